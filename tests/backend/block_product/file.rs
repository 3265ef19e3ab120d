//! Files: what was written is read, anything else is refused.

use std::io::Write;
use std::path::Path;

use haarmonic::Error;
use haarmonic::backend::block_product::Transport;
use haarmonic::compress::ScanOrder;
use haarmonic::scene::Procedural;
use haarmonic::store::Stored;

use super::support::{ORDERS, layout, patchwork, visibility};
use crate::support::{baker, noise, soup};

fn binary(side: usize, block: usize, vertices: usize, order: ScanOrder) -> Transport {
    let cut = patchwork(side, block, 5);
    Transport::from_clipped(&visibility(side, vertices, cut), &layout(side, block, order)).unwrap()
}

fn gray(side: usize, block: usize, bits: u32) -> Transport {
    let mesh = soup(2);
    Transport::bake_gray(&mesh, &baker(&mesh, side), &layout(side, block, ScanOrder::Serpentine), (4, bits), &())
        .unwrap()
}

fn round_trip(transport: &Transport, path: &Path) -> Vec<u8> {
    transport.save(path).unwrap();
    assert_eq!(&Transport::load(path).unwrap(), transport);
    std::fs::read(path).unwrap()
}

/// Overwrites a file: one that is emptied first may be waited for until it is on the disk.
fn put(bytes: &[u8], path: &Path) {
    let mut file = std::fs::OpenOptions::new().write(true).create(true).truncate(false).open(path).unwrap();
    file.write_all(bytes).unwrap();
    file.set_len(bytes.len() as u64).unwrap();
}

/// The reason why bytes are refused.
fn refusal(bytes: &[u8], path: &Path) -> String {
    put(bytes, path);
    match Transport::load(path) {
        Err(Error::File { path: named, place, reason }) if named == path => format!("{place}: {reason}"),
        other => panic!("{:?}", other.map(|t| t.stats())),
    }
}

/// All bits of some bytes.
fn bits(bytes: &[u8]) -> impl Iterator<Item = usize> {
    0..8 * bytes.len()
}

/// The same bytes with the checksum that belongs to them.
fn signed(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let crc = crc32fast::hash(&bytes[..body]);
    bytes[body..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

#[test]
fn what_was_saved_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    for order in ORDERS {
        for (side, block) in [(8, 8), (48, 16), (32, 32), (64, 32)] {
            round_trip(&binary(side, block, 3, order), &path);
        }
    }
    for (side, block, bits) in [(8, 8, 2), (32, 16, 5), (32, 32, 8)] {
        round_trip(&gray(side, block, bits), &path);
    }
    // The same transport is the same bytes.
    let transport = binary(16, 8, 5, ScanOrder::Hilbert);
    assert_eq!(round_trip(&transport, &path), round_trip(&transport.clone(), &path));
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["blocks.bin"], "nothing else is left behind");
}

#[test]
fn several_sections_are_one_transport() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    for vertices in [0, 1, 4095, 4096, 4097, 8192, 9000] {
        let sees = |v: usize, texel: usize| noise(v) < 0.3 || (noise(v) < 0.8 && texel > v % 384);
        let maps = visibility(8, vertices, sees);
        round_trip(&Transport::from_clipped(&maps, &layout(8, 8, ScanOrder::Serpentine)).unwrap(), &path);
    }
    let mesh = Procedural::BasRelief.build(5000).unwrap().mesh;
    assert!(mesh.positions().len() > 4096);
    let (baker, layout) = (baker(&mesh, 16), layout(16, 8, ScanOrder::Serpentine));
    round_trip(&Transport::bake_gray(&mesh, &baker, &layout, (2, 3), &()).unwrap(), &path);
    round_trip(&Transport::bake(&baker, &layout, &()).unwrap(), &path);
}

#[test]
fn every_cut_flipped_bit_and_tail_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    for transport in [binary(8, 8, 2, ScanOrder::Serpentine), gray(8, 8, 4)] {
        let good = round_trip(&transport, &path);
        assert!((100..1000).contains(&good.len()), "{} bytes", good.len());
        for len in 0..good.len() {
            let reason = refusal(&good[..len], &path);
            assert!(reason.ends_with("is cut short"), "cut at {len}: {reason}");
        }
        for bit in bits(&good) {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            refusal(&bad, &path);
        }
        for tail in [&[0][..], b"more"] {
            let reason = refusal(&[&good, tail].concat(), &path);
            assert!(reason.ends_with("is followed by more bytes than belong to it"), "{reason}");
        }
    }
}

/// Whoever forges a checksum gets an error or a transport that keeps its promises, and no panic.
#[test]
fn bits_that_are_flipped_under_a_good_checksum_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    let mut loaded = 0;
    for transport in [binary(8, 8, 2, ScanOrder::Hilbert), gray(8, 8, 4)] {
        let good = round_trip(&transport, &path);
        for bit in bits(&good[..good.len() - 4]) {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            put(&signed(bad), &path);
            match Transport::load(&path) {
                Ok(other) => {
                    // Another path or another visibility; nothing that is out of bounds.
                    loaded += 1;
                    assert_eq!(other.vertices(), transport.vertices(), "bit {bit}");
                    let mut out = vec![f32::NAN; other.layout().grid().len()];
                    (0..other.vertices()).for_each(|v| {
                        other.decode(v, &mut out);
                        assert!(out.iter().all(|x| (0.0..=1.0).contains(x)), "bit {bit}");
                    });
                }
                Err(error) => assert!(error.to_string().contains("blocks.bin"), "{error}"),
            }
        }
    }
    assert!(loaded > 0);
}

/// A side that lies.
#[test]
fn a_side_that_lies_costs_no_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    let mut bytes = round_trip(&binary(8, 8, 2, ScanOrder::Serpentine), &path);
    bytes[30..32].copy_from_slice(&5000_u16.to_le_bytes());
    let start = std::time::Instant::now();
    refusal(&bytes, &path);
    assert!(start.elapsed().as_millis() < 100, "{:?}", start.elapsed());
}

#[test]
fn messages_say_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    let good = round_trip(&binary(16, 8, 3, ScanOrder::Serpentine), &path);
    assert_eq!(refusal(b"something else", &path), "byte 0: is no file of haarmonic");
    let mut newer = good.clone();
    newer[14] = 9;
    assert_eq!(refusal(&newer, &path), "byte 14: has version 9, this build reads version 3: make it again");
    // A section of side, block, path, top level, vertices; then one of maps, whose length is behind its tag.
    let with = |field: usize, value: u64| {
        let mut bytes = good.clone();
        let start = if field < 5 { 30 + 8 * field } else { 74 };
        bytes[start..][..8].copy_from_slice(&value.to_le_bytes());
        refusal(&signed(bytes), &path)
    };
    for (field, value, expected) in [
        (0, 0, "byte 54: 0 is not a side of a cube map"),
        (0, u64::MAX, "byte 54: 18446744073709551615 is not a side of a cube map"),
        (0, 12, "byte 54: a cube map of side 12 has no blocks of side 8"),
        (1, 7, "byte 54: a cube map of side 16 has no blocks of side 7"),
        (1, u64::MAX, "byte 54: a cube map of side 16 has no blocks of side 18446744073709551615"),
        (2, 3, "byte 54: names a path through blocks that this build does not know"),
        (3, 0, "byte 62: names a top level that is not in 1…255"),
        (3, 256, "byte 62: names a top level that is not in 1…255"),
    ] {
        assert_eq!(with(field, value), expected);
    }
    for (field, value) in [(0, 8), (0, 24), (1, 16), (4, 2), (4, 4), (4, 1 << 40), (4, u64::MAX)] {
        let reason = with(field, value);
        assert!(reason.contains("a section of (pixels, levels, maps) (") && reason.contains("72)"), "{reason}");
    }
    for top in [2, 255] {
        assert!(with(3, top).contains("a section of maps: "), "{}", with(3, top));
    }
    assert!(with(4, 0).ends_with("a section \"END.\" was expected, there is one \"MAPS\""), "{}", with(4, 0));
    for length in [u64::MAX, 1 << 41, 1 << 40, 1 << 20] {
        let reason = with(5, length);
        assert!(reason.contains("bytes of coded maps") || reason.contains("is cut short"), "{reason}");
    }
    // The last three words are those of turned paths, a bit for each of 24 blocks.
    let mut beyond = good.clone();
    let last = good.len() - 16 - 8;
    beyond[last + 3] |= 0x10;
    let reason = refusal(&signed(beyond), &path);
    assert!(reason.ends_with("a path is turned of a block that is beyond the 24 of a vertex"), "{reason}");
    let absent = Transport::load(folder.path().join("absent.bin")).unwrap_err().to_string();
    assert!(absent.contains("absent.bin") && absent.contains("cannot be opened"), "{absent}");
}

#[test]
fn transports_of_other_back_ends_are_refused() {
    use haarmonic::backend::wavelet_triple as triple;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wavelets.bin");
    triple::Transport::from_binary(visibility(8, 2, patchwork(8, 8, 1))).unwrap().save(&path).unwrap();
    let reason = refusal(&std::fs::read(&path).unwrap(), &path);
    assert!(
        reason.ends_with("holds a transport of wavelet triple products, expected a transport of block products"),
        "{reason}"
    );
    binary(8, 8, 2, ScanOrder::RowMajor).save(&path).unwrap();
    let reason = triple::Transport::load(&path).unwrap_err().to_string();
    assert!(reason.contains("holds a transport of block products"), "{reason}");
}

#[test]
fn a_save_that_fails_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blocks.bin");
    let (old, new) = (binary(8, 8, 2, ScanOrder::RowMajor), binary(16, 8, 2, ScanOrder::RowMajor));
    old.save(&path).unwrap();
    // Where the new file would be written first there is a folder.
    let part = folder.path().join(format!("blocks.bin.{}.part", std::process::id()));
    std::fs::create_dir(&part).unwrap();
    assert!(matches!(new.save(&path), Err(Error::File { path: named, .. }) if named == path));
    assert_eq!(Transport::load(&path).unwrap(), old);
    std::fs::remove_dir(&part).unwrap();
    new.save(&path).unwrap();
    assert_eq!(Transport::load(&path).unwrap(), new);
    // A folder where the file should be, and no folder at all: nothing is left behind.
    let taken = folder.path().join("taken");
    std::fs::create_dir_all(taken.join("inside")).unwrap();
    for wrong in [taken.clone(), folder.path().join("no/such/blocks.bin")] {
        assert!(matches!(new.save(&wrong), Err(Error::File { .. })));
    }
    let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["blocks.bin", "taken"]);
}
