//! Locally adaptive products: all-frequency relighting with light, view and materials that change in every frame
//! [Inger, Farbman & Lischinski 2013].
//!
//! The cube map around each vertex is cut into blocks of, say, 16² texels. Over most of them one of the three factors
//! of light × visibility × reflectance is constant, and the triple product is no more than a dot product:
//!
//! | visibility of the block | reflectance needs | what is summed | samples |
//! |---|---|---|---|
//! | hidden | anything | nothing | 0 |
//! | free | 1, 4 or 16 samples | samples × weights that hold the light | 1, 4, 16 |
//! | partly hidden | 1 or 4 samples | samples × weights from suffix sums of the light, a look-up where visibility changes | 1, 4 |
//! | any | more | pixel by pixel, run by run | all |
//! | any | a cosine (Lambert) | n · Σ L V ω from suffix sums: exact | 0 |
//!
//! | type | life |
//! |---|---|
//! | [`BlockLayout`] | how a cube map is cut |
//! | [`Transport`] | visibility of a static scene, baked once, saved and loaded |
//! | [`LightForms`] | a light in the forms that the products read, a millisecond or two for a new one |
//! | [`Relighter`] | frames |
//! | [`Rule`], [`SampleBasis`] | how many samples, and what lies between them |
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | texel, pixel | an element of the cube map; the same element by its row-major number in its block |
//! | block | a square of one face, of side² texels |
//! | path | the order in which a block's map is coded: one of two scans, whichever has fewer changes |
//! | place | the number of a pixel along a path |
//! | change | a place where a map goes from hidden to visible or back |
//! | tile, slot | 4 × 2 pixels that are summed together; the number of a pixel in the order of the tiles |
//! | course | a block together with the path that its map takes: two for each block |
//! | group | 256 vertices whose maps of one course are taken together |
//! | lobe | a part of a BRDF with a kernel of its own; its factor is what the kernel is multiplied with |
//! | family | shapes of blocks (large, small, askew) that share a table of errors |
//! | frame | one picture: a light, a view and materials |

mod bounds;
mod cases;
mod coding;
mod culling;
mod file;
mod frame;
mod interpolation;
mod layout;
mod light;
mod live;
mod lobes;
mod parameters;
mod paths;
mod products;
mod relighter;
mod rule;
mod samples;
mod schedule;
mod settings;
mod source;
mod stats;
mod suffix;
mod tables;
mod tiles;
mod transport;
mod visible;

pub use interpolation::SampleBasis;
pub use layout::BlockLayout;
pub use light::LightForms;
pub use relighter::Relighter;
pub use rule::{BlockAngle, Rule};
pub use settings::Settings;
pub use stats::FrameStats;
pub use transport::{Transport, TransportStats};
