//! Spherical harmonics: real, orthonormal on the sphere, without the Condon–Shortley phase, flat index l(l+1)+m.
//!
//! | you have | you want | use |
//! |---|---|---|
//! | two expansions | the expansion of their product | [`Product::apply`], [`Product::batch`] for many |
//! | one expansion | its square, at half the multiplications | [`Square::apply`], [`Square::batch`] |
//! | one expansion that multiplies many others | a matrix | [`Product::matrix`] |
//! | three expansions | the integral of their product | [`Product::integral`] |
//! | nothing but sizes | the coefficients Γ themselves | [`TripleTensor`], [`gamma`] |

mod gamma;
mod product;

pub use gamma::{TripleTensor, gamma};
pub use product::{Product, Square};
