//! Nodes in z of quadrature on the sphere, in pairs z and −z, and what the harmonics are there.
//!
//! On a circle of constant z an expansion is Σ_m α_m e^{imφ} with α_m = c_m − i s_m, α_{−m} its conjugate, and
//!
//! ```math
//! c_0 = Σ_l N P_l a_l0,   c_m, s_m = 1/√2 Σ_l N P_lm a_{l,±m};
//! ```
//!
//! and from the same of a function h its coefficients are Σ_z w 2π N P_l c_0 and Σ_z w 2√2 π N P_lm {c, s}_m.

use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use nalgebra::Vector3;

use crate::Result;
use crate::numeric::{GaussLegendre, LegendreSteps};
use crate::sh::eval;

/// A rule for even polynomials in z on [−1, 1].
pub(super) struct Rule {
    /// (z, weight at each of z and −z), z ≥ 0. The equator comes as a pair like any other, of half its weight.
    pub pairs: Vec<[f64; 2]>,
    /// The weight of each of the ends ±1, 0 if they are no nodes.
    pub poles: f64,
}

impl Rule {
    /// Gauss' rule for degrees up to `degree`.
    pub fn gauss(degree: usize) -> Result<Self> {
        // Odd polynomials integrate to 0 by symmetry.
        let even = degree & !1;
        let rule = GaussLegendre::new(even / 2 + 1)?;
        let mut pairs: Vec<[f64; 2]> = rule.nodes().iter().zip(rule.weights()).map(|(z, w)| [*z, *w]).collect();
        pairs.drain(..pairs.len() / 2);
        if pairs[0][0] == 0.0 {
            pairs[0][1] *= 0.5;
        }
        Ok(Self { pairs, poles: 0.0 })
    }

    /// Lobatto's rule, which has the poles among its nodes: there only m = 0 lives, so that they cost next to nothing.
    ///
    /// With k nodes the inner ones are the zeros of P_{k−1}′ and every weight is 2/(k(k−1) P_{k−1}²); exact up to
    /// degree 2k − 3                                                                  [Abramowitz & Stegun 25.4.32]
    pub fn lobatto(degree: usize) -> Self {
        let even = degree & !1;
        let count = (even + 3).div_ceil(2).max(2);
        let n = (count - 1) as f64;
        let weight = |value: f64| 2.0 / (n * (n + 1.0) * value * value);
        let pairs = (1..=(count - 1) / 2).map(|i| {
            // From the extrema of the cosine that is like it; P″ by Legendre's equation.
            let mut z = (PI * i as f64 / n).cos();
            for _ in 0..20 {
                let (value, slope) = legendre(count - 1, z);
                z -= slope * (1.0 - z * z) / (2.0 * z * slope - n * (n + 1.0) * value);
            }
            let middle = 2 * i == count - 1;
            let z = if middle { 0.0 } else { z };
            [z, weight(legendre(count - 1, z).0) * if middle { 0.5 } else { 1.0 }]
        });
        Self { pairs: pairs.collect(), poles: weight(1.0) }
    }
}

/// P_n and its derivative.
fn legendre(n: usize, z: f64) -> (f64, f64) {
    let mut steps = LegendreSteps::new(z);
    (0..n).for_each(|_| steps.advance());
    (steps.value(), steps.slope())
}

/// N P_lm(z) for m = 0…, l = m…bands − 1, one m after the other, without Condon–Shortley sign or √2: the harmonics at
/// φ = 0.
pub(super) fn normalized_legendre(bands: usize, z: f64) -> Result<Vec<f64>> {
    let values = eval(bands, &Vector3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z))?;
    let orders = (0..bands).flat_map(|m| (m..bands).map(move |l| (l, m)));
    Ok(orders.map(|(l, m)| values[l * (l + 1) + m] * if m == 0 { 1.0 } else { FRAC_1_SQRT_2 }).collect())
}

/// Factors of N P_lm to evaluate and, at weight `weight`, to project.
pub(super) fn factors(m: usize, weight: f64) -> [f64; 2] {
    if m == 0 { [1.0, 2.0 * PI * weight] } else { [FRAC_1_SQRT_2, 2.0 * SQRT_2 * PI * weight] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_even_monomials() {
        for degree in 0..40 {
            for rule in [Rule::gauss(degree).unwrap(), Rule::lobatto(degree)] {
                for power in (0..=degree as i32).step_by(2) {
                    let sum: f64 =
                        rule.pairs.iter().map(|[z, w]| 2.0 * w * z.powi(power)).sum::<f64>() + 2.0 * rule.poles;
                    let want = 2.0 / f64::from(power + 1);
                    assert!((sum - want).abs() < 2e-15, "degree {degree}, power {power}: {sum} against {want}");
                }
            }
        }
    }

    #[test]
    fn few_nodes_suffice() {
        assert_eq!(Rule::gauss(15).unwrap().pairs.len(), 4);
        assert_eq!(Rule::lobatto(21).pairs.len(), 5);
    }
}
