//! Near-field relighting, cell by cell of the top face, without wavelets.

use nalgebra::Vector3;

use super::super::scene::sees;
use crate::scene::{BackFaces, Brdf, LocalFrame, Mesh};
use crate::sphere::TopFace;

/// The mean radiance over each cell of a top face of a light above it: by the overlap of every cell with every pixel.
///
/// Shapes: `pixels` row by row, `columns` in a row, over a rectangle of `extent` whose centre lies at `to` from the
/// point, both in the axes of the face; result: row by row. All is 0 unless the light is above the point.
///
/// # Panics
/// Unless the pixels fill their rows.
#[track_caller]
pub fn incident(
    (pixels, columns): (&[Vector3<f64>], usize),
    extent: [f64; 2],
    to: &Vector3<f64>,
    face: &TopFace,
) -> Vec<Vector3<f64>> {
    assert_eq!(pixels.len() % columns, 0, "whole rows of pixels");
    let (n, counts) = (face.cells(), [columns, pixels.len() / columns]);
    let mut out = vec![Vector3::zeros(); n * n];
    if to.z <= 0.0 {
        return out;
    }
    let step = face.size() / n as f64;
    let cell = |i: usize| [0, 1].map(|k| to.z * ((i + k) as f64 * step - 0.5 * face.size()));
    let pixel =
        |axis: usize, i: usize| [0, 1].map(|k| to[axis] + extent[axis] * ((i + k) as f64 / counts[axis] as f64 - 0.5));
    let overlap = |a: [f64; 2], b: [f64; 2]| (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
    for (i, out) in out.iter_mut().enumerate() {
        let (x, y) = (cell(i % n), cell(i / n));
        for (j, radiance) in pixels.iter().enumerate() {
            let area = overlap(x, pixel(0, j % columns)) * overlap(y, pixel(1, j / columns));
            *out += radiance * (area / ((x[1] - x[0]) * (y[1] - y[0])));
        }
    }
    out
}

/// The transport of a vertex: ∫ visibility · brdf_cos dω over each cell, by the midpoints of `samples`² parts, each
/// tested against every face of the mesh.
///
/// Result: row by row, in R, G and B.
pub fn transport(
    mesh: &Mesh,
    vertex: usize,
    (brdf, wo): (&dyn Brdf, &Vector3<f64>),
    frame: &LocalFrame,
    face: &TopFace,
    samples: usize,
) -> Vec<Vector3<f64>> {
    let surface = mesh.local_frame(vertex);
    let wo = surface.to_local(wo);
    let (n, fine) = (face.cells(), face.cells() * samples);
    let step = face.size() / fine as f64;
    let mut out = vec![Vector3::zeros(); n * n];
    for y in 0..fine {
        for x in 0..fine {
            let line = |i: usize| (i as f64 + 0.5) * step - 0.5 * face.size();
            let local = Vector3::new(line(x), line(y), 1.0);
            // dω = dv/(1 + |v|²)^{3/2}, corner by corner of the solid angle of a rectangle.
            let corner = |x: f64, y: f64| (x * y / (1.0 + x * x + y * y).sqrt()).atan();
            let [left, right, low, high] =
                [local.x - 0.5 * step, local.x + 0.5 * step, local.y - 0.5 * step, local.y + 0.5 * step];
            let omega = corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low);
            let direction = frame.to_world(&local).normalize();
            let wi = surface.to_local(&direction);
            if wi.z > 0.0 && sees(mesh, vertex, &direction, BackFaces::Occlude) {
                out[y / samples * n + x / samples] += brdf.eval(&wi, &wo) * (wi.z * omega);
            }
        }
    }
    out
}

/// Σ over the cells of radiance × transport.
pub fn radiance(incident: &[Vector3<f64>], transport: &[Vector3<f64>]) -> Vector3<f64> {
    incident.iter().zip(transport).map(|(l, t)| l.component_mul(t)).sum()
}
