//! Near-field relighting by affine wavelet products: textured lamps that move, grow, turn and are painted while every
//! vertex sees them [Sun 2008, §4.5–4.6].

mod light;
mod sampling;
mod texture;

pub use light::PlanarLight;
pub use sampling::{
    BrdfDensity, BrdfScratch, BrdfTable, DirectionSample, DirectionSampler, Incidence, LightDensity, LightHit,
    LightSampler, LightWeight, Mixture, ProductDensity, ProductSampler, ProductScratch, ProductSettings, Reflection,
    ShadingPoint, Window,
};
