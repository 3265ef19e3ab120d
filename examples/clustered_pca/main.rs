//! Transport maps as principal components, in one piece and clustered, in tables and pictures.
//!
//! `cargo run --release --features io --example clustered_pca` bakes visibility x cosine of every vertex on a cube map
//! (6 x 16 x 16 numbers), stores the maps by `Pca` and, at about equal storage, by `ClusteredPca`, each with its
//! numbers in f32, f16 and 8 bits, and prints what is lost of the maps and of the values that a light makes of them.
//! `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod figures;
mod maps;
mod measure;
mod stored;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use args::Args;
use maps::Maps;
use measure::Measured;
use serde_json::json;
use support::{Failure, table};

/// Components of the whole matrix in the picture of maps.
const SHOWN: usize = 32;

fn main() -> ExitCode {
    support::exit(run(&Args::new()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    let maps = Maps::new(args)?;
    let all = measure::all(&maps, args.seed)?;
    let (vertices, columns) = (maps.vertices(), maps.columns());
    println!("Maps of {}: {vertices} vertices x {columns} texels; light: {}\n", maps.name, maps.light_name);
    println!("{}", table::format(&Measured::HEADER, &all.iter().map(Measured::cells).collect::<Vec<_>>()));
    println!("ratio: bytes of the maps in f32 / bytes of means, components, weights and labels");
    let difference = all.iter().filter_map(|m| m.difference).fold(0.0, f64::max);
    println!("products with the light without decoding differ by {difference:.1e} of the largest");

    let shown = |m: &&Measured| m.whole == SHOWN;
    let whole = all.iter().filter(shown).find(|m| m.clusters == 1);
    let clustered = all.iter().filter(shown).filter(|m| m.clusters > 1);
    let best = clustered.min_by(|a, b| a.formats[0].error.total_cmp(&b.formats[0].error));
    let mut pictures = vec![("clustered_pca_error.png", figures::errors(&all))];
    if let (Some(whole), Some(best)) = (whole, best) {
        pictures.push(("clustered_pca_maps.png", figures::maps(&maps, [whole, best])?));
    }
    for (file, sheet) in &pictures {
        args.folder.save(file, sheet)?;
    }
    let names: Vec<&str> = pictures.iter().map(|p| p.0).collect();
    println!("pictures: {} in {}", names.join(", "), args.folder.path.display());
    let settings = json!({
        "scene": maps.name,
        "light": maps.light_name,
        "vertices": vertices,
        "texels": columns,
        "seed": args.seed,
    });
    support::write_report(&args.common, "clustered_pca", settings, all.iter().flat_map(Measured::report).collect())
}
