//! Writes the computed source files of the crate.

use std::process::ExitCode;

#[allow(clippy::print_stderr, reason = "a program's one line of error")]
fn main() -> ExitCode {
    match haarmonic_generate::write() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
