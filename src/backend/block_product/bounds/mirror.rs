//! Errors of lobes about the mirror direction.

use nalgebra::Vector3;

use super::errors::{Checks, Codes, Errors};
use super::gauge::Gauge;
use super::{cell_of, half_sine};
use crate::backend::block_product::rule::SampleClass;
use crate::parallel;

/// Errors for lobes about the mirror direction, over sin(θ/2) of the angle θ between it and a block's centre.
#[derive(Debug, Clone)]
pub(in crate::backend::block_product) struct MirrorBounds {
    cells: Vec<Codes>,
    /// [cell]: the largest errors of no sample from there on outwards.
    beyond: Vec<Codes>,
}

/// Cells of a [`MirrorBounds`].
const MIRROR_CELLS: usize = 128;

impl MirrorBounds {
    /// Errors of max(cos, 0)^n at the edges of the cells.
    pub(in crate::backend::block_product) fn edges(gauge: &Gauge, exponent: f64) -> Vec<Errors> {
        let edge = |i: usize| {
            let theta = 2.0 * (i as f64 / MIRROR_CELLS as f64).min(1.0).asin();
            let azimuths = (0..4).map(|k| (k as f64 * 0.5 + 0.25) * std::f64::consts::FRAC_PI_2);
            let mut most = Errors::default();
            for azimuth in azimuths {
                let (s, c) = theta.sin_cos();
                let mirror = Vector3::new(s * azimuth.cos(), s * azimuth.sin(), c);
                for shape in &gauge.shapes {
                    let lobe =
                        |d: &Vector3<f64>| d * mirror.dot(d).max(0.0).powf(exponent) * f64::from(mirror.dot(d) > 0.0);
                    most = most.worst(gauge.errors(shape, lobe));
                }
            }
            // From here to the next edge towards the mirror direction.
            let before = 2.0 * ((i as f64 - 1.0) / MIRROR_CELLS as f64).max(0.0).asin();
            let nearest = (before - gauge.radius).max(0.0).cos();
            most.with_a_pixel_of(if nearest > 0.0 { nearest.powf(exponent) } else { 0.0 }, gauge.side)
        };
        parallel::map(MIRROR_CELLS + 1, edge)
    }

    /// The worse of two exponents' errors, and of a cell's two edges.
    pub(in crate::backend::block_product) fn between(low: &[Errors], high: &[Errors]) -> Self {
        let both = |i: usize| low[i].worst(high[i]);
        let cells: Vec<Codes> = (0..MIRROR_CELLS).map(|i| Codes::new(both(i).worst(both(i + 1)))).collect();
        let mut beyond = cells.clone();
        for i in (1..MIRROR_CELLS).rev() {
            beyond[i - 1] = beyond[i - 1].worse(beyond[i]);
        }
        Self { cells, beyond }
    }

    /// The errors of a block whose centre has this cosine to the mirror direction.
    #[inline(always)]
    pub(in crate::backend::block_product) fn codes(&self, cosine: f32) -> &Codes {
        &self.cells[cell_of(half_sine(cosine), MIRROR_CELLS)]
    }

    /// A cosine to the mirror direction below which blocks need no sample; above 1 if none does.
    pub(in crate::backend::block_product) fn reach(&self, checks: &Checks) -> f32 {
        let is_free_of =
            |codes: &Codes| [true, false].iter().all(|&free| codes.class(checks, free) == SampleClass::NONE);
        match self.beyond.partition_point(|codes| !is_free_of(codes)) {
            0 => 2.0,
            MIRROR_CELLS => -2.0,
            // The inner edge of the first cell without, and what the cosine's rounding can be off.
            cell => 1.0 - 2.0 * (cell as f32 / MIRROR_CELLS as f32).powi(2) - 1e-6,
        }
    }
}
