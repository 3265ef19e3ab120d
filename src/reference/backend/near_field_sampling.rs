//! Twin of product importance sampling in [`backend::near_field`](crate::backend::near_field): a density on cells of
//! the plane above a point, from the definition.
//!
//! No wavelets, no affine maps, no tables: the mean of the light over each cell by overlaps of rectangles, and the
//! reflectance, cosine and solid angle at its middle.

use nalgebra::Vector3;

/// A light as cells of a rectangle across +z: how bright each is, row after row, columns along x.
#[derive(Debug, Clone, Copy)]
pub struct Light<'a> {
    /// Cells along both edges.
    pub side: usize,
    /// How bright they are.
    pub cells: &'a [f64],
    /// The lengths of the edges.
    pub extent: [f64; 2],
    /// The middle, seen from the point.
    pub centre: [f64; 3],
}

/// The mean brightness in each of `side`² cells of the rectangle `low`…`high` of the plane z = 1.
pub fn incident(light: &Light<'_>, [low, high]: [[f64; 2]; 2], side: usize) -> Vec<f64> {
    // The rectangle's cells as they lie on the light's plane.
    let line = |axis: usize, i: usize| {
        light.centre[2] * (low[axis] + (high[axis] - low[axis]) * i as f64 / side as f64) - light.centre[axis]
    };
    let edge = |axis: usize, i: usize| light.extent[axis] * (i as f64 / light.side as f64 - 0.5);
    let overlap = |axis: usize, cell: usize, of_light: usize| {
        let (a, b) = (line(axis, cell), line(axis, cell + 1));
        (b.min(edge(axis, of_light + 1)) - a.max(edge(axis, of_light))).max(0.0) / (b - a)
    };
    let mean = |cell: usize| {
        let share = |i: usize| overlap(0, cell % side, i % light.side) * overlap(1, cell / side, i / light.side);
        light.cells.iter().enumerate().map(|(i, bright)| bright * share(i)).sum()
    };
    (0..side * side).map(mean).collect()
}

/// The density of each cell, per steradian at its middle: light × `reflect` × solid angle, so that it integrates to 1.
///
/// `reflect` is the reflectance times the cosine for a unit direction to the light, 0 below the surface. Not all of the
/// product may be 0.
pub fn product_density(
    light: &Light<'_>,
    window: [[f64; 2]; 2],
    side: usize,
    reflect: impl Fn(&Vector3<f64>) -> f64,
) -> Vec<f64> {
    let [low, high] = window;
    let middle = |axis: usize, i: usize| low[axis] + (high[axis] - low[axis]) * (i as f64 + 0.5) / side as f64;
    let area = (high[0] - low[0]) * (high[1] - low[1]) / (side * side) as f64;
    let direction = |cell: usize| Vector3::new(middle(0, cell % side), middle(1, cell / side), 1.0);
    let solid_angle = |cell: usize| area / direction(cell).norm().powi(3);
    let incident = incident(light, window, side);
    let product: Vec<f64> =
        (0..side * side).map(|i| incident[i] * reflect(&direction(i).normalize()) * solid_angle(i)).collect();
    let total: f64 = product.iter().sum();
    (0..side * side).map(|i| product[i] / total / solid_angle(i)).collect()
}
