//! Dense matrices for the principal components: products, orthonormal rows, symmetric eigenproblems.

mod eigen;
mod product;
mod rows;
mod sums;
mod tile;

pub(super) use eigen::symmetric_eigen;
pub(super) use product::{Factors, Left, Part, there_and_back, times_rows, times_some_rows, transpose_times};
pub(super) use rows::{Rows, Scaling};
pub(super) use sums::{combine, dot, dot_wide, largest_positive, orthonormalise};
