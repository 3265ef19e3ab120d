//! One rotation, many vectors.

use nalgebra::{Rotation3, UnitQuaternion};
use pulp::Arch;

use super::blocks;
use super::chain::rotate_flat;
use super::single;
use super::sizes::{block_start, check_bands};
use super::swap::Swap;
use super::turns::{
    Flat, Turns, components, entries, matrix_flat, matrix_turns, quaternion_flat, quaternion_turns, tiny,
};
use crate::error::check_length;
use crate::{Error, Real, Result};

/// The matrix of one rotation, a dense block for each degree.
///
/// ```math
/// y(Rω) = M y(ω),  (Rf)(ω) = f(R⁻¹ω) has the coefficients M f               [Sun 2008, eq. 2.11: see docs/errata.md]
/// M(R₁R₂) = M(R₁) M(R₂),  M(R⁻¹) = Mᵀ
/// ```
///
/// Built in `f64` from constant matrices, as [`Rotator`](super::Rotator) says, and then narrowed; what it says of
/// degenerate rotations and of matrices that are not quite orthogonal holds here.
///
/// Shapes: f, out: bands², index l(l+1)+m; batches coefficient-major, coefficient i of vector v at i·count + v.
/// Cost: bands(4 bands² − 1)/3 multiplications a vector, Θ(bands⁴) to build.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::{Rotation3, Vector3}, sh::Rotation};
/// // z goes to x: so does the lobe z.
/// let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
/// let rotation = Rotation::<f64>::new(2, &turn)?;
/// let mut turned = [0.0; 4];
/// rotation.apply(&[0.0, 0.0, 1.0, 0.0], &mut turned);
/// assert!((turned[3] - 1.0).abs() < 1e-15 && turned[2].abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Rotation<T> {
    bands: usize,
    /// Block after block, row-major.
    blocks: Vec<T>,
    /// The same, for batches.
    tiles: Vec<T>,
    run: blocks::Run<T>,
    arch: Arch,
}

impl<T: Real> Rotation<T> {
    /// The plan of a rotation for `bands`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or more than 128; [`Error::NotFinite`] if an entry of the matrix is NaN or
    /// infinite.
    pub fn new(bands: usize, rotation: &Rotation3<f64>) -> Result<Self> {
        check_finite("rotation matrix entry", rotation.matrix().as_slice())?;
        let r = entries(rotation);
        Self::by_columns(bands, matrix_turns(&r.map(|r| [r])), || matrix_flat(&r))
    }

    /// The plan of a rotation that is given as a quaternion.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_quaternion(bands: usize, rotation: &UnitQuaternion<f64>) -> Result<Self> {
        check_finite("quaternion component", rotation.quaternion().coords.as_slice())?;
        let q = components(rotation);
        Self::by_columns(bands, quaternion_turns(&q.map(|q| [q])), || quaternion_flat(q))
    }

    /// Column m' of all blocks at once is the rotated sum of all y_{l,m'}.
    fn by_columns(
        bands: usize,
        (turns, [across]): (Turns<f64, 1>, [f64; 1]),
        flat: impl FnOnce() -> Flat<f64>,
    ) -> Result<Self> {
        check_bands(bands)?;
        let table = Swap::<f64>::new(bands);
        let flat = (across < tiny()).then(flat);
        let mut blocks = vec![T::zero(); block_start(bands)];
        let (mut hot, mut column) = (vec![0.0; bands * bands], vec![0.0; bands * bands]);
        let centre = |l: usize| l * (l + 1);
        for order in 0..2 * bands - 1 {
            // m' = order − (bands − 1), in the degrees that have it.
            let place = |l: usize| (l + order).checked_sub(bands - 1).filter(|&j| j < 2 * l + 1);
            hot.fill(0.0);
            (0..bands).filter_map(|l| Some(centre(l) - l + place(l)?)).for_each(|i| hot[i] = 1.0);
            column[0] = hot[0];
            match &flat {
                Some(flat) => rotate_flat(0..bands, flat, &hot, &mut column, [1, 0]),
                None => single::rotate(&table, 1..bands, &turns, &hot, &mut column),
            }
            for l in 0..bands {
                let Some(j) = place(l) else { continue };
                let size = 2 * l + 1;
                let block = &mut blocks[block_start(l)..][..size * size];
                for (row, &value) in block.chunks_exact_mut(size).zip(&column[l * l..]) {
                    row[j] = T::of(value);
                }
            }
        }
        let tiles = blocks::tiles(bands, &blocks);
        Ok(Self { bands, blocks, tiles, run: blocks::choose(), arch: Arch::new() })
    }

    /// The number of bands.
    #[inline]
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The block of degree l, row-major, 2l + 1 rows and columns; m from −l to l.
    ///
    /// # Panics
    /// If `l` is not below `bands`.
    #[track_caller]
    pub fn block(&self, l: usize) -> &[T] {
        assert!(l < self.bands, "degree: below {} expected, got {l}", self.bands);
        &self.blocks[block_start(l)..block_start(l + 1)]
    }

    /// The plan of R⁻¹: every block transposed.
    pub fn inverse(&self) -> Self {
        let mut blocks = Vec::with_capacity(self.blocks.len());
        for l in 0..self.bands {
            let (block, size) = (self.block(l), 2 * l + 1);
            blocks.extend((0..size * size).map(|k| block[k % size * size + k / size]));
        }
        let tiles = blocks::tiles(self.bands, &blocks);
        Self { bands: self.bands, blocks, tiles, run: self.run, arch: self.arch }
    }

    /// `out` = `f` rotated.
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply(&self, f: &[T], out: &mut [T]) {
        check_length("coefficients", self.bands * self.bands, f.len());
        check_length("rotated coefficients", self.bands * self.bands, out.len());
        for l in 0..self.bands {
            let size = 2 * l + 1;
            let (f, out) = (&f[l * l..][..size], &mut out[l * l..][..size]);
            for (row, out) in self.block(l).chunks_exact(size).zip(out) {
                *out = dot(row, f.iter());
            }
        }
    }

    /// `count` expansions rotated: the same bits as [`apply`](Self::apply) one by one.
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not `count` · bands².
    #[track_caller]
    pub fn apply_batch(&self, count: usize, f: &[T], out: &mut [T]) {
        check_length("coefficients", (self.bands * self.bands).saturating_mul(count), f.len());
        check_length("rotated coefficients", (self.bands * self.bands).saturating_mul(count), out.len());
        if count < blocks::least::<T>() {
            (0..count).for_each(|v| self.one([count, v], f, out));
        } else {
            (self.run)(self.arch, (self.bands, &self.tiles), count, f, out);
        }
    }

    /// Vector v of `count`.
    fn one(&self, [count, v]: [usize; 2], f: &[T], out: &mut [T]) {
        for l in 0..self.bands {
            let size = 2 * l + 1;
            let f = f[l * l * count..].iter().skip(v).step_by(count);
            for (row, i) in self.block(l).chunks_exact(size).zip(l * l..) {
                out[i * count + v] = dot(row, f.clone());
            }
        }
    }
}

/// Σ m f, from the first term on.
#[inline(always)]
fn dot<'a, T: Real>(row: &[T], mut f: impl Iterator<Item = &'a T>) -> T {
    let first = row[0] * *f.next().expect("a coefficient");
    row[1..].iter().zip(f).fold(first, |sum, (&m, &f)| sum + m * f)
}

fn check_finite(what: &'static str, values: &[f64]) -> Result<()> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}
