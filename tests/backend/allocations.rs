//! What allocates nothing after the first time: frames and lights of block products.
//!
//! Counted on the only thread of a pool, rayon's part in a frame included. With more threads the same code runs on each
//! of them, which is not counted. What remains is rayon's queue for calls from outside its pool: it takes a block of
//! memory from the caller once in 63 frames (seen with pools of 2 and 4 threads); calls from inside take none.

use std::sync::Arc;

use haarmonic::backend::block_product::{BlockAngle, BlockLayout, Relighter, Rule, SampleBasis, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    Brdf, CookTorrance, EnvironmentLight, Lambert, Materials, Model, Phong, Procedural, Sky, Sum, View,
    VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::{CubeGrid, CubeMap};

fn allocations(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

fn on_one_thread(test: impl FnOnce() + Send) {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(test);
}

/// Binary visibility and that of four bits, in blocks of 8².
fn transports(model: &Model) -> [Transport; 2] {
    let grid = CubeGrid::new(16).unwrap();
    let layout = BlockLayout::new(grid, 8, ScanOrder::Hilbert).unwrap();
    let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).unwrap();
    [
        Transport::bake(&baker, &layout, &()).unwrap(),
        Transport::bake_gray(&model.mesh, &baker, &layout, (2, 4), &()).unwrap(),
    ]
}

/// Lambert with Phong on the floor, GGX on what stands there.
fn materials(model: &Model) -> Materials {
    let terms: Vec<(f64, Arc<dyn Brdf>)> = vec![
        (0.6, Arc::new(Lambert::new([0.8, 0.4, 0.2]).unwrap())),
        (0.4, Arc::new(Phong::new([0.3, 0.4, 0.5], 60.0).unwrap())),
    ];
    let brdfs: Vec<Arc<dyn Brdf>> =
        vec![Arc::new(Sum::new(terms).unwrap()), Arc::new(CookTorrance::isotropic([0.9, 0.6, 0.3], 0.3).unwrap())];
    Materials::new(brdfs, model.by_part(&[0, 1])).unwrap()
}

fn light(transport: &Transport) -> CubeMap<Vector3<f32>> {
    EnvironmentLight::from_sky(Sky::default()).unwrap().to_cube(transport.layout().grid())
}

/// Four views, in turns of all vertices and of those of a picture.
fn frames(model: &Model, transport: &Transport, rule: Rule) {
    let materials = materials(model);
    let mut relighter =
        Relighter::new(&model.mesh, transport, Settings { rule, basis: SampleBasis::default() }).unwrap();
    relighter.set_light(&light(transport)).unwrap();
    let mut out = vec![Vector3::zeros(); model.mesh.positions().len()];
    let eye = View::eye(model.camera.eye().cast()).unwrap();
    let first = allocations(|| relighter.relight(&eye, &materials, &mut out).unwrap());
    assert!(first > 0, "plans of the materials are counted");
    relighter.relight_in_picture(&model.camera, 1.5, &materials, &mut out).unwrap();
    for k in 0..4 {
        let eye = View::eye(Vector3::new(3.0, 1.0 + k as f32, 5.0 - 3.0 * k as f32)).unwrap();
        let all = allocations(|| relighter.relight(&eye, &materials, &mut out).unwrap());
        assert!(out.iter().filter(|l| l.max() > 0.0).count() > out.len() / 4, "a frame shows something");
        let aspect = 0.5 + f64::from(k);
        let in_picture =
            allocations(|| relighter.relight_in_picture(&model.camera, aspect, &materials, &mut out).unwrap());
        assert!(out.iter().filter(|l| l.max() > 0.0).count() > out.len() / 8, "a picture shows something");
        assert_eq!((all, in_picture), (0, 0), "{rule:?}, frame {k}");
    }
}

#[test]
fn frames_allocate_nothing_once_the_materials_are_known() {
    on_one_thread(|| {
        let model = Procedural::TorusKnotOnFloor.build(1000).unwrap();
        for transport in transports(&model) {
            for rule in [Rule::default(), Rule::Fixed { angle: BlockAngle::Nearest }, Rule::Pixels] {
                frames(&model, &transport, rule);
            }
        }
    });
}

#[test]
fn lights_allocate_nothing_after_the_first() {
    on_one_thread(|| {
        let model = Procedural::TorusKnotOnFloor.build(1000).unwrap();
        let [transport, _] = transports(&model);
        let mut light = light(&transport);
        let mut made = None;
        let settings = Settings::default();
        let first = allocations(|| {
            let relighter = made.insert(Relighter::new(&model.mesh, &transport, settings).unwrap());
            relighter.set_light(&light).unwrap();
        });
        assert!(first > 10, "a relighter's tables are counted: {first}");
        let mut relighter = made.unwrap();
        for k in 0..3 {
            light.texels_mut().iter_mut().for_each(|texel| *texel *= 1.5);
            assert_eq!(allocations(|| relighter.set_light(&light).unwrap()), 0, "light {k}");
        }
    });
}
