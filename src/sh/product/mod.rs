//! Products and squares of expansions.
//!
//! A plan has the form that has the fewest operations for its size; only these were timed, not each form at each size:
//!
//! | form | for | what it does |
//! |---|---|---|
//! | straight lines by the tensor | 2 and 3 equal bands | each unordered pair of coefficients once, equal Γ factored out |
//! | straight lines by quadrature | 4 to 8 equal bands | a convolution in azimuth at each pair of nodes ±z |
//! | sparse table | unequal bands, up to 24 in sum | a product for each non-zero Γ and each pair (i, k) |
//! | grid | all others | the quadrature, in loops |
//!
//! The quadrature is exact: its rule integrates every polynomial in z that occurs. It replaces the sums over (l₁, l₂,
//! l₃) of fixed orders, which grow as the cube of the bands, by sums over nodes, which do not mix degrees. In it zeros
//! of the tensor are zeros up to rounding, and a NaN reaches every coefficient.

mod generated;
mod grid;
mod integral;
mod kernel;
mod matrix;
mod nodes;
mod single;
pub(super) mod straight;
mod table;
mod text;

use std::sync::OnceLock;

use pulp::Arch;

use self::grid::Grid;
use self::kernel::Kernel;
use self::matrix::MatrixTable;
use self::table::Table;
use super::gamma::met;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// The largest sum of the three numbers of bands that meet for which the sparse table is used. Chosen from operation
/// counts of equal bands, not measured for unequal ones.
const MOST_SPARSE: usize = 24;

/// The largest such sum for which a matrix is made from a table: its entries grow as the fifth power.
const MOST_TABULATED: usize = 48;

/// The most bands of anything, though not more than 128 can meet: those of [`Basis`](super::Basis) in `f64`.
const MOST_BANDS: usize = 1024;

/// How a plan multiplies.
#[derive(Debug, Clone)]
enum Form<T> {
    Straight(Kernel<T>),
    Sparse(Table<T>),
    Grid(Grid<T>),
}

impl<T: Real> Form<T> {
    fn new(bands: [usize; 3], square: bool) -> Result<Self> {
        if let Some(&most) = bands.iter().max().filter(|&&n| n > MOST_BANDS) {
            return Err(Error::OutOfRange { what: "bands of a product", got: most as f64, allowed: "1 to 1024" });
        }
        if bands[0] == bands[1]
            && bands[1] == bands[2]
            && let Some(kernel) = Kernel::new(bands[0], square)
        {
            return Ok(Self::Straight(kernel));
        }
        if bands_that_meet(bands)? > MOST_SPARSE {
            return Ok(Self::Grid(Grid::new(bands, square)?));
        }
        let fold = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Less => 2.0,
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Greater => 0.0,
        };
        Ok(Self::Sparse(Table::new(bands, |i, j| if square { fold(i, j) } else { 1.0 })?))
    }

    fn multiplications(&self) -> usize {
        match self {
            Self::Straight(kernel) => kernel.multiplications(),
            Self::Sparse(table) => table.multiplications(),
            Self::Grid(grid) => grid.multiplications(),
        }
    }

    fn run(&self, arch: Arch, count: usize, factors: [&[T]; 2], out: &mut [T]) {
        match self {
            Self::Straight(kernel) => kernel.run(arch, count, factors, out),
            Self::Sparse(table) => table.run(arch, count, factors, out),
            Self::Grid(grid) => grid.run(arch, count, factors, out),
        }
    }
}

/// Product of two expansions, truncated to any number of bands.
///
/// ```math
/// h_k = Σ_ij a_i b_j Γ_ijk                                                    [Sun 2008, §2.4]
/// ```
///
/// With `bands_out` = bands_a + bands_b − 1 nothing is cut off, and the result is the product of the functions; beyond
/// that the coefficients are 0. Truncated products commute but do not associate. To multiply many vectors by one and
/// the same, make a [`matrix`](Self::matrix). Calls do not allocate.
///
/// Equal bands of 2 to 8 have straight-line kernels. Small unequal ones use the sparse tensor: there a zero of Γ is a
/// zero of the result. All others are multiplied on circles of latitude, where the tensor is not needed.
///
/// | bands | 2 | 3 | 4 | 5 | 6 | 7 | 8 |
/// |---|---|---|---|---|---|---|---|
/// | multiplications, product | 13 | 96 | 290 | 704 | 1352 | 2365 | 3156 |
/// | multiplications, square | 9 | 64 | 178 | 420 | 792 | 1370 | 1818 |
///
/// Shapes: a: bands_a², b: bands_b², out: bands_out², index l(l+1)+m.
/// Accuracy: 3 eps(T) ‖a‖ ‖b‖ + 3e-15 against quadrature below 13 bands; 2 eps(T) ‖a‖ ‖b‖ between truncations up to 64
/// bands.
/// Cost: [`multiplications`](Self::multiplications), Θ(bands³) on circles.
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
    form: Form<T>,
    matrix: OnceLock<MatrixTable<T>>,
    arch: Arch,
}

impl<T: Real> Product<T> {
    /// Products of `bands_a` by `bands_b` bands to `bands_out`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if one of them is 0 or more than 128 bands meet: 64 bands can be
    /// multiplied without truncation, or 128 to 128; or if one of them is more than 1024, the most of a
    /// [`Basis`](crate::sh::Basis).
    pub fn new(bands_a: usize, bands_b: usize, bands_out: usize) -> Result<Self> {
        let bands = [bands_a, bands_b, bands_out];
        Ok(Self { bands, form: Form::new(bands, false)?, matrix: OnceLock::new(), arch: Arch::new() })
    }

    /// The bands of a, b and out.
    #[inline]
    pub fn bands(&self) -> [usize; 3] {
        self.bands
    }

    /// Multiplications of one product.
    #[inline]
    pub fn multiplications(&self) -> usize {
        self.form.multiplications()
    }

    /// `out` = the product of `a` and `b`.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or `out.len()` is not the square of its bands.
    #[inline]
    #[track_caller]
    pub fn apply(&self, a: &[T], b: &[T], out: &mut [T]) {
        self.apply_batch(1, a, b, out);
    }

    /// `count` products at once, coefficient-major: coefficient i of vector v is at i·`count` + v in `a`, `b` and
    /// `out`.
    ///
    /// The same bits as [`apply`](Self::apply) vector by vector. Does not allocate.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or `out.len()` is not `count` times the square of its bands.
    #[track_caller]
    pub fn apply_batch(&self, count: usize, a: &[T], b: &[T], out: &mut [T]) {
        check_length("factor a", square(self.bands[0]).saturating_mul(count), a.len());
        check_length("factor b", square(self.bands[1]).saturating_mul(count), b.len());
        check_length("product", square(self.bands[2]).saturating_mul(count), out.len());
        self.form.run(self.arch, count, [a, b], out);
    }

    /// The matrix of the product with `a`: row-major, bands_out² rows of bands_b², `matrix` · b = product of a and b.
    ///
    /// ```math
    /// M_kj = Σ_i a_i Γ_ijk;   symmetric if bands_b = bands_out                       [Sun 2008, §2.4]
    /// ```
    ///
    /// The first call makes a table of the non-zero Γ; the others do not allocate. Where the numbers of bands that meet
    /// add up to more than 48 there is no table: each call allocates and costs bands_b² products.
    ///
    /// # Panics
    /// If `a.len()` is not bands_a² or `matrix.len()` not bands_out² · bands_b².
    #[track_caller]
    pub fn matrix(&self, a: &[T], matrix: &mut [T]) {
        check_length("factor a", square(self.bands[0]), a.len());
        check_length("product matrix", square(self.bands[2]) * square(self.bands[1]), matrix.len());
        match bands_that_meet(self.bands) {
            Ok(0..=MOST_TABULATED) => {
                self.matrix.get_or_init(|| MatrixTable::new(self.bands)).fill(a, matrix);
            }
            _ => self.matrix_by_columns(a, matrix),
        }
    }

    /// Products with every basis function.
    fn matrix_by_columns(&self, a: &[T], matrix: &mut [T]) {
        let (rows, columns) = (square(self.bands[2]), square(self.bands[1]));
        let (mut hot, mut column) = (vec![T::zero(); columns], vec![T::zero(); rows]);
        for j in 0..columns {
            hot[j] = T::one();
            self.apply(a, &hot, &mut column);
            hot[j] = T::zero();
            for (row, value) in matrix.chunks_exact_mut(columns).zip(&column) {
                row[j] = *value;
            }
        }
    }
}

/// Square of an expansion, truncated to any number of bands: [`Product`] with itself in less time.
///
/// ```math
/// h_k = Σ_i a_i (Γ_iik a_i + Σ_{j>i} 2Γ_ijk a_j)
/// ```
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
    form: Form<T>,
    arch: Arch,
}

impl<T: Real> Square<T> {
    /// Squares of `bands` bands to `bands_out`.
    ///
    /// # Errors
    /// As [`Product::new`] with both factors of `bands`.
    pub fn new(bands: usize, bands_out: usize) -> Result<Self> {
        Ok(Self { bands: [bands, bands_out], form: Form::new([bands, bands, bands_out], true)?, arch: Arch::new() })
    }

    /// The bands of the factor and of the square.
    #[inline]
    pub fn bands(&self) -> [usize; 2] {
        self.bands
    }

    /// Multiplications of one square.
    #[inline]
    pub fn multiplications(&self) -> usize {
        self.form.multiplications()
    }

    /// `out` = the square of `a`.
    ///
    /// # Panics
    /// If `a.len()` or `out.len()` is not the square of its bands.
    #[inline]
    #[track_caller]
    pub fn apply(&self, a: &[T], out: &mut [T]) {
        self.apply_batch(1, a, out);
    }

    /// `count` squares at once, coefficient-major as [`Product::apply_batch`]; the same bits as [`apply`](Self::apply).
    ///
    /// # Panics
    /// If `a.len()` or `out.len()` is not `count` times the square of its bands.
    #[track_caller]
    pub fn apply_batch(&self, count: usize, a: &[T], out: &mut [T]) {
        check_length("factor", square(self.bands[0]).saturating_mul(count), a.len());
        check_length("square", square(self.bands[1]).saturating_mul(count), out.len());
        self.form.run(self.arch, count, [a, a], out);
    }
}

/// The sum of the three numbers of bands that meet.
fn bands_that_meet(bands: [usize; 3]) -> Result<usize> {
    Ok(met(bands)?.into_iter().fold(0, usize::saturating_add))
}

#[inline]
fn square(bands: usize) -> usize {
    bands * bands
}
