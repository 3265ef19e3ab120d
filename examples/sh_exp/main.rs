//! Exponentials of spherical harmonic expansions: error and time of every method.
//!
//! `cargo run --release --features io --example sh_exp` takes unions of 1 to 8 discs, adds up the logarithms of their
//! visibilities, takes exp by every method, and compares with the projection of the true visibility [Sun 2008, §5.2].
//! It prints a table for each number of bands and draws error against ‖f̂‖ and against time. `--help` lists the
//! options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod charts;
mod measure;
mod scenes;
#[path = "../support/mod.rs"]
mod support;
mod trips;

use std::process::ExitCode;

use args::Args;
use measure::Measured;
use scenes::Scenes;
use serde_json::json;
use support::Failure;
use support::progress::Bar;

fn main() -> ExitCode {
    support::exit(run(&Args::new()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    let bar = Bar::new("project visibility");
    let scenes = Scenes::new(args.vectors, args.largest, *scenes::BANDS.end(), &bar)?;
    bar.finish();

    let bar = Bar::new("measure exponentials");
    let mut measured = Vec::new();
    for bands in scenes::BANDS {
        measured.push(Measured::new(bands, &scenes)?);
        haarmonic::Progress::advance(&bar, measured.len(), scenes::BANDS.count());
    }
    bar.finish();
    println!("{} unions of 1 to 8 discs of half angles {} to {}\n", args.vectors, scenes::SMALLEST, args.largest);
    for measured in &measured {
        println!("{} bands: mean relative L2 error against the projected visibility, by |f^|\n", measured.bands);
        println!("{}", measured.table());
    }
    args.folder.save("sh_exp_error.png", &charts::errors(&measured))?;
    args.folder.save("sh_exp_time.png", &charts::times(&measured))?;

    let trips = trips::measure(&scenes)?;
    println!(
        "exp(log g) for the visibility g of one disc, and of the unions: mean relative L2 error\n\n{}",
        trips.table()
    );

    let settings = json!({
        "vectors": args.vectors,
        "half_angles": [scenes::SMALLEST, args.largest],
        "round_trips": trips.report(),
    });
    support::write_report(&args.common, "sh_exp", settings, measured.iter().flat_map(Measured::report).collect())?;
    println!("pictures: sh_exp_error.png, sh_exp_time.png in {}", args.folder.path.display());
    Ok(())
}
