//! Integrals along great-circle arcs, and what becomes of them.

use nalgebra::Vector3;

use super::Nodes;
use super::outline::Outline;
use crate::Result;
use crate::numeric::GaussLegendre;

/// Gauss–Legendre rules of 2, 3, … nodes, each with the frequency up to which it is exact to rounding.
#[derive(Debug, Clone)]
pub(super) struct ArcRules {
    degree: f64,
    rules: Vec<Rule>,
}

#[derive(Debug, Clone)]
struct Rule {
    /// The largest κ for which e^{iκx} over [−1, 1] is integrated to 1e-17.
    reach: f64,
    rule: GaussLegendre,
}

impl ArcRules {
    /// Rules for trigonometric polynomials of `degree` on arcs up to half a circle.
    ///
    /// The error of N nodes is at most κ^{2N} 2^{2N+1} N!⁴ / ((2N+1) (2N)!³) for e^{iκx}, κ = degree · half the length.
    pub(super) fn new(degree: usize) -> Result<Self> {
        let farthest = degree as f64 * std::f64::consts::FRAC_PI_2;
        let mut rules = Vec::new();
        // ln N! and ln (2N)!, N = 1.
        let (mut single, mut double) = (0.0, 2f64.ln());
        for n in 2usize.. {
            let x = n as f64;
            single += x.ln();
            double += (2.0 * x * (2.0 * x - 1.0)).ln();
            let bound = (2.0 * x + 1.0) * 2f64.ln() + 4.0 * single - (2.0 * x + 1.0).ln() - 3.0 * double;
            let reach = ((1e-17f64.ln() - bound) / (2.0 * x)).exp();
            rules.push(Rule { reach, rule: GaussLegendre::new(n)? });
            if reach >= farthest {
                break;
            }
        }
        Ok(Self { degree: degree as f64, rules })
    }

    /// Nodes of the largest rule.
    pub(super) fn largest(&self) -> usize {
        self.rules.len() + 1
    }

    fn of(&self, half: f64) -> &GaussLegendre {
        let kappa = self.degree * half;
        let at = self.rules.partition_point(|r| r.reach < kappa);
        &self.rules[at.min(self.rules.len() - 1)].rule
    }
}

/// The nodes of all arcs, weighted by the components of p; returns the moment ∫ ω dω = ½ Σ p · length [Lambert].
pub(super) fn push_nodes(rules: &ArcRules, outline: &Outline, nodes: &mut Nodes) -> Vector3<f64> {
    let mut moment = Vector3::zeros();
    for (a, b) in outline.arcs() {
        // Not a × b: of vertices close together the difference is exact.
        let cross = a.cross(&(b - a));
        let sine = cross.norm();
        if sine == 0.0 {
            continue;
        }
        let half = 0.5 * sine.atan2(a.dot(&b));
        let p = cross / sine;
        let start = a / a.norm();
        let (sin, cos) = sin_cos(half);
        let middle = start * cos + p.cross(&start) * sin;
        let along = p.cross(&middle);
        moment += p * half;
        let rule = rules.of(half);
        for (x, w) in rule.nodes().iter().zip(rule.weights()) {
            let (sin, cos) = sin_cos(half * x);
            nodes.push((middle * cos + along * sin).into(), (p * (half * w)).into());
        }
    }
    moment
}

/// Sine and cosine of |t| ≤ π/2, by Taylor: 1e-16, the same bits on every machine.
#[inline(always)]
fn sin_cos(t: f64) -> (f64, f64) {
    /// (2k)! and (2k+1)! below each other, from the highest power.
    const TERMS: usize = 12;
    let square = t * t;
    let (mut sin, mut cos) = (1.0, 1.0);
    for k in (1..TERMS).rev() {
        let k = k as f64;
        sin = 1.0 - square / (2.0 * k * (2.0 * k + 1.0)) * sin;
        cos = 1.0 - square / (2.0 * k * (2.0 * k - 1.0)) * cos;
    }
    (t * sin, cos)
}

/// ∇(r^l y_lm)/(l(l+1)) in the y of degree l − 1.
///
/// With U = C + iS the solid harmonics of m > 0 (C at +m, S at −m), U_0 = √2 y_0 and k² = (2l+1)/(2l−1):
///
/// ```text
/// (∂_x − i∂_y) U_lm = k √((l+m)(l+m−1)) U_{l−1,m−1},  (∂_x + i∂_y) U_lm = −k √((l−m)(l−m−1)) U_{l−1,m+1}
/// ∂_z U_lm = k √(l² − m²) U_{l−1,m}
/// ```
#[derive(Debug, Clone)]
pub(super) struct Coupling {
    /// Of m − 1, m + 1 and m, for l = 1…, m = 0…l.
    terms: Vec<[f64; 3]>,
}

impl Coupling {
    pub(super) fn new(bands: usize) -> Self {
        let mut terms = Vec::new();
        for l in 1..bands {
            for m in 0..=l {
                let (lf, mf) = (l as f64, m as f64);
                let k = ((2.0 * lf + 1.0) / (2.0 * lf - 1.0)).sqrt() / (lf * (lf + 1.0));
                let down = 0.5 * k * ((lf + mf) * (lf + mf - 1.0)).sqrt();
                let up = 0.5 * k * ((lf - mf) * (lf - mf - 1.0)).sqrt();
                let root = std::f64::consts::SQRT_2;
                let ends = match m {
                    // Both neighbours of m = 0 are U_1 or its conjugate.
                    0 => [0.0, root * up],
                    1 => [root * down, up],
                    _ => [down, up],
                };
                terms.push([ends[0], ends[1], k * ((lf - mf) * (lf + mf)).sqrt()]);
            }
        }
        Self { terms }
    }

    /// Degrees from 1 of `out`, from `sums[i][k]` = Σ p_k ∫ y_i.
    pub(super) fn apply(&self, sums: &[[f64; 3]], out: &mut [f64]) {
        let mut terms = self.terms.iter();
        let bands = out.len().isqrt();
        for l in 1..bands {
            let (centre, below) = (l * (l + 1), l * (l - 1));
            let largest = l - 1;
            for m in 0..=l {
                let [down, up, level] = *terms.next().expect("one a coefficient");
                // (C, S) of degree l − 1.
                let at = |m: usize| -> [[f64; 3]; 2] {
                    match m {
                        m if m > largest => [[0.0; 3]; 2],
                        0 => [sums[below], [0.0; 3]],
                        m => [sums[below + m], sums[below - m]],
                    }
                };
                let [c, s] = at(m);
                let [cu, su] = at(m + 1);
                if m == 0 {
                    out[centre] = level * c[2] - up * (cu[0] + su[1]);
                    continue;
                }
                let [cd, sd] = at(m - 1);
                out[centre + m] = down * (cd[0] - sd[1]) - up * (cu[0] + su[1]) + level * c[2];
                out[centre - m] = down * (sd[0] + cd[1]) - up * (su[0] - cu[1]) + level * s[2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::Basis;
    use crate::sphere::fibonacci_directions;

    #[test]
    fn coupling_is_the_gradient_across_an_arc() {
        const BANDS: usize = 12;
        let basis = Basis::<f64>::new(BANDS).unwrap();
        let mut values = vec![0.0; BANDS * BANDS];
        let mut gradients = vec![Vector3::zeros(); BANDS * BANDS];
        for (i, d) in fibonacci_directions(20).iter().enumerate() {
            let p = d.cross(&Vector3::new(0.3, i as f64, -1.0)).normalize();
            basis.gradient(d, &mut values, &mut gradients);
            let sums: Vec<[f64; 3]> = values.iter().map(|y| (p * *y).into()).collect();
            let mut got = vec![0.0; BANDS * BANDS];
            Coupling::new(BANDS).apply(&sums, &mut got);
            for l in 1..BANDS {
                for index in l * l..(l + 1) * (l + 1) {
                    let want = gradients[index].dot(&p) / (l * (l + 1)) as f64;
                    assert!((got[index] - want).abs() < 2e-15, "{index}: {} {want}", got[index]);
                }
            }
        }
    }

    #[test]
    fn rules_reach_as_far_as_they_say() {
        for rule in ArcRules::new(80).unwrap().rules {
            let kappa = rule.reach;
            let got = rule.rule.integrate(-1.0, 1.0, |x| (kappa * x).cos());
            assert!((got - 2.0 * kappa.sin() / kappa).abs() < 2e-14, "{}", rule.rule.nodes().len());
        }
        // And not much farther: a tenth of the nodes less is not enough.
        let rules = ArcRules::new(80).unwrap();
        let farthest = 40.0 * std::f64::consts::PI;
        let fewer = GaussLegendre::new(rules.largest() * 8 / 10).unwrap();
        let off = fewer.integrate(-1.0, 1.0, |x| (farthest * x).cos()) - 2.0 * farthest.sin() / farthest;
        assert!(off.abs() > 1e-13, "{off:e}");
    }

    #[test]
    fn taylor_is_sine_and_cosine() {
        for i in -200..=200 {
            let t = f64::from(i) / 200.0 * std::f64::consts::FRAC_PI_2;
            let ((sin, cos), want) = (sin_cos(t), t.sin_cos());
            assert!((sin - want.0).abs() < 2.3e-16 && (cos - want.1).abs() < 2.3e-16, "{t}");
        }
    }
}
