//! Sample warping against the inverse of cumulated pixels, and against the density that it says.

use haarmonic::haar::{Decomposition, SampleWarp1d, SampleWarp2d, forward_1d, forward_2d};
use haarmonic::{Error, reference::haar as twin};
use proptest::prelude::*;

use crate::support::{cases, noise};

const BOTH: [Decomposition; 2] = [Decomposition::Nonstandard, Decomposition::Standard];

/// Pixels from 0 to 1, of which some are 0 and some much brighter.
fn pixels(seed: usize, len: usize) -> Vec<f64> {
    (0..len)
        .map(|i| match noise(seed + 2 * i) {
            x if x < 0.2 => 0.0,
            x if x > 0.95 => 100.0 * noise(seed + 2 * i + 1),
            x => x,
        })
        .collect()
}

fn warp_2d(pixels: &[f64], width: usize, height: usize, decomposition: Decomposition) -> SampleWarp2d {
    let coefs = forward_2d(pixels, width, height, decomposition).unwrap();
    SampleWarp2d::new(&coefs, width, height, decomposition).unwrap()
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn signals_are_warped_by_their_inverse_sums(log in 0..8_u32, seed in 0..1_000_000_usize, u in 0.0..1.0_f64) {
        let mut signal = pixels(seed, 1 << log);
        signal[0] += 1e-3;
        let warp = SampleWarp1d::new(&forward_1d(&signal).unwrap()).unwrap();
        let ((x, density), (want, want_density)) = (warp.sample(u), twin::warp_1d(&signal, u));
        // A rounding of a share moves a sample by eps over its density.
        let tolerance = 1e-13 * (1.0 + 1.0 / want_density.max(1e-3));
        let is_on_edge = density != want_density && (x - want).abs() <= tolerance;
        prop_assert!((x - want).abs() <= tolerance, "{x} against {want}");
        prop_assert!((density / want_density - 1.0).abs() < 1e-11 || is_on_edge, "{density} against {want_density}");
        prop_assert_eq!(warp.density(x), density);
    }

    #[test]
    fn images_are_warped_as_their_pixels_are(
        log in 0..5_u32, seed in 0..1_000_000_usize, u in 0.0..1.0_f64, v in 0.0..1.0_f64
    ) {
        let side = 1 << log;
        let mut image = pixels(seed, side * side);
        image.iter_mut().for_each(|p| *p += 1e-3);
        for decomposition in BOTH {
            let warp = warp_2d(&image, side, side, decomposition);
            let ([x, y], density) = warp.sample([u, v]);
            let ([want_x, want_y], want) = match decomposition {
                Decomposition::Nonstandard => twin::warp_nonstandard(&image, side, [u, v]),
                Decomposition::Standard => twin::warp_standard(&image, side, side, [u, v]),
            };
            let off = (x - want_x).abs().max((y - want_y).abs());
            prop_assert!(off < 1e-9, "{decomposition:?}: ({x}, {y}) against ({want_x}, {want_y})");
            prop_assert!((density / want - 1.0).abs() < 1e-9, "{decomposition:?}: {density} against {want}");
            prop_assert!((warp.density([x, y]) / density - 1.0).abs() < 1e-12);
        }
    }

    /// Whatever is left of an image, its density is one: the sum over pixels is 1 whatever was truncated.
    #[test]
    fn densities_integrate_to_one(log in 0..5_u32, seed in 0..1_000_000_usize, keep in 0.0..1.0_f64) {
        let side = 1 << log;
        let image = pixels(seed, side * side);
        for decomposition in BOTH {
            let mut coefs = forward_2d(&image, side, side, decomposition).unwrap();
            coefs.iter_mut().enumerate().skip(1).filter(|(i, _)| noise(seed + i) > keep).for_each(|(_, c)| *c = 0.0);
            let warp = SampleWarp2d::new(&coefs, side, side, decomposition).unwrap();
            let centre = |i: usize| (i as f64 + 0.5) / side as f64;
            let density = |i: usize| warp.density([centre(i % side), centre(i / side)]);
            let mean = (0..side * side).map(density).sum::<f64>() / (side * side) as f64;
            prop_assert!((mean - 1.0).abs() < 1e-12, "{decomposition:?}: {mean}");
        }
    }
}

/// A warp that is set again is the warp that would be made anew; what is refused leaves it as it was.
#[test]
fn warps_are_set_again() {
    for (width, height) in [(1, 1), (2, 2), (16, 16), (8, 2), (1, 8)] {
        for decomposition in BOTH.into_iter().filter(|d| width == height || *d == Decomposition::Standard) {
            let [first, second] =
                [1, 2].map(|seed| warp_2d(&pixels(seed, width * height), width, height, decomposition));
            let mut warp = first;
            let coefs = forward_2d(&pixels(2, width * height), width, height, decomposition).unwrap();
            warp.set(&coefs).unwrap();
            assert_eq!(warp, second, "{width} × {height}, {decomposition:?}");
            assert!(matches!(warp.set(&coefs[1..]), Err(Error::Length { .. })));
            let broken: Vec<f64> = coefs.iter().map(|c| c * f64::INFINITY).collect();
            assert!(matches!(warp.set(&broken), Err(Error::NotFinite { .. })));
            assert_eq!(warp, second);
        }
    }
}

/// Pearson's test: counts of 40 000 samples from stratified numbers fit the density at a significance of 0.001.
#[test]
fn counts_fit_the_density() {
    let side = 8;
    let image: Vec<f64> = pixels(3, side * side).iter().map(|p| p + 0.05).collect();
    for decomposition in BOTH {
        let warp = warp_2d(&image, side, side, decomposition);
        let mut counts = vec![0.0_f64; side * side];
        const SAMPLES: usize = 40_000;
        for i in 0..SAMPLES {
            let ([x, y], _) = warp.sample([noise(2 * i), noise(2 * i + 1)]);
            counts[(y * side as f64) as usize * side + (x * side as f64) as usize] += 1.0;
        }
        let total: f64 = image.iter().sum();
        let statistic: f64 = counts
            .iter()
            .zip(&image)
            .map(|(count, pixel)| {
                let expected = SAMPLES as f64 * pixel / total;
                (count - expected).powi(2) / expected
            })
            .sum();
        // The 0.999 quantile of χ² with 63 degrees of freedom.
        assert!(statistic < 103.4, "{decomposition:?}: {statistic}");
    }
}

#[test]
fn edges() {
    // One cell; nothing but zeros; all of the density in one pixel; uniform numbers at the ends.
    let one = SampleWarp1d::new(&[5.0_f32]).unwrap();
    assert_eq!((one.sample(0.25), one.density(0.9)), ((0.25, 1.0), 1.0));
    let dark = SampleWarp1d::new(&[0.0; 8]).unwrap();
    assert_eq!((dark.sample(0.3), dark.density(0.3)), ((0.3, 1.0), 1.0));
    for decomposition in BOTH {
        let mut image = vec![0.0; 16];
        image[6] = 2.0_f64.powi(1000);
        let warp = warp_2d(&image, 4, 4, decomposition);
        // Square roots of two leave an eps of density where there should be none, in the standard form.
        let least = if decomposition == Decomposition::Standard { 1e-14 } else { 0.0 };
        for u in [least, 0.5, 1.0 - f64::EPSILON] {
            let ([x, y], density) = warp.sample([u, u]);
            assert!(
                (0.5..0.75).contains(&x) && (0.25..0.5).contains(&y) && (density - 16.0).abs() < 1e-13,
                "{x}, {y}: {density}"
            );
        }
        for outside in [[-0.1, 0.5], [0.5, 1.0], [f64::NAN, 0.5], [f64::INFINITY, 0.0]] {
            assert_eq!(warp.density(outside), 0.0);
        }
        assert!(matches!(SampleWarp2d::new(&[0.0; 3], 1, 3, decomposition), Err(Error::NotPowerOfTwo { .. })));
        assert!(matches!(SampleWarp2d::new(&[0.0; 3], 2, 2, decomposition), Err(Error::Length { .. })));
        assert!(matches!(SampleWarp2d::new(&[f64::NAN; 4], 2, 2, decomposition), Err(Error::NotFinite { .. })));
        assert!(matches!(SampleWarp2d::new(&[0.0; 4], 1 << 20, 1, decomposition), Err(Error::OutOfRange { .. })));
    }
    let oblong = SampleWarp2d::new(&[0.0; 8], 4, 2, Decomposition::Nonstandard);
    assert!(matches!(oblong, Err(Error::Length { .. })));
    // Oblong images have a standard form.
    let warp = warp_2d(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 4, 2, Decomposition::Standard);
    assert_eq!(warp.density([0.9, 0.9]), 4.0);
    assert!(matches!(SampleWarp1d::new(&[0.0; 3]), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(SampleWarp1d::new::<f32>(&[]), Err(Error::NotPowerOfTwo { .. })));
    assert!(matches!(SampleWarp1d::new(&[1.0, f64::INFINITY]), Err(Error::NotFinite { index: 1, .. })));
}
