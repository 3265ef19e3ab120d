//! The standard basis with any number of axes, and products in it.

use haarmonic::haar::{
    Decomposition, SparseVector, StandardProduct, StandardTripleProduct, Transform2d, TransformNd, forward_2d,
    inverse_2d, multiply_sparse_standard,
};
use haarmonic::{Error, reference::haar as twin};
use proptest::prelude::*;

use crate::support::{assert_all_close, cases, noise};

fn signal(seed: usize, len: usize) -> Vec<f64> {
    (0..len).map(|i| 2.0 * noise(seed + i) - 1.0).collect()
}

/// A share of a signal's terms.
fn sparse(seed: usize, len: usize, share: f64) -> SparseVector<f64> {
    let dense: Vec<f64> =
        (0..len).map(|i| if noise(seed + 2 * i) < share { noise(seed + 2 * i + 1) - 0.5 } else { 0.0 }).collect();
    SparseVector::from_dense(&dense)
}

/// Coefficients by inner products with products of basis functions.
fn coefficients_nd(samples: &[f64], sizes: &[usize]) -> Vec<f64> {
    let indices = |mut flat: usize| {
        let mut out = vec![0; sizes.len()];
        for axis in (0..sizes.len()).rev() {
            (out[axis], flat) = (flat % sizes[axis], flat / sizes[axis]);
        }
        out
    };
    let centre = |i: usize, size: usize| (i as f64 + 0.5) / size as f64;
    (0..samples.len())
        .map(|k| {
            let k = indices(k);
            let sum: f64 = (0..samples.len())
                .map(|i| {
                    let i = indices(i);
                    let at = |axis: usize| twin::basis_1d(k[axis], centre(i[axis], sizes[axis]));
                    (0..sizes.len()).map(at).product::<f64>()
                })
                .zip(samples)
                .map(|(basis, sample)| basis * sample)
                .sum();
            sum / samples.len() as f64
        })
        .collect()
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn any_number_of_axes_agrees_with_inner_products(
        logs in prop::collection::vec(0..4_u32, 1..5), seed in 0..1_000_000_usize,
    ) {
        let sizes: Vec<usize> = logs.iter().map(|log| 1 << log).collect();
        let plan = TransformNd::<f64>::new(&sizes).unwrap();
        prop_assume!(plan.len() <= 512);
        let samples = signal(seed, plan.len());
        let (mut coefs, mut scratch) = (samples.clone(), vec![0.0; plan.scratch_len()]);
        plan.forward_in_place(&mut coefs, &mut scratch);
        assert_all_close(&coefs, &coefficients_nd(&samples, &sizes), 1e-15 * (4 + sizes.len()) as f64, "coefficients");
        plan.inverse_in_place(&mut coefs, &mut scratch);
        assert_all_close(&coefs, &samples, 1e-14, "samples");
    }

    /// More lines than are taken together, and a number of them that is no multiple.
    #[test]
    fn two_axes_are_the_standard_decomposition(log_w in 0..7_u32, log_h in 0..7_u32, seed in 0..1_000_000_usize) {
        let (width, height) = (1 << log_w, 1 << log_h);
        let samples: Vec<f32> = signal(seed, width * height).iter().map(|x| *x as f32).collect();
        let plan = TransformNd::<f32>::new(&[height, width]).unwrap();
        let (mut coefs, mut scratch) = (samples.clone(), vec![0.0; plan.scratch_len()]);
        plan.forward_in_place(&mut coefs, &mut scratch);
        let two = Transform2d::<f32>::new(width, height, Decomposition::Standard).unwrap();
        let (mut want, mut scratch) = (vec![0.0; samples.len()], vec![0.0; two.scratch_len()]);
        two.forward(&samples, &mut want, &mut scratch);
        for (a, b) in coefs.iter().zip(&want) {
            prop_assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }

    #[test]
    fn triple_products_agree_with_pixels(
        log_w in 0..5_u32, log_h in 0..5_u32, seed in 0..1_000_000_usize, share in 0.0..1.0_f64,
    ) {
        let (width, height) = (1 << log_w, 1 << log_h);
        let n = width * height;
        let (a, b, c) = (sparse(seed, n, share), sparse(seed + 7919, n, share), signal(seed + 1, n));
        let pixels = |coefs: &[f64]| inverse_2d(coefs, width, height, Decomposition::Standard).unwrap();
        let (pa, pb, pc) = (pixels(&a.to_dense()), pixels(&b.to_dense()), pixels(&c));
        let want = (0..n).map(|i| pa[i] * pb[i] * pc[i]).sum::<f64>() / n as f64;
        let scale = (0..n).map(|i| (pa[i] * pb[i] * pc[i]).abs()).sum::<f64>() / n as f64;
        let got = StandardTripleProduct::new(width, height, &c).unwrap().integral(&a, &b);
        prop_assert!((got - want).abs() <= 2e-14 * (scale + 1.0), "{got} against {want}");

        let product: Vec<f64> = pa.iter().zip(&pb).map(|(a, b)| a * b).collect();
        let want = forward_2d(&product, width, height, Decomposition::Standard).unwrap();
        let tolerance = 4e-15 * (1.0 + product.iter().fold(0.0_f64, |m, p| m.max(p.abs())));
        let got = multiply_sparse_standard(&a, &b, width, height).unwrap();
        assert_all_close(&got.to_dense(), &want, tolerance, "sparse");

        let plan = StandardProduct::new(width, height).unwrap();
        let (mut out, mut scratch) = (vec![0.0; n], vec![0.0; plan.scratch_len()]);
        plan.apply(&a.to_dense(), &b.to_dense(), &mut out, &mut scratch);
        assert_all_close(&out, &want, tolerance, "dense");
    }
}

#[test]
fn what_has_no_standard_basis_is_refused() {
    assert!(matches!(TransformNd::<f32>::new(&[]), Err(Error::Empty { .. })));
    assert!(matches!(TransformNd::<f32>::new(&[4, 3]), Err(Error::NotPowerOfTwo { got: 3, .. })));
    assert!(matches!(TransformNd::<f32>::new(&[4, 0]), Err(Error::NotPowerOfTwo { got: 0, .. })));
    assert!(matches!(TransformNd::<f32>::new(&[1 << 40, 1 << 40]), Err(Error::OutOfRange { .. })));
    let one = TransformNd::<f64>::new(&[1, 1, 1]).unwrap();
    let mut data = [3.5];
    one.forward_in_place(&mut data, &mut vec![0.0; one.scratch_len()]);
    assert_eq!((data, one.len(), one.sizes()), ([3.5], 1, vec![1, 1, 1]));
    assert_eq!(TransformNd::<f64>::new(&[4, 2, 8]).unwrap().flat(&[3, 1, 5]), 3 * 16 + 8 + 5);

    let empty = |len: usize| SparseVector::<f32>::new(len, vec![], vec![]).unwrap();
    assert!(matches!(StandardProduct::<f32>::new(3, 4), Err(Error::NotPowerOfTwo { got: 3, .. })));
    assert!(matches!(StandardTripleProduct::new(4, 0, &[0.0; 0]), Err(Error::NotPowerOfTwo { got: 0, .. })));
    assert!(matches!(StandardTripleProduct::new(4, 2, &[0.0; 7]), Err(Error::Length { expected: 8, got: 7, .. })));
    assert!(matches!(multiply_sparse_standard(&empty(8), &empty(4), 4, 2), Err(Error::Length { .. })));
    assert!(matches!(multiply_sparse_standard(&empty(8), &empty(8), 1 << 30, 1 << 30), Err(Error::OutOfRange { .. })));
    assert_eq!(multiply_sparse_standard(&empty(8), &empty(8), 4, 2).unwrap().nnz(), 0);
}

#[test]
#[should_panic(expected = "scratch (at least)")]
fn a_transform_wants_its_scratch() {
    TransformNd::<f64>::new(&[4, 4]).unwrap().forward_in_place(&mut [0.0; 16], &mut [0.0; 3]);
}
