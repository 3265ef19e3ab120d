//! Twins of [`table`](crate::table): sums pixel by pixel, distances pair by pair, coverages by cutting polygons.

mod coverage;
mod summed_area;
mod visibility_distance;

pub use coverage::{half_plane_coverage, mean_coverage, printed_coverage};
pub use summed_area::{rectangle_sum, summed_area};
pub use visibility_distance::signed_squares;
