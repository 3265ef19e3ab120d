//! Straight-line Rust text that counts its arithmetic.

use std::fmt::Write;

/// The body of a function, with the operations that it does.
#[derive(Default)]
pub(crate) struct Text {
    pub(crate) body: String,
    pub(crate) multiplications: usize,
    pub(crate) additions: usize,
}

impl Text {
    /// A line of the body.
    pub(crate) fn line(&mut self, line: &str) {
        writeln!(self.body, "        {line}").expect("a string takes everything");
    }

    /// `name` = `value`.
    pub(crate) fn set(&mut self, name: &str, value: &str) {
        self.line(&format!("let {name} = {value};"));
    }

    /// x · y.
    pub(crate) fn times(&mut self, x: &str, y: &str) -> String {
        self.multiplications += 1;
        format!("{x} * {y}")
    }

    /// Σ ± terms, the first of which is positive.
    pub(crate) fn sum(&mut self, terms: &[(bool, String)]) -> String {
        self.additions += terms.len() - 1;
        let mut sum = terms[0].1.clone();
        assert!(!terms[0].0, "the first term is positive");
        for (negative, term) in &terms[1..] {
            sum += if *negative { " - " } else { " + " };
            sum += term;
        }
        sum
    }
}

/// Terms that are all positive.
pub(crate) fn positive(terms: impl IntoIterator<Item = String>) -> Vec<(bool, String)> {
    terms.into_iter().map(|term| (false, term)).collect()
}
