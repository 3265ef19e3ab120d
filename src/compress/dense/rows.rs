//! Rows of a matrix as they enter products: some of them, shifted and scaled.

use crate::Real;

/// A power of two by which a matrix is multiplied before anything is squared, so that neither large nor small numbers
/// leave the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct Scaling(f64);

impl Scaling {
    /// Brings `largest` below 1; exact but for numbers that become subnormal beside it.
    pub(in super::super) fn of<T: Real>(largest: f64) -> Self {
        if largest == 0.0 {
            return Self(1.0);
        }
        // Exponents of f32 go to 127; of f64 to 1023.
        let limit = if size_of::<T>() == 4 { 126.0 } else { 1022.0 };
        Self((-(largest.log2().floor() + 1.0)).clamp(-limit, limit).exp2())
    }

    pub(in super::super) fn factor(self) -> f64 {
        self.0
    }
}

/// scale · (row − mean) of chosen rows, as numbers of the kind that products are computed in.
#[derive(Clone, Copy)]
pub(in super::super) struct Rows<'a, T, E> {
    data: &'a [T],
    columns: usize,
    order: Option<&'a [u32]>,
    shift: &'a [E],
    scale: E,
}

impl<'a, T: Real, E: Real> Rows<'a, T, E> {
    /// All rows; `shift` is the mean times the scale.
    pub(in super::super) fn new(data: &'a [T], shift: &'a [E], scaling: Scaling) -> Self {
        Self { data, columns: shift.len(), order: None, shift, scale: E::of(scaling.0) }
    }

    /// The rows that `order` lists.
    pub(in super::super) fn only(self, order: &'a [u32]) -> Self {
        Self { order: Some(order), ..self }
    }

    pub(in super::super) fn len(&self) -> usize {
        self.order.map_or(self.data.len() / self.columns.max(1), <[u32]>::len)
    }

    pub(in super::super) fn columns(&self) -> usize {
        self.columns
    }

    #[inline(always)]
    fn row(&self, i: usize) -> &'a [T] {
        let i = self.order.map_or(i, |order| order[i] as usize);
        &self.data[i * self.columns..][..self.columns]
    }

    /// Columns `first..first + out.len()` of row i.
    #[inline(always)]
    pub(in super::super) fn copy(&self, i: usize, first: usize, out: &mut [E]) {
        let row = &self.row(i)[first..][..out.len()];
        let shift = &self.shift[first..][..out.len()];
        for ((out, &x), &shift) in out.iter_mut().zip(row).zip(shift) {
            *out = E::of(x.widen()) * self.scale - shift;
        }
    }
}
