//! Sparse matrices with blocks.

use proptest::collection::vec;
use proptest::prelude::*;

use crate::compress::SparseMatrix;

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
