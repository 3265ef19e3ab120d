//! Differential coding of 16 × 16 visibility blocks: encode, decode, and dot products against those over pixels.
//! Throughput is in maps.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::compress::{CodedBinaryMaps, Scan, ScanOrder, suffix_sums};

const MAPS: usize = 20_000;

/// Numbers in [0, 1) without a pattern.
fn noise(len: usize) -> Vec<f32> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..len).map(|_| next()).collect()
}

/// Blocks behind a half-plane and a disc.
fn blocks() -> Vec<[u64; 4]> {
    let numbers = noise(3 * MAPS);
    let block = |n: &[f32]| {
        let (sin, cos) = (n[0] * std::f32::consts::TAU).sin_cos();
        let (offset, radius) = (12.0 * (n[1] - 0.5), 6.0 * n[2]);
        let mut words = [0u64; 4];
        for p in 0..256 {
            let (x, y) = ((p % 16) as f32 - 7.5, (p / 16) as f32 - 7.5);
            let seen = cos * x + sin * y > offset && (x - 3.0).hypot(y + 2.0) > radius;
            words[p / 64] |= u64::from(seen) << (p % 64);
        }
        words
    };
    numbers.chunks_exact(3).map(block).collect()
}

fn coding(c: &mut Criterion) {
    let mut group = c.benchmark_group("run_coding");
    group.sample_size(20).throughput(Throughput::Elements(MAPS as u64));
    let blocks = blocks();
    let coded = |blocks: &[[u64; 4]]| {
        let mut maps = CodedBinaryMaps::<u8>::new(256).unwrap();
        blocks.iter().for_each(|block| maps.push_bits(block));
        maps
    };
    let maps = coded(&blocks);
    group.bench_function("encode_bits", |b| b.iter(|| coded(black_box(&blocks))));
    let mut words = [0; 4];
    group.bench_function("decode_bits", |b| {
        b.iter(|| maps.iter().for_each(|map| map.decode_bits(black_box(&mut words))))
    });
    let mut values = [0.0f32; 256];
    group.bench_function("decode_f32", |b| b.iter(|| maps.iter().for_each(|map| map.decode(black_box(&mut values)))));
    let hilbert = Scan::new(ScanOrder::Hilbert, 16, 16).unwrap();
    group.bench_function("hilbert_bits", |b| {
        b.iter(|| blocks.iter().for_each(|block| hilbert.apply_bits(block, black_box(&mut words))));
    });
    let bytes = maps.to_bytes();
    group.bench_function("to_bytes", |b| b.iter(|| black_box(&maps).to_bytes()));
    group.bench_function("from_bytes", |b| b.iter(|| CodedBinaryMaps::<u8>::from_bytes(black_box(&bytes)).unwrap()));

    let light = noise(256);
    let rgb: Vec<[f32; 3]> = light.iter().map(|&l| [l, 0.5 * l, 0.25 * l]).collect();
    let (mut sums, mut wide, mut rgb_sums) = ([0.0f32; 256], [0.0f64; 256], [[0.0f64; 3]; 256]);
    suffix_sums(256, &light, &mut sums);
    suffix_sums(256, &light, &mut wide);
    suffix_sums(256, &rgb, &mut rgb_sums);
    group.bench_function("dot_f32", |b| {
        b.iter(|| {
            maps.iter().for_each(|map| {
                black_box(map.dot(black_box(&sums)));
            })
        });
    });
    group.bench_function("dot_f64", |b| {
        b.iter(|| {
            maps.iter().for_each(|map| {
                black_box(map.dot(black_box(&wide)));
            })
        });
    });
    group.bench_function("dot_rgb_f64", |b| {
        b.iter(|| {
            maps.iter().for_each(|map| {
                black_box(map.dot(black_box(&rgb_sums)));
            })
        });
    });
    group.bench_function("masked_dot", |b| {
        b.iter(|| {
            maps.iter().for_each(|map| {
                black_box(map.masked_dot(black_box(&light), &light));
            })
        });
    });
    // Over all pixels: of maps that are stored as bits, and of decoded ones (a KiB each).
    group.bench_function("pixels_from_bits", |b| {
        b.iter(|| {
            for words in &blocks {
                let mut sum = 0.0f64;
                for (i, &word) in words.iter().enumerate() {
                    let mut rest = word;
                    while rest != 0 {
                        sum += f64::from(light[64 * i + rest.trailing_zeros() as usize]);
                        rest &= rest - 1;
                    }
                }
                black_box(sum);
            }
        });
    });
    let mut decoded = vec![0.0f32; 256 * MAPS];
    maps.iter().zip(decoded.chunks_exact_mut(256)).for_each(|(map, out)| map.decode(out));
    group.bench_function("pixels_decoded", |b| {
        b.iter(|| {
            for map in decoded.chunks_exact(256) {
                let mut sums = [0.0f32; 16];
                for (v, l) in map.chunks_exact(16).zip(light.chunks_exact(16)) {
                    (0..16).for_each(|i| sums[i] += v[i] * l[i]);
                }
                black_box(sums.iter().sum::<f32>());
            }
        });
    });
    group.finish();
}

criterion_group!(benches, coding);
criterion_main!(benches);
