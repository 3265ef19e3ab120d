//! A mesh lit by an environment map: relighting by wavelets and by blocks next to ground truth.
//!
//! `cargo run --release --features io,backends --example relight` lights the built-in scene with the built-in sky by
//! every method, writes a contact sheet and prints the error and the time of each. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod methods;
mod pictures;
mod report;
mod scene;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use args::Args;
use clap::Parser;
use methods::Run;
use scene::Scene;
use support::Failure;

fn main() -> ExitCode {
    support::exit(run(&Args::parse()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.make_folders()?;
    let scene = Scene::new(args)?;
    println!(
        "{}: {} vertices, {} faces; {}; light {}; {}² × 6 texels; {} threads",
        scene.name,
        scene.mesh.positions().len(),
        scene.mesh.faces().len(),
        scene.brdf,
        scene.light_name,
        args.resolution,
        rayon::current_num_threads()
    );
    let run = Run::new(args, &scene)?;
    println!("\n{}", report::table(&run));
    report::details(&run).iter().for_each(|table| println!("{table}"));
    let sheet = pictures::contact_sheet(args, &scene, &run)?;
    pictures::save(args, &scene, &run, &sheet)?;
    report::save(args, &scene, &run)?;
    println!("contact sheet: {} (top left: ground truth)", args.out.display());
    Ok(())
}
