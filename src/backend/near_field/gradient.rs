//! The adjoint: what a loss of the radiance says of a light.

use nalgebra::Vector3;

use super::incident::IncidentLight;
use super::light::PlanarLight;
use super::pixels::PixelRows;
use super::relighter::Relighter;
use super::texture::PARAMETERS;
use crate::affine::{Axis, Parameter, PixelOperator};
use crate::error::check_length;
use crate::{Error, Result, parallel};

/// The derivatives of a loss J in everything that a light has.
#[derive(Debug, Clone, PartialEq)]
pub struct LightGradient {
    /// In the centre, in world coordinates.
    pub centre: Vector3<f64>,
    /// In the two sizes.
    pub size: [f64; 2],
    /// In the angle.
    pub rotation: f64,
    /// In the radiance of each texel, before the mask.
    pub texture: Vec<Vector3<f64>>,
}

/// Vertices whose derivatives are summed together, in order.
const TOGETHER: usize = 256;

/// What some vertices add up to: derivatives in the light's centre in the frame, in its extent, and in its pixels.
struct Sums {
    centre: Vector3<f64>,
    extent: [f64; 2],
    pixels: [Vec<f64>; 3],
}

impl Relighter<'_> {
    /// The gradient of a loss J in one of the lights, from ∂J/∂B of each vertex: the transpose of
    /// [`relight`](Self::relight).
    ///
    /// `light` is what was set. Derivatives in place and size go through the affine maps of every vertex, those in
    /// texture, rotation and size through the light's pixels; right-hand where there is a kink, as of the extent of an
    /// upright light that begins to turn. Wavelets that the light has not kept do not count, and neither do targets
    /// that were not chosen: it is the gradient of the frame with all targets.
    ///
    /// In parallel, with the same bits for any number of threads. Cost: about five times that of a frame through
    /// pixels. What is allocated is the images of the transport, if there are none yet, and an image for each 256
    /// vertices.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if there is no such light.
    ///
    /// # Panics
    /// Unless `cotangent` has one value a vertex.
    #[track_caller]
    pub fn gradient(&mut self, index: usize, light: &PlanarLight, cotangent: &[Vector3<f32>]) -> Result<LightGradient> {
        let vertices = self.transport.vertices();
        check_length("derivatives of the vertices", vertices, cotangent.len());
        if index >= self.lights.len() {
            let allowed = "below the number of lights that were set";
            return Err(Error::OutOfRange { what: "number of a light", got: index as f64, allowed });
        }
        self.decode()?;
        let Some(pixels) = &self.pixels else { unreachable!("just decoded") };
        let (incident, side) = (&self.lights[index], self.settings.source_side);
        let parts = parallel::map(vertices.div_ceil(TOGETHER), |part| {
            let range = part * TOGETHER..((part + 1) * TOGETHER).min(vertices);
            self.sum(incident, pixels, range, cotangent)
        });
        let mut centre = Vector3::zeros();
        let (mut extent, mut planes) = ([0.0; 2], [(); 3].map(|()| vec![0.0; side * side]));
        for part in parts {
            centre += part.centre;
            (0..2).for_each(|axis| extent[axis] += part.extent[axis]);
            for (plane, part) in planes.iter_mut().zip(part.pixels) {
                plane.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
            }
        }
        let mut planes = planes.map(|plane| plane.into_iter().map(|x| x as f32).collect::<Vec<_>>());
        self.lights[index].project(&mut planes);
        let placement = light.placement();
        let mut texture = vec![Vector3::zeros(); light.texture().len()];
        let cotangent = planes.each_ref().map(Vec::as_slice);
        let mut slopes = placement.adjoint(light.texture_size(), |i| light.radiance(i), side, cotangent, &mut texture);
        for (axis, along) in placement.extent_slopes().into_iter().enumerate() {
            (0..PARAMETERS).for_each(|k| slopes[k] += extent[axis] * along[k]);
        }
        for (texel, &mask) in texture.iter_mut().zip(light.mask()) {
            *texel *= f64::from(mask);
        }
        let [width, height, rotation] = slopes;
        let centre = self.transport.frame.to_world(&centre);
        Ok(LightGradient { centre, size: [width, height], rotation, texture })
    }

    fn sum(
        &self,
        light: &IncidentLight,
        pixels: &PixelRows,
        vertices: std::ops::Range<usize>,
        cotangent: &[Vector3<f32>],
    ) -> Sums {
        let (side, cells) = (self.settings.source_side, self.transport.face.cells());
        let area = side * side;
        let (source, factor, profile) = (light.pixels(), light.factor(), light.profile());
        let mut sums = Sums { centre: Vector3::zeros(), extent: [0.0; 2], pixels: [(); 3].map(|()| vec![0.0; area]) };
        let mut operator = PixelOperator::new(side, cells).expect("the relighter has checked the sides");
        let (mut image, [mut wide, mut shaped]) = (vec![0.0; area], [(); 2].map(|()| vec![0.0; cells * cells]));
        for vertex in vertices {
            let position = self.transport.positions[vertex].cast();
            let Some(maps) = light.maps(&position) else { continue };
            let given = cotangent[vertex].cast::<f64>();
            if given == Vector3::zeros() {
                continue;
            }
            // ∂J/∂s and ∂J/∂o of each axis.
            let mut slopes = [[0.0; 2]; 2];
            for row in self.transport.rows.of(vertex) {
                let view = f64::from(self.view.get(row).copied().unwrap_or(1.0));
                let weight = Vector3::from(self.transport.rows.weight[row]).cast::<f64>();
                let (transport, scale) = pixels.of(row, &mut wide);
                shaped.copy_from_slice(transport);
                let along = weight.component_mul(&given) * (view * f64::from(scale));
                shaped.iter_mut().zip(profile).for_each(|(t, p)| *t *= p);
                operator.set(maps);
                operator.adjoint(&shaped, &mut image);
                for (sum, along) in sums.pixels.iter_mut().zip(along.iter()) {
                    sum.iter_mut().zip(&image).for_each(|(sum, &g)| *sum += along * f64::from(g));
                }
                for axis in [Axis::X, Axis::Y] {
                    for (k, parameter) in Parameter::ALL.into_iter().enumerate() {
                        operator.set_derivative((axis, parameter), maps);
                        let slope = operator.inner_products(source, &shaped);
                        slopes[axis as usize][k] +=
                            (0..3).map(|c| along[c] * f64::from(slope[c])).sum::<f64>() * factor;
                    }
                }
            }
            // s = z a/W and o = ½ − (x + z a/2)/W of each axis.
            let (size, extent) = (self.transport.face.size(), light.extent());
            for axis in 0..2 {
                let ([by_scale, by_offset], map, w) = (slopes[axis], maps[axis], extent[axis]);
                sums.centre[axis] -= by_offset / w;
                sums.centre.z += (by_scale - 0.5 * by_offset) * size / w;
                sums.extent[axis] += (by_offset * (0.5 - map.offset()) - by_scale * map.scale()) / w;
            }
        }
        sums
    }
}
