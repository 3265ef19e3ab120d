//! Scenes made by a formula, at any tessellation.

mod bas_relief;
mod builder;
mod stacked_spheres;
mod stage;
mod table;
mod torus_knot;

use nalgebra::Vector3;

use self::builder::Builder;
pub use self::stage::{Stage, StageObject, Staged};
use super::{Camera, Mesh};
use crate::{Error, Result};

/// The built-in scenes.
///
/// All are some units large, stand on y = 0 or around it, have outward counter-clockwise faces, smooth normals on
/// smooth surfaces and split vertices at hard edges. Solids are closed; floors and the relief are open sheets with a
/// skirt.
///
/// Texture coordinates are in [0, 1]² and cover it once for each piece of a part: seen from above on floors and the
/// relief (u along +x, v along −z), (along, up) on skirts and the sides of boxes, a disc on the caps of rods. Round
/// surfaces share the vertices of their seams, which no texture may cut: around rods, and around and along the knot,
/// the coordinate runs from 0 to 1 and back again, and the halves of a sphere in front of and behind its centre (z)
/// have one disc, u along x and v along y. So a half of each of these is mirrored:
/// [`Mesh::uv_handedness`](crate::scene::Mesh::uv_handedness).
///
/// # Example
/// ```
/// use haarmonic::scene::Procedural;
/// let model = Procedural::TorusKnotOnFloor.build(5_000)?;
/// assert!((4_500..5_500).contains(&model.mesh.positions().len()));
/// assert_eq!(model.part_names[model.parts[0] as usize], "floor");
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Procedural {
    /// A trefoil tube that stands on a floor.
    TorusKnotOnFloor,
    /// A pyramid of ten spheres on a floor, and some small ones around it.
    StackedSpheres,
    /// A table with chairs and a railing: thin shadow casters.
    Table,
    /// A carved medallion: an open sheet displaced along +y.
    BasRelief,
}

/// What a built-in scene consists of.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The geometry.
    pub mesh: Mesh,
    /// For every vertex the part it belongs to, an index of `part_names`.
    pub parts: Vec<u8>,
    /// The names of the parts.
    pub part_names: &'static [&'static str],
    /// A camera that shows the scene well.
    pub camera: Camera,
}

impl Model {
    /// A value for every vertex from its part's.
    ///
    /// # Panics
    /// If there are fewer values than parts.
    #[track_caller]
    pub fn by_part<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.parts.iter().map(|&p| values[p as usize]).collect()
    }
}

impl Procedural {
    /// All scenes.
    pub const ALL: [Self; 4] = [Self::TorusKnotOnFloor, Self::StackedSpheres, Self::Table, Self::BasRelief];

    /// A name for command lines: lower case with hyphens.
    pub const fn name(self) -> &'static str {
        match self {
            Self::TorusKnotOnFloor => "torus-knot",
            Self::StackedSpheres => "stacked-spheres",
            Self::Table => "table",
            Self::BasRelief => "bas-relief",
        }
    }

    /// The scene of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scene| scene.name() == name)
    }

    /// The scene with about `vertices` vertices: within 10 %.
    ///
    /// All surfaces are tessellated at one spacing, which is searched for; floors are finer around what stands on them
    /// than at their rim.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1,000 ≤ `vertices` ≤ 2,000,000.
    pub fn build(self, vertices: usize) -> Result<Model> {
        if !(1_000..=2_000_000).contains(&vertices) {
            return Err(Error::OutOfRange {
                what: "vertices of a built-in scene",
                got: vertices as f64,
                allowed: "in 1000…2000000",
            });
        }
        let spacing = spacing_for(vertices, |h| {
            let mut builder = Builder::counting();
            self.tessellate(&mut builder, h);
            builder.vertices()
        });
        let mut builder = Builder::new();
        self.tessellate(&mut builder, spacing);
        let (mesh, parts) = builder.finish()?;
        let (part_names, eye, target, fov) = self.stage();
        let camera = Camera::look_at(eye, target, Vector3::y(), fov)?;
        Ok(Model { mesh, parts, part_names, camera })
    }

    fn tessellate(self, builder: &mut Builder, spacing: f64) {
        match self {
            Self::TorusKnotOnFloor => torus_knot::tessellate(builder, spacing),
            Self::StackedSpheres => stacked_spheres::tessellate(builder, spacing),
            Self::Table => table::tessellate(builder, spacing),
            Self::BasRelief => bas_relief::tessellate(builder, spacing),
        }
    }

    /// Part names, eye, target, vertical field of view.
    fn stage(self) -> (&'static [&'static str], Vector3<f64>, Vector3<f64>, f64) {
        let fov = 36_f64.to_radians();
        match self {
            Self::TorusKnotOnFloor => {
                (&["floor", "knot"], Vector3::new(2.5, 3.1, 6.6), Vector3::new(0.0, 0.92, 0.0), fov)
            }
            Self::StackedSpheres => {
                (&["floor", "spheres", "beads"], Vector3::new(2.9, 3.3, 6.3), Vector3::new(0.0, 0.7, 0.0), fov)
            }
            Self::Table => (
                &["floor", "table", "chairs", "railing", "fruit"],
                Vector3::new(2.6, 2.5, 4.1),
                Vector3::new(0.0, 0.42, -0.1),
                fov,
            ),
            Self::BasRelief => (&["relief", "skirt"], Vector3::new(0.0, 2.9, 2.6), Vector3::new(0.0, 0.0, 0.1), fov),
        }
    }
}

/// The spacing whose tessellation comes nearest to `target` vertices; `count` falls with the spacing but for steps.
fn spacing_for(target: usize, count: impl Fn(f64) -> usize) -> f64 {
    let (mut fine, mut coarse) = (1e-4_f64, 4.0_f64);
    let mut best = (usize::MAX, coarse);
    for _ in 0..40 {
        let middle = (fine * coarse).sqrt();
        let vertices = count(middle);
        if vertices.abs_diff(target) < best.0 {
            best = (vertices.abs_diff(target), middle);
        }
        if vertices > target { fine = middle } else { coarse = middle }
    }
    best.1
}
