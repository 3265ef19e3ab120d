//! Criterion benches of haarmonic; see docs/performance.md for what they measured.
