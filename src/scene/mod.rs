//! Scenes: what is lit, by what, and what the right answer is.

mod brdf;
mod bvh;
mod camera;
mod light;
mod material;
mod mesh;
mod metrics;
mod picture;
mod procedural;
mod tone_map;
mod truth;
mod view;
mod visibility;

pub use brdf::{
    AshikhminShirley, Beckmann, BlinnPhong, Brdf, BrdfExpansions, BrdfFn, BrdfSpec, CookTorrance, DirectionTable,
    FactoredBrdf, Lambert, Lobe, Merl, MerlLookup, OrenNayar, Phong, Structure, Sum, TabulatedBrdf, Ward,
};
#[allow(unused_imports, reason = "for those back ends that ask for them")]
pub(crate) use brdf::{Axes, Kernel, KernelVisitor, Shape, narrow};
pub use bvh::{Bvh, Hit};
pub use camera::Camera;
pub use light::{
    EnvironmentLight, EnvironmentSource, LightField, LightSample, LocalLight, RectangleLight, Sky, SoftBox,
    SphereLight, SpotLight, Sun,
};
pub use material::Materials;
pub use mesh::{Bounds, LocalFrame, Mesh, MeshRepair};
pub use metrics::{Comparison, max_abs, percentile_peak, psnr_db, rel_l2};
pub use picture::{Picture, PixelHit, PixelSample, UvFootprint};
pub use procedural::{Model, Procedural, Stage, StageObject, Staged};
pub use tone_map::{ToneMap, linear_to_srgb, srgb_to_linear};
pub use truth::{Convergence, Fog, GroundTruth, Interreflection, LocalTruth, Outgoing, Phase, TexelVisibility};
pub use view::View;
pub use visibility::{
    BackFaces, BinaryVisibility, Directions, FractionalVisibility, Occluders, Viewpoint, VisibilityBaker,
    VisibilityScratch, VisibilitySettings, VisibilityTracer,
};
