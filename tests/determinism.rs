//! The same bits for any number of threads, and without threads.
//!
//! The hashes of what a small scene gives are compared between pools of 1, 2 and 5 threads; the build without feature
//! `rayon` runs the same code once and compares with the hashes that a build with threads wrote next to its test
//! binary, if there is one.
#![cfg(feature = "backends")]

use std::hash::{DefaultHasher, Hash, Hasher};

use haarmonic::backend::near_field as near;
use haarmonic::backend::wavelet_double as double;
use haarmonic::backend::wavelet_triple::{self as triple, Slices};
use haarmonic::haar::{Keep, Weighting};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    EnvironmentLight, GroundTruth, Materials, Mesh, Occluders, Phong, Procedural, Sky, TexelVisibility, View,
    VisibilityBaker, VisibilitySettings,
};
use haarmonic::sh::{
    CubeProjection, CubeReconstruction, LatLongProjection, LatLongReconstruction, TexelRule, monte_carlo,
};
use haarmonic::sphere::{CubeGrid, CubeMap, LatLongGrid, LatLongMap};

fn hash(values: impl IntoIterator<Item = u64>) -> u64 {
    let mut hasher = DefaultHasher::new();
    values.into_iter().for_each(|v| v.hash(&mut hasher));
    hasher.finish()
}

fn bits(radiance: &[Vector3<f32>]) -> u64 {
    hash(radiance.iter().flat_map(|l| l.iter().map(|c| u64::from(c.to_bits())).collect::<Vec<_>>()))
}

/// Spherical harmonics: maps to coefficients and back, Monte Carlo.
fn harmonics() -> u64 {
    let colour = |d: &Vector3<f64>| d.map(|c| (3.0 * c).exp() as f32);
    let (cube, lat_long) = (CubeGrid::new(19).unwrap(), LatLongGrid::new(50, 23).unwrap());
    let mut all: Vec<u64> = Vec::new();
    for rule in [TexelRule::Centre, TexelRule::Mean] {
        let map = CubeMap::from_fn(cube, |d| colour(&d));
        let c = CubeProjection::new(cube, 6, rule).unwrap().project(&map);
        let refs = c.each_ref().map(|c| &c[..]);
        let back: CubeMap<Vector3<f32>> = CubeReconstruction::new(cube, 6, rule).unwrap().reconstruct(refs);
        let map = LatLongMap::from_fn(lat_long, |d| colour(&d));
        let d = LatLongProjection::new(lat_long, 6, rule).unwrap().project(&map);
        let refs = d.each_ref().map(|c| &c[..]);
        let other: LatLongMap<Vector3<f32>> = LatLongReconstruction::new(lat_long, 6, rule).unwrap().reconstruct(refs);
        all.extend(c.iter().chain(&d).flatten().map(|c| u64::from(c.to_bits())));
        all.extend([bits(back.texels()), bits(other.pixels())]);
    }
    let estimate = monte_carlo(5, 1000, 3, |d| [d.x.max(0.0)]).unwrap();
    all.extend(estimate.coefficients.iter().chain(&estimate.errors).flatten().map(|c| c.to_bits()));
    hash(all)
}

/// Light, visibility, ground truth, double product, triple product sampled and tabulated, harmonics, near light.
fn hashes() -> [u64; 8] {
    let model = Procedural::TorusKnotOnFloor.build(1000).unwrap();
    let grid = CubeGrid::new(16).unwrap();
    let materials = Materials::uniform(Phong::new([0.7, 0.5, 0.3], 15.0).unwrap());
    let view = View::eye(model.camera.eye().cast()).unwrap();
    let light = EnvironmentLight::from_sky(Sky::default()).unwrap().to_cube(grid);
    let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).unwrap();
    let visibility = baker.bake(&()).unwrap();
    let truth = GroundTruth { mesh: &model.mesh, materials: &materials, view: &view, light: &light };
    let truth = truth.radiance(&TexelVisibility::Binary(&visibility), &()).unwrap();
    let mut out = vec![Vector3::zeros(); truth.len()];

    let double =
        double::Transport::bake(&model.mesh, &visibility, &view, &materials, double::BakeSettings::default(), &());
    let double = double.unwrap();
    let settings = double::Settings { light_terms: Keep::Fraction(0.05), weighting: Weighting::Area };
    let mut relighter = double::Relighter::new(&double, settings).unwrap();
    relighter.set_light(&light).unwrap();
    relighter.relight(&view, &materials, &mut out).unwrap();
    let by_double = bits(&out);

    let transport = triple::Transport::from_binary(visibility.clone()).unwrap();
    let triple = [Slices::Sampled, Slices::Tabulated(8)].map(|slices| {
        let settings = triple::Settings { slices, ..triple::Settings::default() };
        let mut relighter = triple::Relighter::new(&model.mesh, &transport, settings).unwrap();
        relighter.set_light(&light).unwrap();
        relighter.relight(&view, &materials, &mut out).unwrap();
        bits(&out)
    });
    let truth = hash(truth.iter().flat_map(|l| l.iter().map(|c| c.to_bits()).collect::<Vec<_>>()));
    [
        bits(light.texels()),
        hash(visibility.words().iter().copied()),
        truth,
        by_double,
        triple[0],
        triple[1],
        harmonics(),
        near_light(&model.mesh, &materials, &view),
    ]
}

/// A turned lamp near the scene by wavelets and by pixels, and the gradient in it.
fn near_light(mesh: &Mesh, materials: &Materials, view: &View) -> u64 {
    let settings = near::BakeSettings { cells: 8, samples: 2, ..near::BakeSettings::default() };
    let transport = near::Transport::bake(mesh, Occluders::of_mesh(mesh), view, materials, settings, &()).unwrap();
    let texture = (0..16).map(|i| Vector3::new(i as f32, 1.0, 0.1 * i as f32)).collect();
    let lamp = near::PlanarLight::new(Vector3::new(0.3, 3.0, 0.1), [2.0, 1.0], 4, texture).unwrap();
    let lamp = lamp.with_rotation(0.4).unwrap();
    let mut all = Vec::new();
    for route in [near::Route::Couplings, near::Route::Pixels] {
        let settings = near::Settings { source_side: 8, route, ..near::Settings::default() };
        let mut relighter = near::Relighter::new(&transport, settings).unwrap();
        relighter.set_lights(std::slice::from_ref(&lamp)).unwrap();
        let mut out = vec![Vector3::zeros(); mesh.positions().len()];
        relighter.relight(&mut out);
        let gradient = relighter.gradient(0, &lamp, &out).unwrap();
        all.push(bits(&out));
        all.extend(gradient.centre.iter().chain(&gradient.size).map(|x| x.to_bits()));
    }
    hash(all)
}

/// Where the build with threads leaves its hashes for the build without.
fn record() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("determinism.hashes")
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(hashes);
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
    std::fs::write(record(), format!("{one:?}")).unwrap();
}

#[cfg(not(feature = "rayon"))]
#[test]
#[expect(clippy::print_stderr, reason = "a skipped comparison must be seen")]
fn no_threads_give_the_same_bits() {
    let alone = hashes();
    assert_eq!(alone, hashes());
    match std::fs::read_to_string(record()) {
        Ok(threaded) => assert_eq!(threaded, format!("{alone:?}")),
        Err(_) => eprintln!("skipped: run the tests with feature rayon first to compare with threads"),
    }
}
