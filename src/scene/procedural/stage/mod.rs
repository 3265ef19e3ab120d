//! Scenes of objects that move against each other, with lamps.

mod figure;
mod kitchen;
mod robot;
mod street;
mod temple;

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};

use super::builder::Builder;
use super::spacing_for;
use crate::scene::{Bvh, Camera, LocalLight, Mesh, Occluders};
use crate::{Error, Result};

/// The built-in scenes of several objects: for methods that move them, turn lamps on, or fill the air with fog.
///
/// Metres; y points up, the ground is y = 0. Objects are closed, with outward counter-clockwise faces, smooth normals
/// on smooth surfaces and split vertices at hard edges; the ground is an open sheet with a skirt.
///
/// # Example
/// ```
/// use haarmonic::scene::Stage;
/// let scene = Stage::Robot.build(8_000, 0.25)?;
/// assert_eq!(scene.objects.len(), 13); // twelve parts and the ground
/// let occluders = scene.occluders()?;
/// assert!(occluders.any_hit(&nalgebra::Vector3::new(0.0, 9.0, 0.0), &-nalgebra::Vector3::y()));
/// # use haarmonic::nalgebra;
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stage {
    /// A robot of twelve rigid parts that walks on the spot.
    Robot,
    /// A kitchen table with a pot, a mug, a plate and an apple on it, under a lamp with a pattern.
    KitchenTable,
    /// A street between houses, with three pairs of lamps.
    Street,
    /// A figure of ten bones with sixty spheres on them that walks on the spot.
    WalkingFigure,
    /// Sixteen such figures, each at its own step.
    Crowd,
    /// A temple of flat faces: steps, square columns and a slab for a roof.
    Temple,
}

/// A scene of several objects.
#[derive(Debug, Clone)]
pub struct Staged {
    /// The objects, in the order of their names.
    pub objects: Vec<StageObject>,
    /// Lamps that are part of the scene.
    pub lights: Vec<LocalLight>,
    /// Spheres that stand for what moves, centre and radius, for methods that shadow by spheres: sixty a figure.
    pub spheres: Vec<(Vector3<f64>, f64)>,
    /// A camera that shows the scene well.
    pub camera: Camera,
}

/// A rigid object where it stands.
#[derive(Debug, Clone)]
pub struct StageObject {
    /// What it is.
    pub name: &'static str,
    /// Its geometry, which other objects may share.
    pub mesh: Arc<Mesh>,
    /// Where it stands: world = pose · position.
    pub pose: Isometry3<f64>,
}

/// What a scene is made of before it is tessellated.
struct Plan {
    shapes: Vec<Shape>,
    /// Name, number of the shape, pose.
    objects: Vec<(&'static str, usize, Isometry3<f64>)>,
    lights: Vec<LocalLight>,
    spheres: Vec<(Vector3<f64>, f64)>,
    eye: [f64; 3],
    target: [f64; 3],
}

/// Adds the surfaces of an object at a spacing.
type Shape = Box<dyn Fn(&mut Builder, f64)>;

impl Plan {
    fn new(eye: [f64; 3], target: [f64; 3]) -> Self {
        Self { shapes: vec![], objects: vec![], lights: vec![], spheres: vec![], eye, target }
    }

    /// A shape that objects can have.
    fn shape(&mut self, shape: impl Fn(&mut Builder, f64) + 'static) -> usize {
        self.shapes.push(Box::new(shape));
        self.shapes.len() - 1
    }

    fn place(&mut self, name: &'static str, shape: usize, pose: Isometry3<f64>) {
        self.objects.push((name, shape, pose));
    }

    /// A shape of one object.
    fn add(&mut self, name: &'static str, pose: Isometry3<f64>, shape: impl Fn(&mut Builder, f64) + 'static) {
        let shape = self.shape(shape);
        self.place(name, shape, pose);
    }

    /// The ground, `half` metres to each side.
    fn ground(&mut self, half: f64) {
        self.add("ground", Isometry3::identity(), move |builder, spacing| builder.floor(half, 0.05, 1.5 * spacing));
    }
}

impl Stage {
    /// All scenes.
    pub const ALL: [Self; 6] =
        [Self::Robot, Self::KitchenTable, Self::Street, Self::WalkingFigure, Self::Crowd, Self::Temple];

    /// A name for command lines: lower case with hyphens.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::KitchenTable => "kitchen-table",
            Self::Street => "street",
            Self::WalkingFigure => "walking-figure",
            Self::Crowd => "crowd",
            Self::Temple => "temple",
        }
    }

    /// The scene of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|stage| stage.name() == name)
    }

    /// The scene with about `vertices` vertices in all shapes, each counted once (within 15 %), at a `phase` of its
    /// motion: periodic, 1 is a whole step with each leg. Scenes without motion are the same at all phases.
    ///
    /// The crowd has the shapes of one figure: its vertices are as many for sixteen.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 2,000 ≤ `vertices` ≤ 2,000,000, [`Error::NotFinite`] for a phase that is NaN or
    /// infinite.
    pub fn build(self, vertices: usize, phase: f64) -> Result<Staged> {
        if !(2_000..=2_000_000).contains(&vertices) {
            let what = "vertices of a built-in scene";
            return Err(Error::OutOfRange { what, got: vertices as f64, allowed: "in 2000…2000000" });
        }
        if !phase.is_finite() {
            return Err(Error::NotFinite { what: "phase of a scene, number", index: 0 });
        }
        let plan = match self {
            Self::Robot => robot::plan(phase),
            Self::KitchenTable => kitchen::plan()?,
            Self::Street => street::plan()?,
            Self::WalkingFigure => figure::plan(phase, 1),
            Self::Crowd => figure::plan(phase, 4),
            Self::Temple => temple::plan(),
        };
        let spacing = spacing_for(vertices, |spacing| {
            let mut builder = Builder::counting();
            plan.shapes.iter().for_each(|shape| shape(&mut builder, spacing));
            builder.vertices()
        });
        let mesh = |shape: &Shape| {
            let mut builder = Builder::new();
            shape(&mut builder, spacing);
            Ok(Arc::new(builder.finish()?.0))
        };
        let meshes = plan.shapes.iter().map(mesh).collect::<Result<Vec<_>>>()?;
        let object = |(name, shape, pose)| StageObject { name, mesh: Arc::clone(&meshes[shape]), pose };
        let [eye, target] = [plan.eye, plan.target].map(Vector3::from);
        Ok(Staged {
            objects: plan.objects.into_iter().map(object).collect(),
            lights: plan.lights,
            spheres: plan.spheres,
            camera: Camera::look_at(eye, target, Vector3::y(), 36_f64.to_radians())?,
        })
    }
}

impl Staged {
    /// All objects as one mesh in the world, in their order.
    ///
    /// # Errors
    /// Those of [`Mesh::merge`].
    pub fn merged(&self) -> Result<Mesh> {
        let moved = |object: &StageObject| object.mesh.transformed(&nalgebra::convert(object.pose));
        let moved = self.objects.iter().map(moved).collect::<Result<Vec<_>>>()?;
        Mesh::merge(&moved)
    }

    /// The objects as what stops rays, in their order; shapes that objects share have one hierarchy.
    ///
    /// Cost: that of [`Bvh::new`] for every shape.
    ///
    /// # Errors
    /// Those of [`Occluders::new`].
    pub fn occluders(&self) -> Result<Occluders> {
        let mut known: Vec<(&Arc<Mesh>, Arc<Bvh>)> = Vec::new();
        for object in &self.objects {
            if !known.iter().any(|(mesh, _)| Arc::ptr_eq(mesh, &object.mesh)) {
                known.push((&object.mesh, Arc::new(Bvh::new(&object.mesh))));
            }
        }
        let bvh = |object: &StageObject| known.iter().find(|(mesh, _)| Arc::ptr_eq(mesh, &object.mesh));
        Occluders::new(self.objects.iter().filter_map(|object| Some((Arc::clone(&bvh(object)?.1), object.pose))))
    }
}
