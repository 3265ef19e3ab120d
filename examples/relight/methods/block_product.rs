//! Locally adaptive products, and the same transport pixel by pixel as their baseline.

use haarmonic::backend::block_product::{
    BlockAngle, BlockLayout, FrameStats, Relighter, Rule, Settings, Transport, TransportStats,
};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::Comparison;

use super::{Outcome, Stage};
use crate::args::{Args, Sampling};
use crate::scene::Scene;
use crate::support::Failure;
use crate::support::progress::Bar;

/// Frames of the baseline: it takes its time, and the same in each.
const BASELINE_FRAMES: usize = 2;

/// What only this method has to tell.
pub struct Blocks {
    /// Edge of a block in texels.
    pub side: usize,
    pub sampling: Sampling,
    /// None for the rules that have no tolerance.
    pub tolerance: Option<f64>,
    pub transport: TransportStats,
    pub frame: FrameStats,
    /// Milliseconds of the first frame, which also makes the materials' tables.
    pub first_ms: f64,
    /// What the relighter holds beside the transport.
    pub relighter_bytes: usize,
    /// Milliseconds of a frame pixel by pixel; None if that is the method itself.
    pub baseline_ms: Option<f64>,
}

/// Bakes, runs the frames, counts their blocks and times the baseline.
pub fn run(stage: &Stage, truth: &[Vector3<f64>]) -> Result<Outcome, Failure> {
    let Stage { args, scene: Scene { mesh, materials, .. }, .. } = stage;
    let (transport, bake_s) = bake(stage)?;
    let rule = rule(args)?;
    let mut relighter = Relighter::new(mesh, &transport, Settings { rule, ..Settings::default() })?;
    let frames = stage.frames("block-product: frames", args.frames(), &mut relighter)?;
    // Of the first frame, whose radiance is shown.
    relighter.set_light(&stage.light)?;
    let frame = relighter.frame_stats(&stage.view, materials)?;
    let baseline_ms = match args.rule {
        Sampling::Pixels => None,
        _ => Some(baseline(stage, &transport)?),
    };
    let stats = transport.stats();
    let blocks = Blocks {
        side: args.block(),
        sampling: args.rule,
        tolerance: (args.rule == Sampling::Bounded).then_some(args.tolerance),
        transport: stats,
        frame,
        first_ms: frames.first_ms,
        relighter_bytes: relighter.bytes(),
        baseline_ms,
    };
    Ok(Outcome {
        method: "block-product",
        comparison: Comparison::new(truth, &frames.radiance)?,
        radiance: frames.radiance,
        bake_s,
        relight_ms: frames.median_ms,
        transport_bytes: stats.coded.bytes_in_memory,
        light_terms: None,
        blocks: Some(blocks),
    })
}

/// The transport and the seconds that it took from the mesh.
fn bake(stage: &Stage) -> Result<(Transport, f64), Failure> {
    let layout = BlockLayout::new(stage.grid, stage.args.block(), ScanOrder::Serpentine)?;
    let Some(bits) = stage.args.visibility_bits else {
        let bar = Bar::new("block-product: coding");
        let transport = Transport::from_binary(&stage.scene.mesh, stage.visibility, &layout)?;
        return Ok((transport, stage.visibility_s + bar.finish()));
    };
    let bar = Bar::new("block-product: gray visibility");
    let levels = (stage.args.visibility_samples, bits);
    let transport = Transport::bake_gray(&stage.scene.mesh, stage.baker, &layout, levels, &bar)?;
    Ok((transport, bar.finish()))
}

fn rule(args: &Args) -> Result<Rule, Failure> {
    Ok(match args.rule {
        Sampling::Bounded => Rule::bounded(args.tolerance)?,
        Sampling::Fixed => Rule::Fixed { angle: BlockAngle::Centre },
        Sampling::FixedSound => Rule::Fixed { angle: BlockAngle::Nearest },
        Sampling::Pixels => Rule::Pixels,
    })
}

fn baseline(stage: &Stage, transport: &Transport) -> Result<f64, Failure> {
    let settings = Settings { rule: Rule::Pixels, ..Settings::default() };
    let mut relighter = Relighter::new(&stage.scene.mesh, transport, settings)?;
    let frames = stage.frames("block-product: baseline", BASELINE_FRAMES, &mut relighter)?;
    Ok(frames.median_ms)
}
