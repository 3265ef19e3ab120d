//! Spherical harmonics: basis, projection, rotation, products, exponentials and logarithms, zonal functions, lights.
//!
//! A function on the sphere is f = Σ c_i y_i with the real, orthonormal basis *without* the Condon–Shortley phase, so
//! y_{1,−1}, y_{1,0}, y_{1,1} = √(3/4π)·(y, z, x). Coefficient i = l(l+1) + m is degree l, order m ([`index`]); `bands`
//! n holds the degrees 0…n−1, n² coefficients. (A paper's "order n" is `bands` n; its "degree up to l_max" is l_max +
//! 1.) Other signs, scales, layouts and axes, with presets by project: [`Convention`], [`to_complex`] and, for what
//! game engines keep of an environment, [`DiffuseProbe`].
//!
//! | you have | you want | use |
//! |---|---|---|
//! | one direction | all y_i | [`Basis::eval`] |
//! | many directions | all y_i, a row for each coefficient or for each point | [`Basis::eval_batch`], [`Basis::eval_points`] |
//! | coefficients, many directions | f there | [`Basis::reconstruct`], which stores no basis values |
//! | weighted samples | Σ w y_i, all channels in one pass | [`Basis::accumulate`] |
//! | a direction | tangent gradients of all y_i | [`Basis::gradient`], [`Basis::gradient_batch`] |
//! | a direction | their Hessians on the sphere | [`Basis::hessian`], [`Basis::hessian_batch`] |
//! | a function | ∫ f y_i, exact for polynomials; by random directions with its error | [`project_fn`], [`monte_carlo`] |
//! | a cube map, a latitude–longitude map | its coefficients | [`CubeProjection`], [`LatLongProjection`] |
//! | coefficients | the map | [`CubeReconstruction`], [`LatLongReconstruction`] |
//! | samples anywhere | the best fit | [`ScatteredFit`] |
//! | an expansion | its least and greatest value, certified | [`Extrema`] |
//! | one that rings | a milder one; one that is nowhere negative | [`Window`], [`Deringing`] |
//! | one rotation, many expansions | all of them rotated | [`Rotation`] |
//! | many rotations | an expansion rotated by each | [`Rotator`]; about z [`rotate_z`], [`rotate_z_batch`] |
//! | one vector at a time, of 1 to 8 bands | values, products, rotations and integrals of arrays, without a plan | [`Expansion`] |
//! | two expansions | their product to any number of bands; one of them as a matrix; many pairs | [`Product`] |
//! | one | its square | [`Square`] |
//! | three | ∫ f g h | [`Product::integral`]; many, in RGB, [`Product::integral_batch`] |
//! | a function of the angle to an axis: cosine, lobe, cap, von Mises–Fisher | its coefficients about any axis; convolution with it | [`Zonal`] |
//! | a sun, a sky, a glowing ball | its coefficients, in the units you mean | [`Lights`] |
//! | a polygon that glows | its coefficients from any point, clipped by the horizon | [`PolygonLight`] |
//! | radiance | irradiance for many normals; with a visibility for each | [`Irradiance`]; [`DiffuseLight`], its batches and its table |
//! | many discs or spheres in the way | the sum of their logarithms | [`CapSum`] |
//! | logarithms of visibility, added up | the visibility: exp | [`Exponential`], whose page says by which method |
//! | visibility | its logarithm | [`Logarithm`]; of a disc by its angle, tabulated, [`CapLog`] |
//! | one, and any function h | h of it | [`GridFunction`]; by products [`ProductSeries`], [`ProductSpectrum`] |
//! | curiosity | ∫ y_i y_j y_k, all that are not zero | [`gamma`], [`TripleTensor`] |
//!
//! Directions are unit vectors in Cartesian coordinates: no angles, so the poles are points like any other.
//!
//! Sources: the recurrence in l at fixed m of normalised Legendre functions (Holmes & Featherstone 2002, eq. 11);
//! azimuth by (x + iy)^m. Limits: `bands` ≤ 128 in `f32`, 1024 in `f64` ([`Basis::max_bands`] says why).

mod basis;
mod cap_sum;
mod convention;
mod diffuse_probe;
mod expansion;
mod exponential;
mod gamma;
mod index;
mod lane;
mod light;
mod product;
mod project;
mod rotate;
mod zonal;

pub use basis::{Basis, associated_legendre, eval};
pub use cap_sum::CapSum;
pub use convention::{Convention, Layout, Normalization, Phase, from_complex, to_complex};
pub use diffuse_probe::DiffuseProbe;
pub use expansion::Expansion;
pub use exponential::{
    CapFit, CapLog, ExpMethod, Exponential, GridFunction, LogMethod, Logarithm, OptimalLinear, Powers, ProductSeries,
    ProductSpectrum,
};
pub use gamma::{TripleTensor, gamma};
pub use index::{bands_of, coefficient_count, degree_order, index};
pub use light::{
    DiffuseLight, DiffuseLightTable, Irradiance, Light, Lights, Measure, PolygonLight, PolygonScratch, Sides,
};
pub use product::{Product, Square};
pub use project::{
    Channels, CubeProjection, CubeReconstruction, DeringBy, DeringWindow, Deringing, Extrema, Extremum,
    LatLongProjection, LatLongReconstruction, MonteCarlo, ScatteredFit, TexelRule, Window, monte_carlo, project_cube,
    project_fn, project_fn_channels, project_lat_long,
};
pub use rotate::{Rotation, Rotator, rotate_z, rotate_z_batch};
pub use zonal::{VonMisesFisher, Zonal};
