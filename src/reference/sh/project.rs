//! Projection and reconstruction, a direction and a coefficient at a time.

use nalgebra::{DMatrix, DVector, UnitVector3};

use super::basis;
use crate::numeric::GaussLegendre;
use crate::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, fibonacci_directions};

/// Σ w f(d) y(d) over samples (direction, w f).
pub fn project(bands: usize, samples: impl IntoIterator<Item = (UnitVector3<f64>, f64)>) -> Vec<f64> {
    let mut out = vec![0.0; bands * bands];
    for (d, weighted) in samples {
        out.iter_mut().zip(basis(bands, &d)).for_each(|(o, y)| *o += weighted * y);
    }
    out
}

/// Σ c_i y_i at a direction.
pub fn reconstruct(coefficients: &[f64], direction: &UnitVector3<f64>) -> f64 {
    let y = basis(coefficients.len().isqrt(), direction);
    coefficients.iter().zip(y).map(|(c, y)| c * y).sum()
}

/// The coefficients of a cube map, each texel at its centre.
pub fn project_cube(map: &CubeMap<f64>, bands: usize) -> Vec<f64> {
    let (grid, omega) = (map.grid(), map.grid().face_solid_angles());
    let samples = map.texels().iter().enumerate();
    project(bands, samples.map(|(i, f)| (grid.direction(i), f * omega[i % omega.len()])))
}

/// ∫ y_i over a texel of a cube map, by `points`² Gauss points of the face's plane.
pub fn cube_texel_integrals(bands: usize, grid: CubeGrid, texel: usize, points: usize) -> Vec<f64> {
    let (face, x, y) = grid.texel(texel);
    let rule = GaussLegendre::new(points).expect("at least one point");
    let half = 1.0 / grid.side() as f64;
    let nodes = || rule.nodes().iter().zip(rule.weights());
    project(
        bands,
        nodes().flat_map(|(&a, &wa)| {
            nodes().map(move |(&b, &wb)| {
                let at = face.point(grid.centre(x) + half * a, grid.centre(y) + half * b);
                (UnitVector3::new_normalize(at), wa * wb * half * half / at.norm().powi(3))
            })
        }),
    )
}

/// The coefficients of a latitude–longitude map, each pixel at its centre.
pub fn project_lat_long(map: &LatLongMap<f64>, bands: usize) -> Vec<f64> {
    let grid = map.grid();
    let samples = map.pixels().iter().enumerate();
    project(bands, samples.map(|(i, f)| (grid.direction(i), f * grid.solid_angle(i / grid.width()))))
}

/// ∫ y_i over a pixel of a latitude–longitude map, by `points`² Gauss points of the image.
pub fn lat_long_pixel_integrals(bands: usize, grid: LatLongGrid, pixel: usize, points: usize) -> Vec<f64> {
    let rule = GaussLegendre::new(points).expect("at least one point");
    let nodes = || rule.nodes().iter().zip(rule.weights());
    let (x, y) = ((pixel % grid.width()) as f64, (pixel / grid.width()) as f64);
    let (du, dv) = (1.0 / grid.width() as f64, 1.0 / grid.height() as f64);
    project(
        bands,
        nodes().flat_map(|(&a, &wa)| {
            nodes().map(move |(&b, &wb)| {
                let v = (y + 0.5 + 0.5 * b) * dv;
                let at = LatLongGrid::point((x + 0.5 + 0.5 * a) * du, v);
                // 2π du · π dv of azimuth and polar angle.
                let area = 2.0 * std::f64::consts::PI.powi(2) * (std::f64::consts::PI * v).sin() * du * dv;
                (at, 0.25 * wa * wb * area)
            })
        }),
    )
}

/// The c that makes Σ w (f(d) − Σ c_i y_i(d))² + λ Σ l²(l+1)² c_i² least, of least norm where that leaves a choice.
///
/// By the singular values of the stacked matrix. Samples are (direction, w, f).
pub fn least_squares(bands: usize, samples: &[(UnitVector3<f64>, f64, f64)], lambda: f64) -> Vec<f64> {
    let size = bands * bands;
    let mut matrix = DMatrix::zeros(samples.len() + size, size);
    let mut right = DVector::zeros(samples.len() + size);
    for (row, (d, w, f)) in samples.iter().enumerate() {
        for (column, y) in basis(bands, d).into_iter().enumerate() {
            matrix[(row, column)] = w.sqrt() * y;
        }
        right[row] = w.sqrt() * f;
    }
    for i in 0..size {
        let l = i.isqrt();
        matrix[(samples.len() + i, i)] = lambda.sqrt() * (l * (l + 1)) as f64;
    }
    let svd = matrix.svd(true, true);
    let largest = svd.singular_values.max();
    svd.solve(&right, 1e-12 * largest).expect("both factors were asked for").as_slice().to_vec()
}

/// The least value of an expansion on `points` evenly spread directions.
pub fn sampled_minimum(coefficients: &[f64], points: usize) -> f64 {
    fibonacci_directions(points).iter().map(|d| reconstruct(coefficients, d)).fold(f64::INFINITY, f64::min)
}
