//! Spherical harmonics in pictures.
//!
//! `cargo run --release --features io --example harmonics` draws the basis, projects an environment light to a few
//! sizes, as it is, under a window and deringed, shows where each is negative, and prints the error of the light and of
//! the irradiance that it gives. `--env` takes a file, `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod basis;
mod light;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use args::Args;
use serde_json::json;
use support::Failure;

fn main() -> ExitCode {
    support::exit(run(&Args::new()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    let light = args.light.load()?;
    args.common.start()?;
    args.folder.make()?;
    args.folder.save("harmonics_basis.png", &basis::draw()?)?;

    eprintln!("projecting {} at {}x{}x6 texels", light.0, args.resolution, args.resolution);
    let study = light::Study::new(args, light)?;
    println!("A light in spherical harmonics: relative L2 errors, least values of any channel\n\n{}", study.table());
    args.folder.save("harmonics_light.png", &study.draw()?)?;

    let settings = json!({ "env": args.light.env, "resolution": args.resolution });
    support::write_report(&args.common, "harmonics", settings, study.report().into())?;
    println!("pictures: harmonics_basis.png, harmonics_light.png in {}", args.folder.path.display());
    Ok(())
}
