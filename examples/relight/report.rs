//! The table and the JSON report.

use serde_json::{Map, Value, json};

use crate::args::Args;
use crate::methods::{Outcome, Run};
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

/// What single methods have to tell, as text.
pub fn details(run: &Run) -> Vec<String> {
    let details = run.results.iter().filter_map(|o| Some((o.method, o.details.as_ref()?)));
    let table = |(method, (heading, rows)): (&str, &(String, Vec<[String; 2]>))| {
        table::format(&[method, heading], &rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>())
    };
    details.map(table).collect()
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
        keys.extend(o.keys.clone());
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
