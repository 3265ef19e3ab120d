//! Norms of errors and of lights, and their logarithms.

use crate::backend::block_product::rule::SampleClass;

/// Norms of the errors of 0, 1, 4 and 16 samples.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::backend::block_product) struct Errors {
    pub(super) rms: [f64; 4],
    /// |mean e|
    pub(super) bias: [f64; 4],
    /// mean |e|
    pub(super) mean: [f64; 4],
}

impl Errors {
    /// The larger of each.
    pub(super) fn worst(self, other: Self) -> Self {
        let larger = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|k| a[k].max(b[k]));
        Self {
            rms: larger(self.rms, other.rms),
            bias: larger(self.bias, other.bias),
            mean: larger(self.mean, other.mean),
        }
    }
}

impl Errors {
    /// These errors, raised to what a single pixel of height `nearest` makes in a block of `side`²: a lobe can be so
    /// narrow that the places where errors were measured miss it.
    pub(super) fn with_a_pixel_of(mut self, nearest: f64, side: usize) -> Self {
        let (rms, mean) = (nearest / side as f64, nearest / (side * side) as f64);
        if self.rms[0] < rms {
            for k in 0..4 {
                self.rms[k] = self.rms[k].max(rms);
                self.bias[k] = self.bias[k].max(mean);
                self.mean[k] = self.mean[k].max(mean);
            }
        }
        self
    }
}

/// [`Errors`] on a logarithmic scale: 0 stands for no error, [`NEVER`] for more than can be said, and each step from 1
/// on multiplies the error by the 32nd root of 2.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::backend::block_product) struct Codes {
    rms: Four,
    bias: Four,
    mean: Four,
}

impl Codes {
    /// Of errors and a tenth more, because they are measured at single places.
    pub(super) fn new(errors: Errors) -> Self {
        let codes = |errors: [f64; 4]| Four::new(errors.map(|error| code(1.1 * error)));
        Self { rms: codes(errors.rms), bias: codes(errors.bias), mean: codes(errors.mean) }
    }

    /// Of errors as they are.
    #[cfg(test)]
    pub(super) fn exactly(errors: Errors) -> Self {
        let codes = |errors: [f64; 4]| Four::new(errors.map(code));
        Self { rms: codes(errors.rms), bias: codes(errors.bias), mean: codes(errors.mean) }
    }

    #[cfg(test)]
    pub(super) fn all(&self) -> [u16; 12] {
        std::array::from_fn(|k| ([self.rms, self.bias, self.mean][k / 4].0 >> (16 * (k % 4))) as u16)
    }

    /// Of codes that are there: rms, bias, mean.
    pub(super) fn of(codes: &[[u16; 4]; 3]) -> Self {
        let [rms, bias, mean] = codes.map(Four::new);
        Self { rms, bias, mean }
    }

    /// [`class`](Self::class) of what lies between four, rounded up; the weights add up to 64.
    #[inline(always)]
    pub(super) fn class_between(four: [&Self; 4], weights: [u64; 4], checks: &Checks, free: bool) -> SampleClass {
        let [a, b, c, d] = four;
        let rms = Four::between([a.rms, b.rms, c.rms, d.rms], weights);
        // A block is asked for two of the three.
        let other = |codes: &Self| if free { codes.bias } else { codes.mean };
        let other = Four::between([other(a), other(b), other(c), other(d)], weights);
        let holds = if free {
            checks.bias.holds(other) & checks.deviation.holds(rms)
        } else {
            checks.rms.holds(rms) | checks.mean.holds(other)
        };
        SampleClass::after(holds.trailing_zeros() / 16)
    }

    /// What lies between four.
    #[cfg(test)]
    pub(super) fn between(four: [&Self; 4], weights: [u64; 4]) -> Self {
        let part = |part: fn(&Self) -> Four| Four::between(four.map(part), weights);
        Self { rms: part(|codes| codes.rms), bias: part(|codes| codes.bias), mean: part(|codes| codes.mean) }
    }

    pub(super) fn worse(self, other: Self) -> Self {
        Self { rms: self.rms.larger(other.rms), bias: self.bias.larger(other.bias), mean: self.mean.larger(other.mean) }
    }

    /// The fewest samples of a block, free or partly hidden: none, 1, 4, 16, pixels.
    #[inline(always)]
    pub(in crate::backend::block_product) fn class(&self, checks: &Checks, free: bool) -> SampleClass {
        let in_free = checks.bias.holds(self.bias) & checks.deviation.holds(self.rms);
        let in_mixed = checks.rms.holds(self.rms) | checks.mean.holds(self.mean);
        let holds = if free { in_free } else { in_mixed };
        SampleClass::after(holds.trailing_zeros() / 16)
    }
}

/// Codes of 0, 1, 4 and 16 samples, sixteen bits each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Four(u64);

impl Four {
    fn new(codes: [u16; 4]) -> Self {
        Self(codes.iter().rev().fold(0, |four, &code| four << 16 | u64::from(code)))
    }

    /// All four at once: sixteen bits hold 1023 · 64 and what rounds it up.
    #[inline(always)]
    fn between([a, b, c, d]: [Self; 4], weights: [u64; 4]) -> Self {
        const UP: u64 = 0x003f_003f_003f_003f;
        const LOW: u64 = 0x03ff_03ff_03ff_03ff;
        let sum = a.0 * weights[0] + b.0 * weights[1] + c.0 * weights[2] + d.0 * weights[3] + UP;
        Self(sum >> 6 & LOW)
    }

    fn larger(self, other: Self) -> Self {
        let code = |four: Self, k: usize| (four.0 >> (16 * k)) as u16;
        Self::new(std::array::from_fn(|k| code(self, k).max(code(other, k))))
    }
}

/// A limit in each sixteen bits, and their highest bit.
#[derive(Debug, Clone, Copy, Default)]
struct Check(u64);

impl Check {
    const HIGHEST: u64 = 0x8000_8000_8000_8000;

    /// An error of 0 is always allowed, one of [`NEVER`] never.
    fn new(limit: f32) -> Self {
        let limit = limit.clamp(0.0, f32::from(NEVER) - 1.0) as u64;
        Self((limit * 0x0001_0001_0001_0001) | Self::HIGHEST)
    }

    /// Leaves the highest of sixteen bits where a code is not above the limit; no difference borrows from the next.
    #[inline(always)]
    fn holds(self, codes: Four) -> u64 {
        (self.0 - codes.0) & Self::HIGHEST
    }
}

/// The largest errors that a block's light allows a lobe.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::backend::block_product) struct Checks {
    bias: Check,
    deviation: Check,
    rms: Check,
    mean: Check,
}

/// The largest errors that a block's light allows, as codes without offset; see [`threshold`].
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::backend::block_product) struct Limits {
    /// Of |mean e| and of rms e, in a free block.
    bias: f32,
    deviation: f32,
    /// Of rms e or of mean |e|, in one that is partly hidden.
    rms: f32,
    mean: f32,
    /// How much smaller errors of one sign must be.
    spread: f32,
    /// Σ of what may be left out of a block, over its brightest radiance.
    tail: f64,
}

/// √(blocks/2): the sum of as many equal errors as there are blocks above a horizon, over that of independent ones.
pub(in crate::backend::block_product) fn spread(blocks: usize) -> f64 {
    (blocks as f64 / 2.0).sqrt()
}

impl Limits {
    /// `allowed`: the error of the radiance by one of so many blocks.
    pub(in crate::backend::block_product) fn new(allowed: f64, norms: &Norms, blocks: usize) -> Self {
        Self {
            spread: offset(spread(blocks)),
            bias: threshold(0.5 * allowed / norms.sum),
            deviation: threshold(0.5 * allowed / norms.deviation),
            rms: threshold(allowed / norms.rms),
            mean: threshold(allowed / norms.largest),
            tail: 0.5 * allowed / norms.peak,
        }
    }

    /// For a lobe of the factor of `offset`.
    pub(in crate::backend::block_product) fn checks(&self, offset: f32) -> Checks {
        Checks {
            bias: Check::new(self.bias - offset),
            deviation: Check::new(self.deviation - offset),
            rms: Check::new(self.rms - offset),
            mean: Check::new(self.mean - offset),
        }
    }

    /// The cosine to the mirror direction below which pixels may be left out of `factor` cosⁿ θ.
    ///
    /// The larger of two: that where no pixel may count on its own; and, for a lobe wider than pixels, that where all
    /// beyond it together, L F 2π ∫ cosⁿ θ sin θ dθ = L F 2π cosⁿ⁺¹ θ/(n + 1), are half of what the block is allowed.
    pub(in crate::backend::block_product) fn least_cosine(&self, factor: f64, exponent: f64, pixel: f64) -> f64 {
        let darkness = (f64::from(self.rms.max(self.mean) - self.spread - offset(factor)) - ZERO) / STEPS;
        // An exponent of 0 leaves out nothing: 2^(−∞ · 1e30) = 0.
        let single = (darkness / exponent.max(1e-30)).min(0.0).exp2();
        if exponent * pixel * pixel > WIDE {
            return single;
        }
        let together = (self.tail * (exponent + 1.0) / (std::f64::consts::TAU * factor)).powf(1.0 / (exponent + 1.0));
        single.max(together.min(1.0))
    }
}

/// Exponent × square of the radius of a pixel, to which sums over pixels are integrals: those of Gaussians of a width
/// of two radii.
const WIDE: f64 = 0.25;

/// Norms of the light of a block of N pixels, of its brightest channel.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::backend::block_product) struct Norms {
    /// |Σ L|
    pub(in crate::backend::block_product) sum: f64,
    /// √(N Σ (L − mean L)²)
    pub(in crate::backend::block_product) deviation: f64,
    /// √(N Σ L²)
    pub(in crate::backend::block_product) rms: f64,
    /// N max |L|
    pub(in crate::backend::block_product) largest: f64,
    /// The largest |radiance|, which L is times the solid angle of a pixel.
    pub(in crate::backend::block_product) peak: f64,
}

impl Norms {
    /// Of one channel of L, and the largest radiance.
    pub(in crate::backend::block_product) fn new(light: &[f64], peak: f64) -> Self {
        let n = light.len() as f64;
        let sum: f64 = light.iter().sum();
        let (mut squares, mut deviations, mut largest) = (0.0, 0.0, 0.0_f64);
        for &x in light {
            squares += x * x;
            deviations += (x - sum / n).powi(2);
            largest = largest.max(x.abs());
        }
        Self {
            sum: sum.abs(),
            deviation: (n * deviations).sqrt(),
            rms: (n * squares).sqrt(),
            largest: n * largest,
            peak,
        }
    }

    /// The larger of each.
    pub(in crate::backend::block_product) fn larger(self, other: Self) -> Self {
        Self {
            sum: self.sum.max(other.sum),
            deviation: self.deviation.max(other.deviation),
            rms: self.rms.max(other.rms),
            largest: self.largest.max(other.largest),
            peak: self.peak.max(other.peak),
        }
    }
}

/// Above every threshold.
const NEVER: u16 = 1023;
pub(super) const STEPS: f64 = 32.0;
const ZERO: f64 = 800.0;

/// Rounded up: an error is never less than its code says.
pub(super) fn code(error: f64) -> u16 {
    match error {
        0.0 => 0,
        e if e < f64::INFINITY => (ZERO + STEPS * e.log2()).ceil().clamp(1.0, f64::from(NEVER)) as u16,
        _ => NEVER,
    }
}

/// The code of the largest error that is allowed, rounded down; to be lessened by [`offset`]s.
fn threshold(allowed: f64) -> f32 {
    // 0/0, no error allowed of no light: nothing depends on it.
    if allowed.is_nan() { f32::INFINITY } else { (ZERO + STEPS * allowed.log2()).floor() as f32 }
}

/// What a factor of the error adds to its code, rounded up.
pub(in crate::backend::block_product) fn offset(factor: f64) -> f32 {
    (STEPS * factor.log2()).ceil() as f32
}
