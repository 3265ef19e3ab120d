//! Maps to be coded, sparse matrices with blocks.

use proptest::collection::vec;
use proptest::prelude::*;

use crate::compress::SparseMatrix;

/// A binary map of `len` values: long runs, noise, alternating, one value out of line (first and last among them),
/// constant.
pub fn run_map(len: usize) -> BoxedStrategy<Vec<bool>> {
    let longest = (len / 4).max(1);
    let runs = (any::<bool>(), vec(1..=longest, len / longest + 1..=len + 1)).prop_map(move |(first, runs)| {
        let values = runs.into_iter().enumerate().flat_map(|(i, run)| std::iter::repeat_n((i % 2 == 0) == first, run));
        let mut values: Vec<bool> = values.take(len).collect();
        values.resize(len, first);
        values
    });
    let last = len.saturating_sub(1);
    let place = prop_oneof![Just(0), Just(last), 0..=last];
    let odd_one = (place, any::<bool>()).prop_map(move |(at, value)| (0..len).map(|i| (i == at) == value).collect());
    prop_oneof![
        4 => runs,
        2 => vec(any::<bool>(), len),
        1 => any::<bool>().prop_map(move |first| (0..len).map(|i| (i % 2 == 0) == first).collect()),
        2 => odd_one,
        1 => any::<bool>().prop_map(move |value| std::vec![value; len]),
    ]
    .boxed()
}

/// A map of `len` levels from 0 to `top`: [`run_map`]s of two levels, and noise.
pub fn level_map(len: usize, top: u8) -> impl Strategy<Value = Vec<u8>> {
    let two = (run_map(len), 0..=top, 0..=top);
    prop_oneof![two.prop_map(|(map, a, b)| map.into_iter().map(|v| if v { a } else { b }).collect()), vec(0..=top, len),]
}

/// A matrix of integer levels with structure to find: up to five rectangles of random rows and columns, constant along
/// the rows, that may overlap, and some levels changed. Shapes from 0 × 0 to `max_rows` × `max_columns`; also all zero,
/// all equal, and without structure.
///
/// Levels are small; the scale is 1/4 or 1/16, as visibility sampled 2 × 2 and 4 × 4 times has it.
pub fn block_matrix(max_rows: usize, max_columns: usize) -> impl Strategy<Value = SparseMatrix> {
    let shape = (0..=max_rows, 0..=max_columns, prop_oneof![Just(0.25), Just(0.0625)]);
    shape.prop_flat_map(|(rows, columns, scale)| {
        dense_blocks(rows, columns).prop_map(move |dense| {
            let entry = |at: usize| (at / columns, at % columns, dense[at]);
            SparseMatrix::from_triplets(rows, columns, scale, (0..dense.len()).map(entry)).expect("small levels")
        })
    })
}

fn dense_blocks(rows: usize, columns: usize) -> BoxedStrategy<Vec<i32>> {
    let len = rows * columns;
    let block = (vec(any::<bool>(), rows), vec(prop_oneof![3 => Just(0), 2 => 1..=4], columns));
    let noise = vec((0..len.max(1), -4..=4), 0..=len / 6);
    let blocks = (vec(block, 1..=5), noise).prop_map(move |(blocks, noise)| {
        let mut dense = vec![0; len];
        for (chosen, levels) in &blocks {
            for row in (0..rows).filter(|&row| chosen[row]) {
                for column in (0..columns).filter(|&column| levels[column] != 0) {
                    dense[row * columns + column] = levels[column];
                }
            }
        }
        noise.iter().filter(|(at, _)| *at < len).for_each(|&(at, level)| dense[at] = level);
        dense
    });
    prop_oneof![
        6 => blocks,
        2 => vec(prop_oneof![2 => Just(0), 1 => 1..=2], len),
        1 => (1..=4).prop_map(move |level| std::vec![level; len]),
        1 => Just(std::vec![0; len]),
    ]
    .boxed()
}

/// Rows of numbers around 1 in magnitude: mean + Σ weights · directions + noise, of rank 0 to `columns`, the noise 0
/// (exactly low rank, but for rounding), small or all there is. 1 to `max_rows` rows of 1 to `max_columns`; repeated
/// rows, equal rows, zeros.
pub fn low_rank_rows(max_rows: usize, max_columns: usize) -> impl Strategy<Value = Vec<Vec<f64>>> {
    (1..=max_rows, 1..=max_columns).prop_flat_map(|(rows, columns)| flat_rows(rows, columns))
}

fn flat_rows(rows: usize, columns: usize) -> BoxedStrategy<Vec<Vec<f64>>> {
    let x = || -1.0..1.0f64;
    let directions = (0..=columns).prop_flat_map(move |rank| vec(vec(x(), columns), rank));
    let noise = prop_oneof![Just(0.0), Just(1e-3), Just(1.0)];
    let parts = (vec(x(), columns), directions, vec(vec(x(), columns), rows), vec(vec(x(), columns), rows), noise);
    type Parts = (Vec<f64>, Vec<Vec<f64>>, Vec<Vec<f64>>, Vec<Vec<f64>>, f64);
    let rows_of = move |(mean, directions, weights, noises, noise): Parts| {
        let entry = |row: usize, c: usize| {
            let sum: f64 = directions.iter().zip(&weights[row]).map(|(u, w)| w * u[c]).sum();
            mean[c] + sum + noise * noises[row][c]
        };
        (0..rows).map(|row| (0..columns).map(|c| entry(row, c)).collect()).collect::<Vec<Vec<f64>>>()
    };
    prop_oneof![
        8 => parts.prop_map(rows_of),
        1 => vec(x(), columns).prop_map(move |row| std::vec![row; rows]),
        1 => (vec(x(), columns), 0..rows).prop_map(move |(row, at)| {
            (0..rows).map(|i| if i == at { row.clone() } else { std::vec![0.0; columns] }).collect()
        }),
    ]
    .boxed()
}

/// Rows in one to `max_clusters` groups, each around a place of its own and flat in its own way as in
/// [`low_rank_rows`], in mixed order.
pub fn clustered_rows(
    max_clusters: usize,
    max_rows: usize,
    max_columns: usize,
) -> impl Strategy<Value = Vec<Vec<f64>>> {
    let groups = move |columns: usize| {
        let group = (1..=max_rows).prop_flat_map(move |rows| flat_rows(rows, columns));
        vec((vec(-8.0..8.0f64, columns), group), 1..=max_clusters)
    };
    (1..=max_columns).prop_flat_map(groups).prop_flat_map(|groups| {
        let moved = |(place, rows): (Vec<f64>, Vec<Vec<f64>>)| {
            rows.into_iter().map(move |row| row.iter().zip(&place).map(|(x, p)| x + p).collect::<Vec<f64>>())
        };
        Just(groups.into_iter().flat_map(moved).collect::<Vec<_>>()).prop_shuffle()
    })
}
