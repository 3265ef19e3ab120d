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

    /// What is wrong with a block of so many vertices and columns that comes from a file; nothing if every index stays
    /// inside of what it points into and every number is finite.
    pub(super) fn fault(&self, vertices: usize, columns: usize) -> Option<&'static str> {
        let is_finite = |values: &Values| match values {
            Values::Full(values) => values.iter().all(|x| x.is_finite()),
            Values::Bits16(_) | Values::Bits8(_) => true,
        };
        let (first, last) = (self.starts.first(), self.starts.last().map(|&end| end as usize));
        let checks = [
            (self.vertex.iter().all(|&v| usize::from(v) < vertices), "a row is of a vertex that is not there"),
            (self.columns.is_sorted_by(|a, b| a < b), "columns do not rise"),
            (self.columns.last().is_none_or(|&c| (c as usize) < columns), "a column is not there"),
            (self.starts.len() == self.columns.len() + 1, "there is not one start a column, and an end"),
            (self.starts.is_sorted(), "a column ends before it starts"),
            (first == Some(&0) && last == Some(self.rows.len()), "columns do not begin and end where their rows do"),
            (self.rows.len() == self.values.len(), "there is not one value a row index"),
            (self.rows.iter().all(|&r| usize::from(r) < self.vertex.len()), "a row is not there"),
            (self.weight.as_flattened().iter().all(|x| x.is_finite()), "a weight is NaN or infinite"),
            (is_finite(&self.values), "a value is NaN or infinite"),
        ];
        checks.iter().find(|(holds, _)| !holds).map(|(_, fault)| *fault)
    }

    /// Adds the radiance of the block's vertices to `out`, which is 0, using `sums` (one a row) as scratch. What is
    /// beyond the largest `f32` is that.
    pub(super) fn add_radiance(&self, light: &[(u32, [f32; 4])], sums: &mut Vec<[f32; 4]>, out: &mut [Vector3<f32>]) {
        sums.clear();
        sums.resize(self.vertex.len(), [0.0; 4]);
        self.accumulate(light, sums);
        for ((&vertex, weight), sum) in self.vertex.iter().zip(&self.weight).zip(sums.iter()) {
            out[usize::from(vertex)] += Vector3::new(sum[0] * weight[0], sum[1] * weight[1], sum[2] * weight[2]);
        }
        if !out.iter().all(|l| l.iter().all(|c| c.is_finite())) {
            self.set_wide_radiance(light, out);
        }
    }

    /// As [`add_radiance`](Self::add_radiance), where sums leave the range of `f32` on the way: by numbers that no
    /// measured reflectance has.
    #[cold]
    fn set_wide_radiance(&self, light: &[(u32, [f32; 4])], out: &mut [Vector3<f32>]) {
        let mut sums = vec![[0.0_f64; 4]; self.vertex.len()];
        self.accumulate(light, &mut sums);
        let mut wide = vec![Vector3::<f64>::zeros(); out.len()];
        for ((&vertex, weight), sum) in self.vertex.iter().zip(&self.weight).zip(&sums) {
            let weight = weight.map(f64::from);
            wide[usize::from(vertex)] += Vector3::new(sum[0] * weight[0], sum[1] * weight[1], sum[2] * weight[2]);
        }
        let limit = f64::from(f32::MAX);
        out.iter_mut().zip(&wide).for_each(|(out, l)| *out = l.map(|c| c.clamp(-limit, limit) as f32));
    }

    fn accumulate<S: Scalar>(&self, light: &[(u32, [f32; 4])], sums: &mut [[S; 4]]) {
        match &self.values {
            Values::Full(v) => self.accumulate_values(v, light, sums),
            Values::Bits16(v) => self.accumulate_values(v, light, sums),
            Values::Bits8(v) => self.accumulate_values(v, light, sums),
        }
    }

    /// sums[row] += value · light over the columns that block and light share.
    fn accumulate_values<V: Copy + Into<f32>, S: Scalar>(
        &self,
        values: &[V],
        light: &[(u32, [f32; 4])],
        sums: &mut [[S; 4]],
    ) {
        let mut at = 0;
        for &(column, colour) in light {
            // Both lists ascend: the search begins where the last one ended.
            at += self.columns[at..].partition_point(|&c| c < column);
            if self.columns.get(at) != Some(&column) {
                continue;
            }
            let colour = colour.map(S::from);
            let run = self.starts[at] as usize..self.starts[at + 1] as usize;
            for (&row, &value) in self.rows[run.clone()].iter().zip(&values[run]) {
                let value = S::from(value.into());
                let sum = &mut sums[usize::from(row)];
                for c in 0..4 {
                    sum[c] += value * colour[c];
                }
            }
        }
    }
}

/// What radiance is summed in: `f32`, or `f64` where that does not hold it.
trait Scalar: Copy + From<f32> + std::ops::AddAssign + std::ops::Mul<Output = Self> {}
impl Scalar for f32 {}
impl Scalar for f64 {}
