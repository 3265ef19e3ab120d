//! The transport of a static scene on top faces.

use std::sync::Arc;

use nalgebra::Vector3;

use super::bake::{Baker, Reflectance};
use super::rows::Rows;
use super::settings::{BakeSettings, ViewFactors};
use crate::haar::{Decomposition, Transform2d};
use crate::parallel::{self, Watch};
use crate::scene::{
    DirectionTable, Directions, FactoredBrdf, LocalFrame, Materials, Mesh, Occluders, View, Viewpoint, VisibilityTracer,
};
use crate::sphere::TopFace;
use crate::{Error, Progress, Result};

/// The transport of a static scene: visibility × brdf_cos × measure of every vertex on a top face that is aligned with
/// the plane of lights, in the standard Haar basis, sparse.
///
/// ```math
/// B(v) = ∫ L(v, ω) T(v, ω) dω = Σ_k L_k(v) T_k(v)                                       [Sun 2008, eq. 4.36]
/// ```
///
/// The face is [0, 1]² of [`TopFace`]; its measure dω/dw is part of T. Each cell's is a sum over `samples`² rays, each
/// with the exact solid angle of its part of the cell.
///
/// A transport is of one view, or of any (its BRDFs do not depend on the view), or holds each BRDF as a sum of products
/// so that the view stays free: [`bake`](Self::bake), [`bake_view_free`](Self::bake_view_free).
///
/// # Example
/// ```
/// use haarmonic::backend::near_field::{BakeSettings, PlanarLight, Relighter, Settings, Transport};
/// use haarmonic::nalgebra::Vector3;
/// use haarmonic::scene::{Lambert, Materials, Occluders, Procedural, View};
///
/// let model = Procedural::StackedSpheres.build(1_000)?;
/// let grey = Materials::uniform(Lambert::new([0.5; 3])?);
/// let view = View::eye(model.camera.eye().cast())?;
/// let settings = BakeSettings { cells: 16, samples: 1, ..BakeSettings::default() };
/// let transport = Transport::bake(&model.mesh, Occluders::of_mesh(&model.mesh), &view, &grey, settings, &())?;
///
/// let mut relighter = Relighter::new(&transport, Settings { source_side: 16, ..Settings::default() })?;
/// let mut lamp = PlanarLight::uniform(Vector3::new(0.0, 4.0, 0.0), [1.0, 1.0], Vector3::repeat(3.0))?;
/// let mut radiance = vec![Vector3::zeros(); transport.vertices()];
/// for step in 0..3 {
///     lamp.set_centre(Vector3::new(f64::from(step), 4.0, 0.0))?;
///     relighter.set_lights(std::slice::from_ref(&lamp))?;
///     relighter.relight(&mut radiance);
/// }
/// assert!(radiance.iter().any(|l| l.y > 0.0));
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Transport {
    pub(super) face: TopFace,
    pub(super) frame: LocalFrame,
    pub(super) positions: Vec<Vector3<f32>>,
    /// What was baked; none if radiance does not depend on it, or the view is free.
    pub(super) view: Option<View>,
    pub(super) free: Option<FreeView>,
    pub(super) rows: Rows,
}

/// What a free view needs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FreeView {
    /// Of each part; none for BRDFs that do not depend on the view.
    pub(super) factors: Vec<Option<FactoredBrdf>>,
    /// Of each vertex: its part, normal and tangent.
    pub(super) parts: Vec<u32>,
    pub(super) frames: Vec<[Vector3<f32>; 2]>,
}

impl FreeView {
    /// Products of the BRDF with the most of them.
    pub(super) fn terms(&self) -> usize {
        self.factors.iter().flatten().map(FactoredBrdf::terms).max().unwrap_or(1)
    }

    pub(super) fn frame(&self, vertex: usize) -> LocalFrame {
        let [normal, tangent] = self.frames[vertex];
        LocalFrame { tangent, bitangent: normal.cross(&tangent), normal }
    }
}

/// What a [`Transport`] holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct TransportStats {
    /// Vertices.
    pub vertices: usize,
    /// Images, at most one for each vertex, channel and product.
    pub rows: usize,
    /// Coefficients that are stored, of all rows.
    pub coefficients: usize,
    /// Bytes in memory.
    pub bytes: usize,
}

/// Vertices that a task bakes at a time.
const TOGETHER: usize = 64;

impl Transport {
    /// Computes the transport of every vertex for one view; for any, if no material depends on it.
    ///
    /// `progress` counts vertices. The same bits for any number of threads. Cost: (cells · samples)² rays, one BRDF
    /// slice and one transform a vertex.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a number of cells that is none; [`Error::OutOfRange`] above 256, for a face size
    /// outside that of [`TopFace`], no or more than 15 samples, an offset or tolerance outside of [0, 1), axes that are
    /// not orthonormal, more than 2³² rows; [`Error::Length`] if materials do not fit the mesh; [`Error::NotFinite`]
    /// for a BRDF whose value for one of the directions is NaN or infinite in `f32` (the index is the BRDF's);
    /// [`Error::Cancelled`].
    pub fn bake(
        mesh: &Mesh,
        occluders: impl Into<Arc<Occluders>>,
        view: &View,
        materials: &Materials,
        settings: BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Self> {
        materials.check(mesh.positions().len())?;
        let depends = materials.brdfs().iter().any(|brdf| !brdf.is_view_independent());
        let mut baked = run(mesh, occluders.into(), materials, Reflectance::Seen(view), settings, progress)?;
        baked.view = depends.then_some(*view);
        Ok(baked)
    }

    /// Computes the transport of every vertex for any view: BRDFs that depend on it become sums of products of light
    /// and view, one row a product.
    ///
    /// # Errors
    /// As [`bake`](Self::bake), and what [`FactoredBrdf::new`] refuses.
    pub fn bake_view_free(
        mesh: &Mesh,
        occluders: impl Into<Arc<Occluders>>,
        materials: &Materials,
        factors: ViewFactors,
        settings: BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let vertices = mesh.positions().len();
        materials.check(vertices)?;
        let factor = |brdf: &Arc<dyn crate::scene::Brdf>| match brdf.is_view_independent() {
            true => Ok(None),
            false => FactoredBrdf::new(&**brdf, factors.cells, factors.terms).map(Some),
        };
        let factors: Vec<_> = materials.brdfs().iter().map(factor).collect::<Result<_>>()?;
        let mut baked = run(mesh, occluders.into(), materials, Reflectance::Factored(&factors), settings, progress)?;
        let frames = mesh.normals().iter().zip(mesh.tangents()).map(|(&n, &t)| [n, t]).collect();
        let parts = (0..vertices).map(|v| materials.part(v) as u32).collect();
        baked.free = Some(FreeView { factors, parts, frames });
        Ok(baked)
    }

    /// The face of every vertex.
    pub fn face(&self) -> TopFace {
        self.face
    }

    /// The axes of the faces, and of the lights' plane.
    pub fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// Where they are.
    pub fn positions(&self) -> &[Vector3<f32>] {
        &self.positions
    }

    /// The view that was baked; none if radiance does not depend on it, or if the view is free.
    pub fn view(&self) -> Option<&View> {
        self.view.as_ref()
    }

    /// Whether the view may change from frame to frame: [`Relighter::set_view`](super::Relighter::set_view).
    pub fn is_view_free(&self) -> bool {
        self.free.is_some()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let free = self.free.as_ref().map_or(0, |free| {
            let tables = free.factors.iter().flatten().map(|f| 32 * f.terms() * f.cells() * f.cells()).sum::<usize>();
            tables + size_of_val(free.parts.as_slice()) + size_of_val(free.frames.as_slice())
        });
        self.rows.bytes() + size_of_val(self.positions.as_slice()) + free
    }

    /// Counts and sizes.
    pub fn stats(&self) -> TransportStats {
        let rows = &self.rows;
        TransportStats {
            vertices: self.vertices(),
            rows: rows.len(),
            coefficients: rows.entries(),
            bytes: self.bytes(),
        }
    }
}

/// The largest face, whose wavelets have numbers of 16 bits.
const LARGEST: usize = 256;

fn run(
    mesh: &Mesh,
    occluders: Arc<Occluders>,
    materials: &Materials,
    reflectance: Reflectance<'_>,
    settings: BakeSettings,
    progress: &dyn Progress,
) -> Result<Transport> {
    let BakeSettings { frame, face_size, cells, samples, offset, tolerance, precision } = settings;
    if cells > LARGEST {
        let got = cells as f64;
        return Err(Error::OutOfRange { what: "cells along a top face", got, allowed: "at most 256" });
    }
    if !(1..=15).contains(&samples) {
        return Err(Error::OutOfRange { what: "samples along a cell", got: samples as f64, allowed: "in 1…15" });
    }
    if !(0.0..1.0).contains(&tolerance) {
        let got = f64::from(tolerance);
        return Err(Error::OutOfRange { what: "tolerance of the transport", got, allowed: "in [0, 1)" });
    }
    let face = TopFace::new(face_size, cells)?;
    let transform = Transform2d::new(cells, cells, Decomposition::Standard)?;
    let fine = TopFace::new(face_size, cells * samples)?;
    let viewpoints = Viewpoint::of_vertices(mesh, offset)?;
    let viewpoints = viewpoints.into_iter().map(|view| view.with_frame(frame)).collect::<Result<Vec<_>>>()?;
    let tracer = VisibilityTracer::new(occluders, Directions::top_face(fine));
    let directions = DirectionTable::top_face(&fine, &frame);
    let baker = Baker { mesh, materials, reflectance, settings, face, tracer, viewpoints, directions, transform };
    let vertices = mesh.positions().len();
    let watch = Watch::new(progress, vertices);
    let parts = parallel::try_map(
        vertices.div_ceil(TOGETHER),
        || baker.memory(),
        |k, memory| {
            watch.check()?;
            let mut rows = Rows::new(precision);
            let range = k * TOGETHER..((k + 1) * TOGETHER).min(vertices);
            for vertex in range.clone() {
                baker.vertex(vertex, &mut rows, memory)?;
            }
            watch.advance(range.len());
            Ok(rows)
        },
    )?;
    let count: usize = parts.iter().map(Rows::len).sum();
    if count > u32::MAX as usize {
        let got = count as f64;
        return Err(Error::OutOfRange { what: "rows of a transport", got, allowed: "below 2^32" });
    }
    let mut rows = Rows::new(precision);
    parts.iter().for_each(|part| rows.append(part));
    Ok(Transport { face, frame, positions: mesh.positions().to_vec(), view: None, free: None, rows })
}
