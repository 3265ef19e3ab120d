//! Nanoseconds of spherical harmonics in `f32`, in turn: products, rotations, evaluation, projection. Same inputs and
//! same way as peers/directxmath.cpp, so that peers/against_directxmath.py can run both alternately.
//!
//! Run with: cargo bench -p haarmonic-benches --bench sh [-- WORDS]: jobs whose name holds all the words.

use std::hint::black_box;

use haarmonic::nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use haarmonic::sh::{
    Basis, CubeProjection, Expansion, Product, Rotation, Rotator, Square, TexelRule, rotate_z, rotate_z_batch,
};
use haarmonic::sphere::{CubeGrid, CubeMap, fibonacci_directions};
use haarmonic_benches::{Jobs, numbers};

/// Inputs of single calls, in the first cache up to 6 bands.
const INPUTS: usize = 64;
/// Vectors of a batch that stays in the second cache, an odd number of registers so that rows do not share cache sets.
fn batch_size(size: usize) -> usize {
    ((2000 / size).max(8) / 8).div_ceil(2) * 16 - 8
}

fn products(jobs: &mut Jobs) {
    for bands in 2..=8 {
        let (size, count) = (bands * bands, batch_size(bands * bands));
        let product = Product::<f32>::new(bands, bands, bands).expect("bands in range");
        let square = Square::<f32>::new(bands, bands).expect("bands in range");
        let (a, b, mut out) = (numbers(size * INPUTS), numbers(size * INPUTS), numbers(size * INPUTS));
        let (single, lone, f) = (product.clone(), square.clone(), a.clone());
        jobs.add(format!("product single {bands}"), INPUTS, move || {
            let inputs = a.chunks_exact(size).zip(b.chunks_exact(size));
            for ((a, b), out) in inputs.zip(black_box(&mut out).chunks_exact_mut(size)) {
                single.apply(a, b, out);
            }
        });
        let mut out = f.clone();
        jobs.add(format!("square single {bands}"), INPUTS, move || {
            for (f, out) in f.chunks_exact(size).zip(black_box(&mut out).chunks_exact_mut(size)) {
                lone.apply(f, out);
            }
        });
        let (f, mut matrix, plan) = (numbers(size), numbers(size * size), product.clone());
        jobs.add(format!("matrix of a product {bands}"), 1, move || plan.matrix(black_box(&f), black_box(&mut matrix)));
        let (a, b, mut out) = (numbers(size * count), numbers(size * count), numbers(size * count));
        let f = a.clone();
        jobs.add(format!("product batch {bands}"), count, move || {
            product.apply_batch(count, black_box(&a), &b, black_box(&mut out));
        });
        let mut out = f.clone();
        jobs.add(format!("square batch {bands}"), count, move || {
            square.apply_batch(count, black_box(&f), black_box(&mut out));
        });
    }
}

/// A call that stays one and writes to where its result belongs, as DirectXMath's do: what is inlined into a loop over
/// arrays may be vectorised across them.
#[inline(never)]
fn call<A, B, R>(function: impl Fn(A, B) -> R, a: A, b: B, out: &mut R) {
    *out = function(a, b);
}

/// Arrays of `N`, one at a time.
fn arrays<const N: usize>(jobs: &mut Jobs)
where
    [f32; N]: Expansion<Scalar = f32>,
{
    let bands = <[f32; N]>::BANDS;
    let inputs = || numbers(N * INPUTS).as_chunks::<N>().0.to_vec();
    let (a, b, mut out) = (inputs(), numbers(N * (INPUTS + 1))[N..].as_chunks::<N>().0.to_vec(), inputs());
    let (f, g, mut h) = (a.clone(), b.clone(), out.clone());
    jobs.add(format!("product array {bands}"), INPUTS, move || {
        for ((a, b), out) in a.iter().zip(&b).zip(black_box(&mut out)) {
            call(<[f32; N]>::product, a, b, out);
        }
    });
    jobs.add(format!("product array, inlined {bands}"), INPUTS, move || {
        for ((a, b), out) in f.iter().zip(&g).zip(black_box(&mut h)) {
            *out = a.product(b);
        }
    });
    let (f, mut out, turns) = (inputs(), inputs(), (0..INPUTS).map(|i| turn(i).cast::<f32>()).collect::<Vec<_>>());
    jobs.add(format!("rotate array {bands}"), INPUTS, move || {
        for ((f, turn), out) in f.iter().zip(&turns).zip(black_box(&mut out)) {
            call(<[f32; N]>::rotate, f, turn, out);
        }
    });
    let directions: Vec<_> = fibonacci_directions(INPUTS).iter().map(|d| d.into_inner().cast::<f32>()).collect();
    let (mut out, d) = (inputs(), directions.clone());
    jobs.add(format!("eval array {bands}"), INPUTS, move || {
        for (d, out) in d.iter().zip(black_box(&mut out)) {
            call(|d, ()| <[f32; N]>::eval(d), d, (), out);
        }
    });
    let mut out = inputs();
    jobs.add(format!("eval array, inlined {bands}"), INPUTS, move || {
        for (d, out) in directions.iter().zip(black_box(&mut out)) {
            *out = <[f32; N]>::eval(d);
        }
    });
    let (a, b, mut out) = (inputs(), inputs(), numbers(INPUTS));
    jobs.add(format!("dot array {bands}"), INPUTS, move || {
        for ((a, b), out) in a.iter().zip(&b).zip(black_box(&mut out)) {
            call(<[f32; N]>::dot, a, b, out);
        }
    });
    let (a, b, c) = (inputs(), inputs(), inputs());
    jobs.add(format!("integral array {bands}"), INPUTS, move || {
        for ((a, b), c) in black_box(&a).iter().zip(&b).zip(&c) {
            black_box(a.integral(b, c));
        }
    });
}

fn turn(i: usize) -> Rotation3<f64> {
    let x = i as f64;
    Rotation3::new(Vector3::new((1.3 * x).sin(), (0.7 * x + 1.0).cos(), (2.1 * x).sin()) * 2.0)
}

fn single_rotations(jobs: &mut Jobs) {
    let turns: Vec<_> = (0..INPUTS).map(|i| turn(i).cast::<f32>()).collect();
    let quaternions: Vec<_> = turns.iter().map(UnitQuaternion::from_rotation_matrix).collect();
    for bands in 3..=6 {
        let size = bands * bands;
        let rotator = Rotator::<f32>::new(bands).expect("bands in range");
        let (f, mut out) = (numbers(size * INPUTS), numbers(size * INPUTS));
        let (turns, plan) = (turns.clone(), rotator.clone());
        jobs.add(format!("rotate single {bands}"), INPUTS, move || {
            for ((f, turn), out) in f.chunks_exact(size).zip(&turns).zip(black_box(&mut out).chunks_exact_mut(size)) {
                plan.apply(turn, f, out);
            }
        });
        let (f, mut out, quaternions) = (numbers(size * INPUTS), numbers(size * INPUTS), quaternions.clone());
        jobs.add(format!("rotate single quaternion {bands}"), INPUTS, move || {
            for ((f, turn), out) in
                f.chunks_exact(size).zip(&quaternions).zip(black_box(&mut out).chunks_exact_mut(size))
            {
                rotator.apply_quaternion(turn, f, out);
            }
        });
        let (mut f, angles) = (numbers(size * INPUTS), numbers(INPUTS));
        jobs.add(format!("rotate_z single {bands}"), INPUTS, move || {
            for (f, &angle) in black_box(&mut f).chunks_exact_mut(size).zip(&angles) {
                rotate_z(angle, f);
            }
        });
    }
}

fn batch_rotations(jobs: &mut Jobs) {
    for bands in [3, 4, 5, 6, 10, 21] {
        let size = bands * bands;
        let one = Rotation::<f32>::new(bands, &turn(3)).expect("bands in range");
        for count in [INPUTS, 512] {
            let (f, mut out, one) = (numbers(size * count), numbers(size * count), one.clone());
            jobs.add(format!("one rotation, {count} vectors {bands}"), count, move || {
                one.apply_batch(count, black_box(&f), black_box(&mut out));
            });
        }
        let quaternions: Vec<_> = (0..INPUTS).map(|i| UnitQuaternion::from_rotation_matrix(&turn(i))).collect();
        let q = [0, 1, 2, 3].map(|k| quaternions.iter().map(|q| q.coords[k] as f32).collect::<Vec<_>>());
        let rotator = Rotator::<f32>::new(bands).expect("bands in range");
        let (f, mut out, plan) = (numbers(size * INPUTS), numbers(size * INPUTS), rotator.clone());
        jobs.add(format!("a rotation each {bands}"), INPUTS, move || {
            plan.apply_quaternion_batch(INPUTS, q.each_ref().map(|c| &c[..]), black_box(&f), black_box(&mut out));
        });
        let r: [Vec<f32>; 9] = std::array::from_fn(|k| (0..INPUTS).map(|i| turn(i)[(k / 3, k % 3)] as f32).collect());
        let (f, mut out) = (numbers(size * INPUTS), numbers(size * INPUTS));
        jobs.add(format!("a matrix each {bands}"), INPUTS, move || {
            rotator.apply_batch(INPUTS, r.each_ref().map(|c| &c[..]), black_box(&f), black_box(&mut out));
        });
        let (mut f, [cos, sin]) = (
            numbers(size * INPUTS),
            [f32::cos, f32::sin].map(|f| numbers(INPUTS).into_iter().map(f).collect::<Vec<_>>()),
        );
        jobs.add(format!("about z each {bands}"), INPUTS, move || {
            rotate_z_batch(&cos, &sin, black_box(&mut f));
        });
    }
}

fn evaluation(jobs: &mut Jobs) {
    let directions: Vec<Vector3<f32>> =
        fibonacci_directions(INPUTS).iter().map(|d| Unit::into_inner(*d).cast::<f32>()).collect();
    for bands in [3, 4, 5, 6, 10, 21, 51] {
        let size = bands * bands;
        let basis = Basis::<f32>::new(bands).expect("bands in range");
        if bands <= 6 {
            let (mut out, basis, directions) = (numbers(size * INPUTS), basis.clone(), directions.clone());
            jobs.add(format!("eval single {bands}"), INPUTS, move || {
                for (d, out) in directions.iter().zip(black_box(&mut out).chunks_exact_mut(size)) {
                    basis.eval(d, out);
                }
            });
        }
        for count in [if bands <= 4 { 256 } else { 64 }, 100_000] {
            if count == 100_000 && bands > 10 {
                continue;
            }
            let directions = fibonacci_directions(count);
            let [x, y, z] = [0, 1, 2].map(|k| directions.iter().map(|d| d[k] as f32).collect::<Vec<_>>());
            let (mut out, rows, [u, v, w]) = (numbers(size * count), basis.clone(), [x.clone(), y.clone(), z.clone()]);
            jobs.add(format!("eval rows, {count} points {bands}"), count, move || {
                rows.eval_batch(black_box(&u), &v, &w, black_box(&mut out));
            });
            let (mut out, points) = (numbers(size * count), basis.clone());
            jobs.add(format!("eval points, {count} points {bands}"), count, move || {
                points.eval_points(black_box(&x), &y, &z, black_box(&mut out));
            });
        }
    }
}

fn projections(jobs: &mut Jobs) {
    let grid = CubeGrid::new(64).expect("a side in range");
    let map = CubeMap::from_fn(grid, |d| d.map(|c| (3.0 * c).exp() as f32));
    for bands in [3, 6] {
        let plan = CubeProjection::<f32>::new(grid, bands, TexelRule::Centre).expect("bands in range");
        let map = map.clone();
        jobs.add(format!("project 64² × 6 RGB {bands}"), 1, move || {
            black_box(plan.project(black_box(&map)));
        });
    }
}

fn main() {
    let mut jobs = Jobs::default();
    products(&mut jobs);
    arrays::<4>(&mut jobs);
    arrays::<9>(&mut jobs);
    arrays::<16>(&mut jobs);
    arrays::<25>(&mut jobs);
    arrays::<36>(&mut jobs);
    arrays::<49>(&mut jobs);
    arrays::<64>(&mut jobs);
    single_rotations(&mut jobs);
    batch_rotations(&mut jobs);
    evaluation(&mut jobs);
    projections(&mut jobs);
    jobs.run();
}
