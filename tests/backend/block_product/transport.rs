//! Visibility in blocks: coded, decoded, the same on every way in.

use haarmonic::Error;
use haarmonic::backend::block_product::Transport;
use haarmonic::compress::ScanOrder;
use haarmonic::scene::{BinaryVisibility, Procedural};
use haarmonic::strategies::{block_layout, run_map};
use proptest::prelude::*;

use super::support::{ORDERS, above, layout, patchwork, visibility};
use crate::support::{Watch, baker, cases, grid, noise, soup};

fn decoded(transport: &Transport, vertex: usize) -> Vec<f32> {
    let mut out = vec![f32::NAN; transport.layout().grid().len()];
    transport.decode(vertex, &mut out);
    out
}

#[track_caller]
fn holds(transport: &Transport, visibility: &BinaryVisibility, what: &str) {
    assert_eq!((transport.vertices(), transport.top()), (visibility.vertices(), 1));
    for v in 0..visibility.vertices() {
        for (texel, got) in decoded(transport, v).into_iter().enumerate() {
            assert_eq!(got, f32::from(u8::from(visibility.sees(v, texel))), "{what}: vertex {v}, texel {texel}");
        }
    }
}

const SIZES: [(usize, usize); 8] = [(8, 8), (16, 16), (32, 32), (48, 8), (48, 16), (64, 8), (64, 32), (128, 16)];

#[test]
fn binary_maps_come_back_bit_for_bit() {
    for (side, block) in SIZES {
        let texels = 6 * side * side;
        let cut = patchwork(side, block, side);
        // Noise, checkerboard, nothing, everything, first texel, last texel, all but one, blocks of all kinds.
        let maps = visibility(side, 9, |v, texel| match v {
            0 => noise(texel) < 0.5,
            1 => (texel % side + texel / side) % 2 == 0,
            2 => false,
            3 => true,
            4 => texel == 0,
            5 => texel == texels - 1,
            6 => texel != texels / 2,
            _ => cut(v, texel),
        });
        for order in ORDERS {
            let transport = Transport::from_clipped(&maps, &layout(side, block, order)).unwrap();
            holds(&transport, &maps, &format!("{side}/{block} {order:?}"));
        }
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn any_bits_come_back((layout, bits) in block_layout(48).prop_flat_map(|layout| {
        let texels = layout.grid().len();
        (Just(layout), run_map(texels))
    })) {
        let maps = visibility(layout.grid().side(), 1, |_, texel| bits[texel]);
        let transport = Transport::from_clipped(&maps, &layout).unwrap();
        let expected: Vec<f32> = bits.iter().map(|&bit| f32::from(u8::from(bit))).collect();
        prop_assert_eq!(decoded(&transport, 0), expected);
    }
}

/// How often numbers change along a path that starts with 0.
fn changes(along: impl Iterator<Item = f32>) -> usize {
    let (mut count, mut before) = (0, 0.0);
    for value in along {
        count += usize::from(value != before);
        before = value;
    }
    count
}

#[test]
fn each_block_takes_the_path_with_fewer_changes() {
    let mesh = soup(20);
    let mut taken = [0; 2];
    for (side, block) in [(16, 8), (32, 16), (64, 32)] {
        let baker = baker(&mesh, side);
        for order in ORDERS {
            let layout = layout(side, block, order);
            let binary = Transport::bake(&baker, &layout, &()).unwrap();
            let gray = Transport::bake_gray(&mesh, &baker, &layout, (2, 3), &()).unwrap();
            for transport in [binary, gray] {
                let mut all = 0;
                for v in 0..60 {
                    let map = decoded(&transport, v);
                    for b in 0..layout.blocks() {
                        let along = |path: usize| changes(layout.texels(path, b).iter().map(|&t| map[t as usize]));
                        let (counts, path) = ([along(0), along(1)], transport.path(v, b));
                        assert_eq!(
                            path,
                            usize::from(counts[1] < counts[0]),
                            "{order:?}, vertex {v}, block {b}: {counts:?}"
                        );
                        taken[path] += usize::from(counts[0] != counts[1]);
                        all += counts[path];
                    }
                }
                assert_eq!(transport.stats().coded.changes, all);
            }
        }
    }
    assert!(taken[0] > 500 && taken[1] > 500, "{taken:?}");
}

/// The figures of docs/block_product.md: changes a partly hidden block of the table scene along one path, and along the
/// better of two.
#[test]
fn two_paths_have_fewer_changes_than_any_one() {
    let mesh = Procedural::Table.build(1000).unwrap().mesh;
    let baker = baker(&mesh, 64);
    let mut got = Vec::new();
    for order in ORDERS {
        let layout = layout(64, 16, order);
        let transport = Transport::bake(&baker, &layout, &()).unwrap();
        let mut first = 0;
        for v in 0..transport.vertices() {
            let map = decoded(&transport, v);
            let along = |b: usize| changes(layout.texels(0, b).iter().map(|&t| map[t as usize]));
            first += (0..layout.blocks()).map(along).sum::<usize>();
        }
        let coded = transport.stats().coded;
        let mixed = (coded.maps - coded.all_zero - coded.all_one) as f64;
        got.push([(first - coded.all_one) as f64 / mixed, coded.mean_changes_of_mixed()]);
    }
    // Rows 18.8, with columns 10.2; serpentine 14.6 and 8.0; Hilbert 15.0 and 13.9.
    let [rows, serpentine, hilbert] = [got[0], got[1], got[2]];
    assert!(rows[1] < 0.55 * rows[0] && serpentine[1] < 0.55 * serpentine[0] && hilbert[1] < hilbert[0], "{got:?}");
    assert!(serpentine[1] < 0.6 * hilbert[0] && serpentine[1] < 0.85 * rows[1], "{got:?}");
}

#[test]
fn baked_is_what_a_baked_map_becomes() {
    let mesh = soup(60);
    for (side, block) in [(16, 8), (32, 16), (64, 32), (48, 8)] {
        let baker = baker(&mesh, side);
        let maps = baker.bake(&()).unwrap();
        for order in ORDERS {
            let layout = layout(side, block, order);
            let transport = Transport::bake(&baker, &layout, &()).unwrap();
            assert_eq!(transport, Transport::from_clipped(&maps, &layout).unwrap());
            assert_eq!(transport, Transport::from_binary(&mesh, &maps, &layout).unwrap());
            holds(&transport, &maps, &format!("{side}/{block}"));
        }
    }
}

#[test]
fn gray_maps_are_rounded_to_levels_and_hidden_below_the_horizon() {
    let mesh = soup(20);
    let mut in_between = 0;
    for (side, block, samples, bits) in
        [(16, 8, 1, 2), (32, 16, 2, 2), (32, 8, 3, 4), (32, 32, 4, 8), (48, 16, 4, 6), (16, 16, 15, 8), (8, 8, 15, 3)]
    {
        let baker = baker(&mesh, side);
        let counts = baker.bake_fractional(samples, &()).unwrap();
        let top = (1_u32 << bits) - 1;
        for order in ORDERS {
            let layout = layout(side, block, order);
            let transport = Transport::from_fractional(&mesh, &counts, &layout, bits).unwrap();
            let what = format!("{side}/{block}, {samples}² samples, {bits} bits, {order:?}");
            assert_eq!(
                transport,
                Transport::bake_gray(&mesh, &baker, &layout, (samples, bits), &()).unwrap(),
                "{what}"
            );
            assert_eq!((transport.vertices(), u32::from(transport.top())), (60, top));
            for v in 0..60 {
                let normal = mesh.normals()[v].cast::<f64>();
                for (texel, got) in decoded(&transport, v).into_iter().enumerate() {
                    let share = f64::from(counts.vertex(v)[texel]) / (samples * samples) as f64;
                    let is_above = normal.dot(&grid(side).direction(texel)) > 0.0;
                    let level = if is_above { (share * f64::from(top)).round() } else { 0.0 };
                    assert_eq!(got, (level / f64::from(top)) as f32, "{what}: vertex {v}, texel {texel}");
                    in_between += usize::from(got > 0.0 && got < 1.0);
                }
            }
        }
    }
    assert!(in_between > 10_000, "only {in_between} texels between hidden and free");
}

/// Whatever is visible below a horizon is cut off, so that maps of any origin give the light of clipped ones.
#[test]
fn maps_of_others_end_at_the_horizon() {
    let mesh = soup(20);
    for (side, block) in [(16, 8), (32, 32), (48, 16)] {
        let layout = layout(side, block, ScanOrder::Serpentine);
        let cut = patchwork(side, block, 9);
        for full in [true, false] {
            let sees = |v: usize, texel: usize| full || cut(v, texel);
            let whole = visibility(side, mesh.positions().len(), sees);
            let clipped = Transport::from_clipped(&above(&mesh, side, sees), &layout).unwrap();
            assert_ne!(clipped, Transport::from_clipped(&whole, &layout).unwrap());
            assert_eq!(clipped, Transport::from_binary(&mesh, &whole, &layout).unwrap());
        }
    }
    let (maps, few) = (visibility(16, 4, |_, _| true), soup(1));
    let got = Transport::from_binary(&few, &maps, &layout(16, 8, ScanOrder::RowMajor));
    assert!(matches!(got, Err(Error::Length { expected: 3, got: 4, .. })));
}

#[test]
fn uniform_maps_cost_nothing_or_one_change() {
    for (side, block) in SIZES {
        let layout = layout(side, block, ScanOrder::Serpentine);
        for full in [false, true] {
            let maps = visibility(side, 3, |_, _| full);
            let stats = Transport::from_clipped(&maps, &layout).unwrap().stats();
            let blocks = 3 * layout.blocks();
            assert_eq!((stats.vertices, stats.blocks, stats.coded.maps), (3, layout.blocks(), blocks));
            let (zero, one) = if full { (0, blocks) } else { (blocks, 0) };
            assert_eq!((stats.coded.all_zero, stats.coded.all_one, stats.coded.changes), (zero, one, one));
        }
    }
}

/// A flat square in the air: from it everything above is free.
#[test]
fn gray_maps_that_are_free_have_one_change() {
    use haarmonic::nalgebra::Vector3;
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, z]| Vector3::new(x, 0.0, z));
    let mesh = haarmonic::scene::Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let layout = layout(32, 16, ScanOrder::Hilbert);
    let transport = Transport::bake_gray(&mesh, &baker(&mesh, 32), &layout, (4, 4), &()).unwrap();
    let coded = transport.stats().coded;
    // +Y and the upper halves of four sides; the horizon runs between blocks.
    assert_eq!((coded.maps, coded.all_one, coded.all_zero, coded.changes), (96, 48, 48, 48));
}

#[test]
fn progress_reaches_the_end_and_cancellation_stops() {
    let mesh = soup(300);
    let (baker, layout) = (baker(&mesh, 8), layout(8, 8, ScanOrder::RowMajor));
    let bake = |gray: bool, watch: &Watch| {
        if gray {
            Transport::bake_gray(&mesh, &baker, &layout, (2, 4), watch)
        } else {
            Transport::bake(&baker, &layout, watch)
        }
    };
    for gray in [false, true] {
        let watch = Watch::new(900);
        bake(gray, &watch).unwrap();
        assert_eq!(watch.largest(), 900);
        for stop_after in [0, 100] {
            let watch = Watch::stopping_after(stop_after, 900);
            assert_eq!(bake(gray, &watch), Err(Error::Cancelled));
            assert!(watch.largest() < 900);
        }
    }
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_bakes_the_same() {
    let mesh = soup(300);
    let (baker, layout) = (baker(&mesh, 16), layout(16, 8, ScanOrder::Hilbert));
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let gray = Transport::bake_gray(&mesh, &baker, &layout, (2, 3), &()).unwrap();
            (Transport::bake(&baker, &layout, &()).unwrap(), gray)
        })
    };
    let one = of(1);
    assert!(of(2) == one && of(5) == one);
}

#[test]
fn what_does_not_fit_is_refused() {
    let (mesh, few) = (soup(4), soup(3));
    let (fine, layout) = (baker(&mesh, 16), layout(8, 8, ScanOrder::RowMajor));
    let out_of_range = |got: haarmonic::Result<Transport>, name: &str| match got {
        Err(Error::OutOfRange { what, .. }) => assert!(what.contains(name), "{what} is not about {name}"),
        other => panic!("{name}: {other:?}"),
    };
    out_of_range(Transport::bake(&fine, &layout, &()), "baker's cube map");
    out_of_range(Transport::bake_gray(&mesh, &fine, &layout, (2, 4), &()), "baker's cube map");
    let maps = above(&mesh, 16, |_, _| true);
    out_of_range(Transport::from_clipped(&maps, &layout), "visibility's cube map");
    let counts = fine.bake_fractional(2, &()).unwrap();
    out_of_range(Transport::from_fractional(&mesh, &counts, &layout, 4), "visibility's cube map");

    let fits = baker(&mesh, 8);
    for samples in [0, 16, usize::MAX] {
        out_of_range(Transport::bake_gray(&mesh, &fits, &layout, (samples, 4), &()), "visibility samples");
    }
    let counts = fits.bake_fractional(2, &()).unwrap();
    for bits in [0, 1, 9, 32, u32::MAX] {
        out_of_range(Transport::bake_gray(&mesh, &fits, &layout, (2, bits), &()), "bits");
        out_of_range(Transport::from_fractional(&mesh, &counts, &layout, bits), "bits");
    }
    let expected = Err(Error::Length { what: "visibility maps", expected: 9, got: 12 });
    assert_eq!(Transport::bake_gray(&few, &fits, &layout, (2, 4), &()), expected);
    assert_eq!(Transport::from_fractional(&few, &counts, &layout, 4), expected);
}
