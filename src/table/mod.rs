//! Tables that answer for a whole square of an image with a few look-ups, whatever the square's size [Xu 2006 §4.2,
//! 4.3].
//!
//! | you have | you want | use |
//! |---|---|---|
//! | an image, many rectangles | ∫ f over each, exact | [`SummedArea`], [`SummedAreaPlan`] |
//! | an image that repeats | the same across the seam | [`SummedAreaRef::sum_beyond`] with [`Outside::Wrap`] |
//! | slices of a BRDF | one square, between two or four slices | [`SummedAreaStack::mix`] |
//! | a map of the hemisphere disk | a square light across the horizon | [`DiskGrid::mask`], then [`SummedArea::mean`] |
//! | a binary map | the share of a square that is visible, by one look-up | [`VisibilityDistance`], [`Coverage`] |
//!
//! Take `SummedArea<f64>` for anything larger than a few hundred pixels a side: a small sum is a difference of large
//! ones. A visibility distance does not know what is behind the nearest edge; where occluders are thinner than the
//! square, take a summed-area table of the map.
//!
//! docs/table.md has the theory and what was measured, docs/errata.md what the paper leaves open.

mod binary_map;
mod coverage;
mod distance_lookup;
mod distance_rows;
mod lookup;
mod prefix;
mod rectangle;
mod stack;
mod summed_area;
mod visibility_distance;

pub use binary_map::BinaryMap;
pub use coverage::{Coverage, half_plane_coverage, linear_coverage, mean_coverage, smoothstep_coverage};
pub use distance_lookup::{VisibilityDistance, VisibilityDistanceRef};
pub use lookup::{SummedArea, SummedAreaRef};
pub use rectangle::{DiskGrid, Outside, Rectangle};
pub use stack::SummedAreaStack;
pub use summed_area::SummedAreaPlan;
pub use visibility_distance::{Border, VisibilityDistancePlan, VisibilityDistanceScratch};
