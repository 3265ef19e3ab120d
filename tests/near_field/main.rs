//! Near-field relighting: lights on their own, frames against the twin and the truth, gradients, files.
#![cfg(all(feature = "near_field", feature = "reference", feature = "proptest"))]

mod file;
mod frames;
mod gradient;
mod importance_sampling;
mod light;
#[path = "../support/mod.rs"]
mod support;

use std::sync::Arc;

use haarmonic::backend::near_field::{BakeSettings, PlanarLight, Precision, Transport};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Brdf, CookTorrance, Lambert, Materials, Mesh, Model, Occluders, Phong, Procedural, Sum, View};

use support::Stream;

/// Everything kept, on 16² cells.
pub fn exact() -> BakeSettings {
    BakeSettings { cells: 16, samples: 1, tolerance: 0.0, precision: Precision::Full, ..BakeSettings::default() }
}

/// A floor with spheres: two colours, one of them a lobe; or a mixture without a colour.
pub fn materials(model: &Model, mixed: bool) -> Materials {
    let lobe: Arc<dyn Brdf> = match mixed {
        false => Arc::new(Phong::new([0.2, 0.7, 0.4], 9.0).unwrap()),
        true => Arc::new(
            Sum::new(vec![
                (0.5, Arc::new(Lambert::new([0.9, 0.2, 0.1]).unwrap()) as Arc<dyn Brdf>),
                (0.5, Arc::new(CookTorrance::isotropic([0.3, 0.5, 0.9], 0.5).unwrap())),
            ])
            .unwrap(),
        ),
    };
    let parts = model.parts.iter().map(|&part| u32::from(part > 0)).collect();
    Materials::new(vec![Arc::new(Lambert::new([0.5, 0.6, 0.7]).unwrap()), lobe], parts).unwrap()
}

/// Spheres on a floor.
pub fn model() -> Model {
    Procedural::StackedSpheres.build(1000).unwrap()
}

/// What a mesh sees of itself.
pub fn bake(mesh: &Mesh, view: &View, materials: &Materials, settings: BakeSettings) -> Transport {
    Transport::bake(mesh, Occluders::of_mesh(mesh), view, materials, settings, &()).unwrap()
}

/// A lamp of `side`² noisy texels, above and beside the middle.
pub fn lamp(side: usize, seed: u64) -> PlanarLight {
    let mut stream = Stream::new(seed);
    let texture = (0..side * side).map(|_| Vector3::from_fn(|_, _| stream.unit() as f32)).collect();
    PlanarLight::new(Vector3::new(0.4, 3.5, -0.3), [2.5, 1.7], side, texture).unwrap()
}
