//! Double product: transport in wavelets, light in few wavelets [Ng 2003].

use std::io::{Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::Vector3;
#[cfg(feature = "rayon")]
use rayon::prelude::*;

use super::light::{ProjectedLight, in_range, undo};
use crate::backend::archive;
use crate::error::check_length;
use crate::haar::{Keep, MaskedSum, Transform2d, Weighting};
use crate::scene::{BinaryVisibility, DirectionTable, Materials, Mesh, View};
use crate::sphere::{CubeGrid, CubeMap};
use crate::{Error, Progress, Result};

const KIND: [u8; 4] = *b"WDBL";
const VERSION: u32 = 1;

/// Vertices of one block of the transport matrix. A block's columns are contiguous, so that a light term reads one run of
/// memory a block: fewer vertices make the runs short, more make the accumulators leave the first-level cache.
const BLOCK: usize = 256;

/// How a transport's coefficients are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit floats: 6 bytes a coefficient with its row.
    Full,
    /// 16-bit integers with one scale a vertex: 4 bytes; the step is 1/32767 of the vertex's largest coefficient.
    #[default]
    Bits16,
    /// 8-bit integers with one scale a vertex, as the paper stores them: 3 bytes; the step is 1/127 of the largest.
    Bits8,
}

/// How [`DoubleTransport::bake`] stores what it computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleSettings {
    /// The smallest coefficients of a vertex are dropped as long as the relative L2 error of its transport stays below this;
    /// 0 keeps every non-zero. Too large loses shadows' edges, too small stores noise: each halving costs about 1.5 × the memory.
    pub tolerance: f32,
    /// How the rest is stored.
    pub precision: Precision,
}

impl Default for DoubleSettings {
    fn default() -> Self {
        Self { tolerance: 0.01, precision: Precision::default() }
    }
}

/// The transport of a static scene seen from one view (from any view, if the materials do not depend on it): visibility ×
/// brdf_cos of every vertex in the nonstandard Haar basis of each cube-map face, sparse, by wavelet.
///
///   radiance(v) = Σ_i L_i T_vi                                                              [Ng 2003, eq. 5]
///
/// with L the light's coefficients (texels weighted by side² × solid angle). The matrix is stored in blocks of 256 vertices,
/// each by column, so that a light of few terms reads only its own columns.
#[derive(Debug, Clone, PartialEq)]
pub struct DoubleTransport {
    grid: CubeGrid,
    vertices: usize,
    blocks: Vec<Block>,
}

/// The rows of some vertices, by column. A vertex has one row if its material has a colour, three otherwise.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    /// Of each row: its vertex, counted from the block's first.
    vertex: Vec<u16>,
    /// Of each row: what its sum adds to the vertex's R, G and B.
    weight: Vec<[f32; 3]>,
    /// The columns that hold anything, ascending.
    columns: Vec<u32>,
    /// Where each of these begins in `rows` and `values`, and the end.
    starts: Vec<u32>,
    rows: Vec<u16>,
    values: Values,
}

#[derive(Debug, Clone, PartialEq)]
enum Values {
    Full(Vec<f32>),
    Bits16(Vec<i16>),
    Bits8(Vec<i8>),
}

impl Values {
    fn bytes(&self) -> usize {
        match self {
            Self::Full(v) => size_of_val(v.as_slice()),
            Self::Bits16(v) => size_of_val(v.as_slice()),
            Self::Bits8(v) => size_of_val(v.as_slice()),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Full(v) => v.len(),
            Self::Bits16(v) => v.len(),
            Self::Bits8(v) => v.len(),
        }
    }
}

impl DoubleTransport {
    /// Computes the transport of every vertex: visibility × brdf_cos at every texel, transformed and thinned.
    ///
    /// Shapes: `visibility` has one map a mesh vertex, `materials` one material a vertex. The same bits for any number of
    /// threads. Cost: one BRDF slice and one Haar transform a vertex.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a cube map whose side is none, [`Error::Length`] if mesh, visibility and materials
    /// disagree about the number of vertices, [`Error::OutOfRange`] for a tolerance outside [0, 1), [`Error::NotFinite`] for a BRDF
    /// whose value for one of the texels is NaN or infinite in `f32` (the index is the BRDF's), [`Error::Cancelled`].
    pub fn bake(
        mesh: &Mesh,
        visibility: &BinaryVisibility,
        materials: &Materials,
        view: &View,
        settings: &DoubleSettings,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let vertices = mesh.positions().len();
        super::check_scene(mesh, visibility.vertices(), materials)?;
        if !(0.0..1.0).contains(&settings.tolerance) {
            let got = f64::from(settings.tolerance);
            return Err(Error::OutOfRange { what: "tolerance of the transport", got, allowed: "in [0, 1)" });
        }
        let baker = Baker {
            mesh,
            visibility,
            materials,
            view,
            settings,
            directions: DirectionTable::new(visibility.grid()),
            transform: super::face_transform(visibility.grid())?,
        };
        let done = AtomicUsize::new(0);
        let block = |first: usize| {
            if progress.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let block = baker.block(first, (first + BLOCK).min(vertices))?;
            let step = BLOCK.min(vertices - first);
            progress.advance(done.fetch_add(step, Ordering::Relaxed) + step, vertices);
            Ok(block)
        };
        let firsts: Vec<usize> = (0..vertices).step_by(BLOCK).collect();
        #[cfg(feature = "rayon")]
        let blocks = firsts.into_par_iter().map(block).collect::<Result<Vec<_>>>()?;
        #[cfg(not(feature = "rayon"))]
        let blocks = firsts.into_iter().map(block).collect::<Result<Vec<_>>>()?;
        Ok(Self { grid: visibility.grid(), vertices, blocks })
    }

    /// The grid of the cube maps.
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// How many coefficients are stored.
    pub fn nnz(&self) -> usize {
        self.blocks.iter().map(|b| b.rows.len()).sum()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let block = |b: &Block| {
            size_of_val(b.vertex.as_slice())
                + size_of_val(b.weight.as_slice())
                + size_of_val(b.columns.as_slice())
                + size_of_val(b.starts.as_slice())
                + size_of_val(b.rows.as_slice())
                + b.values.bytes()
        };
        self.blocks.iter().map(block).sum()
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
        writer.field(self.grid.side() as u64)?;
        writer.field(self.vertices as u64)?;
        writer.field(self.blocks.len() as u64)?;
        for block in &self.blocks {
            writer.array(&block.vertex)?;
            writer.array(block.weight.as_flattened())?;
            writer.array(&block.columns)?;
            writer.array(&block.starts)?;
            writer.array(&block.rows)?;
            match &block.values {
                Values::Full(v) => writer.field(32u8).and_then(|()| writer.array(v))?,
                Values::Bits16(v) => writer.field(16u8).and_then(|()| writer.array(v))?,
                Values::Bits8(v) => writer.field(8u8).and_then(|()| writer.array(v))?,
            }
        }
        writer.finish()
    }

    fn read(input: impl Read, path: &Path) -> Result<Self> {
        let mut reader = archive::Reader::new(input, path, KIND, "a double-product transport", VERSION)?;
        let side: u64 = reader.field()?;
        let vertices: u64 = reader.field()?;
        let count: u64 = reader.field()?;
        let grid = usize::try_from(side).ok().and_then(|s| CubeGrid::new(s).ok());
        let grid = grid.filter(|g| g.side().is_power_of_two());
        let grid = grid.ok_or_else(|| reader.wrong(format!("{side} is not a side of a cube map")))?;
        if count != vertices.div_ceil(BLOCK as u64) {
            return Err(reader.wrong(format!("{count} blocks cannot hold {vertices} vertices")));
        }
        let mut blocks = Vec::new();
        for b in 0..count {
            let vertex: Vec<u16> = reader.array("rows of a block", None)?;
            let flat: Vec<f32> = reader.array("weights of a block", Some(3 * vertex.len()))?;
            let columns: Vec<u32> = reader.array("columns of a block", None)?;
            let starts: Vec<u32> = reader.array("starts of a block", Some(columns.len() + 1))?;
            let rows: Vec<u16> = reader.array("row indices of a block", None)?;
            let values = match reader.field::<u8>()? {
                32 => Values::Full(reader.array("values of a block", Some(rows.len()))?),
                16 => Values::Bits16(reader.array("values of a block", Some(rows.len()))?),
                8 => Values::Bits8(reader.array("values of a block", Some(rows.len()))?),
                bits => return Err(reader.wrong(format!("{bits} is not a number of bits of a value"))),
            };
            let weight = flat.as_chunks::<3>().0.to_vec();
            let block = Block { vertex, weight, columns, starts, rows, values };
            let held = (vertices - b * BLOCK as u64).min(BLOCK as u64) as usize;
            if !block.is_consistent(held, grid.len()) {
                return Err(reader.wrong(format!("block {b} contradicts itself")));
            }
            blocks.push(block);
        }
        reader.finish()?;
        Ok(Self { grid, vertices: vertices as usize, blocks })
    }
}

impl Block {
    /// Whether every index stays inside what it points into.
    fn is_consistent(&self, vertices: usize, columns: usize) -> bool {
        self.vertex.iter().all(|&v| usize::from(v) < vertices)
            && self.columns.is_sorted_by(|a, b| a < b)
            && self.columns.last().is_none_or(|&c| (c as usize) < columns)
            && self.starts.is_sorted()
            && self.starts.first() == Some(&0)
            && self.starts.last().map(|&s| s as usize) == Some(self.rows.len())
            && self.rows.len() == self.values.len()
            && self.rows.iter().all(|&r| usize::from(r) < self.vertex.len())
    }

    /// Adds the radiance of the block's vertices to `out`, using `sums` (one a row) as scratch.
    fn add_radiance(&self, light: &[(u32, [f32; 4])], sums: &mut Vec<[f32; 4]>, out: &mut [Vector3<f32>]) {
        sums.clear();
        sums.resize(self.vertex.len(), [0.0; 4]);
        match &self.values {
            Values::Full(v) => self.accumulate(v, light, sums),
            Values::Bits16(v) => self.accumulate(v, light, sums),
            Values::Bits8(v) => self.accumulate(v, light, sums),
        }
        for ((&vertex, weight), sum) in self.vertex.iter().zip(&self.weight).zip(sums.iter()) {
            out[usize::from(vertex)] += Vector3::new(sum[0] * weight[0], sum[1] * weight[1], sum[2] * weight[2]);
        }
    }

    /// sums[row] += value · light over the columns that block and light share.
    fn accumulate<V: Copy + Into<f32>>(&self, values: &[V], light: &[(u32, [f32; 4])], sums: &mut [[f32; 4]]) {
        let mut at = 0;
        for &(column, colour) in light {
            // Both lists ascend: the search begins where the last one ended.
            at += self.columns[at..].partition_point(|&c| c < column);
            if self.columns.get(at) != Some(&column) {
                continue;
            }
            let run = self.starts[at] as usize..self.starts[at + 1] as usize;
            for (&row, &value) in self.rows[run.clone()].iter().zip(&values[run]) {
                let value: f32 = value.into();
                let sum = &mut sums[usize::from(row)];
                for c in 0..4 {
                    sum[c] += value * colour[c];
                }
            }
        }
    }
}

struct Baker<'a> {
    mesh: &'a Mesh,
    visibility: &'a BinaryVisibility,
    materials: &'a Materials,
    view: &'a View,
    settings: &'a DoubleSettings,
    directions: DirectionTable,
    transform: Transform2d<f32>,
}

impl Baker<'_> {
    fn block(&self, first: usize, end: usize) -> Result<Block> {
        let n = self.directions.len();
        let mut samples = vec![0.0; 3 * n];
        let mut seen = vec![0.0; 3 * n];
        let masked = MaskedSum::new();
        let mut scratch = vec![0.0; self.transform.scratch_len()];
        let mut vertex = Vec::new();
        let mut weight = Vec::new();
        let mut entries: Vec<(u32, u16, f32)> = Vec::new();
        for v in first..end {
            let brdf = self.materials.brdf(v);
            let planes = brdf.planes();
            let samples = &mut samples[..planes * n];
            let frame = self.mesh.frame(v);
            let wo = self.view.outgoing(brdf, &self.mesh.positions()[v], &frame);
            brdf.sample_cos(&frame, &wo, &self.directions, samples);
            if !samples.iter().all(|x| x.is_finite()) {
                return Err(self.materials.not_finite(v));
            }
            let seen = &mut seen[..planes * n];
            for (plane, seen) in samples.chunks_exact(n).zip(seen.chunks_exact_mut(n)) {
                super::mask(&masked, self.visibility.vertex(v), plane, seen);
            }
            self.transform.forward_batch(seen, samples, &mut scratch);
            for (c, plane) in samples.chunks_exact(n).enumerate() {
                let row = vertex.len() as u16;
                let largest = plane.iter().fold(0.0f32, |m, x| m.max(x.abs()));
                if largest == 0.0 {
                    continue;
                }
                let (scale, levels) = match self.settings.precision {
                    Precision::Full => (1.0, None),
                    Precision::Bits16 => (largest / 32767.0, Some(())),
                    Precision::Bits8 => (largest / 127.0, Some(())),
                };
                let threshold = energy_threshold(plane, self.settings.tolerance);
                for (i, &x) in plane.iter().enumerate() {
                    let stored = if levels.is_some() { (x / scale).round() } else { x };
                    if x.abs() >= threshold && stored != 0.0 {
                        entries.push((i as u32, row, stored));
                    }
                }
                let colour = match brdf.colour() {
                    Some(colour) => colour.cast::<f32>(),
                    None => Vector3::ith(c, 1.0),
                };
                vertex.push((v - first) as u16);
                weight.push((colour * scale).into());
            }
        }
        Ok(self.by_column(vertex, weight, &mut entries))
    }

    fn by_column(&self, vertex: Vec<u16>, weight: Vec<[f32; 3]>, entries: &mut [(u32, u16, f32)]) -> Block {
        entries.sort_unstable_by_key(|&(column, row, _)| (column, row));
        let mut columns = Vec::new();
        let mut starts = Vec::new();
        for (at, &(column, ..)) in entries.iter().enumerate() {
            if columns.last() != Some(&column) {
                columns.push(column);
                starts.push(at as u32);
            }
        }
        starts.push(entries.len() as u32);
        let rows = entries.iter().map(|e| e.1).collect();
        let values = entries.iter().map(|e| e.2);
        let values = match self.settings.precision {
            Precision::Full => Values::Full(values.collect()),
            Precision::Bits16 => Values::Bits16(values.map(|x| x as i16).collect()),
            Precision::Bits8 => Values::Bits8(values.map(|x| x as i8).collect()),
        };
        Block { vertex, weight, columns, starts, rows, values }
    }
}

/// A threshold below which the coefficients hold at most `tolerance`² of the energy Σ x².
///
/// The energy is binned by the top bits of the magnitude (8 bins an octave), so that no sorting is needed; the threshold is the
/// lower edge of the first bin that would exceed the budget.
fn energy_threshold(coefs: &[f32], tolerance: f32) -> f32 {
    const SHIFT: u32 = 20;
    let mut bins = vec![0.0f64; 1 << (31 - SHIFT)];
    for x in coefs {
        bins[(x.abs().to_bits() >> SHIFT) as usize] += f64::from(*x) * f64::from(*x);
    }
    let budget = bins.iter().sum::<f64>() * f64::from(tolerance).powi(2);
    let mut dropped = 0.0;
    for (bin, energy) in bins.iter().enumerate() {
        dropped += energy;
        if dropped > budget {
            return f32::from_bits((bin as u32) << SHIFT);
        }
    }
    0.0
}

/// Relights a scene from its [`DoubleTransport`] under lights that change.
#[derive(Debug, Clone)]
pub struct DoubleRelighter<'a> {
    transport: &'a DoubleTransport,
    projected: ProjectedLight,
    light: Vec<(u32, [f32; 4])>,
    /// What the radiance of the vertices is multiplied by: 1, but for lights beyond the range of sums in `f32`.
    factor: f64,
}

impl<'a> DoubleRelighter<'a> {
    /// A relighter without light.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] for a transport whose cube maps are no power of two a side (none that was baked here).
    pub fn new(transport: &'a DoubleTransport) -> Result<Self> {
        Ok(Self { transport, projected: ProjectedLight::new(transport.grid)?, light: Vec::new(), factor: 1.0 })
    }

    /// Sets the light: radiance on the transport's grid, of which `keep` wavelets are kept, the same for R, G and B.
    /// Any finite light: the brightest and darkest are scaled by a power of two.
    ///
    /// # Errors
    /// [`Error::Length`] for a light on another grid, [`Error::NotFinite`] for a texel that is NaN or infinite; what selection refuses.
    pub fn set_light(
        &mut self,
        light: &CubeMap<Vector3<f32>>,
        keep: Keep,
        weighting: Weighting<'_, f32>,
    ) -> Result<()> {
        let (light, factor) = in_range(light);
        self.projected.set(&light)?;
        let kept = self.projected.select(keep, weighting)?;
        self.factor = factor;
        self.light.clear();
        for &i in kept[0].indices() {
            let [r, g, b] = self.projected.coefficient(i as usize);
            self.light.push((i, [r, g, b, 0.0]));
        }
        Ok(())
    }

    /// How many wavelets the light has.
    pub fn light_terms(&self) -> usize {
        self.light.len()
    }

    /// The radiance that each vertex sends to the view it was baked for; finite (at most [`f32::MAX`]).
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
    pub fn relight(&self, out: &mut [Vector3<f32>]) {
        check_length("radiance of the vertices", self.transport.vertices, out.len());
        let block = |sums: &mut Vec<[f32; 4]>, block: &Block, out: &mut [Vector3<f32>]| {
            out.fill(Vector3::zeros());
            block.add_radiance(&self.light, sums, out);
            undo(self.factor, out);
        };
        #[cfg(feature = "rayon")]
        self.transport
            .blocks
            .par_iter()
            .zip(out.par_chunks_mut(BLOCK))
            .for_each_init(Vec::new, |sums, (b, out)| block(sums, b, out));
        #[cfg(not(feature = "rayon"))]
        {
            let mut sums = Vec::new();
            self.transport.blocks.iter().zip(out.chunks_mut(BLOCK)).for_each(|(b, out)| block(&mut sums, b, out));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_keeps_the_energy_it_promises() {
        let coefs: Vec<f32> = (0..4096).map(|i| ((i * 37 % 1009) as f32 / 300.0).powi(5) * 1e-3).collect();
        let total: f64 = coefs.iter().map(|x| f64::from(*x).powi(2)).sum();
        for tolerance in [0.0f32, 1e-4, 0.01, 0.1, 0.5] {
            let threshold = energy_threshold(&coefs, tolerance);
            let dropped: f64 = coefs.iter().filter(|x| x.abs() < threshold).map(|x| f64::from(*x).powi(2)).sum();
            let share = (dropped / total).sqrt();
            assert!(share <= f64::from(tolerance), "{share} dropped at {tolerance}");
            // The bins are an eighth of an octave wide: the budget is nearly used up.
            assert!(tolerance == 0.0 || share > 0.5 * f64::from(tolerance), "only {share} dropped at {tolerance}");
        }
        assert_eq!(energy_threshold(&[0.0; 8], 0.1), 0.0);
    }
}
