//! The grids of parameters on which the errors of lobes are tabulated.

use nalgebra::Vector3;

use super::bounds::Symmetry;
use crate::scene::Shape;

/// A cell of the parameters of lobes about the half vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Parameters {
    /// Exponents or roughnesses.
    lowest: [i32; 2],
    highest: [i32; 2],
    /// Reflectances at normal incidence, of the channels' least and largest: the lobe is linear in them, so that a norm
    /// of its error is largest at an end.
    f0: [i32; 2],
    symmetry: Symmetry,
}

/// A corner of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    across: [i32; 2],
    f0: i32,
    pub(super) symmetry: Symmetry,
}

impl Corner {
    /// A shape of the kind of `like` with the parameters of this corner.
    pub(super) fn shape(&self, like: Shape) -> Shape {
        let [u, v] = self.across;
        match like {
            Shape::Cosine => Shape::Cosine,
            Shape::Mirror { .. } => Shape::Mirror { exponent: exponent_at(u) },
            Shape::Half { .. } => Shape::Half { exponent: exponent_at(u) },
            Shape::Microfacets { .. } => Shape::Microfacets {
                alpha: [u, v].map(|index| alpha_at(index, self.symmetry)),
                f0: Vector3::repeat(f0_at(self.f0)),
            },
        }
    }
}

impl Parameters {
    /// The cell that a shape lies in: eighths of an octave of exponents; sixteenths of roughnesses, quarters if
    /// anisotropic.
    pub(super) fn of(shape: Shape) -> Self {
        match shape {
            Shape::Cosine => Self { lowest: [0; 2], highest: [0; 2], f0: [0; 2], symmetry: Symmetry::Turned },
            Shape::Mirror { exponent } | Shape::Half { exponent } => {
                let at = exponent_index(exponent);
                Self { lowest: [at; 2], highest: [at + 1; 2], f0: [0; 2], symmetry: Symmetry::Turned }
            }
            Shape::Microfacets { alpha, f0 } => {
                let symmetry = if alpha[0] == alpha[1] { Symmetry::Turned } else { Symmetry::Mirrored };
                let end = |round: fn(f64) -> f64| alpha.map(|alpha| round(alpha.log2() * steps(symmetry)) as i32);
                let f0 = [f0_index(f0.min(), f64::floor), f0_index(f0.max(), f64::ceil)];
                Self { lowest: end(f64::floor), highest: end(f64::ceil), f0, symmetry }
            }
        }
    }

    pub(super) fn corners(self) -> Vec<Corner> {
        let Self { lowest, highest, symmetry, .. } = self;
        let mut across: Vec<[i32; 2]> = match symmetry {
            Symmetry::Turned => vec![lowest, highest],
            _ => [lowest[0], highest[0]].iter().flat_map(|&u| [[u, lowest[1]], [u, highest[1]]]).collect(),
        };
        let mut f0 = self.f0.to_vec();
        across.sort_unstable();
        across.dedup();
        f0.dedup();
        across.iter().flat_map(|&across| f0.iter().map(move |&f0| Corner { across, f0, symmetry })).collect()
    }
}

/// Reflectances 0, 2⁻⁸, … 2^(−1/2), 1.
fn f0_at(index: i32) -> f64 {
    if index < LEAST_F0 { 0.0 } else { (f64::from(index) / 2.0).exp2() }
}

fn f0_index(f0: f64, round: fn(f64) -> f64) -> i32 {
    (round(f0.log2() * 2.0)).max(f64::from(LEAST_F0 - 1)) as i32
}

const LEAST_F0: i32 = -16;

/// Exponents 0, 1/8, …, 1, 2^(1/8), 2^(2/8), ….
pub(super) fn exponent_at(index: i32) -> f64 {
    if index <= 8 { f64::from(index.max(0)) / 8.0 } else { (f64::from(index - 8) / 8.0).exp2() }.min(1e7)
}

pub(super) fn exponent_index(exponent: f64) -> i32 {
    if exponent < 1.0 { (exponent * 8.0) as i32 } else { 8 + (exponent.log2() * 8.0).floor() as i32 }
}

/// Roughnesses of a grid, per octave.
fn steps(symmetry: Symmetry) -> f64 {
    if symmetry == Symmetry::Turned { 16.0 } else { 4.0 }
}

/// Roughnesses 2^(k/steps) in [1e-4, 1].
fn alpha_at(index: i32, symmetry: Symmetry) -> f64 {
    (f64::from(index) / steps(symmetry)).exp2().clamp(1e-4, 1.0)
}
