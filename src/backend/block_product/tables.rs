//! Directions of blocks, structure of arrays.

use super::interpolation::Interpolation;
use super::layout::BlockLayout;
use super::light::NODES;

/// Directions that do not change with light, view or materials.
#[derive(Debug, Clone)]
pub(super) struct Directions {
    /// [block][place]
    pub(super) pixels: [Vec<f32>; 3],
    /// [block][node of 1, 4, 16]
    pub(super) nodes: [Vec<f32>; 3],
    /// [block]
    pub(super) centres: [Vec<f32>; 3],
    /// [block]: cosines of π/8 and π/4, of the angles and of what a block's radius leaves of them.
    pub(super) limits: [Vec<[f32; 2]>; 2],
}

impl Directions {
    pub(super) fn new(layout: &BlockLayout, interpolation: &Interpolation) -> Self {
        use std::f64::consts::{FRAC_PI_4, FRAC_PI_8};
        let mut all = Self {
            pixels: Default::default(),
            nodes: Default::default(),
            centres: Default::default(),
            limits: Default::default(),
        };
        let push = |planes: &mut [Vec<f32>; 3], d: nalgebra::Vector3<f64>| {
            planes.iter_mut().zip(d.iter()).for_each(|(plane, &c)| plane.push(c as f32));
        };
        for block in 0..layout.blocks() {
            for &texel in layout.texels(block) {
                push(&mut all.pixels, layout.grid().direction(texel as usize).into_inner());
            }
            for node in interpolation.levels().iter().flat_map(|level| &level.nodes) {
                push(&mut all.nodes, layout.direction(block, node[0], node[1]));
            }
            push(&mut all.centres, layout.centre(block));
            for (limits, radius) in all.limits.iter_mut().zip([0.0, layout.radius(block)]) {
                limits.push([FRAC_PI_8, FRAC_PI_4].map(|angle| (angle + radius).cos() as f32));
            }
        }
        debug_assert_eq!(all.nodes[0].len(), layout.blocks() * NODES);
        all
    }
}
