//! Principal component analysis.

mod components;
mod entries;
mod fit;
mod moments;
mod settings;
mod stored;

pub use components::Pca;
pub(in crate::compress) use components::{add_up, check_matrix};
pub(in crate::compress) use entries::{check_index, column_of, entry_of, entry_of_column};
pub(in crate::compress) use fit::{Source, fit};
pub(in crate::compress) use moments::Moments;
pub use settings::{Centre, PcaMethod, PcaSettings};
