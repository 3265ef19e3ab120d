//! Functions on a block from 1, 4 or 16 samples of them.

use crate::Result;
use crate::dct::{BlockDct, LowProjection};

/// Nodes of all levels.
pub(super) const NODES: usize = 1 + 4 + 16;

/// What is taken to lie between the samples of a block.
///
/// A function is sampled at the centres of l × l parts of the block and stands for Σ_j f(node_j) φ_j. The sum over the
/// block of light × visibility × function so is Σ_j f(node_j) G_j with weights G_j = Σ L V φ_j that hold the light
/// alone: the change of basis [Inger 2013, eq. 4] is done when the light changes, not at every vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum SampleBasis {
    /// The l × l lowest cosines of the block, as in the paper. The mirrored continuation of a cosine series has a kink
    /// at the block's edge: 16 coefficients miss a component of direction by .8 % (root mean square, 64²).
    Cosine,
    /// Polynomials of degree l − 1 on each axis through the same samples. A fifth of the error of cosines and less
    /// wherever 16 samples are enough at all (docs/block_product.md).
    #[default]
    Polynomial,
}

/// The nodes and the cardinal functions φ of every level.
#[derive(Debug, Clone)]
pub(super) struct Interpolation {
    levels: [Level; 3],
}

#[derive(Debug, Clone)]
pub(super) struct Level {
    /// (x, y) of each node, in pixels from the centre of the block's first.
    pub(super) nodes: Vec<[f64; 2]>,
    /// [node][pixel], pixels row after row.
    pub(super) cardinals: Vec<Vec<f64>>,
}

impl Interpolation {
    pub(super) fn new(side: usize, basis: SampleBasis) -> Result<Self> {
        let level = |low: usize| -> Result<Level> {
            let plan = LowProjection::<f64>::centres(side, low)?;
            let at = plan.positions();
            let nodes = (0..low * low).map(|j| [at[j % low], at[j / low]]).collect();
            let cardinals = match basis {
                SampleBasis::Cosine => cosines(side, &plan)?,
                SampleBasis::Polynomial => polynomials(side, at),
            };
            Ok(Level { nodes, cardinals })
        };
        Ok(Self { levels: [level(1)?, level(2)?, level(4)?] })
    }

    pub(super) fn levels(&self) -> &[Level; 3] {
        &self.levels
    }
}

/// What one sample of 1 becomes.
fn cosines(side: usize, plan: &LowProjection<f64>) -> Result<Vec<Vec<f64>>> {
    let (low, dct) = (plan.low(), BlockDct::<f64>::new(side)?);
    let cardinal = |node: usize| {
        let mut samples = vec![0.0; low * low];
        samples[node] = 1.0;
        let (mut coefs, mut block) = (samples.clone(), vec![0.0; side * side]);
        plan.project(&samples, &mut coefs);
        dct.inverse_low(low, &coefs, &mut block);
        block
    };
    Ok((0..low * low).map(cardinal).collect())
}

/// Products of Lagrange's polynomials.
fn polynomials(side: usize, at: &[f64]) -> Vec<Vec<f64>> {
    let lagrange = |j: usize, x: usize| -> f64 {
        (0..at.len()).filter(|&k| k != j).map(|k| (x as f64 - at[k]) / (at[j] - at[k])).product()
    };
    let low = at.len();
    let cardinal = |node: usize| {
        let (v, u) = (node / low, node % low);
        (0..side * side).map(|p| lagrange(u, p % side) * lagrange(v, p / side)).collect()
    };
    (0..low * low).map(cardinal).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::block_product::BlockLayout;
    use crate::compress::ScanOrder;
    use crate::sphere::CubeGrid;

    #[test]
    fn what_a_basis_holds_it_gives_back() {
        for side in [8, 16, 32] {
            for basis in [SampleBasis::Cosine, SampleBasis::Polynomial] {
                let plan = Interpolation::new(side, basis).unwrap();
                for (level, low) in plan.levels().iter().zip([1, 2, 4]) {
                    let function = |x: f64, y: f64| match basis {
                        SampleBasis::Polynomial => (0.3 + x / 7.0).powi(low - 1) * (1.0 - y / 9.0).powi(low - 1),
                        SampleBasis::Cosine => {
                            let cosine = |x: f64| {
                                ((2.0 * x + 1.0) * f64::from(low - 1) * std::f64::consts::PI / (2 * side) as f64).cos()
                            };
                            cosine(x) * (0.5 + cosine(y))
                        }
                    };
                    for p in 0..side * side {
                        let terms = level.nodes.iter().zip(&level.cardinals).map(|(n, c)| function(n[0], n[1]) * c[p]);
                        let (value, scale) = terms.fold((0.0, 1.0), |(v, s), t| (v + t, s + t.abs()));
                        let exact = function((p % side) as f64, (p / side) as f64);
                        // Rounding of the cardinal functions and of the sum.
                        assert!(
                            (value - exact).abs() < 16.0 * f64::EPSILON * scale,
                            "{side} {basis:?} {low}: {value} {exact}"
                        );
                    }
                }
            }
        }
    }

    /// Root mean square over a block of what 16 samples miss of a function of direction.
    fn missed(basis: SampleBasis, f: impl Fn(&nalgebra::Vector3<f64>) -> f64) -> f64 {
        let layout = BlockLayout::new(CubeGrid::new(64).unwrap(), 16, ScanOrder::RowMajor).unwrap();
        let plan = Interpolation::new(16, basis).unwrap();
        let level = &plan.levels()[2];
        let at = |x: f64, y: f64| f(&layout.direction(5, x, y));
        let error = |p: usize| {
            let guess: f64 = level.nodes.iter().zip(&level.cardinals).map(|(n, c)| at(n[0], n[1]) * c[p]).sum();
            at((p % 16) as f64, (p / 16) as f64) - guess
        };
        ((0..256).map(|p| error(p).powi(2)).sum::<f64>() / 256.0).sqrt()
    }

    /// The figures of docs/block_product.md.
    #[test]
    fn polynomials_are_better_where_sixteen_samples_are_enough() {
        let layout = BlockLayout::new(CubeGrid::new(64).unwrap(), 16, ScanOrder::RowMajor).unwrap();
        let centre = layout.centre(5);
        let both = |f: &dyn Fn(&nalgebra::Vector3<f64>) -> f64| {
            [SampleBasis::Cosine, SampleBasis::Polynomial].map(|b| missed(b, f))
        };
        let side = both(&|d| d.y);
        let broad = both(&|d| centre.dot(d).powi(10));
        let sharp = both(&|d| centre.dot(d).powi(200));
        // Measured 7.9e-3, 1.0e-4; 2.3e-2, 4.5e-3; 6.1e-2, 1.4e-1.
        assert!(side[0] > 50.0 * side[1] && side[0] < 0.02, "{side:?}");
        assert!(broad[0] > 4.0 * broad[1] && broad[0] < 0.04, "{broad:?}");
        assert!(sharp[1] > 2.0 * sharp[0] && sharp[1] < 0.25, "{sharp:?}");
    }
}
