//! A BRDF's expansion by brute force.

use std::f64::consts::PI;

use nalgebra::{UnitVector3, Vector3};

use crate::reference::sh::basis;

/// ∫ f(ω) max(cos θ, 0) y_i(ω) dω, all i of `bands`, and ∫ (f max(cos θ, 0))² last: the middles of `steps` × 4 `steps`
/// patches of the hemisphere in its two angles.
///
/// The error falls as 1/steps² of a smooth f.
pub fn brdf_expansion(bands: usize, steps: usize, f: impl Fn(&Vector3<f64>) -> f64) -> (Vec<f64>, f64) {
    let (mut sums, mut energy) = (vec![0.0; bands * bands], 0.0);
    for i in 0..steps {
        let (sin, cos) = (0.5 * PI * (i as f64 + 0.5) / steps as f64).sin_cos();
        for k in 0..4 * steps {
            let azimuth = 0.5 * PI * (k as f64 + 0.3) / steps as f64;
            let direction = Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
            let patch = sin * (0.5 * PI / steps as f64).powi(2);
            let value = f(&direction) * cos;
            energy += patch * value * value;
            let y = basis(bands, &UnitVector3::new_normalize(direction));
            sums.iter_mut().zip(y).for_each(|(sum, y)| *sum += patch * value * y);
        }
    }
    (sums, energy)
}
