//! Biclusters with loss: their errors against dense matrices, their order against every choice.

use haarmonic::Error;
use haarmonic::compress::{Bicluster, BiclusterSettings, Biclustering, SparseMatrix};
use haarmonic::reference::compress as twin;
use haarmonic::strategies::block_matrix;
use proptest::prelude::*;

use crate::support::{assert_close, cases, noise};

fn dense(matrix: &SparseMatrix) -> Vec<Vec<i64>> {
    let row = |j| (0..matrix.columns()).map(|k| i64::from(matrix.level(j, k))).collect();
    (0..matrix.rows()).map(row).collect()
}

fn exact(matrix: &SparseMatrix) -> Biclustering {
    Biclustering::new(matrix, &BiclusterSettings::default(), &()).unwrap()
}

/// Weights, some of them 0.
fn weights(count: usize, seed: usize) -> Vec<f64> {
    (0..count).map(|i| (4.0 * noise(seed + i) - 1.0).max(0.0)).collect()
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn errors_are_those_of_the_matrices(matrix in block_matrix(24, 16), bound in 0.0..40.0f64, weighted in any::<bool>()) {
        let all = exact(&matrix);
        let (rows, columns) = if weighted {
            (weights(matrix.rows(), 0), weights(matrix.columns(), 100))
        } else {
            (vec![1.0; matrix.rows()], vec![1.0; matrix.columns()])
        };
        let pruning = if weighted { all.weighted_pruning(&rows, &columns).unwrap() } else { all.pruning() };
        let unit = matrix.scale().powi(2);
        let error = |of: &Biclustering| {
            unit * twin::weighted_squared_error(&dense(&matrix), &dense(&of.to_matrix()), &rows, &columns)
        };
        // Every point of the curve is one of `within`, but for those that a later one is better than.
        let mut last = f64::INFINITY;
        for (k, point) in pruning.curve().iter().enumerate().rev() {
            if point.squared_error >= last {
                continue;
            }
            last = point.squared_error;
            let (left, found) = pruning.within(point.squared_error * (1.0 + 1e-12)).unwrap();
            prop_assert_eq!((found.bytes, found.flops), (point.bytes, point.flops), "point {}", k);
            prop_assert_eq!((left.stats().bytes, left.stats().flops), (point.bytes, point.flops));
            assert_close(found.squared_error, error(&left), 1e-14 * error(&left), "found");
            assert_close(point.squared_error, error(&left), 1e-13 * error(&left) + 1e-14 * unit, "point");
        }
        // A bound is kept, and nothing of the curve that keeps it is smaller.
        let (left, found) = pruning.within(bound).unwrap();
        prop_assert!(found.squared_error <= bound && error(&left) <= bound * (1.0 + 1e-14));
        prop_assert!(pruning.curve().iter().all(|p| p.bytes >= found.bytes || p.squared_error > bound));
        if !weighted {
            // Squares of integers times a power of two.
            prop_assert_eq!(found.squared_error, error(&left));
        }
    }

    #[test]
    fn the_ends_are_everything_and_nothing(matrix in block_matrix(24, 16)) {
        let all = exact(&matrix);
        let pruning = all.pruning();
        let (first, last) = (pruning.curve()[0], *pruning.curve().last().unwrap());
        prop_assert_eq!((first.bytes, first.flops, first.squared_error), (all.stats().bytes, all.stats().flops, 0.0));
        prop_assert_eq!((last.bytes, last.flops), (4 + 4 * (matrix.rows() + 1), 0));
        let (left, point) = pruning.within(0.0).unwrap();
        prop_assert_eq!((left.to_matrix(), point.squared_error), (matrix.clone(), 0.0));
        let (none, point) = pruning.within(f64::INFINITY).unwrap();
        let squares: f64 = dense(&matrix).iter().flatten().map(|&t| (t * t) as f64).sum();
        prop_assert!(none.is_empty() && none.to_matrix().nnz() == 0);
        prop_assert_eq!(point.squared_error, squares * matrix.scale().powi(2));
        prop_assert!(pruning.curve().windows(2).all(|p| p[1].bytes < p[0].bytes && p[1].flops <= p[0].flops));
    }

    #[test]
    fn no_choice_is_better_where_biclusters_do_not_overlap(
        sizes in prop::collection::vec((1..4usize, 1..4usize), 1..4),
        levels in prop::collection::vec(prop_oneof![-4..-1i32, 1..5i32], 9),
        seed in 0..1000usize,
    ) {
        // Side by side down the diagonal: nine columns at most.
        let (mut row, mut column, mut parts) = (0u32, 0u32, Vec::new());
        for (r, l) in sizes {
            let (rows, columns) = (row..row + r as u32, column..column + l as u32);
            let levels = levels[column as usize..][..l].to_vec();
            parts.push((rows.collect::<Vec<_>>(), columns.collect::<Vec<_>>(), levels));
            (row, column) = (row + r as u32, column + l as u32);
        }
        let shape = [row as usize, column as usize];
        let biclusters = parts.iter().map(|(rows, columns, levels)| Bicluster { rows, columns, levels });
        let all = Biclustering::from_parts(shape[0], shape[1], 0.5, biclusters).unwrap();
        let (rows, columns) = (weights(shape[0], seed), weights(shape[1], seed + 500));
        let wide = |list: &[u32]| list.iter().map(|&i| i as usize).collect::<Vec<_>>();
        let naive: Vec<_> = parts
            .iter()
            .map(|(rows, columns, levels)| (wide(rows), wide(columns), levels.iter().map(|&t| i64::from(t)).collect()))
            .collect();
        for point in all.weighted_pruning(&rows, &columns).unwrap().curve() {
            let least = 0.25 * twin::least_pruning_error(shape, &naive, point.bytes, [&rows, &columns]);
            assert_close(point.squared_error, least, 1e-13 * least, "least error for these bytes");
        }
    }
}

#[test]
fn columns_without_weight_go_first() {
    let levels = [[4, 3, 2, 2], [4, 3, 2, 2], [4, 3, 2, 1]];
    let triplets = (0..3).flat_map(|j| (0..4).map(move |k| (j, k, levels[j][k])));
    let matrix = SparseMatrix::from_triplets(3, 4, 0.25, triplets).unwrap();
    let all = exact(&matrix);
    // Nobody looks at columns 0 and 3.
    let (left, point) = all.weighted_pruning(&[1.0; 3], &[0.0, 1.0, 2.0, 0.0]).unwrap().within(0.0).unwrap();
    assert_eq!((left.len(), point.squared_error, left.to_matrix().nnz()), (1, 0.0, 6));
    // Nobody looks at anything.
    let (left, point) = all.weighted_pruning(&[0.0; 3], &[1.0; 4]).unwrap().within(0.0).unwrap();
    assert_eq!((left.len(), point.squared_error, point.flops), (0, 0.0, 0));
    assert_eq!(all.stats().dense_bytes, 12);
}

#[test]
fn nothing_to_prune() {
    for (rows, columns) in [(0, 0), (3, 0), (0, 2), (2, 2)] {
        let matrix = SparseMatrix::from_triplets(rows, columns, 1.0, []).unwrap();
        let all = exact(&matrix);
        let pruning = all.pruning();
        assert_eq!(pruning.curve().len(), 1);
        assert_eq!(pruning.within(1.0).unwrap().0, all);
    }
}

#[test]
fn wrong_weights_and_bounds_are_refused() {
    let matrix = SparseMatrix::from_triplets(2, 3, 1.0, [(0, 1, 2)]).unwrap();
    let all = exact(&matrix);
    let length = |what, expected, got| Error::Length { what, expected, got };
    let wrong = |rows: &[f64], columns: &[f64]| all.weighted_pruning(rows, columns).map(|_| ()).unwrap_err();
    assert_eq!(wrong(&[1.0], &[1.0; 3]), length("weights of rows", 2, 1));
    assert_eq!(wrong(&[1.0; 2], &[1.0; 4]), length("weights of columns", 3, 4));
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(wrong(&[1.0, bad], &[1.0; 3]), Error::OutOfRange { what: "weights of rows", .. }));
        assert!(matches!(wrong(&[1.0; 2], &[bad; 3]), Error::OutOfRange { what: "weights of columns", .. }));
    }
    for bad in [-1.0, f64::NAN] {
        assert!(matches!(all.pruning().within(bad), Err(Error::OutOfRange { .. })));
    }
}
