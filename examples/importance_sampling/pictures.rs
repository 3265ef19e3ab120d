//! Every sampler beside the reference, with close-ups.

use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{ToneMap, percentile_peak};

use crate::args::Args;
use crate::measure::Run;
use crate::scene::Scene;
use crate::support::Failure;
use crate::support::sheet::{Panel, Sheet};

/// The part of the picture that is shown enlarged, as shares of its edge: corner and edge.
const CLOSE_UP: ([f64; 2], f64) = ([0.3, 0.2], 0.3);

/// Pixels along an edge of a panel, at least.
const PANEL: usize = 300;

pub fn sheet(args: &Args, scene: &Scene, run: &Run) -> Result<Sheet, Failure> {
    let tone = ToneMap::with_white(0.4 * percentile_peak(&run.truth)?.max(1e-6));
    let panels = |caption: Vec<String>, pixels: &[Vector3<f32>]| {
        let shown: Vec<[u8; 3]> = pixels.iter().map(|pixel| tone.apply(pixel)).collect();
        let whole = enlarged(&shown, args.size, [0, 0], args.size, PANEL.div_ceil(args.size));
        let edge = ((CLOSE_UP.1 * args.size as f64) as usize).max(1);
        let corner = CLOSE_UP.0.map(|share| (share * args.size as f64) as usize);
        let close = enlarged(&shown, args.size, corner, edge, whole.0 / edge);
        [(caption, whole), (vec![], close)].map(|(caption, (width, pixels))| {
            let height = pixels.len() / width;
            Some(Panel { caption, width, height, pixels })
        })
    };
    let mut all = vec![panels(vec!["reference".to_owned(), args.brdf.clone()], &run.truth)];
    for outcome in &run.outcomes {
        let figures = format!("RMSE {:.3}: {:.2} of light's", outcome.rmse, outcome.rmse_ratio_to_light);
        all.push(panels(vec![outcome.method.name().to_owned(), figures], &outcome.pixels));
    }
    let title = format!("{} near a textured lamp, {} samples a pixel, close-ups below", scene.name, args.spp);
    let mut rows = Vec::new();
    for half in all.chunks_mut(4) {
        for row in 0..2 {
            rows.push(half.iter_mut().map(|panels| panels[row].take()).collect());
        }
    }
    Ok(Sheet::new(&title, &rows))
}

/// A square part of a picture with pixels as large as `factor`: its edge and its pixels.
fn enlarged(pixels: &[[u8; 3]], width: usize, corner: [usize; 2], edge: usize, factor: usize) -> (usize, Vec<[u8; 3]>) {
    let out = edge * factor.max(1);
    let pixel = |i: usize| {
        let [x, y] = [0, 1].map(|k| (corner[k] + [i % out, i / out][k] / factor.max(1)).min(width - 1));
        pixels[y * width + x]
    };
    (out, (0..out * out).map(pixel).collect())
}
