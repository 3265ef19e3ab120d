//! Pictures: a piece of the matrix and its biclusters, and the costs against the vertices.

use haarmonic::compress::{Biclustering, SparseMatrix};

use crate::measure::Measured;
use crate::support::axis::{Axis, Scale};
use crate::support::plot::{self, Chart, LOOKS, Series};
use crate::support::sheet::{PAPER, Panel, Sheet};

/// Entries of a panel along rows and columns, and pixels of an entry.
const ROWS: usize = 190;
const COLUMNS: usize = 130;
const PIXELS: usize = 3;
/// Of a chart.
const SIZE: [usize; 2] = [760, 580];
const BACK: [u8; 3] = [12, 12, 14];
const DIM: [u8; 3] = [70, 72, 78];

/// Rows of the matrix that share a column, and the columns that they use most: in their own order, with rows and
/// columns of a bicluster side by side, and coloured by bicluster.
pub fn matrix(measured: &Measured) -> Sheet {
    let (matrix, biclusters) = (&measured.matrix, &measured.biclusters);
    let window = Window::new(matrix, biclusters);
    let mut sorted = window.clone();
    sorted.sort();
    let panel = |caption: [&str; 2], pixels| {
        Some(Panel {
            caption: caption.map(str::to_owned).to_vec(),
            width: COLUMNS * PIXELS,
            height: ROWS * PIXELS,
            pixels,
        })
    };
    let row = vec![
        panel(["visibility, in the matrix's own order", "brighter = more visible"], window.levels(matrix)),
        panel(["the same, reordered by biclusters", ""], sorted.levels(matrix)),
        panel(["a colour for each bicluster", "grey: of one row; white: two or more"], sorted.members()),
    ];
    Sheet::new(
        "A piece of the transfer matrix: rows = (vertex, local direction), columns = texels of the light",
        &[row],
    )
}

/// Rows and columns to show, and the biclusters that meet them.
#[derive(Clone)]
struct Window {
    rows: Vec<u32>,
    columns: Vec<u32>,
    /// (rows, columns) of each, the one that covers most of the window first.
    biclusters: Vec<(Vec<u32>, Vec<u32>)>,
}

impl Window {
    fn new(matrix: &SparseMatrix, all: &Biclustering) -> Self {
        // The column in most biclusters of several rows: where there is most to see.
        let mut met = vec![0; matrix.columns()];
        all.iter().filter(|b| b.rows.len() > 1).for_each(|b| b.columns.iter().for_each(|&k| met[k as usize] += 1));
        let busiest = (0..matrix.columns()).max_by_key(|&k| met[k]).unwrap_or(0);
        let using: Vec<u32> =
            (0..matrix.rows()).filter(|&row| matrix.level(row, busiest) != 0).map(|row| row as u32).collect();
        let shown = ROWS.min(using.len());
        let rows: Vec<u32> = (0..shown).map(|i| using[i * using.len() / shown]).collect();
        let mut counts = vec![0; matrix.columns()];
        rows.iter().for_each(|&row| matrix.row(row as usize).0.iter().for_each(|&c| counts[c as usize] += 1));
        let columns = most(counts.into_iter().zip(0..), COLUMNS);
        let inside = |all: &[u32], some: &[u32]| -> Vec<u32> {
            some.iter().copied().filter(|i| all.binary_search(i).is_ok()).collect()
        };
        let mut biclusters: Vec<_> = all.iter().map(|b| (inside(&rows, b.rows), inside(&columns, b.columns))).collect();
        biclusters.retain(|(rows, columns)| !rows.is_empty() && !columns.is_empty());
        biclusters.sort_by_key(|(rows, columns)| std::cmp::Reverse(rows.len() * columns.len()));
        Self { rows, columns, biclusters }
    }

    /// Puts rows of one bicluster together, and columns.
    fn sort(&mut self) {
        let first = |lists: Vec<&Vec<u32>>, item: u32| {
            let at = lists.iter().position(|list| list.contains(&item)).unwrap_or(lists.len());
            let second = lists.iter().skip(at + 1).position(|list| list.contains(&item)).unwrap_or(lists.len());
            (at, second)
        };
        let biclusters = &self.biclusters;
        self.rows.sort_by_cached_key(|&row| first(biclusters.iter().map(|b| &b.0).collect(), row));
        self.columns.sort_by_cached_key(|&column| first(biclusters.iter().map(|b| &b.1).collect(), column));
    }

    fn levels(&self, matrix: &SparseMatrix) -> Vec<[u8; 3]> {
        self.paint(|row, column| {
            let share = f64::from(matrix.level(row as usize, column as usize)) * matrix.scale();
            if share > 0.0 { [(60.0 + 195.0 * share) as u8; 3] } else { BACK }
        })
    }

    fn members(&self) -> Vec<[u8; 3]> {
        self.paint(|row, column| {
            let covers = |b: &&(Vec<u32>, Vec<u32>)| b.0.contains(&row) && b.1.contains(&column);
            let mut covering = self.biclusters.iter().enumerate().filter(|(_, b)| covers(b));
            match (covering.next(), covering.next()) {
                (None, _) => BACK,
                (Some(_), Some(_)) => [255; 3],
                (Some((_, b)), None) if b.0.len() == 1 => DIM,
                (Some((i, _)), None) => hue(i),
            }
        })
    }

    fn paint(&self, colour: impl Fn(u32, u32) -> [u8; 3]) -> Vec<[u8; 3]> {
        let width = COLUMNS * PIXELS;
        let mut pixels = vec![BACK; width * ROWS * PIXELS];
        for (y, &row) in self.rows.iter().enumerate() {
            for (x, &column) in self.columns.iter().enumerate() {
                let colour = colour(row, column);
                for dy in 0..PIXELS {
                    pixels[(y * PIXELS + dy) * width + x * PIXELS..][..PIXELS].fill(colour);
                }
            }
        }
        pixels
    }
}

/// The `count` items with the largest counts (of equals the first), ascending.
fn most(items: impl Iterator<Item = (usize, u32)>, count: usize) -> Vec<u32> {
    let mut items: Vec<_> = items.filter(|item| item.0 > 0).collect();
    items.sort_by_key(|item| std::cmp::Reverse(item.0));
    let mut items: Vec<u32> = items.into_iter().take(count).map(|item| item.1).collect();
    items.sort_unstable();
    items
}

/// The colours of charts in turn; the second and third time around lighter and darker.
fn hue(index: usize) -> [u8; 3] {
    let colours = LOOKS.len() - 1; // grey is taken
    let towards = [None, Some(255.0), Some(0.0)][index / colours % 3];
    let mix = |c: u8| towards.map_or(c, |end| (0.6 * f64::from(c) + 0.4 * end) as u8);
    LOOKS[index % colours].colour.map(mix)
}

/// Time and shares against the vertices.
pub fn scaling(all: &[Measured], name: &str) -> Sheet {
    let points = |f: &dyn Fn(&Measured) -> f64| all.iter().map(|m| [m.vertices as f64, f(m)]).collect::<Vec<_>>();
    let last = all.last().expect("at least one size");
    let law = points(&|m| last.search_seconds * m.vertices as f64 / last.vertices as f64);
    let search = points(&|m| m.search_seconds);
    let notes = search.iter().map(|p| format!("{:.2} s", p[1])).collect::<Vec<_>>();
    let [few, many] = [all[0].vertices as f64 / 1.3, last.vertices as f64 * 1.3];
    let times = Chart {
        title: format!("Search, {name}"),
        x: Axis::between("vertices", Scale::Log10, few, many),
        y: Axis::new("time of the search, s", Scale::Log10),
        series: vec![
            Series::law("linear in the vertices", [16, 8], law),
            Series::new("measured", 0, search).with_notes(notes),
        ],
        size: SIZE,
    };
    let share = |k: usize, name: &str, f: &dyn Fn(&Measured) -> f64| {
        let points = points(f);
        let notes = points.iter().map(|p| format!("{:.1} %", p[1])).collect::<Vec<_>>();
        Series::new(name, k, points).with_notes(notes)
    };
    let time = |m: &Measured| 100.0 * m.product_ms[1] / m.product_ms[0];
    let slowest = all.iter().map(time).fold(30.0, f64::max);
    let shares = Chart {
        title: "Cost of a product".to_owned(),
        y: Axis::between("% of the sparse matrix's cost", Scale::Linear, 0.0, 1.15 * slowest),
        series: vec![
            share(0, "operations", &|m| m.percent()[0]),
            share(1, "bytes", &|m| m.percent()[1]),
            share(2, "time (RGB)", &time),
        ],
        ..times.clone()
    };
    let legend = |chart: &Chart, columns| plot::legend(&chart.series, columns, SIZE[0]);
    Sheet::grid(&[vec![times.draw(), shares.draw()], vec![legend(&times, 2), legend(&shares, 3)]], PAPER)
}
