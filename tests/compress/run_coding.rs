//! Differential coding against golden values and the naive twins; damaged bytes.

use crate::support::{HAAR_AFFINE, cases, golden, numbers};
use haarmonic::compress::{
    CodedBinaryMap, CodedBinaryMaps, CodedGrayMaps, MapIndex, MapState, Scan, ScanOrder, decode_gaps, encode_gaps,
    suffix_sums,
};
use haarmonic::reference::compress as twin;
use haarmonic::{Error, strategies};
use proptest::prelude::*;

fn unhex(value: &serde_json::Value) -> Vec<u8> {
    let text = value.as_str().unwrap();
    (0..text.len() / 2).map(|i| u8::from_str_radix(&text[2 * i..][..2], 16).unwrap()).collect()
}

fn to_bits(map: &[bool]) -> Vec<u64> {
    map.chunks(64).map(|word| word.iter().rev().fold(0, |bits, &v| bits << 1 | u64::from(v))).collect()
}

fn to_numbers(map: &[bool]) -> Vec<f64> {
    map.iter().map(|&v| f64::from(u8::from(v))).collect()
}

fn sums_of(signal: &[f64]) -> Vec<f64> {
    let mut sums = vec![f64::NAN; signal.len()];
    suffix_sums(signal.len(), signal, &mut sums);
    sums
}

#[test]
fn golden_values_are_reproduced() {
    let file = golden(HAAR_AFFINE, "visibility_differential");
    let (mut maps, mut places) = (CodedBinaryMaps::<u8>::new(256).unwrap(), Vec::new());
    for case in file["binary"].as_array().unwrap() {
        let map: Vec<bool> = case["V_bits"].as_str().unwrap().bytes().map(|b| b == b'1').collect();
        let (light, sums) = (numbers(&case["L"]), numbers(&case["L_int"]));
        let indices: Vec<u8> = numbers(&case["indices"]).iter().map(|&x| x as u8).collect();
        maps.push_bits(&to_bits(&map));
        maps.push_bools(&map);
        for index in [maps.len() - 2, maps.len() - 1] {
            assert_eq!(maps.map(index).changes(), indices);
            // Whole numbers: every sum is exact.
            assert_eq!(maps.map(index).dot(&sums), case["dot"].as_f64().unwrap());
            let mut decoded = vec![f64::NAN; 256];
            maps.map(index).decode(&mut decoded);
            assert_eq!(decoded, to_numbers(&map));
        }
        assert_eq!((sums_of(&light), twin::suffix_sums(&light)), (sums.clone(), sums));
        let (mut bytes, mut back) = (Vec::new(), Vec::new());
        encode_gaps(&indices, &mut bytes);
        assert_eq!(bytes, unhex(&case["varint_gap_hex"]));
        decode_gaps::<u8>(&bytes, 256, &mut back).unwrap();
        assert_eq!(back, indices);
        places.extend(indices.iter().flat_map(|&i| twin::varint(i.into())));
        assert!(places.ends_with(&unhex(&case["varint_abs_hex"])));
    }
    for case in file["gray"].as_array().unwrap() {
        let levels: Vec<u8> = numbers(&case["V_times_64"]).iter().map(|&x| x as u8).collect();
        let mut maps = CodedGrayMaps::<u8>::new(256, 64).unwrap();
        maps.push_levels(&levels);
        maps.push_values(&levels.iter().map(|&x| f64::from(x) / 64.0).collect::<Vec<_>>());
        for map in maps.iter() {
            let pairs: Vec<Vec<f64>> = map.differences().map(|(at, d)| vec![at as f64, d.into()]).collect();
            assert_eq!(pairs, case["diff_pairs"].as_array().unwrap().iter().map(numbers).collect::<Vec<_>>());
            assert_eq!(64.0 * map.dot(&sums_of(&numbers(&case["L"]))), case["dot_times_64"].as_f64().unwrap());
            let mut decoded = vec![0xff; 256];
            map.decode_levels(&mut decoded);
            assert_eq!(decoded, levels);
        }
    }
}

/// A binary map through every entry and every exit.
fn round_trip<I: MapIndex>(map: &[bool]) {
    let (len, values) = (map.len(), to_numbers(map));
    let differences = twin::differences(&values);
    let mut maps = CodedBinaryMaps::<I>::new(len).unwrap();
    maps.push_bools(map);
    // Bits beyond the map do not matter.
    let mut bits = to_bits(map);
    if len % 64 != 0 {
        *bits.last_mut().unwrap() |= !0 << (len % 64);
    }
    maps.push_bits(&bits);
    let copy = maps.map(0).changes().to_vec();
    maps.push(CodedBinaryMap::new(&copy, len).unwrap());
    let (first, other) = (maps.clone(), maps.clone());
    maps.append(&other);
    assert_eq!(maps.len(), 6);
    for coded in maps.iter() {
        assert_eq!(coded, first.map(0));
        assert_eq!(
            coded.changes().iter().map(|c| c.place()).collect::<Vec<_>>(),
            Vec::from_iter(differences.iter().map(|d| d.0))
        );
        assert_eq!(coded.count_ones(), map.iter().filter(|&&v| v).count());
        assert_eq!(coded.state() == MapState::AllZero, map.iter().all(|v| !v));
        assert_eq!(coded.state() == MapState::AllOne, map.iter().all(|&v| v));
        assert_eq!(coded.runs().len(), coded.runs().count());
        let (mut decoded, mut words) = (vec![f32::NAN; len], vec![!0; len.div_ceil(64)]);
        coded.decode(&mut decoded);
        assert!(decoded.iter().zip(&values).all(|(d, v)| f64::from(*d) == *v));
        assert_eq!(twin::integrate(len, &differences), values);
        coded.decode_bits(&mut words);
        assert_eq!(words, to_bits(map));
    }
    let bytes = maps.to_bytes();
    assert_eq!(CodedBinaryMaps::<I>::from_bytes(&bytes).as_ref(), Ok(&maps));
    let header = 6 + twin::varint(len as u64).len() + twin::varint(6).len();
    let mut before = 0;
    let gaps = differences.iter().map(|d| twin::varint((d.0 - std::mem::replace(&mut before, d.0)) as u64).len());
    let each = twin::varint(differences.len() as u64).len() + gaps.sum::<usize>();
    assert_eq!(bytes.len(), header + 6 * each);
    let stats = maps.stats();
    assert_eq!((stats.maps, stats.changes, stats.most_changes), (6, 6 * differences.len(), differences.len()));
    assert_eq!(stats.bytes_in_file, bytes.len());
    assert_eq!(stats.bytes_in_memory, 6 * (4 + differences.len() * size_of::<I>()));
    let constant = map.iter().all(|&v| v == map[0]);
    assert_eq!(stats.all_zero + stats.all_one, if constant { 6 } else { 0 });
    assert_eq!(stats.mean_changes_of_mixed(), if constant { 0.0 } else { differences.len() as f64 });
}

/// A map of 1 to 600 pixels, the ends of words among them.
fn any_map() -> impl Strategy<Value = Vec<bool>> {
    let len = prop_oneof![1usize..600, prop::sample::select(vec![1, 63, 64, 65, 128, 255, 256, 257])];
    len.prop_flat_map(strategies::run_map)
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn maps_survive_every_form(map in any_map(), visible in strategies::visibility_map(16, 16)) {
        round_trip::<u16>(&map);
        round_trip::<u32>(&map);
        if map.len() <= 256 {
            round_trip::<u8>(&map);
        }
        round_trip::<u8>(&visible);
    }

    /// A slice is what the maps of its range alone give.
    #[test]
    fn slices_are_the_maps_of_their_range(levels in prop::collection::vec(strategies::level_map(70, 3), 0..6)) {
        let of = |range: &[Vec<u8>]| {
            let (mut binary, mut gray) = (CodedBinaryMaps::<u8>::new(70).unwrap(), CodedGrayMaps::<u8>::new(70, 3).unwrap());
            for levels in range {
                binary.push_bools(&levels.iter().map(|&level| level > 0).collect::<Vec<_>>());
                gray.push_levels(levels);
            }
            (binary, gray)
        };
        let (binary, gray) = of(&levels);
        for start in 0..=levels.len() {
            for end in start..=levels.len() {
                let got = (binary.slice(start..end), gray.slice(start..end));
                prop_assert_eq!(got, of(&levels[start..end]), "{}..{}", start, end);
            }
        }
    }

    /// Dot products are the sums over the pixels, one channel, three, and weighted.
    #[test]
    fn dot_products_match_pixel_sums(
        (map, light, weights) in any_map().prop_flat_map(|map| {
            let len = map.len();
            let unit = || prop::collection::vec(-1.0..1.0_f64, len);
            (Just(map), unit(), unit())
        })
    ) {
        let len = map.len();
        let mut maps = CodedBinaryMaps::<u16>::new(len).unwrap();
        maps.push_bools(&map);
        let (values, coded) = (to_numbers(&map), maps.map(0));
        let want: f64 = values.iter().zip(&light).map(|(v, l)| v * l).sum();
        let changes = coded.changes().len() as f64;
        // Each of the sums looked up is wrong by an ε or so of the block's total, 600 at most.
        let tolerance = (changes + 8.0) * f64::EPSILON * len as f64;
        prop_assert!((coded.dot(&sums_of(&light)) - want).abs() <= tolerance);

        let rgb: Vec<[f64; 3]> = light.iter().map(|&l| [l, 2.0 * l, -l]).collect();
        let mut sums = vec![[f64::NAN; 3]; len];
        suffix_sums(len, &rgb, &mut sums);
        let got = coded.dot(&sums);
        prop_assert!((0..3).all(|i| (got[i] - [1.0, 2.0, -1.0][i] * want).abs() <= 2.0 * tolerance), "{:?} {}", got, want);

        // f32 sums of f32 light: rounded once, at the end.
        let narrow: Vec<f32> = light.iter().map(|&l| l as f32).collect();
        let want: f64 = values.iter().zip(&narrow).map(|(v, l)| v * f64::from(*l)).sum();
        let mut sums = vec![f32::NAN; len];
        suffix_sums(len, &narrow, &mut sums);
        let largest = sums.iter().fold(0.0f32, |m, s| m.max(s.abs()));
        let tolerance = 0.5 * (changes + 1.0) * f64::from(f32::EPSILON * largest) + tolerance;
        prop_assert!((f64::from(coded.dot(&sums)) - want).abs() <= tolerance);

        let want: f64 = (0..len).map(|i| values[i] * light[i] * weights[i]).sum();
        let got = coded.masked_dot(&light, &weights);
        prop_assert!((got - want).abs() <= 4.0 * f64::EPSILON * len as f64);
        let got = coded.masked_dot(&rgb, &weights);
        prop_assert!((got[1] - 2.0 * want).abs() <= 8.0 * f64::EPSILON * len as f64);
    }

    #[test]
    fn gray_maps_survive_every_form_and_their_dot_products(
        (top, levels, light) in (1u8..=255, 1usize..300).prop_flat_map(|(top, len)| {
            (Just(top), strategies::level_map(len, top), prop::collection::vec(-1.0..1.0_f64, len))
        })
    ) {
        let len = levels.len();
        let values: Vec<f64> = levels.iter().map(|&l| f64::from(l) / f64::from(top)).collect();
        let mut maps = CodedGrayMaps::<u16>::new(len, top).unwrap();
        maps.push_levels(&levels);
        maps.push_values(&values);
        let other = maps.clone();
        maps.append(&other);
        let whole: Vec<f64> = levels.iter().map(|&l| l.into()).collect();
        let differences = twin::differences(&whole);
        let want: f64 = values.iter().zip(&light).map(|(v, l)| v * l).sum();
        for coded in maps.iter() {
            let got: Vec<(usize, f64)> = coded.differences().map(|(at, d)| (at, d.into())).collect();
            prop_assert_eq!(&got, &differences);
            prop_assert_eq!(twin::integrate(len, &got), whole.clone());
            let mut decoded = vec![f64::NAN; len];
            coded.decode(&mut decoded);
            prop_assert_eq!(&decoded, &values);
            let tolerance = (4 * got.len() + 8) as f64 * f64::EPSILON * len as f64;
            prop_assert!((coded.dot(&sums_of(&light)) - want).abs() <= tolerance);
            prop_assert!((coded.masked_dot(&light, &vec![1.0; len]) - want).abs() <= tolerance);
        }
        let bytes = maps.to_bytes();
        prop_assert_eq!(&CodedGrayMaps::<u16>::from_bytes(&bytes).unwrap(), &maps);
        let stats = maps.stats();
        prop_assert_eq!((stats.maps, stats.changes, stats.bytes_in_file), (4, 4 * differences.len(), bytes.len()));
        prop_assert_eq!(stats.bytes_in_memory, 4 * (4 + 3 * differences.len()));
        prop_assert_eq!(stats.all_one == 4, levels.iter().all(|&l| l == top));
    }

    /// Half a step of rounding at most, out of range clamped, NaN 0; and more bits are closer.
    #[test]
    fn quantisation_is_to_the_nearest_level(values in prop::collection::vec(-0.5..1.5_f64, 1..80), bits in 1u32..9) {
        let mut maps = CodedGrayMaps::<u8>::with_bits(values.len(), bits).unwrap();
        maps.push_values(&values);
        let top = f64::from(maps.top());
        prop_assert_eq!(top, f64::from(bits).exp2() - 1.0);
        let mut decoded = vec![f64::NAN; values.len()];
        maps.map(0).decode(&mut decoded);
        for (v, d) in values.iter().zip(&decoded) {
            prop_assert!((v.clamp(0.0, 1.0) - d).abs() <= 0.5 / top + f64::EPSILON);
        }
    }

    /// Any bytes at all: an answer or an error; and what is read is written the same.
    #[test]
    fn random_bytes_never_panic(
        mut bytes in prop::collection::vec(prop_oneof![any::<u8>(), 0u8..4, Just(0x80), Just(0xff)], 0..64),
        len in 1usize..=256,
    ) {
        let mut changes = vec![7u8];
        match decode_gaps::<u8>(&bytes, len, &mut changes) {
            Ok(()) => {
                prop_assert!(CodedBinaryMap::new(&changes[1..], len).is_ok());
                let mut again = Vec::new();
                encode_gaps(&changes[1..], &mut again);
                prop_assert_eq!(&again, &bytes);
            }
            Err(error) => {
                let damaged = matches!(error, Error::Damaged { offset, .. } if offset <= bytes.len());
                prop_assert!(damaged && changes == [7]);
            }
        }
        for kind in 0..2 {
            bytes.splice(0..0, [b'h', b'r', b'u', b'n', 1, kind]);
            if let Ok(maps) = CodedBinaryMaps::<u8>::from_bytes(&bytes) {
                prop_assert_eq!(maps.to_bytes(), &bytes[..]);
            }
            if let Ok(maps) = CodedGrayMaps::<u32>::from_bytes(&bytes) {
                prop_assert_eq!(maps.to_bytes(), &bytes[..]);
            }
            bytes.drain(..6);
        }
    }

    /// A file cut anywhere is refused, one with a byte more, too; a flipped bit is refused or makes other maps.
    #[test]
    fn damaged_files_are_refused(
        maps in prop::collection::vec(strategies::run_map(100), 1..5),
        levels in prop::collection::vec(strategies::level_map(100, 9), 1..5),
        bit in any::<prop::sample::Index>(),
    ) {
        let mut binary = CodedBinaryMaps::<u16>::new(100).unwrap();
        maps.iter().for_each(|map| binary.push_bools(map));
        let mut gray = CodedGrayMaps::<u16>::new(100, 9).unwrap();
        levels.iter().for_each(|map| gray.push_levels(map));
        for (mut bytes, is_binary) in [(binary.to_bytes(), true), (gray.to_bytes(), false)] {
            let read = |bytes: &[u8]| if is_binary {
                CodedBinaryMaps::<u16>::from_bytes(bytes).map(|maps| maps.to_bytes())
            } else {
                CodedGrayMaps::<u16>::from_bytes(bytes).map(|maps| maps.to_bytes())
            };
            for cut in 0..bytes.len() {
                prop_assert!(read(&bytes[..cut]).is_err(), "cut at {}", cut);
            }
            let bit = bit.index(8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
            // There is one way to write maps: what is read is what these bytes say.
            if let Ok(again) = read(&bytes) {
                prop_assert_eq!(&again, &bytes);
            }
            prop_assert!(bit >= 48 || read(&bytes).is_err(), "a flip in the header");
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes.push(0);
            prop_assert!(read(&bytes).is_err());
        }
    }

    #[test]
    fn scans_are_permutations(
        (order, width, height) in prop_oneof![
            (prop::sample::select(vec![ScanOrder::RowMajor, ScanOrder::Serpentine]), 1usize..20, 1usize..20),
            (0u32..6).prop_map(|levels| (ScanOrder::Hilbert, 1 << levels, 1 << levels)),
        ],
        turned in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let scan = if turned { Scan::turned(order, width, height) } else { Scan::new(order, width, height) }.unwrap();
        if turned {
            // Columns for rows: the path through the image on its side.
            let along = Scan::new(order, height, width).unwrap();
            let sideways = |p: u32| (p as usize % height, p as usize / height);
            let upright = |p: u32| (p as usize / width, p as usize % width);
            prop_assert!(along.pixels().iter().map(|&p| sideways(p)).eq(scan.pixels().iter().map(|&p| upright(p))));
        }
        let mut seen = vec![false; width * height];
        scan.pixels().iter().for_each(|&p| seen[p as usize] = true);
        prop_assert!(seen.iter().all(|&s| s) && scan.pixels().len() == seen.len());
        // All but rows are paths of neighbours.
        let place = |p: u32| ((p as usize % width) as i64, (p as usize / width) as i64);
        for pair in scan.pixels().windows(2) {
            let ((x, y), (u, v)) = (place(pair[0]), place(pair[1]));
            prop_assert!(order == ScanOrder::RowMajor || (x - u).abs() + (y - v).abs() == 1);
        }
        let image: Vec<u64> = (0..seen.len() as u64).map(|i| (i ^ seed).wrapping_mul(0x9e37_79b9_7f4a_7c15)).collect();
        let [mut path, mut back] = [vec![0; image.len()], vec![0; image.len()]];
        scan.apply(&image, &mut path);
        scan.undo(&path, &mut back);
        prop_assert_eq!(&back, &image);
        prop_assert!(path.iter().zip(scan.pixels()).all(|(&value, &p)| value == image[p as usize]));
        let bools = |values: &[u64]| values.iter().map(|v| v >> 63 == 1).collect::<Vec<_>>();
        let mut bits = vec![0; image.len().div_ceil(64)];
        scan.apply_bits(&to_bits(&bools(&image)), &mut bits);
        prop_assert_eq!(bits, to_bits(&bools(&path)));
    }
}

#[test]
fn hilberts_curve_is_its_definition() {
    for levels in 0..6 {
        let side = 1usize << levels;
        let scan = Scan::new(ScanOrder::Hilbert, side, side).unwrap();
        let want: Vec<u32> = twin::hilbert(levels).iter().map(|&(x, y)| (y * side + x) as u32).collect();
        assert_eq!(scan.pixels(), want);
    }
}

#[test]
fn constant_maps_are_as_the_paper_says() {
    let mut maps = CodedBinaryMaps::<u8>::new(256).unwrap();
    maps.push_bits(&[0; 4]);
    maps.push_bits(&[!0; 4]);
    maps.push_bools(&(0..256).map(|i| i % 2 == 0).collect::<Vec<_>>());
    maps.push_bits(&[0, 0, 0, 1 << 63]);
    assert!(maps.map(0).changes().is_empty() && maps.map(0).state() == MapState::AllZero);
    assert!(maps.map(1).changes() == [0] && maps.map(1).state() == MapState::AllOne);
    // 256 changes: the number needs 9 bits.
    assert!(maps.map(2).changes().len() == 256 && maps.map(2).state() == MapState::Mixed);
    assert_eq!(maps.map(3).changes(), [255]);
    let sums = [2.0f32; 256];
    assert_eq!([0, 1, 2, 3].map(|i| maps.map(i).dot(&sums)), [0.0, 2.0, 0.0, 2.0]);
    let stats = maps.stats();
    assert_eq!((stats.all_zero, stats.all_one, stats.changes, stats.changes_of_mixed), (1, 1, 258, 257));
    assert_eq!(stats.mean_changes_of_mixed(), 128.5);
    assert_eq!(maps.stats().mean_bytes_in_file(), stats.bytes_in_file as f64 / 4.0);
    assert_eq!(CodedBinaryMaps::<u8>::new(3).unwrap().stats().mean_bytes_in_file(), 0.0);
}

/// The smallest number that needs each length of varint, and the ways not to write it.
#[test]
fn gaps_have_one_form() {
    for (change, bytes) in [(0u32, 1), (127, 1), (128, 2), (16383, 2), (16384, 3), (1 << 21, 4), (1 << 28, 5)] {
        let (mut written, mut read) = (Vec::new(), Vec::new());
        encode_gaps(&[change], &mut written);
        assert_eq!((written.len(), &written), (bytes, &twin::varint(change.into())));
        decode_gaps::<u32>(&written, change as usize + 1, &mut read).unwrap();
        assert_eq!(read, [change]);
        assert!(decode_gaps::<u32>(&written, change as usize, &mut read).is_err());
        // Overlong: the same number with another group of zeros.
        *written.last_mut().unwrap() |= 0x80;
        assert!(decode_gaps::<u32>(&written, 1 << 30, &mut read).is_err(), "cut short");
        written.push(0);
        assert!(decode_gaps::<u32>(&written, 1 << 30, &mut read).is_err(), "overlong");
    }
    let reason = |bytes: &[u8]| match decode_gaps::<u8>(bytes, 256, &mut Vec::new()) {
        Err(Error::Damaged { offset, reason, .. }) => (offset, reason),
        other => panic!("{other:?}"),
    };
    assert_eq!(reason(&[3, 0]), (2, "a gap of 0"));
    assert_eq!(reason(&[0, 0]), (2, "a gap of 0"));
    assert_eq!(reason(&[3, 0x80]), (2, "cut short"));
    assert_eq!(reason(&[0x83, 0]), (2, "a number longer than it need be"));
    assert_eq!(reason(&[0xff; 12]), (10, "a number beyond 64 bits"));
    assert_eq!(reason(&[1, 0xff, 1]), (3, "a change beyond the map"));
    // 2^64 − 1 after 1: the sum must not wrap.
    assert_eq!(reason(&[1, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1]), (11, "a change beyond the map"));
}

#[test]
fn impossible_maps_are_refused() {
    assert!(CodedBinaryMaps::<u8>::new(0).is_err() && CodedBinaryMaps::<u8>::new(257).is_err());
    assert!(CodedBinaryMaps::<u8>::new(256).is_ok() && CodedBinaryMaps::<u16>::new(65536).is_ok());
    assert!(CodedBinaryMaps::<u16>::new(65537).is_err() && CodedBinaryMaps::<u32>::new(1 << 32).is_ok());
    assert!(CodedBinaryMap::<u8>::new(&[3, 3], 256).is_err() && CodedBinaryMap::<u8>::new(&[3, 2], 256).is_err());
    assert!(CodedBinaryMap::<u8>::new(&[3], 3).is_err() && CodedBinaryMap::<u8>::new(&[2], 3).is_ok());
    assert!(CodedGrayMaps::<u8>::new(9, 0).is_err());
    assert!(CodedGrayMaps::<u8>::with_bits(9, 0).is_err() && CodedGrayMaps::<u8>::with_bits(9, 9).is_err());
    for (order, width, height) in [
        (ScanOrder::RowMajor, 0, 4),
        (ScanOrder::RowMajor, 1 << 40, 1 << 40),
        (ScanOrder::Hilbert, 12, 12),
        (ScanOrder::Hilbert, 8, 16),
    ] {
        assert!(Scan::new(order, width, height).is_err() && Scan::turned(order, width, height).is_err());
    }
    let mut gray = CodedGrayMaps::<u8>::with_bits(3, 8).unwrap();
    gray.push_values(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
    assert_eq!((gray.map(0).changes(), gray.map(0).levels()), (&[1, 2][..], &[255, 0][..]));
    // A count that lies fails at once, and not in the allocator.
    let lie = [b"hrun\x01\x00\x04".as_slice(), &twin::varint(1 << 60)].concat();
    assert!(matches!(CodedBinaryMaps::<u8>::from_bytes(&lie), Err(Error::Damaged { .. })));
    let other = [b"hrun\x02\x00\x04\x00".as_slice(), b"hrun\x01\x01\x04\x00", b"hrum\x01\x00\x04\x00", b""];
    assert!(other.iter().all(|bytes| CodedBinaryMaps::<u8>::from_bytes(bytes).is_err()));
    assert!(CodedBinaryMaps::<u8>::from_bytes(b"hrun\x01\x00\x04\x00").unwrap().is_empty());
    // A level that repeats, and one above the top.
    let gray = |levels: [u8; 2]| [b"hrun\x01\x01\x04\x01\x07\x02\x01\x01".as_slice(), &levels].concat();
    assert!(CodedGrayMaps::<u8>::from_bytes(&gray([7, 3])).is_ok());
    assert!([[3, 3], [0, 3], [3, 8]].iter().all(|&levels| CodedGrayMaps::<u8>::from_bytes(&gray(levels)).is_err()));
}

fn panics(f: impl FnOnce() + std::panic::UnwindSafe) -> bool {
    std::panic::catch_unwind(f).is_err()
}

#[test]
fn wrong_lengths_panic() {
    let maps = || {
        let mut maps = CodedBinaryMaps::<u8>::new(65).unwrap();
        maps.push_bools(&[true; 65]);
        maps
    };
    assert!(panics(|| maps().push_bits(&[0])));
    assert!(panics(|| maps().push_bools(&[true; 64])));
    assert!(panics(|| maps().append(&CodedBinaryMaps::new(64).unwrap())));
    assert!(panics(|| maps().push(CodedBinaryMap::new(&[], 64).unwrap())));
    assert!(panics(|| {
        maps().map(1).dot(&[0.0; 65]);
    }));
    assert!(panics(|| {
        maps().map(0).dot(&[0.0; 64]);
    }));
    assert!(panics(|| {
        maps().map(0).masked_dot(&[0.0; 65], &[0.0; 64]);
    }));
    assert!(panics(|| maps().map(0).decode(&mut [0.0; 64])));
    assert!(panics(|| maps().map(0).decode_bits(&mut [0; 1])));
    assert!(panics(|| suffix_sums(0, &[0.0], &mut [0.0])));
    assert!(panics(|| suffix_sums(2, &[0.0; 3], &mut [0.0; 3])));
    assert!(panics(|| suffix_sums(2, &[0.0; 4], &mut [0.0; 2])));
    assert!(panics(|| encode_gaps(&[3u8, 3], &mut Vec::new())));
    assert!(panics(|| CodedGrayMaps::<u8>::new(1, 3).unwrap().push_levels(&[4])));
    assert!(panics(|| CodedGrayMaps::<u8>::new(1, 3).unwrap().append(&CodedGrayMaps::new(1, 4).unwrap())));
    let gray = || CodedGrayMaps::<u8>::with_bits(1, 2).unwrap();
    for (start, end) in [(0, 2), (2, 2), (1, 0)] {
        assert!(panics(|| drop(maps().slice(start..end))));
        assert!(panics(|| drop(gray().slice(start..end))));
    }
    assert!(panics(|| Scan::new(ScanOrder::RowMajor, 2, 2).unwrap().apply(&[0; 4], &mut [0; 3])));
    assert_eq!(maps().map(0).dot(&[1.0; 65]), 1.0);
}

/// What f32 sums cost behind a sun, and what f64 sums save: the figures of the docs.
#[test]
fn a_sun_in_the_block_needs_wide_sums() {
    let mut light = vec![1.0f32; 256];
    light[200] = 1e5;
    let mut map = vec![true; 256];
    map[150..].fill(false);
    map[0] = false;
    let mut maps = CodedBinaryMaps::<u8>::new(256).unwrap();
    maps.push_bools(&map);
    let (mut narrow, mut wide) = (vec![0.0f32; 256], vec![0.0f64; 256]);
    let dimmed: Vec<f32> = light.iter().map(|l| l / 3.0).collect();
    suffix_sums(256, &dimmed, &mut narrow);
    suffix_sums(256, &dimmed, &mut wide);
    let want: f64 = dimmed.iter().zip(&map).filter(|(_, v)| **v).map(|(l, _)| f64::from(*l)).sum();
    let [narrow, wide] = [f64::from(maps.map(0).dot(&narrow)), maps.map(0).dot(&wide)].map(|x| (x - want).abs() / want);
    assert!((1e-6..1e-4).contains(&narrow) && wide < 1e-12, "{narrow:e} {wide:e}");
}

/// Changes and bytes a block of 16 × 16 in each order, over blocks cut from occluded 64 × 64 faces.
#[test]
fn paths_of_neighbours_save_two_changes_in_five() {
    let side = 64;
    let mut stats = Vec::new();
    for order in [ScanOrder::RowMajor, ScanOrder::Serpentine, ScanOrder::Hilbert] {
        let scan = Scan::new(order, 16, 16).unwrap();
        let mut maps = CodedBinaryMaps::<u8>::new(256).unwrap();
        for face in 0..60 {
            // Half-planes and discs at angles and places without a pattern.
            let turn = |k: usize| (face * 7 + k * 3) as f64 * 2.399_963_2 % std::f64::consts::TAU;
            let seen = |x: usize, y: usize| {
                let (x, y) = (x as f64 - 31.5, y as f64 - 31.5);
                let plane = x * turn(0).cos() + y * turn(0).sin() > 8.0 * turn(1) - 20.0;
                let disc = |k| (x - 30.0 * turn(k).cos()).hypot(y - 30.0 * turn(k).sin()) > 2.0 + 3.0 * turn(k + 1);
                plane && disc(2) && disc(4) && disc(6)
            };
            for block in 0..16 {
                let (x0, y0) = (block % 4 * 16, block / 4 * 16);
                let map: Vec<bool> = (0..256).map(|i| seen(x0 + i % 16, y0 + i / 16)).collect();
                let mut path = vec![false; 256];
                scan.apply(&map, &mut path);
                maps.push_bools(&path);
            }
        }
        assert_eq!(side * side * 60, maps.len() * 256);
        let found = maps.stats();
        stats.push(found);
    }
    // The figures of the docs: changes of a block that is not constant, and bytes of any.
    let changes = [0, 1, 2].map(|i| stats[i].mean_changes_of_mixed());
    let bytes = [0, 1, 2].map(|i| stats[i].mean_bytes_in_file());
    let near = |got: [f64; 3], want: [f64; 3]| got.iter().zip(want).all(|(g, w)| (g - w).abs() < 0.006);
    assert!(near(changes, [16.62, 9.92, 10.03]) && near(bytes, [7.53, 5.00, 5.10]), "{changes:?} {bytes:?}");
}
