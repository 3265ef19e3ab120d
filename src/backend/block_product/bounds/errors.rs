//! Norms of errors and of lights, and their logarithms.

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
    /// The errors where a function reaches `nearest` somewhere in a block of `side`²: if less was measured than one pixel of that
    /// makes, the places of measurement missed it.
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

/// [`Errors`] as logarithms: 0 is exactly none, [`NEVER`] more than can be said, k + 1 is k's times the eighth root of 2.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::backend::block_product) struct Codes {
    rms: [u8; 4],
    bias: [u8; 4],
    mean: [u8; 4],
}

impl Codes {
    /// Of errors and a tenth more, because they are measured at single places.
    pub(super) fn new(errors: Errors) -> Self {
        let codes = |errors: [f64; 4]| errors.map(|error| code(1.1 * error));
        Self { rms: codes(errors.rms), bias: codes(errors.bias), mean: codes(errors.mean) }
    }

    pub(super) fn worse(self, other: Self) -> Self {
        let larger = |a: [u8; 4], b: [u8; 4]| std::array::from_fn(|k| a[k].max(b[k]));
        Self {
            rms: larger(self.rms, other.rms),
            bias: larger(self.bias, other.bias),
            mean: larger(self.mean, other.mean),
        }
    }

    /// The fewest samples of a free block: none, 1, 4, 16, pixels.
    #[inline(always)]
    pub(in crate::backend::block_product) fn free(&self, limits: &Limits, offset: f32) -> u8 {
        let (bias, rms) = (limit(limits.bias - offset), limit(limits.deviation - offset));
        first(std::array::from_fn(|k| self.bias[k] <= bias && self.rms[k] <= rms))
    }

    /// The same of a block that is partly hidden.
    #[inline(always)]
    pub(in crate::backend::block_product) fn mixed(&self, limits: &Limits, offset: f32) -> u8 {
        let (rms, mean) = (limit(limits.rms - offset), limit(limits.mean - offset));
        first(std::array::from_fn(|k| self.rms[k] <= rms || self.mean[k] <= mean))
    }
}

/// The index of the first that holds, or 4.
#[inline(always)]
fn first(holds: [bool; 4]) -> u8 {
    let bits = holds.iter().enumerate().fold(16, |bits, (k, &holds)| bits | u32::from(holds) << k);
    bits.trailing_zeros() as u8
}

/// A limit as a code; an error of 0 is always allowed, one of [`NEVER`] never.
#[inline(always)]
fn limit(limit: f32) -> u8 {
    limit.clamp(0.0, f32::from(NEVER) - 1.0) as u8
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
        }
    }

    /// log₂ of what a pixel may reflect, times the factor of `offset`, and still be left out.
    #[inline(always)]
    pub(in crate::backend::block_product) fn darkness(&self, offset: f32) -> f32 {
        (self.rms.max(self.mean) - self.spread - offset - ZERO as f32) / STEPS as f32
    }
}

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
}

impl Norms {
    /// Of one channel.
    pub(in crate::backend::block_product) fn new(light: &[f64]) -> Self {
        let n = light.len() as f64;
        let sum: f64 = light.iter().sum();
        let (mut squares, mut deviations, mut largest) = (0.0, 0.0, 0.0_f64);
        for &x in light {
            squares += x * x;
            deviations += (x - sum / n).powi(2);
            largest = largest.max(x.abs());
        }
        Self { sum: sum.abs(), deviation: (n * deviations).sqrt(), rms: (n * squares).sqrt(), largest: n * largest }
    }

    /// The larger of each.
    pub(in crate::backend::block_product) fn larger(self, other: Self) -> Self {
        Self {
            sum: self.sum.max(other.sum),
            deviation: self.deviation.max(other.deviation),
            rms: self.rms.max(other.rms),
            largest: self.largest.max(other.largest),
        }
    }
}

/// Above every threshold.
const NEVER: u8 = u8::MAX;
const STEPS: f64 = 8.0;
const ZERO: f64 = 200.0;

/// Rounded up: an error is never less than its code says.
fn code(error: f64) -> u8 {
    match error {
        0.0 => 0,
        e if e < f64::INFINITY => (ZERO + STEPS * e.log2()).ceil().clamp(1.0, f64::from(NEVER)) as u8,
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
