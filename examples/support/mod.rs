//! What the examples share: arguments, progress bars, timers, tables, charts, contact sheets, reports.
#![allow(dead_code, reason = "each example uses its own share of this")]

pub mod args;
pub mod axis;
pub mod canvas;
#[cfg(feature = "io")]
pub mod environment;
pub mod notes;
pub mod plot;
pub mod progress;
pub mod sheet;
pub mod table;
pub mod text;
pub mod timer;

use std::process::ExitCode;

use serde_json::{Value, json};

/// Anything that ends the program with one line.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What `main` returns: a failure is one line on standard error and a status that is not zero.
pub fn exit(outcome: Result<(), Failure>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the JSON object of `--report` if that was asked for: what every example states, its settings, its results.
pub fn write_report(args: &args::Common, example: &str, settings: Value, results: Value) -> Result<(), Failure> {
    let Some(path) = &args.report else { return Ok(()) };
    let mut report = json!({
        "example": example,
        "version": env!("CARGO_PKG_VERSION"),
        "threads": rayon::current_num_threads(),
        "results": results,
    });
    if let (Value::Object(report), Value::Object(settings)) = (&mut report, settings) {
        report.extend(settings);
    }
    let text = serde_json::to_string_pretty(&report)? + "\n";
    std::fs::write(path, text).map_err(|e| format!("{}: cannot be written: {e}", path.display()))?;
    Ok(())
}
