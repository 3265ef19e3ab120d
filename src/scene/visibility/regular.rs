//! A patch of cells with one ray each, through the cell's centre.

use super::live::LiveRays;
use super::trace::Rays;
use super::triangle::Triangle;

/// The centre of a column or row as all rays of a patch use it: (i + ½)(2/side) − 1 in `f32`.
///
/// Exact where the side is a power of two, elsewhere within 2⁻²³.
pub(super) fn centre(side: usize, i: usize) -> f32 {
    (i as f32 + 0.5) * (2.0 / side as f32) - 1.0
}

/// Whether the ray through (u, v) meets a triangle.
pub(super) fn is_inside(triangle: &Triangle, [u, v]: [f32; 2]) -> bool {
    triangle.along_patch().iter().all(|n| n[0] * u + (n[1] * v + n[2]) >= 0.0)
}

/// The living rays of such a patch.
pub(super) struct RegularRays<'a> {
    pub(super) live: &'a mut LiveRays,
    pub(super) centres: &'a [f32],
}

impl Rays for RegularRays<'_> {
    const CENTRES: bool = true;

    #[inline(always)]
    fn side(&self) -> usize {
        self.centres.len()
    }

    #[inline(always)]
    fn any(&self, x: [u32; 2], y: [u32; 2]) -> bool {
        self.live.any(x, y)
    }

    #[inline(always)]
    fn kill(&mut self, x: u32, y: u32) {
        self.live.kill(y as usize, x as usize, x as usize + 1);
    }

    /// As computed, E is monotone along a row, so the inner cells of a row are a run. Its ends are guessed from the
    /// root of the line and set right with the predicate itself.
    #[inline(always)]
    fn occlude(&mut self, triangle: &Triangle) {
        let Self { live, centres } = self;
        let (x0, x1) = (triangle.x[0] as usize, triangle.x[1] as usize);
        let half = 0.5 * centres.len() as f32;
        let e = triangle.along_patch();
        let roots = [-half / e[0][0], -half / e[1][0], -half / e[2][0]];
        for y in triangle.y[0] as usize..triangle.y[1] as usize {
            if !live.any(triangle.x, [y as u32, y as u32 + 1]) {
                continue;
            }
            let v = centres[y];
            let base = [e[0][1] * v + e[0][2], e[1][1] * v + e[1][2], e[2][1] * v + e[2][2]];
            let (mut first, mut end) = (x0, x1);
            for k in 0..3 {
                let (n, base) = (e[k][0], base[k]);
                let guess = ((base * roots[k] + half) as i32).max(0) as usize;
                if n > 0.0 {
                    let mut from = guess.min(end).max(first);
                    while from > first && n * centres[from - 1] + base >= 0.0 {
                        from -= 1;
                    }
                    while from < end && n * centres[from] + base < 0.0 {
                        from += 1;
                    }
                    first = from;
                } else if n < 0.0 {
                    let mut to = guess.min(end).max(first);
                    while to > first && n * centres[to - 1] + base < 0.0 {
                        to -= 1;
                    }
                    while to < end && n * centres[to] + base >= 0.0 {
                        to += 1;
                    }
                    end = to;
                } else if base < 0.0 {
                    end = first;
                }
                if first >= end {
                    break;
                }
            }
            if first < end {
                live.kill(y, first, end);
            }
        }
    }
}
