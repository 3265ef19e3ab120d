//! Directions of blocks, structure of arrays.

use nalgebra::Vector3;

use super::interpolation::Interpolation;
use super::interpolation::NODES;
use super::layout::BlockLayout;
use super::tiles::{Eight, TILE, Tiles};

/// The largest angles between a centre and what lies around it, in radians.
#[derive(Debug, Clone, Copy)]
pub(super) struct Radii {
    pub(super) tile: f64,
    pub(super) pixel: f64,
}

/// Directions that do not change with light, view or materials.
#[derive(Debug, Clone)]
pub(super) struct Directions {
    /// [block][tile] x, y, z
    pub(super) pixels: Vec<Eight<3>>,
    /// [block][node of 1, 4, 16]
    pub(super) nodes: [Vec<f32>; 3],
    /// [block][tile], the middle
    pub(super) tiles: [Vec<f32>; 3],
    pub(super) radii: Radii,
    /// [block]
    pub(super) centres: [Vec<f32>; 3],
    /// [block]: cosines of π/8 and π/4, of the angles and of what a block's radius leaves of them.
    pub(super) limits: [Vec<[f32; 2]>; 2],
}

impl Directions {
    pub(super) fn new(layout: &BlockLayout, tiles: &Tiles, interpolation: &Interpolation) -> Self {
        use std::f64::consts::{FRAC_PI_4, FRAC_PI_8};
        let mut all = Self {
            pixels: Default::default(),
            nodes: Default::default(),
            tiles: Default::default(),
            // Half a diagonal in the middle of a face.
            radii: Radii { tile: 0.0, pixel: std::f64::consts::SQRT_2 / layout.grid().side() as f64 },
            centres: Default::default(),
            limits: Default::default(),
        };
        let push = |planes: &mut [Vec<f32>; 3], d: Vector3<f64>| {
            planes.iter_mut().zip(d.iter()).for_each(|(plane, &c)| plane.push(c as f32));
        };
        for block in 0..layout.blocks() {
            for pixels in tiles.pixels().chunks_exact(TILE) {
                let texels = pixels.iter().map(|&pixel| layout.texel(block, pixel as usize));
                let places = texels.map(|texel| layout.grid().direction(texel).into_inner());
                let centre = places.clone().sum::<Vector3<f64>>().normalize();
                push(&mut all.tiles, centre);
                let mut eight = [[0.0; TILE]; 3];
                for (lane, d) in places.clone().enumerate() {
                    eight.iter_mut().zip(d.iter()).for_each(|(axis, &c)| axis[lane] = c as f32);
                }
                all.pixels.push(eight);
                all.radii.tile = places.map(|d| d.angle(&centre)).fold(all.radii.tile, f64::max);
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
