//! Nanoseconds a vertex of locally adaptive products against their own pixel baseline, one thread, 64² × 6 texels in
//! blocks of 16².
//!
//! Run with: cargo bench -p haarmonic-benches --bench block_product [-- WORDS]: jobs whose name holds all the words.

use std::hint::black_box;
use std::sync::Arc;

use haarmonic::backend::block_product::{
    BlockAngle, BlockLayout, LightForms, Relighter, Rule, SampleBasis, Settings, Transport,
};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    Brdf, BrdfFn, BrdfSpec, EnvironmentLight, Materials, Model, Procedural, Sky, View, VisibilityBaker,
    VisibilitySettings,
};
use haarmonic::sphere::{CubeGrid, CubeMap};
use haarmonic_benches::Jobs;

const VERTICES: usize = 6000;

/// The parts of the table scene: floor, table, chairs, railing, fruit.
const MATERIALS: [(&str, [&str; 5]); 8] = [
    ("diffuse", ["lambert:0.7"; 5]),
    ("exponent 10", ["lambert:0.7", "phong:10:0.3+lambert:0.4", "phong:10:0.3", "phong:10:0.3", "phong:10:0.3"]),
    (
        "exponents to 200",
        ["lambert:0.7", "phong:200:0.3+lambert:0.4", "phong:50:0.3+lambert:0.4", "phong:100:0.3", "phong:10:0.3"],
    ),
    (
        "Ward .15 .3",
        ["lambert:0.7", "ward:0.15:0.3:0.3", "ward:0.15:0.3:0.3", "ward:0.15:0.3:0.3", "ward:0.15:0.3:0.3"],
    ),
    ("Ward .2", ["lambert:0.7", "ward:0.2:0.2:0.3", "ward:0.2:0.2:0.3", "ward:0.2:0.2:0.3", "ward:0.2:0.2:0.3"]),
    ("Ward .4", ["lambert:0.7", "ward:0.4:0.4:0.3", "ward:0.4:0.4:0.3", "ward:0.4:0.4:0.3", "ward:0.4:0.4:0.3"]),
    ("GGX .2", ["lambert:0.7", "ggx:0.2", "ggx:0.2", "ggx:0.2", "ggx:0.2"]),
    ("GGX .4", ["lambert:0.7", "ggx:0.4", "ggx:0.4", "ggx:0.4", "ggx:0.4"]),
];

struct Stage {
    model: Model,
    transport: Transport,
    light: CubeMap<Vector3<f32>>,
}

fn stage() -> &'static Stage {
    let model = Procedural::Table.build(VERTICES).expect("a size in range");
    let transport = bake(&model);
    let grid = transport.layout().grid();
    let light = EnvironmentLight::from_sky(Sky::default()).expect("a default is allowed").to_cube(grid);
    // Jobs live as long as the program.
    Box::leak(Box::new(Stage { model, transport, light }))
}

fn bake(model: &Model) -> Transport {
    let grid = CubeGrid::new(64).expect("a side in range");
    let layout = BlockLayout::new(grid, 16, ScanOrder::Serpentine).expect("16 divides 64");
    let baker = VisibilityBaker::new(&model.mesh, grid, VisibilitySettings::default()).expect("a default is allowed");
    Transport::bake(&baker, &layout, &()).expect("nobody cancels")
}

fn materials(model: &Model, specs: [&str; 5]) -> Materials {
    let brdf = |spec: &str| -> Arc<dyn Brdf> {
        spec.parse::<BrdfSpec>().and_then(|spec| spec.build()).expect("the table's forms are right")
    };
    Materials::new(specs.map(brdf).to_vec(), model.parts.iter().map(|&p| u32::from(p)).collect()).expect("five parts")
}

/// Materials whose tables are made anew; a diffuse one has none, which is what the rest of a first frame costs.
fn first_frames() -> Vec<(&'static str, Arc<dyn Brdf>)> {
    let named = ["lambert:0.7", "phong:50", "ward:0.2", "ggx:0.2", "ggx:0.15:0.4"]
        .map(|spec| (spec, spec.parse::<BrdfSpec>().and_then(|spec| spec.build()).expect("a right form")));
    let glossy = |wi: &Vector3<f64>, wo: &Vector3<f64>| {
        let cosine = (wi.z * wo.z - wi.x * wo.x - wi.y * wo.y).max(0.0);
        Vector3::new(0.2, 0.1, 0.05) + Vector3::repeat(1.5 * cosine.powi(20))
    };
    let brushed = |wi: &Vector3<f64>, wo: &Vector3<f64>| {
        let h = (wi + wo).normalize();
        Vector3::repeat(0.05 + 0.6 * (-(h.x / 0.2).powi(2) - (h.y / 0.6).powi(2)).exp())
    };
    let closures: [(&str, Arc<dyn Brdf>); 2] =
        [("closure, isotropic", Arc::new(BrdfFn::new(glossy))), ("closure, brushed", Arc::new(BrdfFn::new(brushed)))];
    named.into_iter().chain(closures).collect()
}

fn main() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    one.expect("nobody built a pool before");
    let stage = stage();
    let view = View::eye(stage.model.camera.eye().cast()).expect("a finite eye");
    let mut jobs = Jobs::default();
    let mut forms = LightForms::new(stage.transport.layout(), SampleBasis::default()).expect("a layout");
    jobs.add("light", 1, move || forms.set(black_box(&stage.light)).expect("a finite light"));
    let vertices = stage.model.mesh.positions().len();
    for (name, specs) in MATERIALS {
        let materials = Arc::new(materials(&stage.model, specs));
        for (rule_name, rule) in [
            ("bounded", Rule::default()),
            ("fixed", Rule::Fixed { angle: BlockAngle::Nearest }),
            ("pixels", Rule::Pixels),
        ] {
            let settings = Settings { rule, ..Settings::default() };
            let mut relighter =
                Relighter::new(&stage.model.mesh, &stage.transport, settings).expect("one mesh throughout");
            relighter.set_light(&stage.light).expect("a finite light");
            let (materials, mut out) = (Arc::clone(&materials), vec![Vector3::zeros(); vertices]);
            jobs.add(format!("{name} {rule_name}"), vertices, move || {
                relighter.relight(&view, &materials, &mut out).expect("materials of this mesh");
                black_box(&mut out);
            });
        }
    }
    for (name, brdf) in first_frames() {
        let model = Procedural::Table.build(1000).expect("a size in range");
        let transport = bake(&model);
        let parts = model.parts.iter().map(|&p| u32::from(p)).collect();
        let materials = Materials::new(vec![brdf; 5], parts).expect("five parts");
        let mut out = vec![Vector3::zeros(); model.mesh.positions().len()];
        jobs.add(format!("first frame {name}"), 1, move || {
            let mut relighter =
                Relighter::new(&model.mesh, &transport, Settings::default()).expect("one mesh throughout");
            relighter.set_light(&stage.light).expect("a finite light");
            relighter.relight(&view, &materials, &mut out).expect("materials of this mesh");
        });
    }
    jobs.run();
}
