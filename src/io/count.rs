//! Counting what a reader repairs, for one warning instead of many.

use crate::io::report::Report;

/// How often something was seen, and where first.
#[derive(Debug, Default)]
pub(super) struct Count {
    pub(super) n: usize,
    pub(super) first: String,
}

impl Count {
    pub(super) fn add(&mut self, place: impl FnOnce() -> String) {
        if self.n == 0 {
            self.first = place();
        }
        self.n += 1;
    }

    /// Warns if anything was seen.
    pub(super) fn warn(self, report: &mut Report, message: impl FnOnce(usize) -> String) {
        if self.n > 0 {
            report.warn(self.first, message(self.n));
        }
    }
}

/// "1 face" or "5 faces".
pub(super) fn plural(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
