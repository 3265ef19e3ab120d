//! One rotation, many vectors.

use nalgebra::{Rotation3, UnitQuaternion};
use pulp::{Arch, Simd, WithSimd};

use super::rotator::Rotator;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// The largest `bands` of a rotation.
pub(super) const MAX_BANDS: usize = 128;

pub(super) fn check_bands(bands: usize) -> Result<()> {
    if bands == 0 || bands > MAX_BANDS {
        return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to 128" });
    }
    Ok(())
}

/// The matrix of one rotation, a dense block for each degree.
///
///   y(Rω) = M y(ω),  (Rf)(ω) = f(R⁻¹ω) has the coefficients M f                  [Sun 2008, eq. 2.11: see docs/errata.md]
///   M(R₁R₂) = M(R₁) M(R₂),  M(R⁻¹) = Mᵀ
///
/// Built in `f64` from constant matrices, as [`Rotator`] says, and then narrowed; what it says of degenerate rotations and of matrices
/// that are not quite orthogonal holds here.
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
    arch: Arch,
}

/// Entries before block l: Σ (2k+1)² for k < l.
#[inline(always)]
const fn block_start(l: usize) -> usize {
    l * (4 * l * l - (l > 0) as usize) / 3
}

impl<T: Real> Rotation<T> {
    /// The plan of a rotation for `bands`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is 0 or more than 128; [`Error::NotFinite`] if an entry of the matrix is NaN or infinite.
    pub fn new(bands: usize, rotation: &Rotation3<f64>) -> Result<Self> {
        check_finite("rotation matrix entry", rotation.matrix().as_slice())?;
        Self::by_columns(bands, |rotator, f, out| rotator.apply(rotation, f, out))
    }

    /// The plan of a rotation that is given as a quaternion.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_quaternion(bands: usize, rotation: &UnitQuaternion<f64>) -> Result<Self> {
        check_finite("quaternion component", rotation.quaternion().coords.as_slice())?;
        Self::by_columns(bands, |rotator, f, out| rotator.apply_quaternion(rotation, f, out))
    }

    /// Column m' of all blocks at once is the rotated sum of all y_{l,m'}.
    fn by_columns(bands: usize, rotate: impl Fn(&Rotator<f64>, &[f64], &mut [f64])) -> Result<Self> {
        let rotator = Rotator::<f64>::new(bands)?;
        let mut blocks = vec![T::zero(); block_start(bands)];
        let (mut hot, mut column) = (vec![0.0; bands * bands], vec![0.0; bands * bands]);
        let centre = |l: usize| l * (l + 1);
        for order in 0..2 * bands - 1 {
            // m' = order − (bands − 1), in the degrees that have it.
            let place = |l: usize| (l + order).checked_sub(bands - 1).filter(|&j| j < 2 * l + 1);
            hot.fill(0.0);
            (0..bands).filter_map(|l| Some(centre(l) - l + place(l)?)).for_each(|i| hot[i] = 1.0);
            rotate(&rotator, &hot, &mut column);
            for l in 0..bands {
                let Some(j) = place(l) else { continue };
                let size = 2 * l + 1;
                let block = &mut blocks[block_start(l)..][..size * size];
                for (row, &value) in block.chunks_exact_mut(size).zip(&column[l * l..]) {
                    row[j] = T::of(value);
                }
            }
        }
        Ok(Self { bands, blocks, arch: Arch::new() })
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
        Self { bands: self.bands, blocks, arch: self.arch }
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
    pub fn batch(&self, count: usize, f: &[T], out: &mut [T]) {
        check_length("coefficients", self.bands * self.bands * count, f.len());
        check_length("rotated coefficients", self.bands * self.bands * count, out.len());
        if count < lanes::<T>() {
            (0..count).for_each(|v| self.one([count, v], f, out));
        } else {
            self.arch.dispatch(Batch { rotation: self, count, f, out });
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

/// Vectors of a block: two AVX2 registers.
const fn lanes<T>() -> usize {
    if size_of::<T>() == 4 { 16 } else { 8 }
}

fn check_finite(what: &'static str, values: &[f64]) -> Result<()> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// A batch; run by `pulp` with the instructions that the machine has.
struct Batch<'a, T> {
    rotation: &'a Rotation<T>,
    count: usize,
    f: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for Batch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if size_of::<T>() == 4 { self.run::<8>() } else { self.run::<4>() }
    }
}

impl<T: Real> Batch<'_, T> {
    /// Degree by degree; the last block of vectors has 2W as well, some for the second time.
    #[inline(always)]
    fn run<const W: usize>(self) {
        let Self { rotation, count, f, out } = self;
        macro_rules! degrees {
            ($($l:literal: $($rows:literal)*;)*) => {$(
                if rotation.bands > $l {
                    const N: usize = 2 * $l + 1;
                    let rows = $l * $l * count..($l + 1) * ($l + 1) * count;
                    let mut low = Low::<T, N>::new(&f[rows.clone()], &mut out[rows], count);
                    let block = &rotation.blocks[block_start($l)..][..N * N];
                    for at in (0..count).step_by(2 * W) {
                        let first = at.min(count - 2 * W);
                        let vectors = low.load::<W>(first);
                        let mut row = 0;
                        $(
                            low.multiply::<W, $rows>(&block[row * N..][..$rows * N], &vectors, [row, first]);
                            #[allow(unused_assignments, reason = "the last one's")]
                            {
                                row += $rows;
                            }
                        )*
                    }
                }
            )*};
        }
        degrees!(0: 1; 1: 3; 2: 5; 3: 4 3; 4: 5 4; 5: 4 4 3;);
        if rotation.bands > 6 {
            let local = &mut [[[T::zero(); W]; 2]; 2 * MAX_BANDS];
            let mut io = Io { f, out, count, first: 0, local };
            for at in (0..count).step_by(2 * W) {
                io.first = at.min(count - 2 * W);
                for l in 6..rotation.bands {
                    rotation.degree(l, &mut io);
                }
            }
        }
    }
}

/// The N rows of a degree, in and out: a row known by its slice is checked once.
struct Low<'a, T, const N: usize> {
    f: [&'a [T]; N],
    out: [&'a mut [T]; N],
}

impl<'a, T: Real, const N: usize> Low<'a, T, N> {
    #[inline(always)]
    fn new(f: &'a [T], out: &'a mut [T], count: usize) -> Self {
        let (mut f, mut out) = (f.chunks_exact(count), out.chunks_exact_mut(count));
        Self {
            f: std::array::from_fn(|_| f.next().expect("N rows")),
            out: std::array::from_fn(|_| out.next().expect("N rows")),
        }
    }

    #[inline(always)]
    fn load<const W: usize>(&self, first: usize) -> [[[T; W]; 2]; N] {
        let mut vectors = [[[T::zero(); W]; 2]; N];
        for j in 0..N {
            let (halves, _) = self.f[j][first..][..2 * W].as_chunks::<W>();
            vectors[j] = [halves[0], halves[1]];
        }
        vectors
    }

    /// R rows of a block, from `row` on, times the vectors.
    #[inline(always)]
    fn multiply<const W: usize, const R: usize>(
        &mut self,
        block: &[T],
        vectors: &[[[T; W]; 2]; N],
        [row, first]: [usize; 2],
    ) {
        let mut sums = [[[T::zero(); W]; 2]; R];
        for j in 0..N {
            for r in 0..R {
                add(j == 0, &mut sums[r], block[r * N + j], &vectors[j]);
            }
        }
        for r in 0..R {
            self.out[row + r][first..][..2 * W].copy_from_slice(sums[r].as_flattened());
        }
    }
}

/// Vectors first..first + 2W of `count`, in and out.
struct Io<'a, T, const W: usize> {
    f: &'a [T],
    out: &'a mut [T],
    count: usize,
    first: usize,
    local: &'a mut [[[T; W]; 2]],
}

impl<T: Real, const W: usize> Io<'_, T, W> {
    #[inline(always)]
    fn load(&self, row: usize) -> [[T; W]; 2] {
        let (halves, _) = self.f[row * self.count + self.first..][..2 * W].as_chunks::<W>();
        [halves[0], halves[1]]
    }

    /// R rows of a block, from `row` on, times `size` vectors.
    #[inline(always)]
    fn multiply_any<const R: usize>(&mut self, block: &[T], size: usize, row: usize) {
        let rows: [&[T]; R] = std::array::from_fn(|r| &block[r * size..][..size]);
        let mut sums = [[[T::zero(); W]; 2]; R];
        let (head, tail) = self.local[..size].split_first().expect("a vector");
        for r in 0..R {
            add(true, &mut sums[r], rows[r][0], head);
        }
        for (j, vectors) in (1..).zip(tail) {
            for r in 0..R {
                add(false, &mut sums[r], rows[r][j], vectors);
            }
        }
        self.store(row, &sums);
    }

    #[inline(always)]
    fn store<const R: usize>(&mut self, row: usize, sums: &[[[T; W]; 2]; R]) {
        for (r, sums) in sums.iter().enumerate() {
            self.out[(row + r) * self.count + self.first..][..2 * W].copy_from_slice(sums.as_flattened());
        }
    }
}

/// Adds a term, or sets the first one.
#[inline(always)]
fn add<T: Real, const W: usize>(first: bool, sum: &mut [[T; W]; 2], entry: T, vectors: &[[T; W]; 2]) {
    for h in 0..2 {
        for i in 0..W {
            let term = entry * vectors[h][i];
            sum[h][i] = if first { term } else { sum[h][i] + term };
        }
    }
}

impl<T: Real> Rotation<T> {
    #[inline(always)]
    fn degree<const W: usize>(&self, l: usize, io: &mut Io<'_, T, W>) {
        let size = 2 * l + 1;
        for j in 0..size {
            io.local[j] = io.load(l * l + j);
        }
        let block = &self.blocks[block_start(l)..block_start(l + 1)];
        // As even as can be.
        let tiles = size.div_ceil(5);
        let mut row = 0;
        for tile in 0..tiles {
            let rows = (size - row).div_ceil(tiles - tile);
            let block = &block[row * size..];
            match rows {
                3 => io.multiply_any::<3>(block, size, l * l + row),
                4 => io.multiply_any::<4>(block, size, l * l + row),
                _ => io.multiply_any::<5>(block, size, l * l + row),
            }
            row += rows;
        }
    }
}
