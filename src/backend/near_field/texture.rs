//! A turned texture on an upright grid, by exact areas of overlap, and the derivatives of that.

use nalgebra::Vector3;

/// How a texture lies in its plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub(super) size: [f64; 2],
    pub(super) rotation: f64,
}

/// What derivatives are taken with respect to: the two sizes, then the rotation.
pub(super) const PARAMETERS: usize = 3;

impl Placement {
    /// Lengths of the upright rectangle around the turned one.
    pub(super) fn extent(&self) -> [f64; 2] {
        let (sin, cos) = self.turn();
        let [w, h] = self.size;
        [w * cos.abs() + h * sin.abs(), w * sin.abs() + h * cos.abs()]
    }

    /// ∂ extent/∂ parameter, right-hand: [axis][parameter].
    pub(super) fn extent_slopes(&self) -> [[f64; PARAMETERS]; 2] {
        self.dual_extent().map(|extent| extent.slope)
    }

    fn turn(&self) -> (f64, f64) {
        if self.rotation == 0.0 { (0.0, 1.0) } else { self.rotation.sin_cos() }
    }

    fn dual_turn(&self) -> (Dual, Dual) {
        let (sin, cos) = self.turn();
        (Dual { value: sin, slope: [0.0, 0.0, cos] }, Dual { value: cos, slope: [0.0, 0.0, -sin] })
    }

    fn dual_extent(&self) -> [Dual; 2] {
        let (sin, cos) = self.dual_turn();
        let (sin, cos) = (sin.abs(), cos.abs());
        let [w, h] = self.dual_size();
        [w * cos + h * sin, w * sin + h * cos]
    }

    fn dual_size(&self) -> [Dual; 2] {
        [Dual { value: self.size[0], slope: [1.0, 0.0, 0.0] }, Dual { value: self.size[1], slope: [0.0, 1.0, 0.0] }]
    }

    /// The mean of the texture in each of `side`² cells of the extent.
    pub(super) fn resample(
        &self,
        [width, height]: [usize; 2],
        radiance: impl Fn(usize) -> Vector3<f32>,
        side: usize,
        mut out: [&mut [f32]; 3],
    ) {
        out.iter_mut().for_each(|plane| plane.fill(0.0));
        let mut add = |cell: usize, area: f64, radiance: Vector3<f32>| {
            for (plane, c) in out.iter_mut().zip(radiance.iter()) {
                plane[cell] += (area * f64::from(*c)) as f32;
            }
        };
        if self.turn() == (0.0, 1.0) {
            // Upright: overlaps of intervals, one axis after the other.
            for y in 0..height {
                each_overlap(y, height, side, |row, along_y| {
                    for x in 0..width {
                        let radiance = radiance(y * width + x);
                        each_overlap(x, width, side, |column, along_x| {
                            add(row * side + column, along_x * along_y, radiance);
                        });
                    }
                });
            }
            return;
        }
        let grid = Grid::<f64>::new(self.size, self.extent(), self.turn(), [width, height], side);
        for texel in 0..width * height {
            let radiance = radiance(texel);
            if radiance != Vector3::zeros() {
                grid.each_cell([texel % width, texel / width], |cell, area| add(cell, area, radiance));
            }
        }
    }

    /// The transpose of [`resample`](Self::resample): from ∂J/∂cell, the derivatives of J in the texels and in the
    /// parameters (of the radiance in the cells alone, their number and not their place being kept).
    pub(super) fn adjoint(
        &self,
        [width, height]: [usize; 2],
        radiance: impl Fn(usize) -> Vector3<f32>,
        side: usize,
        cotangent: [&[f32]; 3],
        texels: &mut [Vector3<f64>],
    ) -> [f64; PARAMETERS] {
        let grid = Grid::<Dual>::new(self.dual_size(), self.dual_extent(), self.dual_turn(), [width, height], side);
        let mut sum = [0.0; PARAMETERS];
        for (texel, gradient) in texels.iter_mut().enumerate() {
            let radiance = radiance(texel).cast::<f64>();
            *gradient = Vector3::zeros();
            grid.each_cell([texel % width, texel / width], |cell, area| {
                let g = Vector3::from(cotangent.map(|plane| f64::from(plane[cell])));
                *gradient += g * area.value;
                let along = g.dot(&radiance);
                sum.iter_mut().zip(area.slope).for_each(|(sum, slope)| *sum += along * slope);
            });
        }
        sum
    }
}

/// Calls `each(cell, overlap)` for the cells of `side` that interval `i` of `count` lies over, both over [0, 1]; the
/// overlap is in cells.
fn each_overlap(i: usize, count: usize, side: usize, mut each: impl FnMut(usize, f64)) {
    // In integers: ends at i·side and (i + 1)·side, cells of count.
    let (start, end) = (i * side, (i + 1) * side);
    for cell in start / count..end.div_ceil(count) {
        let overlap = end.min((cell + 1) * count) - start.max(cell * count);
        each(cell, overlap as f64 / count as f64);
    }
}

/// A number, with or without derivatives.
trait Number:
    Copy
    + From<f64>
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
{
    fn value(self) -> f64;
}

impl Number for f64 {
    fn value(self) -> f64 {
        self
    }
}

/// A number and its derivatives in the parameters.
#[derive(Debug, Clone, Copy)]
struct Dual {
    value: f64,
    slope: [f64; PARAMETERS],
}

impl Dual {
    /// |x|, at 0 with the derivative of x as it grows.
    fn abs(self) -> Self {
        // −0 and 0 alike: what leaves 0 upwards keeps its slope, what leaves it downwards turns it.
        let falls = self.value < 0.0 || (self.value == 0.0 && self.slope[PARAMETERS - 1] < 0.0);
        if falls { Self::from(0.0) - self } else { self }
    }

    fn new(value: f64, slope: impl Fn(usize) -> f64) -> Self {
        Self { value, slope: std::array::from_fn(slope) }
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self { value, slope: [0.0; PARAMETERS] }
    }
}

impl std::ops::Add for Dual {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self::new(self.value + b.value, |k| self.slope[k] + b.slope[k])
    }
}

impl std::ops::Sub for Dual {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self::new(self.value - b.value, |k| self.slope[k] - b.slope[k])
    }
}

#[expect(clippy::suspicious_arithmetic_impl, reason = "the product's rule")]
impl std::ops::Mul for Dual {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self::new(self.value * b.value, |k| self.slope[k] * b.value + self.value * b.slope[k])
    }
}

#[expect(clippy::suspicious_arithmetic_impl, reason = "the quotient's rule")]
impl std::ops::Div for Dual {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Self::new(value, |k| (self.slope[k] - value * b.slope[k]) / b.value)
    }
}

impl Number for Dual {
    fn value(self) -> f64 {
        self.value
    }
}

type Point<N> = [N; 2];

/// Where texels lie in a grid of `side`² unit cells.
struct Grid<N> {
    side: usize,
    /// The corner of texel (0, 0), and the steps to the next texel along a row and along a column.
    origin: Point<N>,
    right: Point<N>,
    down: Point<N>,
}

/// The most corners of a quadrilateral that four lines have cut, each of which leaves at most half as many more:
/// rounding may make it a little less than convex.
const CORNERS: usize = 20;

/// A polygon of few corners.
struct Polygon<N> {
    corners: [Point<N>; CORNERS],
    len: usize,
}

impl<N: Number> Grid<N> {
    fn new(size: [N; 2], extent: [N; 2], (sin, cos): (N, N), [width, height]: [usize; 2], side: usize) -> Self {
        let cells = N::from(side as f64);
        let to_grid = |x: N, y: N| [x / extent[0] * cells, y / extent[1] * cells];
        let (w, h) = (size[0], size[1]);
        let (half, zero) = (N::from(0.5), N::from(0.0));
        let right = to_grid(w * cos, w * sin);
        let down = to_grid(zero - h * sin, h * cos);
        let middle = half * cells;
        let origin = [0, 1].map(|k| middle - half * (right[k] + down[k]));
        let share = |step: Point<N>, count: usize| step.map(|s| s / N::from(count as f64));
        Self { side, origin, right: share(right, width), down: share(down, height) }
    }

    /// Calls `each(cell, area)` for the cells that a texel lies over.
    fn each_cell(&self, [x, y]: [usize; 2], mut each: impl FnMut(usize, N)) {
        let corner = |i: usize, j: usize| -> Point<N> {
            let (i, j) = (N::from((x + i) as f64), N::from((y + j) as f64));
            [0, 1].map(|k| self.origin[k] + i * self.right[k] + j * self.down[k])
        };
        let quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        let last = self.side - 1;
        let range = |k: usize| {
            let ends = quad.map(|p| p[k].value());
            let (low, high) = ends.iter().fold((f64::MAX, f64::MIN), |(l, h), &e| (l.min(e), h.max(e)));
            // `as` holds what rounding takes outside.
            ((low as usize).min(last), (high as usize).min(last))
        };
        let ((left, right), (top, bottom)) = (range(0), range(1));
        if (left, top) == (right, bottom) {
            return each(top * self.side + left, area(&quad));
        }
        for row in top..=bottom {
            for column in left..=right {
                let mut part = Polygon { corners: [quad[0]; CORNERS], len: 4 };
                part.corners[..4].copy_from_slice(&quad);
                // The outer cells reach on for ever, so that nothing is lost to rounding.
                for (axis, cell) in [(0, column), (1, row)] {
                    if cell > 0 {
                        part = part.keep(axis, 1.0, cell as f64);
                    }
                    if cell < last {
                        part = part.keep(axis, -1.0, (cell + 1) as f64);
                    }
                }
                if part.len > 2 {
                    each(row * self.side + column, area(&part.corners[..part.len]));
                }
            }
        }
    }
}

impl<N: Number> Polygon<N> {
    /// What lies on the side `sign`·(x − line) ≥ 0 of a line across an axis    [Sutherland & Hodgman 1974].
    fn keep(&self, axis: usize, sign: f64, line: f64) -> Self {
        let mut kept = Self { corners: self.corners, len: 0 };
        for i in 0..self.len {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % self.len]);
            let [inside_a, inside_b] = [a, b].map(|p| sign * (p[axis].value() - line) >= 0.0);
            if inside_a {
                kept.push(a);
            }
            if inside_a != inside_b {
                let t = (N::from(line) - a[axis]) / (b[axis] - a[axis]);
                let mut cut = [0, 1].map(|k| a[k] + t * (b[k] - a[k]));
                cut[axis] = N::from(line);
                kept.push(cut);
            }
        }
        kept
    }

    fn push(&mut self, corner: Point<N>) {
        self.corners[self.len] = corner;
        self.len += 1;
    }
}

/// The area of a convex polygon whose corners run from x to y.
fn area<N: Number>(corners: &[Point<N>]) -> N {
    let first = corners[0];
    let mut twice = N::from(0.0);
    for pair in corners[1..].windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|p| [p[0] - first[0], p[1] - first[1]]);
        twice = twice + (a[0] * b[1] - a[1] * b[0]);
    }
    twice * N::from(0.5)
}
