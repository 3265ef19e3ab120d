//! ∫ L B V over one square: routes × kept terms × side, the naive twin, and the engine against the better route.
//!
//! Light: a gradient sky with a sun and two boxes, the same for all; BRDFs and visibilities: 32 lobes and 32 silhouettes, taken
//! in turn, as a renderer does from vertex to vertex. Times are per integral. `TRIPLE_PRODUCT_SWEEP=1` prints the engine's table.

use std::hint::black_box;
use std::time::Instant;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use haarmonic::Real;
use haarmonic::haar::{
    BitPyramid, Decomposition, Factor, MaskedSum, MeanTree, NFoldProduct, NgTree, NgTripleProduct, Quadtree, Route,
    SparseVector, TripleProduct, Visibility, forward_2d, rows_to_morton, upper_means,
};
use haarmonic::reference::haar as naive;

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
    brdf: Factor<T>,
    brdf_tree: NgTree<T>,
    brdf_quadtree: Quadtree<T>,
    rows: Vec<u64>,
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
        bits: BitPyramid::from_rows(side, &rows).expect("a square"),
        rows,
        means: MeanTree::from_coefficients(side, [&dense]).expect("a square"),
        visibility_quadtree: Quadtree::new(&visibility).expect("a square"),
        visibility: dense,
    }
}

/// Nanoseconds an integral, the median of some runs over all vertices.
fn time<T>(case: &Case<T>, mut f: impl FnMut(&Vertex<T>) -> f64) -> f64 {
    let mut runs: Vec<f64> = (0..25)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..8 {
                for vertex in &case.vertices {
                    black_box(f(black_box(vertex)));
                }
            }
            start.elapsed().as_secs_f64() * 1e9 / (8 * case.vertices.len()) as f64
        })
        .collect();
    runs.sort_by(f64::total_cmp);
    runs[runs.len() / 2]
}
