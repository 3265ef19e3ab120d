//! Damaged OpenEXR files: an error or a picture, and memory bounded by the size in the header.

use std::io::Write;

use exr::prelude::{Blocks, Compression, SampleType, Vec2};
use haarmonic::io::{load_image, read_exr};

use super::exr_files::{COMPRESSIONS, file};
use super::{fault, messages};

/// What a read may take besides four times the picture: tables of the codes, and the file's name in errors.
const TABLES: u64 = 1 << 20;

/// Small numbers with the period 2⁶⁴ − 1 (xorshift, 13-7-17).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() >> 16) as usize % n.max(1)
    }
}

/// Numbers at which sizes, counts and sums go wrong.
fn edge(random: &mut Random) -> u64 {
    let power = 1_u64 << random.below(64);
    match random.below(6) {
        0 => 0,
        1 => power,
        2 => power - 1,
        3 => power.wrapping_neg(),
        4 => u64::MAX,
        _ => random.below(300) as u64,
    }
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match random.below(10) {
            0 | 1 => bytes[at] = random.next() as u8,
            2 | 3 => bytes[at] ^= 1 << random.below(8),
            4 => bytes.insert(at, random.next() as u8),
            5 => drop(bytes.drain(at..end)),
            6 => bytes.truncate(if random.below(8) == 0 { at } else { bytes.len() }),
            7 => {
                let from = random.below(bytes.len() - (end - at) + 1);
                bytes.copy_within(from..from + (end - at), at);
            }
            n => {
                let number = edge(random).to_le_bytes();
                let size = if n == 8 { 4 } else { 8 };
                let end = (at + size).min(bytes.len());
                bytes[at..end].copy_from_slice(&number[..end - at]);
            }
        }
    }
}

/// Pixels of the largest window that the header declares, of those that are not refused for their size.
fn declared(bytes: &[u8]) -> u64 {
    let pixels = |name: &[u8]| {
        let at = bytes.windows(name.len()).position(|w| w == name)? + name.len() + 4;
        let number = |i: usize| Some(i64::from(i32::from_le_bytes(bytes.get(at + 4 * i..)?.first_chunk().copied()?)));
        let (w, h) = (number(2)? - number(0)? + 1, number(3)? - number(1)? + 1);
        u64::try_from(w.checked_mul(h)?).ok().filter(|n| *n <= 1 << 27)
    };
    let (data, display) = (pixels(b"dataWindow\0box2i\0"), pixels(b"displayWindow\0box2i\0"));
    data.unwrap_or(0).max(display.unwrap_or(0))
}

fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for compression in COMPRESSIONS {
        for (names, types, size, blocks) in [
            (&["R", "G", "B"][..], &[SampleType::F16][..], (20, 37), Blocks::ScanLines),
            (&["R", "G", "B"][..], &[SampleType::F32][..], (9, 11), Blocks::Tiles(Vec2(5, 8))),
            (&["A", "R", "G", "B"][..], &[SampleType::F16, SampleType::F32][..], (12, 5), Blocks::ScanLines),
            (&["Y", "Z"][..], &[SampleType::F16][..], (17, 18), Blocks::Tiles(Vec2(16, 16))),
        ] {
            seeds.push(file(names, types, compression, size, blocks, false));
        }
    }
    for name in ["dwa_inflate_size.exr", "dwa_huffman_count.exr", "envmap_cube.exr", "rec2020.exr"] {
        seeds.push(std::fs::read(fault(name)).unwrap());
    }
    seeds
}

/// Ten million have been run with `HAARMONIC_MUTATIONS=10000000`, and `HAARMONIC_MUTATION_SEED` for others.
#[test]
fn mutated_files_neither_panic_nor_take_more_than_the_picture() {
    let number = |name: &str| std::env::var(name).ok().and_then(|n| n.parse::<u64>().ok());
    let count = number("HAARMONIC_MUTATIONS").unwrap_or(20_000);
    let mut random = Random(number("HAARMONIC_MUTATION_SEED").unwrap_or(0) ^ 0x9e37_79b9_7f4a_7c15);
    let seeds = seeds();
    // What is computed once for all files is not a file's.
    for seed in &seeds {
        let _ = read_exr(seed, "warm.exr");
    }
    let (mut read, mut worst) = (0_u64, 0.0_f64);
    let mut bytes = Vec::new();
    for i in 0..count {
        bytes.clone_from(&seeds[i as usize % seeds.len()]);
        let before = random.0;
        mutate(&mut bytes, &mut random);
        let mut result = None;
        let memory = allocation_counter::measure(|| result = Some(read_exr(&bytes, "a.exr")));
        match result.unwrap() {
            Ok(_) => read += 1,
            Err(e) => assert!(e.to_string().starts_with("a.exr"), "{e}"),
        }
        let allowed = 4 * 12 * declared(&bytes) + TABLES;
        let taken = memory.bytes_max;
        assert!(taken <= allowed, "mutation {i} ({before:#x}): {taken} bytes taken, {allowed} allowed");
        worst = worst.max(taken as f64 / allowed as f64);
    }
    // Damage that no checksum sees gives a picture: were there none, the harness would not get past the header.
    assert!(read > count / 50, "{read} of {count} read");
    if count > 20_000 {
        let line = format!("{count} mutations, {read} of them read; at most {worst:.2} of the memory allowed");
        let _ = writeln!(std::io::stderr(), "{line}");
    }
}

#[test]
fn absurd_sizes_in_blocks_are_errors_with_their_place() {
    for (name, place) in [("dwa_inflate_size.exr", "block "), ("dwa_huffman_count.exr", "block ")] {
        let path = fault(name);
        let mut result = None;
        let memory = allocation_counter::measure(|| result = Some(load_image(&path)));
        let message = result.unwrap().unwrap_err().to_string();
        assert!(message.starts_with(&format!("{}, {place}", path.display())), "{message}");
        assert!(memory.bytes_max < 4 << 20, "{}", memory.bytes_max);
    }
}

/// Every number at the head of a DWA block in turn, at every edge.
#[test]
fn numbers_at_the_head_of_a_dwa_block() {
    let good = file(
        &["R", "G", "B", "A", "Z"],
        &[SampleType::F16],
        Compression::DWAA(None),
        (20, 37),
        Blocks::ScanLines,
        false,
    );
    // The first block begins with its line and size; its first number is the version, 2.
    let window = [2_u8, 0, 0, 0, 0, 0, 0, 0];
    let head = (0..good.len()).find(|&i| i > 300 && good[i..].starts_with(&window)).unwrap();
    let mut refused = 0;
    for number in 1..11 {
        for value in (0..64).flat_map(|b| [1_u64 << b, (1 << b) - 1, (1_u64 << b).wrapping_neg()]) {
            let mut bytes = good.clone();
            bytes[head + 8 * number..][..8].copy_from_slice(&value.to_le_bytes());
            let mut result = None;
            let memory = allocation_counter::measure(|| result = Some(read_exr(&bytes, "a.exr")));
            assert!(memory.bytes_max < TABLES, "number {number} = {value}: {}", memory.bytes_max);
            if let Err(e) = result.unwrap() {
                assert!(e.to_string().starts_with("a.exr, block 0 of 2: "), "{e}");
                refused += 1;
            }
        }
    }
    // All but the values that are right, and, for Huffman or zlib, the other code.
    assert!(refused > 10 * 192 - 40, "{refused}");
}

/// Memory of a whole file in one block, by the writer's worst cases: every sample stored.
#[test]
fn one_block_takes_at_most_four_times_the_picture() {
    for compression in COMPRESSIONS {
        let bytes =
            file(&["R", "G", "B"], &[SampleType::F16], compression, (512, 256), Blocks::Tiles(Vec2(512, 256)), false);
        let mut result = None;
        let memory = allocation_counter::measure(|| result = Some(read_exr(&bytes, "a.exr")));
        let loaded = result.unwrap().unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        let picture = 12 * 512 * 256;
        assert!(memory.bytes_max < 3 * picture + TABLES, "{compression}: {}", memory.bytes_max as f64 / picture as f64);
    }
}

#[test]
fn compressions_that_cannot_be_read_say_so() {
    let good = file(&["R", "G", "B"], &[SampleType::F16], Compression::ZIP16, (8, 4), Blocks::ScanLines, false);
    let name = b"compression\0compression\0\x01\0\0\0";
    let at = good.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    for (code, message) in [
        (10, "a.exr, header: HTJ2K compression cannot be read; save the picture with another one, such as ZIP"),
        (11, "a.exr, header: HTJ2K compression cannot be read; save the picture with another one, such as ZIP"),
        (12, "a.exr, header: compression number 12 is not known"),
        (255, "a.exr, header: compression number 255 is not known"),
    ] {
        let mut bytes = good.clone();
        bytes[at] = code;
        assert_eq!(read_exr(&bytes, "a.exr").unwrap_err().to_string(), message);
    }
}

#[test]
fn too_many_channels() {
    let good = file(&["R", "G", "B"], &[SampleType::F16], Compression::ZIP16, (8, 4), Blocks::ScanLines, false);
    let name = b"channels\0chlist\0";
    let at = good.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    for (count, message) in [
        (4096, "there is no one set of channels R, G, B and no plain Y; the channels are: "),
        (4097, "more than 4096 channels"),
    ] {
        let mut list = Vec::new();
        for i in 0..count {
            list.extend(format!("{i:04x}.R\0").as_bytes());
            list.extend([1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
        }
        list.push(0);
        let old = i32::from_le_bytes(good[at..at + 4].try_into().unwrap()) as usize;
        let bytes = [&good[..at], &(list.len() as i32).to_le_bytes(), &list, &good[at + 4 + old..]].concat();
        let e = read_exr(&bytes, "a.exr").unwrap_err().to_string();
        assert!(e.starts_with(&format!("a.exr, header: {message}")), "{e}");
    }
}
