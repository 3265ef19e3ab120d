//! Products by the sparse triple-product tensor, for any numbers of bands.
//!
//! For each output k the non-zeros are grouped by i,
//!
//! ```math
//! h_k = Σ_i a_i (Σ_j Γ_ijk b_j),
//! ```
//!
//! so that a sum stays in registers until its output is done and only the sparse Γ, its partners' indices and the
//! inputs are read. The square has Γ_ijk and Γ_jik in one entry, 2Γ_ijk at i < j. No fused multiply-add: every machine
//! gives the same bits.

use pulp::{Arch, Simd, WithSimd};

use crate::sh::gamma::{check_degrees, partners};
use crate::{Real, Result};

/// Lanes of a block: four AVX2 registers of `f32`.
const LANES_F32: usize = 32;
/// The same four registers of `f64`.
const LANES_F64: usize = 16;

/// Entries of one (k, i): the index i and where its entries end.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Group {
    i: u16,
    end: u32,
}

/// The tensor grouped by output k, then i, then j.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table<T> {
    /// Where the groups of each output end. Outputs beyond the last are 0.
    outputs: Vec<u32>,
    groups: Vec<Group>,
    entries: Vec<(u16, T)>,
}

impl<T: Real> Table<T> {
    /// `fold` gives the factor of Γ_ijk in entry (i, j), 0 to leave it out.
    pub fn new(bands: [usize; 3], fold: impl Fn(usize, usize) -> f64) -> Result<Self> {
        let [bands_a, bands_b, bands_out] = check_degrees(bands)?;
        let mut table = Self { outputs: Vec::new(), groups: Vec::new(), entries: Vec::new() };
        for k in 0..bands_out * bands_out {
            for i in 0..bands_a * bands_a {
                let before = table.entries.len();
                partners(i, k, bands_b, |j, gamma| {
                    let value = gamma * fold(i, j);
                    if value != 0.0 {
                        table.entries.push((j as u16, T::of(value)));
                    }
                });
                if table.entries.len() > before {
                    table.groups.push(Group { i: i as u16, end: table.entries.len() as u32 });
                }
            }
            table.outputs.push(table.groups.len() as u32);
        }
        Ok(table)
    }

    pub fn multiplications(&self) -> usize {
        self.entries.len() + self.groups.len()
    }

    /// Calls with the outputs' numbers and their groups: (i, entries).
    #[inline(always)]
    fn walk(&self, mut output: impl FnMut(usize, &[Group], usize)) {
        let mut group = 0;
        for (k, &end) in self.outputs.iter().enumerate() {
            let first_entry = if group == 0 { 0 } else { self.groups[group - 1].end as usize };
            output(k, &self.groups[group..end as usize], first_entry);
            group = end as usize;
        }
    }

    /// `count` vectors; the lengths have been checked.
    pub fn run(&self, arch: Arch, count: usize, [a, b]: [&[T]; 2], out: &mut [T]) {
        if size_of::<T>() == 4 {
            arch.dispatch(Call::<T, LANES_F32> { table: self, count, a, b, out });
        } else {
            arch.dispatch(Call::<T, LANES_F64> { table: self, count, a, b, out });
        }
    }
}

/// One call, run by `pulp` with the instructions that the machine has.
struct Call<'a, T, const L: usize> {
    table: &'a Table<T>,
    count: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

impl<T: Real, const L: usize> WithSimd for Call<'_, T, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        let count = self.count;
        self.out[self.table.outputs.len() * count..].fill(T::zero());
        if count < L {
            (0..count).for_each(|v| self.single(v));
        } else {
            for first in (0..count).step_by(L) {
                // The last block overlaps the one before rather than be narrower.
                self.block(first.min(count - L));
            }
        }
    }
}

impl<T: Real, const L: usize> Call<'_, T, L> {
    /// Vector `v`.
    #[inline(always)]
    fn single(&mut self, v: usize) {
        let Self { table, count, a, b, ref mut out } = *self;
        table.walk(|k, groups, mut entry| {
            let mut sum = T::zero();
            for g in groups {
                let mut inner = T::zero();
                for &(j, value) in &table.entries[entry..g.end as usize] {
                    inner += value * b[usize::from(j) * count + v];
                }
                entry = g.end as usize;
                sum += a[usize::from(g.i) * count + v] * inner;
            }
            out[k * count + v] = sum;
        });
    }

    /// `L` vectors from `first` on.
    #[inline(always)]
    fn block(&mut self, first: usize) {
        let Self { table, count, a, b, ref mut out } = *self;
        table.walk(|k, groups, mut entry| {
            let mut sum = [T::zero(); L];
            for g in groups {
                let mut inner = [T::zero(); L];
                for &(j, value) in &table.entries[entry..g.end as usize] {
                    let row = &b[usize::from(j) * count + first..][..L];
                    for lane in 0..L {
                        inner[lane] += value * row[lane];
                    }
                }
                entry = g.end as usize;
                let row = &a[usize::from(g.i) * count + first..][..L];
                for lane in 0..L {
                    sum[lane] += row[lane] * inner[lane];
                }
            }
            out[k * count + first..][..L].copy_from_slice(&sum);
        });
    }
}
