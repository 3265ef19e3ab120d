//! Strategies for [`backend`](crate::backend).

use proptest::prelude::*;

use crate::backend::block_product::BlockLayout;
use crate::compress::ScanOrder;
use crate::sphere::CubeGrid;

/// A layout of blocks of 8², 16² or 32² pixels on a cube map of up to `max_side` texels along an edge, in any order:
/// one block a face, and sides that are no power of two, among them.
///
/// # Panics
/// Unless `max_side` is from 8 to [`BlockLayout::MAX_SIDE`].
#[track_caller]
pub fn block_layout(max_side: usize) -> BoxedStrategy<BlockLayout> {
    assert!((8..=BlockLayout::MAX_SIDE).contains(&max_side), "a largest side of {max_side}");
    let blocks: Vec<usize> = [8, 16, 32].into_iter().filter(|&block| block <= max_side).collect();
    let order = prop::sample::select(vec![ScanOrder::RowMajor, ScanOrder::Serpentine, ScanOrder::Hilbert]);
    (prop::sample::select(blocks), order)
        .prop_flat_map(move |(block, order)| {
            let along = prop_oneof![1 => Just(1), 3 => 1..=max_side / block];
            along.prop_map(move |along| {
                let grid = CubeGrid::new(along * block).expect("at most the largest side");
                BlockLayout::new(grid, block, order).expect("a multiple of the block's side")
            })
        })
        .boxed()
}
