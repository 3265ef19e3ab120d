//! A glossy object near a textured lamp, with a few samples a pixel: product importance sampling beside its rivals.
//!
//! `cargo run --release --features near_field,io --example importance_sampling` draws a golden knot by every sampler at
//! 8 samples a pixel, next to a reference without noise, and prints how large the errors are and how many samples each
//! rival would need for the error of the best. `--help` lists the options.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to its user")]

mod args;
mod measure;
mod pictures;
mod samplers;
mod scene;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use args::Args;
use clap::Parser;
use samplers::Samplers;
use scene::Scene;
use serde_json::json;
use support::Failure;

fn main() -> ExitCode {
    support::exit(run(&Args::parse()))
}

fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    args.common.start()?;
    args.folder.make()?;
    let scene = Scene::new(args)?;
    let samplers = Samplers::new(args, &scene)?;
    println!(
        "{}: {} vertices, {}; {} pixels show it; {} samples a pixel, {:?}; order {}, terms {}; {} threads",
        scene.name,
        scene.mesh.positions().len(),
        args.brdf,
        scene.glossy(),
        args.spp,
        args.numbers,
        args.order,
        args.terms,
        rayon::current_num_threads()
    );
    println!("tables and light prepared in {:.2} s", samplers.prepare_s);
    let shadowed = measure::run(args, &scene, &samplers, Some(&scene.occluders), "reference")?;
    println!("\nwith shadows\n{}", shadowed.table());
    let free = measure::run(args, &scene, &samplers, None, "reference without shadows")?;
    println!("without shadows\n{}", free.table());
    args.folder.save("importance_sampling.png", &pictures::sheet(args, &scene, &shadowed)?)?;
    println!("picture: importance_sampling.png in {}", args.folder.path.display());
    let settings = json!({
        "scene": scene.name,
        "brdf": args.brdf,
        "spp": args.spp,
        "order": args.order,
        "terms": args.terms.to_string(),
        "light_share": args.share,
        "numbers": format!("{:?}", args.numbers).to_lowercase(),
        "size": args.size,
        "glossy_pixels": scene.glossy(),
        "prepare_s": samplers.prepare_s,
    });
    let results: Vec<_> = shadowed.keys("shadows").chain(free.keys("no shadows")).collect();
    support::write_report(&args.common, "importance_sampling", settings, json!(results))
}
