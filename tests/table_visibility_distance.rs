//! Visibility distance tables and coverage against golden values and brute force.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod support;

use haarmonic::Error;
use haarmonic::reference::table as twin;
use haarmonic::strategies;
use haarmonic::table::{
    BinaryMap, Coverage, Frame, Rectangle, SummedArea, VisibilityDistance, VisibilityDistancePlan,
    VisibilityDistanceRef, VisibilityDistanceScratch, half_plane_coverage, linear_coverage, mean_coverage,
    smoothstep_coverage,
};
use proptest::prelude::*;
use support::{assert_close, golden, rational};

/// 48 cases, or as many as PROPTEST_CASES says.
fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|s| s.parse().ok()).unwrap_or(48);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn squares(width: usize, height: usize, map: &[bool], frame: Frame) -> Vec<i32> {
    let plan = VisibilityDistancePlan::new(width, height, frame).unwrap();
    let mut out = vec![i32::MIN; plan.len()];
    plan.squares(map.into(), &mut out, &mut VisibilityDistanceScratch::default());
    out
}

/// The twin's squares, the bound where there is no boundary.
fn expected(width: usize, height: usize, map: &[bool], frame: Frame) -> Vec<i32> {
    let bound = 4 * (width * width + height * height) as i32;
    let squares = twin::signed_squares(width, height, map, frame == Frame::Zero);
    let signed = |i: usize| squares[i].map_or(if map[i] { bound } else { -bound }, |s| i32::try_from(s).unwrap());
    (0..map.len()).map(signed).collect()
}

#[test]
fn golden_distances_are_reproduced() {
    let golden = golden("signed_distance");
    let cases = golden["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 6);
    for case in cases {
        let rows: Vec<&str> = case["map_rows"].as_array().unwrap().iter().map(|r| r.as_str().unwrap()).collect();
        let (width, height) = (rows[0].len(), rows.len());
        let map: Vec<bool> = rows.concat().bytes().map(|b| b == b'1').collect();
        let bound = 4 * (width * width + height * height) as i64;
        for (frame, key) in [(Frame::Open, "signed_4d2_no_border"), (Frame::Zero, "signed_4d2_outside_is_zero")] {
            let values = case[key].as_array().unwrap().iter().flat_map(|r| r.as_array().unwrap());
            let sign = |i: usize| if map[i] { 1 } else { -1 };
            let want: Vec<i64> = values.enumerate().map(|(i, v)| v.as_i64().unwrap_or(sign(i) * bound)).collect();
            let got: Vec<i64> = squares(width, height, &map, frame).into_iter().map(i64::from).collect();
            assert_eq!(got, want, "{} {frame:?}", case["name"]);
            let twin: Vec<i64> = expected(width, height, &map, frame).into_iter().map(i64::from).collect();
            assert_eq!(twin, want, "twin: {} {frame:?}", case["name"]);
        }
    }
}

#[test]
fn golden_coverages_are_reproduced() {
    let golden = golden("square_and_hemisphere");
    let rows = golden["coverage"].as_array().unwrap();
    assert_eq!(rows.len(), 61);
    for row in rows {
        let [d, edge, angle] = std::array::from_fn(|k| rational(&row[k]));
        let want = row[3].as_f64().unwrap();
        assert_close(half_plane_coverage(d, edge, [angle.cos(), angle.sin()]), want, 1e-14, "half-plane");
        assert_close(twin::half_plane_coverage(d, edge, angle), want, 1e-14, "cut polygon");
    }
    let rows = golden["orientation_average"].as_array().unwrap();
    for row in rows {
        let (t, want) = (rational(&row[0]), row[1].as_f64().unwrap());
        assert_close(mean_coverage(t, 2.0), want, 1e-14, "mean");
        assert_close(twin::mean_coverage(t, 2.0), want, 1e-12, "mean by quadrature");
    }
}
