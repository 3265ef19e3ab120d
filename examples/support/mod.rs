//! What the examples share: progress bars, tables, contact sheets, reports.
#![allow(dead_code, reason = "each example uses its own share of this")]

#[cfg(feature = "io")]
pub mod environment;
pub mod plot;
pub mod progress;
pub mod sheet;
pub mod table;

use std::process::ExitCode;

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

/// Limits the threads of the program, where an option says so.
pub fn limit_threads(threads: Option<usize>) -> Result<(), Failure> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    Ok(())
}
