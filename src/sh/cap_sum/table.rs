//! The zonal functions of a plan, tabulated over the solid angle of their caps.

use std::f64::consts::PI;

use super::pieces::pieces;
use crate::sh::basis::kernel::Table;
use crate::{Error, Real, Result};

/// The most bands: those of [`CapLog`](crate::sh::CapLog).
pub(super) const MAX_BANDS: usize = 32;

/// k_l/u over u = 1 − cos θ, linear between nodes, where k_l are the factors of degree l.
///
/// Nodes are evenly spaced in each piece. Which cell a u lies in is said by a coordinate x that counts cells,
///
/// ```math
/// x(u) = Σ_p slope_p clamp(u − start_p, 0, length_p)
/// ```
///
/// so that lanes need no search among the pieces.
#[derive(Debug, Clone)]
pub(super) struct CapTable<T> {
    pub bands: usize,
    /// The constants of the basis.
    pub basis: Table<T>,
    /// (start, length, slope).
    pub pieces: Vec<[T; 3]>,
    pub largest: T,
    pub cells: T,
    /// `bands` numbers a node.
    pub nodes: Vec<T>,
}

/// 1 − cos θ, of which small θ lose nothing.
pub(super) fn versine(theta: f64) -> f64 {
    let half = (0.5 * theta).sin();
    2.0 * half * half
}

/// The angle of a versine.
fn angle(versine: f64) -> f64 {
    2.0 * (0.5 * versine).sqrt().min(1.0).asin()
}

/// √(4π/(2l+1)): the factor of degree l over its coefficient.
pub(super) fn factor_over_coefficient(l: usize) -> f64 {
    (4.0 * PI / (2 * l + 1) as f64).sqrt()
}

impl<T: Real> CapTable<T> {
    /// Tabulates f_l/(1 − cos θ); also returns the largest error at three points inside each cell.
    pub fn new(bands: usize, knots: &[f64], cells: usize, mut f: impl FnMut(f64, &mut [f64])) -> Result<(Self, f64)> {
        check(bands, knots, cells)?;
        let mut density = |u: f64| {
            let mut values = vec![0.0; bands];
            f(angle(u), &mut values);
            values.iter_mut().for_each(|value| *value /= u);
            values
        };
        let ends: Vec<f64> = [0.0].into_iter().chain(knots.iter().map(|&theta| versine(theta))).collect();
        let pieces = pieces(&ends, cells, &mut density);
        let mut nodes = Vec::with_capacity((cells + 1) * bands);
        // At u = 0 the quotient is that of nothing by nothing: it is continued from the first cell.
        let first = pieces[0].length / pieces[0].cells as f64;
        let [a, b, c] = [0.25, 0.5, 0.75].map(|x| density(x * first));
        nodes.extend((0..bands).map(|l| 3.0 * (a[l] - b[l]) + c[l]));
        let (mut between, mut before) = (Vec::new(), 0);
        for piece in &pieces {
            for cell in 0..piece.cells {
                nodes.extend(density(piece.at((cell + 1) as f64)));
                for t in [0.25, 0.5, 0.75] {
                    between.push((before + cell, t, density(piece.at(cell as f64 + t))));
                }
            }
            before += piece.cells;
        }
        let scaled = nodes.iter().enumerate().map(|(i, &value)| T::of(value * factor_over_coefficient(i % bands)));
        let table = Self {
            bands,
            basis: Table::new(bands),
            pieces: pieces.iter().map(|p| [p.start, p.length, p.cells as f64 / p.length].map(T::of)).collect(),
            largest: T::of(ends[ends.len() - 1]),
            cells: T::of(cells as f64),
            nodes: scaled.collect(),
        };
        if let Some(index) = table.nodes.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite { what: "zonal function over its solid angle, node by node:", index });
        }
        let error = between.iter().map(|(cell, t, want)| table.error(*cell, *t, want)).fold(0.0, f64::max);
        Ok((table, error))
    }

    /// How far f_l/(1 − cos θ) is from the line of its cell, at most.
    fn error(&self, cell: usize, t: f64, want: &[f64]) -> f64 {
        let rows = &self.nodes[cell * self.bands..][..2 * self.bands];
        let error = |(l, want): (usize, &f64)| {
            let [a, b] = [rows[l], rows[l + self.bands]].map(|k| k.widen() / factor_over_coefficient(l));
            (a + t * (b - a) - want).abs()
        };
        want.iter().enumerate().map(error).fold(0.0, f64::max)
    }
}

fn check(bands: usize, knots: &[f64], cells: usize) -> Result<()> {
    if !(1..=MAX_BANDS).contains(&bands) {
        return Err(Error::OutOfRange { what: "bands", got: bands as f64, allowed: "1 to 32" });
    }
    if knots.is_empty() {
        return Err(Error::Empty { what: "list of knots" });
    }
    let mut below = 0.0;
    for &knot in knots {
        if !(knot > below && knot <= PI) {
            return Err(Error::OutOfRange {
                what: "knot of a zonal table", got: knot, allowed: "ascending in (0, π]"
            });
        }
        below = knot;
    }
    if !(knots.len()..=1 << 16).contains(&cells) {
        let allowed = "at least the number of knots and at most 65536";
        return Err(Error::OutOfRange { what: "cells of a zonal table", got: cells as f64, allowed });
    }
    Ok(())
}
