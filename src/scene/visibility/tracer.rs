//! Visibility from any point in any frame.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::chart::{Chart, Disk, Perspective};
use super::directions::{Directions, Patch, PatchRays};
use super::live::LiveRays;
use super::occluders::{Occluders, Sight};
use super::orientation::{Aligned, Orientation, Turned};
use super::regular::{self, RegularRays};
use super::scattered::{self, LiveList, ScatteredLive};
use super::trace::{Rays, TracePatch, Waiting, occluded};
use super::triangle::Triangle;
use super::view::View;
use super::viewpoint::Viewpoint;
use crate::error::check_length;
use crate::numeric::arch_256;
use crate::parallel::{self, Watch};
use crate::{Error, Progress, Result};

/// A plan that finds which directions are free from any origin, in any frame.
///
/// All rays of an origin are traced at once: each patch of directions is rasterised front to back through a hierarchy
/// of boxes. [`VisibilityBaker`](super::VisibilityBaker) tells what occludes and how exactly; a patch that does not lie
/// along the axes of its object (a frame, an object that is turned, any map but a cube) widens edges by up to √3 times
/// as much, a top face by half of its size times that.
///
/// Free points start where they are, so that the surface under them occludes if they lie in it or below;
/// [`Viewpoint::of_vertices`] starts off the surface.
///
/// The same bits for any number of threads, with and without `rayon`.
///
/// Cost: see docs/performance.md, Visibility.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{Directions, Occluders, Procedural, Viewpoint, VisibilityTracer}};
/// let mesh = Procedural::Table.build(1000)?.mesh;
/// let tracer = VisibilityTracer::new(Occluders::of_mesh(&mesh), Directions::disk(16)?);
/// let views = Viewpoint::of_vertices(&mesh, 1.0 / 65536.0)?;
/// // The local hemisphere of every vertex, one after the other: nothing is stored.
/// let local = |vertex: usize| views[vertex].with_frame(mesh.local_frame(vertex));
/// tracer.for_each(views.len(), local, &(), |_vertex, words| assert_eq!(words.len(), 4))?;
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct VisibilityTracer {
    occluders: Arc<Occluders>,
    directions: Directions,
    arch: pulp::Arch,
}

/// Work space of one thread for [`VisibilityTracer`].
#[derive(Debug, Clone)]
pub struct VisibilityScratch {
    live: Live,
    stack: Vec<Waiting>,
}

/// What lives of a patch's rays.
#[derive(Debug, Clone)]
struct Live {
    /// Rays of a regular patch, cells of a scattered one.
    cells: LiveRays,
    /// Rays of a scattered patch.
    list: LiveList,
}

/// Viewpoints that a task takes at a time.
const TOGETHER: usize = 64;

impl VisibilityTracer {
    /// A plan for what stops rays and the directions of a map.
    pub fn new(occluders: impl Into<Arc<Occluders>>, directions: Directions) -> Self {
        Self { occluders: occluders.into(), directions, arch: arch_256() }
    }

    /// The directions of a map.
    pub fn directions(&self) -> &Directions {
        &self.directions
    }

    /// What stops rays.
    pub fn occluders(&self) -> &Arc<Occluders> {
        &self.occluders
    }

    /// Work space for one thread.
    pub fn scratch(&self) -> VisibilityScratch {
        let live = Live { cells: LiveRays::new(self.directions.side()), list: LiveList::default() };
        VisibilityScratch { live, stack: Vec::with_capacity(self.occluders.stack_len()) }
    }

    /// The binary map of one viewpoint, into the caller's words (whatever they held before): bit 1 where the direction
    /// is above the horizon and free. Of several samples an element, all must be.
    ///
    /// Returns how many rays there were above the horizon.
    ///
    /// # Panics
    /// If `words` has another length than [`Directions::words`], or `scratch` is of a tracer with other directions.
    #[track_caller]
    pub fn trace(&self, viewpoint: &Viewpoint, words: &mut [u64], scratch: &mut VisibilityScratch) -> u64 {
        check_length("words of a visibility map", self.directions.words(), words.len());
        assert_eq!(self.directions.samples(), 1, "a binary map has one sample an element");
        words.fill(0);
        let per_face = self.directions.patch_len().div_ceil(64);
        self.patches(viewpoint, scratch, |patch, live| match &patch.rays {
            PatchRays::Regular(number) => live.cells.pack(&mut words[number * per_face..][..per_face]),
            PatchRays::Scattered(rays) => live.list.for_each(|ray| {
                let element = rays.elements[ray] as usize;
                words[element / 64] |= 1 << (element % 64);
            }),
        })
    }

    /// The fractional map of one viewpoint: how many of an element's samples are above the horizon and free, of
    /// [`Directions::sample_counts`].
    ///
    /// Returns how many rays there were above the horizon.
    ///
    /// # Panics
    /// If `counts` has another length than [`Directions::len`], or `scratch` is of a tracer with other directions.
    #[track_caller]
    pub fn count(&self, viewpoint: &Viewpoint, counts: &mut [u8], scratch: &mut VisibilityScratch) -> u64 {
        check_length("counts of a visibility map", self.directions.len(), counts.len());
        counts.fill(0);
        let (per_face, samples) = (self.directions.patch_len(), self.directions.samples());
        self.patches(viewpoint, scratch, |patch, live| match &patch.rays {
            PatchRays::Regular(number) => live.cells.count(samples, &mut counts[number * per_face..][..per_face]),
            PatchRays::Scattered(rays) => live.list.for_each(|ray| counts[rays.elements[ray] as usize] += 1),
        })
    }

    /// The binary maps of `count` viewpoints, in parallel, each handed over as soon as it is there and not kept.
    ///
    /// `each(i, words)` is called once for every i, in any order, from any thread. `progress` counts viewpoints.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if `progress` asked to stop, and those of `viewpoint`.
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    #[track_caller]
    pub fn for_each(
        &self,
        count: usize,
        viewpoint: impl Fn(usize) -> Result<Viewpoint> + Sync,
        progress: &dyn Progress,
        each: impl Fn(usize, &[u64]) + Sync,
    ) -> Result<()> {
        self.stream(count, self.directions.words(), progress, |i, words, scratch| {
            self.trace(&viewpoint(i)?, words, scratch);
            each(i, words);
            Ok(())
        })
    }

    /// The fractional maps of `count` viewpoints, as [`for_each`](Self::for_each).
    ///
    /// # Errors
    /// Those of [`for_each`](Self::for_each).
    pub fn for_each_fractional(
        &self,
        count: usize,
        viewpoint: impl Fn(usize) -> Result<Viewpoint> + Sync,
        progress: &dyn Progress,
        each: impl Fn(usize, &[u8]) + Sync,
    ) -> Result<()> {
        self.stream(count, self.directions.len(), progress, |i, counts, scratch| {
            self.count(&viewpoint(i)?, counts, scratch);
            each(i, counts);
            Ok(())
        })
    }

    /// The binary maps of all viewpoints, one after the other: [`Directions::words`] words each.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if `progress` asked to stop, [`Error::OutOfRange`] if the result does not fit in memory.
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    #[track_caller]
    pub fn trace_batch(&self, viewpoints: &[Viewpoint], progress: &dyn Progress) -> Result<Vec<u64>> {
        self.collect(viewpoints.len(), self.directions.words(), progress, |i, words, scratch| {
            self.trace(&viewpoints[i], words, scratch);
        })
    }

    /// The fractional maps of all viewpoints, one after the other: [`Directions::len`] counts each.
    ///
    /// # Errors
    /// Those of [`trace_batch`](Self::trace_batch).
    pub fn count_batch(&self, viewpoints: &[Viewpoint], progress: &dyn Progress) -> Result<Vec<u8>> {
        self.collect(viewpoints.len(), self.directions.len(), progress, |i, counts, scratch| {
            self.count(&viewpoints[i], counts, scratch);
        })
    }

    /// One direction of one viewpoint by testing every face of every object: the same bit as the fast path, slowly. Of
    /// several samples an element, whether all are free.
    ///
    /// # Panics
    /// If there is no such element.
    #[track_caller]
    pub fn sees_brute_force(&self, viewpoint: &Viewpoint, element: usize) -> bool {
        assert!(element < self.directions.len(), "element {element} of {}", self.directions.len());
        let frame = Frame::new(viewpoint);
        let mut rays = 0;
        let all_free = self.directions.patches().iter().all(|patch| match &patch.rays {
            PatchRays::Regular(number) => {
                let (side, samples) = (self.directions.side(), self.directions.samples());
                let (first, cells) = (number * self.directions.patch_len(), side / samples);
                let Some(within) = element.checked_sub(first).filter(|i| *i < cells * cells) else { return true };
                let (centres, centres_f32) = self.directions.centres();
                let corner = [within % cells * samples, within / cells * samples];
                (0..samples * samples).all(|i| {
                    rays += 1;
                    let cell = [corner[0] + i % samples, corner[1] + i / samples];
                    let point = cell.map(|c| centres_f32[c]);
                    frame.is_above(patch, cell.map(|c| centres[c]))
                        && !self.occluded::<Perspective>(viewpoint, patch, cell, |t| regular::is_inside(t, point))
                })
            }
            PatchRays::Scattered(plan) => {
                (0..plan.len()).filter(|&ray| plan.elements[ray] as usize == element).all(|ray| {
                    rays += 1;
                    let direction = plan.directions[ray];
                    scattered::is_above(frame.horizon_along(patch), direction)
                        && !self.occluded::<Disk>(viewpoint, patch, plan.cell(ray), |t| t.is_inside(direction))
                })
            }
        });
        all_free && rays > 0
    }

    fn occluded<C: Chart>(
        &self,
        viewpoint: &Viewpoint,
        patch: &Patch,
        cell: [usize; 2],
        is_inside: impl Fn(&Triangle) -> bool,
    ) -> bool {
        let (frame, back_faces) = (Frame::new(viewpoint), self.occluders.back_faces());
        let (side, reach) = patch.cells(self.directions.side());
        self.occluders.sights(viewpoint.position()).any(|sight| match frame.place(patch, &sight) {
            Place::Aligned(aligned) => {
                let view = View::<_, C>::new(aligned, side, reach, 1.0, back_faces);
                occluded(sight.bvh, &view, cell, &is_inside)
            }
            Place::Turned(turned) => {
                let view = View::<_, C>::new(turned, side, reach, patch.slack, back_faces);
                occluded(sight.bvh, &view, cell, &is_inside)
            }
        })
    }

    /// Traces all patches and hands over those with a ray above the horizon.
    #[track_caller]
    fn patches(
        &self,
        viewpoint: &Viewpoint,
        scratch: &mut VisibilityScratch,
        mut done: impl FnMut(&Patch, &Live),
    ) -> u64 {
        let VisibilityScratch { live, stack } = scratch;
        check_length("cells along the scratch's patches", self.directions.side(), live.cells.side());
        let frame = Frame::new(viewpoint);
        let (centres, centres_f32) = self.directions.centres();
        let mut rays = 0;
        for patch in self.directions.patches() {
            let normal = frame.horizon_along(patch);
            let above = match &patch.rays {
                PatchRays::Regular(_) => match normal {
                    Some(normal) => live.cells.keep_above(normal, centres),
                    None => live.cells.keep_all(),
                },
                PatchRays::Scattered(plan) => live.list.keep_above(plan, normal, &mut live.cells),
            };
            if above == 0 {
                continue;
            }
            rays += above;
            for sight in self.occluders.sights(viewpoint.position()) {
                let place = frame.place(patch, &sight);
                match &patch.rays {
                    PatchRays::Regular(_) => {
                        let rays = RegularRays { live: &mut live.cells, centres: centres_f32 };
                        self.walk::<Perspective, _>(place, patch, &sight, rays, stack);
                    }
                    PatchRays::Scattered(plan) => {
                        let rays = ScatteredLive { plan, list: &mut live.list, cells: &mut live.cells };
                        self.walk::<Disk, _>(place, patch, &sight, rays, stack);
                    }
                }
            }
            done(patch, live);
        }
        rays
    }

    fn walk<C: Chart, R: Rays>(
        &self,
        place: Place,
        patch: &Patch,
        sight: &Sight<'_>,
        rays: R,
        stack: &mut Vec<Waiting>,
    ) {
        let (bvh, back_faces) = (sight.bvh, self.occluders.back_faces());
        let (side, reach) = patch.cells(self.directions.side());
        match place {
            Place::Aligned(aligned) => {
                let view = View::<_, C>::new(aligned, side, reach, 1.0, back_faces);
                self.run(TracePatch { bvh, view, rays, stack });
            }
            Place::Turned(turned) => {
                let view = View::<_, C>::new(turned, side, reach, patch.slack, back_faces);
                self.run(TracePatch { bvh, view, rays, stack });
            }
        }
    }

    fn run<O: Orientation, C: Chart, R: Rays>(&self, job: TracePatch<'_, O, C, R>) {
        self.arch.dispatch(job);
    }

    /// Runs `one` for every viewpoint on a buffer of its thread.
    fn stream<T: Copy + Default + Send>(
        &self,
        count: usize,
        len: usize,
        progress: &dyn Progress,
        one: impl Fn(usize, &mut [T], &mut VisibilityScratch) -> Result<()> + Sync,
    ) -> Result<()> {
        let watch = Watch::new(progress, count);
        let scratch = || (vec![T::default(); len], self.scratch());
        parallel::try_each(count.div_ceil(TOGETHER), scratch, |piece, (buffer, scratch)| {
            let part = piece * TOGETHER..((piece + 1) * TOGETHER).min(count);
            let done = part.len();
            for i in part {
                if i % 8 == 0 {
                    watch.check()?;
                }
                one(i, buffer, scratch)?;
            }
            watch.advance(done);
            Ok(())
        })
    }

    /// Runs `one` for every viewpoint on its `len` elements of one list.
    fn collect<T: Copy + Default + Send>(
        &self,
        count: usize,
        len: usize,
        progress: &dyn Progress,
        one: impl Fn(usize, &mut [T], &mut VisibilityScratch) + Sync,
    ) -> Result<Vec<T>> {
        let mut all = Vec::new();
        let too_large = || Error::OutOfRange {
            what: "bytes of visibility",
            got: count as f64 * len as f64 * size_of::<T>() as f64,
            allowed: "what fits in memory",
        };
        let total = count.checked_mul(len).ok_or_else(too_large)?;
        all.try_reserve_exact(total).map_err(|_| too_large())?;
        all.resize(total, T::default());
        // A few hundred pieces: enough to balance threads, few enough to report each.
        let piece = count.div_ceil(256).max(1);
        let watch = Watch::new(progress, count);
        parallel::try_chunks(
            &mut all,
            piece * len,
            || self.scratch(),
            |index, part, scratch| {
                for (k, values) in part.chunks_exact_mut(len).enumerate() {
                    if k % 8 == 0 {
                        watch.check()?;
                    }
                    one(index * piece + k, values, scratch);
                }
                watch.advance(part.len() / len);
                Ok(())
            },
        )?;
        Ok(all)
    }
}

/// A viewpoint's frame and horizon in the form that patches want.
struct Frame {
    /// Local to world and its inverse; `None` is the identity.
    turn: Option<(Matrix3<f64>, Matrix3<f64>)>,
    /// The horizon's normal in local coordinates.
    horizon: Option<Vector3<f64>>,
}

/// How a patch lies among an object's triangles.
enum Place {
    Aligned(Aligned),
    Turned(Turned),
}

impl Frame {
    fn new(viewpoint: &Viewpoint) -> Self {
        let to_world = viewpoint.to_world();
        // Orthonormal to 1e-3: it has an inverse.
        let turn = to_world.map(|turn| (turn, turn.try_inverse().unwrap_or_else(|| turn.transpose())));
        let local = |n: Vector3<f64>| to_world.map_or(n, |turn| turn.transpose() * n);
        Self { turn, horizon: viewpoint.horizon().map(local) }
    }

    /// The horizon's normal along right, down and out of a patch.
    fn horizon_along(&self, patch: &Patch) -> Option<[f64; 3]> {
        self.horizon.map(|n| [0, 1, 2].map(|k| patch.axes.column(k).dot(&n)))
    }

    fn is_above(&self, patch: &Patch, [u, v]: [f64; 2]) -> bool {
        self.horizon_along(patch).is_none_or(|n| n[0] * u + (n[1] * v + n[2]) > 0.0)
    }

    fn place(&self, patch: &Patch, sight: &Sight<'_>) -> Place {
        if let (Some(face), None, None) = (patch.face, self.turn, sight.turn) {
            return Place::Aligned(Aligned::new(face, sight.origin));
        }
        let (mut axes, mut dual) = (patch.axes, patch.dual);
        if let Some((turn, inverse)) = &self.turn {
            (axes, dual) = (turn * axes, dual * inverse);
        }
        if let Some(turn) = sight.turn {
            (axes, dual) = (turn * axes, dual * turn.transpose());
        }
        Place::Turned(Turned::new(&axes, &dual, sight.origin))
    }
}
