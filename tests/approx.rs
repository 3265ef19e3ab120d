//! Approximate equality of every type that holds numbers: one table.
#![cfg(feature = "io")]

use std::fmt::Debug;

use approx::{AbsDiffEq, UlpsEq};
use haarmonic::affine::{AffineMap, Kernel, LightFieldTerm, ProductGradient, WaveletImage, ZoomWindow};
use haarmonic::compress::{ClusteredPca, ClusteredPcaSettings, Distortion, Pca};
use haarmonic::haar::{Pyramid, SparseVector};
use haarmonic::io::Image;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Bounds, Camera, Comparison, Hit, LocalFrame, Mesh, View};
use haarmonic::sh::{DiffuseLight, Extremum, MonteCarlo, VonMisesFisher, Zonal};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap};
use haarmonic::table::{self, Rectangle, SummedArea, SummedAreaStack, VisibilityDistance};

/// `make` makes a value of one number about 1, if such a value may be; `other` has another shape, if values have
/// shapes.
#[track_caller]
fn check<V, E>(make: impl Fn(f64) -> Option<V>, other: Option<V>)
where
    V: UlpsEq + approx::RelativeEq + AbsDiffEq<Epsilon = E> + Debug,
    E: From<f32>,
{
    let (one, near) = (make(1.0).unwrap(), make(1.001).unwrap());
    let e = |epsilon: f32| E::from(epsilon);
    assert!(one.abs_diff_eq(&one, e(0.0)) && one.relative_eq(&one, e(0.0), e(0.0)) && one.ulps_eq(&one, e(0.0), 0));
    assert!(one.abs_diff_eq(&near, e(0.01)) && !one.abs_diff_eq(&near, e(1e-4)), "{one:?} {near:?}");
    assert!(one.relative_eq(&near, e(0.0), e(0.01)) && !one.relative_eq(&near, e(0.0), e(1e-4)), "{one:?} {near:?}");
    assert!(one.ulps_eq(&near, e(0.01), 0) && !one.ulps_eq(&near, e(0.0), 4), "{one:?} {near:?}");
    // Half a unit of f32's last place, at most four of f64 or none of f32.
    let beside = make(1.0 + 3.0 * f64::EPSILON).unwrap();
    assert!(one.ulps_eq(&beside, e(0.0), 16), "{one:?} {beside:?}");
    // What cannot be compared is not equal: another shape, and what is no number, even to itself.
    for (a, b) in [(make(1.0), other), (make(f64::NAN), make(f64::NAN)), (make(f64::NAN), make(1.0))] {
        let (Some(a), Some(b)) = (a, b) else { continue };
        assert!(!a.abs_diff_eq(&b, e(1e9)) && !b.abs_diff_eq(&a, e(1e9)), "{a:?} {b:?}");
        assert!(!a.relative_eq(&b, e(1e9), e(1.0)) && !b.relative_eq(&a, e(1e9), e(1.0)), "{a:?} {b:?}");
        assert!(!a.ulps_eq(&b, e(1e9), 9) && !b.ulps_eq(&a, e(1e9), 9), "{a:?} {b:?}");
    }
}

fn v(x: f64) -> Vector3<f32> {
    Vector3::new(1.0, x as f32, 0.5)
}

#[test]
fn maps_and_pictures() {
    let cube = |side: usize, x: f64| {
        let grid = CubeGrid::new(side).unwrap();
        CubeMap::new(grid, vec![x; grid.len()]).unwrap()
    };
    check(|x| Some(cube(1, x)), Some(cube(2, 1.0)));
    check(|x| Some(cube(1, x).map(v)), Some(cube(2, 1.0).map(v)));
    let lat_long =
        |width: usize, x: f64| LatLongMap::new(LatLongGrid::new(width, 4 / width).unwrap(), vec![x as f32; 4]).unwrap();
    check(|x| Some(lat_long(4, x)), Some(lat_long(2, 1.0)));
    let image = |width: usize, x: f64| Image::new(width, 4 / width, vec![v(x); 4]).unwrap();
    check(|x| Some(image(4, x)), Some(image(2, 1.0)));
}

#[test]
fn wavelets() {
    check(|x| Some(Pyramid::from_pixels(2, &[x; 4]).unwrap()), Some(Pyramid::from_pixels(1, &[1.0]).unwrap()));
    // An entry that is not stored is 0.
    check(|x| Some(SparseVector::from_dense(&[0.0, x])), Some(SparseVector::from_dense(&[0.0, 1.0, 0.0])));
    let (stored, absent) = (SparseVector::from_dense(&[1e-9, 1.0]), SparseVector::from_dense(&[0.0, 1.0]));
    assert!(stored.ulps_eq(&absent, 1e-8, 4) && !stored.ulps_eq(&absent, 1e-10, 4));
    check(|x| AffineMap::new(x, 0.5).ok(), None);
    check(|x| AffineMap::new(2.0, x).ok(), None);
    let term = |i, value| LightFieldTerm { plane: [i, 0], direction: [0, 0], value: [0.5, value] };
    check(|x| Some(term(0, x)), Some(term(1, 1.0)));
    let image = |i, value| WaveletImage::new([2, 2], vec![0, i], vec![[0.5, 0.25], [0.5, value]]).ok();
    check(|x| image(1, x), image(2, 1.0));
    check(|x| image(1, x), WaveletImage::new([2, 1], vec![0, 1], vec![[0.5, 0.25], [0.5, 1.0]]).ok());
    check(|x| Kernel::from_taps(1, &[0.5, x]).ok(), Kernel::from_taps(0, &[0.5, 1.0]).ok());
    check(|x| Some(ZoomWindow::from_maps([AffineMap::IDENTITY, AffineMap::new(x, 0.5).ok()?])), None);
    check(|x| Some(ZoomWindow::from_maps([AffineMap::new(2.0, x).ok()?, AffineMap::IDENTITY])), None);
    let gradient = |at: usize, x: f64| {
        let number = |k| if k == at { x } else { 0.25 };
        ProductGradient { value: [number(0)], scale: [[number(1)], [number(2)]], offset: [[number(3)], [number(4)]] }
    };
    (0..5).for_each(|at| check(|x| Some(gradient(at, x)), None));
}

#[test]
fn harmonics() {
    check(|x| Zonal::from_factors([0.5, x]).ok(), Zonal::from_factors([0.5, 1.0, 0.0]).ok());
    check(|x| Zonal::from_factors([0.5, x as f32]).ok(), None);
    let table = |side, x: f64| DiffuseLight::new(&[12.0 * x], 1, 1).unwrap().table(side).unwrap();
    check(|x| Some(table(1, x)), Some(table(2, 1.0)));
    check(|x| VonMisesFisher::new(x).ok(), None);
    let extremum = |value, bound| Extremum { direction: Vector3::x_axis(), value, bound };
    check(|x| Some(extremum(x, 0.5)), None);
    check(|x| Some(extremum(0.5, x)), None);
    let away = Extremum { direction: -Vector3::x_axis(), ..extremum(0.5, 1.0) };
    assert!(!away.abs_diff_eq(&extremum(0.5, 1.0), 1.5) && away.abs_diff_eq(&extremum(0.5, 1.0), 2.5));
    let estimate = |x, error, samples| MonteCarlo {
        coefficients: [vec![x], vec![0.5]],
        errors: [vec![0.1], vec![error]],
        samples,
    };
    check(|x| Some(estimate(x, 0.1, 3)), Some(estimate(1.0, 0.1, 4)));
    check(|x| Some(estimate(0.5, x, 3)), None);
}

#[test]
fn scenes() {
    let frame = |x| LocalFrame { tangent: v(x), bitangent: v(0.5), normal: v(0.25) };
    check(|x| Some(frame(x)), None);
    check(|x| Some(Bounds { min: v(0.5), max: v(x) }), None);
    let mesh = |x: f64, flip: bool| {
        let positions = vec![Vector3::zeros(), Vector3::new(x as f32, 0.0, 0.0), Vector3::y()];
        Mesh::new(positions, vec![if flip { [0, 2, 1] } else { [0, 1, 2] }]).ok()
    };
    check(|x| mesh(x, false), mesh(1.0, true));
    let camera = |x| Camera::look_at(Vector3::new(0.0, 0.0, x), Vector3::zeros(), Vector3::y(), 0.5).ok();
    check(camera, None);
    check(|x| View::eye(v(x)).ok(), View::towards(v(1.0)).ok());
    let hit = |face, distance| Hit { face, distance, barycentric: [0.25, 0.25, 0.5] };
    check(|x| Some(hit(1, x)), Some(hit(2, 1.0)));
    check(|x| Some(Comparison { psnr_db: 40.0, rel_l2: x, max_abs: 0.5 }), None);
    let equal = Comparison { psnr_db: f64::INFINITY, rel_l2: 0.0, max_abs: 0.0 };
    assert!(equal.ulps_eq(&equal, 0.0, 0));
}

#[test]
fn tables() {
    let sums = |width, x: f64| SummedArea::<f64>::new(width, 4 / width, &[0.0, 0.0, 0.0, x]).unwrap();
    check(|x| Some(sums(4, x)), Some(sums(2, 1.0)));
    let stack = |layers, x: f64| SummedAreaStack::<f32>::new([1, 4 / layers], layers, &[0.0, 0.0, 0.0, x]).unwrap();
    check(|x| Some(stack(2, x)), Some(stack(1, 1.0)));
    check(|x| Some(Rectangle { left: 0.0, top: 0.5, right: x, bottom: 2.0 }), None);
    // Distances are of a map: no number of theirs is free.
    let distances = |map: &[bool; 4], width: usize, frame| {
        VisibilityDistance::new([width, 4 / width], map.as_slice(), frame).unwrap()
    };
    let (edge, corner) = ([true, true, false, false], [true, true, true, false]);
    let open = table::Border::Open;
    assert!(distances(&edge, 4, open).ulps_eq(&distances(&edge, 4, open), 0.0, 0));
    assert!(distances(&edge, 4, open).ulps_eq(&distances(&corner, 4, open), 2.0, 0));
    for other in [distances(&corner, 4, open), distances(&edge, 2, open), distances(&edge, 4, table::Border::Zero)] {
        assert!(!distances(&edge, 4, open).ulps_eq(&other, 0.125, 0), "{other:?}");
    }
}

#[test]
fn components() {
    let pca = |columns: usize, x: f64, variance: f64| {
        let mut component = vec![0.0; columns];
        component[0] = 1.0;
        Pca::from_parts(vec![x; columns], component, vec![variance], 2.0).ok()
    };
    check(|x| pca(2, x, 0.5), pca(3, 1.0, 0.5));
    check(|x| pca(2, 0.5, x), None);
    check(|x: f64| Some(Distortion::between(&[2.0], &[2.0 - x])), None);
    let clusters = |rows: usize, x: f64| {
        let settings = ClusteredPcaSettings::new(1, 1);
        ClusteredPca::from_labels(&[x, 0.5].repeat(rows), 2, &vec![0; rows], &settings, &()).ok()
    };
    check(|x| clusters(2, x), clusters(3, 1.0));
}
