//! Light × transport of a fixed view and fixed materials.

use haarmonic::backend::wavelet_double::{BakeSettings, Relighter, Settings, Transport};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Comparison;
use serde_json::Map;

use super::{Method, Outcome, Stage};
use crate::scene::Scene;
use crate::support::Failure;
use crate::support::progress::Bar;

/// It has no options of its own.
#[derive(Debug, clap::Args)]
pub struct WaveletDouble {}

impl Method for WaveletDouble {
    fn name(&self) -> &'static str {
        "wavelet-double"
    }

    fn run(&self, stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
        let Scene { mesh, materials, .. } = stage.scene;
        let bar = Bar::new("wavelet-double: transport");
        let settings = BakeSettings::default();
        let transport = Transport::bake(mesh, stage.visibility, &stage.view, materials, settings, &bar)?;
        let bake_s = stage.visibility_s + bar.finish();
        let settings = Settings { light_terms: stage.args.terms, weighting: stage.args.weighting.into() };
        let mut relighter = Relighter::new(&transport, settings)?;
        let frames = stage.frames("wavelet-double: frames", stage.args.frames(), &mut relighter)?;
        Ok(Outcome {
            method: self.name(),
            comparison: Comparison::new(truth, &frames.radiance)?,
            radiance: frames.radiance,
            bake_s,
            relight_ms: frames.median_ms,
            transport_bytes: transport.bytes(),
            light_terms: Some(relighter.light_terms()),
            caption: stage.terms(relighter.light_terms()),
            keys: Map::new(),
            details: None,
        })
    }
}
