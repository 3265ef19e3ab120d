//! Importance sampling of a near light: densities against their twin and themselves, estimates against ground truth.

mod density;
mod edges;
mod estimates;
mod statistics;

use std::sync::Arc;

use haarmonic::backend::near_field::{PlanarLight, ShadingPoint};
use haarmonic::nalgebra::{Unit, Vector3};
use haarmonic::scene::{Brdf, Lambert, LocalFrame, Phong, Sum, Ward};

use crate::support::noise;

/// The frame that lights lie across.
fn up() -> LocalFrame {
    LocalFrame { tangent: Vector3::x(), bitangent: -Vector3::z(), normal: Vector3::y() }
}

/// Discs of colour on black, `side`² texels, 1 × 0.7 wide and `height` above the origin.
fn discs(side: usize, height: f64) -> PlanarLight {
    let texel = |i: usize| {
        let at = |i: usize| (i as f32 + 0.5) / side as f32;
        let (x, y) = (at(i % side), at(i / side));
        let disc = |cx: f32, cy: f32, r: f32| if (x - cx).hypot(y - cy) < r { 1.0 } else { 0.0 };
        let (warm, cold) = (disc(0.3, 0.35, 0.22), disc(0.75, 0.65, 0.2));
        Vector3::new(8.0 * warm, 4.0 * warm + cold, warm + 5.0 * cold) + Vector3::repeat(0.05 * noise(i) as f32)
    };
    PlanarLight::new(Vector3::new(0.2, height, -0.1), [1.0, 0.7], side, (0..side * side).map(texel).collect()).unwrap()
}

fn frame(normal: [f64; 3]) -> LocalFrame {
    LocalFrame::around(&Unit::new_normalize(Vector3::from(normal)))
}

/// A surface at a place whose viewer stands where the mirror image of `target` is, a little aside.
fn point(position: [f64; 3], normal: [f64; 3], target: [f64; 3]) -> ShadingPoint {
    let (position, frame) = (Vector3::from(position), frame(normal));
    let local = frame.to_local(&(Vector3::from(target) - position).normalize());
    let wo = Vector3::new(-local.x + 0.1, -local.y, local.z).normalize();
    ShadingPoint { position, frame, wo: frame.to_world(&wo) }
}

fn points() -> [ShadingPoint; 4] {
    [
        point([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, -0.2]),
        point([0.9, 0.1, 0.4], [0.2, 1.0, -0.3], [0.4, 1.0, -0.1]),
        // The horizon runs through the light.
        point([-0.3, 0.2, 0.1], [1.0, 0.3, 0.2], [0.5, 1.0, 0.0]),
        // Far aside: the light is seen at a grazing angle, outside the face.
        point([7.0, 0.0, 0.5], [-0.5, 1.0, 0.1], [0.3, 1.0, -0.1]),
    ]
}

fn gold() -> Sum {
    let terms: Vec<(f64, Arc<dyn Brdf>)> = vec![
        (1.0, Arc::new(Phong::new([0.7, 0.5, 0.2], 40.0).unwrap())),
        (1.0, Arc::new(Lambert::new([0.2, 0.15, 0.05]).unwrap())),
    ];
    Sum::new(terms).unwrap()
}

fn brushed() -> Sum {
    let terms: Vec<(f64, Arc<dyn Brdf>)> = vec![
        (1.0, Arc::new(Ward::new([0.6, 0.6, 0.7], 0.15, 0.5).unwrap())),
        (1.0, Arc::new(Lambert::new([0.1, 0.1, 0.2]).unwrap())),
    ];
    Sum::new(terms).unwrap()
}
