//! What methods share that light the vertices of a mesh by distant light.

#[allow(dead_code, reason = "for those methods that ask for it")]
pub(in crate::backend) mod range;

use nalgebra::Vector3;

use crate::scene::{Materials, View};
use crate::sphere::{CubeGrid, CubeMap};
use crate::store::SectionReader;
use crate::{Error, Result};

/// What may change from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Freedom {
    /// The light. View and materials are those of the bake.
    Light,
    /// The light, the view and the materials.
    LightViewMaterials,
}

/// A method that turns distant light into the radiance of every vertex, frame after frame.
///
/// A light is set once and then used by every frame until the next one; without light all vertices are black.
///
/// # Example
/// ```
/// # #[cfg(feature = "block_product")] {
/// use haarmonic::backend::DistantRelighter;
/// use haarmonic::backend::block_product::{BlockLayout, Relighter, Settings, Transport};
/// use haarmonic::compress::ScanOrder;
/// use haarmonic::nalgebra::Vector3;
/// use haarmonic::scene::{EnvironmentLight, Lambert, Materials, Procedural, Sky, View};
/// use haarmonic::scene::{VisibilityBaker, VisibilitySettings};
/// use haarmonic::sphere::CubeGrid;
///
/// let (mesh, grid) = (Procedural::StackedSpheres.build(1_000)?.mesh, CubeGrid::new(16)?);
/// let baker = VisibilityBaker::new(&mesh, grid, VisibilitySettings::default())?;
/// let transport = Transport::bake(&baker, &BlockLayout::new(grid, 16, ScanOrder::Serpentine)?, &())?;
/// let mut method: Box<dyn DistantRelighter + '_> = Box::new(Relighter::new(&mesh, &transport, Settings::default())?);
///
/// method.set_light(&EnvironmentLight::from_sky(Sky::default())?.to_cube(method.grid()))?;
/// let mut radiance = vec![Vector3::zeros(); method.vertices()];
/// let grey = Materials::uniform(Lambert::new([0.5; 3])?);
/// method.relight(&View::eye(Vector3::new(0.0, 1.0, 5.0))?, &grey, &mut radiance)?;
/// assert!(radiance.iter().any(|l| l.y > 0.0));
/// # }
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub trait DistantRelighter: Send {
    /// The grid on which a light must be.
    fn grid(&self) -> CubeGrid;

    /// How many vertices are lit.
    fn vertices(&self) -> usize;

    /// What may change from frame to frame.
    fn freedom(&self) -> Freedom;

    /// Sets the light: radiance on the method's grid. Any finite light will do. One that is refused leaves the one
    /// before.
    ///
    /// # Errors
    /// [`Error::Length`] for a light on another grid, [`Error::NotFinite`] for a texel that is NaN or infinite, and
    /// what the choice of the light's terms refuses.
    fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()>;

    /// The radiance that each vertex sends to the viewer; finite, at most [`f32::MAX`] in magnitude.
    ///
    /// A method of [`Freedom::Light`] gives that of the materials that were baked, whatever materials are asked for.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is a material for each vertex; [`Error::NotFinite`] for a BRDF that gives NaN or
    /// infinity (the index is the BRDF's), and `out` is no frame then; [`Error::Baked`] for a view other than the baked
    /// one, if radiance depends on it.
    ///
    /// # Panics
    /// Unless `out` has a value for each vertex.
    #[track_caller]
    fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()>;

    /// Bytes in memory that grow with the number of vertices, beside the transport's.
    fn bytes(&self) -> usize;
}

#[allow(dead_code, reason = "for those methods that ask for it")]
/// Checks that there is what is needed for each vertex of a mesh.
pub(in crate::backend) fn check_vertices(what: &'static str, expected: usize, got: usize) -> Result<()> {
    if got == expected { Ok(()) } else { Err(Error::Length { what, expected, got }) }
}

/// The grid whose side a file names.
#[allow(dead_code, reason = "for those methods that ask for it")]
pub(in crate::backend) fn read_grid(section: &mut SectionReader) -> Result<CubeGrid> {
    let side = section.count("texels of a side")?;
    CubeGrid::new(side).map_err(|_| section.wrong(format!("{side} is not a side of a cube map")))
}

/// The same of a method that wants a power of two.
#[allow(dead_code, reason = "for those methods that ask for it")]
pub(in crate::backend) fn read_dyadic_grid(section: &mut SectionReader) -> Result<CubeGrid> {
    match read_grid(section)? {
        grid if grid.side().is_power_of_two() => Ok(grid),
        grid => Err(section.wrong(format!("{} is not a side of a cube map", grid.side()))),
    }
}
