//! Polygons cut into triangles.
//!
//! A fan around the first corner where that covers the polygon once, which it does for every convex one; ear clipping
//! by the crate `earcut` otherwise. Both look at the polygon along its Newell normal, the mean of its area vectors.
//! Holes are part of the outline, as exporters write them: a bridge leads there and back, and its corners come twice.

use earcut::Earcut;
use nalgebra::Vector3;

/// Corners from which on a polygon is left as a fan: the node indices of `earcut` end at 2³² bytes.
const MOST_CORNERS: usize = 1 << 24;

/// What became of a polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cut {
    /// The fan around the first corner covers it.
    Fan,
    /// Other triangles cover it.
    Ears,
    /// Its outline crosses itself (or is too long): the triangles do not have its area.
    Crossing,
}

/// Cuts polygons; the memory is used again.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    /// Corner numbers, three a triangle, of the last polygon; none if it stays a fan.
    pub(super) triangles: Vec<u32>,
}

impl Cutter {
    /// Cuts the polygon with these corners, four or more.
    pub(super) fn cut(&mut self, corners: &[Vector3<f64>]) -> Cut {
        self.triangles.clear();
        let from_first = |i: usize| corners[i] - corners[0];
        let pairs = 1..corners.len() - 1;
        let areas = || pairs.clone().map(|i| from_first(i).cross(&from_first(i + 1)));
        let normal: Vector3<f64> = areas().sum();
        if corners.iter().any(|p| !p.iter().all(|c| c.is_finite())) {
            return Cut::Fan;
        }
        // How far f32 moves a corner, and so how large an area can be and mean nothing.
        let step = f64::from(f32::EPSILON) * corners.iter().map(|p| p.amax()).fold(0.0, f64::max);
        let rounding = |i: usize| 2.0 * step * (from_first(i).norm() + from_first(i + 1).norm());
        let all: f64 = pairs.clone().map(rounding).sum();
        if !(normal.norm() > all) {
            // No side to look at it from: nothing, or loops that cancel.
            let nothing = areas().zip(pairs.clone()).all(|(area, i)| area.norm() <= rounding(i));
            return if nothing { Cut::Fan } else { Cut::Crossing };
        }
        let up = normal.normalize();
        let mut turned = 0.0;
        let covers = areas().zip(pairs.clone()).all(|(area, i)| {
            turned += up.dot(&area).atan2(from_first(i).dot(&from_first(i + 1)));
            up.dot(&area) >= -rounding(i)
        });
        if covers && turned < std::f64::consts::TAU * (1.0 + 1e-9) {
            return Cut::Fan;
        }
        self.flatten(corners, &normal);
        if corners.len() > MOST_CORNERS {
            return Cut::Crossing;
        }
        let none: [u32; 0] = [];
        self.earcut.earcut(self.flat.iter().copied(), &none, &mut self.triangles);
        let double_area = |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let whole: f64 = pairs.map(|i| double_area([self.flat[0], self.flat[i], self.flat[i + 1]])).sum();
        let mut covered = 0.0;
        for t in self.triangles.chunks_exact_mut(3) {
            let area = double_area([0, 1, 2].map(|k| self.flat[t[k] as usize]));
            if area * whole < 0.0 {
                t.swap(1, 2);
            }
            covered += area.abs();
        }
        if (covered - whole.abs()).abs() <= all.max(1e-9 * whole.abs()) { Cut::Ears } else { Cut::Crossing }
    }

    /// The corners seen along the normal, on the plane of the two axes that it is farthest from. A polygon parallel to
    /// such a plane keeps its coordinates exactly.
    fn flatten(&mut self, corners: &[Vector3<f64>], normal: &Vector3<f64>) {
        let k = normal.iamax();
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (slope_i, slope_j) = (normal[i] / normal[k], normal[j] / normal[k]);
        self.flat.clear();
        self.flat.extend(corners.iter().map(|p| {
            let p = p - corners[0];
            [p[i] - slope_i * p[k], p[j] - slope_j * p[k]]
        }));
    }
}
