//! Locally adaptive products, and the same transport pixel by pixel as their baseline.

use clap::ValueEnum;
use haarmonic::backend::block_product::{
    BlockAngle, BlockLayout, FrameStats, Relighter, Rule, Settings, Transport, TransportStats,
};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Comparison;
use serde_json::{Map, Value, json};

use super::{Frames, Method, Outcome, Stage};
use crate::args::Args;
use crate::scene::Scene;
use crate::support::Failure;
use crate::support::progress::Bar;

/// Frames of the baseline: it takes its time, and the same in each.
const BASELINE_FRAMES: usize = 2;

#[derive(Debug, clap::Args)]
pub struct BlockProduct {
    /// block-product: edge of a block in texels, 8, 16 or 32 [default: 16, or the resolution if that is less]
    #[arg(long, value_name = "N")]
    block: Option<usize>,

    /// block-product: what chooses how many samples a block of reflectance gets
    #[arg(long, value_enum, default_value = "bounded")]
    rule: Sampling,

    /// block-product, rule bounded: error of a vertex in units of the light's mean radiance; less is better and slower
    #[arg(long, value_name = "T", default_value_t = tolerance(), allow_negative_numbers = true)]
    tolerance: f64,

    /// block-product: visibility of 2^B levels, B from 2 to 8, instead of two. The ground truth it is compared with
    /// keeps two levels, as for the other methods; with a larger --truth-resolution the gain shows
    #[arg(long, value_name = "B")]
    visibility_bits: Option<u32>,

    /// block-product: rays along a texel's edge for --visibility-bits, from 1 to 15 (S² rays a texel)
    #[arg(long, value_name = "S", default_value_t = 4, requires = "visibility_bits")]
    visibility_samples: usize,
}

/// The back end's own.
fn tolerance() -> f64 {
    match Rule::default() {
        Rule::Bounded { tolerance } => tolerance,
        _ => 0.0,
    }
}

/// What chooses the samples of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Sampling {
    /// The fewest within --tolerance
    Bounded,
    /// By the angle to the mirror direction, as the paper prints it
    Fixed,
    /// The same with the angle lessened by the block's radius
    FixedSound,
    /// Every pixel: the baseline
    Pixels,
}

impl Sampling {
    /// The name on the command line.
    fn name(self) -> &'static str {
        match self {
            Self::Bounded => "bounded",
            Self::Fixed => "fixed",
            Self::FixedSound => "fixed-sound",
            Self::Pixels => "pixels",
        }
    }
}

/// What the frames told.
struct Measured {
    transport: TransportStats,
    frame: FrameStats,
    frames: Frames,
    /// What the relighter holds beside the transport.
    relighter_bytes: usize,
    /// Milliseconds of a frame pixel by pixel; none if that is the method itself.
    baseline_ms: Option<f64>,
}

impl Method for BlockProduct {
    fn name(&self) -> &'static str {
        "block-product"
    }

    fn is_of_paper(&self) -> bool {
        true
    }

    fn check(&self, args: &Args) -> Result<(), String> {
        if args.resolution < 8 {
            return Err(format!("--resolution must be at least 8 for block-product, got {}", args.resolution));
        }
        let block = self.side(args);
        if ![8, 16, 32].contains(&block) || block > args.resolution {
            return Err(format!("--block must be 8, 16 or 32 and at most --resolution, got {block}"));
        }
        if !(self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return Err(format!("--tolerance must be a finite number of at least 0, got {}", self.tolerance));
        }
        if let Some(bits) = self.visibility_bits.filter(|bits| !(2..=8).contains(bits)) {
            return Err(format!("--visibility-bits must be in 2...8, got {bits}"));
        }
        if !(1..=15).contains(&self.visibility_samples) {
            return Err(format!("--visibility-samples must be in 1...15, got {}", self.visibility_samples));
        }
        Ok(())
    }

    /// Bakes, runs the frames, counts their blocks and times the baseline.
    fn run(&self, stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
        let Stage { args, scene: Scene { mesh, materials, .. }, .. } = stage;
        let (transport, bake_s) = self.bake(stage)?;
        let mut relighter = Relighter::new(mesh, &transport, Settings { rule: self.rule()?, ..Settings::default() })?;
        let frames = stage.frames("block-product: frames", args.frames(), &mut relighter)?;
        // Of the first frame, whose radiance is shown.
        relighter.set_light(&stage.light)?;
        let frame = relighter.frame_stats(&stage.view, materials)?;
        let baseline_ms = match self.rule {
            Sampling::Pixels => None,
            _ => Some(baseline(stage, &transport)?),
        };
        let (relighter_bytes, transport) = (relighter.bytes(), transport.stats());
        let measured = Measured { transport, frame, frames, relighter_bytes, baseline_ms };
        Ok(Outcome {
            method: self.name(),
            comparison: Comparison::new(truth, &measured.frames.radiance)?,
            bake_s,
            relight_ms: measured.frames.median_ms,
            transport_bytes: measured.transport.coded.bytes_in_memory,
            light_terms: None,
            caption: self.caption(args),
            keys: self.keys(args, &measured),
            details: Some((self.caption(args), self.details(args, &measured))),
            radiance: measured.frames.radiance,
        })
    }
}

impl BlockProduct {
    /// Edge of a block in texels.
    fn side(&self, args: &Args) -> usize {
        self.block.unwrap_or(args.resolution.min(16))
    }

    fn rule(&self) -> Result<Rule, Failure> {
        Ok(match self.rule {
            Sampling::Bounded => Rule::bounded(self.tolerance)?,
            Sampling::Fixed => Rule::Fixed { angle: BlockAngle::Centre },
            Sampling::FixedSound => Rule::Fixed { angle: BlockAngle::Nearest },
            Sampling::Pixels => Rule::Pixels,
        })
    }

    /// The transport and the seconds that it took from the mesh.
    fn bake(&self, stage: &Stage) -> Result<(Transport, f64), Failure> {
        let layout = BlockLayout::new(stage.grid, self.side(stage.args), ScanOrder::Serpentine)?;
        let Some(bits) = self.visibility_bits else {
            let bar = Bar::new("block-product: coding");
            let transport = Transport::from_binary(&stage.scene.mesh, stage.visibility, &layout)?;
            return Ok((transport, stage.visibility_s + bar.finish()));
        };
        let bar = Bar::new("block-product: gray visibility");
        let levels = (self.visibility_samples, bits);
        let transport = Transport::bake_gray(&stage.scene.mesh, stage.baker, &layout, levels, &bar)?;
        Ok((transport, bar.finish()))
    }

    /// The blocks and what chooses their samples.
    fn caption(&self, args: &Args) -> String {
        let (side, rule) = (self.side(args), self.rule.name());
        match self.rule {
            Sampling::Bounded => format!("blocks of {side} × {side}, {rule} by {}", self.tolerance),
            _ => format!("blocks of {side} × {side}, {rule}"),
        }
    }

    fn details(&self, args: &Args, measured: &Measured) -> Vec<[String; 2]> {
        let list = |values: [f64; 4]| values.map(|v| format!("{v:.1}")).join(" / ");
        let (stats, all) = (&measured.transport, self.side(args).pow(2));
        let bytes = [stats.coded.bytes_in_memory, stats.coded.bytes_in_file, measured.relighter_bytes];
        let bytes = bytes.map(|bytes| format!("{:.0}", bytes as f64 / stats.vertices as f64)).join(" / ");
        let frames = &measured.frames;
        let millions = |ms: f64| format!("{:.3}", rate(stats.vertices, ms) / 1e6);
        let row = |name: &str, value: String| [name.to_owned(), value];
        let mut rows = vec![
            row("blocks: zero / one DCT / constant BRDF / triple, %", list(measured.frame.case_percent())),
            row(&format!("samples of BRDF: 1 / 4 / 16 / {all}, %"), list(measured.frame.samples_percent())),
            row("coefficients a partly hidden block", format!("{:.1}", stats.coded.mean_changes_of_mixed())),
            row("bytes a vertex: memory / file / relighter", bytes),
            row("first frame, with the materials' tables, ms", format!("{:.1}", frames.first_ms)),
            row("million vertices a second", millions(frames.median_ms)),
        ];
        if let Some(ms) = measured.baseline_ms {
            rows.push(row("pixel by pixel: ms a frame", format!("{ms:.1}")));
            rows.push(row("pixel by pixel: million vertices a second", millions(ms)));
            rows.push(row("speed-up", format!("{:.1}", ms / frames.median_ms)));
        }
        rows
    }

    fn keys(&self, args: &Args, measured: &Measured) -> Map<String, Value> {
        let (stats, side) = (&measured.transport, self.side(args));
        let [zero, one_dct, constant_brdf, triple] = measured.frame.case_percent();
        let cases = json!({ "zero": zero, "one_dct": one_dct, "constant_brdf": constant_brdf, "triple": triple });
        let samples = ["1", "4", "16", &(side * side).to_string()].map(str::to_owned);
        let samples: Map<_, _> = samples.into_iter().zip(measured.frame.samples_percent().map(Value::from)).collect();
        let mut keys = Map::new();
        let mut put = |key: &str, value: Value| drop(keys.insert(key.to_owned(), value));
        put("block_side", json!(side));
        put("rule", json!(self.rule.name()));
        put("case_percent", cases);
        put("samples_percent", Value::Object(samples));
        put("coeffs_per_block", json!(stats.coded.mean_changes_of_mixed()));
        put("database_bytes", json!(stats.coded.bytes_in_file));
        put("bytes_per_vertex", json!(stats.coded.bytes_in_memory as f64 / stats.vertices as f64));
        put("shaded_vertices", json!(measured.frame.vertices));
        put("first_frame_ms", json!(measured.frames.first_ms));
        put("vertices_per_second", json!(rate(stats.vertices, measured.frames.median_ms)));
        if self.rule == Sampling::Bounded {
            put("tolerance", json!(self.tolerance));
        }
        if let Some(ms) = measured.baseline_ms {
            put("baseline_ms", json!(ms));
            put("baseline_vertices_per_second", json!(rate(stats.vertices, ms)));
        }
        if let Some(bits) = self.visibility_bits {
            put("visibility_bits", json!(bits));
            put("visibility_samples", json!(self.visibility_samples));
        }
        keys
    }
}

/// Vertices a second.
fn rate(vertices: usize, ms: f64) -> f64 {
    1e3 * vertices as f64 / ms
}

fn baseline(stage: &Stage, transport: &Transport) -> Result<f64, Failure> {
    let settings = Settings { rule: Rule::Pixels, ..Settings::default() };
    let mut relighter = Relighter::new(&stage.scene.mesh, transport, settings)?;
    Ok(stage.frames("block-product: baseline", BASELINE_FRAMES, &mut relighter)?.median_ms)
}
