//! Errors, and what they cost.

use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Occluders;
use serde_json::{Value, json};

use crate::args::Args;
use crate::samplers::{Method, Samplers};
use crate::scene::Scene;
use crate::support::progress::Bar;
use crate::support::{Failure, table};

/// Pictures of as many runs, with other numbers, are compared with the reference.
const RUNS: u32 = 3;

/// The reference and every method.
pub struct Run {
    pub truth: Vec<Vector3<f32>>,
    pub outcomes: Vec<Outcome>,
}

/// What a method did.
pub struct Outcome {
    pub method: Method,
    pub pixels: Vec<Vector3<f32>>,
    /// Root mean square over the pixels that show the object and over the channels.
    pub rmse: f64,
    pub rmse_ratio_to_light: f64,
    pub samples_for_equal_error: f64,
    pub us_per_pixel: f64,
}

pub fn run(
    args: &Args,
    scene: &Scene,
    samplers: &Samplers,
    occluders: Option<&Occluders>,
    title: &'static str,
) -> Result<Run, Failure> {
    let bar = Bar::new(title);
    let truth = samplers.truth(scene, occluders, args.truth, &bar)?;
    bar.finish();
    let mut outcomes = Vec::new();
    for method in Method::ALL {
        let bar = Bar::new(method.name());
        let runs: Vec<_> = (0..RUNS).map(|run| samplers.estimate(method, args, scene, occluders, run)).collect();
        bar.finish();
        let squares: f64 = runs.iter().map(|(pixels, _)| mean_square(scene, &truth, pixels)).sum();
        let us_per_pixel = runs.iter().map(|(_, us)| *us).fold(f64::INFINITY, f64::min);
        let pixels = runs.into_iter().next().expect("there is a run").0;
        let rmse = (squares / f64::from(RUNS)).sqrt();
        outcomes.push(Outcome {
            method,
            pixels,
            rmse,
            rmse_ratio_to_light: 0.0,
            samples_for_equal_error: 0.0,
            us_per_pixel,
        });
    }
    let rmse_of = |method: Method| outcomes.iter().find(|o| o.method == method).map_or(f64::NAN, |o| o.rmse);
    let (light, best) = (rmse_of(Method::LightRadiance), rmse_of(Method::Window));
    for outcome in &mut outcomes {
        outcome.rmse_ratio_to_light = outcome.rmse / light;
        // The variance falls with one over the number of samples.
        outcome.samples_for_equal_error = args.spp as f64 * (outcome.rmse / best).powi(2);
    }
    Ok(Run { truth, outcomes })
}

fn mean_square(scene: &Scene, truth: &[Vector3<f32>], pixels: &[Vector3<f32>]) -> f64 {
    let glossy = scene.places.iter().map(|place| place.is_some_and(|place| place.brdf == 1));
    let squares = truth.iter().zip(pixels).zip(glossy).filter(|(_, glossy)| *glossy);
    let sum: f64 = squares.map(|((a, b), _)| f64::from((a - b).norm_squared())).sum();
    sum / (3 * scene.glossy().max(1)) as f64
}

impl Run {
    pub fn table(&self) -> String {
        let header = ["sampler", "RMSE", "of light sampling's", "samples for equal error", "µs a pixel"];
        let row = |o: &Outcome| {
            vec![
                o.method.name().to_owned(),
                format!("{:.4}", o.rmse),
                format!("{:.3}", o.rmse_ratio_to_light),
                format!("{:.0}", o.samples_for_equal_error),
                format!("{:.1}", o.us_per_pixel),
            ]
        };
        table::format(&header, &self.outcomes.iter().map(row).collect::<Vec<_>>())
    }

    pub fn keys<'a>(&'a self, shadows: &'a str) -> impl Iterator<Item = Value> + 'a {
        self.outcomes.iter().map(move |o| {
            json!({
                "method": o.method.name(),
                "visibility": shadows,
                "rmse": o.rmse,
                "rmse_ratio_to_light": o.rmse_ratio_to_light,
                "samples_for_equal_error": o.samples_for_equal_error,
                "us_per_pixel": o.us_per_pixel,
            })
        })
    }
}
