//! The files of straight-line products.

use crate::output::Output;
use crate::text::Text;
use crate::{quadrature, tensor};

/// Bands of the kernels by the tensor, and of those by quadrature.
const TENSOR: [usize; 2] = [2, 3];
const QUADRATURE: [usize; 5] = [4, 5, 6, 7, 8];

/// Every file.
pub(crate) fn outputs() -> Vec<Output> {
    let tensor = TENSOR.into_iter().map(|bands| {
        let functions = [("product", tensor::product(bands, false)), ("square", tensor::product(bands, true))];
        output(format!("src/sh/product/generated/tensor_{bands}.rs"), &format!("Tensor{bands}"), bands, &functions)
    });
    let quadrature = QUADRATURE.into_iter().map(|bands| {
        let functions = [
            ("product", quadrature::product(bands)),
            ("square", quadrature::square(bands)),
            ("product_at_poles", quadrature::poles(bands, ["a", "b"])),
            ("square_at_poles", quadrature::poles(bands, ["a", "a"])),
        ];
        output(
            format!("src/sh/product/generated/quadrature_{bands}.rs"),
            &format!("Quadrature{bands}"),
            bands,
            &functions,
        )
    });
    tensor.chain(quadrature).collect()
}

fn output(path: String, name: &str, bands: usize, functions: &[(&str, Text)]) -> Output {
    let mut text = format!(
        "//! {bands} bands in straight lines. Written by `cargo run -p haarmonic-generate`.\n\n\
         use super::super::text::{{Site, Straight}};\n\n\
         pub(in super::super) struct {name};\n\n\
         #[rustfmt::skip]\n\
         impl Straight for {name} {{\n"
    );
    for (function, body) in functions {
        let constant = function.to_uppercase();
        text += &format!(
            "    const {constant}: usize = {};\n\n    /// {} multiplications, {} additions.\n    #[inline(always)]\n    fn {function}<P: Site>(p: &mut P) {{\n{}    }}\n\n",
            body.multiplications, body.multiplications, body.additions, body.body
        );
    }
    text.truncate(text.trim_end().len());
    text += "\n}\n";
    Output { path, text }
}
