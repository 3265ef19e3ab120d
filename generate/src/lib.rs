//! Source files of haarmonic that are computed: straight-line product kernels, fitted tables.
//!
//! `cargo run -p haarmonic-generate` from anywhere in the workspace writes them; a test of haarmonic compares them with
//! what is committed.

mod basis;
mod optimal_linear;
mod output;
mod product;
mod quadrature;
mod tensor;
mod text;

use output::Output;

fn outputs() -> impl Iterator<Item = Output> {
    [vec![basis::output(), optimal_linear::table()], product::outputs()].into_iter().flatten()
}

/// Writes all computed files.
///
/// # Errors
/// A line that names the file and what the system said.
pub fn write() -> Result<(), String> {
    outputs().try_for_each(|output| output.write())
}

/// Compares all computed files with those in the repository.
///
/// # Errors
/// A line that names the first file that differs and its first line that does.
pub fn check() -> Result<(), String> {
    outputs().try_for_each(|output| output.check())
}
