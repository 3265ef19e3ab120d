//! The bodies of the fuzz targets, which a test of the crate runs over the committed corpus, too.

#[path = "../../tests/fuzz/targets/mod.rs"]
mod targets;

pub use targets::*;
