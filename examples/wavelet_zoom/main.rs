//! A compressed picture is zoomed, streamed and edited without being decompressed.
//!
//! `cargo run --release --features io --example wavelet_zoom` compresses a picture of 1024 x 1024 pixels in the Haar
//! basis, zooms in on a building [Sun 2008, fig. 4.13] by its coefficients alone, and prints what that costs beside
//! decompression, resampling and compression, over the terms that are kept. Pictures show the zoom, how it comes level
//! by level, and a few edits in the wavelet domain. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod figures;
mod input;
mod measure;
mod picture;
mod plain;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use args::Args;
use haarmonic::affine::ZoomWindow;
use haarmonic::haar::Keep;
use input::Input;
use measure::Measured;
use serde_json::json;
use support::{Failure, table};

/// Shares of the terms, in percent, that are measured where none were asked for.
const SOURCES: [f64; 5] = [0.1, 0.5, 1.0, 5.0, 20.0];
const TARGETS: [f64; 3] = [1.0, 10.0, 100.0];

fn main() -> ExitCode {
    support::exit(run(&Args::new()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    let input = Input::new(args)?;
    let free = ZoomWindow::new(args.centre(), [args.zoom; 2])?;
    let choices = |asked: Option<Keep>, percents: &[f64]| match asked {
        Some(keep) => vec![keep],
        None => percents.iter().map(|percent| Keep::Fraction(percent / 100.0)).collect(),
    };
    let (sources, targets) = (choices(args.source, &SOURCES), choices(args.target, &TARGETS));
    let all = measure::all(&input, free, &sources, &targets)?;
    println!(
        "{}: {} x {} pixels, three channels, f32, one thread; window of 1/{}\n",
        input.name, args.side, args.side, args.zoom
    );
    println!("{}", table::format(&Measured::HEADER, &all.iter().map(Measured::cells).collect::<Vec<_>>()));
    println!(
        "bands: inverse transform, exact area resampling, forward transform, selection, in vectors (ImageRoute::Pixels)"
    );
    println!("dense: as bands, but the result stays as large as an image: no list is made, and no term chosen");
    println!("plain: as bands with bilinear samples, in loops that a program without this library would have");
    println!("PSNR: of our zoom against that of the plain method, and against the zoom of the picture with all terms");

    let source = args.source.unwrap_or(Keep::Fraction(0.05));
    let names = ["wavelet_zoom.png", "wavelet_zoom_levels.png", "wavelet_zoom_edit.png"];
    args.folder.save(names[0], &figures::zoom(&input, free, source)?)?;
    args.folder.save(names[1], &figures::levels(&input, free, source)?)?;
    args.folder.save(names[2], &figures::edits(&input, source)?)?;
    println!("pictures: {} in {}", names.join(", "), args.folder.path.display());
    let settings = json!({ "image": input.name, "image_side": args.side, "zoom": args.zoom });
    support::write_report(&args.common, "wavelet_zoom", settings, all.iter().flat_map(Measured::report).collect())
}
