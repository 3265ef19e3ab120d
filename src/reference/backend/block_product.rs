//! Twins of [`backend::block_product`](crate::backend::block_product): algorithm 1 [Inger 2013] for one vertex, from
//! the definitions.
//!
//! Blocks are numbered as [`BlockLayout`](crate::backend::block_product::BlockLayout) numbers them, pixels of a block
//! (x, y) row after row: no path, no sums that are shared, no tables. Solid angles by quadrature, interpolants by a
//! dense linear solve.

use nalgebra::{DMatrix, Vector3};

use crate::backend::block_product::SampleBasis;
use crate::numeric::GaussLegendre;
use crate::reference::sphere::cube_point;
use crate::sphere::CubeMap;

/// How a block's reflectance is had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// From so many samples along each edge of the block: 1, 2 or 4; or from none, and it is taken to be 0.
    Along(usize),
    /// At every pixel.
    Pixels,
}

/// Where the samples lie along an edge of `side` pixels: the centres of its equal parts, in pixels from the centre of
/// the first.
pub fn positions(side: usize, along: usize) -> Vec<f64> {
    (0..along).map(|k| (k as f64 + 0.5) * side as f64 / along as f64 - 0.5).collect()
}

/// The value at each pixel (row) that one sample of 1 and the others 0 give (column).
///
/// ```math
/// Σ_uv A_uv b_u(x) b_v(y) = ρ̃(x, y) at the samples              [Inger 2013, eq. 4],
/// ```
///
/// with b_u(x) = cos((2x + 1)uπ/2N) — the print has cos(2πxu/N), whose equations are singular — or the powers of x,
/// solved for A and evaluated at the pixels.
pub fn cardinals(side: usize, along: usize, basis: SampleBasis) -> DMatrix<f64> {
    let n = side as f64;
    let function = |u: usize, x: f64| match basis {
        SampleBasis::Cosine => ((2.0 * x + 1.0) * u as f64 * std::f64::consts::PI / (2.0 * n)).cos(),
        // About the middle of the block and in units of its half, so that the equations are well conditioned.
        SampleBasis::Polynomial => ((2.0 * x + 1.0) / n - 1.0).powi(u as i32),
    };
    let both = |term: usize, x: f64, y: f64| function(term % along, x) * function(term / along, y);
    let (at, count) = (positions(side, along), along * along);
    let equations = DMatrix::from_fn(count, count, |node, term| both(term, at[node % along], at[node / along]));
    let pixels =
        DMatrix::from_fn(side * side, count, |pixel, term| both(term, (pixel % side) as f64, (pixel / side) as f64));
    pixels * equations.try_inverse().expect("sub-block centres determine the coefficients")
}

/// One block of a cube map of `grid`² × 6 texels in blocks of `side`².
#[derive(Debug, Clone, Copy)]
pub struct Block {
    face: usize,
    corner: [usize; 2],
    side: usize,
    grid: usize,
}

impl Block {
    /// The block of that number.
    pub fn new(grid: usize, side: usize, block: usize) -> Self {
        let along = grid / side;
        Self { face: block / along / along, corner: [block % along * side, block / along % along * side], side, grid }
    }

    /// The flat texel of a pixel.
    pub fn texel(&self, pixel: usize) -> usize {
        let [x, y] = [pixel % self.side, pixel / self.side];
        (self.face * self.grid + self.corner[1] + y) * self.grid + self.corner[0] + x
    }

    /// The unit direction at (x, y), in pixels from the centre of the first.
    pub fn direction(&self, x: f64, y: f64) -> Vector3<f64> {
        let on_face = |corner: usize, x: f64| 2.0 * (corner as f64 + x + 0.5) / self.grid as f64 - 1.0;
        cube_point(self.face, on_face(self.corner[0], x), on_face(self.corner[1], y)).normalize()
    }

    /// The unit direction of a pixel's centre.
    pub fn pixel(&self, pixel: usize) -> Vector3<f64> {
        self.direction((pixel % self.side) as f64, (pixel / self.side) as f64)
    }

    /// The direction of the centre and the largest angle between it and a corner.
    pub fn cap(&self) -> (Vector3<f64>, f64) {
        let (first, last) = (-0.5, self.side as f64 - 0.5);
        let centre = self.direction(0.5 * (first + last), 0.5 * (first + last));
        let corners = [[first, first], [first, last], [last, first], [last, last]];
        (centre, corners.map(|[x, y]| centre.angle(&self.direction(x, y))).into_iter().fold(0.0, f64::max))
    }
}

/// Radiance × solid angle of every texel, in the order of the grid.
///
/// Solid angles by a Gauss–Legendre rule of 8 × 8 points a texel: good to rounding for 8² texels a face and more.
pub fn weighted(light: &CubeMap<Vector3<f32>>) -> Vec<Vector3<f64>> {
    let side = light.grid().side();
    let rule = GaussLegendre::new(8).expect("8 points");
    let line = |i: usize| 2.0 * i as f64 / side as f64 - 1.0;
    let solid_angle = |x: usize, y: usize| {
        let row = |v: f64| rule.integrate(line(x), line(x + 1), |u| (1.0 + u * u + v * v).powf(-1.5));
        rule.integrate(line(y), line(y + 1), row)
    };
    let face: Vec<f64> = (0..side * side).map(|i| solid_angle(i % side, i / side)).collect();
    light.texels().iter().enumerate().map(|(i, l)| l.cast() * face[i % face.len()]).collect()
}

/// Σ L Ω φ_j over a block for the cardinal function φ_j of each of its samples: the weights that a free block's samples
/// are summed with.
pub fn weights(weighted: &[Vector3<f64>], block: &Block, along: usize, basis: SampleBasis) -> Vec<Vector3<f64>> {
    let cardinals = cardinals(block.side, along, basis);
    let weight = |node: usize| (0..cardinals.nrows()).map(|p| weighted[block.texel(p)] * cardinals[(p, node)]).sum();
    (0..along * along).map(weight).collect()
}

/// What the sum of one vertex is made of.
#[derive(Clone, Copy)]
pub struct Vertex<'a> {
    /// Radiance × solid angle, as [`weighted`] makes it.
    pub light: &'a [Vector3<f64>],
    /// Texels and block pixels along an edge.
    pub sides: [usize; 2],
    /// The visibility in [0, 1] of a flat texel.
    pub visibility: &'a dyn Fn(usize) -> f64,
    /// ρ cos at a direction of the world, viewer and frame being given. Below the horizon it is what the caller says:
    /// 0, or the continuation of what is smooth above.
    pub reflectance: &'a dyn Fn(&Vector3<f64>) -> Vector3<f64>,
}

impl Vertex<'_> {
    /// Σ_blocks Σ_pixels L Ω V ρ̃ by algorithm 1, where ρ̃ interpolates as many samples as `samples` says of a block.
    ///
    /// A block that is partly hidden has at most 4 samples; if it should have more it is summed at its pixels (line
    /// 11).
    pub fn radiance(&self, basis: SampleBasis, samples: &dyn Fn(usize) -> Samples) -> Vector3<f64> {
        let [grid, side] = self.sides;
        let tables = [1, 2, 4].map(|along| (along, cardinals(side, along, basis)));
        let table = |along: usize| tables.iter().find(|t| t.0 == along).map(|t| &t.1).expect("1, 2 or 4 samples");
        let one = |number: usize| {
            let block = Block::new(grid, side, number);
            let seen: Vec<f64> = (0..side * side).map(|p| (self.visibility)(block.texel(p))).collect();
            let is_free = seen.iter().all(|&v| v == 1.0);
            let pixels: Vec<Vector3<f64>> = match samples(number) {
                Samples::Along(0) => return Vector3::zeros(),
                Samples::Along(along) if is_free || along <= 2 => {
                    let at = positions(side, along);
                    let node = |j: usize| (self.reflectance)(&block.direction(at[j % along], at[j / along]));
                    let values: Vec<Vector3<f64>> = (0..along * along).map(node).collect();
                    let table = table(along);
                    let mix = |p: usize| values.iter().enumerate().map(|(j, v)| v * table[(p, j)]).sum();
                    (0..side * side).map(mix).collect()
                }
                _ => (0..side * side).map(|p| (self.reflectance)(&block.pixel(p))).collect(),
            };
            let terms = pixels.iter().zip(&seen).enumerate();
            terms.map(|(p, (f, v))| self.light[block.texel(p)].component_mul(f) * *v).sum()
        };
        (0..6 * (grid / side) * (grid / side)).map(one).sum()
    }
}

/// The samples of a block under the fixed rule.
///
/// ```math
/// angle between centre and mirror direction:      < π/8      < π/4      beyond      [Inger 2013, appendix A]
/// exponent below 30                               2          2          1
/// below 250                                       4          2          1
/// 250 and more                                    pixels     2          1
/// ```
///
/// The print is silent about 30 and 250 and calls a block near that has its centre near: with `radius` 0 it is so here;
/// with the block's angular radius a block is near if any of it is.
pub fn fixed_samples(exponent: f64, angle: f64, radius: f64) -> Samples {
    let angle = angle - radius;
    match exponent {
        _ if angle >= std::f64::consts::FRAC_PI_4 => Samples::Along(1),
        s if s >= 30.0 && angle < std::f64::consts::FRAC_PI_8 => {
            if s < 250.0 {
                Samples::Along(4)
            } else {
                Samples::Pixels
            }
        }
        _ => Samples::Along(2),
    }
}
