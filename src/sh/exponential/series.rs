//! Power series in an expansion, powers by truncated products.

use super::ONE;
use crate::error::check_length;
use crate::sh::{Product, Square};
use crate::{Error, Real, Result};

/// Vectors of a block of a batch: rows of four AVX2 registers.
pub(super) const fn lanes<T>() -> usize {
    if size_of::<T>() == 4 { 32 } else { 16 }
}

/// Products and squares of one size, of one vector or of a block of them.
#[derive(Debug, Clone)]
pub(super) struct Multiplier<T> {
    product: Product<T>,
    square: Square<T>,
}

impl<T: Real> Multiplier<T> {
    pub(super) fn new(bands: usize) -> Result<Self> {
        Ok(Self { product: Product::new(bands, bands, bands)?, square: Square::new(bands, bands)? })
    }

    pub(super) fn multiply(&self, count: usize, a: &[T], b: &[T], out: &mut [T]) {
        self.product.apply_batch(count, a, b, out);
    }

    pub(super) fn square(&self, count: usize, a: &[T], out: &mut [T]) {
        self.square.apply_batch(count, a, out);
    }
}

/// How the powers of a [`ProductSeries`] are formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Powers {
    /// f^{k*} = f^{(k−1)*} * f, from left to right: degree − 1 products.
    LeftToRight,
    /// Even powers f² = f*f, f⁴ = f²*f², f⁶ = f⁴*f², …, the odd ones with one more product: (degree + 1)/2 products for
    /// an odd degree, degree/2 + 1 for an even one from 4, one for degree 2.
    EvenOdd,
}

/// A power series of an expansion with truncated products for powers.
///
/// ```math
/// h_*(f) = h_0 1 + h_1 f + h_2 f*f + h_3 f*f*f + …             [Sun 2008, eqs. 5.20, 5.27; the counts are corrected]
/// ```
///
/// The limit of infinitely many terms is h(M_f)·1, M_f the product matrix, which
/// [`ProductSpectrum`](super::ProductSpectrum) gives: a series of [`Powers::LeftToRight`] is a polynomial of M_f;
/// [`Powers::EvenOdd`] truncates fewer times.
///
/// Shapes: f, out: bands², index l(l+1)+m. Calls do not allocate. Accuracy: rounding of 2e-15 Σ |h_k| ‖f‖^k; the
/// truncation of products and series is the method's. Results beyond the range of T are infinite or NaN; NaN in f
/// reaches what its products reach.
///
/// # Example
/// ```
/// use haarmonic::sh::{Powers, ProductSeries};
/// let one = (4.0 * std::f64::consts::PI).sqrt();
/// let series = ProductSeries::<f64>::new(2, &[1.0, 0.5, 0.0, 2.0], Powers::EvenOdd)?;
/// let mut out = [0.0; 4];
/// series.apply(&[3.0 * one, 0.0, 0.0, 0.0], &mut out); // the constant 3
/// assert!((out[0] / one - (1.0 + 0.5 * 3.0 + 2.0 * 27.0)).abs() < 1e-12);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProductSeries<T> {
    bands: usize,
    /// h_0…h_degree.
    coefficients: Vec<T>,
    powers: Powers,
    multiplier: Multiplier<T>,
}

impl<T: Real> ProductSeries<T> {
    /// The largest degree.
    pub const MAX_DEGREE: usize = 16;
    /// The largest number of bands; the stack holds the powers of one vector.
    pub const MAX_BANDS: usize = 32;
    /// Buffers of a vector's or block's size that a call wants: f², f⁴…f¹⁶, the odd half.
    pub(super) const BUFFERS: usize = Self::MAX_DEGREE / 2 + 1;

    /// The series with these h_0, h_1, …
    ///
    /// # Errors
    /// [`Error::Empty`] without coefficients, [`Error::OutOfRange`] if there are more than 17 of them or `bands` is not
    /// in 1…32, [`Error::NotFinite`] for a coefficient that is NaN or infinite.
    pub fn new(bands: usize, coefficients: &[f64], powers: Powers) -> Result<Self> {
        check_bands(bands)?;
        if coefficients.is_empty() {
            return Err(Error::Empty { what: "coefficients of the series" });
        }
        if coefficients.len() > Self::MAX_DEGREE + 1 {
            let got = (coefficients.len() - 1) as f64;
            return Err(Error::OutOfRange { what: "degree of the series", got, allowed: "at most 16" });
        }
        if let Some(index) = coefficients.iter().position(|h| !h.is_finite()) {
            return Err(Error::NotFinite { what: "coefficient of the series", index });
        }
        let coefficients = coefficients.iter().map(|&h| T::of(h)).collect();
        Ok(Self { bands, coefficients, powers, multiplier: Multiplier::new(bands)? })
    }

    /// The Taylor series of exp: h_k = 1/k! up to `degree`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn exp(bands: usize, degree: usize, powers: Powers) -> Result<Self> {
        let mut coefficients = vec![1.0];
        for k in 1..=degree.min(Self::MAX_DEGREE + 1) {
            coefficients.push(coefficients[k - 1] / k as f64);
        }
        Self::new(bands, &coefficients, powers)
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The degree of the series.
    pub fn degree(&self) -> usize {
        self.coefficients.len() - 1
    }

    /// Products and squares of one call.
    pub fn products(&self) -> usize {
        match (self.powers, self.degree()) {
            (_, 0 | 1) => 0,
            (Powers::LeftToRight, p) => p - 1,
            (Powers::EvenOdd, 2) => 1,
            (Powers::EvenOdd, p) if p % 2 == 0 => p / 2 + 1,
            (Powers::EvenOdd, p) => p.div_ceil(2),
        }
    }

    /// `out` = h_*(f).
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply(&self, f: &[T], out: &mut [T]) {
        check_length("expansion", self.bands * self.bands, f.len());
        check_length("function of it", self.bands * self.bands, out.len());
        on_stack(self.bands, |buffers| self.run(1, f, out, buffers));
    }

    /// How much scratch [`apply_batch`](Self::apply_batch) wants, at least, whatever the number of vectors.
    pub fn scratch_len(&self) -> usize {
        (Self::BUFFERS + 2) * self.bands * self.bands * lanes::<T>()
    }

    /// `count` expansions at once, coefficient-major: coefficient i of vector v is at i·`count` + v. The same bits as
    /// [`apply`](Self::apply).
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not `count` times bands², or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn apply_batch(&self, count: usize, f: &[T], out: &mut [T], scratch: &mut [T]) {
        let size = self.bands * self.bands;
        check_length("expansions", size.saturating_mul(count), f.len());
        check_length("functions of them", size.saturating_mul(count), out.len());
        check_scratch(self.scratch_len(), scratch.len());
        in_blocks(size, count, f, out, scratch, |width, f, out, buffers| self.run(width, f, out, buffers));
    }

    /// The series of a vector or block: `buffers` holds [`BUFFERS`](Self::BUFFERS) of its size.
    pub(super) fn run(&self, count: usize, f: &[T], out: &mut [T], buffers: &mut [T]) {
        match self.powers {
            _ if self.degree() < 2 => self.linear(count, f, out),
            Powers::LeftToRight => self.left_to_right(count, f, out, buffers),
            Powers::EvenOdd => self.even_odd(count, f, out, buffers),
        }
    }

    fn linear(&self, count: usize, f: &[T], out: &mut [T]) {
        let slope = self.coefficients.get(1).copied().unwrap_or(T::zero());
        out.iter_mut().zip(f).for_each(|(out, &f)| *out = slope * f);
        add_constant(&mut out[..count], self.coefficients[0]);
    }

    /// Horner's rule: ((h_p f + h_{p−1} 1) * f + h_{p−2} 1) * f…; with M_f 1 = f that is Σ h_k M_f^k 1.
    fn left_to_right(&self, count: usize, f: &[T], out: &mut [T], buffers: &mut [T]) {
        let last = self.degree();
        let sum = &mut buffers[..f.len()];
        out.iter_mut().zip(f).for_each(|(out, &f)| *out = self.coefficients[last] * f);
        add_constant(&mut out[..count], self.coefficients[last - 1]);
        for &h in self.coefficients[..last - 1].iter().rev() {
            sum.copy_from_slice(out);
            self.multiplier.multiply(count, sum, f, out);
            add_constant(&mut out[..count], h);
        }
    }

    fn even_odd(&self, count: usize, f: &[T], out: &mut [T], buffers: &mut [T]) {
        let (degree, size) = (self.degree(), f.len());
        let (odd, powers) = buffers.split_at_mut(size);
        // powers[k − 1] is f^{2k}.
        for k in 1..=degree / 2 {
            let (lower, rest) = powers.split_at_mut((k - 1) * size);
            let power = &mut rest[..size];
            let lower = |j: usize| &lower[(j - 1) * size..][..size];
            match k {
                1 => self.multiplier.square(count, f, power),
                _ if k % 2 == 0 => self.multiplier.square(count, lower(k / 2), power),
                _ => self.multiplier.multiply(count, lower(k - 1), lower(1), power),
            }
        }
        if degree == 2 {
            out.iter_mut().zip(f).for_each(|(out, &f)| *out = self.coefficients[1] * f);
        } else {
            let terms = (degree - 1) / 2;
            self.sum_powers(terms, 1, powers, odd);
            add_constant(&mut odd[..count], self.coefficients[1]);
            self.multiplier.multiply(count, odd, f, out);
        }
        let even = odd;
        self.sum_powers(degree / 2, 0, powers, even);
        out.iter_mut().zip(&*even).for_each(|(out, &even)| *out += even);
        add_constant(&mut out[..count], self.coefficients[0]);
    }

    /// Σ_{k=1}^{terms} h_{2k + offset} f^{2k}.
    fn sum_powers(&self, terms: usize, offset: usize, powers: &[T], out: &mut [T]) {
        let size = out.len();
        for k in 1..=terms {
            let h = self.coefficients[2 * k + offset];
            let power = &powers[(k - 1) * size..][..size];
            match k {
                1 => out.iter_mut().zip(power).for_each(|(out, &power)| *out = h * power),
                _ => out.iter_mut().zip(power).for_each(|(out, &power)| *out += h * power),
            }
        }
    }
}

/// Adds the constant function `h` to vectors whose coefficient 0 is in `row`.
fn add_constant<T: Real>(row: &mut [T], h: T) {
    let h = h * T::of(ONE);
    row.iter_mut().for_each(|x| *x += h);
}

pub(super) fn check_bands(bands: usize) -> Result<()> {
    if bands == 0 || bands > ProductSeries::<f64>::MAX_BANDS {
        return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to 32" });
    }
    Ok(())
}

/// Panics unless the scratch is long enough.
#[track_caller]
pub(super) fn check_scratch(needed: usize, got: usize) {
    assert!(got >= needed, "scratch: at least {needed} expected, got {got}");
}

/// Calls with 12 buffers of bands² on the stack.
pub(super) fn on_stack<T: Real, R>(bands: usize, call: impl FnOnce(&mut [T]) -> R) -> R {
    macro_rules! buffers {
        ($($most:literal)*) => {
            match bands {
                $(0..=$most => call(&mut [T::zero(); STACK_BUFFERS * $most * $most]),)*
                _ => call(&mut [T::zero(); STACK_BUFFERS * 32 * 32]),
            }
        };
    }
    buffers!(4 6 8 16)
}

/// Buffers of [`on_stack`]: those of a series, and two.
pub(super) const STACK_BUFFERS: usize = ProductSeries::<f64>::BUFFERS + 2;

/// Cuts a coefficient-major batch into blocks of [`lanes`] vectors: `run(width, f, out, rest of the scratch)`.
///
/// The scratch is that of two blocks and what `run` wants.
pub(super) fn in_blocks<T: Real>(
    size: usize,
    count: usize,
    f: &[T],
    out: &mut [T],
    scratch: &mut [T],
    mut run: impl FnMut(usize, &[T], &mut [T], &mut [T]),
) {
    let block = size * lanes::<T>();
    let (input, rest) = scratch.split_at_mut(block);
    let (output, rest) = rest.split_at_mut(block);
    for first in (0..count).step_by(lanes::<T>()) {
        let width = lanes::<T>().min(count - first);
        let (input, output) = (&mut input[..size * width], &mut output[..size * width]);
        for (to, from) in input.chunks_exact_mut(width).zip(f.chunks_exact(count)) {
            to.copy_from_slice(&from[first..][..width]);
        }
        run(width, input, output, rest);
        for (from, to) in output.chunks_exact(width).zip(out.chunks_exact_mut(count)) {
            to[first..][..width].copy_from_slice(from);
        }
    }
}
