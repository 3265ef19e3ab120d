//! Blocks on which errors are measured.

use nalgebra::{Rotation3, Unit, Vector3};

use super::errors::{Errors, spread};
use super::lanes::{Lanes, Probe, Sums};
use crate::backend::block_product::interpolation::{Interpolation, Level};
use crate::backend::block_product::layout::BlockLayout;

use crate::backend::block_product::tiles::TILE;

/// A block's directions where an error is measured, about its centre on +z.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// Directions of pixels, and which pixels they are.
    pixels: Vec<(Vector3<f64>, usize)>,
    /// Directions of the nodes of 1, 4 and 16 samples.
    nodes: [Vec<Vector3<f64>>; 3],
}

impl Probe {
    /// Of a shape turned about its centre.
    fn new(shape: &Shape, roll: f64, interpolation: &Interpolation, side: usize) -> Self {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), roll);
        let eight = |all: &[Vector3<f64>]| {
            let mut eight = [[0.0; TILE]; 3];
            for lane in 0..TILE {
                let d = turn * all[lane.min(all.len() - 1)];
                eight.iter_mut().zip(d.iter()).for_each(|(axis, &c)| axis[lane] = c as f32);
            }
            eight
        };
        let chosen: Vec<&(Vector3<f64>, usize)> = shape.pixels.iter().filter(|(_, p)| is_probed(*p, side)).collect();
        let places: Vec<Vector3<f64>> = chosen.iter().map(|(d, _)| *d).collect();
        let nodes: Vec<Vector3<f64>> = shape.nodes.iter().flatten().copied().collect();
        let pixels: Vec<usize> = chosen.iter().map(|(_, pixel)| *pixel).collect();
        let [_, four, sixteen] = interpolation.levels();
        Self {
            pixels: places.chunks(TILE).map(eight).collect(),
            nodes: std::array::from_fn(|k| eight(&nodes[k * TILE..])),
            four: cardinals(four, &pixels),
            sixteen: cardinals(sixteen, &pixels),
            radius: shape.pixels.iter().map(|(d, _)| d.z.min(1.0).acos()).fold(0.0, f64::max),
        }
    }
}

/// The cardinal functions of a level at pixels, eight by eight.
fn cardinals<const COUNT: usize>(level: &Level, pixels: &[usize]) -> Vec<[Lanes; COUNT]> {
    let eight = |pixels: &[usize]| {
        std::array::from_fn(|node| std::array::from_fn(|lane| level.cardinals[node][pixels[lane]] as f32))
    };
    pixels.chunks_exact(TILE).map(eight).collect()
}

/// One pixel of every 2 × 2, each of the four in turn; all of the smallest blocks.
fn is_probed(pixel: usize, side: usize) -> bool {
    let (x, y) = (pixel % side, pixel / side);
    side <= 8 || 2 * (y % 2) + x % 2 == (x / 2 + 2 * (y / 2)) % 4
}

/// Blocks of every shape and how functions on them are interpolated.
#[derive(Debug, Clone)]
pub(in crate::backend::block_product) struct Gauge {
    interpolation: Interpolation,
    pub(super) shapes: Vec<Shape>,
    pub(super) radius: f64,
    /// Pixels along an edge of a block.
    pub(super) side: usize,
    /// See [`spread`].
    pub(super) spread: f64,
    /// Shapes alike in size, smallest first: what stands for each.
    pub(super) families: Vec<Vec<Probe>>,
    /// [shape]
    #[cfg(test)]
    family_of_shape: Vec<u8>,
    /// [block]: its family.
    family_of: Vec<u8>,
    /// What stands for all shapes.
    pub(super) all: Vec<Vec<Probe>>,
}

/// How much less may be left out of a block of a lobe about the half vector than of one about the mirror direction: its
/// tails are long, so that most blocks would leave out as much as they may, all of one sign. A GGX lobe of roughness .1
/// gains 4.4 dB, for a tenth of the time.
pub(super) const LEFT_OUT: f32 = 4.0;

/// Groups of shapes that are told apart.
const GROUPS: usize = 3;

/// Values of a function, or the components of a vector.
pub(super) type Values = Vector3<f64>;

impl Gauge {
    pub(in crate::backend::block_product) fn new(layout: &BlockLayout, interpolation: &Interpolation) -> Self {
        let side = layout.side();
        let shape = |&block: &usize| {
            let centre = Unit::new_normalize(layout.centre(block));
            let turn =
                Rotation3::rotation_between(&centre, &Vector3::z_axis()).expect("the centre of +X's block is not -z");
            let at = |x: f64, y: f64| turn * layout.direction(block, x, y);
            let pixels = (0..side * side).map(|p| (at((p % side) as f64, (p / side) as f64), p)).collect();
            let nodes =
                interpolation.levels().each_ref().map(|level| level.nodes.iter().map(|n| at(n[0], n[1])).collect());
            Shape { pixels, nodes }
        };
        let blocks = layout.shapes();
        let radius = blocks.iter().map(|&block| layout.radius(block)).fold(0.0, f64::max);
        let shapes: Vec<Shape> = blocks.iter().map(shape).collect();
        let mut by_size: Vec<usize> = (0..blocks.len()).collect();
        by_size.sort_by(|&a, &b| layout.radius(blocks[a]).total_cmp(&layout.radius(blocks[b])));
        let runs: Vec<&[usize]> = by_size.chunks(blocks.len().div_ceil(GROUPS)).collect();
        let probe = |shape: usize, roll: f64| Probe::new(&shapes[shape], roll, interpolation, side);
        // A block lies across the plane of incidence at any angle: straight and askew stand for all.
        let both = |run: &&[usize]| vec![probe(run[0], 0.0), probe(run[run.len() - 1], std::f64::consts::FRAC_PI_4)];
        let family_of_shape = |shape: usize| runs.iter().position(|run| run.contains(&shape)).unwrap_or(0) as u8;
        Self {
            interpolation: interpolation.clone(),
            families: runs.iter().map(both).collect(),
            #[cfg(test)]
            family_of_shape: (0..blocks.len()).map(family_of_shape).collect(),
            family_of: (0..layout.blocks()).map(|block| family_of_shape(layout.shape_of(block))).collect(),
            all: vec![both(&&by_size[..])],
            shapes,
            radius,
            side,
            spread: spread(layout.blocks()),
        }
    }

    #[cfg(test)]
    pub(super) fn family_of_shape(&self, shape: usize) -> u8 {
        self.family_of_shape[shape]
    }

    /// [block]: the family of its shape.
    pub(in crate::backend::block_product) fn families(&self) -> &[u8] {
        &self.family_of
    }

    /// What sums over a probe make: rms, bias and mean of 0, 1, 4 and 16 samples.
    ///
    /// `peak` is what the lobe reaches in the block, if it may have been missed. A mean error that cancels at one place
    /// or turn of the block does not at the next: it is taken for an eighth of the root mean square at least.
    pub(super) fn errors_of(&self, sums: &Sums, probe: &Probe, peak: f32) -> [[f32; 4]; 3] {
        let count = (probe.pixels.len() * TILE) as f32;
        let missed = peak / self.side as f32;
        let rms = sums.squares.map(|x| (x / count).sqrt());
        let is_missed = rms[0] < missed || peak.is_infinite();
        let mut errors = [[0.0; 4]; 3];
        for k in 0..4 {
            let weight = if k == 0 { self.spread as f32 * LEFT_OUT } else { 1.0 };
            let floor = if is_missed { missed } else { 0.0 };
            let pixel = floor / self.side as f32;
            errors[0][k] = (rms[k] * weight).max(floor);
            errors[1][k] = (sums.signed[k] / count * weight).max(pixel).max(0.125 * errors[0][k]);
            errors[2][k] = (sums.sizes[k] / count * weight).max(pixel);
        }
        errors
    }

    /// The errors over a shape.
    pub(super) fn errors(&self, shape: &Shape, f: impl Fn(&Vector3<f64>) -> Values) -> Errors {
        let nodes = shape.nodes.each_ref().map(|nodes| nodes.iter().map(&f).collect::<Vec<Values>>());
        let (mut rms, mut bias, mut mean) = ([0.0; 4], [Values::zeros(); 4], [0.0; 4]);
        let count = shape.pixels.len() as f64;
        for (direction, pixel) in &shape.pixels {
            let value = f(direction);
            for k in 0..4 {
                let guess = match k {
                    0 => Values::zeros(),
                    _ => {
                        let cardinals = &self.interpolation.levels()[k - 1].cardinals;
                        nodes[k - 1].iter().zip(cardinals).map(|(v, c)| v * c[*pixel]).sum()
                    }
                };
                let error: Values = value - guess;
                rms[k] += error.norm_squared();
                mean[k] += error.norm();
                bias[k] += error;
            }
        }
        // What is left out is of one sign: such errors add up over the blocks, others average out.
        let weighed = |k: usize, x: f64| if k == 0 { x * self.spread } else { x };
        Errors {
            rms: std::array::from_fn(|k| weighed(k, (rms[k] / count).sqrt())),
            bias: std::array::from_fn(|k| weighed(k, bias[k].norm() / count)),
            mean: std::array::from_fn(|k| weighed(k, mean[k] / count)),
        }
    }
}
