//! Projection by random directions, with the error that it makes.

use std::f64::consts::PI;

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, UnitVector3};

use super::function::{accumulate, components};
use super::rows::for_each_slot;
use crate::approx_eq::approx_by_parts;
use crate::sh::Basis;
use crate::sphere::fibonacci_directions;
use crate::{Error, Result};

/// Coefficients of `C` channels and what they may be off by.
#[derive(Debug, Clone, PartialEq)]
pub struct MonteCarlo<const C: usize> {
    /// The estimates, bands² for each channel.
    pub coefficients: [Vec<f64>; C],
    /// The standard error of each, estimated from the spread of 16 independent estimates (and so itself known to 18 %):
    /// the truth is within 2.1 of them with probability 95 % (Student's t, 15 degrees of freedom).
    pub errors: [Vec<f64>; C],
    /// How often the function was called.
    pub samples: usize,
}

/// The independent estimates that a projection consists of.
const ESTIMATES: usize = 16;

/// Projects a function that can only be sampled, such as traced radiance, onto `bands` with an estimate of the error.
///
/// Sixteen Fibonacci lattices of n/16 directions, each turned by a random rotation of its own: every direction is
/// uniformly distributed, so each lattice's estimate is unbiased, and they are independent, so their spread tells the
/// error. A lattice is spread so evenly that the error falls as n^{−3/4} for functions with edges and faster for smooth
/// ones, where random directions have n^{−1/2}.
///
/// `f` is called in parallel (feature `rayon`) and must depend on the direction alone; the result depends on `samples`
/// and `seed` only. A NaN value makes its channel's coefficients NaN.
///
/// # Errors
/// [`Error::OutOfRange`] unless `bands` is in 1…1024 and `samples`, which is rounded up to a multiple of 16, is 1…2³².
///
/// # Example
/// ```
/// let sky = haarmonic::sh::monte_carlo(3, 4096, 7, |d| [d.z.max(0.0)])?;
/// // ∫ max(z, 0) y₀ = √π/2
/// let error = sky.coefficients[0][0] - 0.5 * std::f64::consts::PI.sqrt();
/// assert!(error.abs() < 4.0 * sky.errors[0][0] && sky.errors[0][0] < 1e-3);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn monte_carlo<const C: usize>(
    bands: usize,
    samples: usize,
    seed: u64,
    f: impl Fn(&UnitVector3<f64>) -> [f64; C] + Sync,
) -> Result<MonteCarlo<C>> {
    let basis = Basis::<f64>::new(bands)?;
    if samples == 0 || samples as u64 > 1 << 32 {
        return Err(Error::OutOfRange { what: "samples", got: samples as f64, allowed: "in 1…2³²" });
    }
    let lattice = fibonacci_directions(samples.div_ceil(ESTIMATES));
    let mut estimates: Vec<[Vec<f64>; C]> = vec![std::array::from_fn(|_| Vec::new()); ESTIMATES];
    // What f costs is not known: in parallel.
    for_each_slot(&mut estimates, 1, usize::MAX, |i, estimate| {
        let turn = random_rotation(seed, i as u64);
        let directions: Vec<_> = lattice.iter().map(|d| UnitVector3::new_normalize(turn * d.into_inner())).collect();
        let weight = 4.0 * PI / lattice.len() as f64;
        let mut weights: [Vec<f64>; C] = std::array::from_fn(|_| Vec::with_capacity(directions.len()));
        for d in &directions {
            for (weights, value) in weights.iter_mut().zip(f(d)) {
                weights.push(weight * value);
            }
        }
        estimate[0] = accumulate(&basis, &components(&directions), &weights);
    });
    let over = |channel: usize, statistic: &dyn Fn(&[f64; ESTIMATES]) -> f64| {
        (0..bands * bands).map(|i| statistic(&std::array::from_fn(|e| estimates[e][channel][i]))).collect::<Vec<f64>>()
    };
    let mean = |x: &[f64; ESTIMATES]| x.iter().sum::<f64>() / ESTIMATES as f64;
    let error = |x: &[f64; ESTIMATES]| {
        let squares: f64 = x.iter().map(|v| (v - mean(x)).powi(2)).sum();
        (squares / (ESTIMATES * (ESTIMATES - 1)) as f64).sqrt()
    };
    Ok(MonteCarlo {
        coefficients: std::array::from_fn(|channel| over(channel, &mean)),
        errors: std::array::from_fn(|channel| over(channel, &error)),
        samples: lattice.len() * ESTIMATES,
    })
}

/// A rotation distributed uniformly: a uniform point of the 3-sphere as a quaternion [Shoemake 1992].
fn random_rotation(seed: u64, stream: u64) -> Rotation3<f64> {
    let [a, b, c] = [0, 1, 2].map(|k| uniform(seed, 3 * stream + k));
    let ((s1, c1), (s2, c2)) = ((2.0 * PI * b).sin_cos(), (2.0 * PI * c).sin_cos());
    let (inner, outer) = ((1.0 - a).sqrt(), a.sqrt());
    UnitQuaternion::from_quaternion(Quaternion::new(outer * c2, inner * s1, inner * c1, outer * s2))
        .to_rotation_matrix()
}

/// Number `counter` of a stream on [0, 1): SplitMix64's output function of a counter [Steele et al. 2014].
fn uniform(seed: u64, counter: u64) -> f64 {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    // The seed is mixed first, so that neighbouring seeds share no numbers.
    let bits = mix(mix(seed.wrapping_add(STEP)).wrapping_add(STEP.wrapping_mul(counter + 1)));
    (bits >> 11) as f64 * 2f64.powi(-53)
}

approx_by_parts!(
    [const C: usize] MonteCarlo<C>, f64, |m| close [m.coefficients.concat(), m.errors.concat()] same [m.samples]
);
