//! Near-field relighting by affine wavelet products: textured lamps that move, grow, turn and are painted while every
//! vertex sees them [Sun 2008, §4.5–4.6].

mod light;
mod texture;

pub use light::PlanarLight;
