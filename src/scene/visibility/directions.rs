//! Which directions are looked along from an origin.

use std::sync::Arc;

use nalgebra::{Matrix3, Unit, UnitVector3, Vector2, Vector3};

use super::fractional::check_samples;
use super::regular::centre;
use super::scattered::ScatteredRays;
use super::view::Reach;
use crate::sphere::{ConcentricSquare, CubeGrid, Face, HemisphereDisk, TopFace};
use crate::{Error, Result};

/// The directions of a visibility map: one for each of its elements, or several spread over each.
///
/// | map | elements | bits |
/// |---|---|---|
/// | [`cube`](Self::cube) | the texels of a cube map | six faces of ⌈side²/64⌉ words each, as [`BinaryVisibility`](super::BinaryVisibility) has them |
/// | [`disk`](Self::disk) | cells of the square around the equal-area disk; those whose centre is outside of it have no direction and are never seen | bit i of all |
/// | [`square`](Self::square) | cells of the concentric square, equal areas of the hemisphere | bit i |
/// | [`top_face`](Self::top_face) | cells of the plane above a surface | bit i |
/// | [`list`](Self::list) | a list of any directions | bit i |
///
/// Directions are local: a [`Viewpoint`](super::Viewpoint) says how they are turned. A cube looks along the world's
/// axes from a viewpoint without a frame and is a local cube from one with the frame of a surface. Cell (x, y) has
/// index y · cells + x, x along local +x and y along local +y; bit i is bit (i mod 64) of word i / 64, spare bits are
/// 0.
///
/// Rays are those of `f32`: within 10⁻⁷ of the directions that are asked for.
///
/// # Example
/// ```
/// use haarmonic::scene::Directions;
/// let disk = Directions::disk(32)?;
/// assert_eq!((disk.len(), disk.words(), disk.direction(0)), (1024, 16, None));
/// assert!(disk.direction(16 * 32 + 16).unwrap().z > 0.99);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Directions {
    plan: Arc<Plan>,
}

#[derive(Debug)]
struct Plan {
    domain: Domain,
    samples: usize,
    /// Cells along a patch.
    side: usize,
    centres: Vec<f64>,
    centres_f32: Vec<f32>,
    patches: Vec<Patch>,
}

#[derive(Debug, Clone, PartialEq)]
enum Domain {
    Cube(CubeGrid),
    Disk(usize),
    Square(usize),
    TopFace(TopFace),
    List(Vec<UnitVector3<f64>>),
}

/// Directions u·right + v·down + out, |u|, |v| ≤ 1, or those of the hemisphere around out.
#[derive(Debug)]
pub(super) struct Patch {
    /// Right, down, out in local coordinates, as columns.
    pub(super) axes: Matrix3<f64>,
    /// Their inverse.
    pub(super) dual: Matrix3<f64>,
    /// The face of the cube that it is.
    pub(super) face: Option<Face>,
    /// How much more than on the face of a cube its coordinates are rounded.
    pub(super) slack: f32,
    pub(super) rays: PatchRays,
}

#[derive(Debug)]
pub(super) enum PatchRays {
    /// In perspective, one through the centre of each cell; the number is that of the patch.
    Regular(usize),
    /// On the disk of the hemisphere around out.
    Scattered(ScatteredRays),
}

impl Patch {
    /// How many cells there are along the patch, those of regular patches being `regular`, and which a ray may be in.
    pub(super) fn cells(&self, regular: usize) -> (usize, Reach) {
        match &self.rays {
            PatchRays::Regular(_) => (regular, Reach::Centres),
            PatchRays::Scattered(rays) => (rays.side(), rays.reach),
        }
    }
}

/// How much wider than for coordinates that are not turned ranges are searched.
const TURNED_SLACK: f32 = 4.0;

/// About this many cells a ray, so that most hold none and a small box that meets no ray is seen to at once.
const CELLS_PER_RAY: usize = 12;

/// The most cells along a patch of scattered rays.
const MOST_CELLS: usize = 512;

impl Directions {
    /// The most cells along a disk or a square.
    pub const MAX_CELLS: usize = 1 << 12;

    /// The texels of a cube map.
    pub fn cube(grid: CubeGrid) -> Self {
        Self::build(Domain::Cube(grid), 1)
    }

    /// Cells of the square [−1, 1]² around the disk of [`HemisphereDisk`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `cells` ≤ [`MAX_CELLS`](Self::MAX_CELLS).
    pub fn disk(cells: usize) -> Result<Self> {
        check_cells(cells)?;
        Ok(Self::build(Domain::Disk(cells), 1))
    }

    /// Cells of the square [−1, 1]² of [`ConcentricSquare`].
    ///
    /// # Errors
    /// As those of [`disk`](Self::disk).
    pub fn square(cells: usize) -> Result<Self> {
        check_cells(cells)?;
        Ok(Self::build(Domain::Square(cells), 1))
    }

    /// The cells of a plane above the surface.
    pub fn top_face(face: TopFace) -> Self {
        Self::build(Domain::TopFace(face), 1)
    }

    /// Any directions.
    ///
    /// # Errors
    /// [`Error::Empty`] without one, [`Error::NotFinite`] for one with NaN or ∞, [`Error::OutOfRange`] for more than
    /// 2³² − 1.
    pub fn list(directions: Vec<UnitVector3<f64>>) -> Result<Self> {
        if directions.is_empty() {
            return Err(Error::Empty { what: "list of directions" });
        }
        if let Some(index) = directions.iter().position(|d| !d.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "direction", index });
        }
        if directions.len() > u32::MAX as usize {
            let got = directions.len() as f64;
            return Err(Error::OutOfRange { what: "number of directions", got, allowed: "below 2^32" });
        }
        Ok(Self::build(Domain::List(directions), 1))
    }

    /// The same map with `samples`² directions an element, for fractional visibility: the centres of its
    /// `samples` × `samples` parts. Those of a disk's parts that lie outside of the disk are left out.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `samples` ≤ 15 and the parts along an edge are as many as a cube or disk may
    /// have cells; a list has 1 sample a direction.
    pub fn with_samples(&self, samples: usize) -> Result<Self> {
        check_samples(samples)?;
        match &self.plan.domain {
            Domain::Cube(grid) => drop(CubeGrid::new(grid.side() * samples)?),
            Domain::Disk(cells) | Domain::Square(cells) => check_cells(cells * samples)?,
            Domain::TopFace(face) => drop(TopFace::new(face.size(), face.cells() * samples)?),
            Domain::List(_) if samples == 1 => {}
            Domain::List(_) => {
                let what = "samples of a direction in a list";
                return Err(Error::OutOfRange { what, got: samples as f64, allowed: "1" });
            }
        }
        Ok(Self::build(self.plan.domain.clone(), samples))
    }

    fn build(domain: Domain, samples: usize) -> Self {
        let (side, patches) = match &domain {
            Domain::Cube(grid) => (grid.side() * samples, cube_patches()),
            Domain::TopFace(face) => (face.cells() * samples, vec![top_patch(face)]),
            Domain::Disk(cells) => {
                // The rim itself has cos θ = 0.
                let inside = |p: &Vector2<f64>| (p.norm_squared() < 1.0).then(|| HemisphereDisk::direction(p));
                let (side, rays) = (cells * samples, grid_rays(*cells, samples, inside));
                (side, vec![disk_patch(false, ScatteredRays::new(side, Reach::Centres, &rays))])
            }
            Domain::Square(cells) => scattered(grid_rays(*cells, samples, |p| Some(ConcentricSquare::direction(p)))),
            Domain::List(list) => scattered(list.iter().zip(0..).map(|(d, i)| (*d, i)).collect()),
        };
        let centres = (0..side).map(|i| (2 * i + 1) as f64 / side as f64 - 1.0).collect();
        let centres_f32 = (0..side).map(|i| centre(side, i)).collect();
        Self { plan: Arc::new(Plan { domain, samples, side, centres, centres_f32, patches }) }
    }

    /// The elements of a map.
    #[expect(clippy::len_without_is_empty, reason = "there is a direction")]
    pub fn len(&self) -> usize {
        match &self.plan.domain {
            Domain::Cube(grid) => grid.len(),
            Domain::Disk(cells) | Domain::Square(cells) => cells * cells,
            Domain::TopFace(face) => face.len(),
            Domain::List(list) => list.len(),
        }
    }

    /// The words of a binary map.
    pub fn words(&self) -> usize {
        match &self.plan.domain {
            Domain::Cube(grid) => 6 * grid.face_len().div_ceil(64),
            _ => self.len().div_ceil(64),
        }
    }

    /// The bit of an element in the words of a binary map.
    ///
    /// # Panics
    /// If there is no such element.
    #[track_caller]
    pub fn bit(&self, element: usize) -> usize {
        assert!(element < self.len(), "element {element} of {}", self.len());
        match &self.plan.domain {
            Domain::Cube(grid) => {
                let face = grid.face_len();
                element / face * face.next_multiple_of(64) + element % face
            }
            _ => element,
        }
    }

    /// The direction of an element's centre in local coordinates, if it has one.
    ///
    /// # Panics
    /// If there is no such element.
    #[track_caller]
    pub fn direction(&self, element: usize) -> Option<UnitVector3<f64>> {
        assert!(element < self.len(), "element {element} of {}", self.len());
        match &self.plan.domain {
            Domain::Cube(grid) => Some(grid.direction(element)),
            Domain::Disk(cells) => {
                let point = cell_centre(*cells, element);
                (point.norm_squared() < 1.0).then(|| HemisphereDisk::direction(&point))
            }
            Domain::Square(cells) => Some(ConcentricSquare::cell_direction(*cells, element)),
            Domain::TopFace(face) => Some(face.cell_direction(element)),
            Domain::List(list) => Some(list[element]),
        }
    }

    /// Directions along an edge of an element.
    pub fn samples(&self) -> usize {
        self.plan.samples
    }

    /// How many directions every element has: what a count of fractional visibility is at most.
    pub fn sample_counts(&self) -> Vec<u8> {
        let full = (self.samples() * self.samples()) as u8;
        let mut counts = vec![0; self.len()];
        for patch in &self.plan.patches {
            match &patch.rays {
                PatchRays::Regular(_) => counts.fill(full),
                PatchRays::Scattered(rays) => rays.elements.iter().for_each(|&i| counts[i as usize] += 1),
            }
        }
        counts
    }

    pub(super) fn patches(&self) -> &[Patch] {
        &self.plan.patches
    }

    /// Cells along every patch.
    pub(super) fn side(&self) -> usize {
        self.plan.side
    }

    /// The centres of a regular patch's cells.
    pub(super) fn centres(&self) -> (&[f64], &[f32]) {
        (&self.plan.centres, &self.plan.centres_f32)
    }

    /// Elements of a regular patch.
    pub(super) fn patch_len(&self) -> usize {
        let cells = self.plan.side / self.plan.samples;
        cells * cells
    }
}

fn check_cells(cells: usize) -> Result<()> {
    if (1..=Directions::MAX_CELLS).contains(&cells) {
        return Ok(());
    }
    Err(Error::OutOfRange { what: "cells along a map of directions", got: cells as f64, allowed: "in 1…4096" })
}

/// The centre of cell i of the square [−1, 1]².
fn cell_centre(cells: usize, i: usize) -> Vector2<f64> {
    let centre = |i: usize| (2 * i + 1) as f64 / cells as f64 - 1.0;
    Vector2::new(centre(i % cells), centre(i / cells))
}

/// The directions of all parts of the cells of a square, with the number of their cell.
fn grid_rays(
    cells: usize,
    samples: usize,
    direction: impl Fn(&Vector2<f64>) -> Option<UnitVector3<f64>>,
) -> Vec<(UnitVector3<f64>, u32)> {
    let fine = cells * samples;
    let ray = |i: usize| {
        let element = i / fine / samples * cells + i % fine / samples;
        Some((direction(&cell_centre(fine, i))?, element as u32))
    };
    (0..fine * fine).filter_map(ray).collect()
}

fn cube_patches() -> Vec<Patch> {
    let patch = |(number, face): (usize, Face)| {
        let axes = Matrix3::from_columns(&face.axes().map(Vector3::from));
        let rays = PatchRays::Regular(number);
        Patch { axes, dual: axes.transpose(), face: Some(face), slack: TURNED_SLACK, rays }
    };
    Face::ALL.into_iter().enumerate().map(patch).collect()
}

fn top_patch(face: &TopFace) -> Patch {
    let half = 0.5 * face.size();
    Patch {
        axes: Matrix3::from_diagonal(&Vector3::new(half, half, 1.0)),
        dual: Matrix3::from_diagonal(&Vector3::new(1.0 / half, 1.0 / half, 1.0)),
        face: None,
        slack: TURNED_SLACK / half.min(1.0) as f32,
        rays: PatchRays::Regular(0),
    }
}

/// Rays in the patches of the two hemispheres, and the cells along each.
fn scattered(rays: Vec<(UnitVector3<f64>, u32)>) -> (usize, Vec<Patch>) {
    let (upper, lower): (Vec<_>, Vec<_>) = rays.into_iter().partition(|(direction, _)| direction.z >= 0.0);
    let lower: Vec<_> = lower.into_iter().map(|(d, i)| (Unit::new_unchecked(mirrored(&d)), i)).collect();
    let cells = ((CELLS_PER_RAY * upper.len().max(lower.len())) as f64).sqrt() as usize;
    let side = cells.next_power_of_two().min(MOST_CELLS);
    let halves = [(false, upper), (true, lower)].into_iter().filter(|(_, rays)| !rays.is_empty());
    let patch =
        |(is_lower, rays): (bool, Vec<_>)| disk_patch(is_lower, ScatteredRays::new(side, Reach::Touched, &rays));
    (side, halves.map(patch).collect())
}

/// The hemisphere around local +z, or the one around −z mirrored.
fn disk_patch(is_lower: bool, rays: ScatteredRays) -> Patch {
    let axes = if is_lower { Matrix3::from_diagonal(&mirrored(&Vector3::repeat(1.0))) } else { Matrix3::identity() };
    Patch { axes, dual: axes, face: None, slack: TURNED_SLACK, rays: PatchRays::Scattered(rays) }
}

fn mirrored(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, -v.z)
}
