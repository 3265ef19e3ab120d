//! Directions, rotations and maps, with the edges where spheres break.

use nalgebra::{Matrix3, Rotation3, Unit, UnitVector3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::Real;
use crate::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap, Texel};

/// A unit direction: the whole sphere, the axes and poles, the edges and corners of the cube, and places beside them.
pub fn direction() -> BoxedStrategy<UnitVector3<f64>> {
    let anywhere = (-1.0..1.0f64, -3.2..3.2f64).prop_map(|(z, phi)| {
        let (sin, cos) = phi.sin_cos();
        let across = (1.0 - z * z).sqrt();
        Unit::new_normalize(Vector3::new(across * cos, across * sin, z))
    });
    // Axes, edge middles and corners are the vectors of −1, 0 and 1.
    let special = (0..26usize).prop_map(|i| {
        let i = if i < 13 { i } else { i + 1 };
        let digit = |k: usize| (i / k % 3) as f64 - 1.0;
        Vector3::new(digit(1), digit(3), digit(9))
    });
    let exact = special.clone().prop_map(Unit::new_normalize);
    let small = || prop_oneof![Just(0.0), Just(1e-300), Just(-1e-16), Just(1e-12), Just(-1e-8)];
    let beside =
        (special, small(), small(), small()).prop_map(|(s, x, y, z)| Unit::new_normalize(s + Vector3::new(x, y, z)));
    prop_oneof![4 => anywhere, 2 => exact, 1 => beside].boxed()
}

/// A rotation: any, none, quarter and half turns about the axes, half turns about any axis, those of the cube without
/// rounding, turns by almost nothing, and those that almost keep or reverse the z axis.
pub fn rotation() -> BoxedStrategy<Rotation3<f64>> {
    let about = |angle: BoxedStrategy<f64>| {
        (direction(), angle).prop_map(|(axis, angle)| Rotation3::from_axis_angle(&axis, angle))
    };
    let quarters = (0..3usize, 0..4i32).prop_map(|(axis, quarters)| {
        let axis = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][axis];
        Rotation3::from_axis_angle(&axis, f64::from(quarters) * std::f64::consts::FRAC_PI_2)
    });
    let small = || prop_oneof![Just(1e-300), Just(1e-16), Just(1e-9), Just(-1e-5)].boxed();
    // Columns are signed axes; the last one's sign makes it a rotation.
    let cube = (0..3usize, 0..2usize, any::<bool>(), any::<bool>()).prop_map(|(first, other, a, b)| {
        let axis = |k: usize, negative: bool| Vector3::ith(k % 3, if negative { -1.0 } else { 1.0 });
        let (x, y) = (axis(first, a), axis(first + 1 + other, b));
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]))
    });
    let about_z = |angle| Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    let level = (-3.2..3.2f64, direction(), small(), any::<bool>()).prop_map(move |(angle, axis, tilt, over)| {
        let over = Rotation3::from_axis_angle(&Vector3::x_axis(), if over { std::f64::consts::PI } else { 0.0 });
        Rotation3::from_axis_angle(&axis, tilt) * over * about_z(angle)
    });
    prop_oneof![
        4 => about((-3.2..3.2f64).boxed()),
        1 => Just(Rotation3::identity()),
        2 => quarters,
        1 => about(small()),
        1 => about(Just(std::f64::consts::PI).boxed()),
        1 => cube,
        1 => level,
    ]
    .boxed()
}

/// `len` values of one map: ordinary, high dynamic range, signed, constant, one-hot or zero; no NaN or infinity.
pub fn radiance<T: Real>(len: usize) -> BoxedStrategy<Vec<T>> {
    let narrow = |values: Vec<f64>| values.into_iter().map(T::of).collect::<Vec<T>>();
    let one_hot = (0..len.max(1), 0.1..1e4f64)
        .prop_map(move |(at, value)| (0..len).map(|i| T::of(if i == at { value } else { 0.0 })).collect());
    prop_oneof![
        3 => vec(0.0..1.0f64, len).prop_map(narrow),
        2 => vec((-12.0..12.0f64).prop_map(f64::exp), len).prop_map(narrow),
        2 => vec(-1.0..1.0f64, len).prop_map(narrow),
        1 => (0.01..100.0f64).prop_map(move |c| vec![T::of(c); len]),
        2 => one_hot,
        1 => Just(vec![T::zero(); len]),
    ]
    .boxed()
}

/// A cube map of [`radiance`] with 1 to `max_side` texels along an edge.
pub fn cube_map<T: Real + Texel>(max_side: usize) -> BoxedStrategy<CubeMap<T>> {
    (1..=max_side)
        .prop_flat_map(|side| {
            let grid = CubeGrid::new(side).expect("a side from 1");
            radiance(grid.len()).prop_map(move |texels| CubeMap::new(grid, texels).expect("one value a texel"))
        })
        .boxed()
}

/// A lat-long map of [`radiance`] of up to `max_width` × `max_height` pixels.
pub fn lat_long_map<T: Real + Texel>(max_width: usize, max_height: usize) -> BoxedStrategy<LatLongMap<T>> {
    (1..=max_width, 1..=max_height)
        .prop_flat_map(|(width, height)| {
            let grid = LatLongGrid::new(width, height).expect("sizes from 1");
            radiance(grid.len()).prop_map(move |pixels| LatLongMap::new(grid, pixels).expect("one value a pixel"))
        })
        .boxed()
}
