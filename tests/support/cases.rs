//! How many cases a property test draws.

use proptest::prelude::ProptestConfig;

/// A few cases, or as many as the environment variable `PROPTEST_CASES` says. Cases that fail are printed and not kept
/// in a file.
pub fn cases(few: u32) -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(few);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}
