//! Low-frequency coefficients from a few samples.

use nalgebra::DMatrix;

use super::tables::basis;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// Above this condition number of an axis the positions are refused: `f32` would have no digits left in two dimensions.
const WORST_CONDITION: f64 = 1e3;

/// The l × l lowest DCT coefficients of a block from l × l samples of a function that is band-limited there.
/// ```math
/// Σ_{u,v<l} A_vu c_v(y_j) c_u(x_k) = ρ(x_k, y_j)                   [Inger 2013, eq. 4, with the basis of BlockDct]
/// A = P S Pᵀ,  P = [c_u(x_k)]⁻¹
/// ```
///
/// Positions are in units of pixels: 0 is the centre of the first, −½ the block's edge. The cosines of the print are
/// not a basis, and its samples are singular (docs/errata.md). Choose
///
/// | positions | P | condition of an axis, l = 2, 4 |
/// |---|---|---|
/// | [`centres`](Self::centres), (k + ½)n/l − ½ | √(n/l) · DCT of l samples | 1, always |
/// | [`at`](Self::at) pixels of n = 16: l = 2 {3, 12}, l = 4 {1, 6, 10, 14} | the inverse | 1.09, 1.32 |
///
/// In two dimensions the condition is the square. What the block holds above the l lowest frequencies is aliased; at
/// the centres frequency 2l − u folds onto −u.
///
/// Shapes: samples and coefficients l², row-major, `y·l + x` and `v·l + u`.
/// Accuracy: l·ε·condition of the largest sample's n, about. Cost: 2l³ multiplications.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// let plan = haarmonic::dct::LowProjection::<f64>::centres(16, 2)?;
/// assert_eq!(plan.positions(), [3.5, 11.5]);
/// let mut coefs = [0.0; 4];
/// plan.project(&[1.0, 1.0, 1.0, 1.0], &mut coefs);
/// // The constant 1: side times the mean.
/// assert!(coefs.iter().zip([16.0, 0.0, 0.0, 0.0]).all(|(c, want)| (c - want).abs() < 1e-14));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LowProjection<T> {
    side: usize,
    positions: Vec<f64>,
    condition: f64,
    /// [u][k]
    matrix: Vec<T>,
}

impl<T: Real> LowProjection<T> {
    /// Samples at the centres of l × l sub-blocks, (k + ½)·side/l − ½ on each axis: condition 1. Any side and l ≤ side.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `low` ≤ `side` ≤ 2¹⁶ and `low` ≤ 64.
    pub fn centres(side: usize, low: usize) -> Result<Self> {
        check_sizes(side, low)?;
        let ratio = side as f64 / low as f64;
        let positions = (0..low).map(|k| (k as f64 + 0.5) * ratio - 0.5).collect();
        let matrix = (0..low * low).map(|i| T::of(ratio.sqrt() * basis(low, i / low, i % low))).collect();
        Ok(Self { side, positions, condition: 1.0, matrix })
    }

    /// Samples at any positions, the same on both axes; l is their number.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for sizes as in [`centres`](Self::centres), for a position outside [−½, side − ½], and
    /// where the condition number of an axis exceeds 1000 (coinciding or badly placed positions); [`Error::NotFinite`]
    /// for NaN.
    pub fn at(side: usize, positions: &[f64]) -> Result<Self> {
        let low = positions.len();
        check_sizes(side, low)?;
        for (index, &x) in positions.iter().enumerate() {
            if !x.is_finite() {
                return Err(Error::NotFinite { what: "sample position", index });
            }
            if x < -0.5 || x > side as f64 - 0.5 {
                return Err(Error::OutOfRange { what: "sample position", got: x, allowed: "in [-1/2, side - 1/2]" });
            }
        }
        let n = side as f64;
        let collocation = DMatrix::from_fn(low, low, |k, u| {
            let scale = if u == 0 { 1.0 } else { 2.0 };
            (scale / n).sqrt() * ((2.0 * positions[k] + 1.0) * u as f64 * std::f64::consts::PI / (2.0 * n)).cos()
        });
        let singular = collocation.singular_values();
        let condition = singular.max() / singular.min();
        let allowed = "at most 1000 for the sample positions";
        let refused = Error::OutOfRange { what: "condition number", got: condition, allowed };
        if !(condition <= WORST_CONDITION) {
            return Err(refused);
        }
        let inverse = collocation.try_inverse().ok_or(refused)?;
        let matrix = (0..low * low).map(|i| T::of(inverse[(i / low, i % low)])).collect();
        Ok(Self { side, positions: positions.to_vec(), condition, matrix })
    }

    /// Frequencies and samples of an axis, l.
    #[inline]
    pub fn low(&self) -> usize {
        self.positions.len()
    }

    /// The side of the block.
    #[inline]
    pub fn side(&self) -> usize {
        self.side
    }

    /// Where to sample each axis, in pixels from the centre of the first.
    #[inline]
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// The condition number (2-norm) of one axis; of the whole solve it is the square.
    #[inline]
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// Samples S\[y\]\[x\] at `positions` of any number of blocks → coefficients A\[v\]\[u\].
    ///
    /// # Panics
    /// If `samples.len()` is not a multiple of l², or `coefs.len()` differs from it.
    #[track_caller]
    pub fn project(&self, samples: &[T], coefs: &mut [T]) {
        let each = self.low() * self.low();
        check_length("samples of whole blocks", samples.len() / each * each, samples.len());
        check_length("coefficients", samples.len(), coefs.len());
        match self.low() {
            1 => self.run::<1>(samples, coefs),
            2 => self.run::<2>(samples, coefs),
            4 => self.run::<4>(samples, coefs),
            8 => self.run::<8>(samples, coefs),
            _ => self.run_any(samples, coefs),
        }
    }

    fn run<const N: usize>(&self, samples: &[T], coefs: &mut [T]) {
        let (matrix, _) = self.matrix.as_chunks::<N>();
        let matrix: &[[T; N]; N] = matrix.try_into().expect("the matrix has l rows");
        let (samples, _) = samples.as_chunks::<N>();
        let (coefs, _) = coefs.as_chunks_mut::<N>();
        for (s, a) in samples.chunks_exact(N).zip(coefs.chunks_exact_mut(N)) {
            let mut half = [[T::zero(); N]; N];
            for v in 0..N {
                for y in 0..N {
                    for x in 0..N {
                        half[v][x] += matrix[v][y] * s[y][x];
                    }
                }
            }
            for v in 0..N {
                for u in 0..N {
                    let mut sum = T::zero();
                    for x in 0..N {
                        sum += matrix[u][x] * half[v][x];
                    }
                    a[v][u] = sum;
                }
            }
        }
    }

    fn run_any(&self, samples: &[T], coefs: &mut [T]) {
        let n = self.low();
        let mut half = vec![T::zero(); n];
        for (s, a) in samples.chunks_exact(n * n).zip(coefs.chunks_exact_mut(n * n)) {
            for v in 0..n {
                for x in 0..n {
                    half[x] = (0..n).fold(T::zero(), |sum, y| sum + self.matrix[v * n + y] * s[y * n + x]);
                }
                for u in 0..n {
                    a[v * n + u] = (0..n).fold(T::zero(), |sum, x| sum + self.matrix[u * n + x] * half[x]);
                }
            }
        }
    }
}

fn check_sizes(side: usize, low: usize) -> Result<()> {
    if side == 0 || side > 1 << 16 {
        return Err(Error::OutOfRange { what: "block side", got: side as f64, allowed: "from 1 to 65536" });
    }
    if low == 0 || low > side.min(64) {
        let allowed = "from 1 to the block side and to 64";
        return Err(Error::OutOfRange { what: "frequencies kept on an axis", got: low as f64, allowed });
    }
    Ok(())
}
