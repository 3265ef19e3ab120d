//! Affine maps, and one-sided slopes of functions of them.

use haarmonic::affine::AffineMap;

#[track_caller]
pub fn map(s: f64, o: f64) -> AffineMap {
    AffineMap::new(s, o).unwrap()
}

/// The right-hand derivative of `f` at 0 of a function that is a + b/(1 + x) without kinks within the step; good to
/// O(h²) + O(ε/h).
fn right_slope(f: impl Fn(f64) -> f64) -> f64 {
    let step = 2f64.powi(-20);
    let difference = |h: f64| (f(h) - f(0.0)) / h;
    2.0 * difference(step / 2.0) - difference(step)
}

/// [∂/∂s, ∂/∂o], right-hand, of a function of a map.
pub fn right_gradient(at: AffineMap, f: impl Fn(AffineMap) -> f64) -> [f64; 2] {
    let moved = |ds: f64, d_o: f64| map(at.scale() + ds, at.offset() + d_o);
    [right_slope(|h| f(moved(h, 0.0))), right_slope(|h| f(moved(0.0, h)))]
}

/// Maps of moderate scale whose kinks the differences do not step over: of few binary places, or of none in common with
/// a cell.
#[cfg(feature = "proptest")]
pub fn differentiable() -> impl proptest::prelude::Strategy<Value = AffineMap> {
    use proptest::prelude::*;
    let generic = [map(0.713, 0.2), map(-1.3719, 1.2113), map(2.613, -0.737), map(-0.5471, 0.7)];
    prop_oneof![haarmonic::strategies::dyadic_map(), prop::sample::select(generic.to_vec())]
        .prop_filter("a moderate scale", |map| (0.2..8.0).contains(&map.scale().abs()) && map.offset().abs() < 8.0)
}
