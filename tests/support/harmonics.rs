//! Expansions in spherical harmonics.

use haarmonic::sh::degree_order;

/// No zeros, no pattern, decaying with the degree.
pub fn coefficients(bands: usize) -> Vec<f64> {
    (0..bands * bands).map(|i| (1.0 + 2.3 * i as f64).sin() / (1.0 + degree_order(i).0 as f64)).collect()
}
