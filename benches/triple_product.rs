//! ∫ L B V over one square: routes × kept terms × side, the naive twin, and the engine against the better route.
//!
//! Light: a gradient sky with a sun and two boxes, the same for all; BRDFs and visibilities: 32 lobes and 32
//! silhouettes, taken in turn, as a renderer does from vertex to vertex. Times are per integral.
//! `TRIPLE_PRODUCT_SWEEP=1` prints the engine's table.
#![expect(clippy::print_stderr, reason = "the sweep is a table for people")]

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::haar::{
    BitPyramid, Decomposition, Factor, MaskedSum, MeanTree, NFoldProduct, Quadtree, Route, SparseVector, TripleProduct,
    Visibility, forward_2d,
};
use haarmonic::reference::haar as naive;
use haarmonic::reference::haar::{NgTree, NgTripleProduct};

const SCENES: usize = 32;

/// One light against many BRDFs and visibilities.
struct Case<T> {
    plan: TripleProduct,
    light: Factor<T>,
    rgb: Factor<T, 3>,
    light_tree: NgTree<T>,
    light_quadtree: Quadtree<T>,
    vertices: Vec<Vertex<T>>,
}

struct Vertex<T> {
    sparse_brdf: SparseVector<T>,
    brdf: Factor<T>,
    brdf_tree: NgTree<T>,
    brdf_quadtree: Quadtree<T>,
    rows: Vec<u64>,
    pixels: Vec<f64>,
    bits: BitPyramid,
    means: MeanTree<T>,
    visibility: Vec<T>,
    visibility_quadtree: Quadtree<T>,
}

fn image(side: usize, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let centre = |i: usize| (i as f64 + 0.5) / side as f64;
    (0..side * side).map(|i| f(centre(i % side), centre(i / side))).collect()
}

fn sky(x: f64, y: f64, channel: f64) -> f64 {
    let sun = if (x - 0.7).hypot(y - 0.2) < 0.06 { 40.0 } else { 0.0 };
    let in_box = |x0: f64, y0: f64| (x - x0).abs() < 0.11 && (y - y0).abs() < 0.07;
    let boxes = if in_box(0.2, 0.4) {
        6.0 * channel
    } else if in_box(0.5, 0.8) {
        4.0
    } else {
        0.0
    };
    0.3 + channel * (1.0 - y) + sun + boxes + 0.2 * (17.0 * x).sin() * (23.0 * y).cos()
}

/// A lobe around a point of the face, as a Phong BRDF of some glossiness leaves on it.
fn lobe(seed: usize) -> impl Fn(f64, f64) -> f64 {
    let (cx, cy) = (0.5 + 0.4 * (seed as f64 * 2.4).cos(), 0.5 + 0.4 * (seed as f64 * 1.7).sin());
    let width = 0.1 + 0.03 * (seed % 7) as f64;
    move |x, y| (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * width * width)).exp() + 0.1 * (1.0 - y)
}

/// A silhouette: what two disks and a slanted half-plane leave open.
fn silhouette(seed: usize) -> impl Fn(f64, f64) -> f64 {
    let s = seed as f64;
    let (ax, ay, r) = (0.3 + 0.2 * (s * 1.3).sin(), 0.4 + 0.2 * (s * 0.7).cos(), 0.15 + 0.1 * (s * 3.1).sin().abs());
    let slope = 0.3 * (s * 0.9).sin();
    move |x, y| {
        let open = y < 0.75 + slope * (x - 0.5) && (x - ax).hypot(y - ay) > r && (x - 0.8).hypot(y - ay - 0.2) > 0.1;
        f64::from(u8::from(open))
    }
}

/// The k largest coefficients by magnitude.
fn kept<T: Real>(pixels: &[f64], side: usize, k: usize) -> SparseVector<T> {
    let c = forward_2d(pixels, side, side, Decomposition::Nonstandard).expect("a power of two");
    let mut order: Vec<usize> = (0..c.len()).collect();
    order.sort_by(|&i, &j| c[j].abs().total_cmp(&c[i].abs()));
    order.truncate(k);
    order.sort_unstable();
    let values = order.iter().map(|&i| T::of(c[i])).collect();
    SparseVector::new(c.len(), order.iter().map(|&i| i as u32).collect(), values).expect("sorted indices")
}

fn case<T: Real>(side: usize, k_light: usize, k_brdf: usize) -> Case<T> {
    let channels = [0.8, 1.0, 1.3].map(|c| kept::<T>(&image(side, |x, y| sky(x, y, c)), side, k_light));
    let light = &channels[1];
    let vertices = (0..SCENES).map(|seed| vertex(side, k_brdf, seed)).collect();
    Case {
        plan: TripleProduct::new(side).expect("a power of two"),
        light: Factor::new([light]).expect("a square"),
        rgb: Factor::new(channels.each_ref()).expect("squares"),
        light_tree: NgTree::new(light).expect("a square"),
        light_quadtree: Quadtree::new(light).expect("a square"),
        vertices,
    }
}

fn vertex<T: Real>(side: usize, k: usize, seed: usize) -> Vertex<T> {
    let brdf = kept::<T>(&image(side, lobe(seed)), side, k);
    let pixels = image(side, silhouette(seed));
    let mut rows = vec![0u64; BitPyramid::words_len(side)];
    pixels.iter().enumerate().for_each(|(i, &p)| rows[i / 64] |= (p as u64) << (i % 64));
    let visibility = kept::<T>(&pixels, side, side * side);
    let dense = visibility.to_dense();
    Vertex {
        brdf: Factor::new([&brdf]).expect("a square"),
        brdf_tree: NgTree::new(&brdf).expect("a square"),
        brdf_quadtree: Quadtree::new(&brdf).expect("a square"),
        sparse_brdf: brdf,
        bits: BitPyramid::from_rows(side, &rows).expect("a square"),
        rows,
        pixels,
        means: MeanTree::from_coefficients(side, [&dense]).expect("a square"),
        visibility_quadtree: Quadtree::new(&visibility).expect("a square"),
        visibility: dense,
    }
}

/// Times `f` over all vertices in turn; criterion's figure is for all of them.
fn bench_all<T>(c: &mut Criterion, name: &str, id: String, case: &Case<T>, mut f: impl FnMut(&Vertex<T>) -> f64) {
    c.benchmark_group(name)
        .throughput(Throughput::Elements(SCENES as u64))
        .bench_function(BenchmarkId::from_parameter(id), |b| {
            b.iter(|| case.vertices.iter().map(|v| f(black_box(v))).sum::<f64>())
        });
}

fn routes<T: Real>(c: &mut Criterion, side: usize, k: usize, scalar: &str) {
    let case = case::<T>(side, k, k);
    let group = format!("triple product {scalar} side {side} k {k}");
    let by =
        |route, v: Visibility<'_, T>, vertex: &Vertex<T>| case.plan.integral_by(route, &case.light, &vertex.brdf, v)[0];
    let mut run = |id: &str, f: &mut dyn FnMut(&Vertex<T>) -> f64| bench_all(c, &group, id.into(), &case, f);
    run("flat merge, means", &mut |v| by(Route::FlatMerge, Visibility::from(&v.means), v));
    run("flat merge, bits", &mut |v| by(Route::FlatMerge, Visibility::from(&v.bits), v));
    run("pixels, bits", &mut |v| by(Route::Pixels, Visibility::from(&v.bits), v));
    run("pixels, means", &mut |v| by(Route::Pixels, Visibility::from(&v.means), v));
    run("engine, bits", &mut |v| case.plan.integral(&case.light, &v.brdf, Visibility::from(&v.bits))[0]);
    run("engine, means", &mut |v| case.plan.integral(&case.light, &v.brdf, Visibility::from(&v.means))[0]);
    run("engine, RGB, bits", &mut |v| case.plan.integral(&case.rgb, &v.brdf, Visibility::from(&v.bits))[2]);
    run("Ng recursion", &mut |v| NgTripleProduct::integral(&case.light_tree, &v.brdf_tree, &v.visibility));
    let mut n_fold = NFoldProduct::new();
    run("N-fold", &mut |v| n_fold.integral(&[&case.light_quadtree, &v.brdf_quadtree, &v.visibility_quadtree]));
}

fn pieces(c: &mut Criterion) {
    let side = 64;
    let case = case::<f32>(side, 41, 41);
    let masked = MaskedSum::new();
    let [light] = case.light.morton_pixels();
    let mut run = |id: &str, f: &mut dyn FnMut(&Vertex<f32>) -> f64| {
        bench_all(c, "triple product pieces f32 side 64", id.into(), &case, f);
    };
    run("sum of L·B formed, masked", &mut |v| masked.sum(light, v.bits.words()));
    run("dot of L·V formed with B", &mut |v| masked.dot_unmasked(light, v.brdf.morton_pixels()[0]));
    let mut words = vec![0; BitPyramid::words_len(side)];
    run("row-major bits to Morton", &mut |v| {
        BitPyramid::morton_from_rows(side, &v.rows, &mut words);
        words[3] as f64
    });
    let mut upper = vec![[0.0; 4]; BitPyramid::upper_len(side)];
    run("means of 8x8 blocks and above", &mut |v| {
        BitPyramid::upper_from_words(side, v.bits.words(), &mut upper);
        upper[0][3].into()
    });
    run("factor of a sparse BRDF", &mut |v| Factor::new([&v.sparse_brdf]).expect("a square").means().mean(0, 0).into());
    let pixels: Vec<f64> = image(side, |x, y| sky(x, y, 1.0));
    run("naive twin", &mut |v| naive::product_integral(&[&pixels, &pixels, &v.pixels]));
}

/// One way to compute a vertex's integral.
type Rival<'a, T> = &'a mut dyn FnMut(&Vertex<T>) -> f64;

/// Nanoseconds an integral of each of some rivals: the lower quartile of interleaved runs, so that a busy machine slows
/// them all alike.
fn race<T>(case: &Case<T>, rivals: &mut [Rival<'_, T>]) -> Vec<f64> {
    let mut runs = vec![Vec::new(); rivals.len()];
    for _ in 0..80 {
        for (runs, f) in runs.iter_mut().zip(rivals.iter_mut()) {
            // Three times untimed, so that every rival meets the caches as it leaves them itself.
            for vertex in case.vertices.iter().chain(&case.vertices).chain(&case.vertices) {
                black_box(f(black_box(vertex)));
            }
            let start = Instant::now();
            for vertex in &case.vertices {
                black_box(f(black_box(vertex)));
            }
            runs.push(start.elapsed().as_secs_f64() * 1e9 / case.vertices.len() as f64);
        }
    }
    runs.iter_mut().for_each(|r| r.sort_by(f64::total_cmp));
    runs.iter().map(|r| r[r.len() / 4]).collect()
}

/// Engine against the better route, for k = 4 … 4096 at side 16 … 128.
fn sweep<T: Real>(scalar: &str) {
    let mut worst = 0.0f64;
    for side in [16, 32, 64, 128] {
        let mut k = 4;
        while k <= (side * side).min(4096) {
            let case = case::<T>(side, k, k);
            for bits in [true, false] {
                let by = |route, x: &Vertex<T>| {
                    let v = if bits { Visibility::from(&x.bits) } else { Visibility::from(&x.means) };
                    case.plan.integral_by(route, &case.light, &x.brdf, v)[0]
                };
                let times = race(
                    &case,
                    &mut [&mut |x| by(Route::FlatMerge, x), &mut |x| by(Route::Pixels, x), &mut |x| {
                        let v = if bits { Visibility::from(&x.bits) } else { Visibility::from(&x.means) };
                        case.plan.integral(&case.light, &x.brdf, v)[0]
                    }],
                );
                let loss = times[2] / times[0].min(times[1]);
                worst = worst.max(loss);
                let form = if bits { "bits" } else { "means" };
                eprintln!(
                    "{scalar} side {side:3} k {k:4} {form:5}: merge {:6.0} pixels {:6.0} engine {:6.0} ns, engine/better {loss:.2}",
                    times[0], times[1], times[2]
                );
            }
            k *= 2;
        }
    }
    eprintln!("{scalar}: worst engine/better {worst:.2}");
}

fn triple_product(c: &mut Criterion) {
    if std::env::var_os("TRIPLE_PRODUCT_SWEEP").is_some() {
        sweep::<f32>("f32");
        sweep::<f64>("f64");
        return;
    }
    for (side, k) in [(64, 41), (64, 123), (64, 410), (64, 1024), (16, 16), (32, 41), (128, 164)] {
        routes::<f32>(c, side, k, "f32");
    }
    routes::<f64>(c, 64, 41, "f64");
    pieces(c);
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    targets = triple_product
}
criterion_main!(benches);
