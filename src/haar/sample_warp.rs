//! Hierarchical sample warping: uniform numbers become samples of a density that is given in Haar wavelets.
//!
//! A density is halved again and again. At each node a uniform number chooses a half in proportion to the half's mean,
//! and what is left of the number, stretched to [0, 1), chooses on: neighbours stay neighbours, so that stratified
//! numbers give stratified samples. Negative means, which truncated wavelets have, count as 0.

use super::Decomposition;
use super::pyramid::Pyramid;
use super::wavelet_tree::BinaryTree;
use crate::{Error, Real, Result};

/// The largest number below 1: where rounding would make a uniform number 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Uniform numbers to samples of a density on [0, 1) that is proportional to a 1D signal.
///
/// ```math
/// p(first half of a node) = max(m + d, 0)/(max(m + d, 0) + max(m − d, 0)),  m its mean, d its detail · 2^{l/2}
/// ```
///
/// Where both halves are 0 or below, either is as likely. Shapes: coefficients in the order of
/// [`Index1d`](super::Index1d). Cost: log₂ n steps a sample.
///
/// # Example
/// ```
/// use haarmonic::haar::{SampleWarp1d, forward_1d};
/// let warp = SampleWarp1d::new(&forward_1d(&[1.0, 3.0])?)?;
/// assert_eq!(warp.sample(0.125), (0.25, 0.5)); // a quarter of the numbers goes to the first half
/// assert_eq!(warp.sample(0.25), (0.5, 1.5));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SampleWarp1d {
    /// [node]: the share of the first half, nodes numbered as details are: 1, then 2 and 3, ….
    shares: Vec<f64>,
}

impl SampleWarp1d {
    /// The warp of a signal's coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless their number is one, [`Error::NotFinite`] for NaN and infinity.
    pub fn new<T: Real>(coefs: &[T]) -> Result<Self> {
        check(coefs, coefs.len(), "coefficients")?;
        let mut warp = Self { shares: vec![0.5; coefs.len()] };
        warp.set_shares(coefs.iter().map(|c| c.widen()));
        Ok(warp)
    }

    /// The shares of a signal with as many coefficients.
    fn set_shares(&mut self, coefs: impl Iterator<Item = f64>) {
        // A node's mean lies where its share will, until its children have theirs.
        let size = self.size();
        for (node, coef) in coefs.enumerate() {
            if node == 0 {
                if size > 1 {
                    self.shares[1] = coef;
                }
                continue;
            }
            let (mean, detail) = (self.shares[node], coef * scale(node));
            let [first, second] = [mean + detail, mean - detail];
            self.shares[node] = share(first, second);
            if 2 * node < size {
                (self.shares[2 * node], self.shares[2 * node + 1]) = (first, second);
            }
        }
    }

    /// The number of cells of the signal.
    pub fn size(&self) -> usize {
        self.shares.len()
    }

    /// The sample of a uniform number in [0, 1), and the density there. Within a cell the density is constant.
    pub fn sample(&self, uniform: f64) -> (f64, f64) {
        let (mut node, mut density, mut u) = (1, 1.0, uniform);
        while node < self.size() {
            let (second, factor) = split(self.shares[node], &mut u);
            (node, density) = (2 * node + usize::from(second), density * factor);
        }
        (cell_to_unit(node - self.size(), u, self.size()), density)
    }

    /// The density at a place in [0, 1), 0 elsewhere.
    pub fn density(&self, x: f64) -> f64 {
        if !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        let cell = ((x * self.size() as f64) as usize).min(self.size() - 1);
        // From the root down, as samples go: the same bits.
        let (leaf, levels) = (self.size() + cell, self.size().ilog2());
        let factor = |down: u32| factor(self.shares[leaf >> (down + 1)], leaf >> down & 1 == 1);
        (0..levels).rev().map(factor).product()
    }
}

/// Pairs of uniform numbers to samples of a density on [0, 1)² that is proportional to an image.
///
/// Under the nonstandard decomposition each square chooses between its upper and lower half, then between left and
/// right [Clarberg 2005]; under the standard one y is chosen first, by the marginal density, then x given y
/// [Sun 2008, §4.6]. Both have the image's density exactly if no pixel is negative.
///
/// Shapes: coefficients as [`Transform2d`](super::Transform2d) orders them. Cost of a sample: log₂ side steps
/// (nonstandard), log₂ width · log₂ height products (standard).
///
/// # Example
/// ```
/// use haarmonic::haar::{Decomposition, SampleWarp2d, forward_2d};
/// let coefs = forward_2d(&[0.0, 0.0, 0.0, 1.0], 2, 2, Decomposition::Nonstandard)?;
/// let warp = SampleWarp2d::new(&coefs, 2, 2, Decomposition::Nonstandard)?;
/// assert_eq!(warp.sample([0.0, 0.5]), ([0.5, 0.75], 4.0));
/// assert_eq!(warp.density([0.2, 0.2]), 0.0);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SampleWarp2d {
    width: usize,
    height: usize,
    form: Form,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    /// Means of the quadtree.
    Nonstandard(Pyramid<f64>),
    /// Coefficients, row after row, and the marginal density in y.
    Standard(Vec<f64>, SampleWarp1d),
}

impl SampleWarp2d {
    /// The warp of an image's coefficients, truncated ones with zeros in between.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless both sides are, [`Error::Length`] unless there are width · height coefficients
    /// and, under the nonstandard decomposition, the sides agree; [`Error::NotFinite`] for NaN and infinity,
    /// [`Error::OutOfRange`] above [`Pyramid::MAX_SIZE`].
    pub fn new<T: Real>(coefs: &[T], width: usize, height: usize, decomposition: Decomposition) -> Result<Self> {
        for side in [width, height] {
            if !side.is_power_of_two() {
                return Err(Error::NotPowerOfTwo { what: "side of an image", got: side });
            }
            if side > Pyramid::<f64>::MAX_SIZE {
                let got = side as f64;
                return Err(Error::OutOfRange { what: "side of an image", got, allowed: "at most 32768" });
            }
        }
        check(coefs, width * height, "coefficients of an image")?;
        let wide: Vec<f64> = coefs.iter().map(|c| c.widen()).collect();
        let form = match decomposition {
            Decomposition::Nonstandard if width != height => {
                return Err(Error::Length { what: "height of a square image", expected: width, got: height });
            }
            Decomposition::Nonstandard => Form::Nonstandard(Pyramid::from_coefficients(width, &wide)?),
            Decomposition::Standard => {
                let marginal: Vec<f64> = wide.iter().step_by(width).copied().collect();
                let marginal = SampleWarp1d::new(&marginal)?;
                Form::Standard(wide, marginal)
            }
        };
        Ok(Self { width, height, form })
    }

    /// Becomes the warp of another image of the same size and decomposition, with the bits of a [`new`](Self::new) one.
    ///
    /// Nothing is allocated under the standard decomposition: this is for a renderer that has a density a point.
    ///
    /// # Errors
    /// [`Error::Length`] for another number of coefficients, [`Error::NotFinite`] for NaN and infinity; the warp then
    /// stays what it is.
    ///
    /// # Example
    /// ```
    /// use haarmonic::haar::{Decomposition::Standard, SampleWarp2d, forward_2d};
    /// let mut warp = SampleWarp2d::new(&[1.0, 0.0, 0.0, 0.0], 2, 2, Standard)?;
    /// assert_eq!(warp.density([0.9, 0.9]), 1.0);
    /// warp.set(&forward_2d(&[1.0, 1.0, 1.0, 5.0], 2, 2, Standard)?)?;
    /// assert_eq!(warp.density([0.9, 0.9]), 2.5);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn set<T: Real>(&mut self, coefs: &[T]) -> Result<()> {
        check(coefs, self.width * self.height, "coefficients of an image")?;
        match &mut self.form {
            Form::Nonstandard(_) => *self = Self::new(coefs, self.width, self.height, Decomposition::Nonstandard)?,
            Form::Standard(wide, marginal) => {
                wide.iter_mut().zip(coefs).for_each(|(wide, c)| *wide = c.widen());
                marginal.set_shares(wide.iter().step_by(self.width).copied());
            }
        }
        Ok(())
    }

    /// The sample [x, y] of two uniform numbers in [0, 1), and the density there. Within a pixel it is constant.
    pub fn sample(&self, uniform: [f64; 2]) -> ([f64; 2], f64) {
        match &self.form {
            Form::Nonstandard(pyramid) => {
                let ([mut u, mut v], mut density) = (uniform, 1.0);
                let (mut x, mut y) = (0, 0);
                for level in 1..=pyramid.finest() {
                    let children = children(pyramid, level, x, y);
                    let (lower, factor_y) = split(share_of_rows(&children), &mut v);
                    let (right, factor_x) = split(share_of_row(&children, lower), &mut u);
                    (x, y) = (2 * x + usize::from(right), 2 * y + usize::from(lower));
                    density *= factor_x * factor_y;
                }
                ([cell_to_unit(x, u, self.width), cell_to_unit(y, v, self.height)], density)
            }
            Form::Standard(coefs, marginal) => {
                let (y, mut density) = marginal.sample(uniform[1]);
                let row = self.row_of(y);
                let (mut node, mut u, mut mean) = (1, uniform[0], self.row_coefficient(coefs, row, 0));
                while node < self.width {
                    let detail = self.row_coefficient(coefs, row, node) * scale(node);
                    let (second, factor) = split(share(mean + detail, mean - detail), &mut u);
                    mean += if second { -detail } else { detail };
                    (node, density) = (2 * node + usize::from(second), density * factor);
                }
                ([cell_to_unit(node - self.width, u, self.width), y], density)
            }
        }
    }

    /// The density at [x, y] in [0, 1)², 0 elsewhere.
    pub fn density(&self, [x, y]: [f64; 2]) -> f64 {
        if ![x, y].iter().all(|c| (0.0..1.0).contains(c)) {
            return 0.0;
        }
        let (column, row) = (((x * self.width as f64) as usize).min(self.width - 1), self.row_of(y));
        match &self.form {
            Form::Nonstandard(pyramid) => (1..=pyramid.finest())
                .map(|level| {
                    let down = pyramid.finest() - level;
                    let (x, y) = (column >> down, row >> down);
                    let children = children(pyramid, level, x / 2, y / 2);
                    let lower = y % 2 == 1;
                    factor(share_of_rows(&children), lower) * factor(share_of_row(&children, lower), x % 2 == 1)
                })
                .product(),
            Form::Standard(coefs, marginal) => {
                let (mut density, mut mean) = (marginal.density(y), self.row_coefficient(coefs, row, 0));
                let levels = self.width.ilog2();
                for level in 0..levels {
                    let node = (1 << level) + (column >> (levels - level));
                    let second = column >> (levels - level - 1) & 1 == 1;
                    let detail = self.row_coefficient(coefs, row, node) * scale(node);
                    density *= factor(share(mean + detail, mean - detail), second);
                    mean += if second { -detail } else { detail };
                }
                density
            }
        }
    }

    fn row_of(&self, y: f64) -> usize {
        ((y * self.height as f64) as usize).min(self.height - 1)
    }

    /// Coefficient k_x of the row of pixels `row`: Σ C[k_y][k_x] ψ_{k_y}(y) over the wavelets that do not vanish there.
    fn row_coefficient(&self, coefs: &[f64], row: usize, column: usize) -> f64 {
        let levels = self.height.ilog2();
        let details = (0..levels).map(|level| {
            let node = (1 << level) + (row >> (levels - level));
            let sign = if row >> (levels - level - 1) & 1 == 1 { -1.0 } else { 1.0 };
            sign * scale(node) * coefs[node * self.width + column]
        });
        coefs[column] + details.sum::<f64>()
    }
}

/// The height of wavelet `node`.
fn scale(node: usize) -> f64 {
    BinaryTree::<f64>::amplitude(node.ilog2())
}

fn check<T: Real>(coefs: &[T], expected: usize, what: &'static str) -> Result<()> {
    if coefs.len() != expected {
        return Err(Error::Length { what, expected, got: coefs.len() });
    }
    if !expected.is_power_of_two() {
        return Err(Error::NotPowerOfTwo { what: "length of a signal", got: expected });
    }
    match coefs.iter().position(|c| !c.is_finite()) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// The share of the first of two means; half where both are 0 or below.
fn share(first: f64, second: f64) -> f64 {
    let (first, second) = (first.max(0.0), second.max(0.0));
    // Over the larger, so that neither the sum of huge means nor the quotient of tiny ones leaves the range.
    let largest = first.max(second);
    if largest > 0.0 { (first / largest) / (first / largest + second / largest) } else { 0.5 }
}

/// Chooses the second half or not and stretches what is left of `uniform`; and the factor of the density.
fn split(share: f64, uniform: &mut f64) -> (bool, f64) {
    let second = *uniform >= share;
    let stretched = if second { (*uniform - share) / (1.0 - share) } else { *uniform / share };
    *uniform = stretched.clamp(0.0, BELOW_ONE);
    (second, factor(share, second))
}

/// What a choice multiplies the density with.
fn factor(share: f64, second: bool) -> f64 {
    2.0 * if second { 1.0 - share } else { share }
}

/// The place `within` [0, 1) of a cell, which rounding does not move into the next one.
fn cell_to_unit(cell: usize, within: f64, cells: usize) -> f64 {
    let line = |x: f64| x / cells as f64;
    line(cell as f64 + within).min(line((cell + 1) as f64).next_down())
}

/// The four nodes of `level` below node (x, y) of the level above, none below 0: upper left, upper right, lower left,
/// lower right.
fn children(pyramid: &Pyramid<f64>, level: u32, x: usize, y: usize) -> [f64; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| pyramid.at(level, 2 * x + dx, 2 * y + dy).max(0.0))
}

fn share_of_rows([a, b, c, d]: &[f64; 4]) -> f64 {
    share(0.5 * a + 0.5 * b, 0.5 * c + 0.5 * d)
}

fn share_of_row([a, b, c, d]: &[f64; 4], lower: bool) -> f64 {
    if lower { share(*c, *d) } else { share(*a, *b) }
}
