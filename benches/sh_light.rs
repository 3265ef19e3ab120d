//! Lights of spherical harmonics: shapes to coefficients, zonal functions about axes, irradiance, polygons.
//!
//! Times per light, axis, normal or polygon, after warming up.

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use haarmonic::nalgebra::Vector3;
use haarmonic::reference::sh as naive;
use haarmonic::sh::{Basis, DiffuseLight, Irradiance, Light, Lights, PolygonLight, Zonal};
use haarmonic::sphere::fibonacci_directions;

const BANDS: [usize; 4] = [3, 4, 6, 10];

/// A light from where it is.
type Make = fn(Vector3<f32>) -> Light<f32>;

fn directions(count: usize) -> [Vec<f32>; 3] {
    let all = fibonacci_directions(count);
    [0, 1, 2].map(|k| all.iter().map(|d| d[k] as f32).collect())
}

/// RGB, as DirectXMath's `XMSHEval…Light`.
fn shapes(c: &mut Criterion) {
    let mut group = c.benchmark_group("sh_light");
    let axes: Vec<Vector3<f32>> = fibonacci_directions(64).iter().map(|d| d.map(|c| c as f32)).collect();
    for bands in BANDS {
        let lights = Lights::<f32>::new(bands).unwrap();
        let mut out = [0; 3].map(|_| vec![0.0; bands * bands]);
        let makes: [(&str, Make); 3] = [
            ("directional", |direction| Light::Directional { direction }),
            ("cone", |axis| Light::Cone { axis, half_angle: 0.3 }),
            ("sphere", |d| Light::Sphere { centre: d * 3.0, radius: 1.0 }),
        ];
        for (name, make) in makes {
            group.bench_function(BenchmarkId::new(name, bands), |b| {
                let mut next = axes.iter().cycle();
                b.iter(|| {
                    let light = make(*next.next().unwrap());
                    let [r, g, b] = &mut out;
                    lights.eval(black_box(&light), [1.0, 0.5, 0.25], [r, g, b]);
                    black_box(&mut out);
                });
            });
        }
    }
}

fn zonal(c: &mut Criterion) {
    const COUNT: usize = 256;
    let mut group = c.benchmark_group("sh_zonal");
    let [x, y, z] = directions(COUNT);
    for bands in BANDS {
        let zonal = Zonal::<f32>::cap(bands, 0.3).unwrap();
        let basis = Basis::new(bands).unwrap();
        let mut out = vec![0.0; bands * bands * COUNT];
        let (one, rest) = out.split_at_mut(bands * bands);
        group.bench_function(BenchmarkId::new("about", bands), |b| {
            b.iter(|| zonal.about(&basis, black_box(&Vector3::new(0.6, 0.0, 0.8)), black_box(&mut *one)));
        });
        black_box(rest);
        group.throughput(Throughput::Elements(COUNT as u64));
        group.bench_function(BenchmarkId::new("about_batch", bands), |b| {
            b.iter(|| zonal.about_batch(&basis, [&x, &y, &z], black_box(&mut out)));
        });
    }
}

fn irradiance(c: &mut Criterion) {
    const COUNT: usize = 1024;
    let mut group = c.benchmark_group("sh_irradiance");
    group.throughput(Throughput::Elements(COUNT as u64));
    let [x, y, z] = directions(COUNT);
    let light: Vec<f32> = (0..27).map(|i| (i as f32).sin()).collect();
    let form = Irradiance::new([&light[..9], &light[9..18], &light[18..]]);
    let mut out = [0; 3].map(|_| vec![0.0f32; COUNT]);
    group.bench_function("rgb", |b| {
        b.iter(|| {
            let [r, g, b] = &mut out;
            form.eval_batch([&x, &y, &z], [r, g, b]);
            black_box(&mut out);
        });
    });
    let basis = Basis::<f32>::new(3).unwrap();
    group.bench_function("rgb_by_basis", |b| {
        b.iter(|| {
            for (out, light) in out.iter_mut().zip(light.chunks(9)) {
                basis.reconstruct(light, &x, &y, &z, out);
            }
            black_box(&mut out);
        });
    });
}

fn at_a_normal(c: &mut Criterion) {
    let mut group = c.benchmark_group("sh_diffuse_light");
    let normals: Vec<Vector3<f32>> = fibonacci_directions(64).iter().map(|d| d.map(|c| c as f32)).collect();
    for bands in [3, 4, 6] {
        let light: Vec<f32> = (0..bands * bands).map(|i| (i as f32).sin()).collect();
        let plan = DiffuseLight::new(&light, bands, bands).unwrap();
        let table = plan.table(32).unwrap();
        let (mut out, mut scratch) = (vec![0.0; bands * bands], vec![0.0; plan.scratch_len()]);
        group.bench_function(BenchmarkId::new("direct", bands), |b| {
            let mut next = normals.iter().cycle();
            b.iter(|| plan.eval(black_box(next.next().unwrap()), black_box(&mut out), &mut scratch));
        });
        group.bench_function(BenchmarkId::new("table", bands), |b| {
            let mut next = normals.iter().cycle();
            b.iter(|| table.lookup(black_box(next.next().unwrap()), black_box(&mut out)));
        });
    }
}

/// RGB through visibility at many normals: one call, and coefficients of a normal at a time with dot products.
fn at_many_normals(c: &mut Criterion) {
    const COUNT: usize = 256;
    let mut group = c.benchmark_group("sh_diffuse_light_batch");
    group.throughput(Throughput::Elements(COUNT as u64));
    let [x, y, z] = directions(COUNT);
    for bands in [3, 4, 6] {
        let size = bands * bands;
        let channels = [1, 2, 3].map(|channel| {
            let light: Vec<f32> = (0..size).map(|i| (i as f32 * channel as f32).sin()).collect();
            DiffuseLight::new(&light, bands, bands).unwrap()
        });
        let visibility: Vec<f32> = (0..size * COUNT).map(|i| (i as f32).cos()).collect();
        let mut out = [0; 3].map(|_| vec![0.0f32; COUNT]);
        let (mut many, mut scratch) = (vec![0.0; size * COUNT], vec![0.0; channels[0].batch_scratch_len()]);
        group.bench_function(BenchmarkId::new("eval", bands), |b| {
            b.iter(|| channels[0].eval_batch([black_box(&x), &y, &z], &mut many, &mut scratch));
        });
        group.bench_function(BenchmarkId::new("integral_rgb", bands), |b| {
            b.iter(|| {
                let [r, g, b] = &mut out;
                let all = channels.each_ref();
                DiffuseLight::integral_batch(all, [black_box(&x), &y, &z], &visibility, [r, g, b], &mut scratch);
            });
        });
        let (mut one, mut scratch) = (vec![0.0; size], vec![0.0; channels[0].scratch_len()]);
        group.bench_function(BenchmarkId::new("integral_rgb_one_by_one", bands), |b| {
            b.iter(|| {
                for v in 0..COUNT {
                    for (channel, out) in channels.iter().zip(&mut out) {
                        channel.eval(black_box(&Vector3::new(x[v], y[v], z[v])), &mut one, &mut scratch);
                        out[v] = one.iter().enumerate().map(|(i, l)| l * visibility[i * COUNT + v]).sum();
                    }
                }
            });
        });
    }
}

/// A regular polygon before the point, and its naive twin.
fn polygon(c: &mut Criterion) {
    let mut group = c.benchmark_group("sh_polygon");
    for (vertices, size) in [(3, 0.6), (4, 0.6), (8, 0.6), (4, 0.02)] {
        let polygon: Vec<Vector3<f64>> = (0..vertices)
            .map(|i| {
                let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(vertices)).sin_cos();
                Vector3::new(0.3 + size * cos, -0.2 + size * sin, 1.0)
            })
            .collect();
        for bands in [3, 4, 6, 10, 16] {
            let plan = PolygonLight::new(bands).unwrap();
            let (mut out, mut scratch) = (vec![0.0; bands * bands], plan.scratch());
            let name = format!("{vertices}_vertices{}", if size < 0.1 { "_small" } else { "" });
            group.bench_function(BenchmarkId::new(name, bands), |b| {
                b.iter(|| plan.eval(black_box(&polygon), None, black_box(&mut out), &mut scratch));
            });
        }
    }
    let quad = [(0.9, -0.2), (0.3, 0.4), (-0.3, -0.2), (0.3, -0.8)].map(|(x, y)| Vector3::new(x, y, 1.0));
    group.sample_size(10);
    group.bench_function(BenchmarkId::new("naive", 6), |b| b.iter(|| naive::polygon(6, black_box(&quad), None, 0)));
}

criterion_group!(benches, shapes, zonal, irradiance, at_a_normal, at_many_normals, polygon);
criterion_main!(benches);
