//! Twins of [`sphere`](crate::sphere): specification tables, dense sampling and quadrature instead of closed forms.
//!
//! Maps are plain slices here, faces are numbers 0…5 in the order +X −X +Y −Y +Z −Z, directions `Vector3<f64>`.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::numeric::GaussLegendre;

/// The direction of the point (u, v) ∈ [−1, 1]² of a cube face, by inverting the (sc, tc, ma) table of the OpenGL
/// specification: u = sc/|ma|, v = tc/|ma|      [OpenGL 4.6 core, table 8.19]
pub fn cube_point(face: usize, u: f64, v: f64) -> Vector3<f64> {
    match face {
        0 => Vector3::new(1.0, -v, -u),  // sc = −rz, tc = −ry, ma = rx
        1 => Vector3::new(-1.0, -v, u),  // sc = +rz, tc = −ry
        2 => Vector3::new(u, 1.0, v),    // sc = +rx, tc = +rz
        3 => Vector3::new(u, -1.0, -v),  // sc = +rx, tc = −rz
        4 => Vector3::new(u, -v, 1.0),   // sc = +rx, tc = −ry
        5 => Vector3::new(-u, -v, -1.0), // sc = −rx, tc = −ry
        _ => panic!("a cube has six faces, got {face}"),
    }
}

/// The direction of the centre of texel `index` of a cube map of `side`² texels a face.
pub fn cube_direction(side: usize, index: usize) -> Vector3<f64> {
    let (face, y, x) = (index / (side * side), index / side % side, index % side);
    let place = |i: usize| (i as f64 + 0.5) / side as f64 * 2.0 - 1.0;
    cube_point(face, place(x), place(y)).normalize()
}

/// The direction of image point (u, v) of a lat-long map: azimuth 2π(u − ½) from −z towards +x, angle πv from +y.
pub fn lat_long_point(u: f64, v: f64) -> Vector3<f64> {
    let (azimuth, polar) = (2.0 * PI * (u - 0.5), PI * v);
    Vector3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
}

/// ∫∫ du dv/(1 + u² + v²)^{3/2} over a rectangle of a cube face, by Gauss–Legendre quadrature.
///
/// Accuracy: 1e-14 relative on the whole face and better on its parts. Cost: 64² evaluations.
pub fn solid_angle(u: [f64; 2], v: [f64; 2]) -> f64 {
    let rule = GaussLegendre::new(64).expect("64 points");
    rule.integrate(v[0], v[1], |v| rule.integrate(u[0], u[1], |u| (1.0 + u * u + v * v).powf(-1.5)))
}

/// ∫∫ du dv/(1 + u² + v²)² over a rectangle of a cube face: its cosine-weighted solid angle, by Gauss–Legendre
/// quadrature.
///
/// Accuracy: 1e-14 relative on the face of size 2 and its parts. Cost: 64² evaluations.
pub fn projected_solid_angle(u: [f64; 2], v: [f64; 2]) -> f64 {
    let rule = GaussLegendre::new(64).expect("64 points");
    rule.integrate(v[0], v[1], |v| rule.integrate(u[0], u[1], |u| (1.0 + u * u + v * v).powi(-2)))
}

/// The mean of `f` over texel `index` of a cube map: `samples`² points, weighted by the solid angle about each.
///
/// Accuracy for functions with jumps: of the order of 1/samples.
pub fn cube_texel_mean(side: usize, index: usize, samples: usize, mut f: impl FnMut(&Vector3<f64>) -> f64) -> f64 {
    let (face, y, x) = (index / (side * side), index / side % side, index % side);
    let place = |i: usize, k: usize| (i as f64 + (k as f64 + 0.5) / samples as f64) / side as f64 * 2.0 - 1.0;
    let (mut sum, mut weights) = (0.0, 0.0);
    for (j, i) in (0..samples * samples).map(|k| (k / samples, k % samples)) {
        let point = cube_point(face, place(x, i), place(y, j));
        let weight = point.norm().powi(-3);
        sum += weight * f(&point.normalize());
        weights += weight;
    }
    sum / weights
}

/// The mean of `f` over pixel `index` of a lat-long map: `samples`² points, weighted by the solid angle about each.
///
/// Accuracy for functions with jumps: of the order of 1/samples.
pub fn lat_long_pixel_mean(
    [width, height]: [usize; 2],
    index: usize,
    samples: usize,
    mut f: impl FnMut(&Vector3<f64>) -> f64,
) -> f64 {
    let place = |i: usize, k: usize, n: usize| (i as f64 + (k as f64 + 0.5) / samples as f64) / n as f64;
    let (mut sum, mut weights) = (0.0, 0.0);
    for (j, i) in (0..samples * samples).map(|k| (k / samples, k % samples)) {
        let v = place(index / width, j, height);
        let weight = (PI * v).sin();
        sum += weight * f(&lat_long_point(place(index % width, i, width), v));
        weights += weight;
    }
    sum / weights
}

/// The texel that holds a direction, by trying every face for the one whose plane it meets within the square.
pub fn cube_nearest(side: usize, direction: &Vector3<f64>) -> usize {
    let cell = |t: f64| (((t + 1.0) / 2.0 * side as f64).floor() as usize).min(side - 1);
    let hit = |face: usize| {
        let out = cube_point(face, 0.0, 0.0);
        let (right, down) = (cube_point(face, 1.0, 0.0) - out, cube_point(face, 0.0, 1.0) - out);
        let depth = direction.dot(&out);
        let (u, v) = (direction.dot(&right) / depth, direction.dot(&down) / depth);
        (depth > 0.0 && u.abs() <= 1.0 && v.abs() <= 1.0).then(|| (face * side + cell(v)) * side + cell(u))
    };
    (0..6).find_map(hit).expect("a direction that is not zero meets a face")
}

/// The pixel that holds a direction, from the definition u = ½ + atan2(x, −z)/2π, v = acos(y)/π.
pub fn lat_long_nearest([width, height]: [usize; 2], direction: &Vector3<f64>) -> usize {
    let d = direction.normalize();
    let (u, v) = (0.5 + d.x.atan2(-d.z) / (2.0 * PI), d.y.acos() / PI);
    let column = (u * width as f64).floor() as usize % width;
    (v * height as f64).floor().min((height - 1) as f64) as usize * width + column
}

/// Bilinear look-up in a cube map, the texels beyond an edge found by searching the whole map.
///
/// Across an edge: the texel of another face whose centre is nearest to the edge's point beside the missing texel. At a
/// corner: the mean of the three texels nearest to it.
pub fn cube_bilinear(side: usize, texels: &[f64], direction: &Vector3<f64>) -> f64 {
    let face = cube_nearest(1, direction);
    let out = cube_point(face, 0.0, 0.0);
    let depth = direction.dot(&out);
    let coordinate = |axis: Vector3<f64>| (direction.dot(&(axis - out)) / depth + 1.0) / 2.0 * side as f64 - 0.5;
    let (x, y) = (coordinate(cube_point(face, 1.0, 0.0)), coordinate(cube_point(face, 0.0, 1.0)));
    let angles = |to: Vector3<f64>| {
        let mut order: Vec<usize> = (0..texels.len()).collect();
        let angle = |&i: &usize| cube_direction(side, i).angle(&to);
        order.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        order
    };
    let last = side as f64 - 1.0;
    let texel = |x: f64, y: f64| {
        let (inside_x, inside_y) = ((0.0..=last).contains(&x), (0.0..=last).contains(&y));
        let place = |t: f64| ((t + 0.5) / side as f64 * 2.0 - 1.0).clamp(-1.0, 1.0);
        let border = cube_point(face, place(x), place(y));
        match (inside_x, inside_y) {
            (true, true) => texels[(face * side + y as usize) * side + x as usize],
            (false, false) => angles(border)[..3].iter().map(|&i| texels[i]).sum::<f64>() / 3.0,
            _ => {
                let order = angles(border);
                let other = order.iter().find(|&&i| i / (side * side) != face).expect("five other faces");
                texels[*other]
            }
        }
    };
    let (x0, y0) = (x.floor(), y.floor());
    let (s, t) = (x - x0, y - y0);
    (1.0 - t) * ((1.0 - s) * texel(x0, y0) + s * texel(x0 + 1.0, y0))
        + t * ((1.0 - s) * texel(x0, y0 + 1.0) + s * texel(x0 + 1.0, y0 + 1.0))
}

/// Bilinear look-up in a lat-long map: an extra row at either pole holds the mean of the row beside it, extra columns
/// repeat the other side, and the two rows and columns about the point are found by search.
pub fn lat_long_bilinear([width, height]: [usize; 2], pixels: &[f64], direction: &Vector3<f64>) -> f64 {
    let d = direction.normalize();
    let (u, v) = (0.5 + d.x.atan2(-d.z) / (2.0 * PI), d.y.acos() / PI);
    let row = |y: usize| -> Vec<f64> { pixels[y * width..(y + 1) * width].to_vec() };
    let pole = |y: usize| vec![row(y).iter().sum::<f64>() / width as f64; width];
    let mut rows = vec![(0.0, pole(0))];
    rows.extend((0..height).map(|y| ((y as f64 + 0.5) / height as f64, row(y))));
    rows.push((1.0, pole(height - 1)));
    let along = |values: &[f64]| {
        let columns: Vec<(f64, f64)> = (-1..=width as i64)
            .map(|x| ((x as f64 + 0.5) / width as f64, values[x.rem_euclid(width as i64) as usize]))
            .collect();
        between(&columns, u)
    };
    let column: Vec<(f64, f64)> = rows.iter().map(|(v, values)| (*v, along(values))).collect();
    between(&column, v)
}

/// Linear interpolation at `x` of (place, value) pairs in ascending places.
fn between(pairs: &[(f64, f64)], x: f64) -> f64 {
    let above = pairs.iter().position(|(place, _)| *place > x).unwrap_or(pairs.len() - 1);
    let ((x0, y0), (x1, y1)) = (pairs[above - 1], pairs[above]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

/// ∫ x^a y^b z^c dω over the unit sphere.
///
/// ```math
/// 4π (a−1)!! (b−1)!! (c−1)!! / (a+b+c+1)!!  if a, b, c are even, else 0      [Folland 2001]
/// ```
pub fn monomial_integral(a: u32, b: u32, c: u32) -> f64 {
    if a % 2 == 1 || b % 2 == 1 || c % 2 == 1 {
        return 0.0;
    }
    // Σ over even powers alone is a ratio of products of odd numbers; interleaved, it neither overflows nor vanishes.
    let mut value = 4.0 * PI;
    let mut below = 3.0;
    for power in [a, b, c] {
        for k in (1..power).step_by(2) {
            value *= f64::from(k) / below;
            below += 2.0;
        }
    }
    value
}

/// The disk point of the local direction at polar angle θ and azimuth φ from +y towards +x.
///
/// ```math
/// p = sinθ/√(1 + cosθ) · (sinφ, cosφ) = √2 sin(θ/2) · (sinφ, cosφ)      [Xu 2006 §5]
/// ```
pub fn hemisphere_point(theta: f64, phi: f64) -> [f64; 2] {
    let radius = 2f64.sqrt() * (theta / 2.0).sin();
    [radius * phi.sin(), radius * phi.cos()]
}
