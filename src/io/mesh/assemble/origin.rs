//! Coordinates far from zero: the origin that is taken off before they are rounded to `f32`.
//!
//! Rounding moves a coordinate c by up to 2⁻²⁴ |c|: a quarter of a metre at the northings of surveyors' grids. How much
//! shape that costs is measured on the faces: the largest movement of a corner as a share of the shortest edge, which
//! is also about the angle by which the face's normal turns.

use nalgebra::Vector3;

use crate::io::count::plural;
use crate::io::report::Report;

/// The share of an edge that rounding may move a corner by and be no loss: normals turn by less than 0.06°.
const SHARE: f64 = 1.0 / 1024.0;

/// The share of half of the mesh's extent that rounding may move a corner by. Faces may be large and the gaps between
/// them small; 2⁻¹⁴ is what a mesh loses about a thousand times its own size away from zero.
const SHARE_OF_EXTENT: f64 = 1.0 / 16384.0;

/// What an origin must lessen the loss by to be worth it. A mesh that reaches to zero gains 2 at most.
const GAIN: f64 = 4.0;

/// What rounding to `f32` costs, seen from one origin.
#[derive(Debug, Default)]
struct Loss {
    /// The sum over the faces of the share that is lost, each at most 1.
    total: f64,
    /// The largest movement of a coordinate.
    rounding: f64,
    /// The largest share of a face, and its index.
    worst: (f64, usize),
    /// Faces that lose more than [`SHARE`].
    faces: usize,
    /// Corners that are beyond `f32`.
    beyond: usize,
}

impl Loss {
    fn new(positions: &[Vector3<f64>], faces: &[[u32; 3]], origin: &Vector3<f64>) -> Self {
        let mut loss = Self::default();
        for (i, face) in faces.iter().enumerate().filter(|(_, f)| !repeats(f)) {
            let corners = face.map(|i| positions[i as usize]);
            let mut moved = 0.0_f64;
            for p in &corners {
                let relative = p - origin;
                let rounded: Vector3<f32> = relative.cast();
                if rounded.iter().all(|c| c.is_finite()) {
                    moved = moved.max((rounded.cast::<f64>() - relative).amax());
                } else {
                    loss.beyond += 1;
                    moved = f64::INFINITY;
                }
            }
            // In the maximum norm, where nothing over- or underflows.
            let edge = (0..3).map(|k| (corners[k] - corners[(k + 1) % 3]).amax()).fold(f64::INFINITY, f64::min);
            if moved == 0.0 || edge == 0.0 {
                continue;
            }
            let share = (moved / edge).min(1.0);
            loss.total += share;
            loss.rounding = loss.rounding.max(moved);
            loss.faces += usize::from(share > SHARE);
            if share > loss.worst.0 {
                loss.worst = (share, i);
            }
        }
        loss
    }
}

/// The origin to take off: zero wherever `f32` keeps the shape as it is, or keeps it no better from elsewhere. Warns of
/// another one, and of what is lost all the same.
///
/// Positions that faces use are finite.
pub(super) fn choose(positions: &[Vector3<f64>], faces: &[[u32; 3]], report: &mut Report) -> Vector3<f64> {
    let mut origin = Vector3::zeros();
    let mut loss = Loss::new(positions, faces, &origin);
    if loss.total == 0.0 && loss.beyond == 0 {
        return origin;
    }
    let (low, high) = bounds(positions, faces);
    let extent = (high * 0.5 - low * 0.5).amax();
    if loss.beyond > 0 || loss.worst.0 > SHARE || loss.rounding > SHARE_OF_EXTENT * extent {
        for candidate in candidates(positions, faces, extent) {
            let there = Loss::new(positions, faces, &candidate);
            // Against the best so far: the first must gain much, a further one anything.
            let gain = if origin == Vector3::zeros() { GAIN } else { 1.0 };
            if there.beyond < loss.beyond || there.beyond == loss.beyond && gain * there.total < loss.total {
                (origin, loss) = (candidate, there);
            }
        }
    }
    if origin != Vector3::zeros() {
        let [x, y, z] = origin.into();
        report.warn(
            "",
            format!(
                "coordinates are too far from zero for f32: the origin ({x}, {y}, {z}) was taken off them; \
                 Mesh::origin has it"
            ),
        );
    }
    if loss.faces > 0 && loss.beyond == 0 {
        let (share, face) = loss.worst;
        report.warn(
            format!("triangle {face}"),
            format!(
                "the coordinates span too much for f32: rounding moves corners by up to {:.2e}, here {:.2} % of the \
                 shortest edge, and bends {}; split the file, or leave out what is far away",
                loss.rounding,
                100.0 * share,
                plural(loss.faces, "triangle", "triangles")
            ),
        );
    }
    origin
}

/// Whether a face names a vertex twice.
pub(super) fn repeats([a, b, c]: &[u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The corners of the faces.
fn corners(positions: &[Vector3<f64>], faces: &[[u32; 3]]) -> impl Iterator<Item = Vector3<f64>> {
    faces.iter().filter(|f| !repeats(f)).flatten().map(|&i| positions[i as usize])
}

/// The smallest and the largest coordinates of the faces.
fn bounds(positions: &[Vector3<f64>], faces: &[[u32; 3]]) -> (Vector3<f64>, Vector3<f64>) {
    let none = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    corners(positions, faces).fold(none, |(low, high), p| (low.inf(&p), high.sup(&p)))
}

/// Where most corners are (the median, which a few faces far away do not move), and the middle of their box.
fn candidates(positions: &[Vector3<f64>], faces: &[[u32; 3]], extent: f64) -> [Vector3<f64>; 2] {
    let (low, high) = bounds(positions, faces);
    let (mut median, mut deviation) = (Vector3::zeros(), 0.0_f64);
    for k in 0..3 {
        let mut values: Vec<f64> = corners(positions, faces).map(|p| p[k]).collect();
        median[k] = middle_of(&mut values);
        values.iter_mut().for_each(|c| *c = (*c - median[k]).abs());
        deviation = deviation.max(middle_of(&mut values));
    }
    let size = if deviation > 0.0 { deviation } else { extent };
    [snap(&median, size), snap(&(low * 0.5 + high * 0.5), extent)]
}

fn middle_of(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The point of a grid of a power of two near `p`, the mesh itself being as large as `size`: few digits, so that
/// subtracting it is exact.
fn snap(p: &Vector3<f64>, size: f64) -> Vector3<f64> {
    let step = size.log2().floor().exp2();
    p.map(|c| Some((c / step).round() * step).filter(|c| c.is_finite()).unwrap_or(c))
}
