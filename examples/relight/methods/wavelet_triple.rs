//! Light × visibility × reflectance.

use haarmonic::backend::wavelet_triple::{Relighter, Settings, Slices as BrdfSlices, Transport};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Comparison;

use super::{Outcome, Stage};
use crate::args::Slices;
use crate::scene::Scene;
use crate::support::Failure;

/// Runs the frames.
pub fn run(stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
    let Scene { mesh, .. } = stage.scene;
    let transport = Transport::from_binary(stage.visibility.clone())?;
    let slices = match stage.args.slices {
        Slices::Fly => BrdfSlices::Sampled,
        Slices::Table(side) => BrdfSlices::Tabulated(side),
    };
    let (terms, weighting) = (stage.args.terms, stage.args.weighting.into());
    let settings = Settings { light_terms: terms, brdf_terms: terms, weighting, slices };
    let mut relighter = Relighter::new(mesh, &transport, settings)?;
    let frames = stage.frames("wavelet-triple: frames", stage.args.frames(), &mut relighter)?;
    Ok(Outcome {
        method: "wavelet-triple",
        comparison: Comparison::new(truth, &frames.radiance)?,
        radiance: frames.radiance,
        bake_s: stage.visibility_s,
        relight_ms: frames.median_ms,
        transport_bytes: transport.bytes() + relighter.bytes(),
        light_terms: Some(relighter.light_terms()),
        blocks: None,
    })
}
