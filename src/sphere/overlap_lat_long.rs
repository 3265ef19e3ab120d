//! Exact solid angles that a spherical quadrilateral shares with the pixels of a latitude–longitude grid.
//!
//! In azimuth φ and height s = sin(elevation) the sphere's area is dφ ds: pixels are rectangles, and by Green's theorem
//! a region's share of them follows from its boundary alone, as a font rasteriser fills a glyph. An edge of a cube
//! texel is an arc of a great circle, whatever the rotation, and along it ∫ s dφ has a closed form.
//!
//! With unit normal n = (horizontal n_h, vertical n_s > 0) and t the angle from the circle's highest point,
//! ```math
//! s = n_h cos t,  tan α = sin t/(n_s cos t),  α = φ − φ of the highest point
//! ∫ s dφ = F = atan(n_h sin t/n_s)
//! ```
//! because dα/dt = n_s/(n_s² cos²t + sin²t) and the denominator is n_s² + n_h² sin²t.
//!
//! Neighbouring quadrilaterals walk their common edge in opposite directions, so all shares of a pixel sum to its solid
//! angle: the scheme keeps energy to rounding, and it keeps constants for the same reason.

use std::f64::consts::{PI, TAU};

use nalgebra::{Rotation3, Vector3};

use super::{CubeGrid, Face, LatLongGrid};
use crate::numeric::safe_sqrt;

/// Shares below this many steradians are rounding noise: a few eps of the radian-sized terms they come from.
const NOISE: f64 = 1e-16;

/// Below this n_s an arc is a meridian: numbers near the end of the range have too few digits for α and F to agree.
const MERIDIAN: f64 = 1e-150;

/// Azimuths (of up to 2π) that a boundary leaves open in a column beyond this are more than rounding.
const NOT_CLOSED: f64 = 1e-13;

/// A spherical quadrilateral: unit corners in cyclic order, and the normal of the edge from corner k to corner k + 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quad {
    pub(super) corners: [Vector3<f64>; 4],
    pub(super) normals: [Vector3<f64>; 4],
}

/// The texels of a turned cube as spherical quadrilaterals.
#[derive(Debug, Clone)]
pub(super) struct TexelQuads {
    grid: CubeGrid,
    axes: [[Vector3<f64>; 3]; 6],
}

impl TexelQuads {
    pub(super) fn new(grid: CubeGrid, rotation: &Rotation3<f64>) -> Self {
        Self { grid, axes: Face::ALL.map(|face| face.axes().map(|axis| rotation * Vector3::from(axis))) }
    }

    pub(super) fn quad(&self, index: usize) -> Quad {
        let (face, x, y) = self.grid.texel(index);
        let [right, down, out] = self.axes[face as usize];
        let (u, v) = ([x, x + 1].map(|i| self.grid.line(i)), [y, y + 1].map(|i| self.grid.line(i)));
        let corner = |u: f64, v: f64| (out + right * u + down * v).normalize();
        let row = |v: f64| (down - out * v).normalize();
        let column = |u: f64| (right - out * u).normalize();
        Quad {
            corners: [corner(u[0], v[0]), corner(u[1], v[0]), corner(u[1], v[1]), corner(u[0], v[1])],
            normals: [row(v[0]), column(u[1]), row(v[1]), column(u[0])],
        }
    }
}

/// What one piece of a boundary adds to its column of pixels: `inside` to its own pixel, `above` · height to those
/// above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Column, then row from the bottom up: the order in which columns are summed.
    key: u64,
    inside: f64,
    above: f64,
}

/// The pixel rectangles of a grid in (φ, s).
#[derive(Debug, Clone)]
pub(super) struct LatLongCells {
    grid: LatLongGrid,
    /// Heights of the lines between rows, from 1 down to −1; symmetric.
    lines: Vec<f64>,
    /// (cos, sin) of the azimuths of the lines between columns.
    meridians: Vec<[f64; 2]>,
}

impl LatLongCells {
    pub(super) fn new(grid: LatLongGrid) -> Self {
        let (width, height) = (grid.width(), grid.height());
        // sin of the signed distance from the equator is odd to the last bit.
        let line = |j: usize| (PI * (height as f64 - 2.0 * j as f64) / (2.0 * height as f64)).sin();
        let meridian = |i: usize| {
            let (sin, cos) = (TAU * (i as f64 / width as f64) - PI).sin_cos();
            [cos, sin]
        };
        Self { grid, lines: (0..=height).map(line).collect(), meridians: (0..width).map(meridian).collect() }
    }

    /// Calls `visit` with every pixel that the quadrilateral overlaps and the solid angle they share.
    ///
    /// The quadrilateral's edges are shorter than a half circle, and it does not hold both poles.
    pub(super) fn overlaps(&self, quad: &Quad, pieces: &mut Vec<Piece>, mut visit: impl FnMut(usize, f64)) {
        let (width, height) = (self.grid.width(), self.grid.height());
        // (−z, x, y): azimuth atan2(x, −z) and height y in their usual places. South of the equator everything is
        // mirrored, so that the pole that a quadrilateral may hold is always the one where "above" ends.
        let south = quad.corners.iter().map(|c| c.y).sum::<f64>() < 0.0;
        let frame = |d: &Vector3<f64>| Vector3::new(-d.z, d.x, if south { -d.y } else { d.y });
        let corners = quad.corners.each_ref().map(frame);
        let normals = quad.normals.each_ref().map(frame);
        pieces.clear();
        for k in 0..4 {
            let (p, q) = (&corners[k], &corners[(k + 1) % 4]);
            let forward = p.cross(q).dot(&normals[k]) >= 0.0;
            self.trace(p, q, &if forward { normals[k] } else { -normals[k] }, pieces);
        }
        pieces.sort_unstable_by_key(|piece| piece.key);
        let diagonals = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
        let sign = diagonals.dot(&corners.iter().sum::<Vector3<f64>>()).signum();

        let mut emit = |column: usize, row: usize, share: f64| {
            if share * sign > NOISE {
                let row = if south { height - 1 - row } else { row };
                visit(row * width + column, share * sign);
            }
        };
        let mut rest = &pieces[..];
        while let Some(first) = rest.first() {
            let column = first.key as usize / height;
            let mut below = 0.0;
            let mut next_row = None;
            while let Some(piece) = rest.first().filter(|p| p.key as usize / height == column) {
                let row = height - 1 - piece.key as usize % height;
                for between in (row + 1..next_row.map_or(row + 1, |r: usize| r + 1)).rev() {
                    emit(column, between, below * self.row_height(between));
                }
                let run = rest.iter().take_while(|p| p.key == piece.key).count();
                let inside: f64 = rest[..run].iter().map(|p| p.inside).sum();
                emit(column, row, inside + below * self.row_height(row));
                below += rest[..run].iter().map(|p| p.above).sum::<f64>();
                rest = &rest[run..];
                next_row = row.checked_sub(1);
                if row == 0 {
                    break;
                }
            }
            // A boundary that closes leaves nothing above it, unless it runs round the pole or through it: an arc that
            // meets the pole has no azimuth there to close with.
            if let (true, Some(top)) = (below.abs() > NOT_CLOSED, next_row) {
                (0..=top).for_each(|row| emit(column, row, below * self.row_height(row)));
            }
        }
    }

    fn row_height(&self, row: usize) -> f64 {
        self.lines[row] - self.lines[row + 1]
    }

    /// The row that holds height `s`.
    fn row_of(&self, s: f64) -> usize {
        let height = self.grid.height();
        let angle = safe_sqrt((1.0 - s) * (1.0 + s)).atan2(s);
        let mut row = ((angle / PI * height as f64) as usize).min(height - 1);
        while row > 0 && s > self.lines[row] {
            row -= 1;
        }
        while row + 1 < height && s < self.lines[row + 1] {
            row += 1;
        }
        row
    }

    /// Cuts the arc from `p` to `q`, n ∝ p × q, at the lines of the grid.
    fn trace(&self, p: &Vector3<f64>, q: &Vector3<f64>, n: &Vector3<f64>, pieces: &mut Vec<Piece>) {
        // Walked so that φ increases. On a meridian dφ = 0, and the jump at the pole has nothing above it.
        let (p, q, n, sign) = if n.z < 0.0 { (q, p, -n, -1.0) } else { (p, q, *n, 1.0) };
        if n.z < MERIDIAN {
            return;
        }
        let arc = Arc::new(&n);
        let (start, mut end) = (arc.at(p), arc.at(q));
        if end.alpha < start.alpha {
            end.alpha += TAU;
        }
        if end.alpha - start.alpha > PI + 0.1 {
            return; // An arc of no length, whose ends rounding has swapped.
        }
        // Heights are monotonic between the highest point, α = 0, and the lowest, α = π.
        let summit = Point { alpha: 0.0, s: arc.across, area: 0.0 };
        let lowest = Point { alpha: PI, s: -arc.across, area: 0.0 };
        let falling = |at: &Point| at.alpha > 0.0;
        if start.alpha < 0.0 && end.alpha > 0.0 {
            self.march(&arc, &start, &summit, Way::Up, sign, pieces);
            self.march(&arc, &summit, &end, Way::Down, sign, pieces);
        } else if start.alpha >= 0.0 && end.alpha > PI {
            self.march(&arc, &start, &lowest, Way::Down, sign, pieces);
            self.march(&arc, &lowest, &end, Way::Up, sign, pieces);
        } else {
            let way = if falling(&end) { Way::Down } else { Way::Up };
            self.march(&arc, &start, &end, way, sign, pieces);
        }
    }

    /// Cuts a piece on which the height is monotonic.
    fn march(&self, arc: &Arc, start: &Point, end: &Point, way: Way, sign: f64, pieces: &mut Vec<Piece>) {
        let (width, height) = (self.grid.width() as i64, self.grid.height());
        let column_of = |alpha: f64| ((arc.azimuth + alpha + PI) / TAU * width as f64).floor() as i64;
        let (mut column, last_column) = (column_of(start.alpha), column_of(end.alpha));
        let (mut row, mut last_row) = (self.row_of(start.s), self.row_of(end.s));
        // Equal heights may round to rows in the wrong order.
        last_row = if way == Way::Down { last_row.max(row) } else { last_row.min(row) };
        // A lap more where the piece lies beyond the lowest point.
        let lap = if start.alpha >= PI { TAU } else { 0.0 };
        let clamp = |at: Point| Point { alpha: at.alpha.clamp(start.alpha, end.alpha), ..at };
        let meridian = |column: i64| {
            (column < last_column).then(|| {
                let line = self.meridians[(column + 1).rem_euclid(width) as usize];
                let alpha = (column + 1) as f64 / width as f64 * TAU - PI - arc.azimuth;
                clamp(Point { alpha, s: 0.0, area: arc.area_at(line) })
            })
        };
        let parallel = |row: usize| {
            (row != last_row).then(|| {
                let at = arc.at_height(self.lines[if way == Way::Down { row + 1 } else { row }], way);
                clamp(Point { alpha: at.alpha + lap, ..at })
            })
        };
        let mut from = *start;
        let (mut next_meridian, mut next_parallel) = (meridian(column), parallel(row));
        loop {
            let key = column.rem_euclid(width) as u64 * height as u64 + (height - 1 - row) as u64;
            let mut add = |to: &Point| {
                let turn = to.alpha - from.alpha;
                let inside = self.lines[row] * turn - (to.area - from.area);
                pieces.push(Piece { key, inside: sign * inside, above: sign * turn });
                from = *to;
            };
            match (next_meridian, next_parallel) {
                (None, None) => return add(end),
                (Some(at), other) if other.is_none_or(|o| at.alpha <= o.alpha) => {
                    add(&at);
                    column += 1;
                    next_meridian = meridian(column);
                }
                (_, Some(at)) => {
                    add(&at);
                    row = if way == Way::Down { row + 1 } else { row - 1 };
                    next_parallel = parallel(row);
                }
                (Some(_), None) => unreachable!("the guard above takes a meridian that comes alone"),
            }
        }
    }
}

/// Whether the height rises or falls along a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Up,
    Down,
}

/// A point of an arc: azimuth from the highest point, height, and the antiderivative F of s dφ.
#[derive(Debug, Clone, Copy)]
struct Point {
    alpha: f64,
    s: f64,
    area: f64,
}

/// A great circle that rises to the east, n_s > 0.
#[derive(Debug)]
struct Arc {
    /// n_s.
    up: f64,
    /// n_h.
    across: f64,
    /// Horizontal unit vector below the highest point, and its azimuth.
    east: [f64; 2],
    azimuth: f64,
}

impl Arc {
    fn new(n: &Vector3<f64>) -> Self {
        let across = n.x.hypot(n.y);
        let east = if across > 0.0 { [-n.x / across, -n.y / across] } else { [1.0, 0.0] };
        Self { up: n.z, across, east, azimuth: east[1].atan2(east[0]) }
    }

    /// From (cos t, sin t) alone, so that α and F agree even beside a pole, where a point has no azimuth.
    fn turn(&self, sin: f64, cos: f64) -> (f64, f64) {
        (sin.atan2(self.up * cos), (self.across * sin).atan2(self.up))
    }

    fn at(&self, p: &Vector3<f64>) -> Point {
        let [ex, ey] = self.east;
        let cos = self.up * (ex * p.x + ey * p.y) + self.across * p.z;
        let (alpha, area) = self.turn(ex * p.y - ey * p.x, cos);
        Point { alpha, s: p.z, area }
    }

    /// Where the circle crosses height `s`. Beside the highest point sin t loses half its digits, and F as many: the
    /// curve is flat there, so the area does not.
    fn at_height(&self, s: f64, way: Way) -> Point {
        let cos = (s / self.across).clamp(-1.0, 1.0);
        let sin = safe_sqrt((1.0 - cos) * (1.0 + cos)) * if way == Way::Down { 1.0 } else { -1.0 };
        let (alpha, area) = self.turn(sin, cos);
        Point { alpha, s, area }
    }

    /// F where the circle crosses the meridian of direction (cos φ, sin φ).
    fn area_at(&self, [x, y]: [f64; 2]) -> f64 {
        let [ex, ey] = self.east;
        let (cos, sin) = (ex * x + ey * y, (ex * y - ey * x) * self.up);
        // sin t = n_s sin α / √(cos²α + n_s² sin²α)
        (self.across * sin).atan2(self.up * (cos * cos + sin * sin).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    /// The largest amounts by which shares miss the solid angles of the texels and of the pixels that they make up.
    fn worst_sums(grid: LatLongGrid, boxed: CubeGrid, rotation: &Rotation3<f64>) -> [f64; 2] {
        let (cells, quads) = (LatLongCells::new(grid), TexelQuads::new(boxed, rotation));
        let mut pixels = vec![0.0; grid.len()];
        let (mut pieces, mut worst) = (Vec::new(), [0.0f64; 2]);
        for i in 0..boxed.len() {
            let mut texel = 0.0;
            cells.overlaps(&quads.quad(i), &mut pieces, |k, share| {
                texel += share;
                pixels[k] += share;
            });
            let (_, x, y) = boxed.texel(i);
            worst[0] = worst[0].max((texel - boxed.solid_angle(x, y)).abs());
        }
        for (k, pixel) in pixels.iter().enumerate() {
            worst[1] = worst[1].max((pixel - grid.solid_angle(k / grid.width())).abs());
        }
        worst
    }

    #[test]
    fn shares_make_up_every_texel_and_every_pixel() {
        let about =
            |x, y, z, angle| Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(Vector3::new(x, y, z)), angle);
        let mut turns = vec![Rotation3::identity(), about(0.3, 1.0, -0.4, 2.0), about(1.0, 1.0, 1.0, TAU / 3.0)];
        // Poles on corners and edges of texels, and off them by ever less, down to numbers below the normal range.
        for tiny in [1e-4, 1e-8, 1e-12, 1e-15, 1e-16, 1e-17, 1e-100, 1e-300, 7e-317] {
            turns.push(about(1.0, 0.0, 0.0, tiny));
            turns.push(about(-0.2, 0.1, 1.0, tiny) * about(1.0, 0.0, 0.0, PI / 4.0));
            let [a, b, c] = [tiny, tiny * 1e-16, tiny * 0.3];
            if tiny < 1e-8 {
                turns.push(Rotation3::from_matrix_unchecked(Matrix3::new(1.0, a, c, -a, 1.0, b, -c, -b, 1.0)));
            }
        }
        for (width, height, side) in [(1, 1, 1), (5, 1, 2), (3, 2, 5), (33, 17, 4), (64, 32, 16), (2, 300, 3)] {
            let (grid, boxed) = (LatLongGrid::new(width, height).unwrap(), CubeGrid::new(side).unwrap());
            for turn in &turns {
                let worst = worst_sums(grid, boxed, turn);
                // Each of some tens of pieces a sum is right to a few eps of the terms it is made of, which are below
                // π.
                assert!(worst[0] < 1e-14 && worst[1] < 3e-14, "{width}×{height}, {side}, {turn:?}: {worst:?}");
            }
        }
    }
}
