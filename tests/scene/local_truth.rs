//! Ground truth of lamps, fog and interreflection against closed forms.

use std::f64::consts::PI;
use std::sync::Arc;

use haarmonic::nalgebra::{Isometry3, UnitVector3, Vector3};
use haarmonic::numeric::exponential_integral_scaled;
use haarmonic::scene::{
    Bvh, Convergence, Fog, GroundTruth, Interreflection, Lambert, LightField, LocalLight, LocalTruth, Materials, Mesh,
    Occluders, Outgoing, Phase, Phong, RectangleLight, SphereLight, SpotLight, TexelVisibility, View,
};
use haarmonic::sphere::{CubeGrid, CubeMap};
use haarmonic::{Error, Result};
use proptest::prelude::*;

use crate::support::{Watch, cases, grid, room};

type V = Vector3<f64>;

/// A triangle around the origin that faces +y, with its first vertex there.
fn floor() -> Mesh {
    let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(Vector3::from);
    Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap()
}

fn white() -> Materials {
    Materials::uniform(Lambert::new([1.0; 3]).unwrap())
}

/// The irradiance of the vertex at the origin, by way of a white floor, which reflects E/π.
fn irradiance(lights: &[LocalLight], samples: usize) -> f64 {
    let (mesh, materials, view) = (floor(), white(), View::towards(Vector3::y()).unwrap());
    let truth = LocalTruth { mesh: &mesh, materials: &materials, view: &view, lights, occluders: None, fog: None };
    truth.radiance(samples, &()).unwrap()[0].x * PI
}

/// The irradiance of a surface at the origin with a normal under a polygon of radiance 1 above its horizon
/// (counter-clockwise seen from the surface's side that it shines to): ½ Σ θ_k n · Γ_k [Lambert 1760].
fn polygon_irradiance(corners: &[V], normal: &V) -> f64 {
    let edges = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
    let sum: f64 = edges.map(|(a, b)| a.angle(&b) * a.cross(&b).normalize().dot(normal)).sum();
    0.5 * sum.abs()
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn rectangles_agree_with_lamberts_formula(
        place in prop::array::uniform3(-2.0..2.0_f64), height in 1.0..4.0_f64,
        turn in prop::array::uniform3(-0.4..0.4_f64), sizes in prop::array::uniform2(0.1..0.6_f64),
    ) {
        let centre = Vector3::new(place[0], height, place[2]);
        let turn = haarmonic::nalgebra::Rotation3::from_scaled_axis(Vector3::from(turn));
        // u × v looks down.
        let (u, v) = (turn * Vector3::x() * sizes[0], turn * Vector3::z() * sizes[1]);
        prop_assume!(u.cross(&v).dot(&-centre) > 0.05 * u.norm() * v.norm());
        let light = RectangleLight::uniform(centre, u, v, Vector3::repeat(1.0)).unwrap();
        let exact = polygon_irradiance(&light.corners(), &Vector3::y());
        let lights = [LocalLight::Rectangle(light)];
        let (coarse, fine) = (irradiance(&lights, 8), irradiance(&lights, 32));
        prop_assert!((fine - exact).abs() < 1e-4 * exact, "{fine} against {exact}");
        // Second order: a sixteenth of the error, or rounding.
        prop_assert!((fine - exact).abs() < 0.1 * (coarse - exact).abs() + 1e-9, "{coarse} {fine} {exact}");
    }

    #[test]
    fn spheres_agree_with_the_closed_form(
        place in prop::array::uniform3(-2.0..2.0_f64), radius in 0.05..0.9_f64,
    ) {
        let centre = Vector3::new(place[0], 1.0 + place[1].abs(), place[2]);
        let light = SphereLight::new(centre, radius, Vector3::repeat(2.0)).unwrap();
        let exact = 2.0 * PI * (radius / centre.norm()).powi(2) * centre.y / centre.norm();
        let got = irradiance(&[LocalLight::Sphere(light)], 16);
        prop_assert!((got - exact).abs() < 1e-14 * exact, "{got} against {exact}");
    }
}

#[test]
fn lamps_of_one_texture_are_their_pixels() {
    // A texture of 3 × 2 pixels is six rectangles.
    let (centre, u, v) = (Vector3::new(0.3, 2.0, -0.2), Vector3::x() * 0.6, Vector3::z() * 0.4);
    let pixels: Vec<Vector3<f32>> = (0..6).map(|i| Vector3::repeat(i as f32)).collect();
    let light = RectangleLight::new(centre, u, v, 3, pixels).unwrap();
    assert_eq!(light.size(), [3, 2]);
    let parts: Vec<LocalLight> = (0..6)
        .map(|i| {
            let place = |i: usize, n: f64| (2 * i + 1) as f64 / n - 1.0;
            let centre = centre + u * place(i % 3, 3.0) + v * place(i / 3, 2.0);
            let part = RectangleLight::uniform(centre, u / 3.0, v / 2.0, Vector3::repeat(i as f32));
            LocalLight::Rectangle(part.unwrap())
        })
        .collect();
    let (whole, parts) = (irradiance(&[LocalLight::Rectangle(light)], 4), irradiance(&parts, 4));
    assert!((whole - parts).abs() < 1e-14 * whole, "{whole} {parts}");
    // A light field of one radiance is a rectangle; one that shines along a cone is darker beside it.
    let field = |f: fn([f64; 2], &V) -> V| LocalLight::Field(LightField::new(centre, u, v, f).unwrap());
    let one = RectangleLight::uniform(centre, u, v, Vector3::repeat(1.0)).unwrap();
    let plain = irradiance(&[LocalLight::Rectangle(one)], 12);
    assert_eq!(irradiance(&[field(|_, _| Vector3::repeat(1.0))], 12), plain);
    let cone = irradiance(&[field(|_, d| Vector3::repeat((-d.y).powi(8)))], 12);
    assert!(cone > 0.5 * plain && cone < plain, "{cone} {plain}");
    // From behind, and from its plane, there is nothing.
    let behind = RectangleLight::uniform(centre, u, -v, Vector3::repeat(1.0)).unwrap();
    assert_eq!(irradiance(&[LocalLight::Rectangle(behind)], 4), 0.0);
    let level = RectangleLight::uniform(Vector3::new(1.0, 0.0, 0.0), u, v, Vector3::repeat(1.0)).unwrap();
    assert_eq!(irradiance(&[LocalLight::Rectangle(level)], 4), 0.0);
}

#[test]
fn points_and_spots_fall_with_the_square() {
    let at = Vector3::new(1.0, 2.0, -0.5);
    let exact = 3.0 / at.norm_squared() * at.y / at.norm();
    let point = SpotLight::point(at, Vector3::repeat(3.0)).unwrap();
    assert!((irradiance(&[LocalLight::Spot(point)], 1) - exact).abs() < 1e-15);
    let towards = UnitVector3::new_normalize(-at);
    let spot =
        |axis: UnitVector3<f64>| LocalLight::Spot(SpotLight::spot(at, axis, Vector3::repeat(3.0), 0.2, 0.5).unwrap());
    assert!((irradiance(&[spot(towards)], 1) - exact).abs() < 1e-15);
    assert_eq!(irradiance(&[spot(-towards)], 1), 0.0);
    // Half-way in the cosine between the two angles.
    let half = ((0.2_f64.cos() + 0.5_f64.cos()) / 2.0).acos();
    let turned = haarmonic::nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), 0.0)
        * haarmonic::nalgebra::Rotation3::from_axis_angle(
            &UnitVector3::new_normalize(towards.cross(&Vector3::y())),
            half,
        );
    let got = irradiance(&[spot(UnitVector3::new_normalize(turned * towards.into_inner()))], 1);
    assert!((got - 0.5 * exact).abs() < 1e-12, "{got} {exact}");
}

/// A lamp above a table stands in nobody's light; behind a wall it is not seen; half behind one it is half.
#[test]
fn shadows_of_objects_that_stand_anywhere() {
    let (mesh, materials, view) = (floor(), white(), View::towards(Vector3::y()).unwrap());
    let lamp = RectangleLight::uniform(Vector3::new(0.0, 4.0, 0.0), Vector3::x(), Vector3::z(), Vector3::repeat(1.0));
    let lights = [LocalLight::Rectangle(lamp.unwrap())];
    let square = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]].map(Vector3::from);
    let board = Arc::new(Bvh::new(&Mesh::new(square.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()));
    let seen = |pose: Isometry3<f64>| {
        let occluders = Occluders::new([(Arc::clone(&board), pose)]).unwrap();
        let truth = LocalTruth {
            mesh: &mesh,
            materials: &materials,
            view: &view,
            lights: &lights,
            occluders: Some(&occluders),
            fog: None,
        };
        truth.radiance(16, &()).unwrap()[0].x
    };
    let open = seen(Isometry3::translation(0.0, 9.0, 0.0));
    assert!(open > 0.05);
    assert_eq!(seen(Isometry3::translation(0.0, 2.0, 0.0)), 0.0);
    let half = seen(Isometry3::translation(1.0, 2.0, 0.0));
    assert!((half / open - 0.5).abs() < 1e-9, "{half} of {open}");
    // Where the lamp itself is part of the scene it does not hide itself.
    assert!((seen(Isometry3::translation(0.0, 4.0, 0.0)) - open).abs() < 1e-12);
}

#[test]
fn doubling_converges_and_says_so() {
    let (mesh, view) = (floor(), View::eye(Vector3::new(-1.0, 2.0, 0.3)).unwrap());
    let materials = Materials::uniform(Phong::new([0.8; 3], 20.0).unwrap());
    let lamp = RectangleLight::uniform(Vector3::new(1.0, 1.5, 0.0), Vector3::x(), Vector3::z(), Vector3::repeat(5.0));
    let lights = [LocalLight::Rectangle(lamp.unwrap())];
    let truth =
        LocalTruth { mesh: &mesh, materials: &materials, view: &view, lights: &lights, occluders: None, fog: None };
    let found = truth.converged(2, 256, 1e-4, &()).unwrap();
    assert!(found.is_reached && found.steps.last().unwrap().1 <= 1e-4, "{found}");
    assert!(found.steps.windows(2).all(|w| w[1].1 < 0.5 * w[0].1 && w[1].0 == 2 * w[0].0), "{found}");
    assert_eq!(found.to_string().lines().count(), 1 + found.steps.len());
    let fine = truth.radiance(512, &()).unwrap();
    assert!((found.values[0] - fine[0]).norm() < 2e-4 * fine[0].norm());
    let short = truth.converged(2, 4, 0.0, &()).unwrap();
    assert!(!short.is_reached && short.steps.len() == 1);
    for (first, most, tolerance) in [(0, 8, 0.1), (5, 8, 0.1), (1, 8, -1.0), (1, 8, f64::NAN)] {
        assert!(matches!(truth.converged(first, most, tolerance, &()), Err(Error::OutOfRange { .. })));
    }
    for samples in [0, 4097, usize::MAX] {
        assert!(matches!(truth.radiance(samples, &()), Err(Error::OutOfRange { .. })));
    }
    assert_eq!(truth.radiance(2, &Watch::stopping_after(0, 3)), Err(Error::Cancelled));
    let fails: Result<Convergence> = Convergence::by_doubling(1, 4, 0.1, |_| Err(Error::Cancelled));
    assert_eq!(fails, Err(Error::Cancelled));
}

/// The airlight of a point: β² I/(2πT sin γ) Im{e^{−Tw}[E₁(T(1 − w)) − …]} for a ray of any length [Sun 2008, 3.16].
fn airlight(beta: f64, distance: f64, gamma: f64, length: f64) -> f64 {
    // By a fine midpoint rule over the length itself, which shares nothing with the code under test.
    let n = 2_000_000;
    let step = length / n as f64;
    let at = |i: usize| {
        let t = (i as f64 + 0.5) * step;
        let d2 = distance * distance + t * t - 2.0 * distance * t * gamma.cos();
        (-beta * (t + d2.sqrt())).exp() / d2
    };
    beta / (4.0 * PI) * step * (0..n).map(at).sum::<f64>()
}

#[test]
fn fog_scatters_as_its_integral_says() {
    for (beta, distance, gamma, length) in [(0.2, 3.0, 0.7, 5.0), (1.0, 2.0, 2.0, 4.0), (0.05, 10.0, 0.1, 30.0)] {
        let fog = Fog::new(Vector3::repeat(beta), Vector3::zeros(), Phase::Isotropic).unwrap();
        let light = SpotLight::point(Vector3::new(0.0, 0.0, distance), Vector3::repeat(1.0)).unwrap();
        let direction = Vector3::new(f64::sin(gamma), 0.0, f64::cos(gamma));
        let lights = [LocalLight::Spot(light)];
        let got = |samples: usize| fog.airlight(&Vector3::zeros(), &direction, length, &lights, None, samples).x;
        let exact = airlight(beta, distance, gamma, length);
        assert!((got(256) / exact - 1.0).abs() < 2e-5, "{} {exact}", got(256));
        assert!((got(256) - exact).abs() < 0.1 * (got(64) - exact).abs() + 1e-9 * exact);
    }
    // To infinity, by the exponential integral: γ → π, where the airlight is β² I e^{−T}/(4πT)(1 − 2T e^{2T} E₁(2T)).
    let (beta, distance) = (0.3, 2.0);
    let t = beta * distance;
    let scaled = exponential_integral_scaled(haarmonic::nalgebra::Complex::new(2.0 * t, 0.0)).re;
    let exact = beta * beta * (-t).exp() / (4.0 * PI * t) * (1.0 - 2.0 * t * scaled);
    let fog = Fog::new(Vector3::repeat(beta), Vector3::zeros(), Phase::Isotropic).unwrap();
    let lights = [LocalLight::Spot(SpotLight::point(Vector3::z() * distance, Vector3::repeat(1.0)).unwrap())];
    let away = Vector3::new(1e-4, 0.0, -1.0).normalize();
    let got = fog.airlight(&Vector3::zeros(), &away, f64::INFINITY, &lights, None, 1 << 16).x;
    assert!((got / exact - 1.0).abs() < 2e-8, "{got} {exact}");
}

#[test]
fn phases_integrate_to_one_and_fog_dims() {
    for phase in [Phase::Isotropic, Phase::Rayleigh, Phase::HenyeyGreenstein(0.6), Phase::HenyeyGreenstein(-0.3)] {
        let n = 100_000;
        let middle = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
        let integral: f64 = (0..n).map(|i| phase.eval(middle(i))).sum::<f64>() * 2.0 * PI * 2.0 / n as f64;
        assert!((integral - 1.0).abs() < 1e-8, "{phase:?}: {integral}");
    }
    let fog = |s: f64, a: f64, phase| Fog::new(Vector3::repeat(s), Vector3::repeat(a), phase);
    assert!(matches!(fog(-0.1, 0.0, Phase::Isotropic), Err(Error::OutOfRange { .. })));
    assert!(matches!(fog(0.1, f64::NAN, Phase::Isotropic), Err(Error::NotFinite { .. })));
    for g in [-1.0, 1.0, f64::NAN] {
        assert!(matches!(fog(0.1, 0.0, Phase::HenyeyGreenstein(g)), Err(Error::OutOfRange { .. })));
    }
    let clear = fog(0.0, 0.0, Phase::Isotropic).unwrap();
    assert_eq!(clear.transmittance(f64::INFINITY), Vector3::repeat(1.0));
    let thick = fog(0.5, 0.25, Phase::Isotropic).unwrap();
    assert!((thick.transmittance(2.0).x - (-1.5_f64).exp()).abs() < 1e-16);

    // Absorption alone dims the lamp; scattering as well sends some of it back.
    let (mesh, materials, view) = (floor(), white(), View::towards(Vector3::y()).unwrap());
    let at = Vector3::new(0.0, 2.0, 0.0);
    let lights = [LocalLight::Spot(SpotLight::point(at, Vector3::repeat(1.0)).unwrap())];
    let under = |fog: Option<&Fog>| {
        let truth =
            LocalTruth { mesh: &mesh, materials: &materials, view: &view, lights: &lights, occluders: None, fog };
        truth.radiance(16, &()).unwrap()[0].x
    };
    let absorbing = fog(0.0, 0.75, Phase::Isotropic).unwrap();
    let (clear, dimmed, lit) = (under(None), under(Some(&absorbing)), under(Some(&thick)));
    assert!((dimmed / clear - (-1.5_f64).exp()).abs() < 1e-12);
    assert!(lit > 1.02 * dimmed && lit < clear, "{clear} {dimmed} {lit}");
}

/// In a furnace every wall sees radiance 1 everywhere, so that k reflections leave albedo^k.
#[test]
fn a_furnace_reflects_a_geometric_series() {
    let (mesh, view) = (room(3), View::eye(Vector3::zeros()).unwrap());
    let bvh = Bvh::new(&mesh);
    let albedo = 0.6;
    let materials = Materials::uniform(Lambert::new([albedo; 3]).unwrap());
    let furnace = Interreflection { mesh: &mesh, bvh: &bvh, materials: &materials, view: &view };
    let ones = Outgoing::Diffuse(vec![Vector3::repeat(1.0); mesh.positions().len()]);
    let watch = Watch::new(3 * mesh.positions().len());
    let got = furnace.radiance(&ones, 3, 12, &watch).unwrap();
    assert_eq!(watch.largest(), 3 * mesh.positions().len());
    let exact = albedo + albedo.powi(2) + albedo.powi(3);
    for (vertex, radiance) in got.iter().enumerate() {
        assert!((radiance.x / exact - 1.0).abs() < 4e-8, "vertex {vertex}: {} against {exact}", radiance.x);
    }
    assert_eq!(furnace.radiance(&ones, 0, 4, &()).unwrap(), vec![Vector3::zeros(); got.len()]);
    let found = furnace.converged(&ones, 1, [4, 32], 1e-3, &()).unwrap();
    assert!(found.is_reached && (found.values[40].x / albedo - 1.0).abs() < 4e-8, "{found}");

    // The same by direction, which is another path through the code.
    let directional = Outgoing::by_direction(CubeGrid::new(2).unwrap(), |_| Ok(vec![Vector3::repeat(1.0); got.len()]));
    let by_direction = furnace.radiance(&directional.unwrap(), 3, 12, &()).unwrap();
    // Below the horizon of a vertex nothing leaves; bilinear look-ups beside it mix that in.
    let off = by_direction.iter().zip(&got).map(|(a, b)| (a - b).norm() / b.norm()).fold(0.0_f64, f64::max);
    assert!(off < 0.2, "{off}");

    for samples in [0, 4097, usize::MAX] {
        assert!(matches!(furnace.radiance(&ones, 1, samples, &()), Err(Error::OutOfRange { .. })));
    }
    assert_eq!(furnace.radiance(&ones, 1, 4, &Watch::stopping_after(0, got.len())), Err(Error::Cancelled));
    let few = Outgoing::Diffuse(vec![Vector3::zeros(); 3]);
    assert!(matches!(furnace.radiance(&few, 1, 4, &()), Err(Error::Length { .. })));
    let glossy = Materials::uniform(Phong::new([0.5; 3], 10.0).unwrap());
    let furnace = Interreflection { materials: &glossy, ..furnace };
    assert!(matches!(furnace.radiance(&ones, 1, 4, &()), Err(Error::OutOfRange { .. })));
}

/// One bounce of a distant light on a glossy mesh by maps of outgoing radiance agrees with the direct truth summed over
/// the hits by hand.
#[test]
fn one_bounce_by_direction_is_the_truth_seen_from_there() {
    let mesh = room(1);
    let bvh = Bvh::new(&mesh);
    let materials = Materials::uniform(Phong::new([0.7; 3], 3.0).unwrap());
    let view = View::eye(Vector3::new(0.1, -0.2, 0.3)).unwrap();
    let light = CubeMap::from_fn(grid(4), |d| Vector3::repeat(1.0 + d.y as f32));
    let full = TexelVisibility::Full { grid: grid(4) };
    let towards = |direction: &V| {
        let view = View::towards(direction.cast())?;
        GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light }.radiance(&full, &())
    };
    let fine = Outgoing::by_direction(CubeGrid::new(12).unwrap(), towards).unwrap();
    let bounce = Interreflection { mesh: &mesh, bvh: &bvh, materials: &materials, view: &view };
    let got = bounce.radiance(&fine, 1, 8, &()).unwrap();
    let coarse = Outgoing::by_direction(CubeGrid::new(6).unwrap(), towards).unwrap();
    let rough = bounce.radiance(&coarse, 1, 8, &()).unwrap();
    let off: f64 =
        got.iter().zip(&rough).map(|(a, b)| (a - b).norm()).sum::<f64>() / got.iter().map(|a| a.norm()).sum::<f64>();
    assert!(off < 0.03 && got.iter().all(|l| l.x > 0.0), "{off}");
}

#[test]
fn lamps_that_are_none_are_refused() {
    let (o, x, z) = (Vector3::zeros(), Vector3::x(), Vector3::z());
    let one = Vector3::repeat(1.0_f32);
    for bad in [f64::NAN, f64::INFINITY] {
        let bad = Vector3::new(0.0, bad, 0.0);
        assert!(matches!(RectangleLight::uniform(bad, x, z, one), Err(Error::NotFinite { index: 0, .. })));
        assert!(matches!(RectangleLight::uniform(o, x, bad, one), Err(Error::NotFinite { index: 2, .. })));
        assert!(matches!(SphereLight::new(bad, 1.0, o), Err(Error::NotFinite { .. })));
        assert!(matches!(SpotLight::point(o, bad), Err(Error::NotFinite { index: 2, .. })));
        assert!(LightField::new(bad, x, z, |_, _| Vector3::zeros()).is_err());
    }
    for (u, v) in [(o, z), (x, x), (x, x + z), (x, o)] {
        assert!(matches!(RectangleLight::uniform(o, u, v, one), Err(Error::OutOfRange { .. })), "{u} {v}");
    }
    assert!(matches!(RectangleLight::new(o, x, z, 2, vec![one; 3]), Err(Error::Length { .. })));
    assert!(matches!(RectangleLight::new(o, x, z, 0, vec![one; 3]), Err(Error::Empty { .. })));
    let nan = vec![one, Vector3::repeat(f32::NAN)];
    assert!(matches!(RectangleLight::new(o, x, z, 1, nan), Err(Error::NotFinite { index: 1, .. })));
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(SphereLight::new(o, radius, o), Err(Error::OutOfRange { .. })));
    }
    for (inner, outer) in [(0.5, 0.5), (-0.1, 0.5), (0.5, 3.2), (f64::NAN, 1.0)] {
        assert!(SpotLight::spot(o, Vector3::x_axis(), o, inner, outer).is_err());
    }
    // From inside, a sphere is everywhere; at its centre too.
    let sphere = SphereLight::new(o, 2.0, Vector3::repeat(1.0)).unwrap();
    assert!((irradiance(&[LocalLight::Sphere(sphere)], 16) - PI).abs() < 0.05);
    // At a point light there is no direction to it.
    let here = SpotLight::point(o, Vector3::repeat(1.0)).unwrap();
    let mut calls = 0;
    LocalLight::Spot(here).sample(&o, 1, |_| calls += 1);
    assert_eq!(calls, 0);
}
