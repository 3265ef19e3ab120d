//! How cube maps are cut.

use haarmonic::Error;
use haarmonic::backend::block_product::BlockLayout;
use haarmonic::compress::ScanOrder;
use haarmonic::reference::backend::block_product as twin;

use super::support::{ORDERS, layout};
use crate::support::grid;

const SIZES: [(usize, usize); 9] =
    [(8, 8), (16, 8), (16, 16), (32, 32), (48, 8), (48, 16), (64, 32), (96, 32), (128, 16)];

#[test]
fn blocks_are_squares_and_hold_every_texel_once() {
    for (side, block) in SIZES {
        for order in ORDERS {
            let layout = layout(side, block, order);
            assert_eq!((layout.grid(), layout.side(), layout.block_len()), (grid(side), block, block * block));
            assert_eq!(layout.blocks(), 6 * (side / block) * (side / block));
            assert_eq!(layout.scans().each_ref().map(|scan| scan.order()), [order; 2]);
            let mut seen = vec![0; layout.grid().len()];
            for (path, b) in (0..2).flat_map(|path| (0..layout.blocks()).map(move |b| (path, b))) {
                layout.texels(path, b).iter().for_each(|&texel| seen[texel as usize] += 1);
                // The same texels as the definition's, each where its pixel is on the path.
                let reference = twin::Block::new(side, block, b);
                for (&texel, &pixel) in layout.texels(path, b).iter().zip(layout.scans()[path].pixels()) {
                    assert_eq!(texel as usize, reference.texel(pixel as usize), "{side}/{block} {order:?}, block {b}");
                }
                let on_face = |texel: u32| (texel as usize % (side * side) / side, texel as usize % side);
                if order != ScanOrder::RowMajor {
                    for pair in layout.texels(path, b).windows(2) {
                        let ((y, x), (v, u)) = (on_face(pair[0]), on_face(pair[1]));
                        assert_eq!(y.abs_diff(v) + x.abs_diff(u), 1, "{order:?} leaps");
                    }
                }
            }
            assert!(seen.iter().all(|&count| count == 2), "{side}/{block} {order:?}");
        }
    }
}

#[test]
fn the_second_path_goes_down_where_the_first_goes_along() {
    for order in ORDERS {
        let layout = layout(16, 16, order);
        let [along, down] = layout.scans();
        for (&pixel, &turned) in along.pixels().iter().zip(down.pixels()) {
            assert_eq!((pixel / 16, pixel % 16), (turned % 16, turned / 16), "{order:?}");
        }
    }
}

#[test]
fn directions_are_those_of_the_grid() {
    for (side, block) in SIZES {
        let layout = layout(side, block, ScanOrder::Hilbert);
        for b in 0..layout.blocks() {
            for (&texel, &pixel) in layout.texels(0, b).iter().zip(layout.scans()[0].pixels()) {
                let (x, y) = (f64::from(pixel % block as u32), f64::from(pixel / block as u32));
                let off = layout.direction(b, x, y) - layout.grid().direction(texel as usize).into_inner();
                // Two ways to round a place on the face.
                assert!(off.amax() <= 2.0 * f64::EPSILON, "{side}/{block}, block {b}, texel {texel}: {off}");
            }
            let (centre, radius) = twin::Block::new(side, block, b).cap();
            assert!((layout.centre(b) - centre).amax() <= 2.0 * f64::EPSILON);
            assert!((layout.radius(b) - radius).abs() <= 1e-15);
            // Nothing of a block is farther than its corners: its edges are arcs of great circles.
            let edge = |i: usize| i as f64 * 0.125 * block as f64 - 0.5;
            let farthest =
                (0..81).map(|i| centre.angle(&layout.direction(b, edge(i % 9), edge(i / 9)))).fold(0.0, f64::max);
            assert!((farthest - radius).abs() <= 1e-15, "{side}/{block}, block {b}: {farthest} {radius}");
        }
    }
    // 19.5° and 10.0° in blocks of 16² of 64² and 128² texels.
    let radius = |side| {
        let layout = layout(side, 16, ScanOrder::RowMajor);
        (0..layout.blocks()).map(|b| layout.radius(b)).fold(0.0, f64::max).to_degrees()
    };
    assert!((radius(64) - 19.5).abs() < 0.05 && (radius(128) - 10.0).abs() < 0.05);
}

#[test]
fn other_sides_are_refused() {
    for block in [0, 1, 4, 7, 12, 24, 64, 128, usize::MAX] {
        for side in [1, 24, 64, 128] {
            let got = BlockLayout::new(grid(side), block, ScanOrder::RowMajor);
            assert!(matches!(got, Err(Error::OutOfRange { what: "side of a block", .. })), "{block}: {got:?}");
        }
    }
    for (side, block) in [(1, 8), (4, 8), (12, 8), (24, 16), (40, 32), (48, 32), (100, 8)] {
        let got = BlockLayout::new(grid(side), block, ScanOrder::RowMajor);
        let expected = Error::OutOfRange {
            what: "side of the cube map",
            got: side as f64,
            allowed: "a multiple of the block's, at most 1024",
        };
        assert_eq!(got, Err(expected));
    }
}
