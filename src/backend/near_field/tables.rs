//! The thesis' two ways to couplings: looked up, and made of a table of M. What they share is the product in two
//! passes.

use crate::affine::{
    AffineMap, Atom, CanonicalTable, MapGrid, Mother, Nonzeros1d, PropagationSource, Quantisation, StoredCouplings,
    canonical,
};
use crate::{Error, Result};

/// Where couplings come from.
#[derive(Debug, Clone)]
pub(super) enum Couplings {
    /// A map's, by the nearest of a grid.
    Stored(StoredCouplings),
    /// M, by look-ups.
    Canonical { table: CanonicalTable, nonzeros: Nonzeros1d },
}

/// Cells along scale and offset of the stored couplings, and texels along M: what the thesis used.
const CELLS: usize = 256;
/// The scales that have stored couplings.
const SCALES: [f64; 2] = [1.0 / 32.0, 32.0];
/// Bytes of stored couplings, at most.
const LIMIT: usize = 1 << 30;

/// Working memory of [`Couplings::propagate`].
#[derive(Debug, Clone, Default)]
pub(super) struct TableScratch {
    rows: [RowsOf; 2],
    half: Vec<[f32; 4]>,
}

/// The couplings of the functions that occur along an axis.
#[derive(Debug, Clone, Default)]
struct RowsOf {
    end: Vec<u32>,
    index: Vec<u16>,
    value: Vec<f32>,
}

impl RowsOf {
    fn row(&self, k: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let start = if k == 0 { 0 } else { self.end[k - 1] };
        let range = start as usize..self.end[k] as usize;
        self.index[range.clone()].iter().map(|&j| usize::from(j)).zip(self.value[range].iter().copied())
    }
}

impl Couplings {
    /// A table of maps for lights and faces of one side.
    pub(super) fn stored([source_side, side]: [usize; 2]) -> Result<Self> {
        if source_side != side {
            let what = "wavelets of a light along an axis, with stored couplings: the cells of the face";
            return Err(Error::Length { what, expected: side, got: source_side });
        }
        Ok(Self::Stored(StoredCouplings::new(side, MapGrid::new(SCALES, [CELLS; 2])?, LIMIT)?))
    }

    /// A table of M.
    pub(super) fn canonical([source_side, side]: [usize; 2]) -> Result<Self> {
        if source_side != side {
            let what = "wavelets of a light along an axis, with a table of M: the cells of the face";
            return Err(Error::Length { what, expected: side, got: source_side });
        }
        let table = CanonicalTable::new(CELLS, Quantisation::F32)?;
        Ok(Self::Canonical { table, nonzeros: Nonzeros1d::new(side)? })
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Stored(stored) => stored.bytes(),
            Self::Canonical { table, .. } => table.bytes(),
        }
    }

    /// The couplings of some functions under a map.
    fn set(&self, functions: &[u32], map: AffineMap, rows: &mut RowsOf) {
        rows.end.clear();
        rows.index.clear();
        rows.value.clear();
        match self {
            Self::Stored(stored) => {
                let operator = stored.operator(hold(map)).expect("a scale inside the grid");
                for &i in functions {
                    let (targets, values) = operator.row(i as usize);
                    rows.index.extend(targets.iter().map(|&j| u16::from(j)));
                    rows.value.extend_from_slice(values);
                    rows.end.push(rows.index.len() as u32);
                }
            }
            Self::Canonical { table, nonzeros } => {
                for &i in functions {
                    let source = Atom::from_flat(i as usize);
                    nonzeros.row(i as usize, map, |j, _| {
                        rows.index.push(j as u16);
                        rows.value.push(look_up(table, source, Atom::from_flat(j), map) as f32);
                    });
                    rows.end.push(rows.index.len() as u32);
                }
            }
        }
    }

    /// L = Σ F D, axis by axis [Sun 2008, §4.5.5], of all targets, R, G, B and nothing.
    pub(super) fn propagate(
        &self,
        source: &PropagationSource<f32, 3>,
        maps: [AffineMap; 2],
        side: usize,
        out: &mut [[f32; 4]],
        scratch: &mut TableScratch,
    ) {
        let TableScratch { rows, half } = scratch;
        for axis in 0..2 {
            self.set(&source.along()[axis], maps[axis], &mut rows[axis]);
        }
        half.clear();
        half.resize(source.along()[1].len() * side, [0.0; 4]);
        for ([x, y], value) in source.placed_terms() {
            let half = &mut half[y as usize * side..][..side];
            for (k, d) in rows[0].row(x as usize) {
                (0..3).for_each(|c| half[k][c] += d * value[c]);
            }
        }
        out.fill([0.0; 4]);
        for (row, half) in half.chunks_exact(side).enumerate() {
            for (k, d) in rows[1].row(row) {
                for (l, z) in out[k * side..][..side].iter_mut().zip(half) {
                    (0..4).for_each(|c| l[c] += d * z[c]);
                }
            }
        }
    }
}

/// A map whose scale the grid has.
fn hold(map: AffineMap) -> AffineMap {
    let inside = 1.0 - 1e-12;
    let scale = map.scale().clamp(SCALES[0] / inside, SCALES[1] * inside);
    AffineMap::new(scale, map.offset()).unwrap_or(map)
}

/// D = 2^{(l_i − l_j)/2} M(r, c) with M from the table where both are wavelets   [Sun 2008, eqs. 4.21–4.23].
fn look_up(table: &CanonicalTable, source: Atom, target: Atom, map: AffineMap) -> f64 {
    let [l_i, l_j] = [source, target].map(|atom| atom.level as i32);
    let radius = 2f64.powi(l_j - l_i - 1) / map.scale();
    let middle = (source.offset as f64 + 0.5) * 2f64.powi(-l_i);
    let centre = 2f64.powi(l_j) * map.solve(middle) - target.offset as f64;
    let m = match (source.mother, target.mother) {
        (Mother::Wavelet, Mother::Wavelet) => table.lookup(radius, centre),
        _ => canonical(source.mother, target.mother, radius, centre),
    };
    2f64.powf(0.5 * f64::from(l_i - l_j)) * m
}
