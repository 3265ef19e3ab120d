//! The table and the JSON report.

use serde_json::{Map, Value, json};

use crate::args::Args;
use crate::methods::{Blocks, Outcome, Run};
use crate::scene::Scene;
use crate::support::table;
use crate::support::{Failure, write_report};

/// The figures of every method, as text.
pub fn table(run: &Run) -> String {
    let header = ["method", "PSNR dB", "rel L2", "max error", "bake s", "relight ms", "transport MB", "light terms"];
    let row = |o: &Outcome| {
        vec![
            o.method.to_owned(),
            psnr(o.comparison.psnr_db).map_or("exact".to_owned(), |db| format!("{db:.2}")),
            format!("{:.2e}", o.comparison.rel_l2),
            format!("{:.2e}", o.comparison.max_abs),
            format!("{:.2}", o.bake_s),
            format!("{:.1}", o.relight_ms),
            format!("{:.1}", o.transport_bytes as f64 / 1e6),
            o.light_terms.map_or("all".to_owned(), |n| n.to_string()),
        ]
    };
    table::format(&header, &run.results.iter().map(row).collect::<Vec<_>>())
}

/// What only block-product has to tell, as text; nothing if it was not run.
pub fn block_table(run: &Run) -> Option<String> {
    let (outcome, blocks) = run.results.iter().find_map(|o| Some((o, o.blocks.as_ref()?)))?;
    let list = |values: [f64; 4]| values.map(|v| format!("{v:.1}")).join(" / ");
    let (stats, all) = (&blocks.transport, blocks.side * blocks.side);
    let a_vertex = |bytes: usize| bytes as f64 / stats.vertices as f64;
    let mut rows = vec![
        ("blocks: zero / one DCT / constant BRDF / triple, %".to_owned(), list(blocks.frame.case_percent())),
        (format!("samples of BRDF: 1 / 4 / 16 / {all}, %"), list(blocks.frame.samples_percent())),
        ("coefficients a partly hidden block".to_owned(), format!("{:.1}", stats.coded.mean_changes_of_mixed())),
        (
            "bytes a vertex: memory / file / relighter".to_owned(),
            [stats.coded.bytes_in_memory, stats.coded.bytes_in_file, blocks.relighter_bytes]
                .map(|bytes| format!("{:.0}", a_vertex(bytes)))
                .join(" / "),
        ),
        ("first frame, with the materials' tables, ms".to_owned(), format!("{:.1}", blocks.first_ms)),
        ("million vertices a second".to_owned(), format!("{:.3}", rate(stats.vertices, outcome.relight_ms) / 1e6)),
    ];
    if let Some(ms) = blocks.baseline_ms {
        rows.push(("pixel by pixel: ms a frame".to_owned(), format!("{ms:.1}")));
        rows.push((
            "pixel by pixel: million vertices a second".to_owned(),
            format!("{:.3}", rate(stats.vertices, ms) / 1e6),
        ));
        rows.push(("speed-up".to_owned(), format!("{:.1}", ms / outcome.relight_ms)));
    }
    let rows: Vec<_> = rows.into_iter().map(|(name, value)| vec![name, value]).collect();
    Some(table::format(&[outcome.method, &settings(blocks)], &rows))
}

/// The blocks and what chooses their samples.
pub fn settings(blocks: &Blocks) -> String {
    let (side, rule) = (blocks.side, blocks.sampling.name());
    match blocks.tolerance {
        Some(tolerance) => format!("blocks of {side} × {side}, {rule} by {tolerance}"),
        None => format!("blocks of {side} × {side}, {rule}"),
    }
}

/// Vertices a second.
fn rate(vertices: usize, ms: f64) -> f64 {
    1e3 * vertices as f64 / ms
}

/// The keys that only block-product has.
fn block_keys(args: &Args, outcome: &Outcome, blocks: &Blocks) -> Map<String, Value> {
    let stats = &blocks.transport;
    let [zero, one_dct, constant_brdf, triple] = blocks.frame.case_percent();
    let samples = ["1", "4", "16", &(blocks.side * blocks.side).to_string()].map(str::to_owned);
    let samples: Map<_, _> = samples.into_iter().zip(blocks.frame.samples_percent().map(Value::from)).collect();
    let mut keys = Map::new();
    let mut put = |key: &str, value: Value| drop(keys.insert(key.to_owned(), value));
    put("block_side", json!(blocks.side));
    put("rule", json!(blocks.sampling.name()));
    put("case_percent", json!({ "zero": zero, "one_dct": one_dct, "constant_brdf": constant_brdf, "triple": triple }));
    put("samples_percent", Value::Object(samples));
    put("coeffs_per_block", json!(stats.coded.mean_changes_of_mixed()));
    put("database_bytes", json!(stats.coded.bytes_in_file));
    put("bytes_per_vertex", json!(stats.coded.bytes_in_memory as f64 / stats.vertices as f64));
    put("shaded_vertices", json!(blocks.frame.vertices));
    put("first_frame_ms", json!(blocks.first_ms));
    put("vertices_per_second", json!(rate(stats.vertices, outcome.relight_ms)));
    if let Some(tolerance) = blocks.tolerance {
        put("tolerance", json!(tolerance));
    }
    if let Some(ms) = blocks.baseline_ms {
        put("baseline_ms", json!(ms));
        put("baseline_vertices_per_second", json!(rate(stats.vertices, ms)));
    }
    if let Some(bits) = args.visibility_bits {
        put("visibility_bits", json!(bits));
        put("visibility_samples", json!(args.visibility_samples));
    }
    keys
}

/// A PSNR that JSON can hold: an exact result has none.
fn psnr(db: f64) -> Option<f64> {
    db.is_finite().then_some(db)
}

/// Writes the report if one was asked for.
pub fn save(args: &Args, scene: &Scene, run: &Run) -> Result<(), Failure> {
    let threads = rayon::current_num_threads();
    let result = |o: &Outcome| {
        let mut keys = Map::new();
        let mut put = |key: &str, value: Value| drop(keys.insert(key.to_owned(), value));
        put("method", json!(o.method));
        put("vertices", json!(scene.mesh.positions().len()));
        put("faces", json!(scene.mesh.faces().len()));
        put("resolution", json!(args.resolution));
        put("brdf", json!(scene.brdf));
        if let Some(db) = psnr(o.comparison.psnr_db) {
            put("psnr_db", json!(db));
        }
        put("rel_l2", json!(o.comparison.rel_l2));
        put("max_abs", json!(o.comparison.max_abs));
        put("bake_s", json!(o.bake_s));
        put("relight_ms", json!(o.relight_ms));
        put("transport_bytes", json!(o.transport_bytes));
        put("threads", json!(threads));
        if let Some(terms) = o.light_terms {
            put("light_terms", json!(terms));
        }
        if let Some(blocks) = &o.blocks {
            keys.extend(block_keys(args, o, blocks));
        }
        Value::Object(keys)
    };
    let eye = scene.camera.eye();
    let settings = json!({
        "scene": scene.name,
        "environment": scene.light_name,
        "rotate_env": args.rotate_env,
        "eye": [eye.x, eye.y, eye.z],
        "resolution": args.resolution,
        "truth_resolution": args.truth_resolution.unwrap_or(args.resolution),
        "terms": args.terms.to_string(),
        "weighting": format!("{:?}", args.weighting).to_lowercase(),
        "frames": args.frames(),
        "visibility_s": run.visibility_s,
    });
    write_report(&args.common, "relight", settings, run.results.iter().map(result).collect())
}
