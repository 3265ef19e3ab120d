//! Tables that answer for whole squares: summed-area tables and visibility distance tables.

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
pub use visibility_distance::{Frame, VisibilityDistancePlan, VisibilityDistanceScratch};
