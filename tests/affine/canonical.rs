//! The canonical coupling M(r, c) and its companions: golden values, the naive twin, and every property of [Sun 2008,
//! §4.4.2] in its corrected form (docs/errata.md).

use std::collections::BTreeSet;

use haarmonic::Real;
use haarmonic::affine::{Mother, canonical, canonical_batch, canonical_gradient, canonical_slope};
use haarmonic::reference::affine as naive;
use proptest::prelude::*;

use crate::support::{HAAR_AFFINE, assert_close, cases, golden, number};
use Mother::{Scaling, Wavelet};

/// Transformed function first, in the order of the golden file.
const PAIRS: [[Mother; 2]; 4] = [[Wavelet, Wavelet], [Scaling, Wavelet], [Wavelet, Scaling], [Scaling, Scaling]];

/// Rows of r, c, the four couplings; and the branch of fig. 4.4, "neg" for r < 0.
fn golden_rows() -> Vec<([f64; 6], String)> {
    let file = golden(HAAR_AFFINE, "canonical_couplings");
    let rows = file["rows"].as_array().unwrap();
    rows.iter().map(|row| (std::array::from_fn(|k| number(&row[k])), row[6].as_str().unwrap().to_owned())).collect()
}

fn psi_psi(r: f64, c: f64) -> f64 {
    canonical(Wavelet, Wavelet, r, c)
}

/// (r, c) in multiples of 1/16 over all that can overlap for 0 < r ≤ 2, and some that cannot: everything in `f64` is
/// exact there.
fn grid() -> impl Iterator<Item = (f64, f64)> {
    let sixteenth = |k: i32| f64::from(k) / 16.0;
    (1..=32).flat_map(move |r| (-48..=64).map(move |c| (sixteenth(r), sixteenth(c))))
}

#[test]
fn golden_couplings() {
    let rows = golden_rows();
    assert_eq!(rows.len(), 248);
    for ([r, c, want @ ..], branch) in &rows {
        for ([f, g], &want) in PAIRS.into_iter().zip(want) {
            let what = format!("{f:?} {g:?} {r} {c} {branch}");
            assert_close(canonical(f, g, *r, *c), want, 3e-15, &what);
            assert_close(naive::canonical(f, g, *r, *c), want, 3e-15, &what);
            // r and c rounded to f32 move M by at most 3 times their own error.
            let error = 5e-7 * r.abs().max(1.0);
            assert_close(canonical(f, g, *r as f32, *c as f32).widen(), want, error, &what);
        }
    }
    assert_eq!(rows.iter().filter(|row| row.1 == "neg").count(), rows.iter().filter(|row| row.0[0] < 0.0).count());
    let letters: BTreeSet<&str> = rows.iter().map(|row| row.1.as_str()).collect();
    assert_eq!(letters, ["B", "C", "D", "E", "F", "G", "neg"].into());
}

/// Fig. 4.4 with the absolute values that print lost, for r > 0.
fn branches(r: f64, c: f64) -> (f64, &'static str) {
    let (d, sr, dr) = ((c - 0.5).abs(), r + 0.5, (r - 0.5).abs());
    let (max_r, min_r) = (r.max(0.5), r.min(0.5));
    if d >= sr {
        (0.0, "B")
    } else if d >= max_r {
        (d - sr, "C")
    } else if d >= dr.max(min_r) {
        (dr - d, "D")
    } else if d >= dr.min(min_r) {
        if dr >= min_r { (0.0, "E") } else { (sr - 3.0 * d, "F") }
    } else {
        (2.0 * (min_r - d), "G")
    }
}

#[test]
fn the_branches_of_figure_4_4_agree() {
    for (r, c) in grid() {
        assert_eq!(branches(r, c).0, psi_psi(r, c), "{r} {c}");
    }
    for ([r, c, want, ..], branch) in golden_rows() {
        if r > 0.0 {
            let (value, letter) = branches(r, c);
            assert_close(value, want, 1e-14 * (1.0 + r + c.abs()), &branch);
            // On the border of two branches either letter is right.
            let (d, sr, dr) = ((c - 0.5).abs(), r + 0.5, (r - 0.5).abs());
            let border = [sr, r, 0.5, dr].iter().any(|b| (d - b).abs() < 1e-12);
            assert!(border || letter == branch, "{r} {c}: {letter} for {branch}");
        }
    }
}

#[test]
fn symmetry_about_one_half_and_mirror() {
    for (r, c) in grid() {
        let at = |f, g, r, c| canonical::<f64>(f, g, r, c);
        // Of functions that are odd about their centre M is even, of one odd and one even function it is odd [eq.
        // 4.27].
        for [f, g] in PAIRS {
            let parity = if f == g { 1.0 } else { -1.0 };
            assert_eq!(at(f, g, r, 0.5 + c), parity * at(f, g, r, 0.5 - c), "{f:?} {g:?} {r} {c}");
            let mirror = if f == Wavelet { -1.0 } else { 1.0 };
            assert_eq!(at(f, g, -r, c), mirror * at(f, g, r, c), "{f:?} {g:?} {r} {c}");
        }
    }
}

#[test]
fn the_two_functions_exchange_their_parts() {
    // M_fg(r, c) = 2r M_gf(1/4r, ½ + 1/4r − c/2r): eq. 4.28 as its first line has it, for all four.
    for (r, c) in grid() {
        let (r_back, c_back) = (0.25 / r, 0.5 + 0.25 / r - c / (2.0 * r));
        for [f, g] in PAIRS {
            let want = 2.0 * r * canonical(g, f, r_back, c_back);
            // The error of 1/4r − c/2r, (1 + |c|)/r·ε/2, times the slope 3 of M and 2r.
            let error = 4.0 * f64::EPSILON * (1.0 + r + c.abs());
            assert_close(canonical(f, g, r, c), want, error, &format!("{f:?} {g:?} {r} {c}"));
            if r.log2().fract() == 0.0 {
                assert_eq!(canonical(f, g, r, c), want, "exact for powers of two");
            }
        }
    }
    // The last line of the derivation has M(1/2r, …).
    assert_ne!(psi_psi(0.25, 0.0), 2.0 * 0.25 * psi_psi(0.5 / 0.25, 0.5 + 0.25 / 0.25 - 0.0));
}

#[test]
fn it_is_zero_outside_and_inside_a_constant_piece() {
    let (mut outside, mut nested) = (0, 0);
    for (r, c) in grid() {
        let (d, dr, min_r) = ((c - 0.5).abs(), (r - 0.5).abs(), r.min(0.5));
        let value = psi_psi(r, c);
        if d >= r + 0.5 {
            assert_eq!(value, 0.0, "eq. 4.24: {r} {c}");
            outside += 1;
        } else if min_r <= d && d <= dr {
            assert_eq!(value, 0.0, "nested: {r} {c}");
            nested += 1;
        } else if branches(r, c).0 != 0.0 {
            assert_ne!(value, 0.0);
        } else {
            // The remaining zeros lie on lines: two pieces cancel.
            let line = |x: f64| x == 0.0;
            assert!(line(r + 0.5 - 3.0 * d) || line(dr - d) || line(min_r - d), "{r} {c}");
        }
    }
    assert!(outside > 100 && nested > 100);
}

#[test]
fn bounds_hold_and_are_attained() {
    for r in (1..=64).map(|k| f64::from(k) / 16.0) {
        let values = || (-128..=160).map(|c| psi_psi(r, f64::from(c) / 32.0));
        let (least, most) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
        assert_eq!((least, most), (-r.min(0.5), 2.0 * r.min(0.5)), "r = {r}");
        assert_eq!(psi_psi(r, 0.5), most);
    }
}

#[test]
fn the_slopes_are_those_of_the_errata() {
    let (mut in_r, mut in_c) = (BTreeSet::new(), BTreeSet::new());
    for (r, c) in grid() {
        for side in [1.0, -1.0] {
            // Towards −r the one-sided derivative is −∂M/∂r just below.
            in_r.insert((side * canonical_slope(Wavelet, Wavelet, [r, c], [side, 0.0])) as i32);
            in_c.insert((side * canonical_slope(Wavelet, Wavelet, [r, c], [0.0, side])) as i32);
        }
    }
    assert_eq!(in_r, [-1, 0, 1, 2].into(), "eq. 4.26: −2 never occurs");
    assert_eq!(in_c, [-3, -2, -1, 0, 1, 2, 3].into(), "eq. 4.25");
}

#[test]
fn slopes_equal_differences_on_both_sides_of_every_kink() {
    // Kinks lie where c, c − r or c + r is 0, ½ or 1; steps of 1/64 from the grid of 1/16 cross none, and everything is
    // exact.
    let step = 1.0 / 64.0;
    for (r, c) in grid() {
        for r in [r, -r] {
            for [f, g] in PAIRS {
                for along in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.5, -1.0]] {
                    let there = canonical(f, g, r + step * along[0], c + step * along[1]);
                    let want = (there - canonical(f, g, r, c)) / step;
                    assert_eq!(canonical_slope(f, g, [r, c], along), want, "{f:?} {g:?} {r} {c} along {along:?}");
                }
                let right = [[1.0, 0.0], [0.0, 1.0]].map(|along| canonical_slope(f, g, [r, c], along));
                assert_eq!(canonical_gradient(f, g, r, c), right);
            }
        }
    }
    // r = 0 is the limit from above, where M starts at 0.
    for c in (-16..=32).map(|k| f64::from(k) / 16.0) {
        for [f, g] in PAIRS {
            let want = canonical(f, g, step, c) / step;
            assert_eq!(canonical_slope(f, g, [0.0, c], [1.0, 0.0]), want, "{f:?} {g:?} {c}");
        }
    }
}

#[test]
fn off_the_kinks_the_gradient_is_that_of_the_twin() {
    for ([r, c, ..], _) in golden_rows() {
        let kink = [c, c - r, c + r].iter().any(|x| [0.0, 0.5, 1.0].iter().any(|b| (x - b).abs() < 1e-6));
        if kink {
            continue;
        }
        for [f, g] in PAIRS {
            let at = |r, c| naive::canonical(f, g, r, c);
            let h = 2f64.powi(-24);
            let want = [(at(r + h, c) - at(r - h, c)) / (2.0 * h), (at(r, c + h) - at(r, c - h)) / (2.0 * h)];
            for (got, want) in canonical_gradient(f, g, r, c).into_iter().zip(want) {
                // ε/h, times the size of r and c.
                assert_close(got, want, 4e-9 * (1.0 + r.abs() + c.abs()), &format!("{f:?} {g:?} {r} {c}"));
            }
        }
    }
}

fn bits<T: Real>(x: T) -> u64 {
    x.widen().to_bits()
}

fn batch_equals_one_by_one<T: Real>() {
    for len in [0, 1, 7, 8, 9, 1000] {
        let r: Vec<T> = (0..len).map(|k| T::of((k as f64 * 0.618).fract() * 4.0 - 1.0)).collect();
        let c: Vec<T> = (0..len).map(|k| T::of((k as f64 * 0.414).fract() * 6.0 - 2.5)).collect();
        for [f, g] in PAIRS {
            let mut out = vec![T::nan(); len];
            canonical_batch(f, g, &r, &c, &mut out);
            for k in 0..len {
                assert_eq!(bits(out[k]), bits(canonical(f, g, r[k], c[k])), "{f:?} {g:?} {k} of {len}");
            }
            assert!(len < 8 || out.iter().any(|&m| m != T::zero()));
        }
    }
}

#[test]
fn a_batch_has_the_bits_of_one_by_one() {
    batch_equals_one_by_one::<f64>();
    batch_equals_one_by_one::<f32>();
}

#[test]
#[should_panic(expected = "centres: expected length 2, got 1")]
fn centres_of_another_length_are_refused() {
    canonical_batch(Wavelet, Wavelet, &[1.0, 1.0], &[1.0], &mut [0.0, 0.0]);
}

#[test]
#[should_panic(expected = "couplings: expected length 2, got 3")]
fn couplings_of_another_length_are_refused() {
    canonical_batch(Wavelet, Wavelet, &[1.0, 1.0], &[1.0, 1.0], &mut [0.0; 3]);
}

#[test]
fn nan_zero_and_infinite_widths() {
    for [f, g] in PAIRS {
        for (r, c) in [(f64::NAN, 0.5), (0.5, f64::NAN), (f64::NAN, f64::NAN)] {
            assert!(canonical(f, g, r, c).is_nan() && naive::canonical(f, g, r, c).is_nan(), "{f:?} {g:?}");
            assert!(canonical(f, g, r as f32, c as f32).is_nan());
            // In whole blocks and in what is left of them.
            let mut out = [0.0; 11];
            let (mut rs, mut cs) = ([0.5; 11], [0.5; 11]);
            ([rs[3], cs[3]], [rs[9], cs[9]]) = ([r, c], [r, c]);
            canonical_batch(f, g, &rs, &cs, &mut out);
            for (k, m) in out.into_iter().enumerate() {
                assert_eq!(m.is_nan(), k == 3 || k == 9, "{k}");
            }
        }
        for c in [-1.0, 0.0, 0.3, 0.5, 1.0, 2.0] {
            assert_eq!(canonical(f, g, 0.0, c), 0.0);
            assert_eq!(naive::canonical(f, g, 0.0, c), 0.0);
        }
    }
    // Ever wider: one half of ψ, or all of φ, covers g.
    assert_eq!(canonical(Scaling, Scaling, f64::INFINITY, 0.5), 1.0);
    assert_eq!(canonical(Wavelet, Wavelet, f64::INFINITY, 0.5), 1.0);
    assert_eq!(canonical(Wavelet, Scaling, f64::INFINITY, 0.25), -0.5);
    assert_eq!(canonical(Wavelet, Scaling, 1.0, f64::INFINITY), 0.0);
}

/// (r, c) with the functions apart, overlapping or beside each other; r of both signs, tiny and huge.
fn anywhere() -> impl Strategy<Value = (f64, f64)> {
    let width = prop_oneof![4 => -4.0..4.0f64, 1 => -60.0..-4.0f64, 1 => 4.0..60.0f64].prop_map(f64::exp2);
    let ends = prop_oneof![2 => Just(0.0), 1 => Just(0.5), 1 => Just(1.0), 4 => -0.5..1.5f64];
    // One of c − r, c and c + r is near, or at, an end of g.
    (width, any::<bool>(), ends, -1..=1i32).prop_map(|(r, mirrored, end, part)| {
        let c = end - f64::from(part) * r;
        (if mirrored { -r } else { r }, c)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8 * cases(64).cases, ..cases(64) })]

    // c ± r is rounded only by half an ulp of itself, and only where it lies in [0, 1] does that show; then three
    // differences of numbers up to 1. Measured: below ε.
    #[test]
    fn it_equals_the_twin((r, c) in anywhere()) {
        for [f, g] in PAIRS {
            let want = naive::canonical(f, g, r, c);
            assert_close(canonical(f, g, r, c), want, 2.0 * f64::EPSILON, &format!("{f:?} {g:?}"));
            let single = canonical(f, g, r as f32, c as f32);
            let want = naive::canonical(f, g, (r as f32).widen(), (c as f32).widen());
            assert_close(single.widen(), want, 2.0 * f32::EPSILON.widen(), &format!("f32 {f:?} {g:?}"));
        }
    }

    #[test]
    fn bounds_hold_everywhere((r, c) in anywhere()) {
        let value = psi_psi(r.abs(), c);
        let (low, high) = (-r.abs().min(0.5), 2.0 * r.abs().min(0.5));
        prop_assert!((low - 4.0 * f64::EPSILON..=high + 4.0 * f64::EPSILON).contains(&value), "{value}");
        prop_assert_eq!(psi_psi(-r.abs(), c), -value);
    }
}
