//! BRDFs: against textbook formulas in angles, energy, reciprocity, edges, kernels, files, command-line forms.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, LazyLock};

use haarmonic::Error;
use haarmonic::nalgebra::{DMatrix, Rotation3, Unit, Vector2, Vector3};
use haarmonic::reference::scene::brdf as twin;
use haarmonic::reference::scene::brdf::{Angles, Lobe};
use haarmonic::scene::{
    AshikhminShirley, Beckmann, BlinnPhong, Brdf, BrdfFn, BrdfSpec, CookTorrance, DirectionTable, FactoredBrdf,
    Lambert, LocalFrame, Merl, MerlLookup, OrenNayar, Phong, Sum, Ward,
};
use haarmonic::sphere::{ConcentricSquare, CubeGrid, TopFace};
use haarmonic::strategies;
use proptest::prelude::*;

use crate::support::cases;

type Terms = Vec<(f64, Arc<dyn Brdf>)>;
type Twin = Box<dyn Fn(Angles) -> f64 + Send + Sync>;

struct Case {
    name: String,
    brdf: Arc<dyn Brdf>,
    /// The green channel.
    twin: Twin,
    /// Where the energy quadrature puts its points.
    lobe: Lobe,
    /// The upper bound of the directional albedo of the green channel.
    albedo: f64,
    /// 1/width of the lobe: what an error of direction is multiplied with.
    sharpness: f64,
}

const RGB: [f64; 3] = [0.9, 0.6, 0.2];

fn case(
    name: String,
    brdf: impl Brdf + 'static,
    lobe: Lobe,
    albedo: f64,
    sharpness: f64,
    twin: impl Fn(Angles) -> f64 + Send + Sync + 'static,
) -> Case {
    Case { name, brdf: Arc::new(brdf), twin: Box::new(twin), lobe, albedo, sharpness }
}

/// Every model at many parameters.
static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let mut all = vec![
        case("lambert".into(), Lambert::new(RGB).unwrap(), Lobe::Half, 0.6, 1.0, |_| twin::lambert(0.6)),
        case("lambert white".into(), Lambert::new([1.0; 3]).unwrap(), Lobe::Half, 1.0, 1.0, |_| twin::lambert(1.0)),
    ];
    for n in [0.0_f64, 0.5, 1.0, 2.0, 10.0, 50.0, 1e3, 1e4] {
        let sharp = 1.0 + n.sqrt();
        // cosⁿ of a cosine that is 1e-7 off zero.
        let rim = if n > 0.0 && n < 1.0 { 1e-7_f64.powf(n - 1.0) } else { sharp };
        let phong = Phong::new(RGB, n).unwrap();
        all.push(case(format!("phong {n}"), phong, Lobe::Mirror, 0.6, rim, move |a| twin::phong(0.6, n, a)));
        let blinn = BlinnPhong::new(RGB, n).unwrap();
        all.push(case(format!("blinn {n}"), blinn, Lobe::Half, 0.6, sharp, move |a| twin::blinn_phong(0.6, n, a)));
    }
    for (x, y) in [(0.01, 0.01), (0.05, 0.2), (0.2, 0.2), (0.5, 0.1), (1.0, 1.0)] {
        let sharp = 1.0 + 1.0 / f64::min(x, y);
        let ward = Ward::new(RGB, x, y).unwrap();
        all.push(case(format!("ward {x} {y}"), ward, Lobe::Half, 0.6, sharp, move |a| twin::ward(0.6, x, y, a)));
        let ggx = CookTorrance::new(RGB, x, y).unwrap();
        let t = move |a| twin::cook_torrance(0.6, x, y, a);
        all.push(case(format!("ggx {x} {y}"), ggx, Lobe::Half, 1.0, sharp, t));
        let ggx = CookTorrance::new([1.0; 3], x, y).unwrap();
        let t = move |a| twin::cook_torrance(1.0, x, y, a);
        all.push(case(format!("ggx white {x} {y}"), ggx, Lobe::Half, 1.0, sharp, t));
    }
    for m in [0.02, 0.1, 0.3, 1.0] {
        let sharp = 1.0 + 1.0 / m;
        for f0 in [0.6, 1.0] {
            let model = Beckmann::new([f0; 3], m).unwrap();
            let t = move |a| twin::beckmann(f0, m, a);
            all.push(case(format!("beckmann {m} {f0}"), model, Lobe::Half, 1.0, sharp, t));
        }
    }
    for sigma in [0.0, 0.1, 0.5, 1.5] {
        let model = OrenNayar::new(RGB, sigma).unwrap();
        let t = move |a| twin::oren_nayar(0.6, sigma, a);
        // The fit's own excess at grazing angles.
        all.push(case(format!("oren-nayar {sigma}"), model, Lobe::Half, 0.6 * 1.03, 1.0, t));
    }
    for (u, v) in [(0.0, 0.0), (1.0, 5.0), (10.0, 10.0), (100.0, 1000.0), (1e4, 1e4)] {
        for (rd, rs) in [(0.0, 1.0), (1.0, 0.05), (0.5, 0.5)] {
            let model = AshikhminShirley::new([rd; 3], [rs; 3], u, v).unwrap();
            let sharp = 1.0 + f64::max(u, v).sqrt();
            let t = move |a| twin::ashikhmin_shirley(rd, rs, u, v, a);
            all.push(case(format!("ashikhmin {u} {v} {rd} {rs}"), model, Lobe::Half, 1.0, sharp, t));
        }
    }
    all
});

fn direction(theta: f64, phi: f64) -> Vector3<f64> {
    Vector3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn frame(seed: f32) -> LocalFrame {
    let r = Rotation3::from_euler_angles(seed, 2.3 * seed + 0.4, 0.7 - seed);
    LocalFrame { tangent: r * Vector3::x(), bitangent: r * Vector3::y(), normal: r * Vector3::z() }
}

fn angles() -> impl Strategy<Value = Angles> {
    let theta = prop_oneof![3 => 0.0..1.56_f64, 1 => 0.0..1e-3, 1 => 1.5..1.569];
    let theta_o = prop_oneof![3 => 0.0..1.56_f64, 1 => 0.0..1e-3, 1 => 1.5..1.569];
    let offset = prop_oneof![1 => -PI..PI, 1 => -0.05..0.05_f64];
    // Half of the pairs near the mirror direction, where narrow lobes live.
    (theta, 0.0..2.0 * PI, theta_o, offset, any::<bool>(), -0.02..0.02_f64).prop_map(|(ti, pi, to, off, near, lean)| {
        let (theta_o, phi_o) = if near { ((ti + lean).clamp(0.0, 1.569), pi + PI + off * 0.1) } else { (to, pi + off) };
        Angles { theta_i: ti, phi_i: pi, theta_o, phi_o }
    })
}

proptest! {
    #![proptest_config(cases(48))]

    /// Tolerance: an angle's rounding times the steepest logarithmic slope, which is sharpness² in all lobes; at
    /// grazing angles times 1/cosines, for the twin's θ_d = ½ acos(…) ends there. In a lobe's rim, the cosine's own
    /// rounding times the slope at the peak.
    #[test]
    fn models_equal_the_textbook(a in angles()) {
        let (wi, wo) = (direction(a.theta_i, a.phi_i), direction(a.theta_o, a.phi_o));
        for case in CASES.iter() {
            let (got, expected) = (case.brdf.eval(&wi, &wo).y, (case.twin)(a));
            let peak = (case.twin)(Angles { theta_o: a.theta_i, phi_o: a.phi_i + PI, ..a }).abs();
            let slope = case.sharpness.powi(2) * (1.0 + a.theta_i.tan().abs()) * (1.0 + a.theta_o.tan().abs());
            let tolerance = 8.0 * f64::EPSILON * (slope * expected.abs() + case.sharpness.powi(2) * peak);
            prop_assert!((got - expected).abs() <= tolerance, "{}: {got} against {expected} at {a:?}", case.name);
        }
    }

    /// Both orders take the same operations but for the order of sums of three.
    #[test]
    fn models_are_reciprocal(a in angles()) {
        let (wi, wo) = (direction(a.theta_i, a.phi_i), direction(a.theta_o, a.phi_o));
        for case in CASES.iter() {
            let (f, g) = (case.brdf.eval(&wi, &wo), case.brdf.eval(&wo, &wi));
            prop_assert!((f - g).amax() <= 8.0 * f64::EPSILON * f.amax(), "{}: {f} against {g}", case.name);
        }
    }

    #[test]
    fn values_are_finite_not_negative_and_zero_below_the_horizon(
        wi in prop::array::uniform3(-1.0..1.0_f64), wo in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let unit = |v: [f64; 3]| Unit::try_new(Vector3::from(v), 1e-3).map(Unit::into_inner);
        let (Some(wi), Some(wo)) = (unit(wi), unit(wo)) else { return Ok(()) };
        for case in CASES.iter() {
            let f = case.brdf.eval(&wi, &wo);
            prop_assert!(f.iter().all(|c| c.is_finite() && *c >= 0.0), "{}: {f}", case.name);
            if wi.z <= 0.0 || wo.z <= 0.0 {
                prop_assert_eq!(f, Vector3::zeros(), "{}", case.name);
            }
        }
    }

    /// At the ends of the parameters' ranges too, and of sums: both orders take the same operations but for the order
    /// of sums of three.
    #[test]
    fn any_model_is_reciprocal_and_its_values_are_numbers(
        brdf in strategies::brdf(), a in angles(), seed in -3.0..3.0_f32, side in 1_usize..8,
    ) {
        let (wi, wo) = (direction(a.theta_i, a.phi_i), direction(a.theta_o, a.phi_o));
        let (f, g) = (brdf.eval(&wi, &wo), brdf.eval(&wo, &wi));
        prop_assert!(f.iter().all(|c| c.is_finite() && *c >= 0.0), "{f}");
        prop_assert!((f - g).amax() <= 8.0 * f64::EPSILON * f.amax(), "{f} against {g}");
        for (wi, wo) in [(-wi, wo), (wi, -wo), (-wi, -wo)] {
            prop_assert_eq!(brdf.eval(&wi, &wo), Vector3::zeros());
        }
        let (table, frame) = (DirectionTable::new(CubeGrid::new(side).unwrap()), frame(seed));
        let mut planes = vec![f32::NAN; 3 * table.len()];
        brdf.sample_cos(&frame, &frame.to_world(&wo).normalize(), &table, &mut planes);
        prop_assert!(planes.iter().all(|c| c.is_finite() && *c >= 0.0));
    }

    #[test]
    fn isotropic_models_do_not_change_under_a_turn(a in angles(), turn in 0.0..6.0_f64) {
        let (wi, wo) = (direction(a.theta_i, a.phi_i), direction(a.theta_o, a.phi_o));
        let r = Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
        let models: [Box<dyn Brdf>; 5] = [
            Box::new(Phong::new(RGB, 20.0).unwrap()),
            Box::new(BlinnPhong::new(RGB, 20.0).unwrap()),
            Box::new(Ward::isotropic(RGB, 0.3).unwrap()),
            Box::new(CookTorrance::isotropic(RGB, 0.3).unwrap()),
            Box::new(AshikhminShirley::new(RGB, [0.1; 3], 30.0, 30.0).unwrap()),
        ];
        for m in &models {
            let (f, g) = (m.eval(&wi, &wo), m.eval(&(r * wi), &(r * wo)));
            let slope = 1.0 + a.theta_i.tan().abs() + a.theta_o.tan().abs();
            // In a tail, ln f is large and so is its slope; the peaks are of order 1 to 10.
            let tolerance = 1e-13 * slope * f.amax() + 1e-14;
            prop_assert!((f - g).amax() <= tolerance, "{m:?}: {f} against {g}");
        }
    }

    /// Kernels against eval, on random frames and views. The largest is 7e-7 sharpness (Ward of roughness 1); at
    /// grazing views 1e-8/cos θ_o more, for h_z is about cos θ_o and rounded as numbers near 1 are.
    #[test]
    fn kernels_equal_eval(seed in -3.0..3.0_f32, theta in 0.0..1.57_f64, phi in 0.0..6.3_f64, side in 1_usize..24) {
        let grid = CubeGrid::new(side).unwrap();
        let face = TopFace::new(f64::from(side as u32), side).unwrap();
        let aside = frame(seed + 0.7);
        let cells = (0..face.len()).map(|i| aside.to_world(&face.cell_direction(i)).normalize()).collect();
        let tables = [
            (DirectionTable::new(grid), (0..grid.len()).map(|i| grid.direction(i).into_inner()).collect::<Vec<_>>()),
            (DirectionTable::top_face(&face, &aside), cells),
        ];
        let frame = frame(seed);
        let wo = frame.to_world(&direction(theta, phi)).normalize();
        for case in CASES.iter() {
            if case.name == "phong 0" {
                // A step at 90° from the mirror direction, which rounding may put on either side of a texel.
                continue;
            }
            for (table, directions) in &tables {
                let worst = kernel_error(&*case.brdf, &frame, &wo, table, directions);
                let allowed = (1.5e-6 + 3e-8 / theta.cos()) * case.sharpness;
                prop_assert!(worst <= allowed, "{} side {side}: {worst:e}", case.name);
            }
        }
    }
}

/// The largest error of `sample_cos` in RGB over the largest value that the lobe has anywhere along these directions,
/// and in its mirror direction.
fn kernel_error(
    brdf: &dyn Brdf,
    frame: &LocalFrame,
    wo: &Vector3<f64>,
    table: &DirectionTable,
    directions: &[Vector3<f64>],
) -> f64 {
    let n = table.len();
    let mut planes = vec![f32::NAN; 3 * n];
    brdf.sample_cos(frame, wo, table, &mut planes);
    let mut single = vec![f32::NAN; n];
    if brdf.colour().is_some() {
        brdf.sample_cos(frame, wo, table, &mut single);
    }
    // Kernels make the frame orthonormal in f64.
    let normal = frame.normal.cast::<f64>().normalize();
    let tangent = frame.tangent.cast::<f64>();
    let tangent = (tangent - normal * tangent.dot(&normal)).normalize();
    let to_local = |w: &Vector3<f64>| Vector3::new(tangent.dot(w), normal.cross(&tangent).dot(w), normal.dot(w));
    let local_wo = to_local(wo);
    assert!((local_wo.norm() - 1.0).abs() < 1e-12);
    let mirror = Vector3::new(-local_wo.x, -local_wo.y, local_wo.z);
    let mut peak = (brdf.eval(&mirror, &local_wo) * local_wo.z).amax();
    let mut worst = 0.0_f64;
    for i in 0..n {
        let wi = to_local(&directions[i]);
        let expected = brdf.eval(&wi, &local_wo) * wi.z.max(0.0);
        peak = peak.max(expected.amax());
        for k in 0..3 {
            let got = f64::from(planes[k * n + i]);
            assert!(got.is_finite() && got >= 0.0, "{brdf:?}: {got}");
            worst = worst.max((got - expected[k]).abs());
        }
        if let Some(colour) = brdf.colour() {
            worst = worst.max((colour * f64::from(single[i]) - expected).amax());
        }
    }
    if peak > 0.0 { worst / peak } else { worst }
}

/// Albedo ≤ its bound at angles from normal to grazing. The quadrature's error is measured by doubling: see `slack`.
#[test]
fn directional_albedo_stays_below_its_bound() {
    for case in CASES.iter() {
        for degrees in [0.0, 20.0, 45.0, 65.0, 80.0, 87.0, 89.5] {
            let f = |i: [f64; 3], o: [f64; 3]| case.brdf.eval(&Vector3::from(i), &Vector3::from(o)).y;
            let theta = f64::to_radians(degrees);
            let albedo = twin::directional_albedo(&f, theta, case.lobe, 96);
            let coarse = twin::directional_albedo(&f, theta, case.lobe, 48);
            let slack = (albedo - coarse).abs() + 1e-9;
            assert!(slack < 4e-3, "{} at {degrees}°: quadrature {albedo} and {coarse}", case.name);
            assert!(albedo > 0.0 && albedo <= case.albedo + slack, "{} at {degrees}°: {albedo}", case.name);
        }
    }
}

#[test]
fn closed_forms() {
    let albedo = |b: &dyn Brdf, theta, lobe| {
        let f = |i: [f64; 3], o: [f64; 3]| b.eval(&Vector3::from(i), &Vector3::from(o)).y;
        twin::directional_albedo(&f, theta, lobe, 128)
    };
    // ∫ cos/π = 1. The quadrature's kink at the horizon costs 1e-4.
    let lambert = Lambert::new(RGB).unwrap();
    for theta in [0.0, 1.0] {
        let got = albedo(&lambert, theta, Lobe::Half);
        assert!((got - 0.6).abs() < 2e-4, "{got}");
    }
    for n in [0.0, 1.0, 2.5, 50.0, 1e4] {
        let phong = albedo(&Phong::new(RGB, n).unwrap(), 0.0, Lobe::Mirror);
        assert!((phong - 0.6).abs() < 1e-6, "phong {n}: {phong}");
        let blinn = albedo(&BlinnPhong::new(RGB, n).unwrap(), 0.0, Lobe::Half);
        assert!((blinn - 0.6).abs() < 1e-4, "blinn {n}: {blinn}");
    }
    // Ashikhmin and Shirley's diffuse term at normal incidence: 28/23 · 31/32 · 23/28.
    let matt = AshikhminShirley::new([1.0; 3], [0.0; 3], 0.0, 0.0).unwrap();
    let gloss = AshikhminShirley::new([0.0; 3], [0.0; 3], 0.0, 0.0).unwrap();
    let got = albedo(&matt, 0.0, Lobe::Half) - albedo(&gloss, 0.0, Lobe::Half);
    assert!((got - 31.0 / 32.0).abs() < 1e-4, "{got}");
    // Peaks, in the mirror direction at normal incidence.
    let up = Vector3::z();
    let close = |got: f64, expected: f64| assert!((got / expected - 1.0).abs() < 1e-14, "{got} against {expected}");
    close(Phong::new([1.0; 3], 50.0).unwrap().eval(&up, &up).x, 52.0 / (2.0 * PI));
    close(Ward::new([1.0; 3], 0.1, 0.2).unwrap().eval(&up, &up).x, 1.0 / (4.0 * PI * 0.02));
    close(CookTorrance::new([0.5; 3], 0.1, 0.2).unwrap().eval(&up, &up).x, 0.5 / (4.0 * PI * 0.02));
}

/// Normal, mirror, grazing and opposite directions, at the ends of the parameters' ranges.
#[test]
fn edges_give_finite_values() {
    let mut models: Vec<Arc<dyn Brdf>> = CASES.iter().map(|c| c.brdf.clone()).collect();
    models.push(Arc::new(Phong::new([1.0; 3], 1e7).unwrap()));
    models.push(Arc::new(BlinnPhong::new([1.0; 3], 1e7).unwrap()));
    models.push(Arc::new(Ward::new([1.0; 3], 1e-4, 1.0).unwrap()));
    models.push(Arc::new(Ward::isotropic([1.0; 3], 1e-4).unwrap()));
    models.push(Arc::new(CookTorrance::isotropic([0.0; 3], 1e-4).unwrap()));
    models.push(Arc::new(CookTorrance::new([1.0; 3], 1e-4, 1.0).unwrap()));
    models.push(Arc::new(AshikhminShirley::new([1.0; 3], [1.0; 3], 1e7, 0.0).unwrap()));
    let mut directions = vec![Vector3::z(), Vector3::x(), -Vector3::z()];
    for z in [1e-3, 1e-8, 1e-20, 1e-160, 1e-308, 5e-324, 0.0] {
        for phi in [0.0, 0.3, FRAC_PI_2, PI, 4.0] {
            let mut d = direction(FRAC_PI_2, phi);
            d.z = z;
            directions.push(d);
        }
    }
    directions.extend([0.2, 0.7, 1.3].map(|t| direction(t, t)));
    let table = DirectionTable::new(CubeGrid::new(5).unwrap());
    for m in &models {
        for wi in &directions {
            for wo in &directions {
                let f = m.eval(wi, wo);
                assert!(f.iter().all(|c| c.is_finite() && *c >= 0.0), "{m:?}, {wi:?}, {wo:?}: {f}");
                assert!((f * wi.z).iter().all(|c| c.is_finite()));
                if wi.z <= 0.0 || wo.z <= 0.0 {
                    assert_eq!(f, Vector3::zeros(), "{m:?}");
                }
            }
            // Odd side: texel centres lie on the axes, so these frames meet exact zeros.
            for f in [frame(0.9), LocalFrame { tangent: Vector3::z(), bitangent: Vector3::x(), normal: Vector3::y() }] {
                let mut planes = vec![f32::NAN; 3 * table.len()];
                m.sample_cos(&f, &f.to_world(wi), &table, &mut planes);
                assert!(planes.iter().all(|c| c.is_finite() && *c >= 0.0), "{m:?}, wo {wi:?}");
                if wi.z <= 0.0 && f.normal == Vector3::y() {
                    assert!(planes.iter().all(|c| *c == 0.0), "{m:?}: lit although seen from behind");
                }
            }
        }
        // The zero vector that `View::wo` gives for the eye itself.
        assert_eq!(m.eval(&Vector3::z(), &Vector3::zeros()), Vector3::zeros());
    }
}

#[test]
fn parameters_out_of_range_are_errors() {
    for bad in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let rgb = [0.5, bad, 0.5];
        assert!(matches!(Lambert::new(rgb), Err(Error::OutOfRange { .. })));
        assert!(Phong::new(rgb, 1.0).is_err());
        assert!(BlinnPhong::new(rgb, 1.0).is_err());
        assert!(Ward::isotropic(rgb, 0.1).is_err());
        assert!(CookTorrance::isotropic(rgb, 0.1).is_err());
        assert!(AshikhminShirley::new(rgb, RGB, 1.0, 1.0).is_err());
        assert!(AshikhminShirley::new(RGB, rgb, 1.0, 1.0).is_err());
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY, 1.1e7] {
        assert!(Phong::new(RGB, bad).is_err());
        assert!(BlinnPhong::new(RGB, bad).is_err());
        assert!(AshikhminShirley::new(RGB, RGB, bad, 1.0).is_err());
        assert!(AshikhminShirley::new(RGB, RGB, 1.0, bad).is_err());
    }
    for bad in [0.0, -0.1, 1.01, 1e-5, f64::NAN] {
        assert!(Ward::new(RGB, bad, 0.1).is_err() && Ward::new(RGB, 0.1, bad).is_err());
        assert!(CookTorrance::new(RGB, bad, 0.1).is_err() && CookTorrance::new(RGB, 0.1, bad).is_err());
    }
    assert_eq!(Sum::new(vec![]).unwrap_err(), Error::Empty { what: "sum of BRDFs" });
    let white: Arc<dyn Brdf> = Arc::new(Lambert::new([1.0; 3]).unwrap());
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(Sum::new(vec![(bad, white.clone())]).is_err());
    }
}

#[test]
fn colours_have_a_largest_component_of_one_and_factor_f() {
    let (wi, wo) = (direction(0.5, 0.1), direction(0.6, 3.0));
    let black = Lambert::new([0.0; 3]).unwrap();
    assert_eq!(black.colour(), Some(Vector3::repeat(1.0)));
    for case in CASES.iter() {
        let Some(colour) = case.brdf.colour() else { continue };
        assert_eq!(colour.max(), 1.0, "{}", case.name);
        let f = case.brdf.eval(&wi, &wo);
        assert!((f - colour * f.max()).amax() <= 2.0 * f64::EPSILON * f.max(), "{}", case.name);
    }
    assert_eq!(CookTorrance::isotropic(RGB, 0.3).unwrap().colour(), None);
    assert_eq!(CookTorrance::isotropic([0.3; 3], 0.3).unwrap().colour(), Some(Vector3::repeat(1.0)));
    let lambert: Arc<dyn Brdf> = Arc::new(Lambert::new(RGB).unwrap());
    let phong: Arc<dyn Brdf> = Arc::new(Phong::new(RGB, 4.0).unwrap());
    let white: Arc<dyn Brdf> = Arc::new(Phong::new([1.0; 3], 4.0).unwrap());
    assert!(lambert.is_view_independent() && !phong.is_view_independent());
    let same = Sum::new(vec![(0.5, lambert.clone()), (0.5, phong)]).unwrap();
    assert_eq!(same.colour(), lambert.colour());
    let mixed = Sum::new(vec![(0.5, lambert), (0.5, white)]).unwrap();
    assert_eq!(mixed.colour(), None);
    assert_eq!((same.planes(), mixed.planes()), (1, 3));
}

#[test]
fn sums_and_closures_sample_like_eval() {
    let table = DirectionTable::new(CubeGrid::new(16).unwrap());
    let lambert: Arc<dyn Brdf> = Arc::new(Lambert::new(RGB).unwrap());
    let phong: Arc<dyn Brdf> = Arc::new(Phong::new([0.2, 0.2, 0.9], 30.0).unwrap());
    let same: Arc<dyn Brdf> = Arc::new(Ward::isotropic(RGB, 0.4).unwrap());
    let closure: Arc<dyn Brdf> =
        Arc::new(BrdfFn::new(|i: &Vector3<f64>, o: &Vector3<f64>| Vector3::new(i.z, o.z, i.x * i.x)));
    let grey: Arc<dyn Brdf> = Arc::new(BrdfFn::grey(|i: &Vector3<f64>, _: &Vector3<f64>| i.z));
    let f = frame(1.1);
    let wo = f.to_world(&direction(0.8, 2.0)).normalize();
    for terms in [
        vec![(0.4, lambert.clone()), (0.6, phong.clone())],
        vec![(0.4, lambert.clone()), (0.6, same)],
        vec![(0.5, closure.clone()), (0.3, phong.clone()), (0.0, lambert.clone())],
        vec![(1.0, grey)],
    ] {
        let sum = Sum::new(terms.clone()).unwrap();
        let wi = direction(0.4, 0.4);
        let expected: Vector3<f64> = terms.iter().map(|(w, b)| b.eval(&wi, &direction(0.8, 2.0)) * *w).sum();
        assert_eq!(sum.eval(&wi, &direction(0.8, 2.0)), expected);
        let directions: Vec<_> = (0..table.len()).map(|i| table.grid().unwrap().direction(i).into_inner()).collect();
        let worst = kernel_error(&sum, &f, &wo, &table, &directions);
        assert!(worst < 1e-6, "{sum:?}: {worst:e}");
    }
    assert_eq!(closure.eval(&-Vector3::z(), &Vector3::z()), Vector3::zeros());
}

#[test]
#[should_panic(expected = "planes of a BRDF slice")]
fn a_wrong_plane_count_panics() {
    let table = DirectionTable::new(CubeGrid::new(2).unwrap());
    let wo = Vector3::z();
    CookTorrance::isotropic(RGB, 0.3).unwrap().sample_cos(&frame(0.0), &wo, &table, &mut vec![0.0; table.len()]);
}

#[test]
fn add_cos_adds_and_scales() {
    let table = DirectionTable::new(CubeGrid::new(4).unwrap());
    let f = frame(0.3);
    let wo = f.to_world(&direction(0.3, 0.0));
    for case in CASES.iter() {
        let mut once = vec![0.0; 3 * table.len()];
        case.brdf.sample_cos(&f, &wo, &table, &mut once);
        let mut twice = vec![1.0; 3 * table.len()];
        case.brdf.add_cos(&f, &wo, &table, 2.0, &mut twice);
        for (a, b) in once.iter().zip(&twice) {
            assert!((2.0 * a + 1.0 - b).abs() <= 4.0 * f32::EPSILON * b, "{}: {a} {b}", case.name);
        }
    }
}

// ---- MERL ----

/// A file of a smooth model, made once.
static MERL: LazyLock<Vec<u8>> = LazyLock::new(|| Merl::bytes_from(&CookTorrance::isotropic(RGB, 0.4).unwrap()));

#[test]
fn merl_files_are_refused_with_the_place() {
    let message = |bytes: &[u8]| match Merl::from_bytes(bytes) {
        Err(Error::File { place, reason, .. }) => format!("{place}: {reason}"),
        other => panic!("{other:?}"),
    };
    assert_eq!(MERL.len(), Merl::FILE_LEN);
    assert!(message(&[]).contains("header"));
    assert!(message(&MERL[..11]).contains("byte 11: truncated"));
    assert!(message(&MERL[..12]).contains("truncated"));
    assert!(message(&MERL[..MERL.len() - 1]).contains("byte 34992011: truncated"));
    let mut bad = MERL.clone();
    bad.push(0);
    assert!(message(&bad).contains("bytes after"));
    bad.pop();
    bad[0] = 91;
    assert!(message(&bad).contains("[91, 90, 180]"));
    bad[..4].copy_from_slice(&(-90_i32).to_le_bytes());
    assert!(message(&bad).contains("[-90, 90, 180]"));
    bad[..4].copy_from_slice(&90_i32.to_le_bytes());
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let at = 12 + 8 * (1_458_000 + 7);
        bad[at..][..8].copy_from_slice(&value.to_le_bytes());
        assert!(message(&bad).contains("byte 11664068: green number 7"), "{}", message(&bad));
    }
    // A stream that never ends is cut off; a missing file is an error with its name.
    let endless = std::io::Read::chain(&MERL[..], std::io::repeat(0));
    assert!(
        Merl::read(endless, "endless").unwrap_err().to_string().contains("endless, byte 34992012: there are bytes")
    );
    assert!(Merl::open("/no/such.binary").unwrap_err().to_string().starts_with("/no/such.binary: "));
    assert!(Merl::read(&MERL[..], "x").is_ok());
}

#[test]
fn merl_reads_what_was_written() {
    let model = CookTorrance::isotropic(RGB, 0.4).unwrap();
    let nearest = Merl::from_bytes(&MERL).unwrap().with_lookup(MerlLookup::Nearest);
    let trilinear = Merl::from_bytes(&MERL).unwrap();
    // The lower of the two directions has the height cos θ_h cos θ_d − sin θ_h sin θ_d |cos φ_d|.
    let below = (0..1_458_000).filter(|i| {
        let h = ((i / 16200) as f64 + 0.5).powi(2) / 8100.0 * FRAC_PI_2;
        let d = ((i / 180 % 90) as f64 + 0.5) / 90.0 * FRAC_PI_2;
        let p = ((i % 180) as f64 + 0.5) / 180.0 * PI;
        h.cos() * d.cos() <= h.sin() * d.sin() * p.cos().abs()
    });
    assert_eq!(nearest.missing(), below.count());
    let (mut coarse, mut fine) = (0.0_f64, 0.0_f64);
    for i in 0..3000 {
        let r = |k: u64| ((i * 7919 + k * 104_729) as f64 * 0.618_033_988_75).fract();
        let a = Angles { theta_i: 1.2 * r(1), phi_i: 2.0 * PI * r(2), theta_o: 1.2 * r(3), phi_o: 2.0 * PI * r(4) };
        let (wi, wo) = (direction(a.theta_i, a.phi_i), direction(a.theta_o, a.phi_o));
        // The cell that the database's reader picks, straight from the bytes; either neighbour where rounding decides.
        let at = 12 + 8 * twin::merl_index(a);
        let stored = f64::from_le_bytes(MERL[at..][..8].try_into().unwrap()) / 1500.0;
        let got = nearest.eval(&wi, &wo).x;
        assert!((got - stored.max(0.0)).abs() <= 1e-7 * stored.abs(), "{a:?}: {got} against {stored}");
        let exact = model.eval(&wi, &wo);
        coarse = coarse.max((nearest.eval(&wi, &wo) - exact).amax() / exact.amax());
        fine = fine.max((trilinear.eval(&wi, &wo) - exact).amax() / exact.amax());
    }
    // Cells of 1° and, in θ_h, of up to 2°: first order for the nearest cell, second for interpolation.
    assert!(coarse < 0.06 && fine < 0.006, "{coarse} {fine}");
}

#[test]
fn merl_edges_are_finite_and_missing_cells_are_left_out() {
    let merl = Merl::from_bytes(&MERL).unwrap();
    for lookup in [MerlLookup::Nearest, MerlLookup::Trilinear] {
        let merl = merl.clone().with_lookup(lookup);
        for z in [1e-300, 1e-8, 0.1_f64] {
            for phi in [0.0, 1.0, PI, -PI, 6.0] {
                let d = |p: f64| Vector3::new(p.cos() * (1.0 - z * z).sqrt(), p.sin() * (1.0 - z * z).sqrt(), z);
                for other in [d(0.0), d(PI), Vector3::z()] {
                    let f = merl.eval(&d(phi), &other);
                    assert!(f.iter().all(|c| c.is_finite() && *c >= 0.0), "{f}");
                }
            }
        }
        assert!(merl.eval(&Vector3::z(), &Vector3::z()).y > 0.0);
    }
    // All cells missing: black.
    let mut bytes = MERL.clone();
    for number in bytes[12..].chunks_exact_mut(8) {
        number.copy_from_slice(&(-1.0_f64).to_le_bytes());
    }
    let none = Merl::from_bytes(&bytes).unwrap();
    assert_eq!(none.missing(), 1_458_000);
    assert_eq!(none.eval(&Vector3::z(), &Vector3::z()), Vector3::zeros());
    // A constant BRDF: interpolation next to missing cells must not darken it.
    let mut beside = 0;
    let flat = Merl::from_bytes(&Merl::bytes_from(&Lambert::new([0.5; 3]).unwrap())).unwrap();
    for i in 0..200 {
        let (t, p) = (1.5 * f64::from(i) / 200.0, f64::from(i));
        let f = flat.eval(&direction(t, p), &direction(1.5 - t, 2.0 * p)).x;
        assert!((f - 0.5 / PI).abs() < 1e-7, "{f}");
        // One direction near the horizon: some of the eight cells are missing, in places all.
        let f = flat.eval(&direction(1.555, 0.0), &direction(t, p)).x;
        assert!((f - 0.5 / PI).abs() < 1e-7 || f == 0.0, "{f}");
        beside += usize::from(f > 0.0);
    }
    assert!(beside > 150, "{beside}");
}

// ---- Command-line forms ----

#[test]
fn specs_build_their_models() {
    let (wi, wo) = (direction(0.5, 0.2), direction(0.45, 3.2));
    let white = [1.0; 3];
    let expect: [(&str, Terms); 10] = [
        ("lambert:0.8", vec![(1.0, Arc::new(Lambert::new([0.8; 3]).unwrap()))]),
        ("lambert:0.8,0.3,0.2", vec![(1.0, Arc::new(Lambert::new([0.8, 0.3, 0.2]).unwrap()))]),
        ("phong:50", vec![(1.0, Arc::new(Phong::new(white, 50.0).unwrap()))]),
        ("blinn-phong:100:0.5", vec![(1.0, Arc::new(BlinnPhong::new([0.5; 3], 100.0).unwrap()))]),
        ("ward:0.2:0.5", vec![(1.0, Arc::new(Ward::new(white, 0.2, 0.5).unwrap()))]),
        ("ward:0.2", vec![(1.0, Arc::new(Ward::new(white, 0.2, 0.2).unwrap()))]),
        ("ggx:0.3", vec![(1.0, Arc::new(CookTorrance::new(white, 0.3, 0.3).unwrap()))]),
        ("ashikhmin:100:1000", vec![(1.0, Arc::new(AshikhminShirley::new([0.0; 3], white, 100.0, 1000.0).unwrap()))]),
        (
            "phong:50+lambert:0.4",
            vec![
                (0.6, Arc::new(Phong::new(white, 50.0).unwrap()) as _),
                (0.4, Arc::new(Lambert::new(white).unwrap()) as _),
            ],
        ),
        (
            "ggx:0.3:0.2:0.04 + lambert:0.8,0.3,0.2 + phong:9",
            vec![
                (0.1, Arc::new(CookTorrance::new([0.04; 3], 0.3, 0.2).unwrap()) as _),
                (1.0, Arc::new(Lambert::new([0.8, 0.3, 0.2]).unwrap()) as _),
                (0.1, Arc::new(Phong::new(white, 9.0).unwrap()) as _),
            ],
        ),
    ];
    for (text, terms) in expect {
        let spec: BrdfSpec = text.parse().unwrap();
        assert_eq!(spec.to_string(), text);
        let expected = Sum::new(terms).unwrap().eval(&wi, &wo);
        let got = spec.build().unwrap().eval(&wi, &wo);
        assert!((got - expected).amax() <= 1e-14 * expected.amax(), "{text}: {got} against {expected}");
    }
}

#[test]
fn specs_say_what_is_wrong() {
    for (text, reason) in [
        ("", "a part is empty"),
        ("lambert", "lambert takes 1 parameters"),
        ("lambert:", "'' is not a number"),
        ("lambert:x", "'x' is not a number"),
        ("lambert:1,2", "has 2 numbers"),
        ("lambert:1.5", "more than 1"),
        ("lambert:-0.5", "must be in [0, 1], got -0.5"),
        ("lambert:nan", "'nan' is not finite"),
        ("phong:inf", "'inf' is not finite"),
        ("phong:50:0.2:1", "phong takes 1 to 2 parameters"),
        ("phong:-1", "Phong exponent must be"),
        ("ward:0", "Ward alpha_x must be"),
        ("ward:0.1:7", "Ward alpha_y must be"),
        ("ggx:0.2:0.2:2", "GGX reflectance F0"),
        ("plastic:3", "there is no model 'plastic'"),
        ("lambert:0.5+", "a part is empty"),
        ("lambert:0.6+phong:3:0.6", "reflect 1.2 in all"),
        ("lambert:1+phong:3", "leave nothing"),
        ("lambert:0.5+merl:a.binary", "cannot be summed"),
        ("merl:", "needs a file name"),
    ] {
        let message = text.parse::<BrdfSpec>().unwrap_err().to_string();
        assert!(message.contains(reason), "{text}: {message}");
        assert!(message.contains(BrdfSpec::FORMS), "{text}: {message}");
    }
    let missing: BrdfSpec = "merl:/no/such+file:x".parse().unwrap();
    assert!(missing.build().unwrap_err().to_string().starts_with("/no/such+file:x: "));
}

#[test]
fn specs_read_merl_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.binary");
    std::fs::write(&path, &*MERL).unwrap();
    let spec: BrdfSpec = format!("merl:{}", path.display()).parse().unwrap();
    let expected = Merl::from_bytes(&MERL).unwrap().eval(&direction(0.3, 0.0), &direction(0.4, 3.0));
    assert_eq!(spec.build().unwrap().eval(&direction(0.3, 0.0), &direction(0.4, 3.0)), expected);
}

/// The best sum of products: errors fall with the terms, and all terms are the table itself.
#[test]
fn factored_brdfs_are_their_models() {
    let model = Sum::new(vec![
        (1.0, Arc::new(Phong::new(RGB, 6.0).unwrap()) as Arc<dyn Brdf>),
        (0.3, Arc::new(Lambert::new([0.2, 0.5, 0.9]).unwrap())),
    ])
    .unwrap();
    let cells = 5;
    let all = FactoredBrdf::new(&model, cells, cells * cells).unwrap();
    assert!(all.errors().windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-12)));
    assert!(all.errors()[24] < 1e-7, "{:?}", all.errors());
    let centre = |i: usize| {
        let place = |i: usize| (2 * i + 1) as f64 / cells as f64 - 1.0;
        ConcentricSquare::direction(&Vector2::new(place(i % cells), place(i / cells))).into_inner()
    };
    // By hand, at the cells' centres: the error of four terms is what it says, and no other four do better by chance.
    let few = FactoredBrdf::new(&model, cells, 4).unwrap();
    assert_eq!((few.terms(), few.cells()), (4, cells));
    let (mut off, mut whole) = (0.0, 0.0);
    for (i, o) in (0..625).map(|k| (centre(k % 25), centre(k / 25))) {
        let (exact, got) = (model.eval(&i, &o), few.eval(&i, &o));
        let by_terms: Vector3<f64> = (0..4).map(|k| few.incident(k, &i) * few.outgoing(k, &o)).sum();
        assert!((got - by_terms).norm() < 1e-13 * (1.0 + got.norm()));
        assert!((all.eval(&i, &o) - exact).norm() < 1e-6);
        off += (got - exact).norm_squared() * i.z * o.z;
        whole += exact.norm_squared() * i.z * o.z;
    }
    assert!(((off / whole).sqrt() - few.errors()[3]).abs() < 1e-9, "{} {:?}", (off / whole).sqrt(), few.errors());
    assert!((few.errors()[3] - all.errors()[3]).abs() < 1e-12);
    // The singular values are those of the matrix.
    let value = |o: usize, k: usize| {
        let (i, o) = (centre(k / 3), centre(o));
        model.eval(&i, &o)[k % 3] * (i.z * o.z).sqrt()
    };
    let singular = DMatrix::from_fn(25, 75, value).singular_values();
    let tail = (singular.iter().skip(4).map(|s| s * s).sum::<f64>() / singular.norm_squared()).sqrt();
    assert!((tail - few.errors()[3]).abs() < 1e-9, "{tail}");
    // Finer cells are nearer between their centres.
    let finer = FactoredBrdf::new(&model, 10, 30).unwrap();
    assert!(finer.cell_error() < 0.6 * all.cell_error(), "{} {}", finer.cell_error(), all.cell_error());

    for cells in [0, 1, 33, usize::MAX] {
        assert!(matches!(FactoredBrdf::new(&model, cells, 1), Err(Error::OutOfRange { .. })));
    }
    for terms in [0, 10, usize::MAX] {
        assert!(matches!(FactoredBrdf::new(&model, 3, terms), Err(Error::OutOfRange { .. })));
    }
    let nan =
        BrdfFn::new(|_: &Vector3<f64>, wo: &Vector3<f64>| Vector3::repeat(if wo.x > 0.5 { f64::NAN } else { 1.0 }));
    assert!(matches!(FactoredBrdf::new(&nan, 4, 1), Err(Error::NotFinite { .. })));
    let black = FactoredBrdf::new(&Lambert::new([0.0; 3]).unwrap(), 3, 2).unwrap();
    assert_eq!((black.errors(), black.cell_error()), (&[0.0, 0.0][..], 0.0));
    let below = Vector3::new(0.6, 0.0, -0.8);
    assert_eq!((few.incident(0, &below), few.outgoing(0, &below)), (Vector3::zeros(), 0.0));
}
