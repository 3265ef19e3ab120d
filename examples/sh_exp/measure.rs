//! Every method on every union: errors and times.

use std::time::Instant;

use haarmonic::sh::{Basis, CapFit, CapLog, ExpMethod, Exponential, GridFunction, LogMethod, Logarithm, Product};
use serde_json::{Value, json};

use crate::scenes::{Scenes, disc, turned};
use crate::support::{Failure, table};

/// Upper ends of the bins of ‖f̂‖.
pub const BINS: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, f64::INFINITY];
/// Vectors that are timed at once.
const BATCH: usize = 256;
const ROUNDS: usize = 30;

/// What a method did.
pub struct Row {
    pub name: &'static str,
    /// Mean relative error, all and in each bin; NaN where there is none.
    pub error: f64,
    pub bins: [f64; 6],
    /// Mean relative difference from the projected exp of the same f.
    pub truth: f64,
    /// Nanoseconds of a vector in f32: alone, in a batch.
    pub times: Option<[f64; 2]>,
}

/// All methods of a number of bands.
pub struct Measured {
    pub bands: usize,
    pub counts: [usize; 6],
    /// ‖f̂‖, the mean in each bin.
    pub norms: [f64; 6],
    pub rows: Vec<Row>,
}

/// One method and how it is scaled.
struct Contender {
    name: &'static str,
    method: ExpMethod,
    scaled_norm: f64,
    fit: CapFit,
}

fn contenders() -> Vec<Contender> {
    use ExpMethod::{Eigen, Grid, Hybrid, OptimalLinear, ScaledSeries, Series};
    let one = |name, method| Contender { name, method, scaled_norm: 0.125, fit: CapFit::default() };
    vec![
        one("PS-2", Series { degree: 2 }),
        one("PS-9", Series { degree: 9 }),
        one("PS*-2", ScaledSeries { degree: 2 }),
        one("PS*-3", ScaledSeries { degree: 3 }),
        Contender { scaled_norm: 0.5, ..one("PS*-2, to 1/2", ScaledSeries { degree: 2 }) },
        Contender { scaled_norm: 0.5, ..one("PS*-3, to 1/2", ScaledSeries { degree: 3 }) },
        Contender { scaled_norm: 1.0, ..one("PS*-4, to 1", ScaledSeries { degree: 4 }) },
        one("PS*-9", ScaledSeries { degree: 9 }),
        one("OL", OptimalLinear),
        one("HYB", Hybrid),
        one("exp(M)1", Eigen),
        one("grid", Grid),
        Contender { fit: CapFit::Grid, ..one("grid, fitted discs", Grid) },
    ]
}

impl Measured {
    pub fn new(bands: usize, scenes: &Scenes) -> Result<Self, Failure> {
        let logs = |fit| {
            sums(bands, scenes, |angle, zonal| {
                let table = match &fit {
                    Fit::Table(table) => table,
                    Fit::Clipped(log) => {
                        return Ok(log.apply_zonal(&disc(bands, angle), zonal)?);
                    }
                };
                table.eval(angle, zonal);
                Ok(())
            })
        };
        let by_products = logs(Fit::Table(CapLog::new(bands, CapFit::default())?))?;
        let by_grid = logs(Fit::Table(CapLog::new(bands, CapFit::Grid)?))?;
        let clipped = logs(Fit::Clipped(Box::new(Logarithm::new(bands, LogMethod::Clipped { floor: 0.02 })?)))?;
        let norms: Vec<f64> = by_products.iter().map(|f| norm(&f[1..])).collect();
        let mut measured = Self { bands, counts: [0; 6], norms: [0.0; 6], rows: Vec::new() };
        for &x in &norms {
            measured.counts[bin(x)] += 1;
            measured.norms[bin(x)] += x;
        }
        for (sum, &count) in measured.norms.iter_mut().zip(&measured.counts) {
            *sum /= count as f64;
        }
        measured.rows.push(measured.row("products", scenes, &norms, &products(bands, scenes)?, &[], None));
        let fine = GridFunction::<f64>::with_rings(bands, 48)?;
        let project = |logs: &[Vec<f64>]| -> Vec<Vec<f64>> {
            logs.iter().map(|f| apply(f, |f, out| fine.apply(f, f64::exp, out))).collect()
        };
        let truths = [project(&by_products), project(&by_grid)];
        for contender in contenders() {
            let (logs, truth) =
                if contender.fit == CapFit::Grid { (&by_grid, &truths[1]) } else { (&by_products, &truths[0]) };
            let plan = Exponential::<f64>::new(bands, contender.method)?.with_scaled_norm(contender.scaled_norm)?;
            let results: Vec<Vec<f64>> = logs.iter().map(|f| apply(f, |f, out| plan.apply(f, out))).collect();
            let narrow = Exponential::<f32>::new(bands, contender.method)?.with_scaled_norm(contender.scaled_norm)?;
            let times = times(&narrow, logs);
            measured.rows.push(measured.row(contender.name, scenes, &norms, &results, truth, Some(times)));
        }
        let plan = Exponential::<f64>::new(bands, ExpMethod::Grid)?;
        let results: Vec<Vec<f64>> = clipped.iter().map(|f| apply(f, |f, out| plan.apply(f, out))).collect();
        measured.rows.push(measured.row("grid, clipped log", scenes, &norms, &results, &[], None));
        Ok(measured)
    }

    fn row(
        &self,
        name: &'static str,
        scenes: &Scenes,
        norms: &[f64],
        results: &[Vec<f64>],
        truth: &[Vec<f64>],
        times: Option<[f64; 2]>,
    ) -> Row {
        let (mut error, mut bins) = (0.0, [0.0; 6]);
        for (k, result) in results.iter().enumerate() {
            let e = relative(result, scenes.visibility(k, self.bands));
            error += e / results.len() as f64;
            bins[bin(norms[k])] += e / self.counts[bin(norms[k])] as f64;
        }
        for (bin, count) in bins.iter_mut().zip(self.counts) {
            *bin = if count == 0 { f64::NAN } else { *bin };
        }
        let sum: f64 = results.iter().zip(truth).map(|(a, b)| relative(a, b)).sum();
        Row { name, error, bins, truth: sum / truth.len() as f64, times }
    }

    pub fn table(&self) -> String {
        let figure = |x: f64| match x {
            _ if x.is_nan() => "-".to_owned(),
            _ if x < 100.0 => format!("{x:.4}"),
            _ => format!("{x:.0e}"),
        };
        let mut header = vec!["method".to_owned(), "all".to_owned()];
        header.extend(BINS.iter().zip(self.counts).map(|(end, count)| format!("< {end} ({count})")));
        header.extend(["to exp f", "ns", "ns in batch"].map(str::to_owned));
        let mut rows = Vec::new();
        for row in &self.rows {
            let mut cells = vec![row.name.to_owned(), figure(row.error)];
            cells.extend(row.bins.map(figure));
            cells.push(figure(row.truth));
            cells.extend(row.times.map_or(["-".to_owned(), "-".to_owned()], |t| t.map(|t| format!("{t:.0}"))));
            rows.push(cells);
        }
        table::format(&header.iter().map(String::as_str).collect::<Vec<_>>(), &rows)
    }

    pub fn report(&self) -> Vec<Value> {
        let row = |row: &Row| {
            let finite = |x: f64| if x.is_finite() { json!(x) } else { Value::Null };
            let mut value = json!({ "bands": self.bands, "method": row.name, "error": row.error,
                "bin_ends": BINS.map(finite), "bin_counts": self.counts, "bin_errors": row.bins.map(finite) });
            if row.truth.is_finite() {
                value["difference_from_projected_exp"] = json!(row.truth);
            }
            if let Some([one, batch]) = row.times {
                value["nanoseconds"] = json!(one);
                value["nanoseconds_in_batch"] = json!(batch);
            }
            value
        };
        self.rows.iter().map(row).collect()
    }
}

/// Where the logarithms of discs come from.
enum Fit {
    Table(CapLog),
    Clipped(Box<Logarithm>),
}

/// The sum of the logarithms of each union's discs.
fn sums(
    bands: usize,
    scenes: &Scenes,
    log: impl Fn(f64, &mut [f64]) -> Result<(), Failure>,
) -> Result<Vec<Vec<f64>>, Failure> {
    let basis = Basis::<f64>::new(bands)?;
    let mut zonal = vec![0.0; bands];
    let mut all = Vec::new();
    for discs in &scenes.discs {
        let mut sum = vec![0.0; bands * bands];
        for disc in discs {
            log(disc.angle, &mut zonal)?;
            sum.iter_mut().zip(turned(&zonal, &disc.axis, &basis)).for_each(|(sum, f)| *sum += f);
        }
        all.push(sum);
    }
    Ok(all)
}

/// The visibilities of each union's discs multiplied, from left to right.
fn products(bands: usize, scenes: &Scenes) -> Result<Vec<Vec<f64>>, Failure> {
    let (basis, product) = (Basis::<f64>::new(bands)?, Product::<f64>::new(bands, bands, bands)?);
    let visibility = |d: &crate::scenes::Disc| turned(&disc(bands, d.angle), &d.axis, &basis);
    let multiply = |a: Vec<f64>, b: Vec<f64>| apply(&a, |a, out| product.apply(a, &b, out));
    let all = scenes.discs.iter().map(|discs| discs.iter().map(visibility).reduce(multiply).unwrap_or_default());
    Ok(all.collect())
}

/// Best of some rounds, nanoseconds a vector: alone, in a batch.
fn times(plan: &Exponential<f32>, logs: &[Vec<f64>]) -> [f64; 2] {
    let size = plan.bands() * plan.bands();
    let vectors: Vec<Vec<f32>> = (0..BATCH).map(|v| logs[v % logs.len()].iter().map(|&x| x as f32).collect()).collect();
    let rows: Vec<f32> = (0..size * BATCH).map(|i| vectors[i % BATCH][i / BATCH]).collect();
    let (mut out, mut all) = (vec![0.0; size], vec![0.0; size * BATCH]);
    let mut scratch = vec![0.0; plan.scratch_len()];
    let rounds = if plan.method() == ExpMethod::Eigen { 1 } else { ROUNDS };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..rounds {
        let start = Instant::now();
        for f in &vectors {
            plan.apply(std::hint::black_box(f), &mut out);
        }
        best[0] = best[0].min(start.elapsed().as_nanos() as f64 / BATCH as f64);
        let start = Instant::now();
        plan.apply_batch(BATCH, std::hint::black_box(&rows), &mut all, &mut scratch);
        best[1] = best[1].min(start.elapsed().as_nanos() as f64 / BATCH as f64);
    }
    best
}

fn apply(f: &[f64], call: impl FnOnce(&[f64], &mut [f64])) -> Vec<f64> {
    let mut out = vec![0.0; f.len()];
    call(f, &mut out);
    out
}

fn bin(x: f64) -> usize {
    BINS.iter().position(|end| x < *end).unwrap_or(BINS.len() - 1)
}

pub fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// ‖got − want‖/‖want‖.
pub fn relative(got: &[f64], want: &[f64]) -> f64 {
    let difference: Vec<f64> = got.iter().zip(want).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(want)
}
