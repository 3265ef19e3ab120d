//! The mathematics of light transport: Haar wavelets with their coupling and tripling coefficients, functions of direction on
//! cube maps, and the rendering back ends of the literature that is built on them.
//!
//! # Map
//!
//! | module | holds | feature |
//! |---|---|---|
//! | [`haar`] | transforms, pyramids, sparse vectors, choice of terms; coupling, tripling, products, product integrals | |
//! | [`affine`] | canonical couplings, affine coupling and tripling coefficients, operators that scale and move whole signals | |
//! | [`sh`] | spherical harmonics: basis, projection, rotation, products, exponentials and logarithms, lights | |
//! | [`dct`] | block cosine transforms, their lowest frequencies from few samples, product integrals | |
//! | [`table`] | summed-area tables; visibility distance tables and the share of a square that is visible | |
//! | [`compress`] | maps by their changes (run coding), biclustering of sparse matrices of few values | |
//! | [`sphere`] | cube maps, lat-long maps, resampling, the equal-area hemisphere disk, quadrature on the sphere | |
//! | [`numeric`] | Gauss–Legendre rules, Legendre polynomials, careful sums | |
#![cfg_attr(
    feature = "scene",
    doc = "| [`scene`] | meshes, procedural scenes, BRDFs, lights, visibility, ground truth, metrics | `scene` |"
)]
#![cfg_attr(
    not(feature = "scene"),
    doc = "| `scene` | meshes, procedural scenes, BRDFs, lights, visibility, ground truth, metrics | `scene` |"
)]
#![cfg_attr(feature = "io", doc = "| [`io`] | files: OBJ, PLY, glTF; HDR, EXR, PNG | `io` |")]
#![cfg_attr(not(feature = "io"), doc = "| `io` | files: OBJ, PLY, glTF; HDR, EXR, PNG | `io` |")]
#![cfg_attr(
    feature = "wavelet",
    doc = "| [`backend::wavelet`] | all-frequency relighting: double product [Ng 2003], triple product [Ng 2004] | `wavelet` |"
)]
#![cfg_attr(
    not(feature = "wavelet"),
    doc = "| `backend::wavelet` | all-frequency relighting: double product [Ng 2003], triple product [Ng 2004] | `wavelet` |"
)]
#![cfg_attr(
    feature = "reference",
    doc = "| [`mod@reference`] | naive `f64` twins of the fast paths, for tests | `reference` |"
)]
#![cfg_attr(
    not(feature = "reference"),
    doc = "| `reference` | naive `f64` twins of the fast paths, for tests | `reference` |"
)]
#![cfg_attr(feature = "proptest", doc = "| [`strategies`] | proptest strategies of the crate's inputs | `proptest` |")]
#![cfg_attr(
    not(feature = "proptest"),
    doc = "| `strategies` | proptest strategies of the crate's inputs | `proptest` |"
)]
//!
//! `rayon` (default) runs loops in parallel; `backends` is every back end. Features only add, and none changes a result: the bits
//! are the same for any number of threads and without them.
//!
//! # With other crates
//!
//! Vectors, rotations and complex numbers are [`nalgebra`]'s, re-exported; arrays are slices of plain numbers.
//!
//! - `serde`: conventions, choices, settings, grids, maps and sparse vectors are stored and loaded. What is loaded is checked
//!   as the constructor checks it: a cube map with a texel too few is an error. The ranges of plain settings are checked where
//!   they always are, by the plan that takes them. Transports have a file form of their own.
//! - `bytemuck`: `bytemuck::cast_slice(map.texels())` is the floats, or the bytes, of a map for an upload to a GPU; complex
//!   coefficients and slices of vectors likewise.
//! - `mint`: nalgebra's types come from and go to mint's, and so to those of any version of glam, cgmath, euclid, …, none of
//!   which is named here: `Vector3::from(mint::Vector3::from(glam_vector))`; back by `let v: mint::Vector3<f64> = vector.into()`
//!   and `glam::DVec3::from(v)`.
//!   glam wants its feature `mint-05` (`mint` before 0.34), and mint itself is a dependency of yours.
#![cfg_attr(
    feature = "bytemuck",
    doc = "
```
# use haarmonic::{nalgebra::Vector3, sphere::{CubeGrid, CubeMap}};
let map = CubeMap::from_fn(CubeGrid::new(4)?, |d| d.map(|x| x as f32));
let floats: &[f32] = bytemuck::cast_slice(map.texels());
assert_eq!(floats.len(), 6 * 4 * 4 * 3);
# Ok::<(), haarmonic::Error>(())
```
"
)]
//!
//! # Which method when
//!
//! | you have | you want | use |
//! |---|---|---|
//! | three functions on a square, few terms | ∫ L B V | [`haar::TripleProduct`], which picks the cheaper route |
//! | any number of sparse functions | their product or its integral | [`haar::NFoldProduct`] |
//! | coefficients, too many | the few that matter to an integral | [`haar::Selection`], weighted by integral |
//! | a lat-long map | a cube map with the same energy | [`sphere::LatLongMap::to_cube`] |
//! | an environment, few numbers | its harmonics, and the irradiance that they give | [`sh::CubeProjection`], [`sh::Irradiance`] |
//! | blockers that move | their common visibility | [`sh::CapLog`], [`sh::Exponential`] |
//! | visibility maps, ever new lights | dot products without decoding | [`compress::BinaryMaps`] |
//! | a sparse matrix of few values | a cheaper way to multiply by it | [`compress::Biclustering`] |
//! | a textured lamp, thousands of places | what each of them sees of it, in wavelets | [`affine::Propagation`] |
//! | a static scene, fixed view or diffuse | a new light in each frame | `backend::wavelet::DoubleRelighter` |
//! | a static scene | new light, view and materials in each frame | `backend::wavelet::TripleRelighter` |
//! | a method of your own | the right answer to compare with | `scene::GroundTruth`, `scene::Comparison` |
//!
//! # Conventions
//!
//! World right-handed, y up; local +z is the normal. Cube map faces +X −X +Y −Y +Z −Z as OpenGL samples them. Haar bases are
//! orthonormal on the unit interval and square, so coefficient 0 is the mean and results do not change with resolution. `wi` and
//! `wo` point away from the surface; `brdf` is without the cosine, `brdf_cos` with it; radiance is linear RGB. Visibility 1 =
//! unoccluded. The repository's docs/conventions.md has them all, docs/errata.md what the papers have wrong, docs/references.md
//! the sources (and a patent that users may want to know of).
//!
//! # Example
//!
//! The mean of a product of two images, from their coefficients alone (Parseval):
//! ```
//! use haarmonic::haar::{Decomposition, forward_2d};
//! let a = forward_2d(&[1.0, 2.0, 3.0, 4.0], 2, 2, Decomposition::Nonstandard)?;
//! let b = forward_2d(&[0.0, 1.0, 0.0, 1.0], 2, 2, Decomposition::Nonstandard)?;
//! let mean: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
//! assert_eq!(mean, (2.0 + 4.0) / 4.0);
//! # Ok::<(), haarmonic::Error>(())
//! ```
//!
//! # Errors and panics
//!
//! Constructors and readers return [`Result`]; what runs in a loop panics on a slice of the wrong length, at the caller's line, and
//! says so under *Panics*. The library never prints, logs or exits.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod error;
mod progress;
mod real;

pub mod affine;
#[cfg(any(feature = "block_product", feature = "wavelet"))]
pub mod backend;
pub mod compress;
pub mod dct;
pub mod haar;
#[cfg(feature = "io")]
pub mod io;
pub mod numeric;
#[cfg(feature = "reference")]
pub mod reference;
#[cfg(feature = "scene")]
pub mod scene;
pub mod sh;
pub mod sphere;
#[cfg(feature = "proptest")]
pub mod strategies;
pub mod table;

pub use error::{Error, Result};
pub use nalgebra;
pub use progress::Progress;
pub use real::Real;

/// The README's code is a test too.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
