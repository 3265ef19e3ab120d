//! Maps to be coded, sparse matrices with blocks.

use proptest::collection::vec;
use proptest::prelude::*;

use crate::compress::SparseMatrix;

/// A binary map of `len` values: long runs, noise, alternating, one value out of line (first and last among them), constant.
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

/// A matrix of integer levels with structure to find: up to five rectangles of random rows and columns, constant along the rows, that may overlap, and
/// some levels changed. Shapes from 0 × 0 to `max_rows` × `max_columns`; also all zero, all equal, and without structure.
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
