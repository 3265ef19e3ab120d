//! Ray-cast pictures of per-vertex colours.

use nalgebra::{UnitVector3, Vector3};

use super::{Bvh, Camera, Mesh};
use crate::error::check_length;
use crate::{Error, Result, parallel};

/// Which vertices show in which pixels: a plan that turns colours of vertices into pictures.
///
/// Rays are cast once, when the plan is built; every set of colours (a frame, a method, an error map) then costs one
/// pass over the samples. Colours are linear RGB, interpolated over the faces; pixels are the mean of `samples`²
/// regularly spaced rays (a box filter).
///
/// Cost: 16 B a ray.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{Bvh, Picture, Procedural}};
/// let model = Procedural::StackedSpheres.build(1_000)?;
/// let picture = Picture::new(&model.mesh, &Bvh::new(&model.mesh), &model.camera, [32, 24], 2)?;
/// let white = vec![Vector3::repeat(1.0); model.mesh.positions().len()];
/// let pixels = picture.shade(&white, |_| Vector3::zeros());
/// // White spheres in the middle, black sky at the top left.
/// assert!((pixels[12 * 32 + 16].x - 1.0).abs() < 1e-6);
/// assert_eq!(pixels[0], Vector3::zeros());
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Picture {
    size: [usize; 2],
    samples: usize,
    camera: Camera,
    vertices: usize,
    /// For every sample, pixel after pixel: the corners of the face and the weights of the first two; corner 0 =
    /// NOTHING: sky.
    hits: Vec<([u32; 3], [f32; 2])>,
}

const NOTHING: u32 = u32::MAX;

impl Picture {
    /// Casts the rays of a picture of `size` = [width, height] pixels, `samples` × `samples` each, in parallel.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless both sizes are in 1…16384 and `samples` in 1…16.
    pub fn new(mesh: &Mesh, bvh: &Bvh, camera: &Camera, size: [usize; 2], samples: usize) -> Result<Self> {
        for pixels in size {
            if !(1..=16384).contains(&pixels) {
                return Err(Error::OutOfRange { what: "picture size", got: pixels as f64, allowed: "in 1…16384" });
            }
        }
        if !(1..=16).contains(&samples) {
            return Err(Error::OutOfRange {
                what: "samples along a pixel's edge",
                got: samples as f64,
                allowed: "in 1…16",
            });
        }
        let nothing = ([NOTHING; 3], [0.0; 2]);
        let mut plan = Self { size, samples, camera: *camera, vertices: mesh.positions().len(), hits: vec![] };
        let mut hits = vec![nothing; size[0] * size[1] * samples * samples];
        let eye = camera.eye();
        parallel::chunks(
            &mut hits,
            size[0] * samples * samples,
            || (),
            |row, hits, ()| {
                for (k, slot) in hits.iter_mut().enumerate() {
                    let direction = plan.direction(row * size[0] * samples * samples + k);
                    if let Some(hit) = bvh.closest_hit(&eye, &direction) {
                        *slot = (mesh.faces()[hit.face as usize], [hit.barycentric[0], hit.barycentric[1]]);
                    }
                }
            },
        );
        plan.hits = hits;
        Ok(plan)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The pixels, row after row from the top left, of a colour for every vertex and one for the sky in every
    /// direction.
    ///
    /// # Panics
    /// If there is not one colour a vertex.
    #[track_caller]
    pub fn shade(
        &self,
        colours: &[Vector3<f32>],
        background: impl Fn(&UnitVector3<f64>) -> Vector3<f32> + Sync,
    ) -> Vec<Vector3<f32>> {
        check_length("colours of a picture", self.vertices, colours.len());
        let per_pixel = self.samples * self.samples;
        let mut pixels = vec![Vector3::zeros(); self.size[0] * self.size[1]];
        parallel::chunks(
            &mut pixels,
            self.size[0],
            || (),
            |row, pixels, ()| {
                for (k, pixel) in pixels.iter_mut().enumerate() {
                    let first = (row * self.size[0] + k) * per_pixel;
                    let mut sum = Vector3::zeros();
                    for (i, (face, [a, b])) in self.hits[first..][..per_pixel].iter().enumerate() {
                        sum += if face[0] == NOTHING {
                            background(&self.direction(first + i))
                        } else {
                            let [x, y, z] = face.map(|v| colours[v as usize]);
                            x * *a + y * *b + z * (1.0 - a - b)
                        };
                    }
                    *pixel = sum / per_pixel as f32;
                }
            },
        );
        pixels
    }

    /// The share of every pixel that shows the mesh: the alpha channel of a picture without a sky.
    pub fn coverage(&self) -> Vec<f32> {
        let per_pixel = self.samples * self.samples;
        let share = |samples: &[([u32; 3], [f32; 2])]| {
            samples.iter().filter(|(face, _)| face[0] != NOTHING).count() as f32 / per_pixel as f32
        };
        self.hits.chunks_exact(per_pixel).map(share).collect()
    }

    /// The direction of a sample.
    fn direction(&self, sample: usize) -> UnitVector3<f64> {
        let (n, [width, height]) = (self.samples, self.size);
        let (pixel, within) = (sample / (n * n), sample % (n * n));
        let x = (pixel % width) as f64 + ((within % n) as f64 + 0.5) / n as f64;
        let y = (pixel / width) as f64 + ((within / n) as f64 + 0.5) / n as f64;
        let half = height as f64 * 0.5;
        self.camera.direction((x - width as f64 * 0.5) / half, 1.0 - y / half)
    }
}
