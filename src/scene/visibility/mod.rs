//! Which directions are free.
//!
//! | type | a texel holds | made by |
//! |---|---|---|
//! | [`BinaryVisibility`] | one bit: the centre direction is free | [`VisibilityBaker::bake`] |
//! | [`FractionalVisibility`] | the share of n×n directions in it that are free | [`VisibilityBaker::bake_fractional`] |
//!
//! Both are of cube maps along the world's axes at the vertices of a mesh. [`VisibilityTracer`] makes maps of any
//! [`Directions`] from any [`Viewpoint`] against any [`Occluders`]:
//!
//! ```text
//! Directions ── patches ──┐           regular: a ray through each cell's centre;  scattered: any in a cell
//! Viewpoint ── frame ─────┼── orientation (aligned | turned), chart (perspective | disk) ── view: ranges of cells
//! Occluders ── hierarchy ─┘                                        └── trace: walk, edges of triangles, living rays
//! ```

mod baker;
mod binary;
mod chart;
mod directions;
mod fractional;
mod lanes;
mod live;
mod occluders;
mod orientation;
mod origin;
mod regular;
mod scattered;
mod trace;
mod tracer;
mod triangle;
mod view;
mod viewpoint;

pub use baker::{BackFaces, VisibilityBaker, VisibilitySettings};
pub use binary::BinaryVisibility;
pub use directions::Directions;
pub use fractional::FractionalVisibility;
pub use occluders::Occluders;
pub use tracer::{VisibilityScratch, VisibilityTracer};
pub use viewpoint::Viewpoint;
