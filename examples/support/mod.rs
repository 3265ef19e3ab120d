//! What the examples share: progress bars, tables, contact sheets, reports.
#![allow(dead_code, reason = "each example uses its own share of this")]

pub mod plot;
pub mod progress;
pub mod sheet;
pub mod table;
