//! Ray-cast pictures of per-vertex colours.

use nalgebra::{SVector, UnitVector3, Vector2, Vector3};

use super::{Bvh, Camera, Mesh};
use crate::error::check_length;
use crate::{Error, Result, parallel};

/// Which faces show in which pixels: a plan that turns colours of vertices, or of hits, into pictures.
///
/// Rays are cast once, when the plan is built; every set of colours (a frame, a method, an error map) then costs one
/// pass over the samples. Colours are linear RGB; pixels are the mean of `samples`² regularly spaced rays (a box
/// filter). [`shade`](Self::shade) interpolates colours of vertices over the faces,
/// [`shade_samples`](Self::shade_samples) asks for the colour of every hit: what is shaded per pixel has its place in
/// the scene from there.
///
/// Cost: 16 B a ray, 12 B a face.
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
    faces: Vec<[u32; 3]>,
    /// For every sample, pixel after pixel.
    hits: Vec<Compact>,
}

/// What a sample shows: a face ([`NOTHING`]: sky), the weights of its first two corners, the depth.
#[derive(Debug, Clone, Copy)]
struct Compact {
    face: u32,
    weights: [f32; 2],
    depth: f32,
}

const NOTHING: u32 = u32::MAX;

/// A place of a mesh that shows in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelHit {
    /// The face.
    pub face: u32,
    /// Weights of the face's corners: not negative but for rounding, sum 1.
    pub barycentric: [f32; 3],
    /// How far from the eye it is.
    pub depth: f32,
}

impl PixelHit {
    /// The value at the hit of what is given a vertex, such as positions, normals or texture coordinates of the mesh.
    ///
    /// # Panics
    /// If a corner of the face has no value.
    #[track_caller]
    pub fn interpolate<const N: usize>(&self, mesh: &Mesh, values: &[SVector<f32, N>]) -> SVector<f32, N> {
        let corners = mesh.faces()[self.face as usize].map(|v| values[v as usize]);
        corners[0] * self.barycentric[0] + corners[1] * self.barycentric[1] + corners[2] * self.barycentric[2]
    }
}

/// What a pixel covers of a texture: a parallelogram around a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UvFootprint {
    /// Texture coordinates of the hit.
    pub uv: Vector2<f64>,
    /// Their change to the next pixel at the right.
    pub right: Vector2<f64>,
    /// Their change to the next pixel below.
    pub down: Vector2<f64>,
}

/// One ray of a pixel, and what it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelSample {
    /// Column and row of the pixel, from the top left.
    pub pixel: [usize; 2],
    /// Which of the pixel's rays, row after row.
    pub sample: usize,
    /// The unit direction of the ray, from the eye.
    pub direction: UnitVector3<f64>,
    /// What it meets; `None` is the sky.
    pub hit: Option<PixelHit>,
}

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
        let nothing = Compact { face: NOTHING, weights: [0.0; 2], depth: f32::INFINITY };
        let (vertices, faces) = (mesh.positions().len(), mesh.faces().to_vec());
        let mut plan = Self { size, samples, camera: *camera, vertices, faces, hits: vec![] };
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
                        let [a, b, _] = hit.barycentric;
                        *slot = Compact { face: hit.face, weights: [a, b], depth: hit.distance as f32 };
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
        self.means(|index| {
            let Compact { face, weights: [a, b], .. } = self.hits[index];
            if face == NOTHING {
                return background(&self.direction(index));
            }
            let [x, y, z] = self.faces[face as usize].map(|v| colours[v as usize]);
            x * a + y * b + z * (1.0 - a - b)
        })
    }

    /// The pixels, row after row from the top left, of a colour for every sample: the mean over those of a pixel.
    ///
    /// `colour` is called once for every sample, from any thread.
    pub fn shade_samples(&self, colour: impl Fn(&PixelSample) -> Vector3<f32> + Sync) -> Vec<Vector3<f32>> {
        self.means(|index| colour(&self.at(index)))
    }

    /// The mean over the samples of every pixel, by their index.
    fn means(&self, colour: impl Fn(usize) -> Vector3<f32> + Sync) -> Vec<Vector3<f32>> {
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
                    (first..first + per_pixel).for_each(|index| sum += colour(index));
                    *pixel = sum / per_pixel as f32;
                }
            },
        );
        pixels
    }

    /// Samples along an edge of a pixel.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// One of the samples² rays of a pixel, and what it shows.
    ///
    /// # Panics
    /// If there is no such pixel or sample.
    #[track_caller]
    pub fn sample(&self, pixel: [usize; 2], sample: usize) -> PixelSample {
        let (per_pixel, [width, height]) = (self.samples * self.samples, self.size);
        assert!(pixel[0] < width && pixel[1] < height, "pixel {pixel:?} of a picture of {width} × {height}");
        assert!(sample < per_pixel, "sample {sample} of {per_pixel}");
        self.at((pixel[1] * width + pixel[0]) * per_pixel + sample)
    }

    fn at(&self, index: usize) -> PixelSample {
        let (per_pixel, width) = (self.samples * self.samples, self.size[0]);
        let (pixel, sample) = (index / per_pixel, index % per_pixel);
        let Compact { face, weights: [a, b], depth } = self.hits[index];
        let hit = (face != NOTHING).then_some(PixelHit { face, barycentric: [a, b, 1.0 - a - b], depth });
        PixelSample { pixel: [pixel % width, pixel / width], sample, direction: self.direction(index), hit }
    }

    /// How the barycentric coordinates of a hit change from pixel to pixel: to the right, and down.
    ///
    /// What is given at the corners, such as texture coordinates, changes by Σ_k `d[0][k]` uv_k to the right
    /// ([`footprint`](Self::footprint)). Central differences over one pixel, in the plane of the face, whether or not
    /// the neighbours show it.
    ///
    /// `None` for the sky, and where the plane of the face is not seen half a pixel away.
    ///
    /// # Panics
    /// As [`sample`](Self::sample).
    #[track_caller]
    pub fn differentials(&self, mesh: &Mesh, pixel: [usize; 2], sample: usize) -> Option<[[f64; 3]; 2]> {
        let hit = self.sample(pixel, sample).hit?;
        let corners = mesh.corners(hit.face as usize).map(|p| p.cast::<f64>() - self.camera.eye());
        let [x, y] = self.place(pixel, sample);
        // The weights of the corners where a ray meets the plane: the volumes of ray and edges, over their sum.
        let weights = |x: f64, y: f64| {
            let direction = self.towards(x, y);
            let volumes = [0, 1, 2].map(|k| corners[(k + 1) % 3].cross(&corners[(k + 2) % 3]).dot(&direction));
            let sum: f64 = volumes.iter().sum();
            // In front of the eye, the sum has the sign of the volume of eye and face.
            let is_seen = sum * corners[0].cross(&corners[1]).dot(&corners[2]) > 0.0;
            is_seen.then(|| volumes.map(|v| v / sum))
        };
        let change = |dx: f64, dy: f64| {
            let (before, after) = (weights(x - dx, y - dy)?, weights(x + dx, y + dy)?);
            Some([0, 1, 2].map(|k| after[k] - before[k]))
        };
        Some([change(0.5, 0.0)?, change(0.0, 0.5)?])
    }

    /// Texture coordinates of a hit and how they change from pixel to pixel, to the right and down: the footprint that
    /// a texture is filtered over.
    ///
    /// `None` for the sky, for a mesh without texture coordinates, and where
    /// [`differentials`](Self::differentials) are none.
    ///
    /// # Panics
    /// As [`sample`](Self::sample).
    #[track_caller]
    pub fn footprint(&self, mesh: &Mesh, pixel: [usize; 2], sample: usize) -> Option<UvFootprint> {
        let (hit, uv) = (self.sample(pixel, sample).hit?, mesh.uv()?);
        let corners = mesh.faces()[hit.face as usize].map(|v| uv[v as usize].cast::<f64>());
        let combine = |weights: [f64; 3]| (0..3).map(|k| corners[k] * weights[k]).sum();
        let [right, down] = self.differentials(mesh, pixel, sample)?;
        let uv = combine(hit.barycentric.map(f64::from));
        Some(UvFootprint { uv, right: combine(right), down: combine(down) })
    }

    /// The share of every pixel that shows the mesh: the alpha channel of a picture without a sky.
    pub fn coverage(&self) -> Vec<f32> {
        let per_pixel = self.samples * self.samples;
        let share =
            |samples: &[Compact]| samples.iter().filter(|hit| hit.face != NOTHING).count() as f32 / per_pixel as f32;
        self.hits.chunks_exact(per_pixel).map(share).collect()
    }

    /// The direction of a sample.
    fn direction(&self, sample: usize) -> UnitVector3<f64> {
        let (per_pixel, width) = (self.samples * self.samples, self.size[0]);
        let pixel = sample / per_pixel;
        let [x, y] = self.place([pixel % width, pixel / width], sample % per_pixel);
        self.towards(x, y)
    }

    /// Where a sample is, in pixels from the top left.
    fn place(&self, pixel: [usize; 2], sample: usize) -> [f64; 2] {
        let n = self.samples;
        let within = [sample % n, sample / n];
        [0, 1].map(|k| pixel[k] as f64 + (within[k] as f64 + 0.5) / n as f64)
    }

    /// The direction of a place in pixels from the top left.
    fn towards(&self, x: f64, y: f64) -> UnitVector3<f64> {
        let [width, height] = self.size;
        let half = height as f64 * 0.5;
        self.camera.direction((x - width as f64 * 0.5) / half, 1.0 - y / half)
    }
}
