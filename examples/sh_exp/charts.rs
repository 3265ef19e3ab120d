//! Error against ‖f̂‖, error against time.

use crate::measure::Measured;
use crate::support::plot::{self, Axis, COLOURS, Chart, Legend, Scale, Series};
use crate::support::sheet::Sheet;

/// What is drawn, and in which colour.
const DRAWN: [(&str, usize); 7] =
    [("products", 6), ("PS-9", 5), ("PS*-2", 0), ("HYB", 2), ("OL", 1), ("grid", 4), ("grid, fitted discs", 3)];

/// Error against ‖f̂‖, a chart for each number of bands.
pub fn errors(measured: &[Measured]) -> Sheet {
    let chart = |m: &Measured| {
        let series = DRAWN.iter().filter_map(|(name, colour)| {
            let row = m.rows.iter().find(|row| row.name == *name)?;
            let points = m.norms.iter().zip(row.bins).filter(|(_, error)| error.is_finite());
            Some(Series::dotted(name, COLOURS[*colour], points.map(|(&x, error)| [x, error]).collect()))
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
        for (k, row) in m.rows.iter().enumerate() {
            let Some([_, batch]) = row.times else { continue };
            if row.error < 1.0 {
                let label = format!("{} ({batch:.0} ns)", row.name);
                series.push(Series {
                    width: 0.0,
                    dots: 9.0,
                    ..Series::dotted(&label, COLOURS[k % 7], vec![[batch, row.error]])
                });
            }
        }
        Chart {
            title: format!("{} bands", m.bands),
            x: Axis::new("ns a vector, f32, batch of 256, one thread", Scale::Log10),
            y: Axis::between("mean relative L2 error of the visibility", Scale::Log10, 1e-2, 1.0),
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
