//! Visibility distance tables and coverage against golden values and brute force.

use crate::support::{HAAR_AFFINE, Stream, assert_close, cases, golden, number};
use haarmonic::Error;
use haarmonic::reference::table as twin;
use haarmonic::strategies;
use haarmonic::table::{
    BinaryMap, Border, Coverage, Rectangle, SummedArea, VisibilityDistance, VisibilityDistancePlan,
    VisibilityDistanceScratch, half_plane_coverage, linear_coverage, mean_coverage, smoothstep_coverage,
};
use proptest::prelude::*;

fn squares(width: usize, height: usize, map: &[bool], border: Border) -> Vec<i32> {
    let plan = VisibilityDistancePlan::new(width, height, border).unwrap();
    let mut out = vec![i32::MIN; plan.len()];
    plan.squares(map.into(), &mut out, &mut VisibilityDistanceScratch::default());
    out
}

/// The twin's squares, the bound where there is no boundary.
fn expected(width: usize, height: usize, map: &[bool], border: Border) -> Vec<i32> {
    let bound = 4 * (width * width + height * height) as i32;
    let squares = twin::signed_squares(width, height, map, border == Border::Zero);
    let signed = |i: usize| squares[i].map_or(if map[i] { bound } else { -bound }, |s| i32::try_from(s).unwrap());
    (0..map.len()).map(signed).collect()
}

#[test]
fn golden_distances_are_reproduced() {
    let golden = golden(HAAR_AFFINE, "signed_distance");
    let cases = golden["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 6);
    for case in cases {
        let rows: Vec<&str> = case["map_rows"].as_array().unwrap().iter().map(|r| r.as_str().unwrap()).collect();
        let (width, height) = (rows[0].len(), rows.len());
        let map: Vec<bool> = rows.concat().bytes().map(|b| b == b'1').collect();
        let bound = 4 * (width * width + height * height) as i64;
        for (border, key) in [(Border::Open, "signed_4d2_no_border"), (Border::Zero, "signed_4d2_outside_is_zero")] {
            let values = case[key].as_array().unwrap().iter().flat_map(|r| r.as_array().unwrap());
            let sign = |i: usize| if map[i] { 1 } else { -1 };
            let want: Vec<i64> = values.enumerate().map(|(i, v)| v.as_i64().unwrap_or(sign(i) * bound)).collect();
            let got: Vec<i64> = squares(width, height, &map, border).into_iter().map(i64::from).collect();
            assert_eq!(got, want, "{} {border:?}", case["name"]);
            let twin: Vec<i64> = expected(width, height, &map, border).into_iter().map(i64::from).collect();
            assert_eq!(twin, want, "twin: {} {border:?}", case["name"]);
        }
    }
}

#[test]
fn golden_coverages_are_reproduced() {
    let golden = golden(HAAR_AFFINE, "square_and_hemisphere");
    let rows = golden["coverage"].as_array().unwrap();
    assert_eq!(rows.len(), 61);
    for row in rows {
        let [d, edge, angle] = std::array::from_fn(|k| number(&row[k]));
        let want = row[3].as_f64().unwrap();
        assert_close(half_plane_coverage(d, edge, [angle.cos(), angle.sin()]), want, 1e-14, "half-plane");
        assert_close(twin::half_plane_coverage(d, edge, angle), want, 1e-14, "cut polygon");
    }
    let rows = golden["orientation_average"].as_array().unwrap();
    for row in rows {
        let (t, want) = (number(&row[0]), row[1].as_f64().unwrap());
        assert_close(mean_coverage(t, 2.0), want, 1e-14, "mean");
        assert_close(twin::mean_coverage(t, 2.0), want, 1e-12, "mean by quadrature");
    }
}

fn map_of(
    sizes: (std::ops::RangeInclusive<usize>, std::ops::RangeInclusive<usize>),
) -> impl Strategy<Value = (usize, usize, Vec<bool>)> {
    sizes.prop_flat_map(|(w, h)| (Just(w), Just(h), strategies::visibility_map(w, h)))
}

fn bits(map: &[bool]) -> Vec<u64> {
    map.chunks(64).map(|part| part.iter().enumerate().map(|(i, &v)| u64::from(v) << i).sum()).collect()
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn distances_are_the_nearest_of_all((width, height, map) in map_of((1..=40, 1..=24))) {
        for border in [Border::Open, Border::Zero] {
            prop_assert_eq!(squares(width, height, &map, border), expected(width, height, &map, border));
        }
    }

    #[test]
    fn one_map_in_every_form((width, height, map) in map_of((1..=40, 1..=24)), count in 1..4_usize) {
        let plan = VisibilityDistancePlan::new(width, height, Border::Zero).unwrap();
        let single = squares(width, height, &map, Border::Zero);
        let negative: Vec<bool> = map.iter().map(|&v| !v).collect();
        let other = squares(width, height, &negative, Border::Zero);
        // Unlike maps in a batch: what one leaves in the scratch is not seen by the next.
        let part = |k: usize| if k % 2 == 0 { &map } else { &negative };
        let want: Vec<i32> = (0..count).flat_map(|k| if k % 2 == 0 { &single } else { &other }).copied().collect();
        let bools: Vec<bool> = (0..count).flat_map(part).copied().collect();
        let bytes: Vec<u8> = bools.iter().map(|&v| if v { 255 } else { 0 }).collect();
        let words: Vec<u64> = (0..count).flat_map(|k| bits(part(k))).collect();
        let (mut out, mut scratch) = (vec![0; want.len()], VisibilityDistanceScratch::default());
        let mut distances = vec![f32::NAN; want.len()];
        for form in [BinaryMap::Bools(&bools), BinaryMap::Bytes(&bytes), BinaryMap::Bits(&words)] {
            plan.squares(form, &mut out, &mut scratch);
            prop_assert_eq!(&out, &want);
            out.fill(0);
            plan.squares_parallel(form, &mut out);
            prop_assert_eq!(&out, &want);
            plan.distances(form, &mut distances, &mut scratch);
            for (&d, &s) in distances.iter().zip(&want) {
                prop_assert_eq!(d, (0.5 * f64::from(s.abs()).sqrt()).copysign(f64::from(s)) as f32);
            }
            let mut parallel = vec![f32::NAN; want.len()];
            plan.distances_parallel(form, &mut parallel);
            prop_assert_eq!(&parallel, &distances);
        }
    }

    #[test]
    fn look_ups_between_centres((width, height, map) in map_of((1..=12, 1..=12)), u in 0.0..1.0_f64, v in 0.0..1.0_f64) {
        let table = VisibilityDistance::new([width, height], map.as_slice(), Border::Open).unwrap();
        let view = table.as_ref();
        let entry = |x: usize, y: usize| f64::from(view.distances()[y * width + x]);
        for y in 0..height {
            for x in 0..width {
                prop_assert_eq!(view.at([x as f64 + 0.5, y as f64 + 0.5]), entry(x, y));
                let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
                let top = entry(x, y) * (1.0 - u) + entry(right, y) * u;
                let bottom = entry(x, below) * (1.0 - u) + entry(right, below) * u;
                let point = [x as f64 + 0.5 + u, y as f64 + 0.5 + v];
                assert_close(view.at(point), top * (1.0 - v) + bottom * v, 1e-13, "bilinear");
                // Distances change at most as fast as the place does, along each axis.
                let gradient = view.gradient(point);
                prop_assert!(gradient.iter().all(|g| g.abs() <= 1.0 + 1e-6), "{:?}", gradient);
            }
        }
    }

    #[test]
    fn coverage_of_half_planes(d in -2.0..2.0_f64, edge in 0.01..3.0_f64, angle in 0.0..7.0_f64, length in 0.1..10.0_f64) {
        let normal = [length * angle.cos(), length * angle.sin()];
        let got = half_plane_coverage(d, edge, normal);
        // Areas of a square of edge² cut at coordinates up to 2.
        assert_close(got, twin::half_plane_coverage(d, edge, angle), 1e-13 / (edge * edge), "half-plane");
        assert_close(got + half_plane_coverage(-d, edge, normal), 1.0, 1e-15, "complement");
        assert_close(mean_coverage(d, edge), twin::mean_coverage(d, edge), 1e-12 / (edge * edge), "mean");
        assert_close(mean_coverage(d, edge) + mean_coverage(-d, edge), 1.0, 1e-15, "complement of the mean");
        let axis = twin::half_plane_coverage(d, edge, 0.0);
        assert_close(linear_coverage(d, edge), axis, 1e-13 / (edge * edge), "linear");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(48).cases.div_ceil(2), ..cases(48) })]

    /// Wider than what is tried in vectors, and farther than 16 bits.
    #[test]
    fn far_boundaries((width, height, map) in map_of((65..=130, 1..=14))) {
        for border in [Border::Open, Border::Zero] {
            prop_assert_eq!(squares(width, height, &map, border), expected(width, height, &map, border));
        }
    }
}

#[test]
fn farther_than_sixteen_bits() {
    for (width, height, at) in [(7, 300, 5), (300, 7, 299), (300, 1, 0), (1, 300, 299), (270, 12, 2000), (48, 150, 0)] {
        for value in [false, true] {
            let map: Vec<bool> = (0..width * height).map(|i| (i == at) != value).collect();
            for border in [Border::Open, Border::Zero] {
                let got = squares(width, height, &map, border);
                assert!(got == expected(width, height, &map, border), "{width}×{height} {value} {border:?}");
            }
        }
    }
}

#[test]
fn the_largest_sizes_do_not_overflow() {
    for (width, height) in [(16_384, 2), (2, 16_384)] {
        let mut map = vec![true; width * height];
        map[0] = false;
        let got = squares(width, height, &map, Border::Open);
        assert_eq!(got[width * height - 1], (2 * 16_383 - 1) * (2 * 16_383 - 1) + 1);
    }
    let plan = VisibilityDistancePlan::new(16_383, 16_383, Border::Open).unwrap();
    assert_eq!(plan.square_bound(), 8 * 16_383 * 16_383);
    for (width, height) in [(16_384, 16_384), (16_385, 1), (usize::MAX, usize::MAX)] {
        assert!(matches!(VisibilityDistancePlan::new(width, height, Border::Open), Err(Error::OutOfRange { .. })));
    }
}

#[test]
fn maps_without_boundary_have_the_bound() {
    for (width, height) in [(1, 1), (4, 3), (60, 2)] {
        let bound = ((width * width + height * height) as f64).sqrt() as f32;
        for value in [false, true] {
            let map = vec![value; width * height];
            let table = VisibilityDistance::new([width, height], map.as_slice(), Border::Open).unwrap();
            let sign = if value { 1.0 } else { -1.0 };
            assert!(table.as_ref().distances().iter().all(|&d| d == sign * bound), "{width}×{height}");
            for form in [Coverage::Gradient, Coverage::Mean, Coverage::Smoothstep, Coverage::Linear] {
                // No square that fits into the map meets a boundary.
                let share = table.as_ref().coverage([0.5, 0.5], 0.9, form);
                assert_eq!(share, if value { 1.0 } else { 0.0 });
            }
            let closed = VisibilityDistance::new([width, height], map.as_slice(), Border::Zero).unwrap();
            let all = closed.as_ref().distances();
            assert!(if value { all[0] == 0.5 } else { all.iter().all(|&d| d == -bound) });
        }
    }
    let plan = VisibilityDistancePlan::new(0, 5, Border::Open).unwrap();
    plan.distances(BinaryMap::Bytes(&[]), &mut [], &mut VisibilityDistanceScratch::default());
    plan.distances_parallel(BinaryMap::Bits(&[]), &mut []);
    let none = VisibilityDistance::new([0, 5], [].as_slice() as &[bool], Border::Open);
    assert!(matches!(none, Err(Error::Empty { .. })));
    let short = VisibilityDistance::new([2, 5], [0_u64; 2].as_slice(), Border::Open);
    assert!(matches!(short, Err(Error::Length { expected: 1, got: 2, .. })));
}

#[test]
fn outside_the_map() {
    let map = [true; 16];
    let closed = VisibilityDistance::new([4, 4], map.as_slice(), Border::Zero).unwrap();
    let view = closed.as_ref();
    // On the border, beyond it, and past a corner.
    assert_eq!(view.at([4.0, 2.0]), 0.0);
    assert_eq!(view.at([6.0, 2.0]), -2.0);
    assert_eq!(view.at([-2.5, 7.5]), 0.5 - 5.0);
    assert_eq!(view.gradient([6.0, 2.0])[0], -1.0);
    assert_eq!(view.coverage([4.0, 2.0], 1.0, Coverage::Gradient), 0.5);
    assert_eq!(view.coverage([9.0, 9.0], 1.0, Coverage::Gradient), 0.0);
    let open = VisibilityDistance::new([2, 1], [true, false].as_slice(), Border::Open).unwrap();
    assert_eq!(open.as_ref().at([-7.0, 5.0]), 0.5);
    assert_eq!(open.as_ref().gradient([1.0, 0.5]), [-1.0, 0.0]);
    assert!(open.as_ref().at([f64::NAN, 0.5]).is_nan());
    assert!(open.as_ref().coverage([0.5, f64::NAN], 1.0, Coverage::Gradient).is_nan());
}

#[test]
fn coverage_at_the_edges() {
    let all = |d: f64, e: f64| {
        [linear_coverage(d, e), half_plane_coverage(d, e, [0.6, -0.8]), mean_coverage(d, e), smoothstep_coverage(d, e)]
    };
    assert_eq!(all(1.0, 0.0), [1.0; 4]);
    assert_eq!(all(-1.0, 0.0), [0.0; 4]);
    assert_eq!(all(1.0, -1.0), [1.0; 4]);
    for share in all(0.0, 2.0).into_iter().chain(all(0.0, 0.0)) {
        assert_close(share, 0.5, 1e-15, "a centre on the boundary");
    }
    for (d, e) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, 0.0)] {
        assert!(all(d, e).iter().all(|share| share.is_nan()), "{d} {e}: {:?}", all(d, e));
    }
    assert_eq!(all(f64::INFINITY, 1.0), [1.0; 4]);
    assert!(half_plane_coverage(0.1, 1.0, [f64::NAN, 1.0]).is_nan());
    assert_eq!(half_plane_coverage(0.1, 1.0, [0.0; 2]), mean_coverage(0.1, 1.0));
    // The seam of the closed form.
    for t in [1.0 - 1e-9, 1.0, 1.0 + 1e-9] {
        assert_close(mean_coverage(-t, 2.0), 0.029_364_399_847_348_4, 1e-9, "t = 1");
    }
    assert_eq!(mean_coverage(-2f64.sqrt(), 2.0), 0.0);
}

/// The figures of the docstrings.
#[test]
fn how_far_the_forms_are_from_each_other() {
    let grid: Vec<f64> = (-3000..=3000).map(|k| f64::from(k) / 2000.0).collect();
    let gap = |t: f64| smoothstep_coverage(t, 2.0) - mean_coverage(t, 2.0);
    let worst = grid.iter().map(|&t| gap(t).abs()).fold(0.0, f64::max);
    let over: Vec<f64> = grid.iter().copied().filter(|t| t.abs() <= 2f64.sqrt()).collect();
    let rms = (over.iter().map(|&t| gap(t).powi(2)).sum::<f64>() / over.len() as f64).sqrt();
    assert_close(worst, 0.006_857, 1e-5, "smoothstep, worst");
    assert_close(rms, 0.003_437, 1e-5, "smoothstep, RMS");
    let turns = (0..=90).map(|k| f64::from(k).to_radians() / 2.0);
    let off = |t: f64, a: f64| (linear_coverage(t, 2.0) - twin::half_plane_coverage(t, 2.0, a)).abs();
    let linear = turns.flat_map(|a| grid.iter().map(move |&t| off(t, a))).fold(0.0, f64::max);
    assert_close(linear, 0.042_893, 1e-5, "linear, worst");
}

const SIDE: usize = 32;

fn drawn(inside: impl Fn(f64, f64) -> bool) -> Vec<bool> {
    (0..SIDE * SIDE).map(|i| inside((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5)).collect()
}

fn half_plane(numbers: &mut Stream) -> impl Fn(f64, f64) -> f64 + use<> {
    let (x, y, angle) = (numbers.between(6.0, 26.0), numbers.between(6.0, 26.0), numbers.between(0.0, 6.3));
    move |u, v| (u - x) * angle.cos() + (v - y) * angle.sin()
}

fn disc(numbers: &mut Stream) -> Vec<bool> {
    let (x, y, r) = (numbers.between(-8.0, 40.0), numbers.between(-8.0, 40.0), numbers.between(8.0, 24.0));
    let hole = numbers.unit() < 0.5;
    drawn(|u, v| ((u - x).hypot(v - y) < r) != hole)
}

fn sticks(numbers: &mut Stream) -> Vec<bool> {
    let all: Vec<_> = (0..3).map(|_| (half_plane(numbers), numbers.between(0.5, 1.5))).collect();
    drawn(|u, v| all.iter().all(|(side, half)| side(u, v).abs() > *half))
}

/// RMS error of eq. 9 as printed and of the four forms, squares of 2 to 10 pixels inside 32² maps against their
/// summed-area tables.
fn rms(mut map: impl FnMut(&mut Stream) -> Vec<bool>) -> [f64; 5] {
    let (mut numbers, mut sums, mut count) = (Stream::new(1), [0.0; 5], 0.0);
    for _ in 0..150 {
        let map = map(&mut numbers);
        if map.iter().all(|&v| v) || !map.iter().any(|&v| v) {
            continue;
        }
        let values: Vec<f32> = map.iter().map(|&v| f32::from(u8::from(v))).collect();
        let exact: SummedArea<f64> = SummedArea::new(SIDE, SIDE, &values).unwrap();
        let table = VisibilityDistance::new([SIDE, SIDE], map.as_slice(), Border::Open).unwrap();
        for _ in 0..200 {
            let edge = numbers.between(2.0, 10.0);
            let [x, y] = std::array::from_fn(|_| numbers.between(0.5 * edge, SIDE as f64 - 0.5 * edge));
            let want = exact.mean(Rectangle::square([x, y], edge));
            let forms = [Coverage::Linear, Coverage::Mean, Coverage::Gradient, Coverage::Smoothstep];
            let got = forms.map(|form| table.as_ref().coverage([x, y], edge, form));
            let printed = twin::printed_coverage(table.as_ref().at([x, y]), edge);
            for (sum, got) in sums.iter_mut().zip([printed].into_iter().chain(got)) {
                *sum += (got - want).powi(2);
            }
            count += 1.0;
        }
    }
    sums.map(|sum| (sum / count).sqrt())
}

/// The figures of docs/table.md. Other random maps give other digits: of the corrected forms, a sixth at most (it is
/// the share of squares near the boundary that makes eq. 9 as printed anything from .2 to .3).
#[test]
fn coverage_of_random_maps() {
    let straight = |n: &mut Stream| {
        let side = half_plane(n);
        drawn(|u, v| side(u, v) > 0.0)
    };
    let wedge = |n: &mut Stream| {
        let sides = [half_plane(n), half_plane(n)];
        drawn(|u, v| sides.iter().all(|side| side(u, v) > 0.0))
    };
    // Linear, mean, gradient, smoothstep.
    for (name, got, want) in [
        ("half-planes", rms(straight), [0.0248, 0.0196, 0.0186, 0.0196]),
        ("wedges", rms(wedge), [0.0362, 0.0327, 0.0327, 0.0324]),
        ("discs", rms(disc), [0.0244, 0.0214, 0.0220, 0.0214]),
        ("sticks", rms(sticks), [0.105, 0.105, 0.105, 0.105]),
    ] {
        assert!((0.15..0.35).contains(&got[0]), "{name}, as printed: {}", got[0]);
        for (form, want) in want.into_iter().enumerate() {
            let got = got[1 + form];
            assert!((got / want - 1.0).abs() < 0.17, "{name}, form {form}: {got}, not about {want}");
        }
        // The gradient knows more than the distance alone, where it means something.
        assert!(name != "half-planes" || (got[3] < got[2] && got[2] < got[1]), "{got:?}");
    }
}
