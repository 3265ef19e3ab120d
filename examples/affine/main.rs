//! Affine wavelets in pictures and tables.
//!
//! `cargo run --release --features io --example affine` draws the canonical coupling M(r, c) and the number of non-zero
//! couplings against the size of the signal [Sun 2008, figs. 4.5 and 4.6], prints what tables of couplings cost and
//! what they get wrong, and draws how long a light takes to a place against the terms kept. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod bases;
mod contenders;
mod counts;
mod figure_m;
mod lights;
mod selection;
#[path = "../support/mod.rs"]
mod support;
mod tables;
mod times;

use std::process::ExitCode;

use args::Args;
use serde_json::json;
use support::Failure;

fn main() -> ExitCode {
    support::exit(run(&Args::new()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    args.folder.save("affine_m.png", &figure_m::draw())?;

    let counts = counts::Counts::new(args)?;
    println!("Non-zero affine couplings of two Haar bases (ACC), most of any (s, o) tried\n\n{}", counts.table());
    args.folder.save("affine_counts.png", &counts.draw())?;

    let bases = bases::count()?;
    println!("Non-zero couplings (ACC) and triplings (ATC) in different bases\n\n{}", bases.table());

    let canonical = tables::canonical()?;
    println!("M(r, c) in a texture: error on 0 < r <= 1/2, -r <= c <= 1/2\n\n{}", canonical.table());

    let stored = tables::stored(args.cells)?;
    println!(
        "Stored couplings, s in {:?} (geometric), o where the light is in sight; ~ extrapolated\n\n{}",
        tables::SCALES,
        stored.table()
    );
    println!(
        "What the nearest entry costs: mean relative L2 error of a transformed light, N = 32\n\n{}",
        tables::quantised()?
    );

    let selection = selection::measure()?;
    println!(
        "Target coefficients chosen before they are known: 32 x 32 textured lights, s in {:?}\n",
        selection::SCALES
    );
    println!("{}", selection.table());

    let times = times::measure()?;
    println!("A light carried to a place: 3 channels together, f32, standard basis, one thread\n\n{}", times.table());
    args.folder.save("affine_times.png", &times.draw())?;

    let results = json!({
        "counts": counts.report(),
        "bases": bases.report(),
        "canonical_table": canonical.report(),
        "stored_couplings": stored.report(),
        "selection": selection.report(),
        "times": times.report(),
    });
    support::write_report(&args.common, "affine", json!({}), results)?;
    println!("pictures: affine_m.png, affine_counts.png, affine_times.png in {}", args.folder.path.display());
    Ok(())
}

/// Two numbers in [0, 1) that fill the square evenly: multiples of the inverse powers of the plastic number.
pub fn pair(k: usize) -> [f64; 2] {
    let k = k as f64 + 0.5;
    [(k * 0.754_877_666_246_692_8).fract(), (k * 0.569_840_290_998_053_3).fract()]
}
