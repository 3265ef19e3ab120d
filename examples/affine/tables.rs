//! What tables of M and of couplings cost, and what they get wrong.

use haarmonic::affine::{
    AffineMap, CanonicalTable, Filter, MapGrid, Mother, Nonzeros1d, Quantisation, StoredCouplings, canonical as exact_m,
};
use haarmonic::haar::forward_1d;
use serde_json::{Value, json};

use crate::lights::textured;
use crate::support::table;
use crate::support::timer::seconds;
use crate::{Failure, pair};

/// Scales of the stored couplings.
pub const SCALES: [f64; 2] = [0.25, 4.0];
const CELLS: [usize; 5] = [64, 128, 256, 512, 1024];
const SAMPLES: usize = 200_000;

/// Errors of [`CanonicalTable`].
pub struct Canonical {
    rows: Vec<(usize, Quantisation, Filter, usize, [f64; 2])>,
}

/// Measures all resolutions and quantisations.
pub fn canonical() -> Result<Canonical, Failure> {
    let mut rows = Vec::new();
    for resolution in [64, 128, 256, 512] {
        for quantisation in Quantisation::ALL {
            let filters: &[Filter] = match quantisation {
                Quantisation::F32 => &[Filter::Linear, Filter::LinearFixed(8), Filter::Nearest],
                _ => &[Filter::Linear],
            };
            for &filter in filters {
                let table = CanonicalTable::new(resolution, quantisation)?.with_filter(filter);
                rows.push((resolution, quantisation, filter, table.bytes(), error_of(&table)));
            }
        }
    }
    Ok(Canonical { rows })
}

/// Largest and RMS error over the stored quarter's share that is not zero.
fn error_of(table: &CanonicalTable) -> [f64; 2] {
    let (mut most, mut squares, mut count) = (0.0f64, 0.0, 0usize);
    for k in 0..SAMPLES {
        let [u, v] = pair(k);
        let (r, c) = (0.5 * u, v - 0.5);
        if c >= -r {
            let error = table.lookup(r, c) - exact_m::<f64>(Mother::Wavelet, Mother::Wavelet, r, c);
            most = most.max(error.abs());
            squares += error * error;
            count += 1;
        }
    }
    [most, (squares / count as f64).sqrt()]
}

impl Canonical {
    pub fn table(&self) -> String {
        let row = |&(n, q, filter, bytes, [most, rms]): &(usize, Quantisation, Filter, usize, [f64; 2])| {
            vec![
                format!("{q:?}, {filter:?}"),
                n.to_string(),
                format!("{:.0} kB", bytes as f64 / 1e3),
                format!("{most:.6}"),
                format!("{rms:.6}"),
            ]
        };
        table::format(&["texels", "n", "size", "max", "RMS"], &self.rows.iter().map(row).collect::<Vec<_>>())
    }

    pub fn report(&self) -> Value {
        let row = |&(n, q, filter, bytes, [most, rms]): &(usize, Quantisation, Filter, usize, [f64; 2])| {
            json!({ "resolution": n, "quantisation": format!("{q:?}"), "filter": format!("{filter:?}"), "bytes": bytes,
                "max_abs": most, "rms": rms })
        };
        json!(self.rows.iter().map(row).collect::<Vec<_>>())
    }
}

/// Sizes and times of [`StoredCouplings`].
pub struct Stored {
    rows: Vec<(usize, Vec<Cost>)>,
}

struct Cost {
    cells: usize,
    bytes: f64,
    seconds: f64,
    measured: bool,
}

/// Builds them up to `largest`² cells, and extrapolates: both grow with the number of cells.
pub fn stored(largest: usize) -> Result<Stored, Failure> {
    let mut rows = Vec::new();
    for size in [8, 16, 32, 64] {
        let mut costs: Vec<Cost> = Vec::new();
        for cells in CELLS {
            let cost = match costs.last() {
                Some(last) if cells > largest => {
                    Cost { cells, bytes: 4.0 * last.bytes, seconds: 4.0 * last.seconds, measured: false }
                }
                _ => {
                    let grid = MapGrid::new(SCALES, [cells; 2])?;
                    let (stored, seconds) = seconds(|| StoredCouplings::new(size, grid, 4 << 30));
                    let stored = stored?;
                    Cost { cells, bytes: stored.bytes() as f64, seconds, measured: true }
                }
            };
            costs.push(cost);
        }
        rows.push((size, costs));
    }
    Ok(Stored { rows })
}

impl Stored {
    pub fn table(&self) -> String {
        let mut header = vec!["N".to_owned()];
        header.extend(CELLS.map(|n| format!("{n} x {n}")));
        let mut rows = Vec::new();
        for (size, costs) in &self.rows {
            let sign = |c: &Cost| if c.measured { "" } else { "~" };
            let cells = |value: fn(&Cost) -> String| costs.iter().map(move |c| sign(c).to_owned() + &value(c));
            rows.push([vec![size.to_string()], cells(|c| format!("{:.2} MB", c.bytes / 1e6)).collect()].concat());
            rows.push([vec![String::new()], cells(|c| format!("{:.3} s", c.seconds)).collect()].concat());
        }
        table::format(&header.iter().map(String::as_str).collect::<Vec<_>>(), &rows)
    }

    pub fn report(&self) -> Value {
        let cost =
            |c: &Cost| json!({ "cells": c.cells, "bytes": c.bytes, "seconds": c.seconds, "measured": c.measured });
        let row = |(size, costs): &(usize, Vec<Cost>)| json!({ "size": size, "tables": costs.iter().map(cost).collect::<Vec<_>>() });
        json!(self.rows.iter().map(row).collect::<Vec<_>>())
    }
}

/// The error of using the nearest entry's (s, o), for rows of textured lights; a table.
pub fn quantised() -> Result<String, Failure> {
    const SIDE: usize = 32;
    const MAPS: usize = 400;
    let lights: Vec<Vec<f64>> = (0..4)
        .flat_map(|seed| {
            let light = textured(SIDE, seed);
            [5, 13, 22].map(|row| light[row * SIDE..][..SIDE].to_vec())
        })
        .map(|row| forward_1d(&row))
        .collect::<Result<_, _>>()?;
    let nonzeros = Nonzeros1d::new(SIDE)?;
    let transform = |light: &[f64], map: AffineMap| {
        let mut target = vec![0.0; SIDE];
        nonzeros.all(map, |i, j, d| target[j] += light[i] * d);
        target
    };
    let mut rows = Vec::new();
    for cells in CELLS {
        // The entry of a cell is exact at its centre: no table is needed to know what it gives.
        let grid = MapGrid::new(SCALES, [cells; 2])?;
        let mut sum = 0.0;
        for k in 0..MAPS {
            let [u, v] = pair(k);
            let s = SCALES[0] * (SCALES[1] / SCALES[0]).powf(u);
            let map = AffineMap::new(s, v * (1.0 + s) - s)?;
            let haarmonic::affine::NearestMap::Cell { scale, offset } = grid.nearest(map) else { continue };
            let light = &lights[k % lights.len()];
            let (exact, stored) = (transform(light, map), transform(light, grid.map(scale, offset)));
            let difference: f64 = exact.iter().zip(&stored).map(|(a, b)| (a - b).powi(2)).sum();
            sum += (difference / exact.iter().map(|a| a * a).sum::<f64>()).sqrt();
        }
        rows.push(vec![format!("{cells} x {cells}"), format!("{:.4}", sum / MAPS as f64)]);
    }
    Ok(table::format(&["cells", "error"], &rows))
}
