//! Double and triple products of wavelets.

use haarmonic::backend::wavelet::{
    DoubleRelighter, DoubleSettings, DoubleTransport, Slices as BrdfSlices, TripleRelighter, TripleSettings,
    TripleTransport,
};
use haarmonic::haar::Weighting;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Comparison;

use super::{Outcome, Stage};
use crate::args::{Choice, Slices};
use crate::scene::Scene;
use crate::support::Failure;
use crate::support::progress::Bar;

fn weighting(choice: Choice) -> Weighting<'static, f32> {
    match choice {
        Choice::Magnitude => Weighting::Magnitude,
        Choice::Area => Weighting::Area,
        Choice::Integral => Weighting::Integral,
    }
}

/// Light × transport of a fixed view and fixed materials.
pub fn double(stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
    let Scene { mesh, materials, .. } = stage.scene;
    let bar = Bar::new("wavelet-double: transport");
    let settings = DoubleSettings::default();
    let transport = DoubleTransport::bake(mesh, stage.visibility, materials, &stage.view, &settings, &bar)?;
    let bake_s = stage.visibility_s + bar.finish();
    let mut relighter = DoubleRelighter::new(&transport)?;
    let mut light_terms = 0;
    let frames = stage.frames("wavelet-double: frames", stage.args.frames(), |light, out| {
        relighter.set_light(light, stage.args.terms, weighting(stage.args.weighting))?;
        relighter.relight(out);
        light_terms = relighter.light_terms();
        Ok(())
    })?;
    Ok(Outcome {
        method: "wavelet-double",
        comparison: Comparison::new(truth, &frames.radiance)?,
        radiance: frames.radiance,
        bake_s,
        relight_ms: frames.median_ms,
        transport_bytes: transport.bytes(),
        light_terms: Some(light_terms),
        blocks: None,
    })
}

/// Light × visibility × reflectance.
pub fn triple(stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
    let Scene { mesh, materials, .. } = stage.scene;
    let transport = TripleTransport::new(stage.visibility.clone())?;
    let slices = match stage.args.slices {
        Slices::Fly => BrdfSlices::Sampled,
        Slices::Table(side) => BrdfSlices::Tabulated(side),
    };
    let settings = TripleSettings { light_terms: stage.args.terms, brdf_terms: stage.args.terms, slices };
    let mut relighter = TripleRelighter::new(mesh, &transport, settings, weighting(stage.args.weighting))?;
    let mut light_terms = 0;
    let frames = stage.frames("wavelet-triple: frames", stage.args.frames(), |light, out| {
        relighter.set_light(light)?;
        relighter.relight(&stage.view, materials, out)?;
        light_terms = relighter.light_terms();
        Ok(())
    })?;
    Ok(Outcome {
        method: "wavelet-triple",
        comparison: Comparison::new(truth, &frames.radiance)?,
        radiance: frames.radiance,
        bake_s: stage.visibility_s,
        relight_ms: frames.median_ms,
        transport_bytes: transport.bytes() + relighter.table_bytes(),
        light_terms: Some(light_terms),
        blocks: None,
    })
}
