//! Biclustering against the deterministic golden run, the naive twin, and its own laws.

use crate::support::{HAAR_AFFINE, cases, golden, number};
use haarmonic::compress::{
    BiclusterMove, BiclusterMultiplier, BiclusterSettings, BiclusterStep, BiclusterTrace, Biclustering, Seeds,
    SparseMatrix,
};
use haarmonic::reference::compress as twin;
use haarmonic::strategies::block_matrix;
use haarmonic::{Error, Progress, Real};
use proptest::prelude::*;
use serde_json::Value;

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
    let level = number(v) * 4.0;
    assert_eq!(level, level.round());
    level as i32
}

#[test]
fn golden_run() {
    let file = golden(HAAR_AFFINE, "bicluster");
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
        let want: Vec<f64> = run["TL"].as_array().unwrap().iter().map(number).collect();
        let mut got = vec![f64::NAN; want.len()];
        product(&found.multiplier(), 1, &light, &mut got);
        assert_eq!(got, want);
        matrix.multiply(&light, &mut got);
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
    for (((b, trace), want), at) in found.iter().zip(traces).zip(&naive).zip(0..) {
        assert_eq!(*trace, want.trace, "bicluster {at}");
        assert!(b.rows.iter().map(|&j| j as usize).eq(want.rows.iter().copied()), "rows of bicluster {at}");
        assert!(b.columns.iter().map(|&k| k as usize).eq(want.columns.iter().copied()), "columns of bicluster {at}");
        assert!(b.levels.iter().map(|&t| i64::from(t)).eq(want.values.iter().copied()), "levels of bicluster {at}");
    }
}

/// Settings that lead to different groups and seeds.
fn settings() -> impl Strategy<Value = BiclusterSettings> {
    let seeds = prop_oneof![Just(Seeds::First), any::<u64>().prop_map(Seeds::Random)];
    let group_rows = prop_oneof![1..6usize, Just(usize::MAX)];
    (seeds, group_rows).prop_map(|(s, g)| BiclusterSettings::default().with_seeds(s).with_group_rows(g))
}

/// Right-hand sides whose products with levels round.
fn right_hand_sides(len: usize) -> Vec<f64> {
    (0..len).map(|i| ((i as f64 + 0.7) * 0.618_033_988_749_895).fract() * 3.0 - 1.0).collect()
}

/// For each row: (an upper bound of the terms in its longest chain of sums, Σ |t x| over its biclusters).
fn magnitudes(found: &Biclustering, x: &[f64]) -> Vec<(f64, f64)> {
    let mut rows = vec![(0.0, 0.0); found.rows()];
    for b in found.iter() {
        let terms = b.columns.iter().zip(b.levels);
        let sum: f64 = terms.map(|(&k, &t)| (found.scale() * f64::from(t) * x[k as usize]).abs()).sum();
        for &row in b.rows {
            let (longest, total) = &mut rows[row as usize];
            (*longest, *total) = (*longest + b.columns.len() as f64 + 1.0, *total + sum);
        }
    }
    rows
}

proptest! {
    #![proptest_config(cases(48))]

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

    #[test]
    fn every_move_is_the_twins_from_random_seeds(matrix in block_matrix(14, 12), seed in any::<u64>()) {
        let (found, traces) = Biclustering::traced(&matrix, &one_group().with_seeds(Seeds::Random(seed)), &()).unwrap();
        assert_same_moves(&matrix, &found, &traces);
    }

    #[test]
    fn the_sum_is_the_matrix(matrix in block_matrix(24, 16), settings in settings()) {
        let (found, traces) = Biclustering::traced(&matrix, &settings, &()).unwrap();
        prop_assert_eq!(&found, &Biclustering::new(&matrix, &settings, &()).unwrap());
        let mut sum = vec![vec![0; matrix.columns()]; matrix.rows()];
        for b in found.iter() {
            prop_assert!(b.rows.is_sorted_by(|a, b| a < b) && b.columns.is_sorted_by(|a, b| a < b));
            prop_assert!(!b.rows.is_empty() && !b.columns.is_empty() && !b.levels.contains(&0));
            for &row in b.rows {
                b.columns.iter().zip(b.levels).for_each(|(&k, &t)| sum[row as usize][k as usize] += i64::from(t));
            }
        }
        prop_assert_eq!(sum, dense(&matrix));
        prop_assert_eq!(found.to_matrix(), matrix.clone());
        // Cost: by its definition, and as what is left of the sparse product's.
        let cost: usize = found.iter().map(|b| b.rows.len() + 2 * b.columns.len() - 1).sum();
        let saved: i64 = traces.iter().map(|t| t.saving).sum();
        let stats = found.stats();
        prop_assert_eq!((stats.flops, stats.biclusters), (cost, found.len()));
        prop_assert_eq!(found.iter().map(|b| b.cost()).sum::<usize>(), cost);
        prop_assert_eq!(cost as i64, 2 * matrix.nnz() as i64 - saved);
        prop_assert!(traces.iter().all(|t| t.saving >= 0));
        prop_assert_eq!((stats.matrix_flops, stats.matrix_bytes), (matrix.flops(), matrix.bytes()));
    }

    #[test]
    fn a_group_is_biclustered_as_if_alone(matrix in block_matrix(16, 12), labels in prop::collection::vec(0..4u32, 16)) {
        let labels = &labels[..matrix.rows()];
        let found = Biclustering::with_groups(&matrix, labels, &BiclusterSettings::default(), &()).unwrap();
        let mut rest = found.iter();
        for group in 0..4 {
            let entries = (0..matrix.rows()).filter(|&j| labels[j] == group).flat_map(|j| {
                let (columns, levels) = matrix.row(j);
                columns.iter().zip(levels).map(move |(&k, &t)| (j, k as usize, t))
            });
            let alone = SparseMatrix::from_triplets(matrix.rows(), matrix.columns(), matrix.scale(), entries).unwrap();
            let alone = Biclustering::new(&alone, &one_group(), &()).unwrap();
            for want in alone.iter() {
                prop_assert_eq!(rest.next(), Some(want));
            }
        }
        prop_assert_eq!(rest.next(), None);
    }

    #[test]
    fn products_are_the_twins(matrix in block_matrix(24, 16), settings in settings()) {
        let found = Biclustering::new(&matrix, &settings, &()).unwrap();
        let x = right_hand_sides(matrix.columns());
        let want = twin::multiply_levels(&dense(&matrix), matrix.scale(), &x);
        let mut got = vec![f64::NAN; matrix.rows()];
        product(&found.multiplier(), 1, &x, &mut got);
        let narrow: Vec<f32> = x.iter().map(|&x| x as f32).collect();
        let mut got_f32 = vec![f32::NAN; matrix.rows()];
        product(&found.multiplier(), 1, &narrow, &mut got_f32);
        let mut sparse = vec![f32::NAN; matrix.rows()];
        matrix.multiply(&narrow, &mut sparse);
        for (row, (terms, sum)) in magnitudes(&found, &x).into_iter().enumerate() {
            // Each term is rounded once, and by each of the at most `terms` sums above it; narrowing x is one more.
            let off = |got: f64, eps: f64| (got - want[row]).abs() <= (terms + 2.0) * 0.5 * eps * sum;
            prop_assert!(off(got[row], 2.0 * f64::EPSILON), "row {}: {} for {}", row, got[row], want[row]); // the twin rounds too
            prop_assert!(off(f64::from(got_f32[row]), f64::from(f32::EPSILON)), "row {}: {}", row, got_f32[row]);
            prop_assert!(off(f64::from(sparse[row]), f64::from(f32::EPSILON) * 8.0), "row {}: {}", row, sparse[row]);
        }
    }

    #[test]
    fn a_right_hand_side_has_the_same_bits_alone_and_with_others(matrix in block_matrix(24, 16), sides in 0..19usize) {
        let found = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).unwrap();
        let plan = found.multiplier::<f32>();
        let x: Vec<f32> = right_hand_sides(matrix.columns() * sides).iter().map(|&x| x as f32).collect();
        let (mut all, mut sparse) = (vec![f32::NAN; matrix.rows() * sides], vec![f32::NAN; matrix.rows() * sides]);
        product(&plan, sides, &x, &mut all);
        matrix.multiply_batch(sides, &x, &mut sparse);
        for side in 0..sides {
            let one: Vec<f32> = x.iter().skip(side).step_by(sides).copied().collect();
            let mut out = vec![f32::NAN; matrix.rows()];
            product(&plan, 1, &one, &mut out);
            prop_assert!(all.iter().skip(side).step_by(sides).zip(&out).all(|(a, b)| a.to_bits() == b.to_bits()));
            matrix.multiply(&one, &mut out);
            prop_assert!(sparse.iter().skip(side).step_by(sides).zip(&out).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}

/// Rows as of a transfer matrix: `directions` normals on a circle, each sees half of it, in bins of 6 columns.
fn circle(directions: usize) -> SparseMatrix {
    const COLUMNS: usize = 96;
    let entry = |vertex: usize, k: usize| {
        let at = (k + COLUMNS - vertex * COLUMNS / directions) % COLUMNS;
        let level = if at == 0 || vertex % 7 == 3 && at % 5 == 0 { 2 } else { 4 };
        (vertex * 8 + at % (COLUMNS / 2) / 6, k, if at < COLUMNS / 2 { level } else { 0 })
    };
    let triplets = (0..directions).flat_map(|vertex| (0..COLUMNS).map(move |k| entry(vertex, k)));
    SparseMatrix::from_triplets(directions * 8, COLUMNS, 0.25, triplets).unwrap()
}

#[test]
#[cfg(feature = "rayon")]
fn same_for_any_number_of_threads() {
    let matrix = circle(300);
    let settings = BiclusterSettings::default().with_group_rows(100).with_seeds(Seeds::Random(3));
    let x: Vec<f32> = right_hand_sides(3 * matrix.columns()).iter().map(|&x| x as f32).collect();
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            let found = Biclustering::new(&matrix, &settings, &()).unwrap();
            let mut out = vec![f32::NAN; 3 * matrix.rows()];
            product(&found.multiplier(), 3, &x, &mut out);
            (found, out.into_iter().map(f32::to_bits).collect::<Vec<_>>())
        })
    };
    let one = run(1);
    assert!(one.0.len() > 20);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn structure_is_found_within_groups() {
    let matrix = circle(300);
    let flops = |group_rows| {
        let settings = BiclusterSettings::default().with_group_rows(group_rows);
        Biclustering::new(&matrix, &settings, &()).unwrap().stats().flops as f64 / matrix.flops() as f64
    };
    let (whole, groups, single) = (flops(usize::MAX), flops(300), flops(1));
    // A row by itself: l multiplications and additions, nothing gained.
    assert_eq!(single, 1.0);
    let consecutive: Vec<u32> = (0..matrix.rows() as u32).map(|row| row / 300).collect();
    let consecutive = Biclustering::with_groups(&matrix, &consecutive, &BiclusterSettings::default(), &()).unwrap();
    let consecutive = consecutive.stats().flops as f64 / matrix.flops() as f64;
    // Groups of shared columns lose little against none (measured .2158 and .2216).
    assert!(whole < 0.217 && groups < 0.223, "{whole} {groups}");
    assert!(consecutive > 1.1 * groups, "{consecutive}");
}

#[test]
fn seeds_are_chosen_by_their_number() {
    let matrix = circle(40);
    let first = |seeds| {
        let (_, traces) = Biclustering::traced(&matrix, &one_group().with_seeds(seeds), &()).unwrap();
        traces[0].seed
    };
    assert_eq!(first(Seeds::First), (0, 0));
    assert_eq!(first(Seeds::Random(7)), first(Seeds::Random(7)));
    let starts: std::collections::BTreeSet<_> = (0..20).map(|seed| first(Seeds::Random(seed))).collect();
    // Twenty of 1,920 places; a repetition has probability .1, three of them 1e-4.
    assert!(starts.len() >= 18, "{starts:?}");
}

/// Counts calls; asks to stop after some.
#[derive(Default)]
struct Watch {
    seen: std::sync::Mutex<Vec<(usize, usize)>>,
    stop_after: Option<usize>,
    asked: std::sync::atomic::AtomicUsize,
}

impl Progress for Watch {
    fn advance(&self, done: usize, total: usize) {
        self.seen.lock().unwrap().push((done, total));
    }
    fn is_cancelled(&self) -> bool {
        let asked = self.asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        self.stop_after.is_some_and(|n| asked >= n)
    }
}

#[test]
fn progress_counts_the_non_zeros_and_can_stop() {
    let matrix = circle(300);
    let settings = BiclusterSettings::default().with_group_rows(500);
    let watch = Watch::default();
    Biclustering::new(&matrix, &settings, &watch).unwrap();
    let seen = watch.seen.into_inner().unwrap();
    assert!(seen.iter().all(|&(done, total)| done <= total && total == matrix.nnz()));
    assert_eq!(seen.iter().map(|s| s.0).max(), Some(matrix.nnz()));
    assert!((5..2000).contains(&seen.len()), "{} reports", seen.len());
    for stop_after in [0, 1, 40] {
        let watch = Watch { stop_after: Some(stop_after), ..Watch::default() };
        assert_eq!(Biclustering::new(&matrix, &settings, &watch), Err(Error::Cancelled));
    }
}

/// The product with `count` right-hand sides.
fn product<T: Real>(plan: &BiclusterMultiplier<T>, count: usize, x: &[T], out: &mut [T]) {
    plan.multiply_batch(count, x, out, &mut vec![T::zero(); plan.scratch_len(count)]);
}

#[test]
fn degenerate_matrices() {
    let bicluster = |matrix: &SparseMatrix| Biclustering::new(matrix, &BiclusterSettings::default(), &()).unwrap();
    // Without entries: no biclusters, products of zero.
    for (rows, columns) in [(0, 0), (0, 5), (5, 0), (4, 3)] {
        let zero = SparseMatrix::from_triplets(rows, columns, 1.0, []).unwrap();
        let found = bicluster(&zero);
        assert!(found.is_empty() && found.to_matrix() == zero);
        let mut out = vec![f64::NAN; rows];
        product(&found.multiplier(), 1, &vec![1.0; columns], &mut out);
        assert_eq!(out, vec![0.0; rows]);
        zero.multiply(&vec![1.0; columns], &mut out);
        assert_eq!(out, vec![0.0; rows]);
        assert_eq!((found.stats().flops, found.stats().bytes), (0, 4 + 4 * (rows + 1)));
    }
    // All equal: one bicluster, whatever the shape.
    for (rows, columns) in [(1, 1), (1, 7), (7, 1), (5, 9), (9, 5)] {
        let places = (0..rows * columns).map(|i| (i / columns, i % columns, 3));
        let found = bicluster(&SparseMatrix::from_triplets(rows, columns, 0.5, places).unwrap());
        // A single row or column has nothing to gain from more than an element: 2 nnz either way.
        let (count, cost) = match (rows, columns) {
            (1, n) => (n, 2 * n),
            _ => (1, rows + 2 * columns - 1),
        };
        assert_eq!((found.len(), found.stats().flops), (count, cost), "{rows} × {columns}");
    }
    // The identity has no structure.
    let identity = SparseMatrix::from_triplets(6, 6, 1.0, (0..6).map(|i| (i, i, 1))).unwrap();
    assert_eq!((bicluster(&identity).len(), bicluster(&identity).stats().flops), (6, 12));
    // The largest levels, both signs: residuals are twice as large, and exact.
    let m = SparseMatrix::MAX_LEVEL;
    let large = from_rows(&[[m, -m, m, 0], [m, -m, -m, 1], [m, m, m, 0], [-m, -m, m, 0]]);
    assert_eq!(bicluster(&large).to_matrix(), large);
}

#[test]
fn entries_in_any_order_and_twice() {
    let matrix =
        SparseMatrix::from_triplets(2, 3, 0.5, [(1, 2, 4), (0, 2, 1), (0, 0, 7), (1, 2, -4), (0, 2, 1)]).unwrap();
    assert_eq!(matrix, from_rows_scaled(0.5, &[[7, 0, 2], [0, 0, 0]]));
    assert_eq!((matrix.nnz(), matrix.row(0), matrix.row(1)), (2, (&[0, 2][..], &[7, 2][..]), (&[][..], &[][..])));
    // Values are rounded to the scale, halves away from zero.
    let matrix =
        SparseMatrix::quantise(1, 4, 0.25, [(0, 0, 0.375), (0, 1, -0.375), (0, 2, 0.12), (0, 3, 1.0)]).unwrap();
    assert_eq!(matrix, from_rows(&[[2, -2, 0, 4]]));
}

fn from_rows_scaled<const N: usize>(scale: f64, rows: &[[i32; N]]) -> SparseMatrix {
    let triplets = rows.iter().enumerate().flat_map(|(j, row)| row.iter().enumerate().map(move |(k, &v)| (j, k, v)));
    SparseMatrix::from_triplets(rows.len(), N, scale, triplets).unwrap()
}

#[test]
fn wrong_input_is_refused() {
    let range = |result: Result<SparseMatrix, Error>| matches!(result, Err(Error::OutOfRange { .. }));
    let length = |result: Result<SparseMatrix, Error>| matches!(result, Err(Error::Length { .. }));
    assert!(range(SparseMatrix::from_triplets(2, 3, 1.0, [(2, 0, 1)])));
    assert!(range(SparseMatrix::from_triplets(2, 3, 1.0, [(0, 3, 1)])));
    assert!(range(SparseMatrix::from_triplets(0, 0, 1.0, [(0, 0, 0)])));
    assert!(range(SparseMatrix::from_triplets(1 << 31, 1, 1.0, [])));
    assert!(range(SparseMatrix::from_triplets(1, 1 << 31, 1.0, [])));
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(range(SparseMatrix::from_triplets(1, 1, scale, [])), "{scale}");
    }
    let m = SparseMatrix::MAX_LEVEL;
    assert!(range(SparseMatrix::from_triplets(1, 1, 1.0, [(0, 0, m + 1)])));
    assert!(range(SparseMatrix::from_triplets(1, 1, 1.0, [(0, 0, m), (0, 0, 1)])));
    assert!(range(SparseMatrix::from_triplets(1, 1, 1.0, [(0, 0, i32::MIN)])));
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let triplets = [(0, 0, 1.0), (0, 1, value)];
        let refused = SparseMatrix::quantise(1, 2, 1.0, triplets);
        assert_eq!(refused, Err(Error::NotFinite { what: "sparse matrix", index: 1 }));
    }
    assert!(range(SparseMatrix::quantise(1, 1, 1e-30, [(0, 0, 1.0)])));

    let rows = |offsets: &[usize], columns: &[u32], levels: &[i32]| {
        SparseMatrix::from_rows(3, 1.0, offsets.to_vec(), columns.to_vec(), levels.to_vec())
    };
    assert_eq!(
        rows(&[0, 2, 2, 3], &[0, 2, 1], &[1, 2, 3]).unwrap(),
        from_rows_scaled(1.0, &[[1, 0, 2], [0; 3], [0, 3, 0]])
    );
    assert_eq!(rows(&[], &[], &[]), Err(Error::Empty { what: "row offsets" }));
    assert!(length(rows(&[0, 1], &[0], &[])));
    assert!(length(rows(&[0, 2], &[0], &[1])));
    assert!(length(rows(&[1, 1], &[0], &[1])));
    assert!(range(rows(&[0, 2, 1], &[0], &[1])));
    assert!(range(rows(&[0, 1, 0, 1], &[0], &[1])));
    assert!(range(rows(&[0, 2], &[1, 1], &[1, 1])));
    assert!(range(rows(&[0, 2], &[2, 1], &[1, 1])));
    assert!(range(rows(&[0, 1], &[3], &[1])));
    assert!(range(rows(&[0, 1], &[0], &[0])));
    assert!(range(rows(&[0, 1], &[0], &[m + 1])));

    let matrix = circle(4);
    let settings = BiclusterSettings::default();
    let none = Biclustering::new(&matrix, &settings.with_group_rows(0), &());
    assert!(matches!(none, Err(Error::OutOfRange { what: "rows of a group", .. })));
    let short = Biclustering::with_groups(&matrix, &[0; 3], &settings, &());
    assert_eq!(short, Err(Error::Length { what: "groups of rows", expected: 32, got: 3 }));
}

#[test]
fn wrong_lengths_panic() {
    let matrix = circle(4);
    let plan = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).unwrap().multiplier::<f32>();
    let panics = |x: usize, out: usize, scratch: usize| {
        let run = || plan.multiply_batch(2, &vec![0.0; x], &mut vec![0.0; out], &mut vec![0.0; scratch]);
        std::panic::catch_unwind(run).is_err()
    };
    let scratch = plan.scratch_len(2);
    assert!(!panics(192, 64, scratch));
    assert!(panics(191, 64, scratch) && panics(192, 63, scratch) && panics(192, 64, scratch + 1));
    let sparse = |x: usize, out: usize| {
        std::panic::catch_unwind(|| matrix.multiply_batch(2, &vec![0.0f32; x], &mut vec![0.0; out])).is_err()
    };
    assert!(!sparse(192, 64) && sparse(191, 64) && sparse(192, 65));
}

#[test]
fn what_is_not_finite_reaches_the_rows_of_its_biclusters() {
    let matrix = circle(40);
    let found = Biclustering::new(&matrix, &one_group(), &()).unwrap();
    let mut x = vec![1.0f32; matrix.columns()];
    x[30] = f32::NAN;
    let mut out = vec![0.0; matrix.rows()];
    product(&found.multiplier(), 1, &x, &mut out);
    let mut reached = 0;
    for row in 0..matrix.rows() {
        let uses = found.iter().any(|b| b.columns.contains(&30) && b.rows.contains(&(row as u32)));
        assert_eq!(out[row].is_nan(), uses, "row {row}");
        assert!(uses || matrix.level(row, 30) == 0);
        reached += usize::from(uses);
    }
    assert!((1..matrix.rows()).contains(&reached));
}
