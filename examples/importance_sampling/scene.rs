//! What is lit, by what, and what every pixel sees of it.

use std::sync::Arc;

use haarmonic::backend::near_field::{PlanarLight, ShadingPoint};
use haarmonic::io;
use haarmonic::nalgebra::{Unit, Vector3};
use haarmonic::scene::{
    Brdf, BrdfSpec, Bvh, Camera, Lambert, LocalFrame, Mesh, Occluders, Picture, PixelSample, Procedural,
};

use crate::args::Args;
use crate::support::Failure;
use crate::support::environment::{file_name, warn};

/// The scene as the command line describes it.
pub struct Scene {
    pub name: String,
    pub mesh: Mesh,
    /// Of the floor, and of what stands on it.
    pub brdfs: [Arc<dyn Brdf>; 2],
    pub light: PlanarLight,
    /// The frame that the light lies across.
    pub up: LocalFrame,
    pub occluders: Occluders,
    pub places: Vec<Option<Place>>,
}

/// What a pixel sees.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub point: ShadingPoint,
    /// Where shadow rays start.
    pub start: Vector3<f64>,
    /// Of [`Scene::brdfs`].
    pub brdf: usize,
}

impl Scene {
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let brdf = args.brdf.parse::<BrdfSpec>()?.build()?;
        let (name, mesh, camera, parts) = match &args.mesh {
            Some(path) => {
                let loaded = io::load_mesh(path)?;
                loaded.warnings.iter().for_each(warn);
                let camera = Camera::framing(&loaded.value, &Vector3::new(0.35, 0.4, 1.0), &Vector3::y(), 0.6, 1.0)?;
                let parts = vec![1; loaded.value.positions().len()];
                (file_name(path), loaded.value, camera, parts)
            }
            None => {
                let model = Procedural::TorusKnotOnFloor.build(args.vertices)?;
                let (eye, target) = (Vector3::new(2.0, 2.0, 6.6), Vector3::new(0.0, 1.05, 0.0));
                let camera = Camera::look_at(eye, target, Vector3::y(), 0.42)?;
                ("torus knot".to_owned(), model.mesh, camera, model.parts)
            }
        };
        let up = LocalFrame { tangent: Vector3::x(), bitangent: -Vector3::z(), normal: Vector3::y() };
        let light = lamp(&mesh, &parts)?;
        let bvh = Bvh::new(&mesh);
        let picture = Picture::new(&mesh, &bvh, &camera, [args.size; 2], 1)?;
        let at = |i: usize| place(&mesh, &parts, &picture.sample([i % args.size, i / args.size], 0));
        let places = (0..args.size * args.size).map(at).collect();
        let occluders = Occluders::of_mesh(&mesh);
        let brdfs = [Arc::new(Lambert::new([0.45, 0.43, 0.4])?) as Arc<dyn Brdf>, brdf];
        Ok(Self { name, mesh, brdfs, light, up, occluders, places })
    }

    /// Pixels that show the glossy object.
    pub fn glossy(&self) -> usize {
        self.places.iter().flatten().filter(|place| place.brdf == 1).count()
    }
}

/// A window of panes near the object, above it and to the right.
fn lamp(mesh: &Mesh, parts: &[u8]) -> Result<PlanarLight, Failure> {
    let object = mesh.positions().iter().zip(parts).filter(|(_, part)| **part > 0).map(|(p, _)| p.cast::<f64>());
    let (low, high) = object
        .fold((Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN)), |(low, high), p| (low.inf(&p), high.sup(&p)));
    let radius = 0.5 * (high - low).norm();
    let middle = 0.5 * (low + high);
    let centre = Vector3::new(middle.x + 0.25 * radius, high.y + 0.35 * radius, middle.z + 0.2 * radius);
    const SIDE: usize = 32;
    let panes = [
        [[16.0, 9.0, 3.0], [0.6, 0.8, 1.2], [5.0, 5.0, 5.0], [0.2, 0.2, 0.3]],
        [[1.0, 1.0, 1.0], [10.0, 12.0, 18.0], [0.3, 0.2, 0.1], [8.0, 2.0, 1.0]],
        [[3.0, 6.0, 2.0], [0.2, 0.3, 0.2], [20.0, 18.0, 12.0], [1.0, 1.0, 2.0]],
        [[0.5, 0.4, 0.3], [6.0, 3.0, 8.0], [0.8, 0.8, 0.8], [2.0, 9.0, 9.0_f32]],
    ];
    let texel = |i: usize| {
        let (x, y) = (i % SIDE, i / SIDE);
        // A dark bar between the panes.
        if x % 8 == 7 || y % 8 == 7 { Vector3::zeros() } else { Vector3::from(panes[y / 8][x / 8]) }
    };
    let texture = (0..SIDE * SIDE).map(texel).collect();
    Ok(PlanarLight::new(centre, [1.3 * radius, 1.0 * radius], SIDE, texture)?)
}

fn place(mesh: &Mesh, parts: &[u8], sample: &PixelSample) -> Option<Place> {
    let hit = sample.hit?;
    let corners = mesh.corners(hit.face as usize).map(|p| p.cast::<f64>());
    let flat = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.0)?;
    let normal = Unit::try_new(hit.interpolate(mesh, mesh.normals()).cast::<f64>(), 1e-9)?;
    let position = hit.interpolate(mesh, mesh.positions()).cast::<f64>();
    let wo = -sample.direction.into_inner();
    let flat = if flat.dot(&normal) < 0.0 { -flat } else { flat };
    let start = position + flat * (1e-4 * f64::from(hit.depth));
    let part = parts[mesh.faces()[hit.face as usize][0] as usize];
    let point = ShadingPoint { position, frame: LocalFrame::around(&normal), wo };
    (normal.dot(&wo) > 0.0).then_some(Place { point, start, brdf: usize::from(part > 0) })
}
