//! The route through wavelets: couplings of the terms that there are, with the targets that are wanted.

use pulp::{Simd, WithSimd};

use super::source::Terms;
use super::targets::{BLOCK, Chosen, Targets, is_sparse_row};
use crate::Real;
use crate::affine::steps::{Steps, row_room};
use crate::affine::{AffineMap, Atom, NonzerosNonstandard};

/// Couplings of the functions that occur along one axis, row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows<T> {
    /// Room for each row.
    pitch: usize,
    len: Vec<u32>,
    index: Vec<u32>,
    value: Vec<T>,
}

impl<T: Real> Rows<T> {
    #[inline(always)]
    fn set(&mut self, levels: u32, functions: &[u32], map: AffineMap) {
        let pitch = row_room(levels);
        self.pitch = pitch;
        self.len.resize(functions.len(), 0);
        self.index.resize(functions.len() * pitch, 0);
        self.value.resize(functions.len() * pitch, T::zero());
        let rows = self.index.chunks_exact_mut(pitch).zip(self.value.chunks_exact_mut(pitch));
        for ((&i, len), (index, value)) in functions.iter().zip(&mut self.len).zip(rows) {
            let steps = Steps::of_source(Atom::from_flat(i as usize), map);
            *len = steps.write_basis(levels, index, value) as u32;
        }
    }

    #[inline(always)]
    fn row(&self, k: usize) -> (&[u32], &[T]) {
        let range = k * self.pitch..k * self.pitch + self.len[k] as usize;
        (&self.index[range.clone()], &self.value[range])
    }

    #[inline(always)]
    fn rows(&self) -> impl Iterator<Item = (&[u32], &[T])> {
        (0..self.len.len()).map(|k| self.row(k))
    }
}

/// The two passes of [Sun 2008, §4.5.5], standard basis:
/// ```math
/// Z[i₂][k₁] = Σ_{i₁} F[i₂][i₁] D[i₁][k₁],   L[k₂][k₁] = Σ_{i₂} D[i₂][k₂] Z[i₂][k₁].
/// ```
pub(super) struct TwoPass<'a, T, const C: usize> {
    pub(super) levels: u32,
    pub(super) maps: [AffineMap; 2],
    pub(super) terms: &'a Terms<T, C>,
    pub(super) targets: &'a Targets,
    pub(super) rows: &'a mut [Rows<T>; 2],
    /// By target row k₂: the i₂ that reach it (place in `terms.along[1]`) and how.
    pub(super) reach: &'a mut Vec<(u32, T)>,
    pub(super) reach_end: &'a mut Vec<u32>,
    /// Z, plane by plane: side values for each i₂ and channel.
    pub(super) half: &'a mut Vec<T>,
    pub(super) out: [&'a mut [T]; C],
}

impl<T: Real, const C: usize> WithSimd for TwoPass<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { levels, maps, terms, targets, rows, reach, reach_end, half, out } = self;
        let side = 1usize << levels;
        for axis in 0..2 {
            rows[axis].set(levels, &terms.along[axis], maps[axis]);
        }
        half.clear();
        half.resize(terms.along[1].len() * C * side, T::zero());
        for (&[x, y], value) in terms.slot.iter().zip(&terms.value) {
            let (index, couplings) = rows[0].row(x as usize);
            let z = &mut half[y as usize * C * side..][..C * side];
            for (&k, &d) in index.iter().zip(couplings) {
                for c in 0..C {
                    z[c * side + k as usize] += value[c] * d;
                }
            }
        }
        match &targets.chosen {
            None => all(side, &rows[1], half, out),
            Some(chosen) => {
                by_target(side, &rows[1], reach, reach_end);
                let terms = half.len();
                half.resize(terms + C * side, T::zero());
                let (half, row) = half.split_at_mut(terms);
                some(side, chosen, (reach, reach_end), half, row, out);
            }
        }
    }
}

/// Every L[k₂][k₁]: whole rows of Z at a time.
#[inline(always)]
fn all<T: Real, const C: usize>(side: usize, rows: &Rows<T>, half: &[T], out: [&mut [T]; C]) {
    for (c, out) in out.into_iter().enumerate() {
        out.fill(T::zero());
        for (z, (index, couplings)) in half.chunks_exact(C * side).zip(rows.rows()) {
            let z = &z[c * side..][..side];
            for (&k, &d) in index.iter().zip(couplings) {
                for (l, &z) in out[k as usize * side..][..side].iter_mut().zip(z) {
                    *l += d * z;
                }
            }
        }
    }
}

/// Turns rows by source into lists by target.
#[inline(always)]
fn by_target<T: Real>(side: usize, rows: &Rows<T>, reach: &mut Vec<(u32, T)>, end: &mut Vec<u32>) {
    end.clear();
    end.resize(side + 1, 0);
    for (index, _) in rows.rows() {
        for &k in index {
            end[k as usize + 1] += 1;
        }
    }
    for k in 0..side {
        end[k + 1] += end[k];
    }
    reach.clear();
    reach.resize(end[side] as usize, (0, T::zero()));
    for (slot, (index, couplings)) in rows.rows().enumerate() {
        for (&k, &d) in index.iter().zip(couplings) {
            reach[end[k as usize] as usize] = (slot as u32, d);
            end[k as usize] += 1;
        }
    }
}

/// The wanted L[k₂][k₁], row by row: a whole row at a time, unless few of it are wanted.
#[inline(always)]
fn some<T: Real, const C: usize>(
    side: usize,
    chosen: &Chosen,
    (reach, reach_end): (&[(u32, T)], &[u32]),
    half: &[T],
    row: &mut [T],
    mut out: [&mut [T]; C],
) {
    let mut begin = 0;
    for &(k, end) in &chosen.rows {
        let range = begin..end as usize;
        begin = end as usize;
        let first = if k == 0 { 0 } else { reach_end[k as usize - 1] as usize };
        let list = &reach[first..reach_end[k as usize] as usize];
        let wanted = &chosen.index[range.clone()];
        let column = |k: u32| k as usize & (side - 1);
        if list.is_empty() {
            out.iter_mut().for_each(|out| out[range.clone()].fill(T::zero()));
            continue;
        }
        if is_sparse_row(side, wanted.len()) {
            for (&k, at) in wanted.iter().zip(range) {
                for c in 0..C {
                    let z = &half[c * side + column(k)..];
                    out[c][at] = list.iter().map(|&(slot, d)| d * z[slot as usize * C * side]).sum();
                }
            }
            continue;
        }
        for (block, row) in row.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
            let mut sum = [T::zero(); BLOCK];
            for &(slot, d) in list {
                let z: &[T; BLOCK] = &half[slot as usize * C * side + block * BLOCK..].as_chunks().0[0];
                for x in 0..BLOCK {
                    sum[x] += d * z[x];
                }
            }
            *row = sum;
        }
        for c in 0..C {
            let row = &row[c * side..][..side];
            for (out, &k) in out[c][range.clone()].iter_mut().zip(wanted) {
                *out = row[column(k)];
            }
        }
    }
}

/// Term by term over the products of the couplings of its two factors, nonstandard basis.
#[inline(always)]
pub(super) fn products<T: Real, const C: usize>(
    nonzeros: NonzerosNonstandard,
    maps: [AffineMap; 2],
    terms: &Terms<T, C>,
    targets: &Targets,
    mut out: [&mut [T]; C],
) {
    for plane in &mut out {
        plane.fill(T::zero());
    }
    let place = targets.chosen.as_ref().map(|chosen| chosen.place.as_slice());
    for (&i, value) in terms.index.iter().zip(&terms.value) {
        let mut add = |at: usize, d: f64| {
            for c in 0..C {
                out[c][at] += value[c] * T::of(d);
            }
        };
        match place {
            None => nonzeros.row(i as usize, maps, &mut add),
            Some(place) => nonzeros.row(i as usize, maps, |j, d| {
                if let Some(at) = place[j].checked_sub(1) {
                    add(at as usize, d);
                }
            }),
        }
    }
}
