//! Products of images in the standard basis.
//!
//! The product of two functions of the 1D basis is one function again, scaled:
//!
//! ```math
//! φ ψ_k = ψ_k;  ψ_c ψ_f = ±2^{l_c/2} ψ_f  for f inside of c, + in its first half
//! ψ_k² = 2^{l_k} on the support of ψ_k;  0 else
//! ```
//!
//! and the integral of a signal times 2^{l_k} over the support of ψ_k is its mean there. So a table of a signal's
//! details and of its means over their supports has every integral of the signal times two basis functions in one
//! entry; with two axes, the table of all four combinations does.

use super::{BinaryTree, Decomposition, SparseVector, Transform2d};
use crate::error::check_length;
use crate::{Error, Real, Result};

/// Product of two images given by dense standard coefficients, by way of pixels.
#[derive(Debug, Clone)]
pub struct StandardProduct<T> {
    transform: Transform2d<T>,
}

impl<T: Real> StandardProduct<T> {
    /// A plan for images of `width` × `height`.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless both are.
    pub fn new(width: usize, height: usize) -> Result<Self> {
        Ok(Self { transform: Transform2d::new(width, height, Decomposition::Standard)? })
    }

    /// How many scalars of scratch [`apply`](Self::apply) needs.
    pub fn scratch_len(&self) -> usize {
        self.transform.len() + self.transform.scratch_len()
    }

    /// out = coefficients of f · g.
    ///
    /// Shapes: f, g, out: width · height, index k_y · width + k_x. Accuracy: a few eps times log₂(width · height) times
    /// max|f| max|g|. Cost: three transforms.
    ///
    /// # Panics
    /// If a length is wrong.
    #[track_caller]
    pub fn apply(&self, f: &[T], g: &[T], out: &mut [T], scratch: &mut [T]) {
        let n = self.transform.len();
        check_length("f", n, f.len());
        check_length("g", n, g.len());
        check_length("out", n, out.len());
        check_length("scratch", self.scratch_len(), scratch.len());
        let (pixels, scratch) = scratch.split_at_mut(n);
        self.transform.inverse(f, pixels, scratch);
        self.transform.inverse(g, out, scratch);
        out.iter_mut().zip(pixels).for_each(|(out, pixel)| *out *= *pixel);
        self.transform.forward_in_place(out, scratch);
    }
}

/// ∫ A B C over the unit square of two sparse images and a dense one, all in the standard basis.
///
/// # Example
/// ```
/// use haarmonic::haar::{Decomposition, SparseVector, StandardTripleProduct, forward_2d};
/// let coefs = |pixels: &[f64]| forward_2d(pixels, 4, 2, Decomposition::Standard);
/// let light = SparseVector::from_dense(&coefs(&[1., 2., 0., 0., 3., 4., 0., 0.])?);
/// let lobe = SparseVector::from_dense(&coefs(&[1., 1., 1., 1., 0., 0., 0., 0.])?);
/// let visibility = StandardTripleProduct::new(4, 2, &coefs(&[1., 0., 1., 0., 1., 0., 1., 0.])?)?;
/// assert!((visibility.integral(&light, &lobe) - 1.0 / 8.0).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct StandardTripleProduct<T> {
    width: usize,
    height: usize,
    /// 2 height rows of 2 width: [`Axis`] along each.
    table: Vec<T>,
}

impl<T: Real> StandardTripleProduct<T> {
    /// The table of the dense image.
    ///
    /// Cost: 4 width · height numbers.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless both sides are, [`Error::Length`] unless there are width · height coefficients,
    /// [`Error::OutOfRange`] for sides whose product is above 2³².
    pub fn new(width: usize, height: usize, coefs: &[T]) -> Result<Self> {
        check_sides(width, height)?;
        if coefs.len() != width * height {
            return Err(Error::Length { what: "coefficients of an image", expected: width * height, got: coefs.len() });
        }
        let mut table = vec![T::zero(); 4 * width * height];
        for (row, coefs) in table.chunks_exact_mut(2 * width).zip(coefs.chunks_exact(width)) {
            row[..width].copy_from_slice(coefs);
            means_down(row, width, 1);
        }
        for x in 0..2 * width {
            means_down(&mut table[x..], height, 2 * width);
        }
        Ok(Self { width, height, table })
    }

    /// ∫ A B C.
    ///
    /// Accuracy: summed in f64. Cost: 3 to 10 ns a pair of terms whose supports overlap, and less for the others.
    ///
    /// # Panics
    /// If an image has another number of coefficients.
    #[track_caller]
    pub fn integral(&self, a: &SparseVector<T>, b: &SparseVector<T>) -> f64 {
        check_length("coefficients of the first image", self.width * self.height, a.len());
        check_length("coefficients of the second image", self.width * self.height, b.len());
        let mut sum = 0.0;
        for_each_pair(a, b, self.width, self.height, |weight, x, y| {
            sum += weight * self.table[y * 2 * self.width + x].widen();
        });
        sum
    }
}

/// The coefficients of the product of two sparse images in the standard basis.
///
/// Cost: all pairs of terms, and 4 width · height numbers. Coefficients that vanish only in exact arithmetic may remain
/// as rounding errors.
///
/// # Errors
/// [`Error::Length`] unless both have width · height coefficients, [`Error::NotPowerOfTwo`] unless both sides are,
/// [`Error::OutOfRange`] for sides whose product is above 2³².
pub fn multiply_sparse_standard<T: Real>(
    f: &SparseVector<T>,
    g: &SparseVector<T>,
    width: usize,
    height: usize,
) -> Result<SparseVector<T>> {
    check_sides(width, height)?;
    for (what, got) in [("coefficients of the first factor", f.len()), ("coefficients of the second factor", g.len())] {
        if got != width * height {
            return Err(Error::Length { what, expected: width * height, got });
        }
    }
    // What an entry of the table is multiplied by in ∫ f g C: the product's coefficients are the derivative in those
    // of C, the table's construction turned round.
    let mut table = vec![0.0; 4 * width * height];
    for_each_pair(f, g, width, height, |weight, x, y| table[y * 2 * width + x] += weight);
    for x in 0..2 * width {
        means_up(&mut table[x..], height, 2 * width);
    }
    let mut out = Vec::with_capacity(width * height);
    for row in table.chunks_exact_mut(2 * width).take(height) {
        means_up(row, width, 1);
        out.extend(row[..width].iter().map(|&c| T::of(c)));
    }
    Ok(SparseVector::from_dense(&out))
}

fn check_sides(width: usize, height: usize) -> Result<()> {
    for side in [width, height] {
        if !side.is_power_of_two() {
            return Err(Error::NotPowerOfTwo { what: "side of an image", got: side });
        }
    }
    match width.checked_mul(height) {
        Some(n) if n as u64 <= 1 << 32 => Ok(()),
        _ => {
            let got = width as f64 * height as f64;
            Err(Error::OutOfRange { what: "pixels of an image", got, allowed: "at most 2^32" })
        }
    }
}

/// Calls `each(weight, x, y)` for every pair of terms whose supports overlap: the weight of the table's entry.
fn for_each_pair<T: Real>(
    a: &SparseVector<T>,
    b: &SparseVector<T>,
    width: usize,
    height: usize,
    mut each: impl FnMut(f64, usize, usize),
) {
    for (i, u) in a.iter() {
        for (j, v) in b.iter() {
            let Some((y, along_y)) = multiply(i / width, j / width, height) else { continue };
            let Some((x, along_x)) = multiply(i % width, j % width, width) else { continue };
            each(u.widen() * v.widen() * (along_x * along_y), x, y);
        }
    }
}

/// The product of two functions of the 1D basis of `size`: the entry of an axis' table whose functional it is, and its
/// factor. None where it vanishes.
///
/// Entry k < size is coefficient k, entry size + k, k > 0, the mean over the support of detail k.
#[inline]
fn multiply(i: usize, j: usize, size: usize) -> Option<(usize, f64)> {
    let (coarse, fine) = (i.min(j), i.max(j));
    if coarse == 0 {
        return Some((fine, 1.0));
    }
    if coarse == fine {
        return Some((size + fine, 1.0));
    }
    let (coarse_level, fine_level) = (coarse.ilog2(), fine.ilog2());
    let down = fine_level - coarse_level;
    if down == 0 || fine >> down != coarse {
        return None;
    }
    let sign = if fine >> (down - 1) & 1 == 0 { 1.0 } else { -1.0 };
    Some((fine, sign * BinaryTree::<f64>::amplitude(coarse_level)))
}

/// Means over the supports of details, from the coefficients of a signal of `size` whose entries lie `stride` apart.
fn means_down<T: Real>(entries: &mut [T], size: usize, stride: usize) {
    if size > 1 {
        entries[(size + 1) * stride] = entries[0];
    }
    for node in 1..size / 2 {
        let mean = entries[(size + node) * stride];
        let detail = entries[node * stride] * BinaryTree::<T>::amplitude(node.ilog2());
        entries[(size + 2 * node) * stride] = mean + detail;
        entries[(size + 2 * node + 1) * stride] = mean - detail;
    }
}

/// [`means_down`] turned round: what the means are multiplied by, as what the coefficients are.
fn means_up(entries: &mut [f64], size: usize, stride: usize) {
    for node in (1..size / 2).rev() {
        let [first, second] = [2 * node, 2 * node + 1].map(|child| entries[(size + child) * stride]);
        entries[(size + node) * stride] += first + second;
        entries[node * stride] += (first - second) * BinaryTree::<f64>::amplitude(node.ilog2());
    }
    if size > 1 {
        entries[0] += entries[(size + 1) * stride];
    }
}
