//! Biclustering against the deterministic golden run, the naive twin, and its own laws.
#![cfg(all(feature = "reference", feature = "proptest"))]

mod support;

use haarmonic::compress::{
    BiclusterMove, BiclusterSettings, BiclusterStep, BiclusterTrace, Biclustering, Seeds, SparseMatrix,
};
use haarmonic::reference::compress as twin;
use haarmonic::strategies::block_matrix;
use haarmonic::{Error, Progress};
use proptest::prelude::*;
use serde_json::Value;
use support::{golden, rational};

fn cases() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(48);
    ProptestConfig::with_cases(cases)
}

fn dense(matrix: &SparseMatrix) -> Vec<Vec<i64>> {
    let row = |j| (0..matrix.columns()).map(|k| i64::from(matrix.level(j, k))).collect();
    (0..matrix.rows()).map(row).collect()
}

fn from_rows<const N: usize>(rows: &[[i32; N]]) -> SparseMatrix {
    let triplets = rows.iter().enumerate().flat_map(|(j, row)| row.iter().enumerate().map(move |(k, &v)| (j, k, v)));
    SparseMatrix::from_triplets(rows.len(), N, 0.25, triplets).unwrap()
}

fn one_group() -> BiclusterSettings {
    BiclusterSettings::default().with_group_rows(usize::MAX)
}

fn list(v: &Value) -> Vec<u64> {
    v.as_array().unwrap().iter().map(|v| v.as_u64().unwrap()).collect()
}

/// Values of the golden file are multiples of 1/4.
fn level(v: &Value) -> i32 {
    let level = rational(v) * 4.0;
    assert_eq!(level, level.round());
    level as i32
}

#[test]
fn golden_run() {
    let file = golden("bicluster");
    let runs = file["cases"].as_array().unwrap();
    assert!(runs.len() >= 3);
    for run in runs {
        let t: Vec<Vec<i32>> =
            run["T"].as_array().unwrap().iter().map(|r| r.as_array().unwrap().iter().map(level).collect()).collect();
        let triplets = t.iter().enumerate().flat_map(|(j, r)| r.iter().enumerate().map(move |(k, &v)| (j, k, v)));
        let matrix = SparseMatrix::from_triplets(t.len(), t[0].len(), 0.25, triplets).unwrap();
        assert_eq!(matrix.nnz() as u64, run["nnz"].as_u64().unwrap());
        let (found, traces) = Biclustering::traced(&matrix, &one_group(), &()).unwrap();
        let wanted = run["biclusters"].as_array().unwrap();
        assert_eq!(found.len(), wanted.len());
        for ((b, trace), want) in found.iter().zip(&traces).zip(wanted) {
            assert_eq!(b.rows.iter().map(|&j| u64::from(j)).collect::<Vec<_>>(), list(&want["rows"]));
            assert_eq!(b.columns.iter().map(|&k| u64::from(k)).collect::<Vec<_>>(), list(&want["cols"]));
            assert_eq!(b.levels, want["t"].as_array().unwrap().iter().map(level).collect::<Vec<_>>());
            assert_eq!(b.cost() as u64, want["cost"].as_u64().unwrap());
            assert_eq!(Some(trace.saving), want["delta_w"].as_i64());
            assert_eq!(vec![trace.seed.0 as u64, trace.seed.1 as u64], list(&want["seed"]));
            assert_eq!(trace.steps.iter().map(step_of).collect::<Vec<_>>(), *want["ops"].as_array().unwrap());
        }
        let stats = found.stats();
        assert_eq!(stats.flops as u64, run["total_cost"].as_u64().unwrap());
        assert_eq!(stats.matrix_flops as u64, run["dense_cost_2nnz"].as_u64().unwrap());
        // Multiples of 1/4 times small integers: exact.
        let light: Vec<f64> = list(&run["L"]).iter().map(|&x| x as f64).collect();
        let want: Vec<f64> = run["TL"].as_array().unwrap().iter().map(rational).collect();
        let mut got = vec![f64::NAN; want.len()];
        found.multiplier().multiply(&light, 1, &mut got);
        assert_eq!(got, want);
        matrix.multiply(&light, 1, &mut got);
        assert_eq!(got, want);
    }
}

fn step_of(step: &BiclusterStep) -> Value {
    let name = match step.kind {
        BiclusterMove::AddRow => "+r",
        BiclusterMove::AddColumn => "+c",
        BiclusterMove::DeleteRow => "-r",
        BiclusterMove::DeleteColumn => "-c",
    };
    serde_json::json!([name, step.index, step.saving])
}

/// Asserts that the fast search made exactly the twin's moves from the same seeds.
fn assert_same_moves(matrix: &SparseMatrix, found: &Biclustering, traces: &[BiclusterTrace]) {
    let mut seeds = traces.iter().map(|t| t.seed);
    let naive = twin::bicluster(&dense(matrix), |_| seeds.next());
    assert_eq!(traces.len(), found.len());
    for (((b, trace), (want, rows, columns, values)), at) in found.iter().zip(traces).zip(&naive).zip(0..) {
        assert_eq!(trace, want, "bicluster {at}");
        assert!(b.rows.iter().map(|&j| j as usize).eq(rows.iter().copied()), "rows of bicluster {at}");
        assert!(b.columns.iter().map(|&k| k as usize).eq(columns.iter().copied()), "columns of bicluster {at}");
        assert!(b.levels.iter().map(|&t| i64::from(t)).eq(values.iter().copied()), "levels of bicluster {at}");
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn every_move_is_the_twins(matrix in block_matrix(14, 12)) {
        let (found, traces) = Biclustering::traced(&matrix, &one_group(), &()).unwrap();
        let mut left = dense(&matrix);
        for (b, trace) in found.iter().zip(&traces) {
            prop_assert_eq!(Some(trace.seed), twin::first_nonzero(&left));
            for &row in b.rows {
                b.columns.iter().zip(b.levels).for_each(|(&k, &t)| left[row as usize][k as usize] -= i64::from(t));
            }
        }
        prop_assert_eq!(twin::first_nonzero(&left), None);
        assert_same_moves(&matrix, &found, &traces);
    }
}
