//! The reader of OpenEXR against the crate `exr`, and the writer against it too.

use exr::prelude::{Blocks, Compression, SampleType, Vec2};
use haarmonic::io::{encode_exr, read_exr};
use haarmonic::nalgebra::Vector3;

use super::exr_files::{COMPRESSIONS, TYPES, file, peer, value};

/// Sides around those of blocks (16, 32, 256 lines), squares of 4 and 8 pixels, and the levels of the wavelet.
const SIZES: [(usize, usize); 9] = [(1, 1), (1, 9), (5, 1), (3, 2), (8, 8), (17, 33), (31, 16), (9, 257), (64, 40)];

#[test]
fn every_compression_type_and_block_is_read_as_the_peer_reads_it() {
    let (mut cosine_samples, mut cosine_differences) = (0, 0);
    for compression in COMPRESSIONS {
        for types in TYPES {
            for size in SIZES {
                let tile = Blocks::Tiles(Vec2(13, 18));
                for (blocks, linear) in [(Blocks::ScanLines, false), (tile, false), (Blocks::ScanLines, true)] {
                    // The peer's writer refuses integers as cosine transforms, as ours does; as alpha they go.
                    let cosine = matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
                    if cosine && types.contains(&SampleType::U32) {
                        continue;
                    }
                    let bytes = file(&["R", "G", "B", "A", "Z"], types, compression, size, blocks, linear);
                    let what = format!("{compression}, {types:?}, {size:?}, {blocks:?}, linear: {linear}");
                    let loaded = read_exr(&bytes, "a.exr").unwrap_or_else(|e| panic!("{what}: {e}"));
                    assert_eq!(loaded.warnings, [], "{what}");
                    let expected = peer(&bytes).unwrap();
                    for (i, (got, expected)) in loaded.value.pixels().iter().zip(&expected).enumerate() {
                        let what = format!("{what}, pixel {i}: {got} {expected}");
                        if cosine {
                            // The peer's constants have 6 digits, and its order of sums is the processor's: the stored
                            // half x may be the neighbour, seldom. Linear is exp(2.2 (x − 1)) with x < 4: 2.2 · 2⁻⁹,
                            // and each is rounded to a half.
                            cosine_samples += 1;
                            cosine_differences += usize::from(got != expected);
                            assert!(
                                (got - expected).amax() <= (2.2 / 512.0 + 1.0 / 1024.0) * expected.amax(),
                                "{what}"
                            );
                        } else {
                            assert_eq!(got, expected, "{what}");
                        }
                        if compression.is_lossless_for(SampleType::F16) && compression.is_lossless_for(SampleType::F32)
                        {
                            let (x, y) = (i % size.0, i / size.0);
                            assert_eq!(*got, Vector3::from_fn(|c, _| value(c, x, y)), "{what}");
                        }
                    }
                }
            }
        }
    }
    assert!(cosine_differences * 50 <= cosine_samples, "{cosine_differences} of {cosine_samples} pixels differ");
}

/// Of a file of several resolutions the finest is read.
#[test]
fn the_finest_of_several_resolutions() {
    use exr::math::RoundingMode;
    use exr::prelude::*;
    let size = Vec2(20, 12);
    for rip in [false, true] {
        let levels = |c: usize| {
            let level = |shrink: (usize, usize)| {
                let (w, h) = ((size.0 >> shrink.0).max(1), (size.1 >> shrink.1).max(1));
                let of = |i: usize| if shrink == (0, 0) { value(c, i % w, i / w) } else { 9999.0 };
                FlatSamples::F32((0..w * h).map(of).collect())
            };
            if rip {
                let maps: Vec<_> = (0..4).flat_map(|y| (0..5).map(move |x| (x, y))).map(level).collect();
                Levels::Rip {
                    rounding_mode: RoundingMode::Down,
                    level_data: RipMaps { map_data: maps, level_count: Vec2(5, 4) },
                }
            } else {
                Levels::Mip { rounding_mode: RoundingMode::Down, level_data: (0..5).map(|l| level((l, l))).collect() }
            }
        };
        let list = ["R", "G", "B"].iter().enumerate().map(|(c, name)| AnyChannel::new(*name, levels(c)));
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::Tiles(Vec2(8, 8)),
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new(size, LayerAttributes::named("l"), encoding, AnyChannels::sort(list.collect()));
        let mut out = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut out).unwrap();
        let image = read_exr(&out.into_inner(), "a.exr").unwrap().value;
        assert_eq!((image.width(), image.height()), (20, 12));
        for y in 0..12 {
            for x in 0..20 {
                assert_eq!(image.pixel(x, y), Vector3::from_fn(|c, _| value(c, x, y)), "({x}, {y}), rip: {rip}");
            }
        }
    }
}

/// Lines from the bottom up, which is how some writers order the blocks.
#[test]
fn decreasing_lines() {
    use exr::prelude::*;
    for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))] {
        let list = ["R", "G", "B"].iter().enumerate().map(|(c, name)| {
            AnyChannel::new(*name, FlatSamples::F32((0..20 * 40).map(|i| value(c, i % 20, i / 20)).collect()))
        });
        let encoding = Encoding { compression: Compression::ZIP16, blocks, line_order: LineOrder::Decreasing };
        let layer = Layer::new(Vec2(20, 40), LayerAttributes::named("l"), encoding, AnyChannels::sort(list.collect()));
        let mut out = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut out).unwrap();
        let image = read_exr(&out.into_inner(), "a.exr").unwrap().value;
        for (i, pixel) in image.pixels().iter().enumerate() {
            assert_eq!(*pixel, Vector3::from_fn(|c, _| value(c, i % 20, i / 20)), "pixel {i}");
        }
    }
}

#[test]
fn the_peer_reads_what_is_written() {
    for (w, h) in SIZES {
        let pixels = (0..w * h).map(|i| Vector3::from_fn(|c, _| value(c, i % w, i / w) * 1.1)).collect();
        let image = haarmonic::io::Image::new(w, h, pixels).unwrap();
        assert_eq!(peer(&encode_exr(&image).unwrap()).unwrap(), image.pixels(), "{w} × {h}");
    }
}
