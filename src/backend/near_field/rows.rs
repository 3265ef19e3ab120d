//! The rows of a transport: sparse images, one after the other.

use std::ops::Range;

use super::settings::Precision;

/// The coefficients of all rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    Full(Vec<f32>),
    Bits16(Vec<i16>),
}

/// Rows of vertices. A vertex has none if it sees nothing, one if its BRDF has a colour, three otherwise, and so many a
/// product of a BRDF that was taken apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rows {
    /// Of each vertex: where its rows end.
    pub(super) vertex_end: Vec<u32>,
    /// Of each row: what its integral adds to R, G and B.
    pub(super) weight: Vec<[f32; 3]>,
    /// Of each row: the product it belongs to; 0 where the view is fixed.
    pub(super) term: Vec<u16>,
    /// Of each row: where its entries end.
    pub(super) row_end: Vec<u64>,
    /// Of each entry: its wavelet, ascending within a row.
    pub(super) index: Vec<u16>,
    pub(super) values: Values,
}

impl Rows {
    pub(super) fn new(precision: Precision) -> Self {
        let values = match precision {
            Precision::Full => Values::Full(Vec::new()),
            Precision::Bits16 => Values::Bits16(Vec::new()),
        };
        let (vertex_end, weight, term) = (Vec::new(), Vec::new(), Vec::new());
        Self { vertex_end, weight, term, row_end: Vec::new(), index: Vec::new(), values }
    }

    /// Adds a row to the vertex that is not ended yet: coefficients of at least a threshold.
    pub(super) fn push(&mut self, coefs: &[f32], threshold: f32, weight: [f32; 3], term: usize) {
        let largest = coefs.iter().fold(0.0f32, |m, x| m.max(x.abs()));
        if largest == 0.0 {
            return;
        }
        let scale = match &self.values {
            Values::Full(_) => 1.0,
            Values::Bits16(_) => largest / 32767.0,
        };
        for (i, &x) in coefs.iter().enumerate().filter(|(_, x)| x.abs() >= threshold) {
            match &mut self.values {
                Values::Full(values) if x != 0.0 => values.push(x),
                Values::Bits16(values) if (x / scale).round() != 0.0 => values.push((x / scale).round() as i16),
                _ => continue,
            }
            self.index.push(i as u16);
        }
        self.weight.push(weight.map(|w| w * scale));
        self.term.push(term as u16);
        self.row_end.push(self.index.len() as u64);
    }

    /// The vertex has all its rows.
    pub(super) fn end_vertex(&mut self) {
        self.vertex_end.push(self.row_end.len() as u32);
    }

    /// Adds the vertices of others.
    pub(super) fn append(&mut self, other: &Self) {
        let (rows, entries) = (self.row_end.len() as u32, self.index.len() as u64);
        self.vertex_end.extend(other.vertex_end.iter().map(|end| end + rows));
        self.weight.extend_from_slice(&other.weight);
        self.term.extend_from_slice(&other.term);
        self.row_end.extend(other.row_end.iter().map(|end| end + entries));
        self.index.extend_from_slice(&other.index);
        match (&mut self.values, &other.values) {
            (Values::Full(a), Values::Full(b)) => a.extend_from_slice(b),
            (Values::Bits16(a), Values::Bits16(b)) => a.extend_from_slice(b),
            _ => unreachable!("one bake has one precision"),
        }
    }

    pub(super) fn vertices(&self) -> usize {
        self.vertex_end.len()
    }

    pub(super) fn len(&self) -> usize {
        self.row_end.len()
    }

    pub(super) fn entries(&self) -> usize {
        self.index.len()
    }

    /// The rows of a vertex.
    #[inline]
    pub(super) fn of(&self, vertex: usize) -> Range<usize> {
        let start = if vertex == 0 { 0 } else { self.vertex_end[vertex - 1] };
        start as usize..self.vertex_end[vertex] as usize
    }

    /// The entries of a row.
    #[inline]
    pub(super) fn entries_of(&self, row: usize) -> Range<usize> {
        let start = if row == 0 { 0 } else { self.row_end[row - 1] };
        start as usize..self.row_end[row] as usize
    }

    /// Calls `each(index, value)` for the entries of a row, without its scale.
    #[inline]
    pub(super) fn for_each(&self, row: usize, mut each: impl FnMut(usize, f32)) {
        let range = self.entries_of(row);
        let index = self.index[range.clone()].iter().map(|&i| usize::from(i));
        match &self.values {
            Values::Full(values) => index.zip(&values[range]).for_each(|(i, &x)| each(i, x)),
            Values::Bits16(values) => index.zip(&values[range]).for_each(|(i, &x)| each(i, f32::from(x))),
        }
    }

    /// Σ value · light over the entries of a row, light in R, G, B and nothing.
    #[inline]
    pub(super) fn dot(&self, row: usize, light: &[[f32; 4]]) -> [f32; 4] {
        let mut sum = [0.0; 4];
        self.for_each(row, |i, value| {
            let light = light[i];
            for c in 0..4 {
                sum[c] += value * light[c];
            }
        });
        sum
    }

    pub(super) fn bytes(&self) -> usize {
        let values = match &self.values {
            Values::Full(values) => size_of_val(values.as_slice()),
            Values::Bits16(values) => size_of_val(values.as_slice()),
        };
        size_of_val(self.vertex_end.as_slice())
            + size_of_val(self.weight.as_slice())
            + size_of_val(self.term.as_slice())
            + size_of_val(self.row_end.as_slice())
            + size_of_val(self.index.as_slice())
            + values
    }

    /// What is wrong with rows of so many wavelets and products that come from a file; nothing if every index stays
    /// inside of what it points into and every number is finite.
    pub(super) fn fault(&self, wavelets: usize, terms: usize) -> Option<&'static str> {
        let values = match &self.values {
            Values::Full(values) => values.len(),
            Values::Bits16(values) => values.len(),
        };
        let is_finite = match &self.values {
            Values::Full(values) => values.iter().all(|x| x.is_finite()),
            Values::Bits16(_) => true,
        };
        let rows = self.row_end.len();
        let ends = self.vertex_end.is_sorted() && self.vertex_end.last().map_or(0, |&end| end as usize) == rows;
        let row_ends = self.row_end.is_sorted() && self.row_end.last().map_or(0, |&end| end) == self.index.len() as u64;
        let checks = [
            (ends, "vertices do not end where their rows do"),
            (row_ends, "rows do not end where their entries do"),
            (self.weight.len() == rows && self.term.len() == rows, "there is not one weight and product a row"),
            (values == self.index.len(), "there is not one value an index"),
            (self.index.iter().all(|&i| usize::from(i) < wavelets), "a wavelet is not there"),
            (self.term.iter().all(|&k| usize::from(k) < terms), "a product is not there"),
            (self.weight.as_flattened().iter().all(|x| x.is_finite()), "a weight is NaN or infinite"),
            (is_finite, "a value is NaN or infinite"),
        ];
        checks.iter().find(|(holds, _)| !holds).map(|(_, fault)| *fault).or_else(|| {
            let rises = |row| self.index[self.entries_of(row)].is_sorted_by(|a, b| a < b);
            (!(0..rows).all(rises)).then_some("the wavelets of a row do not rise")
        })
    }
}
