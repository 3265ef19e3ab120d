//! Every pixel, or no error allowed: the ground truth.

use std::sync::{Arc, LazyLock};

use haarmonic::backend::block_product::{Rule, SampleBasis, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    AshikhminShirley, BlinnPhong, Brdf, BrdfFn, Comparison, CookTorrance, GroundTruth, Lambert, Merl, Mesh, Phong,
    Procedural, Sum, TexelVisibility, View, Ward,
};
use haarmonic::sphere::CubeMap;

use super::support::{above, frame, in_turn, layout, lobe, patchwork, sky, view};
use crate::support::{baker, grid, noisy, soup};

type Lobes = Vec<(&'static str, Arc<dyn Brdf>)>;

const RGB: [f64; 3] = [0.8, 0.5, 0.2];

/// A measured material, made once: reading it takes a while.
static MERL: LazyLock<Arc<dyn Brdf>> = LazyLock::new(|| {
    let bytes = Merl::bytes_from(&CookTorrance::isotropic(RGB, 0.4).unwrap());
    lobe(Merl::from_bytes(&bytes).unwrap())
});

/// Lobes whose errors are measured in a moment.
fn isotropic() -> Lobes {
    let phong = |exponent: f64| lobe(Phong::new(RGB, exponent).unwrap());
    let lambert = lobe(Lambert::new(RGB).unwrap());
    let inner = Sum::new(vec![(0.5, phong(50.0)), (0.5, lobe(BlinnPhong::new([0.3; 3], 20.0).unwrap()))]).unwrap();
    vec![
        ("lambert", lambert.clone()),
        ("phong 10", phong(10.0)),
        ("phong 50", phong(50.0)),
        ("phong 200", phong(200.0)),
        ("phong 1000", phong(1000.0)),
        ("blinn-phong", lobe(BlinnPhong::new(RGB, 120.0).unwrap())),
        ("ward", lobe(Ward::isotropic(RGB, 0.2).unwrap())),
        ("ggx, grey", lobe(CookTorrance::isotropic([0.6; 3], 0.3).unwrap())),
        ("ggx, coloured", lobe(CookTorrance::isotropic(RGB, 0.3).unwrap())),
        ("ashikhmin", lobe(AshikhminShirley::new(RGB, [0.3; 3], 60.0, 60.0).unwrap())),
        ("merl", MERL.clone()),
        ("sum of diffuse", lobe(Sum::new(vec![(0.3, lambert.clone()), (0.2, lambert.clone())]).unwrap())),
        ("sum", lobe(Sum::new(vec![(0.4, lambert), (0.0, phong(7.0)), (0.6, lobe(inner))]).unwrap())),
    ]
}

/// Lobes of which errors are measured over all azimuths.
fn anisotropic() -> Lobes {
    let ripple = |wi: &Vector3<f64>, wo: &Vector3<f64>| {
        let wave = 1.0 + (5.0 * wi.x + 3.0 * wo.y).sin();
        Vector3::new(0.1 * wave, 0.2 * wi.y * wi.y, 0.05)
    };
    vec![
        ("ward, brushed", lobe(Ward::new(RGB, 0.15, 0.5).unwrap())),
        ("ggx, grey and brushed", lobe(CookTorrance::new([0.6; 3], 0.15, 0.4).unwrap())),
        ("ggx, coloured and brushed", lobe(CookTorrance::new(RGB, 0.15, 0.4).unwrap())),
        ("ashikhmin, brushed", lobe(AshikhminShirley::new(RGB, [0.3; 3], 20.0, 200.0).unwrap())),
        ("closure", lobe(BrdfFn::new(ripple))),
    ]
}

fn all() -> Lobes {
    isotropic().into_iter().chain(anisotropic()).collect()
}

const PIXELS: Rule = Rule::Pixels;

fn no_error() -> Rule {
    Rule::bounded(0.0).unwrap()
}

/// What is lit and how it is seen.
struct Shot<'a> {
    mesh: &'a Mesh,
    view: View,
    light: CubeMap<Vector3<f32>>,
}

impl Shot<'_> {
    /// Compares with the ground truth, lobe by lobe: they are dealt out to the vertices.
    fn check(&self, seen: &TexelVisibility, transport: &Transport, lobes: &Lobes, rules: &[Rule], what: &str) {
        let (names, brdfs): (Vec<_>, Vec<_>) = lobes.iter().cloned().unzip();
        let materials = in_turn(&brdfs, self.mesh.positions().len());
        let truth = GroundTruth { mesh: self.mesh, materials: &materials, view: &self.view, light: &self.light };
        let truth = truth.radiance(seen, &()).unwrap();
        for &rule in rules {
            let settings = Settings { rule, basis: SampleBasis::default() };
            let got = frame((self.mesh, transport), settings, &self.light, &self.view, &materials);
            for (k, name) in names.iter().enumerate() {
                let of: (Vec<_>, Vec<_>) =
                    truth.iter().copied().zip(got.iter().copied()).skip(k).step_by(names.len()).unzip();
                assert!(of.0.iter().any(|l| l.max() > 0.0), "{what}, {name}: all black");
                // f32 directions, light and lobes: measured up to 5e-7; 1.7e-6 for the needle, √n roundings of a
                // direction.
                let bound = if *name == "phong 10000" { 5e-6 } else { 1e-6 };
                let error = Comparison::new(&of.0, &of.1).unwrap().rel_l2;
                assert!(error <= bound, "{what}, {name}, {rule:?}: {error:e}");
            }
        }
    }
}

fn scene(procedural: Procedural, side: usize) -> (Mesh, View, CubeMap<Vector3<f32>>) {
    let model = procedural.build(1000).unwrap();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    (model.mesh, view, sky(side))
}

#[test]
fn all_lobes_on_a_scene() {
    let (mesh, view, light) = scene(Procedural::StackedSpheres, 32);
    let baker = baker(&mesh, 32);
    let transport = Transport::bake(&baker, &layout(32, 8, ScanOrder::Serpentine), &()).unwrap();
    let bits = baker.bake(&()).unwrap();
    let shot = Shot { mesh: &mesh, view, light };
    shot.check(&TexelVisibility::Binary(&bits), &transport, &all(), &[PIXELS], "spheres");
    // Errors of brushed facets take as long to measure as all others together.
    let mut lobes = all();
    lobes.retain(|(name, _)| !(name.contains("ggx") && name.contains("brushed")));
    shot.check(&TexelVisibility::Binary(&bits), &transport, &lobes, &[no_error()], "spheres");
}

#[test]
fn every_scene_binary_and_gray() {
    for (procedural, block) in [(Procedural::Table, 16), (Procedural::TorusKnotOnFloor, 32), (Procedural::BasRelief, 8)]
    {
        let (mesh, view, light) = scene(procedural, 32);
        let (baker, layout) = (baker(&mesh, 32), layout(32, block, ScanOrder::Hilbert));
        let shot = Shot { mesh: &mesh, view, light };
        let name = procedural.name();
        let bits = baker.bake(&()).unwrap();
        let transport = Transport::bake(&baker, &layout, &()).unwrap();
        // Errors of wide lobes are measured once: on large blocks that takes seconds.
        let quick = |(name, _): &(&str, _)| block == 16 || name.contains("lambert") || name.contains("phong ");
        let lobes: Lobes = isotropic().into_iter().filter(quick).collect();
        shot.check(&TexelVisibility::Binary(&bits), &transport, &isotropic(), &[PIXELS], name);
        shot.check(&TexelVisibility::Binary(&bits), &transport, &lobes, &[no_error()], name);

        let counts = baker.bake_fractional(3, &()).unwrap();
        let quick =
            |(name, _): &(&str, _)| name.contains("lambert") || name.contains("phong ") || name.contains("diffuse");
        let lobes: Lobes = isotropic().into_iter().filter(quick).collect();
        let transport = Transport::bake_gray(&mesh, &baker, &layout, (3, 5), &()).unwrap();
        let fill = |vertex: usize, out: &mut [f32]| {
            let levels = counts.vertex(vertex).iter().map(|&count| (f64::from(count) * 31.0 / 9.0).round() / 31.0);
            out.iter_mut().zip(levels).for_each(|(out, level)| *out = level as f32);
        };
        let seen = TexelVisibility::Weights { grid: grid(32), fill: &fill };
        let what = format!("{name}, gray");
        shot.check(&seen, &transport, &isotropic(), &[PIXELS], &what);
        shot.check(&seen, &transport, &lobes, &[no_error()], &what);
    }
}

#[test]
fn every_side_and_block() {
    // 18 lobes, each on ten vertices.
    let mesh = soup(60);
    for (side, blocks) in [(32, [8, 16, 32]), (64, [8, 16, 32]), (128, [8, 16, 32])] {
        let shot = Shot { mesh: &mesh, view: view(), light: noisy(side, side) };
        for block in blocks {
            let maps = above(&mesh, side, patchwork(side, block, side));
            let transport = Transport::from_clipped(&maps, &layout(side, block, ScanOrder::Hilbert)).unwrap();
            let what = format!("{side}/{block}");
            shot.check(&TexelVisibility::Binary(&maps), &transport, &all(), &[PIXELS], &what);
        }
    }
}

/// Lobes that break off at a right angle to the mirror direction, and needles.
fn extreme_lobes(rules: &[Rule]) {
    let mesh = soup(60);
    let phong = |exponent: f64| lobe(Phong::new(RGB, exponent).unwrap());
    let lobes: Lobes = vec![
        ("phong 0", phong(0.0)),
        ("phong 0.05", phong(0.05)),
        ("phong 0.5", phong(0.5)),
        ("phong 1", phong(1.0)),
        ("phong 2", phong(2.0)),
        ("phong 10000", phong(1e4)),
    ];
    for block in [8, 16, 32] {
        let maps = above(&mesh, 32, |_, _| true);
        let transport = Transport::from_clipped(&maps, &layout(32, block, ScanOrder::Serpentine)).unwrap();
        let shot = Shot { mesh: &mesh, view: view(), light: noisy(32, 9) };
        shot.check(&TexelVisibility::Binary(&maps), &transport, &lobes, rules, &format!("blocks of {block}²"));
    }
}

#[test]
fn pixels_of_the_flattest_and_the_sharpest_lobes() {
    extreme_lobes(&[PIXELS]);
}

#[test]
fn no_error_of_the_flattest_and_the_sharpest_lobes() {
    extreme_lobes(&[no_error()]);
}
