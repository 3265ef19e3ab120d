//! Runs the methods and measures them against ground truth.

use std::time::Instant;

use haarmonic::backend::wavelet::{
    DoubleRelighter, DoubleSettings, DoubleTransport, Slices as BrdfSlices, TripleRelighter, TripleSettings,
    TripleTransport,
};
use haarmonic::haar::Weighting;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    BinaryVisibility, Comparison, GroundTruth, TexelVisibility, View, VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::{CubeGrid, CubeMap};

use crate::args::{Args, Choice, Method, Slices};
use crate::scene::{Scene, turn};
use crate::support::Failure;
use crate::support::progress::Bar;

/// Ground truth and every method's result.
pub struct Run {
    /// Radiance of each vertex at the truth's resolution.
    pub truth: Vec<Vector3<f64>>,
    pub results: Vec<Outcome>,
    pub visibility_s: f64,
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
}

impl Run {
    pub fn new(args: &Args, scene: &Scene) -> Result<Self, Failure> {
        let grid = CubeGrid::new(args.resolution)?;
        let view = View::eye(scene.camera.eye().cast())?;
        let baker = VisibilityBaker::new(&scene.mesh, grid, VisibilitySettings::default())?;
        let bar = Bar::new("visibility");
        let visibility = baker.bake(&bar)?;
        let visibility_s = bar.finish();
        let stage =
            Stage { args, scene, view, grid, visibility: &visibility, visibility_s, light: scene.light.to_cube(grid) };

        let bar = Bar::new("ground truth");
        let start = Instant::now();
        let reference = stage.ground_truth(&stage.light, &TexelVisibility::Binary(&visibility), &bar)?;
        let reference_ms = start.elapsed().as_secs_f64() * 1e3;
        bar.finish();
        let truth = match args.truth_resolution {
            Some(side) if side != args.resolution => {
                let fine = baker.with_grid(CubeGrid::new(side)?);
                let bake = |vertex: usize, words: &mut [u64]| {
                    fine.bake_vertex(vertex, words);
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
        let wants = |method| args.method == Method::All || args.method == method;
        if wants(Method::Reference) {
            let radiance: Vec<Vector3<f32>> = reference.iter().map(|l| l.cast()).collect();
            results.push(Outcome {
                method: "reference",
                comparison: Comparison::new(&truth, &reference)?,
                radiance,
                bake_s: visibility_s,
                relight_ms: reference_ms,
                transport_bytes: size_of_val(visibility.words()),
                light_terms: None,
            });
        }
        if wants(Method::WaveletDouble) {
            results.push(stage.double(&truth)?);
        }
        if wants(Method::WaveletTriple) {
            results.push(stage.triple(&truth)?);
        }
        Ok(Self { truth, results, visibility_s })
    }
}

/// What all methods share.
struct Stage<'a> {
    args: &'a Args,
    scene: &'a Scene,
    view: View,
    grid: CubeGrid,
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

    fn weighting(&self) -> Weighting<'static, f32> {
        match self.args.weighting {
            Choice::Magnitude => Weighting::Magnitude,
            Choice::Area => Weighting::Area,
            Choice::Integral => Weighting::Integral,
        }
    }

    fn double(&self, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
        let Scene { mesh, materials, .. } = self.scene;
        let bar = Bar::new("wavelet-double: transport");
        let settings = DoubleSettings::default();
        let transport = DoubleTransport::bake(mesh, self.visibility, materials, &self.view, &settings, &bar)?;
        let bake_s = self.visibility_s + bar.finish();
        let mut relighter = DoubleRelighter::new(&transport)?;
        let mut light_terms = 0;
        let (radiance, relight_ms) = self.frames("wavelet-double: frames", |light, out| {
            relighter.set_light(light, self.args.terms, self.weighting())?;
            relighter.relight(out);
            light_terms = relighter.light_terms();
            Ok(())
        })?;
        let comparison = Comparison::new(truth, &radiance)?;
        let transport_bytes = transport.bytes();
        let light_terms = Some(light_terms);
        Ok(Outcome { method: "wavelet-double", radiance, comparison, bake_s, relight_ms, transport_bytes, light_terms })
    }

    fn triple(&self, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
        let Scene { mesh, materials, .. } = self.scene;
        let transport = TripleTransport::new(self.visibility.clone())?;
        let slices = match self.args.slices {
            Slices::Fly => BrdfSlices::Sampled,
            Slices::Table(side) => BrdfSlices::Tabulated(side),
        };
        let settings = TripleSettings { light_terms: self.args.terms, brdf_terms: self.args.terms, slices };
        let mut relighter = TripleRelighter::new(mesh, &transport, settings, self.weighting())?;
        let mut light_terms = 0;
        let (radiance, relight_ms) = self.frames("wavelet-triple: frames", |light, out| {
            relighter.set_light(light)?;
            relighter.relight(&self.view, materials, out)?;
            light_terms = relighter.light_terms();
            Ok(())
        })?;
        Ok(Outcome {
            method: "wavelet-triple",
            comparison: Comparison::new(truth, &radiance)?,
            radiance,
            bake_s: self.visibility_s,
            relight_ms,
            transport_bytes: transport.bytes() + relighter.table_bytes(),
            light_terms: Some(light_terms),
        })
    }

    /// The first frame's radiance and the median milliseconds of all frames, each under a light turned a little further.
    fn frames(
        &self,
        title: &'static str,
        mut frame: impl FnMut(&CubeMap<Vector3<f32>>, &mut [Vector3<f32>]) -> Result<(), Failure>,
    ) -> Result<(Vec<Vector3<f32>>, f64), Failure> {
        let mut first = Vec::new();
        let mut out = vec![Vector3::zeros(); self.scene.mesh.positions().len()];
        let mut times = Vec::new();
        let bar = Bar::new(title);
        for i in 0..self.args.frames {
            let light = match i {
                0 => self.light.clone(),
                _ => {
                    let angle = 360.0 * i as f64 / self.args.frames as f64;
                    let rotation = turn(angle) * self.scene.light.rotation();
                    self.scene.light.clone().with_rotation(rotation).to_cube(self.grid)
                }
            };
            let start = Instant::now();
            frame(&light, &mut out)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
            if i == 0 {
                first.clone_from(&out);
            }
            haarmonic::Progress::advance(&bar, i + 1, self.args.frames);
        }
        bar.finish();
        Ok((first, median(&mut times)))
    }
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    let middle = times.len() / 2;
    if times.len() % 2 == 1 { times[middle] } else { 0.5 * (times[middle - 1] + times[middle]) }
}
