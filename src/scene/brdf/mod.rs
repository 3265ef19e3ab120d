//! Reflectance.

use std::fmt::Debug;

use nalgebra::Vector3;

/// A bidirectional reflectance distribution function in a vertex's local frame (+z is the normal, +x the tangent).
///
/// `wi` and `wo` are unit and point away from the surface.
pub trait Brdf: Debug + Send + Sync {
    /// f(wi, wo) in RGB, 1/sr, without the cosine; zero unless both directions are above the horizon (z > 0).
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64>;

    /// The colour c, largest component 1, if f(wi, wo) = c · s(wi, wo) with one scalar s for all channels.
    ///
    /// Back ends then integrate one channel instead of three.
    fn colour(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Whether f does not depend on `wo`.
    fn is_view_independent(&self) -> bool {
        false
    }
}
