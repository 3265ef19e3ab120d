//! Ground truth: against its naive twin, the white furnace, linearity, every form of visibility.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::support::{Watch, cases, grid, noise, noisy, soup};
use haarmonic::Error;
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::scene::ground_truth as twin;
use haarmonic::scene::{
    BinaryVisibility, Brdf, CookTorrance, GroundTruth, Lambert, Materials, Mesh, Phong, TexelVisibility, View,
};
use haarmonic::sphere::CubeMap;
use proptest::prelude::*;

/// One horizontal triangle, normal +y.
fn floor() -> Mesh {
    let positions = vec![Vector3::new(0.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 0.0)];
    Mesh::new(positions, vec![[0, 1, 2]]).unwrap()
}

fn bits(side: usize, vertices: usize) -> BinaryVisibility {
    let n = grid(side).face_len();
    let per_face = BinaryVisibility::words_per_face(grid(side));
    BinaryVisibility::from_fn(grid(side), vertices, |v, words| {
        for i in 0..6 * n {
            if noise(v * 6 * n + i + 77) < 0.6 {
                words[i / n * per_face + i % n / 64] |= 1 << (i % n % 64);
            }
        }
    })
}

fn bit(words: &[u64], side: usize, i: usize) -> bool {
    let n = side * side;
    words[i / n * n.div_ceil(64) + i % n / 64] >> (i % n % 64) & 1 == 1
}

fn materials(vertices: usize) -> Materials {
    let brdfs: Vec<Arc<dyn Brdf>> = vec![
        Arc::new(Lambert::new([0.8, 0.5, 0.1]).unwrap()),
        Arc::new(Phong::new([0.3, 0.9, 0.9], 12.0).unwrap()),
        Arc::new(CookTorrance::new([0.9, 0.5, 0.2], 0.3, 0.6).unwrap()),
    ];
    Materials::new(brdfs, (0..vertices as u32).map(|v| v % 3).collect()).unwrap()
}

fn close(got: &[Vector3<f64>], expected: &[Vector3<f64>], relative: f64) {
    assert_eq!(got.len(), expected.len());
    for (v, (a, b)) in got.iter().zip(expected).enumerate() {
        assert!((a - b).amax() <= relative * b.amax(), "vertex {v}: {a} against {b}");
    }
}

#[test]
fn equals_the_naive_sum() {
    let mesh = soup(11);
    let n = mesh.positions().len();
    let materials = materials(n);
    for (side, view) in [
        (1, View::eye(Vector3::new(3.0, 5.0, -2.0)).unwrap()),
        (2, View::towards(Vector3::new(0.0, 2.0, 1.0)).unwrap()),
        (5, View::eye(Vector3::new(-6.0, 1.0, 0.0)).unwrap()),
        (8, View::towards(Vector3::new(-1.0, 0.1, 0.0)).unwrap()),
        (9, View::eye(Vector3::zeros()).unwrap()),
    ] {
        let light = noisy(side, side);
        let visibility = bits(side, n);
        let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
        let got = truth.radiance(&TexelVisibility::Binary(&visibility), &()).unwrap();
        let expected: Vec<_> = (0..n)
            .map(|v| {
                let f = mesh.local_frame(v);
                let normal = f.normal.cast::<f64>().normalize();
                let tangent = f.tangent.cast::<f64>();
                let tangent = (tangent - normal * tangent.dot(&normal)).normalize();
                twin::radiance(
                    &light,
                    &|i| f64::from(u8::from(bit(visibility.vertex(v), side, i))),
                    &|wi, wo| materials.brdf(v).eval(wi, wo),
                    [tangent, normal.cross(&tangent), normal],
                    // Lambert, part 0, is asked for along the normal: it does not depend on the view.
                    &if v % 3 == 0 { normal } else { view.wo(&mesh.positions()[v]) },
                )
            })
            .collect();
        assert!(got.iter().filter(|r| r.amax() > 0.0).count() >= n / 8, "side {side}: nearly all black");
        // Rounding of a solid angle, a difference of four numbers near its size × side.
        close(&got, &expected, 1e-13);
    }
}

/// Constant light, nothing in the way: Lambert gives albedo × L, up to the texels that the horizon cuts.
#[test]
fn white_furnace() {
    let albedo = Vector3::new(0.8, 0.5, 0.1);
    let materials = Materials::uniform(Lambert::new(albedo).unwrap());
    let view = View::eye(Vector3::new(0.1, 3.0, 0.2)).unwrap();
    // The floor's horizon runs along texel edges for even sides; the soup's does not. Measured: 0.328/side² there, up
    // to 0.15/side² in the soup, whose errors of single texels cancel.
    for side in [16, 32, 64] {
        let (on, off) = (0.4 / (side * side) as f64, 0.2 / (side * side) as f64);
        for (mesh, bound) in [(floor(), on), (soup(60), off)] {
            let light = CubeMap::from_fn(grid(side), |_| Vector3::new(1.0, 2.0, 4.0));
            let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
            let got = truth.radiance(&TexelVisibility::Full { grid: grid(side) }, &()).unwrap();
            let expected = albedo.component_mul(&Vector3::new(1.0, 2.0, 4.0));
            let mut worst = 0.0_f64;
            for (v, r) in got.iter().enumerate() {
                // A diffuse vertex has its radiance also where the viewer is behind it.
                worst = worst.max(((r - expected).component_div(&expected)).amax());
                assert!(r.iter().all(|c| *c > 0.0), "vertex {v}: {r}");
            }
            assert!(worst <= bound, "side {side}: {worst:e} above {bound:e}");
            assert!(worst > 0.3 * bound, "side {side}: bound {bound:e} is idle, {worst:e}");
        }
    }
}

/// One texel lit: the radiance is L f cos Ω.
#[test]
fn one_hot_light() {
    let g = grid(4);
    let mesh = floor();
    let materials = Materials::uniform(Lambert::new([1.0; 3]).unwrap());
    let view = View::towards(Vector3::y()).unwrap();
    for hot in 0..g.len() {
        let mut light = CubeMap::new(g, vec![Vector3::zeros(); g.len()]).unwrap();
        light.texels_mut()[hot] = Vector3::new(3.0, 0.0, 1e30);
        let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
        let got = truth.radiance(&TexelVisibility::Full { grid: g }, &()).unwrap()[0];
        let (_, x, y) = g.texel(hot);
        let expected = g.direction(hot).y.max(0.0) * g.solid_angle(x, y) / PI;
        assert!((got.x - 3.0 * expected).abs() <= 1e-7 * expected, "texel {hot}: {got}");
        assert_eq!(got.y, 0.0);
        assert!((got.z - f64::from(1e30_f32) * expected).abs() <= 1e23 * expected);
    }
}

#[test]
fn every_form_of_visibility_gives_the_same_bits() {
    for side in [1, 3, 8, 11] {
        let mesh = soup(20);
        let n = mesh.positions().len();
        let materials = materials(n);
        let view = View::eye(Vector3::new(3.0, 4.0, 5.0)).unwrap();
        let light = noisy(side, 5);
        let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
        let stored = bits(side, n);
        let g = grid(side);
        let binary = truth.radiance(&TexelVisibility::Binary(&stored), &()).unwrap();
        // Spare bits that a careless baker sets are nobody's.
        let spare = |words: &mut [u64]| {
            let used = g.face_len() % 64;
            if used > 0 {
                let per_face = words.len() / 6;
                words.iter_mut().skip(per_face - 1).step_by(per_face).for_each(|w| *w |= u64::MAX << used);
            }
        };
        let fill = |v: usize, words: &mut [u64]| {
            assert!(words.iter().all(|w| *w == 0));
            words.copy_from_slice(stored.vertex(v));
            spare(words);
        };
        assert_eq!(truth.radiance(&TexelVisibility::Words { grid: g, fill: &fill }, &()).unwrap(), binary);
        let fill = |v: usize, weights: &mut [f32]| {
            assert!(weights.iter().all(|w| *w == 0.0));
            for (i, w) in weights.iter_mut().enumerate() {
                *w = f32::from(u8::from(bit(stored.vertex(v), side, i)));
            }
        };
        assert_eq!(truth.radiance(&TexelVisibility::Weights { grid: g, fill: &fill }, &()).unwrap(), binary);
        let half = |v: usize, weights: &mut [f32]| {
            fill(v, weights);
            weights.iter_mut().for_each(|w| *w *= 0.5);
        };
        let halved: Vec<_> = binary.iter().map(|r| r * 0.5).collect();
        assert_eq!(truth.radiance(&TexelVisibility::Weights { grid: g, fill: &half }, &()).unwrap(), halved);
        let all = BinaryVisibility::from_fn(g, n, |_, words| {
            words.fill(u64::MAX);
        });
        let full = truth.radiance(&TexelVisibility::Full { grid: g }, &()).unwrap();
        assert_eq!(truth.radiance(&TexelVisibility::Binary(&all), &()).unwrap(), full);
    }
}

proptest! {
    #![proptest_config(cases(32))]

    /// Linear in the light to the rounding of a sum of n terms of one sign, and of the f32 that holds a L₁ + b L₂.
    #[test]
    fn linear_in_the_light(a in 0.0..10.0_f32, b in 0.0..10.0_f32, seed in 0_usize..1000) {
        let mesh = soup(4);
        let materials = materials(12);
        let view = View::eye(Vector3::new(3.0, 4.0, 5.0)).unwrap();
        let visibility = bits(6, 12);
        let of = |light: &CubeMap<Vector3<f32>>| {
            let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light };
            truth.radiance(&TexelVisibility::Binary(&visibility), &()).unwrap()
        };
        let (l1, l2) = (noisy(6, seed), noisy(6, seed + 5000));
        let texels = l1.texels().iter().zip(l2.texels()).map(|(x, y)| x * a + y * b).collect();
        let both = of(&CubeMap::new(grid(6), texels).unwrap());
        for ((x, y), got) in of(&l1).iter().zip(&of(&l2)).zip(&both) {
            let expected = x * f64::from(a) + y * f64::from(b);
            let slack = 2.0 * f64::from(f32::EPSILON) * expected.amax();
            prop_assert!((got - expected).amax() <= slack, "{got} against {expected}");
        }
    }

    #[test]
    fn views_are_unit_and_point_at_the_eye(eye in prop::array::uniform3(-1e3..1e3_f32), p in prop::array::uniform3(-1e3..1e3_f32)) {
        let (eye, p) = (Vector3::from(eye), Vector3::from(p));
        let wo = View::eye(eye).unwrap().wo(&p);
        let expected = eye.cast::<f64>() - p.cast();
        prop_assert!((wo * expected.norm() - expected).norm() <= 1e-15 * 8.0 * expected.norm());
    }
}

#[test]
fn views_have_edges() {
    assert!(View::eye(Vector3::new(f32::NAN, 0.0, 0.0)).is_err());
    assert!(View::towards(Vector3::new(0.0, f32::INFINITY, 0.0)).is_err());
    assert!(View::towards(Vector3::zeros()).is_err());
    let eye = Vector3::new(1.0, 2.0, 3.0);
    assert_eq!(View::eye(eye).unwrap().wo(&eye), Vector3::zeros());
    for length in [1e-45, 1e-20, 1.0, 3e38] {
        let wo = View::towards(Vector3::new(0.0, -length, 0.0)).unwrap().wo(&eye);
        assert_eq!(wo, -Vector3::y());
        assert!((View::eye(Vector3::repeat(length)).unwrap().wo(&Vector3::zeros()).norm() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn materials_have_edges() {
    let lambert: Arc<dyn Brdf> = Arc::new(Lambert::new([0.5; 3]).unwrap());
    let phong: Arc<dyn Brdf> = Arc::new(Phong::new([0.5; 3], 3.0).unwrap());
    assert!(Materials::new(vec![], vec![0]).is_err());
    assert!(Materials::new(vec![lambert.clone()], vec![]).is_err());
    assert!(Materials::new(vec![lambert.clone()], vec![0, 1]).is_err());
    let two = Materials::new(vec![lambert.clone(), phong], vec![0, 1, 1]).unwrap();
    assert_eq!((two.part(0), two.part(2)), (0, 1));
    assert!(two.is_single_channel() && !two.is_view_independent());
    assert!(two.check(3).is_ok());
    assert_eq!(two.check(4), Err(Error::Length { what: "parts of the vertices", expected: 4, got: 3 }));
    let one = Materials::uniform_shared(lambert);
    assert!(one.is_view_independent() && one.check(12345).is_ok());
    assert_eq!(one.part(777), 0);
}

#[test]
fn what_does_not_fit_is_an_error() {
    let mesh = floor();
    let view = View::towards(Vector3::y()).unwrap();
    let lambert = Materials::uniform(Lambert::new([0.5; 3]).unwrap());
    let good = noisy(4, 1);
    let truth = GroundTruth { mesh: &mesh, materials: &lambert, view: &view, light: &good };
    assert!(matches!(truth.radiance(&TexelVisibility::Full { grid: grid(8) }, &()), Err(Error::Length { .. })));
    assert!(matches!(truth.radiance(&TexelVisibility::Binary(&bits(4, 2)), &()), Err(Error::Length { .. })));
    let parts = materials(5);
    let wrong = GroundTruth { materials: &parts, ..truth };
    assert!(matches!(wrong.radiance(&TexelVisibility::Binary(&bits(4, 3)), &()), Err(Error::Length { .. })));
    let mut bad = good.clone();
    bad.texels_mut()[40].y = f32::NAN;
    let nan = GroundTruth { light: &bad, ..truth };
    let got = nan.radiance(&TexelVisibility::Full { grid: grid(4) }, &());
    assert_eq!(got, Err(Error::NotFinite { what: "light texel", index: 40 }));
    let fill = |_: usize, w: &mut [f32]| w[7] = f32::INFINITY;
    let got = truth.radiance(&TexelVisibility::Weights { grid: grid(4), fill: &fill }, &());
    assert_eq!(got, Err(Error::NotFinite { what: "visibility weight", index: 7 }));
}

#[test]
fn progress_reaches_the_end_and_cancellation_stops() {
    let mesh = soup(100);
    let materials = materials(300);
    let view = View::eye(Vector3::new(3.0, 4.0, 5.0)).unwrap();
    let light = noisy(4, 1);
    let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
    let full = TexelVisibility::Full { grid: grid(4) };
    let watch = Watch::new(300);
    truth.radiance(&full, &watch).unwrap();
    assert_eq!(watch.largest(), 300);
    for stop_after in [0, 64] {
        let watch = Watch::stopping_after(stop_after, 300);
        assert_eq!(truth.radiance(&full, &watch), Err(Error::Cancelled));
        assert!(watch.largest() < 300);
    }
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = soup(100);
    let materials = materials(300);
    let view = View::eye(Vector3::new(3.0, 4.0, 5.0)).unwrap();
    let (light, visibility) = (noisy(7, 1), bits(7, 300));
    let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| truth.radiance(&TexelVisibility::Binary(&visibility), &()).unwrap())
    };
    let one = of(1);
    assert_eq!(of(2), one);
    assert_eq!(of(5), one);
}
