//! Importance sampling of a near light: what it costs to prepare a point, and a sample.
//!
//! A panel of 32² texels in 64² coefficients above a glossy floor; times are for one point, 64 of them in turn, or for
//! one sample. The twin is the density of the same cells from the definition, in f64.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use haarmonic::backend::near_field::{
    BrdfScratch, BrdfTable, DirectionSampler, LightSampler, LightWeight, PlanarLight, ProductSampler, ProductSettings,
    Reflection, ShadingPoint, Window,
};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::{Unit, Vector3};
use haarmonic::reference::backend::near_field_sampling::{Light, product_density};
use haarmonic::scene::{Brdf, LocalFrame, Phong};

const POINTS: usize = 64;

fn up() -> LocalFrame {
    LocalFrame { tangent: Vector3::x(), bitangent: -Vector3::z(), normal: Vector3::y() }
}

fn panel() -> PlanarLight {
    let texel = |i: usize| Vector3::new((i % 7) as f32, (i % 32 / 8) as f32, (i / 256) as f32);
    let texture = (0..32 * 32).map(texel).collect();
    PlanarLight::new(Vector3::new(0.1, 1.0, 0.0), [1.2, 0.9], 32, texture).expect("a panel")
}

fn points() -> Vec<ShadingPoint> {
    let point = |i: usize| {
        let (at, turn) = (i as f64 / POINTS as f64, i as f64 * 0.618 * TAU);
        let normal = Unit::new_normalize(Vector3::new(0.5 * turn.cos(), 1.0, 0.5 * turn.sin()));
        let wo = Vector3::new(0.6 * at.cos(), 0.8, 0.6 * at.sin());
        ShadingPoint { position: Vector3::new(at - 0.5, 0.0, 0.3 * at), frame: LocalFrame::around(&normal), wo }
    };
    (0..POINTS).map(point).collect()
}

fn prepare(criterion: &mut Criterion) {
    let (light, points) = (panel(), points());
    let brdf = Phong::new([0.9, 0.7, 0.3], 50.0).expect("a lobe");
    let table = BrdfTable::new(&brdf, 32, 64).expect("a table");
    let mut group = criterion.benchmark_group("importance sampling, a point");
    let mut next = 0;
    let mut turn = move || {
        next = (next + 1) % POINTS;
        next
    };
    let whole = ProductSettings::default();
    let settings = [
        ("product, window on the light", whole),
        ("product, whole face", ProductSettings { window: Window::Face, ..whole }),
        ("product, whole face, 1 %", ProductSettings { window: Window::Face, keep: Keep::Fraction(0.01), ..whole }),
        ("product, window on the light, 32²", ProductSettings { side: 32, ..whole }),
    ];
    for (name, settings) in settings {
        let sampler = ProductSampler::new(&light, &up(), settings).expect("a sampler");
        let mut scratch = sampler.scratch();
        group.bench_function(name, |b| {
            b.iter(|| sampler.density(black_box(&points[turn()]), &table, &mut scratch).share())
        });
    }
    let mut scratch = BrdfScratch::new();
    group.bench_function("BRDF", |b| b.iter(|| table.density(black_box(&points[turn()]), &mut scratch).is_empty()));
    group.sample_size(10);
    let cells: Vec<f64> = light.texture().iter().map(|l| f64::from(l.norm())).collect();
    group.bench_function("twin, whole face", |b| {
        b.iter(|| {
            let point = &points[turn()];
            let to = up().to_local(&(light.centre() - point.position));
            let twin = Light { side: 32, cells: &cells, extent: light.size(), centre: to.into() };
            let wo = point.frame.to_local(&point.wo);
            product_density(&twin, [[-5.0; 2], [5.0; 2]], 64, |direction| {
                let wi = point.frame.to_local(&up().to_world(direction));
                if wi.z > 0.0 { brdf.eval(&wi, &wo).norm() * wi.z } else { 0.0 }
            })
        });
    });
    group.finish();
}

fn sample(criterion: &mut Criterion) {
    let (light, point) = (panel(), points()[0]);
    let brdf = Phong::new([0.9, 0.7, 0.3], 50.0).expect("a lobe");
    let table = BrdfTable::new(&brdf, 32, 64).expect("a table");
    let sampler = ProductSampler::new(&light, &up(), ProductSettings::default()).expect("a sampler");
    let area = LightSampler::new(&light, &up(), LightWeight::Area).expect("a light");
    let (mut scratch, mut brdf_scratch) = (sampler.scratch(), BrdfScratch::new());
    let by_brdf = table.density(&point, &mut brdf_scratch);
    let product = sampler.density(&point, &table, &mut scratch);
    let (by_area, by_radiance) = (area.density(&point.position), sampler.light().density(&point.position));
    let all: [(&str, &dyn DirectionSampler); 5] = [
        ("light, by area", &by_area),
        ("light, by radiance", &by_radiance),
        ("BRDF", &by_brdf),
        ("product alone", product.first()),
        ("product with light sampling", &product),
    ];
    let mut number = 0.0_f64;
    let mut numbers = move || {
        number = (number + 0.618_033_988_749).fract();
        [number, (number * 97.0).fract()]
    };
    let mut group = criterion.benchmark_group("importance sampling, a sample");
    for (name, sampler) in all {
        group.bench_function(name, |b| b.iter(|| sampler.sample(black_box(numbers()))));
    }
    let reflection = Reflection { light: sampler.light(), brdf: &brdf, point, occluders: None, start: point.position };
    group.bench_function("product, estimate of 8", |b| {
        b.iter(|| reflection.estimate(&product, (0..8).map(|_| black_box(numbers()))));
    });
    group.finish();
}

criterion_group!(benches, prepare, sample);
criterion_main!(benches);
