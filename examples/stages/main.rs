//! The built-in scenes of several objects under lamps, by ground truth.
//!
//! `cargo run --release --features io --example stages` lights every scene of `scene::Stage` by its own lamps and a
//! bright panel, with the shadows of all objects, adds two reflections between the objects of the temple and fog to the
//! street, writes one contact sheet and prints what each scene is made of and how the truth converges as samples are
//! doubled. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod lit;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use clap::Parser;
use haarmonic::scene::Stage;
use serde_json::json;
use support::args::{Common, Folder};
use support::sheet::Sheet;
use support::{Failure, table};

/// The built-in scenes of several objects, under lamps.
#[derive(Debug, Parser)]
struct Args {
    /// Vertices of every scene, shapes counted once
    #[arg(long, value_name = "N", default_value_t = 12_000)]
    vertices: usize,

    /// Where in its step what walks is, from 0 to 1
    #[arg(long, value_name = "T", default_value_t = 0.2)]
    phase: f64,

    /// Samples along an edge of a lamp: doubled twice for the table
    #[arg(long, value_name = "S", default_value_t = 3)]
    samples: usize,

    /// Pixels along an edge of a picture
    #[arg(long, value_name = "P", default_value_t = 380)]
    size: usize,

    #[command(flatten)]
    folder: Folder,

    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    support::exit(run(&support::args::parse::<Args>(&[])))
}

fn run(args: &Args) -> Result<(), Failure> {
    if !(1..=16).contains(&args.samples) {
        return Err(format!("--samples must be from 1 to 16; got {}", args.samples).into());
    }
    args.common.start()?;
    args.folder.make()?;
    let mut panels = Vec::new();
    let (mut rows, mut results) = (Vec::new(), Vec::new());
    for stage in Stage::ALL {
        let lit = lit::light(stage, args.vertices, args.phase, args.samples)?;
        let changes: Vec<String> = lit.steps.iter().map(|(_, change)| format!("{:.2} %", 100.0 * change)).collect();
        rows.push(vec![
            stage.name().to_owned(),
            lit.staged.objects.len().to_string(),
            lit.mesh.positions().len().to_string(),
            lit.lamps.to_string(),
            lit.staged.spheres.len().to_string(),
            changes.join(", "),
            format!("{:.1} s", lit.seconds),
        ]);
        results.push(json!({
            "stage": stage.name(),
            "objects": lit.staged.objects.len(),
            "vertices": lit.mesh.positions().len(),
            "lamps": lit.lamps,
            "changes": lit.steps.iter().map(|step| step.1).collect::<Vec<_>>(),
            "seconds": lit.seconds,
        }));
        panels.push(Some(lit.panel(args.size)?));
    }
    let header = ["scene", "objects", "vertices", "lamps", "spheres", "change when samples double", "time"];
    println!("{}", table::format(&header, &rows));
    let second = panels.split_off(3);
    let title = "Scenes of several objects under lamps: ground truth with shadows, two reflections, fog";
    args.folder.save("stages.png", &Sheet::new(title, &[panels, second]))?;
    println!("picture: stages.png in {}", args.folder.path.display());
    let settings = json!({ "phase": args.phase, "samples": args.samples });
    support::write_report(&args.common, "stages", settings, json!(results))
}
