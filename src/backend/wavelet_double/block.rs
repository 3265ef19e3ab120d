//! The transport of some vertices, by column.

use nalgebra::Vector3;

/// Vertices of one block of the transport matrix. A block's columns are contiguous, so that a light term reads one run
/// of memory a block: fewer vertices make the runs short, more make the accumulators leave the first-level cache.
pub(super) const BLOCK: usize = 256;

/// The rows of some vertices, by column. A vertex has one row if its material has a colour, three otherwise.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    /// Of each row: its vertex, counted from the block's first.
    pub(super) vertex: Vec<u16>,
    /// Of each row: what its sum adds to the vertex's R, G and B.
    pub(super) weight: Vec<[f32; 3]>,
    /// The columns that hold anything, ascending.
    pub(super) columns: Vec<u32>,
    /// Where each of these begins in `rows` and `values`, and the end.
    pub(super) starts: Vec<u32>,
    pub(super) rows: Vec<u16>,
    pub(super) values: Values,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
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

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Full(v) => v.len(),
            Self::Bits16(v) => v.len(),
            Self::Bits8(v) => v.len(),
        }
    }
}

impl Block {
    /// How many coefficients are stored.
    pub(super) fn nnz(&self) -> usize {
        self.rows.len()
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.vertex.as_slice())
            + size_of_val(self.weight.as_slice())
            + size_of_val(self.columns.as_slice())
            + size_of_val(self.starts.as_slice())
            + size_of_val(self.rows.as_slice())
            + self.values.bytes()
    }

    /// Whether every index stays inside what it points into.
    pub(super) fn is_consistent(&self, vertices: usize, columns: usize) -> bool {
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
    pub(super) fn add_radiance(&self, light: &[(u32, [f32; 4])], sums: &mut Vec<[f32; 4]>, out: &mut [Vector3<f32>]) {
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
