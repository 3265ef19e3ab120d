//! Rotation of expansions in f64: one rotation for many vectors, a rotation a vector, about z; single calls; building a
//! plan. Rotations in f32 are jobs of the bench `sh`.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::nalgebra::{Rotation3, UnitQuaternion, Vector3};
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Rotation, Rotator, rotate_z, rotate_z_batch};

/// Turns the vector of this number.
type Turn<'a> = dyn Fn(usize, &[f64], &mut [f64]) + 'a;

/// Vectors of a batch: in the second cache at every size.
const COUNT: usize = 512;
/// Vectors of a small batch: in the first cache up to 10 bands.
const SMALL: usize = 64;
const BANDS: [usize; 7] = [3, 4, 5, 6, 8, 10, 21];

fn turn(i: usize) -> Rotation3<f64> {
    let x = i as f64;
    Rotation3::new(Vector3::new((1.3 * x).sin(), (0.7 * x + 1.0).cos(), (2.1 * x).sin()) * 2.0)
}

fn values(len: usize) -> Vec<f64> {
    (0..len).map(|i| (0.1 + 1.7 * i as f64).sin()).collect()
}

/// Structure of arrays of the first COUNT rotations: quaternions and matrices.
fn poses() -> ([Vec<f64>; 4], [Vec<f64>; 9]) {
    let turns: Vec<_> = (0..COUNT).map(turn).collect();
    let quaternion = |k: usize| turns.iter().map(|r| UnitQuaternion::from_rotation_matrix(r).coords[k]).collect();
    let matrix = |k: usize| turns.iter().map(|r| r[(k / 3, k % 3)]).collect();
    (std::array::from_fn(quaternion), std::array::from_fn(matrix))
}

fn batches(c: &mut Criterion) {
    let (quaternions, matrices) = poses();
    let [q, r] = [quaternions.each_ref().map(|c| &c[..]).to_vec(), matrices.each_ref().map(|c| &c[..]).to_vec()];
    let (q, r): ([&[f64]; 4], [&[f64]; 9]) = (q.try_into().expect("four"), r.try_into().expect("nine"));
    let (cos, sin): (Vec<f64>, Vec<f64>) = (0..COUNT).map(|i| ((i as f64).cos(), (i as f64).sin())).unzip();
    let mut group = c.benchmark_group(format!("rotate f64, {COUNT} vectors"));
    group.throughput(Throughput::Elements(COUNT as u64));
    for bands in BANDS {
        let f = values(bands * bands * COUNT);
        let mut out = f.clone();
        let one = Rotation::<f64>::new(bands, &turn(3)).expect("a size in range");
        let many = Rotator::<f64>::new(bands).expect("a size in range");
        group.bench_function(BenchmarkId::new("one rotation", bands), |b| {
            b.iter(|| one.apply_batch(COUNT, black_box(&f), black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new("a quaternion each", bands), |b| {
            b.iter(|| many.apply_quaternion_batch(COUNT, q, black_box(&f), black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new("a matrix each", bands), |b| {
            b.iter(|| many.apply_batch(COUNT, r, black_box(&f), black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new(format!("one rotation, {SMALL} at a time"), bands), |b| {
            let size = SMALL * bands * bands;
            let (f, out) = (&f[..size], &mut out[..size]);
            b.iter(|| (0..COUNT / SMALL).for_each(|_| one.apply_batch(SMALL, black_box(f), black_box(out))));
        });
        let mut turned = f.clone();
        group.bench_function(BenchmarkId::new("about z", bands), |b| {
            b.iter(|| rotate_z_batch(&cos, &sin, black_box(&mut turned)));
        });
    }
    group.finish();
}

fn singles(c: &mut Criterion) {
    let turns: Vec<_> = (0..64).map(turn).collect();
    let quaternions: Vec<_> = turns.iter().map(UnitQuaternion::from_rotation_matrix).collect();
    let mut group = c.benchmark_group("rotate f64, 64 single calls");
    group.throughput(Throughput::Elements(64));
    for bands in BANDS {
        let n = bands * bands;
        let f = values(n * 64);
        let mut out = f.clone();
        let rotator = Rotator::<f64>::new(bands).expect("a size in range");
        let one = Rotation::<f64>::new(bands, &turn(3)).expect("a size in range");
        let mut run = |name: &str, rotate: &Turn<'_>| {
            group.bench_function(BenchmarkId::new(name, bands), |b| {
                b.iter(|| {
                    for (i, (f, out)) in f.chunks_exact(n).zip(out.chunks_exact_mut(n)).enumerate() {
                        rotate(i, black_box(f), black_box(out));
                    }
                });
            });
        };
        run("matrix", &|i, f, out| rotator.apply(&turns[i], f, out));
        run("quaternion", &|i, f, out| rotator.apply_quaternion(&quaternions[i], f, out));
        run("one rotation", &|_, f, out| one.apply(f, out));
        run("about z", &|i, f, out| {
            out.copy_from_slice(f);
            rotate_z(0.1 * i as f64, out);
        });
    }
    group.finish();
}

fn plans(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation plan f32");
    for bands in [3, 6, 10, 16, 32, 64] {
        group.bench_function(BenchmarkId::new("rotation", bands), |b| {
            b.iter(|| Rotation::<f32>::new(bands, black_box(&turn(3))));
        });
        group.bench_function(BenchmarkId::new("rotator", bands), |b| b.iter(|| Rotator::<f32>::new(bands)));
    }
    for bands in [3, 6] {
        group.bench_function(BenchmarkId::new("naive twin, blocks", bands), |b| {
            b.iter(|| naive::rotation(bands, &turn(3)))
        });
    }
    group.finish();
}

fn rotate(c: &mut Criterion) {
    batches(c);
    singles(c);
    plans(c);
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(200));
    targets = rotate
}
criterion_main!(benches);
