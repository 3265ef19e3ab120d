//! Blocks on which errors are measured.

use nalgebra::{Rotation3, Unit, Vector3};

use super::errors::{Errors, spread};
use crate::backend::block_product::interpolation::Interpolation;
use crate::backend::block_product::layout::BlockLayout;

/// A block's directions where an error is measured, about its centre on +z.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// Directions of pixels, and which pixels they are.
    pixels: Vec<(Vector3<f64>, usize)>,
    /// Directions of the nodes of 1, 4 and 16 samples.
    nodes: [Vec<Vector3<f64>>; 3],
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
    spread: f64,
}

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
        Self {
            interpolation: interpolation.clone(),
            shapes: blocks.iter().map(shape).collect(),
            radius,
            side,
            spread: spread(layout.blocks()),
        }
    }

    /// The largest radius of a block.
    pub(in crate::backend::block_product) fn radius(&self) -> f64 {
        self.radius
    }

    /// The errors over every `stride`-th pixel of a shape.
    ///
    /// `f` is None below the horizon, where no pixel counts and no sample can be taken.
    pub(super) fn errors(&self, shape: &Shape, stride: usize, f: impl Fn(&Vector3<f64>) -> Option<Values>) -> Errors {
        let nodes = shape.nodes.each_ref().map(|nodes| nodes.iter().map(&f).collect::<Option<Vec<Values>>>());
        let (mut rms, mut bias, mut mean) = ([0.0; 4], [Values::zeros(); 4], [0.0; 4]);
        let mut count = 0.0;
        // A stride of 3 does not divide a row: all columns have their turn.
        for (direction, pixel) in shape.pixels.iter().skip(stride / 2).step_by(stride) {
            count += 1.0;
            let Some(value) = f(direction) else { continue };
            for k in 0..4 {
                let guess = match k {
                    0 => Values::zeros(),
                    _ => {
                        let Some(nodes) = &nodes[k - 1] else { continue };
                        let cardinals = &self.interpolation.levels()[k - 1].cardinals;
                        nodes.iter().zip(cardinals).map(|(v, c)| v * c[*pixel]).sum()
                    }
                };
                let error: Values = value - guess;
                rms[k] += error.norm_squared();
                mean[k] += error.norm();
                bias[k] += error;
            }
        }
        // What is left out is of one sign: such errors add up over the blocks, others average out.
        let never = |k: usize, x: f64| match k {
            0 => x * self.spread,
            _ if nodes[k - 1].is_none() => f64::INFINITY,
            _ => x,
        };
        Errors {
            rms: std::array::from_fn(|k| never(k, (rms[k] / count).sqrt())),
            bias: std::array::from_fn(|k| never(k, bias[k].norm() / count)),
            mean: std::array::from_fn(|k| never(k, mean[k] / count)),
        }
    }
}
