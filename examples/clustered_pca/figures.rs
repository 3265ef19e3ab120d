//! Pictures: maps before and after, and errors against storage.

use haarmonic::compress::Distortion;
use haarmonic::scene::linear_to_srgb;
use haarmonic::sphere::{CubeGrid, Face};

use crate::maps::Maps;
use crate::measure::{CLUSTERS, Figures, Measured};
use crate::stored::Format;
use crate::support::Failure;
use crate::support::axis::{Axis, Scale, number};
use crate::support::plot::{self, Chart, LOOKS, Look, Series};
use crate::support::sheet::{BRIGHT, ColourBar, DARK, PAPER, Panel, Sheet, heat};
use crate::support::text::Type;

/// Pixels of a texel.
const PIXELS: usize = 4;
/// Difference of maps that is drawn in white.
const WHITE: f32 = 0.5;
/// Where a vertex stands among all by the error of its map.
const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 0.95];

/// Maps of some vertices: as they are, and by principal components in one piece and clustered, at equal storage.
pub fn maps(maps: &Maps, [whole, clustered]: [&Measured; 2]) -> Result<Sheet, Failure> {
    let decoded = [whole.stored.decode(Format::Single)?.0, clustered.stored.decode(Format::Single)?.0];
    let row = |matrix: &'_ [f32], vertex: usize| matrix[vertex * maps.columns()..][..maps.columns()].to_vec();
    let error = |way: usize, vertex| Distortion::between(maps.map(vertex), &row(&decoded[way], vertex)).relative;
    let mut order: Vec<usize> = (0..maps.vertices()).collect();
    order.sort_by_cached_key(|&v| (error(0, v) + error(1, v)).to_bits()); // ordered as numbers >= 0
    let mut rows = Vec::new();
    for share in SHARES {
        let vertex = order[(share * (order.len() - 1) as f64) as usize];
        let original = maps.map(vertex);
        let caption = [format!("vertex {vertex}"), format!("{:.0} % have less error", 100.0 * share)];
        let mut panels = vec![cross(maps.grid, caption, |i| grey(original[i]))];
        for (way, measured) in [whole, clustered].into_iter().enumerate() {
            let left = row(&decoded[way], vertex);
            let ratio = format!("ratio {:.0}", measured.formats[0].ratio);
            panels.push(cross(maps.grid, [measured.name(), ratio], |i| grey(left[i])));
            let off = format!("error {:.1} %", 100.0 * error(way, vertex));
            let caption = [off, "difference".to_owned()];
            panels.push(cross(maps.grid, caption, |i| heat((left[i] - original[i]).abs() / WHITE)));
        }
        rows.push(panels);
    }
    let sheet = Sheet::new(
        "Visibility × cosine on a cube, unfolded: +y on top, then −x +z +x −z, −y below; what is negative is black",
        &rows,
    );
    let ticks = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5].map(|x: f32| {
        let more = if x < WHITE { "" } else { "≥ " };
        (x / WHITE, more.to_owned() + &number(f64::from(x)))
    });
    let bar = ColourBar { label: "|difference| of visibility × cosine", ticks: &ticks, colour: &heat };
    let bar = bar.draw([sheet.width / 2, 150], Type::new(20.0), [BRIGHT, DARK]);
    Ok(Sheet::grid(&[vec![sheet], vec![bar]], DARK))
}

fn grey(x: f32) -> [u8; 3] {
    [(linear_to_srgb(x.clamp(0.0, 1.0)) * 255.0).round() as u8; 3]
}

/// A cube unfolded, so that neighbours in the picture are neighbours on the cube.
fn cross(grid: CubeGrid, caption: [String; 2], colour: impl Fn(usize) -> [u8; 3]) -> Option<Panel> {
    const PLACES: [(Face, [usize; 2]); 6] = [
        (Face::PosY, [1, 0]),
        (Face::NegX, [0, 1]),
        (Face::PosZ, [1, 1]),
        (Face::PosX, [2, 1]),
        (Face::NegZ, [3, 1]),
        (Face::NegY, [1, 2]),
    ];
    let side = grid.side();
    let [width, height] = [4, 3].map(|faces| faces * side * PIXELS);
    let mut pixels = vec![DARK; width * height];
    for (face, [column, row]) in PLACES {
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let colour = colour(grid.index(face, x, y));
            let [left, top] = [column * side + x, row * side + y].map(|c| c * PIXELS);
            for dy in 0..PIXELS {
                pixels[(top + dy) * width + left..][..PIXELS].fill(colour);
            }
        }
    }
    Some(Panel { caption: caption.to_vec(), width, height, pixels })
}

/// Errors of maps and of relit values against storage, and against what a row costs under a new light.
pub fn errors(all: &[Measured]) -> Sheet {
    let lines = |point: &dyn Fn(&Measured, &Figures) -> [f64; 2], formats: &[(usize, [i32; 2])]| {
        let mut series = Vec::new();
        for &(format, dashes) in formats {
            for (k, clusters) in [1].into_iter().chain(CLUSTERS).enumerate() {
                let points = all.iter().filter(|m| m.clusters == clusters).map(|m| point(m, &m.formats[format]));
                let name = if clusters == 1 { "PCA".to_owned() } else { format!("{clusters} clusters") };
                let line = Series::new(&format!("{name}, {}", Format::ALL[format].name()), k, points.collect());
                series.push(Series { look: Look { dashes, ..LOOKS[k].wider(if k == 0 { 2.0 } else { 0.0 }) }, ..line });
            }
        }
        series
    };
    let both = [(0, [0, 0]), (2, [7, 7])];
    let largest = |of: &dyn Fn(&Figures) -> f64| all.iter().flat_map(|m| &m.formats).map(of).fold(0.01, f64::max);
    let percent = |label: &str, largest: f64| Axis::between(label, Scale::Linear, 0.0, 106.0 * largest);
    let maps = Chart {
        title: "Maps".to_owned(),
        x: Axis::new("ratio: bytes of the maps in f32 / bytes stored", Scale::Log10),
        y: percent("relative L² error of the maps, %", largest(&|f| f.error)),
        series: lines(&|_, f| [f.ratio, 100.0 * f.error], &both),
        size: [760, 600],
    };
    let relit = Chart {
        title: "Relit values".to_owned(),
        y: percent("relative L² error of the relit values, %", largest(&|f| f.relit)),
        series: lines(&|_, f| [f.ratio, 100.0 * f.relit], &both),
        ..maps.clone()
    };
    let cost = Chart {
        title: "Maps, by the work for a row under a new light".to_owned(),
        x: Axis::new("weights of a row", Scale::Log2),
        series: lines(&|m, f| [m.stored.components() as f64, 100.0 * f.error], &both[..1]),
        ..maps.clone()
    };
    let legend = plot::legend(&maps.series, 2, 760);
    Sheet::grid(&[vec![maps.draw(), relit.draw()], vec![cost.draw(), legend]], PAPER)
}
