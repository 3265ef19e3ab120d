//! ∫∫ F(s x + o) G(x) W(x) of sparse signals: the wavelet domain, by both routes, against the honest pixel route
//! (decode G and W, resample F exactly by a summed-area table, multiply and add).
//!
//! Light: a gradient, a bright disk and two boxes; 32 lobes, silhouettes and maps are taken in turn, as a renderer does
//! from vertex to vertex. Times are per integral. F's own table is made once, for every method.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use haarmonic::affine::{AffineMap, AffineProduct2d, ProductRoute};
use haarmonic::haar::{Decomposition, Quadtree, SparseVector, Transform2d, forward_2d};

const SCENES: usize = 32;

fn image(side: usize, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let centre = |i: usize| (i as f64 + 0.5) / side as f64;
    (0..side * side).map(|i| f(centre(i % side), centre(i / side))).collect()
}

fn light(x: f64, y: f64) -> f64 {
    let disk = if (x - 0.7).hypot(y - 0.2) < 0.06 { 40.0 } else { 0.0 };
    let boxed = |x0: f64, y0: f64| if (x - x0).abs() < 0.11 && (y - y0).abs() < 0.07 { 6.0 } else { 0.0 };
    0.3 + (1.0 - y) + disk + boxed(0.2, 0.4) + boxed(0.5, 0.8) + 0.2 * (17.0 * x).sin() * (23.0 * y).cos()
}

fn lobe(n: usize) -> impl Fn(f64, f64) -> f64 {
    let (cx, cy) = (0.5 + 0.4 * (n as f64 * 2.4).cos(), 0.5 + 0.4 * (n as f64 * 1.7).sin());
    let width = 0.1 + 0.03 * (n % 7) as f64;
    move |x, y| (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * width * width)).exp() + 0.1 * (1.0 - y)
}

fn silhouette(n: usize) -> impl Fn(f64, f64) -> f64 {
    let n = n as f64;
    let (ax, ay, r) = (0.3 + 0.2 * (n * 1.3).sin(), 0.4 + 0.2 * (n * 0.7).cos(), 0.15 + 0.1 * (n * 3.1).sin().abs());
    move |x, y| f64::from(u8::from(y < 0.75 + 0.3 * (n * 0.9).sin() * (x - 0.5) && (x - ax).hypot(y - ay) > r))
}

/// The k largest coefficients by magnitude.
fn kept(pixels: &[f64], side: usize, k: usize) -> SparseVector<f64> {
    let c = forward_2d(pixels, side, side, Decomposition::Nonstandard).expect("a power of two");
    let mut order: Vec<usize> = (0..c.len()).filter(|&i| c[i] != 0.0).collect();
    order.sort_by(|&i, &j| c[j].abs().total_cmp(&c[i].abs()));
    order.truncate(k);
    SparseVector::from_pairs(c.len(), order.into_iter().map(|i| (i, c[i]))).expect("indices are below the length")
}

struct Vertex {
    factors: [SparseVector<f64>; 2],
    trees: [Quadtree<f64>; 2],
    maps: [AffineMap; 2],
}

struct Case {
    side: usize,
    plan: AffineProduct2d,
    sat: Vec<f64>,
    vertices: Vec<Vertex>,
}

impl Case {
    fn new(side: usize, percent: usize) -> Self {
        let k = (side * side * percent).div_ceil(100);
        let f = kept(&image(side, light), side, k);
        let mut pixels = vec![0.0; side * side];
        let transform = Transform2d::new(side, side, Decomposition::Nonstandard).expect("a power of two");
        transform.inverse(&f.to_dense(), &mut pixels, &mut vec![0.0; transform.scratch_len()]);
        let stride = side + 1;
        let mut sat = vec![0.0; stride * stride];
        for y in 0..side {
            let mut row = 0.0;
            for x in 0..side {
                row += pixels[y * side + x];
                sat[(y + 1) * stride + x + 1] = sat[y * stride + x + 1] + row;
            }
        }
        let vertex = |n: usize| {
            let factors = [kept(&image(side, lobe(n)), side, k), kept(&image(side, silhouette(n)), side, k)];
            let trees = [0, 1].map(|m| Quadtree::new(&factors[m]).expect("a square"));
            let (s, o) = (0.4 + 1.6 * (n as f64 * 0.618).fract(), -0.5 * (n as f64 * 0.414).fract());
            Vertex { factors, trees, maps: [s, 1.1 * s].map(|s| AffineMap::new(s, o).expect("in range")) }
        };
        let vertices = (0..SCENES).map(vertex).collect();
        Self { side, plan: AffineProduct2d::new([&f]).expect("a square"), sat, vertices }
    }
}

/// The pixel route's plan and buffers.
struct Pixels {
    transform: Transform2d<f64>,
    dense: Vec<f64>,
    images: [Vec<f64>; 2],
    scratch: Vec<f64>,
    rows: Vec<f64>,
}

impl Pixels {
    fn new(side: usize) -> Self {
        let transform = Transform2d::new(side, side, Decomposition::Nonstandard).expect("a power of two");
        let image = || vec![0.0; side * side];
        let scratch = vec![0.0; transform.scratch_len()];
        Self { transform, dense: image(), images: [image(), image()], scratch, rows: vec![0.0; side + 1] }
    }

    fn integral(&mut self, case: &Case, vertex: &Vertex) -> f64 {
        let (side, stride) = (case.side, case.side + 1);
        for (factor, image) in vertex.factors.iter().zip(&mut self.images) {
            self.dense.fill(0.0);
            factor.iter().for_each(|(i, value)| self.dense[i] = value);
            self.transform.inverse(&self.dense, image, &mut self.scratch);
        }
        // The summed-area table at the corners of the target's texels, one row of corners after another.
        let place = |map: AffineMap, k: usize| {
            let x = map.apply(k as f64 / side as f64).clamp(0.0, 1.0) * side as f64;
            let cell = (x as usize).min(side - 1);
            (cell, x - cell as f64)
        };
        let mut columns = [(0, 0.0); 65];
        (0..stride).for_each(|k| columns[k] = place(vertex.maps[0], k));
        let mut sum = 0.0;
        self.rows.fill(0.0);
        for y in 0..stride {
            let (row, v) = place(vertex.maps[1], y);
            let (above, below) = (&case.sat[row * stride..][..stride], &case.sat[(row + 1) * stride..][..stride]);
            let at = |(cell, u): (usize, f64)| {
                let (top, low) = (
                    above[cell] + u * (above[cell + 1] - above[cell]),
                    below[cell] + u * (below[cell + 1] - below[cell]),
                );
                top + v * (low - top)
            };
            let mut left = 0.0;
            for x in 0..stride {
                let corner = at(columns[x]);
                let difference = corner - self.rows[x];
                self.rows[x] = corner;
                if x > 0 && y > 0 {
                    let texel = (y - 1) * side + x - 1;
                    sum += (difference - left) * self.images[0][texel] * self.images[1][texel];
                }
                left = difference;
            }
        }
        let area = vertex.maps[0].scale() * vertex.maps[1].scale() * (side * side) as f64;
        sum / area
    }
}

fn bench(c: &mut Criterion) {
    for side in [32, 64] {
        let mut group = c.benchmark_group(format!("affine triple product/{side}"));
        for percent in [1, 10] {
            let case = Case::new(side, percent);
            let mut pixels = Pixels::new(side);
            for v in &case.vertices {
                let want = pixels.integral(&case, v);
                for route in [ProductRoute::Primitive, ProductRoute::Terms] {
                    let [got] = case.plan.integral_by(route, v.trees.each_ref(), v.maps);
                    assert!((got - want).abs() < 1e-10 * want.abs().max(1.0), "{route:?}: {got} {want}");
                }
            }
            let mut run = |name: &str, integral: &mut dyn FnMut(&Vertex) -> f64| {
                let mut n = 0;
                group.bench_function(BenchmarkId::new(name, format!("{percent}%")), |b| {
                    b.iter(|| {
                        n = (n + 1) % SCENES;
                        black_box(integral(&case.vertices[n]))
                    });
                });
            };
            run("pixels", &mut |v| pixels.integral(&case, v));
            run("primitive", &mut |v| case.plan.integral_by(ProductRoute::Primitive, v.trees.each_ref(), v.maps)[0]);
            run("primitive, trees built", &mut |v| {
                let trees = v.factors.each_ref().map(|f| Quadtree::new(f).expect("a square"));
                case.plan.integral_by(ProductRoute::Primitive, trees.each_ref(), v.maps)[0]
            });
            run("terms", &mut |v| case.plan.integral_by(ProductRoute::Terms, v.trees.each_ref(), v.maps)[0]);
            run("gradient", &mut |v| case.plan.gradient(v.trees.each_ref(), v.maps).value[0]);
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1)).sample_size(30);
    targets = bench
}
criterion_main!(benches);
