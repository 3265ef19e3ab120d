//! Error against ‖f̂‖, error against time.

use crate::measure::Measured;
use crate::support::plot::{self, Axis, COLOURS, Chart, Legend, Scale, Series};
use crate::support::sheet::Sheet;

/// What is drawn, and in which colour and width: what lies on the same line is drawn the thinner the later.
const DRAWN: [(&str, usize, f64); 7] = [
    ("products", 6, 2.0),
    ("OL", 1, 2.0),
    ("PS-9", 5, 2.0),
    ("HYB", 2, 5.0),
    ("PS*-2", 0, 2.0),
    ("grid", 4, 2.0),
    ("grid, fitted discs", 3, 2.0),
];

/// Error against ‖f̂‖, a chart for each number of bands.
pub fn errors(measured: &[Measured]) -> Sheet {
    let chart = |m: &Measured| {
        let series = DRAWN.iter().filter_map(|(name, colour, width)| {
            let row = m.rows.iter().find(|row| row.name == *name)?;
            let points = m.norms.iter().zip(row.bins).filter(|(_, error)| error.is_finite());
            let line = Series::dotted(name, COLOURS[*colour], points.map(|(&x, error)| [x, error]).collect());
            Some(Series { width: *width, ..line })
        });
        Chart {
            title: format!("{} bands", m.bands),
            x: Axis::between("|f^|", Scale::Log2, 0.125, 16.0),
            y: Axis::between("mean relative L2 error of the visibility", Scale::Log10, 1e-3, 10.0),
            series: series.collect(),
            legend: Legend::TopLeft,
            caption: Vec::new(),
            size: [560, 420],
        }
        .draw()
    };
    in_rows(measured, chart)
}

/// Error against time, a chart for each number of bands.
pub fn times(measured: &[Measured]) -> Sheet {
    let chart = |m: &Measured| {
        let mut series = Vec::new();
        for (name, colour, _) in DRAWN {
            let found = m.rows.iter().find(|row| row.name == name).and_then(|row| Some((row, row.times?)));
            if let Some((row, [_, batch])) = found {
                let label = format!("{name} ({batch:.0} ns)");
                let dot = Series::dotted(&label, COLOURS[colour], vec![[batch, row.error.min(1.0)]]);
                series.push(Series { width: 0.0, dots: 11.0, ..dot });
            }
        }
        Chart {
            title: format!("{} bands", m.bands),
            x: Axis::new("ns a vector, f32, batch of 256, one thread", Scale::Log10),
            y: Axis::between("mean relative L2 error of the visibility, at most 1", Scale::Log10, 1e-2, 1.0),
            series,
            legend: Legend::Right,
            caption: Vec::new(),
            size: [640, 420],
        }
        .draw()
    };
    in_rows(measured, chart)
}

fn in_rows(measured: &[Measured], chart: impl Fn(&Measured) -> Sheet) -> Sheet {
    let sheets: Vec<Vec<Sheet>> = measured.chunks(2).map(|pair| pair.iter().map(&chart).collect()).collect();
    plot::grid(&sheets)
}
