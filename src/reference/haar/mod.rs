//! Naive twins of [`haar`](crate::haar).

mod product;

pub use product::{
    analyse_1d, analyse_2d, basis_1d, basis_2d, pixel_product_integral, synthesise_1d, synthesise_2d, triple_sum_1d,
    triple_sum_2d, tripling_1d, tripling_2d,
};
