//! Writes the computed source files of the crate, or with `--check` compares them with what is committed.
//!
//! `cargo run --release -p haarmonic-generate [-- --check]` from anywhere in the workspace.

mod basis;
mod optimal_linear;
mod output;
mod product;
mod quadrature;
mod tensor;
mod text;

use std::process::ExitCode;

fn main() -> ExitCode {
    let check = match std::env::args().nth(1).as_deref() {
        None => false,
        Some("--check") => true,
        Some(other) => return fail(&format!("{other}: the only argument is --check")),
    };
    let outputs = [vec![basis::output(), optimal_linear::table()], product::outputs()].into_iter().flatten();
    for output in outputs {
        let done = if check { output.check() } else { output.write() };
        if let Err(message) = done {
            return fail(&message);
        }
    }
    ExitCode::SUCCESS
}

#[allow(clippy::print_stderr, reason = "a program's one line of error")]
fn fail(message: &str) -> ExitCode {
    eprintln!("{message}");
    ExitCode::FAILURE
}
