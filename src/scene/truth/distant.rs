//! The right answer, by brute force.

use nalgebra::Vector3;

use crate::parallel::Watch;
use crate::scene::brdf::Axes;
use crate::scene::{BinaryVisibility, Brdf, Materials, Mesh, View};
use crate::sphere::{CubeGrid, CubeMap, Face};
use crate::{Error, Progress, Result, parallel};

/// What each vertex sees, in one of the forms that [`GroundTruth`] takes.
///
/// Weights are 1 = unoccluded. The closures are called from any thread, once a vertex, with a zeroed buffer.
#[derive(Clone, Copy)]
pub enum TexelVisibility<'a> {
    /// Stored bits.
    Binary(&'a BinaryVisibility),
    /// Bits in the form of [`BinaryVisibility`], made one vertex at a time: nothing is stored.
    Words {
        /// The grid of the bits.
        grid: CubeGrid,
        /// Fills the words of a vertex.
        fill: &'a (dyn Fn(usize, &mut [u64]) + Sync),
    },
    /// Fractional visibility, one weight a texel in storage order.
    Weights {
        /// The grid of the weights.
        grid: CubeGrid,
        /// Fills the weights of a vertex.
        fill: &'a (dyn Fn(usize, &mut [f32]) + Sync),
    },
    /// Everything is visible from everywhere.
    Full {
        /// The grid to sum over.
        grid: CubeGrid,
    },
}

impl TexelVisibility<'_> {
    /// The grid.
    pub fn grid(&self) -> CubeGrid {
        match self {
            Self::Binary(bits) => bits.grid(),
            Self::Words { grid, .. } | Self::Weights { grid, .. } | Self::Full { grid } => *grid,
        }
    }
}

impl std::fmt::Debug for TexelVisibility<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = match self {
            Self::Binary(_) => "Binary",
            Self::Words { .. } => "Words",
            Self::Weights { .. } => "Weights",
            Self::Full { .. } => "Full",
        };
        f.debug_struct(name).field("side", &self.grid().side()).finish_non_exhaustive()
    }
}

/// The radiance of every vertex under distant light, summed over all texels.
///
/// ```math
/// L_o(v) = Σ_t L_t V_t(v) f(wi_t, wo(v)) max(cos θ_t, 0) Ω_t
/// ```
///
/// in `f64`, through [`Brdf::eval`]. No approximation but the texels themselves: light, visibility and BRDF are
/// constant over a texel, taken at its centre. Texels with V = 0 and texels below the horizon are passed over, which
/// changes nothing.
///
/// Shapes: the result is one RGB a vertex. A vertex seen from behind is black, unless its BRDF does not
/// depend on the view ([`View::outgoing`]).
/// Cost: measured in `benches/ground_truth.rs`. Parallel over vertices; the same bits for any number of threads.
#[derive(Debug, Clone, Copy)]
pub struct GroundTruth<'a> {
    /// The vertices.
    pub mesh: &'a Mesh,
    /// Their BRDFs.
    pub materials: &'a Materials,
    /// The viewer.
    pub view: &'a View,
    /// The distant light in radiance, in world coordinates.
    pub light: &'a CubeMap<Vector3<f32>>,
}

/// Vertices that a thread takes at a time.
const CHUNK: usize = 32;

impl GroundTruth<'_> {
    /// The radiance of every vertex.
    ///
    /// # Errors
    /// [`Error::Length`] if the light's grid is not the visibility's or the lists do not fit the mesh,
    /// [`Error::NotFinite`] for a light texel, a visibility weight or a BRDF's value that is NaN or infinite (the index
    /// is then the BRDF's in [`Materials::brdfs`]), [`Error::Cancelled`].
    pub fn radiance(&self, visibility: &TexelVisibility, progress: &dyn Progress) -> Result<Vec<Vector3<f64>>> {
        let vertices = self.mesh.positions().len();
        let texels = self.prepare(visibility, vertices)?;
        let mut out = vec![Vector3::zeros(); vertices];
        let watch = Watch::new(progress, vertices);
        let scratch = || Scratch::new(visibility);
        parallel::try_chunks(&mut out, CHUNK, scratch, |index, chunk, scratch| {
            watch.check()?;
            for (i, radiance) in chunk.iter_mut().enumerate() {
                let vertex = index * CHUNK + i;
                *radiance = self.vertex(vertex, &texels, visibility, scratch)?;
                // Light, weights and cosines are finite.
                if !radiance.iter().all(|c| c.is_finite()) {
                    return Err(self.materials.not_finite(vertex));
                }
            }
            watch.advance(chunk.len());
            Ok(())
        })?;
        Ok(out)
    }

    fn prepare(&self, visibility: &TexelVisibility, vertices: usize) -> Result<Texels> {
        let grid = visibility.grid();
        if self.light.grid() != grid {
            return Err(Error::Length {
                what: "side of the light's cube map",
                expected: grid.side(),
                got: self.light.grid().side(),
            });
        }
        if let TexelVisibility::Binary(bits) = visibility
            && bits.vertices() != vertices
        {
            return Err(Error::Length { what: "vertices with visibility", expected: vertices, got: bits.vertices() });
        }
        self.materials.check(vertices)?;
        if let Some(index) = self.light.texels().iter().position(|l| !l.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "light texel", index });
        }
        Ok(Texels::new(self.light))
    }

    fn vertex(
        &self,
        vertex: usize,
        texels: &Texels,
        visibility: &TexelVisibility,
        scratch: &mut Scratch,
    ) -> Result<Vector3<f64>> {
        let shading = Shading::new(self.mesh, self.materials, self.view, vertex);
        if shading.wo.z <= 0.0 {
            return Ok(Vector3::zeros());
        }
        match visibility {
            TexelVisibility::Binary(bits) => Ok(shading.sum_bits(texels, bits.vertex(vertex))),
            TexelVisibility::Words { fill, .. } => {
                scratch.words.fill(0);
                fill(vertex, &mut scratch.words);
                Ok(shading.sum_bits(texels, &scratch.words))
            }
            TexelVisibility::Weights { fill, .. } => {
                scratch.weights.fill(0.0);
                fill(vertex, &mut scratch.weights);
                if let Some(index) = scratch.weights.iter().position(|w| !w.is_finite()) {
                    return Err(Error::NotFinite { what: "visibility weight", index });
                }
                Ok(shading.sum_weights(texels, |i| f64::from(scratch.weights[i])))
            }
            TexelVisibility::Full { .. } => Ok(shading.sum_weights(texels, |_| 1.0)),
        }
    }
}

/// One vertex's visibility, reused by the vertices of a chunk.
struct Scratch {
    words: Vec<u64>,
    weights: Vec<f32>,
}

impl Scratch {
    fn new(visibility: &TexelVisibility) -> Self {
        let grid = visibility.grid();
        let words = if matches!(visibility, TexelVisibility::Words { .. }) {
            6 * BinaryVisibility::words_per_face(grid)
        } else {
            0
        };
        let weights = if matches!(visibility, TexelVisibility::Weights { .. }) { grid.len() } else { 0 };
        Self { words: vec![0; words], weights: vec![0.0; weights] }
    }
}

/// Directions and L·Ω of all texels.
struct Texels {
    grid: CubeGrid,
    directions: Vec<Vector3<f64>>,
    light: Vec<Vector3<f64>>,
}

impl Texels {
    fn new(light: &CubeMap<Vector3<f32>>) -> Self {
        let grid = light.grid();
        let omega = grid.face_solid_angles();
        Self {
            grid,
            directions: grid.directions().into_iter().map(|d| d.into_inner()).collect(),
            light: light.texels().iter().enumerate().map(|(i, l)| l.cast() * omega[i % omega.len()]).collect(),
        }
    }
}

/// A vertex's BRDF, frame and local direction to the viewer.
pub(super) struct Shading<'a> {
    pub(super) brdf: &'a dyn Brdf,
    pub(super) axes: Axes,
    /// Local.
    pub(super) wo: Vector3<f64>,
}

impl<'a> Shading<'a> {
    pub(super) fn new(mesh: &Mesh, materials: &'a Materials, view: &View, vertex: usize) -> Self {
        let (brdf, frame) = (materials.brdf(vertex), mesh.local_frame(vertex));
        let axes = Axes::new(&frame);
        let wo = axes.to_local(&view.outgoing(brdf, &mesh.positions()[vertex], &frame));
        Self { brdf, axes, wo }
    }

    /// The light of irradiance E from a direction of the world that is reflected to the viewer.
    pub(super) fn reflect(&self, direction: &Vector3<f64>, irradiance: &Vector3<f64>) -> Vector3<f64> {
        let wi = self.axes.to_local(direction);
        if wi.z <= 0.0 {
            return Vector3::zeros();
        }
        self.brdf.eval(&wi, &self.wo).component_mul(irradiance) * wi.z
    }

    /// The light of texel i that is reflected, without visibility.
    #[inline(always)]
    fn texel(&self, texels: &Texels, i: usize) -> Vector3<f64> {
        let wi = self.axes.to_local(&texels.directions[i]);
        if wi.z <= 0.0 {
            return Vector3::zeros();
        }
        self.brdf.eval(&wi, &self.wo).component_mul(&texels.light[i]) * wi.z
    }

    // Apart, so that the loop has the registers to itself: a fifth of the time.
    #[inline(never)]
    fn sum_bits(&self, texels: &Texels, words: &[u64]) -> Vector3<f64> {
        let n = texels.grid.face_len();
        let per_face = words.len() / 6;
        let mut sum = Vector3::zeros();
        for (f, face) in Face::ALL.into_iter().enumerate() {
            if self.is_below(face) {
                continue;
            }
            for (w, &word) in words[f * per_face..][..per_face].iter().enumerate() {
                let first = w * 64;
                // Spare bits past the face are nobody's.
                let spare = (first + 64).saturating_sub(n);
                let mut bits = if spare == 0 { word } else { word & (u64::MAX >> spare) };
                while bits != 0 {
                    sum += self.texel(texels, f * n + first + bits.trailing_zeros() as usize);
                    bits &= bits - 1;
                }
            }
        }
        sum
    }

    fn sum_weights(&self, texels: &Texels, weight: impl Fn(usize) -> f64) -> Vector3<f64> {
        let n = texels.grid.face_len();
        let mut sum = Vector3::zeros();
        for (f, face) in Face::ALL.into_iter().enumerate() {
            if self.is_below(face) {
                continue;
            }
            for i in f * n..(f + 1) * n {
                let w = weight(i);
                if w != 0.0 {
                    sum += self.texel(texels, i) * w;
                }
            }
        }
        sum
    }

    /// Whether a whole face is below the horizon: the largest n·(out + u right + v down) over |u|, |v| ≤ 1.
    fn is_below(&self, face: Face) -> bool {
        let [right, down, out] = face.axes().map(|a| self.axes.normal().dot(&Vector3::from(a)));
        out + right.abs() + down.abs() < -1e-12
    }
}
