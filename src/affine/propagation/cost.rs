//! Which route is the cheapest, from counts.
//!
//! Every route's cost is a sum of counts that are known before it runs, each times a measured constant. How many
//! couplings a source function has is estimated: three at each level that is finer than its image, which is what it has
//! in full view.

use super::{PropagationRoute, PropagationSource, Targets};
use crate::Real;
use crate::affine::AffineMap;
use crate::haar::Decomposition;

/// How many functions of each level there are in a set; φ counts as level 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Estimates {
    count: [u32; LEVELS],
    /// One more than the finest level of the set.
    levels: usize,
}

/// As many as the largest side has.
const LEVELS: usize = 12;

impl Estimates {
    /// For functions of the given levels.
    pub(super) fn new(functions: impl Iterator<Item = u32>) -> Self {
        let mut estimates = Self::default();
        for level in functions {
            estimates.count[level as usize] += 1;
            estimates.levels = estimates.levels.max(level as usize + 1);
        }
        estimates
    }

    /// Σ over the functions of `of` the levels that are finer than their images, of `levels` levels of the target.
    #[inline(always)]
    fn sum(&self, levels: u32, log_scale: i32, of: impl Fn(i32) -> f64) -> f64 {
        let finer = |level: usize| (levels as i32 - level as i32 - log_scale).clamp(0, levels as i32);
        (0..self.levels).map(|level| f64::from(self.count[level]) * of(finer(level))).sum()
    }

    /// Σ over the functions of the levels that are finer than their images.
    #[inline(always)]
    fn finer(&self, levels: u32, log_scale: i32) -> f64 {
        self.sum(levels, log_scale, f64::from)
    }

    /// Σ over the functions of the cells of the finest level in their images.
    #[inline(always)]
    fn cells(&self, levels: u32, log_scale: i32) -> f64 {
        self.sum(levels, log_scale, |finer| f64::from(1u32 << finer))
    }
}

/// ⌊log₂|s| + ½⌋, from the bits of s.
#[inline(always)]
fn log_scale(map: AffineMap) -> i32 {
    let bits = (map.scale().abs() * std::f64::consts::SQRT_2).to_bits();
    (bits >> 52) as i32 - 1023
}

/// What a count costs, in nanoseconds of one core (Zen 3, AVX2) in its fast state; only their ratios matter.
///
/// Fitted to the sweep of the bench `affine_propagation`: sides 16 to 128, 0.1 to 100 % of the terms, 1 to 100 % of the
/// targets, one and three channels. The fit is within 15 % of nine tenths of the measurements.
struct Cost {
    /// One value of a row that is scaled and added.
    fused: f64,
    /// One pixel through the transform.
    pixel: f64,
}

impl Cost {
    const fn of<T: Real>() -> Self {
        if size_of::<T>() == 4 { Self { fused: 1.0, pixel: 0.082 } } else { Self { fused: 1.3, pixel: 0.12 } }
    }
}

/// The route of least estimated cost.
#[inline]
pub(super) fn choose<T: Real, const C: usize>(
    levels: u32,
    source: &PropagationSource<T, C>,
    maps: [AffineMap; 2],
    targets: &Targets,
) -> PropagationRoute {
    let cost = Cost::of::<T>();
    let pixels = pixels::<C>(&cost, [source.side, 1 << levels], maps, targets);
    // What an f64 table loses to small scales is not seen in f32.
    let most = if size_of::<T>() == 4 { 1e6 } else { 16.0 };
    let lookups = match (maps[0].scale() * maps[1].scale()).abs() * most >= 1.0 {
        true => targets.len() as f64 * (66.0 + 21.5 * C as f64),
        false => f64::INFINITY,
    };
    let wavelets = match source.decomposition {
        Decomposition::Standard => two_pass(&cost, levels, source, maps, targets),
        Decomposition::Nonstandard => products(levels, source, maps, targets),
    };
    if wavelets <= pixels.min(lookups) {
        PropagationRoute::Wavelets
    } else if lookups < pixels {
        PropagationRoute::Lookups
    } else {
        PropagationRoute::Pixels
    }
}

/// Weights of the two bands, rows of their sums, the transform, and the choice of the targets.
///
/// Between different sides the first pass combines rows as long as the source, and transforms them.
#[inline(always)]
fn pixels<const C: usize>(cost: &Cost, [from, side]: [usize; 2], maps: [AffineMap; 2], targets: &Targets) -> f64 {
    let (side, from, channels) = (side as f64, from as f64, C as f64);
    let weights = |map: AffineMap| {
        let (s, o) = (map.scale().abs(), map.offset());
        let low = if map.scale() < 0.0 { o - s } else { o };
        // Rows whose cell sees the source, and the weights of each.
        let seen = ((low + s).min(1.0) - low.max(0.0)).max(0.0);
        seen * from + 1.5 * seen / s * side
    };
    let weights = maps.map(weights);
    let rows = from * weights[0] + side * weights[1];
    let pixels = 0.5 * side * (from + side);
    let gather = if targets.chosen.is_some() { 0.5 * targets.len() as f64 } else { 0.0 };
    500.0 + 0.4 * (weights[0] + weights[1]) + channels * (cost.pixel * pixels + 0.32 * cost.fused * rows + gather)
}

/// Couplings of the functions that occur; their products with the terms; the second pass, over all targets or the
/// wanted rows.
#[inline(always)]
fn two_pass<T: Real, const C: usize>(
    cost: &Cost,
    levels: u32,
    source: &PropagationSource<T, C>,
    maps: [AffineMap; 2],
    targets: &Targets,
) -> f64 {
    let (side, channels, terms) = ((1u64 << levels) as f64, C as f64, &source.terms);
    let log = maps.map(log_scale);
    let entries = [0, 1].map(|axis| 3.0 * terms.functions[axis].finer(levels, log[axis]));
    let scatter = 3.0 * terms.by_level.finer(levels, log[0]);
    let functions = (terms.along[0].len() + terms.along[1].len()) as f64;
    let first = 29.0 * functions + 1.7 * (entries[0] + entries[1]);
    let half = channels * (0.65 * scatter + 0.25 * side * terms.along[1].len() as f64);
    let second = match &targets.chosen {
        None => channels * (0.093 * cost.fused * entries[1] * side + 0.026 * side * side),
        Some(chosen) => {
            let (rows, alone) = (chosen.whole_rows as f64, chosen.alone as f64);
            let sums = 0.093 * cost.fused * entries[1] * rows + 0.58 * alone * entries[1] / side;
            3.6 * entries[1] + channels * (sums + 0.5 * targets.len() as f64)
        }
    };
    10.0 + first + half + second
}

/// Term by term, three wavelets a level and axis, and the scaling functions inside.
#[inline(always)]
fn products<T: Real, const C: usize>(
    levels: u32,
    source: &PropagationSource<T, C>,
    maps: [AffineMap; 2],
    targets: &Targets,
) -> f64 {
    let (channels, terms) = (C as f64, &source.terms);
    let log = log_scale(maps[0]).min(log_scale(maps[1]));
    let products = 6.0 * terms.by_level.cells(levels, log) + 15.0 * terms.by_level.finer(levels, log);
    let visits = 32.0 * terms.index.len() as f64 * f64::from(levels);
    visits + (1.9 + 0.1 * channels) * products + 0.14 * channels * targets.len() as f64
}
