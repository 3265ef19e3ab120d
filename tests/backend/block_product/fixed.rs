//! The rule of appendix A against algorithm 1 written out.

use std::sync::Arc;

use haarmonic::backend::block_product::{BlockAngle, Rule, SampleBasis, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::backend::block_product::{self as twin, Samples};
use haarmonic::scene::{
    AshikhminShirley, BlinnPhong, Brdf, CookTorrance, Lambert, Lobe, Materials, Mesh, Phong, Structure, Sum, View, Ward,
};
use haarmonic::sphere::CubeMap;

use super::support::{Axes, frame, in_turn, layout, lobe, patchwork, reflectance, terms, view, visibility};
use crate::support::{baker, grid, noisy, soup};

/// Lobes of every class, on both sides of every limit.
fn lobes() -> Vec<Arc<dyn Brdf>> {
    let rgb = [0.8, 0.5, 0.2];
    let phong = |exponent: f64| lobe(Phong::new(rgb, exponent).unwrap());
    let both = Sum::new(vec![(0.5, lobe(Lambert::new([0.4, 0.6, 0.9]).unwrap())), (0.7, phong(80.0))]).unwrap();
    vec![
        lobe(Lambert::new(rgb).unwrap()),
        phong(3.0),
        phong(29.9),
        phong(30.0),
        phong(249.0),
        phong(250.0),
        lobe(BlinnPhong::new(rgb, 119.0).unwrap()),
        lobe(BlinnPhong::new(rgb, 400.0).unwrap()),
        lobe(Ward::new(rgb, 0.05, 0.3).unwrap()),
        lobe(CookTorrance::isotropic(rgb, 0.2).unwrap()),
        lobe(CookTorrance::new([0.5; 3], 0.1, 0.1).unwrap()),
        lobe(AshikhminShirley::new(rgb, [0.2; 3], 30.0, 60.0).unwrap()),
        lobe(both),
    ]
}

/// The exponent of a Phong lobe of the same width: half vectors turn half as far, and a slope of α is a lobe of
/// exponent 2/α² about them.
fn exponent(brdf: &dyn Brdf) -> Option<f64> {
    let of_slope = |alpha: [f64; 2]| 2.0 / alpha[0].min(alpha[1]).powi(2) / 4.0;
    match brdf.structure() {
        Structure::Lobe(Lobe::Phong(phong)) => Some(phong.exponent()),
        Structure::Lobe(Lobe::BlinnPhong(phong)) => Some(phong.exponent() / 4.0),
        Structure::Lobe(Lobe::Ward(ward)) => Some(of_slope(ward.alpha())),
        Structure::Lobe(Lobe::CookTorrance(ggx)) => Some(of_slope(ggx.alpha())),
        _ => None,
    }
}

struct Shot<'a> {
    mesh: &'a Mesh,
    view: View,
    light: CubeMap<Vector3<f32>>,
    /// Radiance × solid angle.
    weighted: Vec<Vector3<f64>>,
    block: usize,
    sees: &'a dyn Fn(usize, usize) -> f64,
}

impl Shot<'_> {
    fn reference(&self, vertex: usize, brdf: &dyn Brdf, angle: BlockAngle, basis: SampleBasis) -> Vector3<f64> {
        let side = self.light.grid().side();
        let frame = self.mesh.local_frame(vertex);
        let axes = Axes::new(&frame);
        let wo = self.view.outgoing(brdf, &self.mesh.positions()[vertex], &frame);
        let wo = axes.local(&wo);
        if wo.z <= 0.0 {
            return Vector3::zeros();
        }
        let one = |(weight, term): (f64, &dyn Brdf)| {
            let samples = |block: usize| {
                let Some(exponent) = exponent(term) else { return Samples::Along(1) };
                let (centre, radius) = twin::Block::new(side, self.block, block).cap();
                let radius = if angle == BlockAngle::Nearest { radius } else { 0.0 };
                let angle = Vector3::new(-wo.x, -wo.y, wo.z).angle(&axes.local(&centre));
                for limit in [std::f64::consts::FRAC_PI_8, std::f64::consts::FRAC_PI_4] {
                    // The fast path compares cosines in f32.
                    assert!((angle - radius - limit).abs() > 2e-7, "a block at a limit says nothing: other input");
                }
                twin::fixed_samples(exponent, angle, radius)
            };
            let vertex = twin::Vertex {
                light: &self.weighted,
                sides: [side, self.block],
                visibility: &|texel| (self.sees)(vertex, texel),
                reflectance: &|d| reflectance(term, &axes.local(d), &wo),
            };
            vertex.radiance(basis, &samples) * weight
        };
        terms(brdf).into_iter().map(one).sum()
    }

    fn check(&self, transport: &Transport, materials: &Materials, what: &str) {
        let angles = [BlockAngle::Centre, BlockAngle::Nearest];
        for (angle, basis) in angles.into_iter().flat_map(|a| [(a, SampleBasis::Cosine), (a, SampleBasis::Polynomial)])
        {
            let settings = Settings { rule: Rule::Fixed { angle }, basis };
            let got = frame((self.mesh, transport), settings, &self.light, &self.view, materials);
            let want: Vec<_> = (0..got.len()).map(|v| self.reference(v, materials.brdf(v), angle, basis)).collect();
            let largest = want.iter().map(|l| l.amax()).fold(0.0, f64::max);
            for (v, (got, want)) in got.iter().zip(&want).enumerate() {
                let off = (got.cast::<f64>() - want).amax();
                // f32 against f64: measured 1.3e-6, mostly 2e-7.
                assert!(off <= 3e-6 * largest, "{what}, {basis:?}, {angle:?}, vertex {v}: off by {off:e} of {largest}");
            }
        }
    }
}

/// Free blocks reach below the horizon here, where the smooth lobes go on and the others end.
#[test]
fn the_fixed_rule_is_algorithm_1() {
    let mesh = soup(26);
    let vertices = mesh.positions().len();
    let materials = in_turn(&lobes(), vertices);
    for (side, block, order) in [
        (32, 8, ScanOrder::Serpentine),
        (32, 16, ScanOrder::Hilbert),
        (32, 32, ScanOrder::RowMajor),
        (48, 16, ScanOrder::Hilbert),
    ] {
        let cut = patchwork(side, block, 11 * side + block);
        let maps = visibility(side, vertices, &cut);
        let transport = Transport::from_clipped(&maps, &layout(side, block, order)).unwrap();
        let sees = |v: usize, texel: usize| f64::from(u8::from(cut(v, texel)));
        let light = noisy(side, 4);
        let weighted = twin::weighted(&light);
        let shot = Shot { mesh: &mesh, view: view(), light, weighted, block, sees: &sees };
        shot.check(&transport, &materials, &format!("{side}/{block}"));
    }
}

#[test]
fn gray_visibility_too() {
    let mesh = soup(26);
    let materials = in_turn(&lobes(), mesh.positions().len());
    let (baker, layout) = (baker(&mesh, 32), layout(32, 16, ScanOrder::Serpentine));
    let transport = Transport::bake_gray(&mesh, &baker, &layout, (4, 3), &()).unwrap();
    let counts = baker.bake_fractional(4, &()).unwrap();
    let sees = |v: usize, texel: usize| {
        let is_above = mesh.normals()[v].cast::<f64>().dot(&grid(32).direction(texel)) > 0.0;
        if is_above { (f64::from(counts.vertex(v)[texel]) * 7.0 / 16.0).round() / 7.0 } else { 0.0 }
    };
    let light = noisy(32, 5);
    let weighted = twin::weighted(&light);
    let shot = Shot { mesh: &mesh, view: view(), light, weighted, block: 16, sees: &sees };
    shot.check(&transport, &materials, "gray");
}

/// What the print calls unsound: half of a lobe in a block that counts as smooth.
#[test]
fn the_classes_of_appendix_a() {
    use Samples::{Along, Pixels};
    let degrees = f64::to_radians;
    for (exponent, near, middle) in [
        (0.0, Along(2), Along(2)),
        (29.0, Along(2), Along(2)),
        (30.0, Along(4), Along(2)),
        (249.0, Along(4), Along(2)),
        (250.0, Pixels, Along(2)),
        (1e5, Pixels, Along(2)),
    ] {
        let at = |angle: f64, radius: f64| twin::fixed_samples(exponent, degrees(angle), degrees(radius));
        assert_eq!([at(0.0, 0.0), at(22.4, 0.0), at(22.6, 0.0), at(44.9, 0.0)], [near, near, middle, middle]);
        assert_eq!([at(45.1, 0.0), at(90.0, 0.0), at(180.0, 0.0)], [Along(1); 3]);
        assert_eq!([at(41.9, 19.5), at(42.1, 19.5), at(64.4, 19.5), at(64.6, 19.5)], [near, middle, middle, Along(1)]);
    }
}

/// Interpolants of what they hold, by another way than their equations.
#[test]
fn the_twins_interpolants_hold_their_basis() {
    for side in [8, 16, 32] {
        for along in [1_usize, 2, 4] {
            let at = twin::positions(side, along);
            let middle = 0.5 * (side as f64 - 1.0);
            assert!((at.iter().sum::<f64>() / along as f64 - middle).abs() < 1e-14 * side as f64);
            assert!(at.windows(2).all(|p| p[1] - p[0] == (side / along) as f64));
            for basis in [SampleBasis::Cosine, SampleBasis::Polynomial] {
                let table = twin::cardinals(side, along, basis);
                let wave =
                    |x: f64| ((2.0 * x + 1.0) * (along - 1) as f64 * std::f64::consts::PI / (2 * side) as f64).cos();
                let held = |x: f64, y: f64| match basis {
                    SampleBasis::Cosine => (1.0 + wave(x)) * (0.3 - wave(y)),
                    SampleBasis::Polynomial => {
                        (x / 5.0 - 1.0).powi(along as i32 - 1) * (2.0 - y / 7.0).powi(along as i32 - 1)
                    }
                };
                for pixel in 0..side * side {
                    let got: f64 =
                        (0..along * along).map(|j| held(at[j % along], at[j / along]) * table[(pixel, j)]).sum();
                    let want = held((pixel % side) as f64, (pixel / side) as f64);
                    assert!((got - want).abs() <= 1e-12 * (1.0 + want.abs()), "{side} {along} {basis:?}: {got} {want}");
                }
            }
        }
    }
}
