//! Summed-area tables against golden values and sums pixel by pixel.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod support;

use haarmonic::reference::table as twin;
use haarmonic::strategies;
use haarmonic::table::{DiskGrid, Outside, Rectangle, SummedArea, SummedAreaPlan, SummedAreaRef, SummedAreaStack};
use haarmonic::{Error, Real};
use proptest::prelude::*;
use support::{assert_close, golden, rational};

/// 48 cases, or as many as PROPTEST_CASES says.
fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|s| s.parse().ok()).unwrap_or(48);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn rectangle([left, top, right, bottom]: [f64; 4]) -> Rectangle {
    Rectangle { left, top, right, bottom }
}

fn sides(r: Rectangle) -> [f64; 4] {
    [r.left, r.top, r.right, r.bottom]
}

fn narrow<T: Real>(x: &[f64]) -> Vec<T> {
    x.iter().map(|&x| T::of(x)).collect()
}

#[test]
fn golden_tables_and_rectangles_are_reproduced() {
    let golden = golden("sat");
    let numbers = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()).map(|x| x.as_f64().unwrap()).collect()
    };
    let samples = numbers(&golden["table_rows_y"]);
    let want = numbers(&golden["sat_exclusive"]);
    assert_eq!(twin::summed_area(7, 6, &samples), want);
    let table: SummedArea<f64> = SummedArea::new(7, 6, &narrow::<f32>(&samples)).unwrap();
    assert_eq!(table.as_ref().entries(), want);
    let single: SummedArea<f32> = SummedArea::new(7, 6, &samples).unwrap();
    assert_eq!(single.as_ref().entries(), narrow::<f32>(&want));

    let rects = golden["rects"].as_array().unwrap();
    assert_eq!(rects.len(), 15);
    for row in rects {
        let [l, r, t, b, sum] = std::array::from_fn(|k| row[k].as_f64().unwrap());
        assert_eq!(table.sum(rectangle([l, t, r, b])), sum);
        assert_eq!(single.sum(rectangle([l, t, r, b])), sum);
        assert_eq!(twin::rectangle_sum([7, 6], &samples, [l, t, r, b], [false; 2]), sum);
    }
    let rects = golden["fractional_rects"].as_array().unwrap();
    assert_eq!(rects.len(), 15);
    for row in rects {
        let [l, r, t, b, sum] = std::array::from_fn(|k| rational(&row[k]));
        // Entries reach 714; a handful of roundings.
        assert_close(table.sum(rectangle([l, t, r, b])), sum, 1e-12, "fractional");
        assert_close(twin::rectangle_sum([7, 6], &samples, [l, t, r, b], [false; 2]), sum, 1e-12, "twin");
    }
}
