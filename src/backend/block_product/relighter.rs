//! What a user holds: the light, the plans, frame after frame.

use nalgebra::Vector3;

use super::bounds::{Gauge, Limits, spread};
use super::frame::{Frame, Inputs, Scratch};
use super::light::LightForms;
use super::live::LiveBlocks;
use super::lobes::Planner;
use super::rule::Rule;
use super::schedule::Schedule;
use super::settings::Settings;
use super::stats::FrameStats;
use super::tables::Directions;
use super::transport::{Maps, Transport, with_maps};
use super::visible::GrayChange;
use crate::backend::distant::{DistantRelighter, Freedom, check_vertices};
use crate::compress::{CodedBinaryMaps, CodedGrayMaps};
use crate::error::check_length;
use crate::scene::{Camera, Materials, Mesh, View};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Result, parallel};

/// Relights a scene from its [`Transport`]: light, view and materials may change in each frame.
///
/// ```math
/// radiance(v) = Σ_blocks Σ_places L V ρ cos,
/// ```
///
/// each block by algorithm 1 [Inger 2013]: nothing if hidden; reflectance samples times weights if free; the same with
/// weights from suffix sums if partly hidden and one or four samples are enough; pixel by pixel otherwise.
///
/// Frames do not allocate once the materials are known. The result does not depend on the number of threads.
#[derive(Debug, Clone)]
pub struct Relighter<'a> {
    inputs: Inputs<'a>,
    /// [block]
    limits: Vec<Limits>,
    scratch: Vec<Scratch>,
    scheduled: Scheduled<'a>,
    /// Whether the plans know the light.
    is_weighed: bool,
}

/// Maps, and the order in which a frame sums them up.
#[derive(Debug, Clone)]
pub(super) enum Scheduled<'a> {
    Binary8(&'a CodedBinaryMaps<u8>, Schedule<u8>),
    Binary16(&'a CodedBinaryMaps<u16>, Schedule<u16>),
    Gray8(&'a CodedGrayMaps<u8>, Schedule<GrayChange<u8>>),
    Gray16(&'a CodedGrayMaps<u16>, Schedule<GrayChange<u16>>),
}

/// Runs `$body` with `$maps` and `$schedule` bound to those that there are.
macro_rules! with_scheduled {
    ($enum:expr, $maps:ident, $schedule:ident => $body:expr) => {
        match $enum {
            Scheduled::Binary8($maps, $schedule) => $body,
            Scheduled::Binary16($maps, $schedule) => $body,
            Scheduled::Gray8($maps, $schedule) => $body,
            Scheduled::Gray16($maps, $schedule) => $body,
        }
    };
}

impl<'a> Scheduled<'a> {
    fn new(transport: &'a Transport) -> Self {
        let (paths, vertices, blocks) = (transport.paths(), transport.vertices(), transport.layout().blocks());
        match transport.maps() {
            Maps::Binary8(maps) => Self::Binary8(maps, Schedule::new(maps, paths, vertices, blocks)),
            Maps::Binary16(maps) => Self::Binary16(maps, Schedule::new(maps, paths, vertices, blocks)),
            Maps::Gray8(maps) => Self::Gray8(maps, Schedule::new(maps, paths, vertices, blocks)),
            Maps::Gray16(maps) => Self::Gray16(maps, Schedule::new(maps, paths, vertices, blocks)),
        }
    }
}

impl<'a> Relighter<'a> {
    /// A relighter without light.
    ///
    /// # Errors
    /// [`Error::Length`] if mesh and transport disagree about the number of vertices, [`Error::OutOfRange`] for a
    /// tolerance that is negative or not finite.
    pub fn new(mesh: &'a Mesh, transport: &'a Transport, settings: Settings) -> Result<Self> {
        check_vertices("visibility maps", mesh.positions().len(), transport.vertices())?;
        if let Rule::Bounded { tolerance } = settings.rule {
            Rule::bounded(tolerance)?;
        }
        let layout = transport.layout();
        let light = LightForms::new(layout, settings.basis)?;
        let gauge = Gauge::new(layout, light.interpolation());
        let directions = Directions::new(layout, light.tiles(), light.interpolation());
        let live = with_maps!(transport.maps(), maps => LiveBlocks::new(maps, transport.paths(), layout.blocks()));
        Ok(Self {
            inputs: Inputs {
                mesh,
                settings,
                directions,
                planner: Planner::new(gauge, settings.rule),
                needed: Vec::new(),
                live,
                arch: pulp::Arch::new(),
                light,
            },
            limits: vec![Limits::default(); layout.blocks()],
            // Made one by one: a clone would not keep the reserved room.
            scratch: (0..parallel::pieces()).map(|_| Scratch::new(layout)).collect(),
            scheduled: Scheduled::new(transport),
            is_weighed: false,
        })
    }

    /// Sets the light: radiance on the transport's grid. A light that is refused leaves the one before.
    ///
    /// # Errors
    /// As [`LightForms::set`].
    pub fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        self.inputs.light.set(light)?;
        if let Rule::Bounded { tolerance } = self.inputs.settings.rule {
            let blocks = self.limits.len();
            let allowed = tolerance * self.inputs.light.mean / spread(blocks);
            for (limits, norms) in self.limits.iter_mut().zip(&self.inputs.light.norms) {
                *limits = Limits::new(allowed, norms, blocks);
            }
        }
        self.is_weighed = false;
        Ok(())
    }

    /// Bytes in memory that grow with the number of vertices, beside the transport's: its visibility once more, in the
    /// order of frames.
    pub fn bytes(&self) -> usize {
        self.inputs.live.bytes() + with_scheduled!(&self.scheduled, _maps, schedule => schedule.bytes())
    }

    /// The light's forms.
    pub fn light(&self) -> &LightForms {
        &self.inputs.light
    }

    /// The radiance that each vertex sends towards the viewer. Vertices without light (none was set) are black;
    /// radiance beyond [`f32::MAX`] is held there.
    ///
    /// Materials that were not in the last frame cost their tables of errors first: tens of milliseconds for each new
    /// exponent or isotropic lobe about the half vector, some hundreds for an anisotropic one or a closure.
    ///
    /// # Errors
    /// [`Error::Length`] if the materials do not fit the mesh, [`Error::NotFinite`] for a BRDF of which a value that
    /// was asked for, over the hemisphere or for a pixel, is NaN or infinite (the index is the BRDF's); `out` is not a
    /// frame then.
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
    #[track_caller]
    pub fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        self.inputs.needed.clear();
        self.frame(view, materials, out)
    }

    /// As [`relight`](Self::relight), but only for the vertices of faces that turn their front to the camera and may be
    /// in a picture of the given aspect ratio (width/height). The others are black.
    ///
    /// # Errors
    /// As [`relight`](Self::relight), and [`Error::OutOfRange`] unless `aspect` is positive and finite.
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
    #[track_caller]
    pub fn relight_in_picture(
        &mut self,
        camera: &Camera,
        aspect: f64,
        materials: &Materials,
        out: &mut [Vector3<f32>],
    ) -> Result<()> {
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(Error::OutOfRange { what: "aspect ratio", got: aspect, allowed: "positive and finite" });
        }
        super::culling::mark(self.inputs.mesh, camera, aspect, &mut self.inputs.needed);
        self.frame(&View::eye(camera.eye().cast())?, materials, out)
    }

    fn frame(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        check_length("radiance of the vertices", self.inputs.mesh.positions().len(), out.len());
        materials.check(out.len())?;
        if self.inputs.light.is_dark() {
            out.fill(Vector3::zeros());
            return Ok(());
        }
        self.plan(materials)?;
        let frame = Frame { inputs: &self.inputs, view, materials };
        with_scheduled!(&self.scheduled, maps, schedule => frame.run((*maps, schedule), &mut self.scratch, out));
        match out.iter().position(|radiance| !radiance.iter().all(|c| c.is_finite())) {
            Some(vertex) if self.inputs.planner.plans()[materials.part(vertex)].has_opaque() => {
                Err(materials.not_finite(vertex))
            }
            _ => Ok(()),
        }
    }

    fn plan(&mut self, materials: &Materials) -> Result<()> {
        if self.inputs.planner.set(materials.brdfs())? || !self.is_weighed {
            self.inputs.planner.weigh(&self.limits, self.inputs.directions.radii);
            self.is_weighed = true;
        }
        Ok(())
    }

    /// How the blocks of such a frame are integrated.
    ///
    /// # Errors
    /// As [`relight`](Self::relight).
    pub fn frame_stats(&mut self, view: &View, materials: &Materials) -> Result<FrameStats> {
        materials.check(self.inputs.mesh.positions().len())?;
        self.inputs.needed.clear();
        self.plan(materials)?;
        let mut scratch = self.scratch.first().cloned().expect("there is a piece");
        let frame = Frame { inputs: &self.inputs, view, materials };
        Ok(with_scheduled!(&self.scheduled, maps, _schedule => frame.count(*maps, &mut scratch)))
    }
}

impl DistantRelighter for Relighter<'_> {
    fn grid(&self) -> CubeGrid {
        self.inputs.light.grid()
    }

    fn vertices(&self) -> usize {
        self.inputs.mesh.positions().len()
    }

    fn freedom(&self) -> Freedom {
        Freedom::LightViewMaterials
    }

    fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        self.set_light(light)
    }

    fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        self.relight(view, materials, out)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }
}
