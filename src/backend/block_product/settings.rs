//! What a user chooses.

use super::interpolation::SampleBasis;
use super::rule::Rule;

/// How a [`Relighter`](super::Relighter) integrates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// What chooses the number of samples of a block.
    pub rule: Rule,
    /// What lies between samples.
    pub basis: SampleBasis,
}
