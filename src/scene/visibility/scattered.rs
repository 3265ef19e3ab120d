//! A patch of cells on the disk of a hemisphere with any number of rays each, anywhere in the cell.

use nalgebra::{UnitVector3, Vector3};

use super::live::LiveRays;
use super::trace::Rays;
use super::triangle::Triangle;
use super::view::Reach;
use crate::sphere::HemisphereDisk;

/// The rays of such a patch, cell after cell.
#[derive(Debug, Clone)]
pub(super) struct ScatteredRays {
    side: usize,
    pub(super) reach: Reach,
    /// [cell], and one more: the first ray of a cell.
    starts: Vec<u32>,
    /// Along right, down and out of the patch.
    pub(super) directions: Vec<[f32; 3]>,
    cells: Vec<[u16; 2]>,
    /// [ray]: the element of the map that it belongs to.
    pub(super) elements: Vec<u32>,
}

impl ScatteredRays {
    /// Rays of the upper hemisphere of the patch, each with its element, in `side`² cells; `reach` is
    /// [`Reach::Centres`] if each passes through the centre of its cell.
    pub(super) fn new(side: usize, reach: Reach, rays: &[(UnitVector3<f64>, u32)]) -> Self {
        let cells: Vec<[u16; 2]> = rays.iter().map(|(direction, _)| cell(side, direction)).collect();
        let number = |[x, y]: [u16; 2]| usize::from(y) * side + usize::from(x);
        let mut order: Vec<usize> = (0..rays.len()).collect();
        order.sort_by_key(|&ray| number(cells[ray]));
        let mut starts = vec![0_u32; side * side + 1];
        cells.iter().for_each(|&cell| starts[number(cell) + 1] += 1);
        (0..side * side).for_each(|i| starts[i + 1] += starts[i]);
        Self {
            side,
            reach,
            starts,
            directions: order.iter().map(|&ray| rays[ray].0.cast::<f32>().into_inner().into()).collect(),
            cells: order.iter().map(|&ray| cells[ray]).collect(),
            elements: order.iter().map(|&ray| rays[ray].1).collect(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.directions.len()
    }

    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// The cell (x, y) of a ray.
    pub(super) fn cell(&self, ray: usize) -> [usize; 2] {
        self.cells[ray].map(usize::from)
    }

    /// The rays of a cell.
    #[inline(always)]
    fn rays(&self, x: u32, y: u32) -> std::ops::Range<usize> {
        let cell = y as usize * self.side + x as usize;
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }
}

/// The column and row of a direction.
fn cell(side: usize, direction: &UnitVector3<f64>) -> [u16; 2] {
    let p = HemisphereDisk::point(direction);
    [p.x, p.y].map(|p| (((p + 1.0) * 0.5 * side as f64) as usize).min(side - 1) as u16)
}

/// Whether a direction is above the plane of `normal`, both along the patch.
pub(super) fn is_above(normal: Option<[f64; 3]>, direction: [f32; 3]) -> bool {
    normal.is_none_or(|n| Vector3::from(n).dot(&Vector3::from(direction).cast()) > 0.0)
}

/// Which rays of a patch live: a bit a ray.
#[derive(Debug, Clone, Default)]
pub(super) struct LiveList {
    words: Vec<u64>,
}

impl LiveList {
    /// Keeps the rays whose direction is above the plane of `normal` (its components along right, down and out), or
    /// all; marks the cells that hold one of them. Returns how many there are.
    pub(super) fn keep_above(&mut self, rays: &ScatteredRays, normal: Option<[f64; 3]>, cells: &mut LiveRays) -> u64 {
        self.words.clear();
        self.words.resize(rays.len().div_ceil(64), 0);
        cells.clear();
        let mut count = 0;
        for (i, &direction) in rays.directions.iter().enumerate() {
            if is_above(normal, direction) {
                self.words[i / 64] |= 1 << (i % 64);
                let [x, y] = rays.cell(i);
                cells.revive(y, x);
                count += 1;
            }
        }
        count
    }

    #[inline(always)]
    pub(super) fn lives(&self, ray: usize) -> bool {
        self.words[ray / 64] >> (ray % 64) & 1 == 1
    }

    /// Calls `each` for every ray that lives.
    pub(super) fn for_each(&self, mut each: impl FnMut(usize)) {
        for (w, &word) in self.words.iter().enumerate() {
            let mut bits = word;
            while bits != 0 {
                each(w * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }
}

/// The living rays of a patch, and the cells that hold any.
pub(super) struct ScatteredLive<'a> {
    pub(super) plan: &'a ScatteredRays,
    pub(super) list: &'a mut LiveList,
    pub(super) cells: &'a mut LiveRays,
}

impl Rays for ScatteredLive<'_> {
    const CENTRES: bool = false;

    #[inline(always)]
    fn side(&self) -> usize {
        self.plan.side
    }

    #[inline(always)]
    fn any(&self, x: [u32; 2], y: [u32; 2]) -> bool {
        self.cells.any(x, y)
    }

    fn kill(&mut self, _: u32, _: u32) {
        unreachable!("rays of a disk have directions of their own")
    }

    #[inline(always)]
    fn occlude(&mut self, triangle: &Triangle) {
        let Self { plan, list, cells } = self;
        for y in triangle.y[0]..triangle.y[1] {
            if !cells.any(triangle.x, [y, y + 1]) {
                continue;
            }
            for x in triangle.x[0]..triangle.x[1] {
                let rays = plan.rays(x, y);
                let (some, mut alive) = (!rays.is_empty(), false);
                for ray in rays {
                    if list.lives(ray) {
                        if triangle.is_inside(plan.directions[ray]) {
                            list.words[ray / 64] &= !(1 << (ray % 64));
                        } else {
                            alive = true;
                        }
                    }
                }
                if some && !alive {
                    cells.kill(y as usize, x as usize, x as usize + 1);
                }
            }
        }
    }
}
