//! A BRDF as a sum of eight products on 16² directions of light and of view: this crate, from the BRDF to both tables,
//! and faer's thin singular value decomposition of the same 256 × 768 matrix, which is given its values.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use faer::Mat;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Brdf, FactoredBrdf, Phong};
use haarmonic::sphere::ConcentricSquare;

const CELLS: usize = 16;

fn factored(c: &mut Criterion) {
    let brdf = Phong::new([0.8, 0.6, 0.4], 10.0).unwrap();
    let directions: Vec<Vector3<f64>> =
        (0..CELLS * CELLS).map(|i| ConcentricSquare::cell_direction(CELLS, i).into_inner()).collect();
    let matrix = Mat::from_fn(CELLS * CELLS, 3 * CELLS * CELLS, |o, i| {
        let (wi, wo) = (directions[i / 3], directions[o]);
        brdf.eval(&wi, &wo)[i % 3] * (wi.z * wo.z).sqrt()
    });
    let mut group = c.benchmark_group("factored_brdf");
    group.sample_size(10);
    group.bench_function("haarmonic", |b| b.iter(|| FactoredBrdf::new(black_box(&brdf), CELLS, 8).unwrap()));
    group.bench_function("faer_thin_svd", |b| b.iter(|| black_box(&matrix).thin_svd().unwrap()));
    group.finish();
    // Both leave out the same.
    let svd = matrix.thin_svd().unwrap();
    let squares = |from: usize| (from..CELLS * CELLS).map(|k| svd.S()[k] * svd.S()[k]).sum::<f64>();
    let rest = (squares(8) / squares(0)).sqrt();
    let ours = FactoredBrdf::new(&brdf, CELLS, 8).unwrap().errors()[7];
    assert!((rest - ours).abs() < 1e-9, "{rest} {ours}");
}

criterion_group!(benches, factored);
criterion_main!(benches);
