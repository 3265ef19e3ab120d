//! How good the choice of target coefficients by a heuristic light is.

use haarmonic::affine::{AffineMap, Heuristic, MapGrid, Nonzeros1d, NonzerosNonstandard, Prediction, mean_squares_2d};
use haarmonic::haar::{Decomposition, Keep, forward_2d};
use serde_json::{Value, json};

use crate::lights::textured;
use crate::support::table;
use crate::{Failure, pair};

/// Scales of the maps.
pub const SCALES: [f64; 2] = [0.25, 4.0];
const SIDE: usize = 32;
const LIGHTS: usize = 6;
const MAPS: usize = 96;
/// Cells along s and along each offset.
pub const CELLS: [usize; 2] = [16, 24];
/// Maps an axis of a cell over which a mean is taken.
const SAMPLES: usize = 3;

/// One line of the table.
struct Row {
    basis: &'static str,
    heuristic: String,
    kept: f64,
    /// Mean share of all coefficients that is computed, mean relative L2 error.
    share: f64,
    error: f64,
}

/// All of them.
pub struct Measured {
    rows: Vec<Row>,
}

/// A light's coefficients on the target for a pair of maps.
fn propagate(light: &[f64], maps: [AffineMap; 2], decomposition: Decomposition) -> Result<Vec<f64>, Failure> {
    let mut target = vec![0.0; SIDE * SIDE];
    match decomposition {
        Decomposition::Standard => {
            let nonzeros = Nonzeros1d::new(SIDE)?;
            let mut half = vec![0.0; SIDE * SIDE];
            nonzeros.all(maps[0], |i, j, d| (0..SIDE).for_each(|y| half[y * SIDE + j] += light[y * SIDE + i] * d));
            nonzeros.all(maps[1], |i, j, d| (0..SIDE).for_each(|x| target[j * SIDE + x] += half[i * SIDE + x] * d));
        }
        Decomposition::Nonstandard => {
            NonzerosNonstandard::new(SIDE)?.all(maps, |i, j, d| target[j] += light[i] * d);
        }
    }
    Ok(target)
}

/// Compares the heuristics on lights that none of them was made from.
pub fn measure() -> Result<Measured, Failure> {
    let mut rows = Vec::new();
    for (basis, decomposition) in [("standard", Decomposition::Standard), ("nonstandard", Decomposition::Nonstandard)] {
        let coefs = |seed| forward_2d(&textured(SIDE, seed), SIDE, SIDE, decomposition);
        let lights: Vec<Vec<f64>> = (0..LIGHTS).map(coefs).collect::<Result<_, _>>()?;
        let others: Vec<Vec<f64>> = (100..108).map(coefs).collect::<Result<_, _>>()?;
        let mut targets = Vec::new();
        for k in 0..MAPS {
            let ([u, x], [y, _]) = (pair(2 * k), pair(2 * k + 1));
            let s = SCALES[0] * (SCALES[1] / SCALES[0]).powf(u);
            // The light covers at least a tenth of the reach along each axis.
            let offset = |t: f64| AffineMap::new(s, (0.05 + 0.9 * t) * (1.0 + s) - s);
            let maps = [offset(x)?, offset(y)?];
            targets.push((k % LIGHTS, maps, propagate(&lights[k % LIGHTS], maps, decomposition)?));
        }
        let views: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
        let power = mean_squares_2d(SIDE, decomposition, &views)?;
        let grid = MapGrid::new(SCALES, CELLS)?;
        for fraction in [0.1, 0.2, 0.3] {
            let keep = Keep::Fraction(fraction);
            let mut row = |heuristic: String, choose: &dyn Fn(usize, [AffineMap; 2]) -> Vec<u32>| {
                let (share, error) = mean_error(&targets, choose);
                rows.push(Row { basis, heuristic, kept: fraction, share, error });
            };
            let one = |heuristic: Heuristic<'_>| Prediction::<2>::new(SIDE, decomposition, heuristic, grid, keep);
            let constant = [
                one(Heuristic::Constant)?,
                one(Heuristic::Constant)?.with_union(1),
                one(Heuristic::Constant)?.with_samples(SAMPLES),
            ];
            for (name, constant) in ["", ", union of 3^3 cells", ", mean over each cell"].into_iter().zip(constant) {
                row(format!("constant{name}"), &|_, maps| constant.targets(maps).to_vec());
            }
            let others = [one(Heuristic::Power(&power))?, one(Heuristic::Power(&power))?.with_samples(SAMPLES)];
            for (name, others) in ["", ", mean over each cell"].into_iter().zip(others) {
                row(format!("power of other lights, by level{name}"), &|_, maps| others.targets(maps).to_vec());
            }
            for (name, samples) in [("", 1), (", mean over each cell", SAMPLES)] {
                let itself = |light: &Vec<f64>| Ok(one(Heuristic::Light(light))?.with_samples(samples));
                let itself: Vec<Prediction<2>> = lights.iter().map(itself).collect::<Result<_, Failure>>()?;
                row(format!("the light itself{name}"), &|light, maps| itself[light].targets(maps).to_vec());
            }
            let count = keep.of(SIDE * SIDE);
            row("ideal: the largest".into(), &|light, maps| {
                let target = targets.iter().find(|(l, m, _)| *l == light && *m == maps).map(|t| &t.2);
                let target = target.expect("one of the targets");
                let mut order: Vec<u32> = (0..target.len() as u32).collect();
                order.sort_by(|a, b| target[*b as usize].abs().total_cmp(&target[*a as usize].abs()));
                order.truncate(count);
                order
            });
        }
    }
    Ok(Measured { rows })
}

/// Mean share of the coefficients that is chosen and mean relative L2 error of what is left out.
fn mean_error(
    targets: &[(usize, [AffineMap; 2], Vec<f64>)],
    choose: &dyn Fn(usize, [AffineMap; 2]) -> Vec<u32>,
) -> (f64, f64) {
    let (mut share, mut error) = (0.0, 0.0);
    for (light, maps, target) in targets {
        let chosen = choose(*light, *maps);
        let energy = |values: &mut dyn Iterator<Item = f64>| values.map(|l| l * l).sum::<f64>();
        let all = energy(&mut target.iter().copied());
        let kept = energy(&mut chosen.iter().map(|&k| target[k as usize]));
        share += chosen.len() as f64 / target.len() as f64;
        error += if all > 0.0 { (1.0 - kept / all).max(0.0).sqrt() } else { 0.0 };
    }
    (share / targets.len() as f64, error / targets.len() as f64)
}

impl Measured {
    pub fn table(&self) -> String {
        let header = ["basis and heuristic", "asked", "computed", "rel L2"];
        let row = |r: &Row| {
            vec![
                format!("{}: {}", r.basis, r.heuristic),
                format!("{:.0} %", 100.0 * r.kept),
                format!("{:.1} %", 100.0 * r.share),
                format!("{:.4}", r.error),
            ]
        };
        table::format(&header, &self.rows.iter().map(row).collect::<Vec<_>>())
    }

    pub fn report(&self) -> Value {
        let row = |r: &Row| json!({ "basis": r.basis, "heuristic": r.heuristic, "asked": r.kept, "computed": r.share, "rel_l2": r.error });
        json!(self.rows.iter().map(row).collect::<Vec<_>>())
    }
}
