//! One of two densities, by lot.

use nalgebra::Vector3;

use super::{DirectionSample, DirectionSampler};
use crate::{Error, Result};

/// A density that is a share of one density and the rest of another: multiple importance sampling.
///
/// ```math
/// p = (1 − share) p_first + share p_second
/// ```
///
/// Dividing by p is the balance heuristic [Veach & Guibas 1995]. The first uniform number chooses, and what is left of
/// it is stretched: of n stratified numbers, share · n go to the second density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixture<A, B> {
    first: A,
    second: B,
    share: f64,
}

impl<A: DirectionSampler, B: DirectionSampler> Mixture<A, B> {
    /// The mixture in which the second density has a share.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the share is in [0, 1].
    pub fn new(first: A, second: B, share: f64) -> Result<Self> {
        check_share(share)?;
        Ok(Self::unchecked(first, second, share))
    }

    pub(super) fn unchecked(first: A, second: B, share: f64) -> Self {
        Self { first, second, share }
    }

    /// The first density.
    pub fn first(&self) -> &A {
        &self.first
    }

    /// The second density.
    pub fn second(&self) -> &B {
        &self.second
    }

    /// The share of the second density.
    pub fn share(&self) -> f64 {
        self.share
    }
}

pub(super) fn check_share(share: f64) -> Result<()> {
    if (0.0..=1.0).contains(&share) {
        Ok(())
    } else {
        Err(Error::OutOfRange { what: "share of a mixture", got: share, allowed: "in [0, 1]" })
    }
}

impl<A: DirectionSampler, B: DirectionSampler> DirectionSampler for Mixture<A, B> {
    fn sample(&self, [u, v]: [f64; 2]) -> Option<DirectionSample> {
        let below_one = |u: f64| u.min(1.0_f64.next_down());
        let share = self.share;
        // A density that has all of the share is itself, to the last bit.
        if u < share {
            let sample = self.second.sample([below_one(u / share), v])?;
            let other = if share < 1.0 { (1.0 - share) * self.first.pdf(&sample.direction) } else { 0.0 };
            Some(DirectionSample { pdf: share * sample.pdf + other, ..sample })
        } else {
            let sample = self.first.sample([below_one((u - share) / (1.0 - share)), v])?;
            let other = if share > 0.0 { share * self.second.pdf(&sample.direction) } else { 0.0 };
            Some(DirectionSample { pdf: (1.0 - share) * sample.pdf + other, ..sample })
        }
    }

    fn pdf(&self, direction: &Vector3<f64>) -> f64 {
        let part = |share: f64, pdf: &dyn Fn() -> f64| if share > 0.0 { share * pdf() } else { 0.0 };
        part(1.0 - self.share, &|| self.first.pdf(direction)) + part(self.share, &|| self.second.pdf(direction))
    }
}
