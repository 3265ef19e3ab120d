//! Every way of storing the maps, and what each costs and loses.

use haarmonic::Progress;
use haarmonic::compress::{ClusteredPcaSettings, Distortion};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::rel_l2;
use serde_json::{Value, json};

use crate::maps::Maps;
use crate::stored::{Format, Stored, components_of_equal_size};
use crate::support::Failure;
use crate::support::progress::Bar;
use crate::support::timer::seconds;

/// Components of the whole matrix that are tried.
pub const WHOLE: [usize; 5] = [8, 16, 32, 64, 128];
/// Numbers of clusters that are tried; at most 256, so that a label fits a byte.
pub const CLUSTERS: [usize; 3] = [4, 16, 64];

/// One row of the table.
pub struct Measured {
    /// Components of the whole matrix that take as much.
    pub whole: usize,
    /// As asked for; 1: principal components of the whole matrix.
    pub clusters: usize,
    pub stored: Stored,
    pub seconds: f64,
    /// In each format.
    pub formats: [Figures; 3],
    /// Products with the light without decoding against those of the decoded rows: largest difference over the largest
    /// number.
    pub difference: Option<f64>,
}

/// What a format takes and loses.
#[derive(Clone, Copy)]
pub struct Figures {
    /// Bytes of the maps in `f32` for each that is stored.
    pub ratio: f64,
    /// Of the maps: √(Σ difference² / Σ map²).
    pub error: f64,
    /// The same of the relit values.
    pub relit: f64,
}

impl Measured {
    pub const HEADER: [&str; 12] = [
        "stored as",
        "weights a row",
        "seconds",
        "f32: ratio",
        "error %",
        "relit %",
        "f16: ratio",
        "error %",
        "relit %",
        "8 bit: ratio",
        "error %",
        "relit %",
    ];

    fn new(maps: &Maps, truth: &[Vector3<f64>], [whole, clusters, k]: [usize; 3], seed: u64) -> Result<Self, Failure> {
        let (coded, seconds) = seconds(|| -> haarmonic::Result<_> {
            if clusters == 1 {
                return Ok((Stored::pca(&maps.matrix, maps.columns(), k, seed)?, None));
            }
            let settings = ClusteredPcaSettings::new(clusters, k).with_seed(seed);
            let (stored, coded) = Stored::clustered(&maps.matrix, maps.columns(), &settings)?;
            Ok((stored, Some(coded)))
        });
        let (stored, coded) = coded?;
        let mut difference = None;
        let mut formats = Vec::new();
        for format in Format::ALL {
            let (matrix, bytes) = stored.decode(format)?;
            let relit = maps.relit(&matrix);
            if let (Format::Single, Some(coded)) = (format, &coded) {
                let mut products = vec![0.0f32; 3 * maps.vertices()];
                coded.multiply_batch(3, &maps.sides(), &mut products, &mut vec![0.0; coded.scratch_len(3)]);
                let decoded = || relit.iter().flat_map(|x| x.iter().copied());
                let largest = decoded().fold(f64::MIN_POSITIVE, |max, x| max.max(x.abs()));
                let off = decoded().zip(&products).fold(0.0f64, |max, (x, &y)| max.max((x - f64::from(y)).abs()));
                difference = Some(off / largest);
            }
            formats.push(Figures {
                ratio: size_of_val(&maps.matrix[..]) as f64 / bytes as f64,
                error: Distortion::between(&maps.matrix, &matrix).relative,
                relit: rel_l2(truth, &relit)?,
            });
        }
        let formats = formats.try_into().map_err(|_| "a format is missing")?;
        Ok(Self { whole, clusters, stored, seconds, formats, difference })
    }

    pub fn name(&self) -> String {
        match (self.clusters, self.stored.clusters(), self.stored.components()) {
            (1, _, k) => format!("PCA, {k}"),
            (_, clusters, k) => format!("clustered PCA, {clusters} x {k}"),
        }
    }

    pub fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.name(), self.stored.components().to_string(), format!("{:.2}", self.seconds)];
        for f in &self.formats {
            cells.push(format!("{:.1}", f.ratio));
            cells.extend([f.error, f.relit].map(|e| format!("{:.2}", 100.0 * e)));
        }
        cells
    }

    pub fn report(&self) -> impl Iterator<Item = Value> {
        Format::ALL.iter().zip(&self.formats).map(|(format, f)| {
            json!({
                "method": if self.clusters == 1 { "pca" } else { "clustered_pca" },
                "clusters": self.stored.clusters(),
                "components": self.stored.components(),
                "format": format.name(),
                "encode_s": self.seconds,
                "ratio": f.ratio,
                "relative_error": f.error,
                "relit_relative_error": f.relit,
                "product_difference": self.difference,
            })
        })
    }
}

/// Principal components of the whole matrix, each number of them followed by clusters that take about as much.
pub fn all(maps: &Maps, seed: u64) -> Result<Vec<Measured>, Failure> {
    let truth = maps.relit(&maps.matrix);
    let mut plan = Vec::new();
    for whole in WHOLE {
        plan.push([whole, 1, whole]);
        for clusters in CLUSTERS {
            let k = components_of_equal_size(maps.vertices(), maps.columns(), clusters, whole);
            if k > 0 {
                plan.push([whole, clusters, k]);
            }
        }
    }
    let bar = Bar::new("components");
    let mut measured = Vec::new();
    for &way in &plan {
        measured.push(Measured::new(maps, &truth, way, seed)?);
        bar.advance(measured.len(), plan.len());
    }
    bar.finish();
    Ok(measured)
}
