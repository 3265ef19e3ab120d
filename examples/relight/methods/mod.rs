//! Runs the methods and measures them against ground truth.
//!
//! A method is one file: a type that holds its own options and implements [`Method`]. A line in [`methods!`] makes it
//! known.

mod block_product;
mod wavelet_double;
mod wavelet_triple;

use haarmonic::backend::DistantRelighter;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    BinaryVisibility, Comparison, GroundTruth, TexelVisibility, View, VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::{CubeGrid, CubeMap};
use serde_json::{Map, Value};

use crate::args::Args;
use crate::scene::{Scene, turn};
use crate::support::Failure;
use crate::support::progress::Bar;
use crate::support::timer::Timer;

/// Ground truth and every method's result.
pub struct Run {
    /// Radiance of each vertex at the truth's resolution.
    pub truth: Vec<Vector3<f64>>,
    pub results: Vec<Outcome>,
    pub visibility_s: f64,
}

/// What the ground truth is called among the methods.
pub const REFERENCE: &str = "reference";

/// A method that can be compared with ground truth.
pub trait Method {
    /// As `--method` and the report have it.
    fn name(&self) -> &'static str;

    /// Whether it is one of those that Inger 2013 compares.
    fn is_of_paper(&self) -> bool {
        false
    }

    /// What the types of its options do not say.
    fn check(&self, _: &Args) -> Result<(), String> {
        Ok(())
    }

    /// Bakes, runs the frames and measures.
    fn run(&self, stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure>;
}

/// The options of all methods, and the methods in the order of the report.
macro_rules! methods {
    ($($module:ident: $method:ident, $name:literal;)*) => {
        #[derive(Debug, clap::Args)]
        pub struct Methods {
            $(
                #[command(flatten)]
                $module: $module::$method,
            )*
        }

        impl Methods {
            /// What `--method` takes, but for `reference` and `all`.
            pub const NAMES: [&'static str; [$($name),*].len()] = [$($name),*];

            pub fn all(&self) -> [&dyn Method; Self::NAMES.len()] {
                [$(&self.$module),*]
            }
        }
    };
}

methods! {
    wavelet_double: WaveletDouble, "wavelet-double";
    wavelet_triple: WaveletTriple, "wavelet-triple";
    block_product: BlockProduct, "block-product";
}

/// One method's result.
pub struct Outcome {
    pub method: &'static str,
    pub radiance: Vec<Vector3<f32>>,
    pub comparison: Comparison,
    /// Seconds to bake what the method needs, visibility included.
    pub bake_s: f64,
    /// Median over the frames, milliseconds.
    pub relight_ms: f64,
    pub transport_bytes: usize,
    /// Kept terms of the light, for the methods that choose.
    pub light_terms: Option<usize>,
    /// What the picture's caption says of how it was made.
    pub caption: String,
    /// Keys of the report that only this method has.
    pub keys: Map<String, Value>,
    /// What only this method has to tell, as a table: its heading, names and values.
    pub details: Option<(String, Vec<[String; 2]>)>,
}

impl Run {
    pub fn new(args: &Args, scene: &Scene) -> Result<Self, Failure> {
        let grid = CubeGrid::new(args.resolution)?;
        let view = View::eye(scene.camera.eye().cast())?;
        let baker = VisibilityBaker::new(&scene.mesh, grid, VisibilitySettings::default())?;
        let bar = Bar::new("visibility");
        let visibility = baker.bake(&bar)?;
        let visibility_s = bar.finish();
        let stage = Stage {
            args,
            scene,
            view,
            grid,
            baker: &baker,
            visibility: &visibility,
            visibility_s,
            light: scene.light.to_cube(grid),
        };

        let bar = Bar::new("ground truth");
        let mut timer = Timer::default();
        let texels = TexelVisibility::Binary(&visibility);
        let reference = timer.time(|| stage.ground_truth(&stage.light, &texels, &bar))?;
        let reference_ms = timer.first();
        bar.finish();
        let truth = match args.truth_resolution {
            Some(side) if side != args.resolution => {
                let fine = baker.with_grid(CubeGrid::new(side)?);
                let bake = |vertex: usize, words: &mut [u64]| {
                    fine.bake_vertex(vertex, words, &mut fine.scratch());
                };
                let bar = Bar::new("ground truth, resolution of its own");
                let visibility = TexelVisibility::Words { grid: fine.grid(), fill: &bake };
                let truth = stage.ground_truth(&scene.light.to_cube(fine.grid()), &visibility, &bar)?;
                bar.finish();
                truth
            }
            _ => reference.clone(),
        };

        let mut results = Vec::new();
        if args.wants_reference() {
            let radiance: Vec<Vector3<f32>> = reference.iter().map(|l| l.cast()).collect();
            results.push(Outcome {
                method: REFERENCE,
                comparison: Comparison::new(&truth, &reference)?,
                radiance,
                bake_s: visibility_s,
                relight_ms: reference_ms,
                transport_bytes: size_of_val(visibility.words()),
                light_terms: None,
                caption: "every texel".to_owned(),
                keys: Map::new(),
                details: None,
            });
        }
        for method in args.methods.all().into_iter().filter(|method| args.wants(*method)) {
            results.push(method.run(&stage, &truth)?);
        }
        Ok(Self { truth, results, visibility_s })
    }
}

/// The frames of a method.
pub struct Frames {
    /// The first frame's.
    radiance: Vec<Vector3<f32>>,
    first_ms: f64,
    median_ms: f64,
}

/// What all methods share.
pub struct Stage<'a> {
    args: &'a Args,
    scene: &'a Scene,
    view: View,
    grid: CubeGrid,
    baker: &'a VisibilityBaker,
    visibility: &'a BinaryVisibility,
    visibility_s: f64,
    light: CubeMap<Vector3<f32>>,
}

impl Stage<'_> {
    fn ground_truth(
        &self,
        light: &CubeMap<Vector3<f32>>,
        visibility: &TexelVisibility,
        bar: &Bar,
    ) -> Result<Vec<Vector3<f64>>, Failure> {
        let Scene { mesh, materials, .. } = self.scene;
        Ok(GroundTruth { mesh, materials, view: &self.view, light }.radiance(visibility, bar)?)
    }

    /// What a caption says of a light that keeps few terms.
    fn terms(&self, kept: usize) -> String {
        format!("{kept} light terms ({}), by {:?}", self.args.terms, self.args.weighting).to_lowercase()
    }

    /// Times `count` frames, each under a light turned a little further.
    fn frames(&self, title: &'static str, count: usize, method: &mut dyn DistantRelighter) -> Result<Frames, Failure> {
        let mut radiance = Vec::new();
        let mut out = vec![Vector3::zeros(); self.scene.mesh.positions().len()];
        let mut timer = Timer::default();
        let bar = Bar::new(title);
        for i in 0..count {
            let light = match i {
                0 => self.light.clone(),
                _ => {
                    let rotation = turn(360.0 * i as f64 / count as f64) * self.scene.light.rotation();
                    self.scene.light.clone().with_rotation(rotation).to_cube(self.grid)
                }
            };
            timer.time(|| {
                method.set_light(&light)?;
                method.relight(&self.view, &self.scene.materials, &mut out)
            })?;
            if i == 0 {
                radiance.clone_from(&out);
            }
            haarmonic::Progress::advance(&bar, i + 1, count);
        }
        bar.finish();
        Ok(Frames { radiance, first_ms: timer.first(), median_ms: timer.median() })
    }
}
