//! BRDFs of which nothing is known but their values.

use std::sync::Arc;

use haarmonic::Error;
use haarmonic::backend::block_product::{Relighter, Rule, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Brdf, BrdfFn, Comparison, CookTorrance, GroundTruth, Procedural, Sky, TexelVisibility, View};

use super::support::{above, frame, in_turn, layout, lobe, of_sky, patchwork, sky, view};
use crate::support::{baker, noisy, soup};

const RGB: [f64; 3] = [0.8, 0.5, 0.2];

fn constant() -> Arc<dyn Brdf> {
    lobe(BrdfFn::new(|_: &Vector3<f64>, _: &Vector3<f64>| Vector3::from(RGB) / std::f64::consts::PI))
}

/// A single sample of what is constant is exact: the cosine is weighed apart.
#[test]
fn a_constant_closure_is_exact() {
    let mesh = soup(60);
    for (block, tolerance) in [(8, 0.1), (16, 0.1), (16, 1e-3), (32, 0.1), (16, 0.0)] {
        let maps = above(&mesh, 32, patchwork(32, block, 5));
        let transport = Transport::from_binary(&mesh, &maps, &layout(32, block, ScanOrder::Serpentine)).unwrap();
        let settings = Settings { rule: Rule::bounded(tolerance).unwrap(), ..Settings::default() };
        for light in [sky(32), noisy(32, 4), of_sky(Sky::sunset(), 32)] {
            let (view, materials) = (view(), in_turn(&[constant()], mesh.positions().len()));
            let truth = GroundTruth { mesh: &mesh, materials: &materials, view: &view, light: &light };
            let truth = truth.radiance(&TexelVisibility::Binary(&maps), &()).unwrap();
            let got = frame((&mesh, &transport), settings, &light, &view, &materials);
            let error = Comparison::new(&truth, &got).unwrap().rel_l2;
            // Sums in f32.
            assert!(error <= 1e-6, "blocks of {block}, tolerance {tolerance}: off by {error:e}");
        }
    }
}

/// The same lobe as a model and as a closure of it is about as good, and so are closures of other kinds.
#[test]
fn a_closure_is_as_good_as_its_model() {
    let model = Procedural::Table.build(1000).unwrap();
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let maps = baker(&model.mesh, 64).bake(&()).unwrap();
    let transport = Transport::from_binary(&model.mesh, &maps, &layout(64, 16, ScanOrder::Serpentine)).unwrap();
    let light = sky(64);
    let ggx = CookTorrance::isotropic([0.5; 3], 0.25).unwrap();
    let glossy = |wi: &Vector3<f64>, wo: &Vector3<f64>| {
        let cosine = (wi.z * wo.z - wi.x * wo.x - wi.y * wo.y).max(0.0);
        Vector3::new(0.2, 0.1, 0.05) + Vector3::repeat(1.5 * cosine.powi(20))
    };
    let brushed = |wi: &Vector3<f64>, wo: &Vector3<f64>| {
        let h = (wi + wo).normalize();
        Vector3::repeat(0.05 + 0.6 * (-(h.x / 0.2).powi(2) - (h.y / 0.6).powi(2)).exp())
    };
    let error = |brdf: Arc<dyn Brdf>| {
        let materials = in_turn(&[brdf], model.mesh.positions().len());
        let truth = GroundTruth { mesh: &model.mesh, materials: &materials, view: &view, light: &light };
        let truth = truth.radiance(&TexelVisibility::Binary(&maps), &()).unwrap();
        let got = frame((&model.mesh, &transport), Settings::default(), &light, &view, &materials);
        Comparison::new(&truth, &got).unwrap().rel_l2
    };
    let of_model = error(lobe(ggx));
    let of_closure = error(lobe(BrdfFn::new(move |wi: &Vector3<f64>, wo: &Vector3<f64>| ggx.eval(wi, wo))));
    let [glossy, brushed] = [error(lobe(BrdfFn::new(glossy))), error(lobe(BrdfFn::new(brushed)))];
    // Measured .0153 and .0160, .0070, .0063.
    assert!(of_closure <= 1.5 * of_model, "a closure of GGX: {of_closure}, GGX: {of_model}");
    assert!(glossy <= 1e-2 && brushed <= 1e-2, "{glossy} {brushed}");
}

/// NaN is no light: no rule makes something plausible of it.
#[test]
fn a_closure_that_gives_nan_is_named() {
    let mesh = soup(4);
    let maps = above(&mesh, 32, |_, _| true);
    let transport = Transport::from_binary(&mesh, &maps, &layout(32, 16, ScanOrder::Serpentine)).unwrap();
    let everywhere = |_: &Vector3<f64>, _: &Vector3<f64>| Vector3::repeat(f64::NAN);
    let one_channel =
        |wi: &Vector3<f64>, _: &Vector3<f64>| Vector3::new(0.1, if wi.z > 0.5 { f64::NAN } else { 0.2 }, 0.3);
    for brdf in [lobe(BrdfFn::new(everywhere)), lobe(BrdfFn::new(one_channel))] {
        let materials = in_turn(&[brdf], mesh.positions().len());
        for rule in [Rule::default(), Rule::bounded(0.0).unwrap(), Rule::Pixels] {
            let mut relighter = Relighter::new(&mesh, &transport, Settings { rule, ..Settings::default() }).unwrap();
            relighter.set_light(&sky(32)).unwrap();
            let mut out = vec![Vector3::zeros(); mesh.positions().len()];
            let got = relighter.relight(&view(), &materials, &mut out);
            assert!(matches!(got, Err(Error::NotFinite { what: "value of BRDF", index: 0 })), "{rule:?}: {got:?}");
        }
    }
}
