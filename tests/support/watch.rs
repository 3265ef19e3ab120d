//! A listener to long work.

use std::sync::atomic::{AtomicUsize, Ordering};

use haarmonic::Progress;

/// Follows work of `total` pieces, and stops it once it has heard of some.
pub struct Watch {
    total: usize,
    largest: AtomicUsize,
    stop_after: Option<usize>,
}

impl Watch {
    pub fn new(total: usize) -> Self {
        Self { total, largest: AtomicUsize::new(0), stop_after: None }
    }

    pub fn stopping_after(pieces: usize, total: usize) -> Self {
        Self { stop_after: Some(pieces), ..Self::new(total) }
    }

    /// The most pieces that it has heard of.
    pub fn largest(&self) -> usize {
        self.largest.load(Ordering::Relaxed)
    }
}

impl Progress for Watch {
    fn advance(&self, done: usize, total: usize) {
        assert!(done <= total && total == self.total, "{done} of {total}, not of {}", self.total);
        self.largest.fetch_max(done, Ordering::Relaxed);
    }
    fn is_cancelled(&self) -> bool {
        self.stop_after.is_some_and(|pieces| self.largest() >= pieces)
    }
}
