//! Pictures, error maps, and the files they go to.

use haarmonic::io;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::scene::{Bvh, Picture, ToneMap};

use crate::args::Args;
use crate::methods::{Outcome, REFERENCE, Run};
use crate::scene::Scene;
use crate::support::Failure;
use crate::support::axis::number;
use crate::support::sheet::{BRIGHT, ColourBar, DARK, Panel, Sheet, heat};
use crate::support::text::Type;

/// Relative error that the maps show in white.
const WHITE: f32 = 0.25;

/// Ground truth and every method side by side, error maps below.
pub fn contact_sheet(args: &Args, scene: &Scene, run: &Run) -> Result<Sheet, Failure> {
    let plan = picture(args, scene)?;
    let truth: Vec<Vector3<f32>> = run.truth.iter().map(|l| l.cast()).collect();
    let tone = match args.exposure {
        Some(stops) => ToneMap::with_exposure(stops.exp2() as f32),
        None => ToneMap::with_white(bright(&truth)),
    };
    let sky = |direction: &UnitVector3<f64>| scene.light.radiance(direction).cast::<f32>();
    let shown = |colours: &[Vector3<f32>]| plan.shade(colours, sky).iter().map(|l| tone.apply(l)).collect();
    let panel = |caption: Vec<String>, pixels: Vec<[u8; 3]>| {
        Some(Panel { caption, width: args.size, height: args.size, pixels })
    };
    let side = args.truth_resolution.unwrap_or(args.resolution);
    let mut pictures = vec![panel(
        vec![format!("ground truth, {side} × {side} × 6 texels"), format!("reflectance: {}", scene.brdf)],
        shown(&truth),
    )];
    let mut maps = vec![panel(vec!["scale of the error maps".to_owned()], legend(args.size))];
    for outcome in run.results.iter().filter(|o| o.method != REFERENCE || o.comparison.rel_l2 > 0.0) {
        pictures.push(panel(caption(outcome), shown(&outcome.radiance)));
        let errors = relative_errors(&truth, &outcome.radiance);
        let map = plan.shade(&errors, |_| Vector3::zeros());
        let figures = format!("rel. L² {:.2e}, max {:.2e}", outcome.comparison.rel_l2, outcome.comparison.max_abs);
        maps.push(panel(
            vec![format!("error of {}", outcome.method), figures],
            map.iter().map(|e| heat(e.x / WHITE)).collect(),
        ));
    }
    let title = format!("haarmonic: {} lit by {}, {} vertices", scene.name, scene.light_name, truth.len());
    Ok(Sheet::new(&title, &[pictures, maps]))
}

/// Writes the sheet and what else was asked for.
pub fn save(args: &Args, scene: &Scene, run: &Run, sheet: &Sheet) -> Result<(), Failure> {
    io::save_png_srgb8(&args.out, sheet.width, sheet.height, &sheet.pixels)?;
    let Some(first) = run.results.iter().find(|o| o.method != REFERENCE).or(run.results.first()) else {
        return Ok(());
    };
    if let Some(path) = &args.out_ply {
        io::save_ply(path, &scene.mesh, Some(&first.radiance))?;
    }
    if let Some(path) = &args.exr {
        let plan = picture(args, scene)?;
        let pixels = plan.shade(&first.radiance, |direction| scene.light.radiance(direction).cast::<f32>());
        io::save_exr(path, &io::Image::new(args.size, args.size, pixels)?)?;
    }
    Ok(())
}

fn picture(args: &Args, scene: &Scene) -> Result<Picture, Failure> {
    Ok(Picture::new(&scene.mesh, &Bvh::new(&scene.mesh), &scene.camera, [args.size, args.size], 3)?)
}

fn caption(outcome: &Outcome) -> Vec<String> {
    let quality = match outcome.comparison.psnr_db {
        db if db.is_finite() => format!("PSNR {db:.1} dB"),
        _ => "exact".to_owned(),
    };
    vec![
        format!("{}: {quality}", outcome.method),
        format!("{:.1} ms a frame", outcome.relight_ms),
        outcome.caption.clone(),
    ]
}

/// The 98th percentile of the radiance: what shall be white.
fn bright(truth: &[Vector3<f32>]) -> f64 {
    let mut values: Vec<f32> = truth.iter().map(|l| l.max()).collect();
    values.sort_by(f32::total_cmp);
    let bright = f64::from(values[(values.len() - 1) * 98 / 100]);
    if bright > 0.0 { bright } else { 1.0 }
}

/// |difference| of the vertices over the mean of the truth, the same in all channels.
fn relative_errors(truth: &[Vector3<f32>], radiance: &[Vector3<f32>]) -> Vec<Vector3<f32>> {
    let mean = truth.iter().map(|l| f64::from(l.mean())).sum::<f64>() / truth.len() as f64;
    let scale = if mean > 0.0 { (1.0 / mean) as f32 } else { 0.0 };
    truth.iter().zip(radiance).map(|(a, b)| Vector3::repeat((a - b).abs().mean() * scale)).collect()
}

/// The scale of the error maps as a bar across an empty panel.
fn legend(size: usize) -> Vec<[u8; 3]> {
    let ticks = [0.0, 0.05, 0.1, 0.15, 0.2, 0.25].map(|x: f32| {
        let more = if x < WHITE { "" } else { "≥ " };
        (x / WHITE, more.to_owned() + &number(f64::from(x)))
    });
    let bar = ColourBar { label: "|difference| of a vertex / mean of the ground truth", ticks: &ticks, colour: &heat };
    bar.draw([size; 2], Type::new((size as f32 / 22.0).clamp(8.0, 19.0)), [BRIGHT, DARK]).pixels
}
