//! Triple product: light and BRDF in few wavelets, visibility whole [Ng 2004].

use std::io::{Read, Write};
use std::path::Path;

use nalgebra::Vector3;
#[cfg(feature = "rayon")]
use rayon::prelude::*;

use super::light::{ProjectedLight, in_range, undo};
use super::slices::{SliceSampler, SliceTable};
use crate::backend::archive;
use crate::error::check_length;
use crate::haar::{
    BitPyramid, BitPyramidRef, Factor, Keep, MaskedSum, TripleProduct, Visibility, Weighting, rows_to_morton,
    upper_means,
};
use crate::scene::{BinaryVisibility, Materials, Mesh, View};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Result};

const KIND: [u8; 4] = *b"WTRI";
const VERSION: u32 = 1;

/// The transport of a static scene: one visibility bit a texel of the cube map around each vertex, losslessly.
///
/// It knows neither light, nor view, nor materials. In memory and on disk: 6 side² / 8 bytes a vertex (3 KiB at side 64).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TripleTransport {
    visibility: BinaryVisibility,
}

impl TripleTransport {
    /// Wraps baked visibility.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a cube map whose side is none.
    pub fn new(visibility: BinaryVisibility) -> Result<Self> {
        super::face_transform(visibility.grid())?;
        Ok(Self { visibility })
    }

    /// The visibility.
    pub fn visibility(&self) -> &BinaryVisibility {
        &self.visibility
    }

    /// The grid of the cube maps.
    pub fn grid(&self) -> CubeGrid {
        self.visibility.grid()
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.visibility.vertices()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(self.visibility.words())
    }

    /// Saves to a file; a failure leaves what was there.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        archive::save(path, |out| self.write(out, path))
    }

    /// Loads what [`save`](Self::save) wrote.
    ///
    /// # Errors
    /// [`Error::File`] naming the place if the file is of another kind or version, cut short, damaged or inconsistent.
    pub fn load(path: &Path) -> Result<Self> {
        Self::read(archive::open(path)?, path)
    }

    fn write(&self, out: impl Write, path: &Path) -> Result<()> {
        let mut writer = archive::Writer::new(out, path, KIND, VERSION)?;
        writer.field(self.grid().side() as u64)?;
        writer.array(self.visibility.words())?;
        writer.finish()
    }

    fn read(input: impl Read, path: &Path) -> Result<Self> {
        let mut reader = archive::Reader::new(input, path, KIND, "a triple-product transport", VERSION)?;
        let side: u64 = reader.field()?;
        let grid = usize::try_from(side).ok().filter(|s| s.is_power_of_two()).and_then(|s| CubeGrid::new(s).ok());
        let grid = grid.ok_or_else(|| reader.wrong(format!("{side} is not a side of a cube map")))?;
        let words: Vec<u64> = reader.array("words of visibility", None)?;
        let got = words.len();
        let visibility = BinaryVisibility::new(grid, words)
            .map_err(|_| reader.wrong(format!("{got} words are no whole number of visibility maps of side {side}")))?;
        reader.finish()?;
        Ok(Self { visibility })
    }
}

/// Where a vertex's BRDF slice comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Slices {
    /// Sampled for each vertex, in each frame: exact normals and views.
    #[default]
    Sampled,
    /// From a table of slices at the texel centres of a cube map of normals (and, for view-dependent materials, one of views)
    /// of this side, filled on first use. Faster from the second frame on; the nearest slice is off by up to half a texel:
    /// 1.4° at side 32, 2.8° at 16. A slice takes up to 12 side² × 6 bytes of the *visibility's* side: mind side 32 with views.
    Tabulated(usize),
}

/// What [`TripleRelighter`] keeps of light and BRDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TripleSettings {
    /// Wavelets of the light, over all faces.
    pub light_terms: Keep,
    /// Wavelets of each BRDF slice, over all faces.
    pub brdf_terms: Keep,
    /// Where slices come from.
    pub slices: Slices,
}

impl Default for TripleSettings {
    fn default() -> Self {
        Self { light_terms: Keep::Fraction(0.01), brdf_terms: Keep::Fraction(0.01), slices: Slices::default() }
    }
}

/// Relights a scene from its [`TripleTransport`]: light, view and materials may change in each frame.
///
///   radiance(v) = Σ_faces ∫ L B_v V_v = Σ_ijk L_i B_vj V_vk C_ijk                     [Ng 2004, eq. 4]
///
/// With all terms kept this is the sum over all texels; to rounding, ground truth.
#[derive(Debug, Clone)]
pub struct TripleRelighter<'a> {
    mesh: &'a Mesh,
    transport: &'a TripleTransport,
    settings: TripleSettings,
    weighting: Weighting<'a, f32>,
    projected: ProjectedLight,
    light: Light,
    /// What the radiance of the vertices is multiplied by: 1, but for lights beyond the range of sums in `f32`.
    factor: f64,
    product: TripleProduct,
    /// The visibility's words in Morton order, for tabulated slices only.
    morton: Vec<u64>,
    table: SliceTable,
    samplers: Vec<SliceSampler>,
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

impl<'a> TripleRelighter<'a> {
    /// A relighter without light. `weighting` ranks the terms of light and BRDF slices.
    ///
    /// # Errors
    /// [`Error::Length`] if mesh and transport disagree about the number of vertices.
    pub fn new(
        mesh: &'a Mesh,
        transport: &'a TripleTransport,
        settings: TripleSettings,
        weighting: Weighting<'a, f32>,
    ) -> Result<Self> {
        let expected = mesh.positions().len();
        if transport.vertices() != expected {
            return Err(Error::Length { what: "visibility maps", expected, got: transport.vertices() });
        }
        let grid = transport.grid();
        let (morton, table) = match settings.slices {
            Slices::Sampled => (Vec::new(), SliceTable::default()),
            Slices::Tabulated(side) => (morton_words(&transport.visibility), SliceTable::new(CubeGrid::new(side)?)),
        };
        Ok(Self {
            mesh,
            transport,
            settings,
            weighting,
            projected: ProjectedLight::new(grid)?,
            light: Light::default(),
            factor: 1.0,
            product: TripleProduct::new(grid.side())?,
            morton,
            table,
            samplers: Vec::new(),
        })
    }

    /// Sets the light: radiance on the transport's grid. Any finite light: the brightest and darkest are scaled by a power
    /// of two.
    ///
    /// # Errors
    /// As [`ProjectedLight::set`] and [`Selection`](crate::haar::Selection).
    pub fn set_light(&mut self, light: &CubeMap<Vector3<f32>>) -> Result<()> {
        let (light, factor) = in_range(light);
        self.projected.set(&light)?;
        let kept = self.projected.select(self.settings.light_terms, self.weighting)?;
        self.factor = factor;
        self.light.terms = kept[0].nnz();
        self.light.texels = self.projected.texels_of(&kept);
        if let Slices::Tabulated(_) = self.settings.slices {
            let face = self.transport.grid().face_len();
            let faces: Vec<[_; 3]> =
                (0..6).map(|f| kept.each_ref().map(|c| super::slice_of(c, f * face, face))).collect();
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

    /// Bytes of the table of slices so far.
    pub fn table_bytes(&self) -> usize {
        self.table.bytes()
    }

    /// The radiance that each vertex sends towards the viewer; finite (at most [`f32::MAX`]). Vertices without light (none
    /// was set) are black.
    ///
    /// # Errors
    /// [`Error::Length`] if the materials do not fit the mesh, [`Error::NotFinite`] for a BRDF whose value for one of the texels is NaN or
    /// infinite in `f32` (the index is the BRDF's); what the choice of a slice's terms refuses.
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
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
        let pieces = pieces();
        if self.samplers.is_empty() {
            let sampler = SliceSampler::new(self.transport.grid(), self.settings.brdf_terms)?;
            self.samplers = vec![sampler; pieces];
        }
        let piece = out.len().div_ceil(pieces).max(1);
        let (mesh, light, visibility) = (self.mesh, &self.light, &self.transport.visibility);
        let (weighting, masked) = (self.weighting, MaskedSum::new());
        let run = |(index, (out, sampler)): (usize, (&mut [Vector3<f32>], &mut SliceSampler))| -> Result<()> {
            for (i, radiance) in out.iter_mut().enumerate() {
                let v = index * piece + i;
                let brdf = materials.brdf(v);
                let frame = mesh.frame(v);
                let wo = view.outgoing(brdf, &mesh.positions()[v], &frame);
                let slice = sampler.texels((materials.part(v), brdf), &frame, &wo, weighting)?;
                *radiance = masked_radiance(&masked, light, slice, visibility.vertex(v), brdf.colour());
            }
            Ok(())
        };
        #[cfg(feature = "rayon")]
        return out.par_chunks_mut(piece).zip(&mut self.samplers).enumerate().try_for_each(run);
        #[cfg(not(feature = "rayon"))]
        return out.chunks_mut(piece).zip(&mut self.samplers).enumerate().try_for_each(run);
    }

    fn relight_tabulated(&mut self, view: &View, materials: &Materials, out: &mut [Vector3<f32>]) -> Result<()> {
        let (grid, terms) = (self.transport.grid(), self.settings.brdf_terms);
        self.table.fill(self.mesh, view, materials, grid, terms, self.weighting)?;
        let (table, light, product, morton) = (&self.table, &self.light, &self.product, &self.morton);
        let words = BinaryVisibility::words_per_face(grid);
        let side = grid.side();
        let upper = vec![[0.0f32; 4]; BitPyramid::upper_len(side)];
        let run = |upper: &mut Vec<[f32; 4]>, (v, radiance): (usize, &mut Vector3<f32>)| {
            let slice = table.slice(v);
            let mut sum = [0.0f64; 3];
            for face in 0..6 {
                let bits = &morton[(6 * v + face) * words..][..words];
                if slice.is_dark(face) || bits.iter().all(|&w| w == 0) {
                    continue;
                }
                upper_means(side, bits, upper);
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
            *radiance = Vector3::from(sum).component_mul(&colour).cast();
        };
        #[cfg(feature = "rayon")]
        out.par_iter_mut().enumerate().for_each_init(|| upper.clone(), run);
        #[cfg(not(feature = "rayon"))]
        {
            let mut upper = upper;
            out.iter_mut().enumerate().for_each(|vertex| run(&mut upper, vertex));
        }
        Ok(())
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

/// Into how many pieces a frame is cut, each with scratch of its own. The result does not depend on it.
fn pieces() -> usize {
    #[cfg(feature = "rayon")]
    return 4 * rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    return 1;
}

fn morton_words(visibility: &BinaryVisibility) -> Vec<u64> {
    let side = visibility.grid().side();
    let words = BinaryVisibility::words_per_face(visibility.grid());
    let mut morton = vec![0; visibility.words().len()];
    for (rows, morton) in visibility.words().chunks_exact(words).zip(morton.chunks_exact_mut(words)) {
        rows_to_morton(side, rows, morton);
    }
    morton
}
