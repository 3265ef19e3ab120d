//! The mathematics of light transport: Haar wavelets with their coupling and tripling coefficients, spherical
//! harmonics, block cosine transforms and summed tables; and the relighting methods of the literature that are built on
//! them.
//!
//! When light arrives from all directions at a surface, what leaves towards the viewer is an integral of a product:
//! light × visibility × reflectance. A *transport* is what can be computed of that integral before the light is known;
//! *relighting* is the rest, done anew for each light. The crate holds the bases in which such products are cheap, the
//! products themselves, and complete methods that turn a scene into a transport and a light into radiance at every
//! vertex.
//!
//! # Map
//!
//! | module | holds | feature |
//! |---|---|---|
//! | [`haar`] | transforms, pyramids, sparse vectors, choice of terms; couplings, triplings, product integrals | |
//! | [`affine`] | Haar signals that are scaled and moved: couplings, triplings, operators, light seen from a place | |
//! | [`sh`] | spherical harmonics: basis, projection, rotation, products, exponentials and logarithms, lights | |
//! | [`dct`] | block cosine transforms, their lowest frequencies from few samples, product integrals | |
//! | [`table`] | summed-area tables; visibility distance tables and the share of a square that is visible | |
//! | [`compress`] | run coding of maps, biclustering of sparse matrices, principal components, quantisation | |
//! | [`sphere`] | cube maps, lat-long maps, resampling, the equal-area hemisphere disk, quadrature on the sphere | |
//! | [`store`] | files of all that is worth keeping: components, biclusters, coded maps, transports | |
//! | [`numeric`] | exponential integral, tables of two variables, Gauss–Legendre rules, Legendre polynomials, careful sums | |
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
    feature = "scene",
    doc = "| [`backend`] | relighting methods, each with a feature of its own name: the table there has them | … |"
)]
#![cfg_attr(
    not(feature = "scene"),
    doc = "| `backend` | relighting methods, each with a feature of its own name | … |"
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
//! Two more features: `rayon` (default) runs loops in parallel, and `backends` is every back end. `io` and the back
//! ends bring `scene` with them. Features only add, and none changes a result: the bits are the same for any number of
//! threads and without them.
//!
//! # Should I be using this?
//!
//! Yes, if a scene stands still, its light changes, and you want shadows and highlights of all frequencies on a
//! processor, free of noise and the same in every run; if you need one of the building blocks above in Rust; or if you
//! want tested values to compare code of your own with. For much else there are better tools:
//!
//! | you want | take |
//! |---|---|
//! | moving geometry on a GPU that traces rays | ray tracing with resampling (ReSTIR) |
//! | area lights without shadows, or on a GPU | linearly transformed cosines, which Bevy, for one, has built in |
//! | soft diffuse light from probes | harmonics of two bands in a shader; this crate can make their coefficients |
//! | global illumination, or a reference for it | Mitsuba 3 or pbrt: here is light at vertices, reflected n times at most |
//! | wavelets other than Haar's, any size | PyWavelets; to its layout and back: [`haar::to_pywavelets_2d`] |
//! | harmonics in PyTorch or JAX, on a GPU | sphericart: values and derivatives |
//! | harmonics of degrees in the thousands on whole grids | SHTOOLS, SHTns, ducc0: our plans end at 128 bands |
//! | six bands in C++, header only | DirectXMath's `SHMath`; its units are [`sh::Measure::DirectXMath`] |
//! | Fourier and cosine transforms of any length | rustfft, rustdct: [`dct`] does square blocks of 4² to 64² |
//! | decompositions of large dense matrices | faer; [`compress::Pca`] is for few components of many rows |
//! | image processing | OpenCV, which also has the larger summed-area tables of `f32` in less time |
//! | single rays by the million, meshes that deform | Embree, or in Rust `obvhs`: our tracer takes all rays of a place at once |
//! | whole glTF scenes with textures and animation | the crate `gltf`: `io` reads what a mesh needs |
//!
//! docs/performance.md has many of them in the same run. No other public library was found with affine wavelets,
//! products of N wavelet expansions, locally adaptive products or biclustered transfer. Clustered components of
//! transfer existed before, in Direct3D 9 (`D3DXCreatePRTCompBuffer`, closed source); triple products of wavelets as a
//! small C++ header; exponentials of harmonics as demos.
//!
//! # With other crates
//!
//! Vectors, rotations and complex numbers are [`nalgebra`]'s, re-exported; arrays are slices of plain numbers.
//!
//! - `serde`: conventions, choices, settings, grids, maps and sparse vectors are stored and loaded. What is loaded is
//!   checked as the constructor checks it: a cube map with a texel too few is an error. The ranges of plain settings
//!   are checked where they always are, by the plan that takes them. Transports have a file form of their own.
//! - `bytemuck`: `bytemuck::cast_slice(map.texels())` is the floats, or the bytes, of a map for an upload to a GPU;
//!   complex coefficients and slices of vectors likewise.
//! - `mint`: nalgebra's types come from and go to mint's, and so to those of any version of glam, cgmath, euclid, …,
//!   none of which is named here: `Vector3::from(mint::Vector3::from(glam_vector))`; back by `let v: mint::Vector3<f64>
//!   = vector.into()` and `glam::DVec3::from(v)`. glam wants its feature `mint-05` (`mint` before 0.34), and mint
//!   itself is a dependency of yours.
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
//! Products and bases:
//!
//! | you have | you want | use |
//! |---|---|---|
//! | three functions on a square, few terms | ∫ L B V | [`haar::TripleProduct`], which picks the cheaper route |
//! | any number of sparse functions | their product or its integral | [`haar::NFoldProduct`] |
//! | coefficients, too many | the few that matter to an integral | [`haar::Selection`], weighted by integral |
//! | a textured lamp, thousands of places | what each of them sees of it, in wavelets | [`affine::Propagation`] |
//! | a compressed image | it zoomed, moved, masked, blurred, still compressed | [`affine::WaveletImage`] |
//! | a lat-long map | a cube map with the same energy | [`sphere::LatLongMap::to_cube`] |
//! | an environment, few numbers | its harmonics and irradiance | [`sh::CubeProjection`], [`sh::Irradiance`] |
//! | harmonics and rotations | them rotated | [`sh::Rotation`] for many vectors, [`sh::Rotator`] for many rotations |
//! | a lamp with corners | its harmonics from any point | [`sh::PolygonLight`] |
//! | blockers that move | their common visibility | [`sh::CapLog`], [`sh::CapSum`], [`sh::Exponential`] |
//! | a light in blocks, smooth reflectance | their product, cheaply | [`dct::BlockDct`], [`dct::LowProjection`] |
//! | an image, many rectangles | the integral over each | [`table::SummedArea`] |
//! | a visibility map, many squares | the share of each that is seen | [`table::VisibilityDistance`] |
//! | visibility maps, ever new lights | dot products without decoding | [`compress::CodedBinaryMaps`] |
//! | a sparse matrix of few values | a cheaper way to multiply by it | [`compress::Biclustering`] |
//! | rows that are alike | a few weights a row | [`compress::Pca`], [`compress::ClusteredPca`] |
//!
//! Relighting a static scene, light new in each frame; all of these are `backend::…`:
//!
//! | what else changes | use | what it costs and errs |
//! |---|---|---|
//! | nothing: one view, or all is diffuse | `wavelet_double::Relighter` | a sparse matrix times the light's few terms |
//! | view and materials | `block_product::Relighter` | error by a tolerance, diffuse surfaces exact |
//! | the same, by the method of Ng 2004 | `wavelet_triple::Relighter` | slower; exact with all terms kept |
//! | lamps near the scene that move and are painted | `near_field::Relighter` | exact on the cells of a face that sees most of the hemisphere |
//! | a method of your own | `scene::GroundTruth`, `scene::Comparison` | the right answer, and how far from it you are |
//!
//! # Conventions
//!
//! - The world is right-handed and y points up; in the frame of a surface +z is the normal. `wi` and `wo` point away
//!   from it.
//! - Faces of a cube map come in the order +X −X +Y −Y +Z −Z and are oriented as OpenGL samples them.
//! - Haar bases are orthonormal on the unit interval and square: coefficient 0 is the mean, and results do not change
//!   with the resolution.
//! - Harmonics are real, orthonormal on the sphere and without the Condon–Shortley sign; coefficient l(l+1) + m is
//!   degree l, order m.
//! - Radiance is linear RGB. `brdf` is without the cosine, `brdf_cos` with it. Visibility 1 is unoccluded.
//!
//! In the repository, docs/conventions.md has them all, docs/errata.md what the papers have wrong, docs/references.md
//! the sources (and a patent that users may want to know of). A page for each room, such as docs/haar.md, explains use,
//! theory and what was measured.
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
//! Constructors and readers return [`Result`]; what runs in a loop panics on a slice of the wrong length, at the
//! caller's line, and says so under *Panics*. What can fail for the numbers in a slice, such as the logarithm of a
//! function that is nowhere positive, returns [`Result`] wherever it is. The library never prints, logs or exits.
//!
//! # Plans, batches, scratch
//!
//! A *plan* is made once and applied many times, such as [`haar::Transform2d`] or [`sh::Rotation`]. One whose type
//! names a scalar (`f32` or `f64`) is for that one; the others serve both. Functions without a plan, such as
//! [`haar::forward_2d`], make one for a single use.
//!
//! - A name that ends in `_batch` does for many what the name without does for one, with the same bits. Images
//!   follow one another. Of coefficients and right-hand sides, number k of item v is at k · `count` + v.
//! - A name that ends in `_parallel` does the same on all threads.
//! - *Scratch* is memory that a call overwrites, always the last argument. It is a slice of `scratch_len()` numbers, or
//!   a type of its own that the plan's `scratch()` or `default()` makes; one for each thread. Calls do not allocate
//!   unless their page says so.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod approx_eq;
mod error;
mod parallel;
mod progress;
mod real;

pub mod affine;
#[cfg(feature = "scene")]
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
pub mod store;
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

/// And so is that of the rooms' pages.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../docs/affine.md")]
    struct Affine;
    #[cfg(feature = "block_product")]
    #[doc = include_str!("../docs/block_product.md")]
    struct BlockProduct;
    #[doc = include_str!("../docs/compress.md")]
    struct Compress;
    #[doc = include_str!("../docs/dct.md")]
    struct Dct;
    #[doc = include_str!("../docs/haar.md")]
    struct Haar;
    #[cfg(feature = "near_field")]
    #[doc = include_str!("../docs/near_field.md")]
    struct NearField;
    #[cfg(feature = "near_field")]
    #[doc = include_str!("../docs/near_field_sampling.md")]
    struct NearFieldSampling;
    #[doc = include_str!("../docs/numeric.md")]
    struct Numeric;
    #[cfg(feature = "io")]
    #[doc = include_str!("../docs/scene.md")]
    struct Scene;
    #[doc = include_str!("../docs/sh.md")]
    struct Sh;
    #[doc = include_str!("../docs/sphere.md")]
    struct Sphere;
    #[doc = include_str!("../docs/table.md")]
    struct Table;
    #[doc = include_str!("../docs/wavelet_image.md")]
    struct WaveletImage;
}
