//! Lights at both ends of the range of `f32` in the wavelet back end.

use haarmonic::backend::wavelet_double::{self as double, Precision};
use haarmonic::backend::wavelet_triple::{self as triple, Slices};
use haarmonic::haar::{Keep, Weighting};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Mesh;
use haarmonic::scene::{
    BinaryVisibility, EnvironmentLight, Lambert, Materials, Procedural, Sky, View, VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::{CubeGrid, CubeMap};

type Radiance = Vec<Vector3<f32>>;

struct Stage {
    mesh: Mesh,
    visibility: BinaryVisibility,
    materials: Materials,
    view: View,
}

impl Stage {
    fn new() -> Self {
        let model = Procedural::StackedSpheres.build(1000).unwrap();
        let grid = CubeGrid::new(8).unwrap();
        let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).unwrap();
        let visibility = baker.bake(&()).unwrap();
        let materials = Materials::uniform(Lambert::new([0.8, 0.5, 0.1]).unwrap());
        let view = View::eye(model.camera.eye().cast()).unwrap();
        Self { mesh: model.mesh, visibility, materials, view }
    }

    /// What each kind of transport and of slices makes of a light.
    fn relight(&self, light: &CubeMap<Vector3<f32>>) -> Vec<(String, Radiance)> {
        let dark = || vec![Vector3::repeat(f32::NAN); self.mesh.positions().len()];
        let mut all = Vec::new();
        for precision in [Precision::Full, Precision::Bits16, Precision::Bits8] {
            let settings = double::BakeSettings { precision, ..double::BakeSettings::default() };
            let transport =
                double::Transport::bake(&self.mesh, &self.visibility, &self.view, &self.materials, settings, &());
            let transport = transport.unwrap();
            for weighting in [Weighting::Area, Weighting::Magnitude] {
                let settings = double::Settings { light_terms: Keep::Fraction(0.2), weighting };
                let mut relighter = double::Relighter::new(&transport, settings).unwrap();
                relighter.set_light(light).unwrap();
                let mut out = dark();
                relighter.relight(&self.view, &self.materials, &mut out).unwrap();
                all.push((format!("{precision:?}"), out));
            }
        }
        let transport = triple::Transport::from_binary(self.visibility.clone()).unwrap();
        for slices in [Slices::Sampled, Slices::Tabulated(8)] {
            for terms in [Keep::Fraction(1.0), Keep::Fraction(0.2)] {
                let weighting = Weighting::Magnitude;
                let settings = triple::Settings { light_terms: terms, brdf_terms: terms, weighting, slices };
                let mut relighter = triple::Relighter::new(&self.mesh, &transport, settings).unwrap();
                relighter.set_light(light).unwrap();
                let mut out = dark();
                relighter.relight(&self.view, &self.materials, &mut out).unwrap();
                all.push((format!("{slices:?}, {terms}"), out));
            }
        }
        all
    }
}

fn scaled(light: &CubeMap<Vector3<f32>>, factor: f64) -> CubeMap<Vector3<f32>> {
    light.map(|t| t.map(|c| (f64::from(c) * factor) as f32))
}

#[test]
fn radiance_scales_with_the_light_over_the_whole_range() {
    let stage = Stage::new();
    let light = EnvironmentLight::from_sky(Sky::studio()).unwrap().to_cube(CubeGrid::new(8).unwrap());
    // Its brightest texel is in [1, 2).
    let brightest = light.texels().iter().map(Vector3::amax).fold(0.0, f32::max);
    let light = scaled(&light, 2f64.powi(-brightest.log2().floor() as i32));
    let expected = stage.relight(&light);
    for exponent in [-148, -140, -126, -100, -41, -39, 39, 41, 100, 120, 126, 127] {
        let factor = 2f64.powi(exponent);
        let got = stage.relight(&scaled(&light, factor));
        for ((what, expected), (_, got)) in expected.iter().zip(&got) {
            for (v, (expected, got)) in expected.iter().zip(got).enumerate() {
                for c in 0..3 {
                    let right = f64::from(expected[c]) * factor;
                    // The same bits, times a power of two, where light and radiance are normal. Below, the light's
                    // texels are rounded to 2⁻¹⁴⁹ each and the radiance once; texels count with 3 at most in all.
                    let tolerance = if exponent < -100 { 8.0 * 2f64.powi(-149) } else { 0.0 };
                    let right = right.min(f64::from(f32::MAX));
                    let off = (f64::from(got[c]) - right).abs();
                    assert!(off <= tolerance, "{what}, 2^{exponent}, vertex {v}: {} instead of {right}", got[c]);
                }
            }
        }
    }
}

/// A uniform light of 2.6e33 and of the largest number, by which what has an albedo of 0.8 sends 0.8 times as much.
#[test]
fn the_brightest_lights_are_finite() {
    let stage = Stage::new();
    let grid = CubeGrid::new(8).unwrap();
    for value in [2.6e33, 1e37, 8.5e37, f32::MAX] {
        let light = CubeMap::from_fn(grid, |_| Vector3::repeat(value));
        for (what, radiance) in stage.relight(&light) {
            let brightest = radiance.iter().map(|l| l.x).fold(0.0, f32::max) / value;
            assert!(radiance.iter().all(|l| l.iter().all(|c| c.is_finite())), "{what}, {value}");
            // The top of a convex body; 8² texels a face integrate the cosine to 1 %, 20 % of the terms to 10 %.
            assert!((0.7..0.9).contains(&brightest), "{what}, {value}: {brightest}");
        }
    }
}

/// A file with such a light, through the whole chain.
#[cfg(feature = "io")]
#[test]
fn a_bright_picture_is_read_and_lights() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/faults/pictures/bright.hdr");
    let light = haarmonic::io::load_environment(path).unwrap().value.to_cube(CubeGrid::new(8).unwrap());
    for (what, radiance) in Stage::new().relight(&light) {
        let brightest = radiance.iter().map(|l| l.x).fold(0.0, f32::max);
        assert!(radiance.iter().all(|l| l.iter().all(|c| c.is_finite())), "{what}");
        assert!((1.8e33..2.4e33).contains(&brightest), "{what}: {brightest}");
    }
}

#[test]
fn darkness_and_what_is_not_finite() {
    let stage = Stage::new();
    let grid = CubeGrid::new(8).unwrap();
    for (_, radiance) in stage.relight(&CubeMap::from_fn(grid, |_| Vector3::zeros())) {
        assert!(radiance.iter().all(|l| *l == Vector3::zeros()));
    }
    let transport = triple::Transport::from_binary(stage.visibility.clone()).unwrap();
    let mut relighter = triple::Relighter::new(&stage.mesh, &transport, triple::Settings::default()).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut light = CubeMap::from_fn(grid, |_| Vector3::repeat(1e38));
        light.texels_mut()[7].y = bad;
        assert!(matches!(relighter.set_light(&light), Err(haarmonic::Error::NotFinite { index: 7, .. })), "{bad}");
    }
}
