//! Biclustering of transfer matrices in tables and pictures.
//!
//! `cargo run --release --features io --example bicluster` builds the transfer matrix of bi-scale radiance transfer at
//! several numbers of vertices (64 local × 6,144 global directions a vertex), biclusters it, asserts that nothing was
//! lost, and prints operations, bytes and times as the paper's table II does. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod figures;
mod measure;
mod meshes;
#[path = "../support/mod.rs"]
mod support;
mod transfer;

use std::process::ExitCode;

use args::Args;
use measure::Measured;
use serde_json::json;
use support::{Failure, table};

fn main() -> ExitCode {
    support::exit(run(&Args::new()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    let (name, meshes) = meshes::meshes(args)?;
    let all: Vec<Measured> = meshes.iter().map(|mesh| Measured::new(mesh, args)).collect::<Result<_, _>>()?;
    let rows: Vec<Vec<String>> = all.iter().map(Measured::cells).collect();
    println!("Transfer matrix of {name}, 64 local x 6144 global directions, 5 levels: sparse and as biclusters\n");
    println!("{}", table::format(&Measured::HEADER, &rows));
    let last = all.last().expect("at least one size");
    println!(
        "sum of the biclusters = matrix, bit for bit; products (f32, RGB) differ by {:.1e} of the largest",
        last.difference
    );
    let pictures =
        [("bicluster_matrix.png", figures::matrix(last)), ("bicluster_scaling.png", figures::scaling(&all, &name))];
    for (file, sheet) in &pictures {
        args.folder.save(file, sheet)?;
    }
    println!("pictures: bicluster_matrix.png, bicluster_scaling.png in {}", args.folder.path.display());
    let settings = json!({ "scene": name, "group_rows": args.group_rows });
    support::write_report(&args.common, "bicluster", settings, all.iter().map(Measured::report).collect())
}
