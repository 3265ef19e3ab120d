//! Quantisation against its definitions.

use haarmonic::Error;
use haarmonic::compress::{
    ByteBlocks, Distortion, Pca, PcaSettings, QuantisedBytes, QuantisedHalf, half_to_real, real_to_half,
};
use haarmonic::reference::compress as twin;
use proptest::prelude::*;

use crate::support::cases;

#[test]
fn every_half_is_what_the_definition_says_and_comes_back() {
    for bits in 0..=u16::MAX {
        let (single, double) = (half_to_real::<f32>(bits), half_to_real::<f64>(bits));
        match (bits >> 10 & 31, bits & 1023) {
            (31, 0) => assert_eq!(double, if bits >> 15 == 1 { f64::NEG_INFINITY } else { f64::INFINITY }),
            (31, _) => assert!(single.is_nan() && double.is_nan()),
            _ => assert_eq!(double.to_bits(), twin::half_value(bits).to_bits()),
        }
        if double.is_nan() {
            assert_eq!((real_to_half(single), real_to_half(double)), (bits & 0x8000 | 0x7e00, bits & 0x8000 | 0x7e00));
        } else {
            assert_eq!(f64::from(single), double);
            assert_eq!((real_to_half(single), real_to_half(double)), (bits, bits));
        }
    }
}

/// On the middle between each half and the next one, and on the nearest numbers of f64 and f32 on both sides of it.
#[test]
fn rounding_changes_at_the_middle() {
    for low in 0..0x7c00u16 {
        let high = low + 1; // the last one is infinity, for the purpose of rounding 65536
        let next = if high == 0x7c00 { 65536.0 } else { twin::half_value(high) };
        let middle = (twin::half_value(low) + next) / 2.0;
        let even = if low % 2 == 0 { low } else { high };
        for sign in [0, 0x8000u16] {
            let s = if sign == 0 { 1.0 } else { -1.0 };
            assert_eq!(real_to_half(s * middle), even | sign, "{middle}");
            assert_eq!(real_to_half(s * middle.next_down()), low | sign, "below {middle}");
            assert_eq!(real_to_half(s * middle.next_up()), high | sign, "above {middle}");
            let (middle, s) = (middle as f32, s as f32); // exact
            assert_eq!(real_to_half(s * middle), even | sign);
            assert_eq!(real_to_half(s * middle.next_down()), low | sign);
            assert_eq!(real_to_half(s * middle.next_up()), high | sign);
        }
    }
}

#[test]
fn ends_of_the_range() {
    for (x, bits) in [
        (0.0, 0),
        (-0.0, 0x8000),
        (f64::INFINITY, 0x7c00),
        (f64::NEG_INFINITY, 0xfc00),
        (f64::MAX, 0x7c00),
        (-65520.0, 0xfc00),
        (65504.0, 0x7bff),
        (f64::MIN_POSITIVE / 8.0, 0),
        (-f64::MIN_POSITIVE, 0x8000),
        (2f64.powi(-24), 1),
        (2f64.powi(-25), 0),
        (2f64.powi(-26), 0),
    ] {
        assert_eq!(real_to_half(x), bits, "{x:e}");
    }
    assert_eq!((real_to_half(f64::NAN), real_to_half(-f32::NAN)), (0x7e00, 0xfe00));
    // By way of f32 this would be rounded up twice.
    assert_eq!(real_to_half(1.0 + 2f64.powi(-11) + 2f64.powi(-40)), 0x3c01);
    assert_eq!(real_to_half(1.0 + 2f64.powi(-11) - 2f64.powi(-40)), 0x3c00);
}

fn values() -> impl Strategy<Value = (usize, Vec<f64>)> {
    let x = prop_oneof![3 => -1.0..1.0f64, 1 => Just(0.0), 1 => -1e-6..1e-6f64, 1 => 100.0..101.0f64];
    (1..9usize, 0..9usize)
        .prop_flat_map(move |(columns, rows)| (Just(columns), prop::collection::vec(x.clone(), rows * columns)))
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn halves_are_the_nearest(x in prop_oneof![-70000.0..70000.0f64, -1e-4..1e-4f64, -1e-7..1e-7f64, -2.0..2.0f64]) {
        match twin::nearest_half(x) {
            Some(bits) => prop_assert_eq!(real_to_half(x), bits),
            None => prop_assert_eq!(real_to_half(x) & 0x7fff, 0x7c00),
        }
        let x = x as f32;
        if let Some(bits) = twin::nearest_half(f64::from(x)) {
            prop_assert_eq!(real_to_half(x), bits);
        }
    }

    #[test]
    fn half_slices((_, values) in values()) {
        let half = QuantisedHalf::new(&values).unwrap();
        let want: Vec<f64> = values.iter().map(|&x| twin::half_value(twin::nearest_half(x).unwrap())).collect();
        let mut got = vec![f64::NAN; values.len()];
        half.decode(&mut got);
        prop_assert_eq!(&got, &want);
        prop_assert_eq!(half.distortion(), Distortion::between(&values, &want));
        for (x, y) in values.iter().zip(&got) {
            prop_assert!((x - y).abs() <= (x.abs() * 2f64.powi(-11)).max(2f64.powi(-25)));
        }
        prop_assert_eq!(half.bytes(), 2 * values.len());
    }

    #[test]
    fn bytes_are_the_twins((columns, values) in values(), run in 1..20usize) {
        let narrow: Vec<f32> = values.iter().map(|&x| x as f32).collect();
        let wide: Vec<f64> = narrow.iter().map(|&x| f64::from(x)).collect();
        for (blocks, of) in [
            (ByteBlocks::Rows, (0..values.len()).map(|i| i / columns).collect::<Vec<_>>()),
            (ByteBlocks::Columns, (0..values.len()).map(|i| i % columns).collect()),
            (ByteBlocks::Runs(run), (0..values.len()).map(|i| i / run).collect()),
        ] {
            let bytes = QuantisedBytes::new(&narrow, columns, blocks).unwrap();
            let mut got = vec![f32::NAN; values.len()];
            bytes.decode(&mut got);
            let want = twin::bytes(&wide, &of);
            prop_assert_eq!((bytes.len(), bytes.is_empty(), bytes.codes().len()), (values.len(), values.is_empty(), values.len()));
            prop_assert_eq!(bytes.distortion(), Distortion::between(&narrow, &got));
            for i in 0..values.len() {
                let (offset, step) = bytes.block(of[i]);
                // The step is rounded to f32 and multiplied by up to 255; offset + step·q is rounded.
                let rounding = f64::from(f32::EPSILON) * (255.0 * f64::from(step) + f64::from(offset.abs()));
                let error = (f64::from(got[i]) - wide[i]).abs();
                prop_assert!(error <= 0.5 * f64::from(step) + rounding, "{error} {step}");
                prop_assert!(error <= (want[i] - wide[i]).abs() + 2.0 * rounding, "{error} {}", want[i]);
                if step == 0.0 {
                    prop_assert_eq!(got[i], narrow[i]);
                }
            }
            let count = match blocks { ByteBlocks::Columns => columns, _ => of.last().map_or(0, |last| last + 1) };
            prop_assert_eq!(bytes.bytes(), values.len() + 8 * count);
        }
    }
}

#[test]
fn ranges_that_leave_the_scalar() {
    for values in [[f64::MAX, f64::MIN], [f64::MAX / 3.0, f64::MIN / 3.0]] {
        let refused = QuantisedBytes::new(&values, 2, ByteBlocks::Rows);
        assert!(matches!(refused, Err(Error::OutOfRange { what: "range of a block", .. })));
    }
    let values = [f64::MAX / 4.0, f64::MIN / 4.0, 1.0];
    let bytes = QuantisedBytes::new(&values, 3, ByteBlocks::Rows).unwrap();
    let mut got = [f64::NAN; 3];
    bytes.decode(&mut got);
    assert!((got[0] / values[0] - 1.0).abs() < 1e-13 && got[1] == values[1]);
    let tiny = [0.0f32, 1e-45, 0.0];
    let bytes = QuantisedBytes::new(&tiny, 3, ByteBlocks::Rows).unwrap();
    assert!(bytes.distortion().max <= 1.5e-45);
}

#[test]
fn what_is_refused() {
    for bad in [f32::NAN, f32::INFINITY] {
        let error = Error::NotFinite { what: "number", index: 1 };
        assert_eq!(QuantisedHalf::new(&[1.0, bad]), Err(error.clone()));
        assert_eq!(QuantisedBytes::new(&[1.0, bad], 1, ByteBlocks::Columns), Err(error));
    }
    assert!(matches!(QuantisedHalf::new(&[-65520.0]), Err(Error::OutOfRange { got: -65520.0, .. })));
    assert!(QuantisedHalf::new(&[65519.99]).is_ok());
    assert_eq!(QuantisedHalf::new::<f32>(&[]).unwrap().bytes(), 0);
    let refused = |columns, blocks| QuantisedBytes::new(&[1.0f32; 5], columns, blocks).unwrap_err();
    assert!(matches!(refused(0, ByteBlocks::Rows), Error::OutOfRange { what: "columns", .. }));
    assert!(matches!(refused(1, ByteBlocks::Runs(0)), Error::OutOfRange { what: "run", .. }));
    assert_eq!(refused(2, ByteBlocks::Rows), Error::Length { what: "matrix", expected: 6, got: 5 });
}

/// Components and weights at 8 bits are principal components still, with a little more error.
#[test]
fn quantised_components_reconstruct() {
    let (rows, columns) = (200, 48);
    let matrix: Vec<f32> = (0..rows * columns)
        .map(|i| {
            let (u, v) = ((i / columns) as f32 / rows as f32, (i % columns) as f32 / columns as f32);
            (3.0 * u + 2.0 * v).sin() + (5.0 * u * v).cos()
        })
        .collect();
    let pca = Pca::new(&matrix, columns, &PcaSettings::new(6)).unwrap();
    let mut weights = vec![0.0; rows * pca.len()];
    pca.project(&matrix, &mut weights);
    let exact = pca.distortion(&matrix).rms;
    let error = |coarse: &Pca<f32>, weights: &[f32]| {
        let mut back = vec![0.0; matrix.len()];
        coarse.reconstruct(weights, &mut back);
        Distortion::between(&matrix, &back).rms
    };
    let with = |components| {
        Pca::from_parts(pca.mean().to_vec(), components, pca.variances().to_vec(), pca.total_variance()).unwrap()
    };
    let (mut u, mut w) = (pca.components().to_vec(), weights.clone());
    QuantisedHalf::new(&u).unwrap().decode(&mut u);
    QuantisedHalf::new(&w).unwrap().decode(&mut w);
    let half = error(&with(u.clone()), &w);
    QuantisedBytes::new(pca.components(), columns, ByteBlocks::Rows).unwrap().decode(&mut u);
    QuantisedBytes::new(&weights, pca.len(), ByteBlocks::Columns).unwrap().decode(&mut w);
    let byte = error(&with(u), &w);
    assert!(exact < 1e-3 && exact < half && half < byte, "{exact:e} {half:e} {byte:e}");
    assert!(half < exact + 1e-3 && byte < exact + 1e-2, "{half:e} {byte:e}");
}
