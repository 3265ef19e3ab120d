//! Light × visibility × reflectance.

use haarmonic::backend::wavelet_triple::{Relighter, Settings, Slices, Transport};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Comparison;
use serde_json::Map;

use super::{Method, Outcome, Stage};
use crate::support::Failure;

#[derive(Debug, clap::Args)]
pub struct WaveletTriple {
    /// wavelet-triple: slices of the BRDF, sampled for each vertex (`fly`), or from a table of N² × 6 normals
    #[arg(long, value_name = "fly|N", default_value = "fly", value_parser = slices)]
    slices: Slices,
}

fn slices(text: &str) -> Result<Slices, String> {
    match text {
        "fly" => Ok(Slices::Sampled),
        _ => text.parse().map(Slices::Tabulated).map_err(|_| "expected `fly` or a number of texels such as 32".into()),
    }
}

impl Method for WaveletTriple {
    fn name(&self) -> &'static str {
        "wavelet-triple"
    }

    fn is_of_paper(&self) -> bool {
        true
    }

    fn run(&self, stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
        let transport = Transport::from_binary(stage.visibility.clone())?;
        let (terms, weighting) = (stage.args.terms, stage.args.weighting.into());
        let settings = Settings { light_terms: terms, brdf_terms: terms, weighting, slices: self.slices };
        let mut relighter = Relighter::new(&stage.scene.mesh, &transport, settings)?;
        let frames = stage.frames("wavelet-triple: frames", stage.args.frames(), &mut relighter)?;
        Ok(Outcome {
            method: self.name(),
            comparison: Comparison::new(truth, &frames.radiance)?,
            radiance: frames.radiance,
            bake_s: stage.visibility_s,
            relight_ms: frames.median_ms,
            transport_bytes: transport.bytes() + relighter.bytes(),
            light_terms: Some(relighter.light_terms()),
            caption: stage.terms(relighter.light_terms()),
            keys: Map::new(),
            details: None,
        })
    }
}
