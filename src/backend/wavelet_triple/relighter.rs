//! Frames: light and BRDF in few wavelets, visibility whole.

use nalgebra::Vector3;

use super::settings::{Settings, Slices};
use super::slices::{SliceSampler, SliceTable, slice_of};
use super::transport::Transport;
use crate::backend::distant::range::{in_range, undo};
use crate::backend::distant::{DistantRelighter, Freedom, check_vertices};
use crate::error::check_length;
use crate::haar::{BitPyramid, BitPyramidRef, Factor, MaskedSum, ProjectedLight, TripleProduct, Visibility};
use crate::scene::{BinaryVisibility, Materials, Mesh, View};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Result, parallel};

/// Relights a scene from its [`Transport`]: light, view and materials may change in each frame.
///
/// ```math
/// radiance(v) = Σ_faces ∫ L B_v V_v = Σ_ijk L_i B_vj V_vk C_ijk                     [Ng 2004, eq. 4]
/// ```
///
/// With all terms kept this is the sum over all texels; to rounding, ground truth.
#[derive(Debug, Clone)]
pub struct Relighter<'a> {
    mesh: &'a Mesh,
    transport: &'a Transport,
    settings: Settings<'a>,
    projected: ProjectedLight,
    light: Light,
    /// What the radiance of the vertices is multiplied by: 1, but for lights beyond the range of sums in `f32`.
    factor: f64,
    product: TripleProduct,
    /// The visibility's words in Morton order, for tabulated slices only.
    morton: Vec<u64>,
    table: SliceTable,
    samplers: Vec<SliceSampler>,
    /// For each piece of the vertices: upper means of a face.
    upper: Vec<Vec<[f32; 4]>>,
}

/// The kept part of the light, in the forms that the routes read.
#[derive(Debug, Clone, Default)]
struct Light {
    terms: usize,
    /// Weighted texels, R, G and B.
    texels: [Vec<f32>; 3],
    /// One factor a face, for tabulated slices.
    rgb: Vec<Factor<f32, 3>>,
    /// One factor a face and channel, for tabulated slices without a colour.
    single: Vec<[Factor<f32>; 3]>,
}

impl<'a> Relighter<'a> {
    /// A relighter without light.
    ///
    /// # Errors
    /// [`Error::Length`](crate::Error::Length) if mesh and transport disagree about the number of vertices,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a fraction of terms outside [0, 1] and for a table whose
    /// side is none of a cube map.
    pub fn new(mesh: &'a Mesh, transport: &'a Transport, settings: Settings<'a>) -> Result<Self> {
        check_vertices("visibility maps", mesh.positions().len(), transport.vertices())?;
        settings.light_terms.check()?;
        settings.brdf_terms.check()?;
        let grid = transport.grid();
        let (morton, table) = match settings.slices {
            Slices::Sampled => (Vec::new(), SliceTable::default()),
            Slices::Tabulated(side) => (morton_words(transport.visibility()), SliceTable::new(CubeGrid::new(side)?)),
        };
        Ok(Self {
            mesh,
            transport,
            settings,
            projected: ProjectedLight::new(grid)?,
            light: Light::default(),
            factor: 1.0,
            product: TripleProduct::new(grid.side())?,
            morton,
            table,
            samplers: Vec::new(),
            upper: Vec::new(),
        })
    }

    /// Sets the light: radiance on the transport's grid. Any finite light: the brightest and darkest are scaled by a
    /// power of two.
    ///
    /// # Errors
    /// As [`ProjectedLight::set`] and [`Selection`](crate::haar::Selection).
    pub fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        let (light, factor) = in_range(light);
        self.projected.set(&light)?;
        let kept = self.projected.select(self.settings.light_terms, self.settings.weighting)?;
        self.factor = factor;
        self.light.terms = kept[0].nnz();
        self.light.texels = self.projected.texels_of(&kept);
        if let Slices::Tabulated(_) = self.settings.slices {
            let face = self.transport.grid().face_len();
            let faces: Vec<[_; 3]> = (0..6).map(|f| kept.each_ref().map(|c| slice_of(c, f * face, face))).collect();
            self.light.rgb = faces.iter().map(|f| Factor::new(f.each_ref())).collect::<Result<_>>()?;
            let single = |f: &[_; 3]| -> Result<[Factor<f32>; 3]> {
                Ok([Factor::new([&f[0]])?, Factor::new([&f[1]])?, Factor::new([&f[2]])?])
            };
            self.light.single = faces.iter().map(single).collect::<Result<_>>()?;
        }
        Ok(())
    }

    /// How many wavelets the light has.
    pub fn light_terms(&self) -> usize {
        self.light.terms
    }

    /// Bytes in memory that grow with the number of vertices or of different slices, beside the transport's: those of
    /// tabulated slices.
    pub fn bytes(&self) -> usize {
        self.table.bytes() + size_of_val(self.morton.as_slice())
    }

    /// The radiance that each vertex sends towards the viewer; finite (at most [`f32::MAX`]). Vertices without light
    /// (none was set) are black.
    ///
    /// # Errors
    /// [`Error::Length`](crate::Error::Length) if the materials do not fit the mesh,
    /// [`Error::NotFinite`](crate::Error::NotFinite) for a BRDF whose value for one of the texels is NaN or infinite in
    /// `f32` (the index is the BRDF's); what the choice of a slice's terms refuses.
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
    #[track_caller]
    pub fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        check_length("radiance of the vertices", self.mesh.positions().len(), out.len());
        materials.check(out.len())?;
        if self.light.texels[0].is_empty() {
            out.fill(Vector3::zeros());
            return Ok(());
        }
        match self.settings.slices {
            Slices::Sampled => self.relight_sampled(view, materials, out)?,
            Slices::Tabulated(_) => self.relight_tabulated(view, materials, out)?,
        }
        undo(self.factor, out);
        Ok(())
    }

    fn relight_sampled(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        if self.samplers.is_empty() {
            let sampler = SliceSampler::new(self.transport.grid(), self.settings.brdf_terms)?;
            self.samplers = vec![sampler; parallel::pieces()];
        }
        let (mesh, light, visibility) = (self.mesh, &self.light, self.transport.visibility());
        let (weighting, masked) = (self.settings.weighting, MaskedSum::new());
        parallel::with_scratch(out, 1, &mut self.samplers, |first, out, sampler| {
            for (i, radiance) in out.iter_mut().enumerate() {
                let v = first + i;
                let brdf = materials.brdf(v);
                let frame = mesh.local_frame(v);
                let wo = view.outgoing(brdf, &mesh.positions()[v], &frame);
                let slice = sampler.texels((materials.part(v), brdf), &frame, &wo, weighting)?;
                *radiance = masked_radiance(&masked, light, slice, visibility.vertex(v), brdf.colour());
            }
            Ok(())
        })
    }

    fn relight_tabulated(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        let (grid, terms) = (self.transport.grid(), self.settings.brdf_terms);
        self.table.fill(self.mesh, view, materials, grid, terms, self.settings.weighting)?;
        let (table, light, product, morton) = (&self.table, &self.light, &self.product, &self.morton);
        let words = BinaryVisibility::words_per_face(grid);
        let side = grid.side();
        if self.upper.is_empty() {
            self.upper = vec![vec![[0.0; 4]; BitPyramid::upper_len(side)]; parallel::pieces()];
        }
        let radiance = |v: usize, upper: &mut [[f32; 4]]| -> Vector3<f32> {
            let slice = table.slice(v);
            let mut sum = [0.0f64; 3];
            for face in 0..6 {
                let bits = &morton[(6 * v + face) * words..][..words];
                if slice.is_dark(face) || bits.iter().all(|&w| w == 0) {
                    continue;
                }
                BitPyramid::upper_from_words(side, bits, upper);
                let visibility = Visibility::Bits(BitPyramidRef::new(side, bits, upper));
                match slice.face(face) {
                    [brdf] => {
                        let rgb = product.integral(&light.rgb[face], brdf, visibility);
                        sum.iter_mut().zip(rgb).for_each(|(s, x)| *s += x);
                    }
                    planes => {
                        for ((sum, light), brdf) in sum.iter_mut().zip(&light.single[face]).zip(planes) {
                            *sum += product.integral(light, brdf, visibility)[0];
                        }
                    }
                }
            }
            let colour = materials.brdf(v).colour().unwrap_or_else(|| Vector3::repeat(1.0));
            Vector3::from(sum).component_mul(&colour).cast()
        };
        parallel::with_scratch(out, 1, &mut self.upper, |first, out, upper| {
            out.iter_mut().enumerate().for_each(|(i, out)| *out = radiance(first + i, upper));
            Ok(())
        })
    }
}

/// Σ over visible texels of light × slice.
fn masked_radiance(
    masked: &MaskedSum,
    light: &Light,
    slice: &[f32],
    words: &[u64],
    colour: Option<Vector3<f64>>,
) -> Vector3<f32> {
    let n = light.texels[0].len();
    let face = n / 6;
    let mut sum = Vector3::zeros();
    for (f, words) in words.chunks_exact(words.len() / 6).enumerate() {
        if words.iter().all(|&w| w == 0) {
            continue;
        }
        let texels = light.texels.each_ref().map(|t| &t[f * face..][..face]);
        if colour.is_some() {
            sum += Vector3::from(masked.dots(texels, &slice[f * face..][..face], words));
        } else {
            for (c, texels) in texels.into_iter().enumerate() {
                sum[c] += masked.dot(texels, &slice[c * n + f * face..][..face], words);
            }
        }
    }
    let colour = colour.unwrap_or_else(|| Vector3::repeat(1.0));
    (sum.component_mul(&colour) / face as f64).cast()
}

fn morton_words(visibility: &BinaryVisibility) -> Vec<u64> {
    let side = visibility.grid().side();
    let words = BinaryVisibility::words_per_face(visibility.grid());
    let mut morton = vec![0; visibility.words().len()];
    for (rows, morton) in visibility.words().chunks_exact(words).zip(morton.chunks_exact_mut(words)) {
        BitPyramid::morton_from_rows(side, rows, morton);
    }
    morton
}

impl DistantRelighter for Relighter<'_> {
    fn grid(&self) -> CubeGrid {
        self.transport.grid()
    }

    fn vertices(&self) -> usize {
        self.transport.vertices()
    }

    fn freedom(&self) -> Freedom {
        Freedom::LightViewMaterials
    }

    fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        self.set_light(light)
    }

    fn relight(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        self.relight(view, materials, out)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }
}
