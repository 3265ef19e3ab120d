//! Error against ‖f̂‖, error against time.

use crate::measure::Measured;
use crate::support::axis::{Axis, Scale};
use crate::support::plot::{self, Chart, LOOKS, Look, Series};
use crate::support::sheet::{PAPER, Sheet};

/// What is drawn, in which look and by how much wider than usual: of what lies on the same line all is seen, like a
/// flag.
const DRAWN: [(&str, usize, f64); 7] = [
    ("OL", 1, 7.0),
    ("HYB", 2, 5.5),
    ("PS*-2", 0, 4.0),
    ("PS-9", 5, 2.8),
    ("grid", 4, 1.6),
    ("grid, fitted discs", 3, 0.4),
    ("products", 6, -0.9),
];
const SIZE: [usize; 2] = [760, 580];

/// Error against ‖f̂‖, a chart for each number of bands.
pub fn errors(measured: &[Measured]) -> Sheet {
    let chart = |m: &Measured| {
        let series = DRAWN.iter().filter_map(|&(name, look, wider)| {
            let row = m.rows.iter().find(|row| row.name == name)?;
            let points = m.norms.iter().zip(row.bins).filter(|(_, error)| error.is_finite());
            let line = Series::new(name, look, points.map(|(&x, error)| [x, error]).collect());
            Some(Series { look: LOOKS[look].wider(wider), ..line })
        });
        Chart {
            title: format!("{} bands", m.bands),
            x: Axis::between("norm of the logarithm without its mean, ‖f̂‖", Scale::Log2, 0.2, 14.0),
            y: Axis::between("mean relative L² error of visibility", Scale::Log10, 4e-4, 2.0),
            series: series.collect(),
            size: SIZE,
        }
    };
    let charts: Vec<Chart> = measured.iter().map(chart).collect();
    let mut sheets: Vec<Sheet> = charts.iter().map(Chart::draw).collect();
    sheets.push(plot::legend(charts.iter().take(1).flat_map(|c| &c.series), 1, SIZE[0]));
    in_rows(sheets)
}

/// Error against time, a chart for each number of bands.
pub fn times(measured: &[Measured]) -> Sheet {
    let chart = |m: &Measured| {
        let mut series = Vec::new();
        for (name, look, wider) in DRAWN {
            let found = m.rows.iter().find(|row| row.name == name).and_then(|row| Some((row, row.times?)));
            if let Some((row, [_, batch])) = found {
                let point = Series::points(name, look, vec![[batch, row.error.min(1.0)]]);
                let look = Look { width: 0.0, ..point.look.wider(0.6 * wider) };
                series.push(Series { look, ..point }.with_notes([format!("{name}: {batch:.0} ns")]));
            }
        }
        let times = || series.iter().map(|s| s.points[0][0]);
        let [fastest, slowest] = [times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max)];
        Chart {
            title: format!("{} bands", m.bands),
            x: Axis::between(
                "ns for a vector, f32, batch of 256, one thread",
                Scale::Log10,
                fastest / 1.7,
                slowest * 1.7,
            ),
            y: Axis::between("mean relative L² error, at most 1", Scale::Log10, 0.02, 1.5),
            series,
            size: SIZE,
        }
        .draw()
    };
    in_rows(measured.iter().map(chart).collect())
}

fn in_rows(sheets: Vec<Sheet>) -> Sheet {
    let rows: Vec<Vec<Sheet>> = sheets.chunks(2).map(<[Sheet]>::to_vec).collect();
    Sheet::grid(&rows, PAPER)
}
