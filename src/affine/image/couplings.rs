//! The sparse operator of one axis: what each function of the source has in common with those of the target.

use super::kernel::Kernel;
use crate::Real;
use crate::affine::steps::{Steps, row_room};
use crate::affine::{AffineMap, Atom};

/// Row by row of the source, the couplings with functions of the target, by ascending index; rows of functions that do
/// not occur are empty.
#[derive(Debug, Clone)]
pub(super) struct Couplings<T> {
    /// Row i is entries start[i]..start[i + 1].
    start: Vec<u32>,
    index: Vec<u32>,
    value: Vec<T>,
    row: Vec<f64>,
    met: Vec<u32>,
}

impl<T: Real> Couplings<T> {
    pub(super) fn new() -> Self {
        Self { start: Vec::new(), index: Vec::new(), value: Vec::new(), row: Vec::new(), met: Vec::new() }
    }

    /// D_ik(s, o) of the functions that occur, with a target of `levels` levels.
    pub(super) fn set_map(&mut self, occurs: &[bool], levels: u32, map: AffineMap) {
        let room = row_room(levels);
        let mut filled = 0;
        self.start.clear();
        self.start.push(0);
        for (i, &occurs) in occurs.iter().enumerate() {
            if occurs {
                if self.value.len() < filled + room {
                    self.index.resize(2 * (filled + room), 0);
                    self.value.resize(2 * (filled + room), T::zero());
                }
                let steps = Steps::of_source(Atom::from_flat(i), map);
                filled += steps.write_basis(levels, &mut self.index[filled..], &mut self.value[filled..]);
            }
            self.start.push(filled as u32);
        }
    }

    /// Σ_m t_m D_ik(1, −m/N) of the functions that occur: a convolution with the taps t_m.
    ///
    /// Sums are in f64, and what cancels but for rounding is left out.
    pub(super) fn set_kernel(&mut self, occurs: &[bool], kernel: &Kernel) {
        let (size, levels) = (occurs.len(), occurs.len().ilog2());
        let mut index = vec![0; row_room(levels)];
        let mut value = vec![0.0; row_room(levels)];
        self.start.clear();
        self.index.clear();
        self.value.clear();
        self.start.push(0);
        self.row.clear();
        self.row.resize(size, 0.0);
        let largest = kernel.taps().iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        for (i, &occurs) in occurs.iter().enumerate() {
            if occurs {
                for (pixels, tap) in kernel.iter() {
                    // Beyond its own width a signal has left the interval.
                    if tap == 0.0 || pixels.unsigned_abs() >= size as u64 {
                        continue;
                    }
                    let map = AffineMap::new(1.0, -(pixels as f64) / size as f64).expect("at most one width");
                    let steps = Steps::of_source(Atom::from_flat(i), map);
                    let len = steps.write_basis(levels, &mut index, &mut value);
                    for (&k, &d) in index[..len].iter().zip(&value) {
                        self.row[k as usize] += tap * d;
                        self.met.push(k);
                    }
                }
                self.met.sort_unstable();
                self.met.dedup();
                for &k in &self.met {
                    let sum = std::mem::take(&mut self.row[k as usize]);
                    // A coupling is at most 1, and as many taps are added as there are.
                    if sum.abs() > 4.0 * f64::EPSILON * largest * kernel.taps().len() as f64 {
                        self.index.push(k);
                        self.value.push(T::of(sum));
                    }
                }
                self.met.clear();
            }
            self.start.push(self.value.len() as u32);
        }
    }

    /// The couplings of function i.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> (&[u32], &[T]) {
        let range = self.start[i] as usize..self.start[i + 1] as usize;
        (&self.index[range.clone()], &self.value[range])
    }

    /// How many couplings function i has.
    #[inline(always)]
    pub(super) fn count(&self, i: usize) -> usize {
        (self.start[i + 1] - self.start[i]) as usize
    }
}
