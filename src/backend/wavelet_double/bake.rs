//! Computing the transport of a block of vertices.

use nalgebra::Vector3;

use super::block::{Block, Values};
use super::settings::{BakeSettings, Precision};
use crate::Result;
use crate::haar::{MaskedSum, Transform2d, threshold_for_error};
use crate::scene::{BinaryVisibility, DirectionTable, Materials, Mesh, View};

pub(super) struct Baker<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) visibility: &'a BinaryVisibility,
    pub(super) materials: &'a Materials,
    pub(super) view: &'a View,
    pub(super) settings: BakeSettings,
    pub(super) directions: DirectionTable,
    pub(super) transform: Transform2d<f32>,
}

impl Baker<'_> {
    pub(super) fn block(&self, first: usize, end: usize) -> Result<Block> {
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
            let frame = self.mesh.local_frame(v);
            let wo = self.view.outgoing(brdf, &self.mesh.positions()[v], &frame);
            brdf.sample_cos(&frame, &wo, &self.directions, samples);
            if !samples.iter().all(|x| x.is_finite()) {
                return Err(self.materials.not_finite(v));
            }
            let seen = &mut seen[..planes * n];
            for (plane, seen) in samples.chunks_exact(n).zip(seen.chunks_exact_mut(n)) {
                mask(&masked, self.visibility.vertex(v), plane, seen);
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
                let threshold = threshold_for_error(plane, self.settings.tolerance);
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

/// Copies what a vertex sees and sets the rest to 0. Shapes: six faces of words, six of values.
fn mask(masked: &MaskedSum, words: &[u64], values: &[f32], out: &mut [f32]) {
    let faces = values.chunks_exact(values.len() / 6).zip(out.chunks_exact_mut(values.len() / 6));
    for ((values, out), words) in faces.zip(words.chunks_exact(words.len() / 6)) {
        masked.mask(values, words, out);
    }
}
