//! A mesh lit by textured lamps that hang near it and move.
//!
//! `cargo run --release --features io,near_field --example near_field` bakes the built-in scene, moves a stained window
//! over it by every route, and compares with ground truth, with the same cells of the same face, and with lamps that
//! are taken for distant: a contact sheet and a table. `--find` finds a lamp from one picture, `--figures` draws what
//! the thesis shows in its figures 4.7, 4.10 and 4.11. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod figures;
mod find;
mod frames;
mod refine;
mod scene;
#[path = "../support/mod.rs"]
mod support;
mod truth;

use std::process::ExitCode;

use args::Args;
use clap::Parser;
use scene::Scene;
use support::Failure;

fn main() -> ExitCode {
    support::exit(run(&Args::parse()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    if args.figures {
        return figures::run(args);
    }
    let scene = Scene::new(args)?;
    println!(
        "{}: {} vertices, {} faces; {} lamp(s) with {}; face of size {} with {}² cells; {} threads",
        scene.name,
        scene.mesh.positions().len(),
        scene.mesh.faces().len(),
        scene.lights.len(),
        args.texture,
        args.face,
        args.order,
        rayon::current_num_threads()
    );
    if args.find { find::run(args, &scene) } else { frames::run(args, &scene) }
}
