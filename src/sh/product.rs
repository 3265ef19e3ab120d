//! Products and squares of expansions by the sparse triple-product tensor.
//!
//! For each output k the non-zeros are grouped by i,
//!
//!   h_k = Σ_i a_i (Σ_j Γ_ijk b_j),
//!
//! so that a sum stays in registers until its output is done and only the sparse Γ, its partners' indices and the inputs are
//! read. The square has Γ_ijk and Γ_jik in one entry, 2Γ_ijk at i < j. No fused multiply-add: every machine gives the same bits.

use pulp::{Arch, Simd, WithSimd};

use super::gamma::{check_degrees, partners};
use crate::error::check_length;
use crate::{Real, Result};

/// Lanes of a block, at most: four AVX2 registers of `f32`.
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
struct Table<T> {
    /// Where the groups of each output end. Outputs beyond the last are 0.
    outputs: Vec<u32>,
    groups: Vec<Group>,
    entries: Vec<(u16, T)>,
}

impl<T: Real> Table<T> {
    /// `fold` gives the factor of Γ_ijk in entry (i, j), 0 to leave it out.
    fn new(bands: [usize; 3], fold: impl Fn(usize, usize) -> f64) -> Result<Self> {
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

    fn multiplications(&self) -> usize {
        self.entries.len() + self.groups.len()
    }

    /// One product: `write` takes every output and its value.
    #[inline(always)]
    fn each(&self, a: &[T], b: &[T], mut write: impl FnMut(usize, T)) {
        let (mut group, mut entry) = (0, 0);
        for (k, &end) in self.outputs.iter().enumerate() {
            let mut sum = T::zero();
            for g in &self.groups[group..end as usize] {
                let mut inner = T::zero();
                for &(j, value) in &self.entries[entry..g.end as usize] {
                    inner += value * b[usize::from(j)];
                }
                entry = g.end as usize;
                sum += a[usize::from(g.i)] * inner;
            }
            group = end as usize;
            write(k, sum);
        }
    }

    /// The same for a block of `L` vectors: row i of `a` holds coefficient i of each.
    #[inline(always)]
    fn multiply_block<const L: usize>(&self, a: &[[T; L]], b: &[[T; L]], mut write: impl FnMut(usize, &[T; L])) {
        let (mut group, mut entry) = (0, 0);
        for (k, &end) in self.outputs.iter().enumerate() {
            let mut sum = [T::zero(); L];
            for g in &self.groups[group..end as usize] {
                let mut inner = [T::zero(); L];
                for &(j, value) in &self.entries[entry..g.end as usize] {
                    let row = &b[usize::from(j)];
                    for lane in 0..L {
                        inner[lane] += value * row[lane];
                    }
                }
                entry = g.end as usize;
                let row = &a[usize::from(g.i)];
                for lane in 0..L {
                    sum[lane] += row[lane] * inner[lane];
                }
            }
            group = end as usize;
            write(k, &sum);
        }
    }
}

/// Lanes of a block of this scalar.
const fn lanes<T>() -> usize {
    if size_of::<T>() == 4 { LANES_F32 } else { LANES_F64 }
}

/// One vector; run by `pulp` with the instructions that the machine has.
struct One<'a, T> {
    table: &'a Table<T>,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for One<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (reached, beyond) = self.out.split_at_mut(self.table.outputs.len());
        self.table.each(self.a, self.b, |k, value| reached[k] = value);
        beyond.fill(T::zero());
    }
}

/// A batch; `b` is empty for a square.
struct Batch<'a, T, const L: usize> {
    table: &'a Table<T>,
    count: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real, const L: usize> WithSimd for Batch<'_, T, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { table, count, a, b, out, scratch } = self;
        let (rows_a, rows_b) = (a.len() / count, b.len() / count);
        let (blocks, _) = scratch.as_chunks_mut::<L>();
        let (block_a, rest) = blocks.split_at_mut(rows_a);
        let block_b = &mut rest[..rows_b];
        for first in (0..count).step_by(L) {
            let width = L.min(count - first);
            gather(a, count, first, width, block_a);
            gather(b, count, first, width, block_b);
            let second: &[[T; L]] = if rows_b == 0 { block_a } else { block_b };
            table.multiply_block(block_a, second, |k, sum| {
                out[k * count + first..][..width].copy_from_slice(&sum[..width]);
            });
        }
        out[table.outputs.len() * count..].fill(T::zero());
    }
}

/// Columns first..first + width of rows of length `count`; lanes beyond are 0.
#[inline(always)]
fn gather<T: Real, const L: usize>(from: &[T], count: usize, first: usize, width: usize, to: &mut [[T; L]]) {
    for (row, to) in from.chunks_exact(count).zip(to) {
        to[..width].copy_from_slice(&row[first..first + width]);
        to[width..].fill(T::zero());
    }
}

#[inline(always)]
fn run_batch<T: Real>(arch: Arch, table: &Table<T>, count: usize, [a, b]: [&[T]; 2], out: &mut [T], scratch: &mut [T]) {
    if count == 0 {
        return;
    }
    if lanes::<T>() == LANES_F32 {
        arch.dispatch(Batch::<T, LANES_F32> { table, count, a, b, out, scratch });
    } else {
        arch.dispatch(Batch::<T, LANES_F64> { table, count, a, b, out, scratch });
    }
}

/// Panics unless the scratch is long enough.
#[track_caller]
fn check_scratch(needed: usize, got: usize) {
    assert!(got >= needed, "scratch: at least {needed} expected, got {got}");
}

/// Product of two expansions, truncated to any number of bands.
///
///   h_k = Σ_ij a_i b_j Γ_ijk                                                    [Sun 2008, §2.4]
///
/// The plan holds the non-zero Γ; calls do not allocate. With `bands_out` = bands_a + bands_b − 1 nothing is cut off, and the
/// result is the product of the functions; beyond that the coefficients are 0. Truncated products commute but do not
/// associate. To multiply many vectors by one and the same, make a [`matrix`](Self::matrix).
///
/// Shapes: a: bands_a², b: bands_b², out: bands_out², index l(l+1)+m.
/// Accuracy: tested to 3 eps(T) ‖a‖ ‖b‖ + 3e-15 against quadrature below 13 bands, 4e-15 ‖a‖ ‖b‖ at 16 bands in f64. Cost: [`multiplications`](Self::multiplications), Θ(bands⁵)
/// for equal bands. For sizes beyond the plan's limit evaluate on a quadrature grid, multiply and project.
///
/// # Example
/// ```
/// use haarmonic::sh::Product;
/// let product = Product::new(2, 2, 3)?;
/// let (mut out, z) = ([0.0f64; 9], [0.0, 0.0, 1.0, 0.0]);
/// product.apply(&z, &z, &mut out);
/// // y_10² = (3/4π) z²: its mean is in y_00, the rest in y_20.
/// assert!((out[0] - 0.25 * std::f64::consts::FRAC_2_SQRT_PI).abs() < 1e-16);
/// assert!((out[6] - (5.0 * std::f64::consts::PI).sqrt().recip()).abs() < 1e-16);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Product<T> {
    bands: [usize; 3],
    table: Table<T>,
    arch: Arch,
}

impl<T: Real> Product<T> {
    /// Products of `bands_a` by `bands_b` bands to `bands_out`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if one of them is 0, or if the degrees of harmonics that meet add up
    /// to more than 126 (43 bands from 43 and 43, 64 from 32 and 32).
    pub fn new(bands_a: usize, bands_b: usize, bands_out: usize) -> Result<Self> {
        let bands = [bands_a, bands_b, bands_out];
        Ok(Self { bands, table: Table::new(bands, |_, _| 1.0)?, arch: Arch::new() })
    }

    /// The bands of a, b and out.
    #[inline]
    pub fn bands(&self) -> [usize; 3] {
        self.bands
    }

    /// Multiplications of one product: the non-zeros of Γ and one for each pair (i, k) that has some.
    #[inline]
    pub fn multiplications(&self) -> usize {
        self.table.multiplications()
    }

    /// `out` = the product of `a` and `b`.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or `out.len()` is not the square of its bands.
    #[track_caller]
    pub fn apply(&self, a: &[T], b: &[T], out: &mut [T]) {
        self.check_inputs(1, a, b);
        check_length("product", square(self.bands[2]), out.len());
        self.arch.dispatch(One { table: &self.table, a, b, out });
    }

    /// How much scratch [`batch`](Self::batch) wants, at least, whatever the number of vectors.
    #[inline]
    pub fn scratch_len(&self) -> usize {
        (square(self.bands[0]) + square(self.bands[1])) * lanes::<T>()
    }

    /// `count` products at once, coefficient-major: coefficient i of vector v is at i·`count` + v in `a`, `b` and `out`.
    ///
    /// The same bits as [`apply`](Self::apply) vector by vector.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or `out.len()` is not `count` times the square of its bands, or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn batch(&self, count: usize, a: &[T], b: &[T], out: &mut [T], scratch: &mut [T]) {
        self.check_inputs(count, a, b);
        check_length("products", square(self.bands[2]) * count, out.len());
        check_scratch(self.scratch_len(), scratch.len());
        run_batch(self.arch, &self.table, count, [a, b], out, scratch);
    }

    /// The matrix of the product with `a`: row-major, bands_out² rows of bands_b², `matrix` · b = product of a and b.
    ///
    ///   M_kj = Σ_i a_i Γ_ijk;   symmetric if bands_b = bands_out                       [Sun 2008, §2.4]
    ///
    /// # Panics
    /// If `a.len()` is not bands_a² or `matrix.len()` not bands_out² · bands_b².
    #[track_caller]
    pub fn matrix(&self, a: &[T], matrix: &mut [T]) {
        let (rows, columns) = (square(self.bands[2]), square(self.bands[1]));
        check_length("factor a", square(self.bands[0]), a.len());
        check_length("product matrix", rows * columns, matrix.len());
        matrix.fill(T::zero());
        let (mut group, mut entry) = (0, 0);
        for (row, &end) in matrix.chunks_exact_mut(columns).zip(&self.table.outputs) {
            for g in &self.table.groups[group..end as usize] {
                let factor = a[usize::from(g.i)];
                for &(j, value) in &self.table.entries[entry..g.end as usize] {
                    row[usize::from(j)] += factor * value;
                }
                entry = g.end as usize;
            }
            group = end as usize;
        }
    }

    /// ∫ a b c over the sphere, c of bands_out, summed over c in f64.
    ///
    ///   Σ_ijk a_i b_j c_k Γ_ijk
    ///
    /// Cost: a product and a dot product.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or `c.len()` is not the square of its bands.
    #[track_caller]
    pub fn integral(&self, a: &[T], b: &[T], c: &[T]) -> T {
        self.check_inputs(1, a, b);
        check_length("factor c", square(self.bands[2]), c.len());
        self.arch.dispatch(Integral { table: &self.table, a, b, c })
    }

    #[track_caller]
    fn check_inputs(&self, count: usize, a: &[T], b: &[T]) {
        check_length("factor a", square(self.bands[0]) * count, a.len());
        check_length("factor b", square(self.bands[1]) * count, b.len());
    }
}

/// A triple product integral; run by `pulp`.
struct Integral<'a, T> {
    table: &'a Table<T>,
    a: &'a [T],
    b: &'a [T],
    c: &'a [T],
}

impl<T: Real> WithSimd for Integral<'_, T> {
    type Output = T;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> T {
        let mut total = 0.0;
        self.table.each(self.a, self.b, |k, value| total += value.widen() * self.c[k].widen());
        T::of(total)
    }
}

/// Square of an expansion, truncated to any number of bands: [`Product`] with itself at 58 to 70 % of the multiplications (bands 8 to 2).
///
///   h_k = Σ_i a_i (Γ_iik a_i + Σ_{j>i} 2Γ_ijk a_j)
///
/// Shapes: a: bands², out: bands_out², index l(l+1)+m. Accuracy, limits and layout as [`Product`].
///
/// # Example
/// ```
/// use haarmonic::sh::Square;
/// let square = Square::new(1, 1)?;
/// let mut out = [0.0f64];
/// square.apply(&[2.0], &mut out);
/// assert!((out[0] - std::f64::consts::FRAC_2_SQRT_PI).abs() < 1e-15); // 4/√4π
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Square<T> {
    bands: [usize; 2],
    table: Table<T>,
    arch: Arch,
}

impl<T: Real> Square<T> {
    /// Squares of `bands` bands to `bands_out`.
    ///
    /// # Errors
    /// As [`Product::new`] with both factors of `bands`.
    pub fn new(bands: usize, bands_out: usize) -> Result<Self> {
        let fold = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Less => 2.0,
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Greater => 0.0,
        };
        Ok(Self { bands: [bands, bands_out], table: Table::new([bands, bands, bands_out], fold)?, arch: Arch::new() })
    }

    /// The bands of the factor and of the square.
    #[inline]
    pub fn bands(&self) -> [usize; 2] {
        self.bands
    }

    /// Multiplications of one square.
    #[inline]
    pub fn multiplications(&self) -> usize {
        self.table.multiplications()
    }

    /// `out` = the square of `a`.
    ///
    /// # Panics
    /// If `a.len()` or `out.len()` is not the square of its bands.
    #[track_caller]
    pub fn apply(&self, a: &[T], out: &mut [T]) {
        check_length("factor", square(self.bands[0]), a.len());
        check_length("square", square(self.bands[1]), out.len());
        self.arch.dispatch(One { table: &self.table, a, b: a, out });
    }

    /// How much scratch [`batch`](Self::batch) wants, at least.
    #[inline]
    pub fn scratch_len(&self) -> usize {
        square(self.bands[0]) * lanes::<T>()
    }

    /// `count` squares at once, coefficient-major as [`Product::batch`]; the same bits as [`apply`](Self::apply).
    ///
    /// # Panics
    /// If `a.len()` or `out.len()` is not `count` times the square of its bands, or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn batch(&self, count: usize, a: &[T], out: &mut [T], scratch: &mut [T]) {
        check_length("factors", square(self.bands[0]) * count, a.len());
        check_length("squares", square(self.bands[1]) * count, out.len());
        check_scratch(self.scratch_len(), scratch.len());
        run_batch(self.arch, &self.table, count, [a, &[]], out, scratch);
    }
}

#[inline]
fn square(bands: usize) -> usize {
    bands * bands
}
