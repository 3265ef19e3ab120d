//! Spherical harmonics in pictures.
//!
//! `cargo run --release --features io --example harmonics` draws the basis, projects an environment light to a few sizes, as it
//! is, under a window and deringed, shows where each is negative, and prints the error of the light and of the irradiance that
//! it gives. `--env` takes a file, `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod basis;
mod light;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use args::Args;
use clap::Parser;
use serde_json::json;
use support::Failure;
use support::environment::environment;

fn main() -> ExitCode {
    support::exit(run(&Args::parse()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    let light = environment(&args.env)?;
    support::make_folder(&args.out)?;
    support::limit_threads(args.threads)?;
    support::save(&args.out, "harmonics_basis.png", &basis::draw()?)?;

    eprintln!("projecting {} at {}x{}x6 texels", light.0, args.resolution, args.resolution);
    let study = light::Study::new(args, light)?;
    println!("A light in spherical harmonics: relative L2 errors, least values of any channel\n\n{}", study.table());
    support::save(&args.out, "harmonics_light.png", &study.draw()?)?;

    if let Some(path) = &args.report {
        let report = json!({
            "example": "harmonics",
            "version": env!("CARGO_PKG_VERSION"),
            "threads": rayon::current_num_threads(),
            "env": args.env,
            "resolution": args.resolution,
            "results": study.report(),
        });
        support::write_report(path, &report)?;
    }
    println!("pictures: harmonics_basis.png, harmonics_light.png in {}", args.out.display());
    Ok(())
}
