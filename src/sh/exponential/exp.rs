//! The exponential of an expansion, by one of several methods.

use super::ONE;
use super::grid::GridFunction;
use super::grid_exp;
use super::optimal_linear::OptimalLinear;
use super::series::{Multiplier, Powers, ProductSeries, check_bands, check_scratch, in_blocks, lanes, on_stack};
use super::spectrum::ProductSpectrum;
use crate::error::check_length;
use crate::sh::Product;
use crate::{Error, Real, Result};

/// How exp(f) is approximated. f̂ is f without f_0, ‖f̂‖ the root of the sum of its squares.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ExpMethod {
    /// PS-p: 1 + f + f*f/2 + … up to `degree`, as it stands [Sun 2008, eq. 5.22]. For small f, and for comparison.
    Series {
        /// p, 0…16.
        degree: usize,
    },
    /// PS*-p: e^{f_0/√4π} times the 2^s-th power, by s squarings, of the even/odd series of f̂/2^s [Sun 2008, eqs.
    /// 5.25–5.27].
    ScaledSeries {
        /// p, 0…16.
        degree: usize,
    },
    /// OL: e^{f_0/√4π} (a·1 + b f̂), see [`OptimalLinear`]. For ‖f̂‖ ≲ 1.
    OptimalLinear,
    /// HYB: OL of f̂/2^s and s squarings.
    Hybrid,
    /// exp(M_f)·1, the limit of the series, by [`ProductSpectrum`] in f64 [Sun 2008, eq. 5.31]. Allocates; where the
    /// eigenvectors do not converge, PS*-9.
    Eigen,
    /// exp point by point on the grid of [`GridFunction::new`].
    Grid,
}

impl Default for ExpMethod {
    /// PS*-2: within 2e-4 of the error of PS*-9.
    fn default() -> Self {
        Self::ScaledSeries { degree: 2 }
    }
}

/// exp(f) of an expansion, truncated to its bands: from the sum of logarithms of blockers to their common visibility.
///
/// | you have | use | mean error at bands 3, 4, 5, 6 |
/// |---|---|---|
/// | any logarithms | `ScaledSeries { degree: 2 }`, the default | 0.051, 0.050, 0.053, 0.054 |
/// | … and a quarter of its time to save | the same [`with_scaled_norm`](Self::with_scaled_norm)`(0.5)` | 0.051, 0.051, 0.054, 0.054 |
/// | 5 bands or more, discs of [`CapFit::Grid`](super::CapFit::Grid) | `Grid` | 0.052, 0.051, 0.047, 0.042 |
/// | ‖f̂‖ ≲ 1 and no time | `OptimalLinear` | 0.082, 0.138, 0.189, 0.191 |
/// | the limit of the series, to compare | `Eigen` | 0.051, 0.050, 0.052, 0.051 |
///
/// The errors are relative, in L², against the projected visibility of unions of 1 to 8 discs of 0.2 to 0.75 rad;
/// multiplying the discs' visibilities has 0.047, 0.039, 0.032, 0.029
/// (`cargo run --release --features io --example sh_exp`, which has them by ‖f̂‖). More terms than 2 change nothing: it
/// is the products' truncation that is left. `Grid` on logarithms made for products is worse (0.088 at 6 bands): each
/// exp wants its own log.
///
/// Shapes: f, out: bands², index l(l+1)+m. Calls do not allocate (but for [`ExpMethod::Eigen`]).
/// Range: finite f give finite results with every method but `Series`: those beyond the largest T are held at it (by
/// `Grid` the values of exp are, at e^85 in `f32`, e^705 in `f64`). NaN or infinity anywhere in f gives NaN everywhere.
///
/// # Example
/// ```
/// use haarmonic::sh::{ExpMethod, Exponential};
/// let exp = Exponential::new(2, ExpMethod::default())?;
/// let (mut out, one) = ([0.0f64; 4], (4.0 * std::f64::consts::PI).sqrt());
/// exp.apply(&[-0.5 * one, 0.0, 0.0, 0.0], &mut out); // the constant −1/2
/// assert!((out[0] / one - (-0.5f64).exp()).abs() < 1e-15 && out[1..] == [0.0; 3]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Exponential<T> {
    bands: usize,
    method: ExpMethod,
    form: Form<T>,
}

#[derive(Debug, Clone)]
enum Form<T> {
    Series(ProductSeries<T>),
    Scaled(Box<Scaled<T>>),
    Linear(OptimalLinear),
    Eigen(Product<f64>, Box<Exponential<f64>>),
    Grid(GridFunction<T>),
}

impl<T: Real> Exponential<T> {
    /// A plan of exp for expansions of `bands` bands.
    ///
    /// Cost: microseconds to milliseconds; of `OptimalLinear` and `Hybrid` above 8 bands, of which the crate has no
    /// tables, that of [`OptimalLinear::fit`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32 or a degree is above 16.
    pub fn new(bands: usize, method: ExpMethod) -> Result<Self> {
        check_bands(bands)?;
        let scaled = |seed| Ok::<_, Error>(Form::Scaled(Box::new(Scaled::new(bands, seed)?)));
        let form = match method {
            ExpMethod::Series { degree } => Form::Series(ProductSeries::exp(bands, degree, Powers::LeftToRight)?),
            ExpMethod::ScaledSeries { degree } => {
                scaled(Seed::Series(Box::new(ProductSeries::exp(bands, degree, Powers::EvenOdd)?)))?
            }
            ExpMethod::OptimalLinear => Form::Linear(OptimalLinear::new(bands)?),
            ExpMethod::Hybrid => scaled(Seed::Linear(OptimalLinear::new(bands)?))?,
            ExpMethod::Eigen => {
                let fallback = Exponential::new(bands, ExpMethod::ScaledSeries { degree: 9 })?;
                Form::Eigen(Product::new(bands, bands, bands)?, Box::new(fallback))
            }
            ExpMethod::Grid => Form::Grid(GridFunction::new(bands)?),
        };
        Ok(Self { bands, method, form })
    }

    /// With f̂ scaled down to this norm instead of 1/8, for PS*-p and HYB: at 1/2 there are two squarings fewer.
    ///
    /// Rounding grows with the number of squarings, as eps ‖f̂‖/norm; the series' own error at 1/8 is long below it,
    /// which is why norms below 1/1000 are refused.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless it is in [0.001, 8].
    pub fn with_scaled_norm(mut self, norm: f64) -> Result<Self> {
        if !(0.001..=8.0).contains(&norm) {
            return Err(Error::OutOfRange { what: "scaled norm", got: norm, allowed: "in [0.001, 8]" });
        }
        if let Form::Scaled(scaled) = &mut self.form {
            scaled.norm = norm;
        }
        Ok(self)
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The method.
    pub fn method(&self) -> ExpMethod {
        self.method
    }

    /// `out` = exp(f).
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply(&self, f: &[T], out: &mut [T]) {
        check_length("logarithm", self.bands * self.bands, f.len());
        check_length("exponential", self.bands * self.bands, out.len());
        match &self.form {
            Form::Series(series) => series.apply(f, out),
            Form::Scaled(scaled) => on_stack(self.bands, |buffers| scaled.run(1, f, out, buffers)),
            Form::Grid(grid) => grid.exp(1, f, out),
            Form::Linear(linear) => self.linear(linear, 1, f, out),
            Form::Eigen(product, fallback) => self.eigen(product, fallback, 1, f, out),
        }
    }

    /// How much scratch [`apply_batch`](Self::apply_batch) wants, at least, whatever the number of vectors.
    pub fn scratch_len(&self) -> usize {
        match &self.form {
            Form::Series(series) => series.scratch_len(),
            Form::Scaled(scaled) => scaled.scratch_len(),
            _ => 0,
        }
    }

    /// `count` exponentials at once, coefficient-major: coefficient i of vector v is at i·`count` + v. The same bits as
    /// [`apply`](Self::apply).
    ///
    /// # Panics
    /// If `f.len()` or `out.len()` is not `count` times bands², or `scratch` is shorter than
    /// [`scratch_len`](Self::scratch_len).
    #[track_caller]
    pub fn apply_batch(&self, count: usize, f: &[T], out: &mut [T], scratch: &mut [T]) {
        check_length("logarithms", (self.bands * self.bands).saturating_mul(count), f.len());
        check_length("exponentials", (self.bands * self.bands).saturating_mul(count), out.len());
        check_scratch(self.scratch_len(), scratch.len());
        match &self.form {
            Form::Series(series) => series.apply_batch(count, f, out, scratch),
            Form::Scaled(scaled) => scaled.apply_batch(count, f, out, scratch),
            Form::Grid(grid) => grid.exp(count, f, out),
            Form::Linear(linear) => self.linear(linear, count, f, out),
            Form::Eigen(product, fallback) => self.eigen(product, fallback, count, f, out),
        }
    }

    fn linear(&self, linear: &OptimalLinear, count: usize, f: &[T], out: &mut [T]) {
        for v in 0..count {
            let (norm, finite) = norm_without_constant(count, v, f);
            let [a, b] = linear.factors(norm);
            let log_scale = f[v].widen() / ONE;
            let [factor, again] = if finite { exp_in_two(log_scale) } else { [f64::NAN; 2] };
            out[v] = held(factor * (a * ONE) * again);
            for (out, f) in out[v..].iter_mut().step_by(count).zip(f[v..].iter().step_by(count)).skip(1) {
                *out = held(factor * (b * f.widen()) * again);
            }
        }
    }

    fn eigen(&self, product: &Product<f64>, fallback: &Exponential<f64>, count: usize, f: &[T], out: &mut [T]) {
        for v in 0..count {
            let column: Vec<f64> = f[v..].iter().step_by(count).map(|x| x.widen()).collect();
            let result = if column.iter().all(|x| x.is_finite()) {
                ProductSpectrum::new(product, &column).map(|spectrum| exp_of(&spectrum)).unwrap_or_else(|_| {
                    let mut out = vec![0.0; column.len()];
                    fallback.apply(&column, &mut out);
                    out
                })
            } else {
                vec![f64::NAN; column.len()]
            };
            out[v..].iter_mut().step_by(count).zip(result).for_each(|(out, x)| *out = held(x));
        }
    }
}

/// ‖f̂‖ of column v and whether all of f is finite; the norm is infinite if its square overflows.
fn norm_without_constant<T: Real>(count: usize, v: usize, f: &[T]) -> (f64, bool) {
    let column = || f[v..].iter().step_by(count).map(|x| x.widen());
    let square: f64 = column().skip(1).map(|x| x * x).sum();
    let finite = (square.is_finite() && f[v].is_finite()) || column().all(f64::is_finite);
    (square.sqrt(), finite)
}

/// e^x, at most e^705.
fn held_exp(x: f64) -> f64 {
    if x < -708.0 { 0.0 } else { grid_exp::exp(x) }
}

/// e^x as a product of two factors, the second 1 unless e^x alone could overflow.
fn exp_in_two(x: f64) -> [f64; 2] {
    // Beyond twice this no finite number times it is less than the largest.
    let x = if x > 1400.0 { 1400.0 } else { x };
    if x > 700.0 { [grid_exp::exp(0.5 * x); 2] } else { [held_exp(x), 1.0] }
}

/// exp(M_f)·1, infinite where it overflows.
fn exp_of(spectrum: &ProductSpectrum) -> Vec<f64> {
    let largest = spectrum.largest().min(f64::MAX);
    if largest <= 700.0 {
        return spectrum.apply(held_exp);
    }
    // e^x = e^{x − largest} e^{largest}.
    let [factor, again] = exp_in_two(largest);
    spectrum.apply(|x| held_exp(x - largest)).into_iter().map(|x| x * factor * again).collect()
}

/// Narrowed, and held within the finite numbers; NaN stays.
fn held<T: Real>(x: f64) -> T {
    let most = T::max_value().widen();
    T::of(if x > most {
        most
    } else if x < -most {
        -most
    } else {
        x
    })
}

/// Scaling and squaring.
#[derive(Debug, Clone)]
struct Scaled<T> {
    bands: usize,
    seed: Seed<T>,
    multiplier: Multiplier<T>,
    norm: f64,
}

/// What approximates the exponential of a small f̂.
#[derive(Debug, Clone)]
enum Seed<T> {
    Series(Box<ProductSeries<T>>),
    Linear(OptimalLinear),
}

/// One vector of a block: how its f is reduced.
#[derive(Debug, Clone, Copy, Default)]
struct Reduction {
    /// Σ f̂², then ‖f̂‖.
    norm: f64,
    squarings: u32,
    /// f/2^squarings.
    shrink: f64,
    /// e^{f_0/√4π}.
    factor: f64,
    /// Whether powers on the way may leave the range of T.
    far: bool,
}

/// Most vectors of a block.
const MOST: usize = 32;

impl<T: Real> Scaled<T> {
    fn new(bands: usize, seed: Seed<T>) -> Result<Self> {
        Ok(Self { bands, seed, multiplier: Multiplier::new(bands)?, norm: 0.125 })
    }

    fn scratch_len(&self) -> usize {
        (BUFFERS + 2) * self.bands * self.bands * lanes::<T>()
    }

    fn apply_batch(&self, count: usize, f: &[T], out: &mut [T], scratch: &mut [T]) {
        let size = self.bands * self.bands;
        in_blocks(size, count, f, out, scratch, |width, f, out, buffers| self.run(width, f, out, buffers));
    }

    /// A vector or block.
    fn run(&self, count: usize, f: &[T], out: &mut [T], buffers: &mut [T]) {
        let mut reductions = [Reduction::default(); MOST];
        let reductions = &mut reductions[..count];
        self.reduce(f, reductions);
        let (small, rest) = buffers.split_at_mut(f.len());
        shrink(f, reductions, small);
        match &self.seed {
            Seed::Series(series) => series.run(count, small, out, rest),
            Seed::Linear(linear) => seed_linear(linear, reductions, small, out),
        }
        self.square_up(reductions, out, &mut rest[..f.len()]);
        for row in out.chunks_exact_mut(count) {
            row.iter_mut().zip(&*reductions).for_each(|(out, r)| *out *= T::of(r.factor));
        }
        for v in (0..count).filter(|&v| reductions[v].far) {
            if count == 1 {
                self.far(f, out, buffers);
            } else {
                let size = self.bands * self.bands;
                let (column, rest) = buffers.split_at_mut(size);
                let (result, rest) = rest.split_at_mut(size);
                column.iter_mut().zip(f[v..].iter().step_by(count)).for_each(|(to, f)| *to = *f);
                self.far(column, result, rest);
                out[v..].iter_mut().step_by(count).zip(result).for_each(|(out, x)| *out = *x);
            }
        }
    }

    /// The number of squarings that brings a norm within the limit. A norm that rounding lifts above it is within.
    fn squarings(&self, norm: f64) -> u32 {
        let (mut squarings, mut reach) = (0, self.norm * (1.0 + 1e-6));
        while norm > reach {
            squarings += 1;
            reach *= 2.0;
        }
        squarings
    }

    fn reduce(&self, f: &[T], reductions: &mut [Reduction]) {
        // |f̂(ω)| ≤ ‖f̂‖ bands/√4π bounds the eigenvalues of every power, which so stay below e to this.
        let limit = if size_of::<T>() == 4 { 80.0 } else { 700.0 };
        let count = reductions.len();
        for row in f.chunks_exact(count).skip(1) {
            for (r, f) in reductions.iter_mut().zip(row) {
                r.norm += f.widen() * f.widen();
            }
        }
        for (r, f) in reductions.iter_mut().zip(f) {
            r.norm = r.norm.sqrt();
            let (constant, bound) = (f.widen() / ONE, r.norm * self.bands as f64 / ONE);
            r.far = !(bound < limit && bound + constant < limit && constant > f64::NEG_INFINITY);
            if !r.far {
                r.squarings = self.squarings(r.norm);
                r.shrink = 0.5f64.powi(r.squarings as i32);
                r.factor = held_exp(constant);
            }
        }
    }

    /// Squares each vector as often as it is due.
    fn square_up(&self, reductions: &[Reduction], out: &mut [T], other: &mut [T]) {
        let count = reductions.len();
        let most = reductions.iter().map(|r| r.squarings).max().unwrap_or(0);
        for done in 0..most {
            self.multiplier.square(count, out, other);
            for (out, other) in out.chunks_exact_mut(count).zip(other.chunks_exact(count)) {
                for ((out, &other), r) in out.iter_mut().zip(other).zip(reductions) {
                    *out = if r.squarings > done { other } else { *out };
                }
            }
        }
    }

    /// One vector whose powers may overflow: each is kept at a largest coefficient of 1, with the logarithm of its
    /// scale beside it.
    fn far(&self, f: &[T], out: &mut [T], buffers: &mut [T]) {
        if f.iter().any(|x| !x.is_finite()) {
            return out.fill(T::nan());
        }
        let largest = f.iter().skip(1).fold(0.0, |m: f64, x| m.max(x.widen().abs()));
        let square: f64 = f.iter().skip(1).map(|x| (x.widen() / largest).powi(2)).sum();
        // The largest squares beyond f64: scaled below. A constant has 0/0 there.
        let norm = if largest > 0.0 { (largest * square.sqrt()).min(f64::MAX) } else { 0.0 };
        let squarings = self.squarings(norm);
        let one = &mut [Reduction { norm, squarings, shrink: 0.5f64.powi(squarings as i32), ..Reduction::default() }];
        let (small, rest) = buffers.split_at_mut(f.len());
        shrink(f, one, small);
        match &self.seed {
            Seed::Series(series) => series.run(1, small, out, rest),
            Seed::Linear(linear) => seed_linear(linear, one, small, out),
        }
        let mut log_scale = 0.0;
        let normalise = |x: &mut [T], log_scale: &mut f64| {
            let largest = x.iter().fold(T::zero(), |m, x| m.max(x.abs()));
            if largest > T::zero() {
                x.iter_mut().for_each(|x| *x /= largest);
                *log_scale += largest.widen().ln();
            }
        };
        normalise(out, &mut log_scale);
        for _ in 0..squarings {
            self.multiplier.square(1, out, small);
            out.copy_from_slice(small);
            log_scale *= 2.0;
            normalise(out, &mut log_scale);
        }
        let log_scale = log_scale + f[0].widen() / ONE;
        for x in out {
            let sign = x.signum().widen();
            // e^{log |x| + log scale}, so that a small coefficient survives a large scale.
            *x = if x.is_zero() { T::zero() } else { held(sign * held_exp_ends(x.abs().widen().ln() + log_scale)) };
        }
    }
}

/// e^x, infinity beyond its range.
fn held_exp_ends(x: f64) -> f64 {
    if x > 705.0 {
        let [factor, again] = exp_in_two(x);
        factor * again
    } else {
        held_exp(x)
    }
}

/// f̂ · shrink.
fn shrink<T: Real>(f: &[T], reductions: &[Reduction], small: &mut [T]) {
    let count = reductions.len();
    small[..count].fill(T::zero());
    for (small, f) in small.chunks_exact_mut(count).zip(f.chunks_exact(count)).skip(1) {
        for ((small, &f), r) in small.iter_mut().zip(f).zip(reductions) {
            *small = f * T::of(r.shrink);
        }
    }
}

/// a·1 + b f̂ of each vector.
fn seed_linear<T: Real>(linear: &OptimalLinear, reductions: &[Reduction], small: &[T], out: &mut [T]) {
    let count = reductions.len();
    let mut factors = [[T::zero(); 2]; MOST];
    for (factors, r) in factors.iter_mut().zip(reductions) {
        let [a, b] = linear.factors(r.norm * r.shrink);
        *factors = [T::of(a * ONE), T::of(b)];
    }
    for (out, small) in out.chunks_exact_mut(count).zip(small.chunks_exact(count)) {
        for ((out, &small), factors) in out.iter_mut().zip(small).zip(&factors) {
            *out = factors[1] * small;
        }
    }
    out[..count].iter_mut().zip(&factors).for_each(|(out, factors)| *out = factors[0]);
}

/// Buffers of a block: f̂/2^s and those of the series.
const BUFFERS: usize = ProductSeries::<f64>::BUFFERS + 1;
