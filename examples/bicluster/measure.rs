//! Biclustering of one mesh's transfer matrix: what it saves, how long it takes.

use haarmonic::compress::{BiclusterSettings, Biclustering, Seeds, SparseMatrix};
use haarmonic::scene::Mesh;
use serde_json::{Value, json};

use crate::args::Args;
use crate::support::Failure;
use crate::support::progress::Bar;
use crate::support::timer::Timer;
use crate::transfer::transfer_matrix;

/// Right-hand sides of the timed products: RGB.
const SIDES: usize = 3;
const ROUNDS: usize = 9;

/// One row of the table.
pub struct Measured {
    pub vertices: usize,
    pub matrix: SparseMatrix,
    pub biclusters: Biclustering,
    pub build_seconds: f64,
    pub search_seconds: f64,
    /// Products with an RGB light, milliseconds: compressed rows, biclusters.
    pub product_ms: [f64; 2],
    /// Largest difference of the two products over the largest number in them.
    pub difference: f64,
}

impl Measured {
    pub const HEADER: [&str; 11] = [
        "vertices",
        "nnz (M)",
        "MFLOP",
        "reduced to",
        "%",
        "MB (CSR)",
        "reduced to",
        "%",
        "search s",
        "ms (CSR)",
        "ms (biclusters)",
    ];

    pub fn new(mesh: &Mesh, args: &Args) -> Result<Self, Failure> {
        let bar = Bar::new("visibility");
        let matrix = transfer_matrix(mesh, &bar)?;
        let build_seconds = bar.finish();
        let seeds = args.seed.map_or(Seeds::First, Seeds::Random);
        let settings = BiclusterSettings::default().with_group_rows(args.group_rows).with_seeds(seeds);
        let bar = Bar::new("biclusters");
        let biclusters = Biclustering::new(&matrix, &settings, &bar)?;
        let search_seconds = bar.finish();
        if biclusters.to_matrix() != matrix {
            return Err("the biclusters do not add up to the matrix".into());
        }
        let (product_ms, difference) = products(&matrix, &biclusters);
        let vertices = mesh.positions().len();
        Ok(Self { vertices, matrix, biclusters, build_seconds, search_seconds, product_ms, difference })
    }

    /// Shares of the matrix's operations and bytes, percent.
    pub fn percent(&self) -> [f64; 2] {
        let stats = self.biclusters.stats();
        let share = |a: usize, b: usize| 100.0 * a as f64 / b.max(1) as f64;
        [share(stats.flops, stats.matrix_flops), share(stats.bytes, stats.matrix_bytes)]
    }

    pub fn cells(&self) -> Vec<String> {
        let stats = self.biclusters.stats();
        let mega = |n: usize| format!("{:.2}", n as f64 / 1e6);
        let [flops, bytes] = self.percent().map(|p| format!("{p:.1}"));
        let [rows, biclusters] = self.product_ms.map(|ms| format!("{ms:.2}"));
        vec![
            self.vertices.to_string(),
            mega(self.matrix.nnz()),
            mega(stats.matrix_flops),
            mega(stats.flops),
            flops,
            mega(stats.matrix_bytes),
            mega(stats.bytes),
            bytes,
            format!("{:.2}", self.search_seconds),
            rows,
            biclusters,
        ]
    }

    pub fn report(&self) -> Value {
        let stats = self.biclusters.stats();
        json!({
            "method": "bicluster",
            "vertices": self.vertices,
            "rows": self.matrix.rows(),
            "columns": self.matrix.columns(),
            "nnz": self.matrix.nnz(),
            "biclusters": stats.biclusters,
            "flops": stats.flops,
            "matrix_flops": stats.matrix_flops,
            "bytes": stats.bytes,
            "matrix_bytes": stats.matrix_bytes,
            "exact": true,
            "matrix_s": self.build_seconds,
            "search_s": self.search_seconds,
            "product_rgb_ms": self.product_ms[1],
            "matrix_product_rgb_ms": self.product_ms[0],
            "product_difference": self.difference,
        })
    }
}

/// Medians of some rounds, and the difference.
fn products(matrix: &SparseMatrix, biclusters: &Biclustering) -> ([f64; 2], f64) {
    // A light without a pattern.
    let x: Vec<f32> = (0..matrix.columns() * SIDES).map(|i| (i as f32 * 0.618_034).fract()).collect();
    let multiplier = biclusters.multiplier::<f32>();
    let mut scratch = vec![0.0; multiplier.scratch_len(SIDES)];
    let mut out = [vec![0.0f32; matrix.rows() * SIDES], vec![0.0f32; matrix.rows() * SIDES]];
    let [mut plain, mut biclustered] = [Timer::default(), Timer::default()];
    for _ in 0..ROUNDS {
        plain.time(|| matrix.multiply_batch(SIDES, &x, &mut out[0]));
        biclustered.time(|| multiplier.multiply_batch(SIDES, &x, &mut out[1], &mut scratch));
    }
    let largest = out[0].iter().fold(0.0f32, |m, x| m.max(x.abs()));
    let difference = out[0].iter().zip(&out[1]).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
    ([plain, biclustered].map(|timer| timer.median()), f64::from(difference / largest.max(f32::MIN_POSITIVE)))
}
