//! Scenes: what is lit, by what, and what the right answer is.

mod brdf;
mod ground_truth;
mod material;
mod mesh;
mod view;
mod visibility;

pub use brdf::{
    AshikhminShirley, BlinnPhong, Brdf, BrdfFn, BrdfSpec, CookTorrance, DirectionTable, Lambert, Merl, MerlLookup,
    Phong, Sum, Ward,
};
pub use ground_truth::{GroundTruth, TexelVisibility};
pub use material::Materials;
pub use mesh::{Frame, Mesh};
pub use view::View;
pub use visibility::BinaryVisibility;
