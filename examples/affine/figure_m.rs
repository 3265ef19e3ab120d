//! The canonical coupling M(r, c) as a map and in cuts along both axes [Sun 2008, fig. 4.5].

use haarmonic::affine::{Mother, canonical};

use crate::support::axis::{Axis, Scale, number};
use crate::support::plot::{self, Chart, Series};
use crate::support::sheet::{ColourBar, INK, PAPER, Sheet};
use crate::support::text::Type;

const SIZE: [usize; 2] = [760, 560];

fn m(r: f64, c: f64) -> f64 {
    canonical(Mother::Wavelet, Mother::Wavelet, r, c)
}

/// The map, both cuts, and what they show.
pub fn draw() -> Sheet {
    let chart = |title: &str, x: Axis, y: Axis, series| Chart { title: title.to_owned(), x, y, series, size: SIZE };
    let [r, c] = [
        Axis::between("half the width: radius r", Scale::Linear, 0.0, 1.5),
        Axis::between("centre c", Scale::Linear, -1.0, 2.0),
    ];
    let map = chart("M(r, c)", c, r, Vec::new()).draw_over(Some(&|c, r| {
        let value = m(r, c);
        let inside = (c - 0.5).abs() < r + 0.5;
        if inside && value.abs() < 0.004 { INK } else { diverging(value) }
    }));
    let ticks = [-0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0].map(|m: f64| ((m as f32 + 0.5) / 1.5, number(m)));
    let bar = ColourBar {
        label: "M; black: zero although the supports overlap",
        ticks: &ticks,
        colour: &|share| diverging(f64::from(share) * 1.5 - 0.5),
    };
    let bar = bar.draw([SIZE[0], 150], Type::new(20.0), [INK, PAPER]);
    let steps = |low: f64, high: f64| (0..=1200).map(move |k| low + (high - low) * f64::from(k) / 1200.0);
    let over_c = |(k, r): (usize, f64)| {
        Series::curve(&format!("r = {r}"), k, steps(-1.0, 2.0).map(|c| [c - 0.5, m(r, c)]).collect())
    };
    // The last two lie on each other where they rise and fall.
    let under = |mut s: Series| {
        s.look = if s.label == "r = 1" { s.look.wider(2.5) } else { s.look };
        s
    };
    let over_r = |(k, c): (usize, f64)| {
        Series::curve(&format!("c − 1/2 = {}", c - 0.5), k, steps(0.0, 2.0).map(|r| [r, m(r, c)]).collect())
    };
    let cuts_c = [0.125, 0.25, 0.375, 0.5, 1.0, 1.5].into_iter().enumerate().map(over_c).map(under).collect();
    let cuts_r = [0.5, 0.625, 0.75, 0.875, 1.0, 1.25].into_iter().enumerate().map(over_r).collect();
    let notes = [
        "M(r, c) = ∫ ψ((u − c)/2r + 1/2) ψ(u) du",
        "             = 2 L(c) − L(c − r) − L(c + r),   r > 0,",
        "     L(x) = max(0, 1/2 − |x − 1/2|)",
        "",
        "zero: outside |c − 1/2| < r + 1/2, and wherever one",
        "wavelet lies in a constant piece of the other (black)",
        "slopes: in c 0, 1, 2, 3 up or down; in r −1, 0, 1, 2",
        "bounds: −min(r, 1/2) ≤ M ≤ 2 min(r, 1/2)",
        "symmetry: M(r, 1/2 + c) = M(r, 1/2 − c),",
        "     M(r, c) = 2r M(1/4r, 1/2 + 1/4r − c/2r)",
        "",
        "r: half the width of the transformed wavelet,",
        "c: its centre, in cells of the other wavelet",
    ];
    let mut text = vec![String::new(); 2];
    text.extend(notes.map(str::to_owned));
    let y = || Axis::between("M", Scale::Linear, -0.6, 1.1);
    let over_c = chart("M over c", Axis::between("c − 1/2", Scale::Linear, -1.5, 1.5), y(), cuts_c);
    let over_r = chart("M over r", Axis::between("r", Scale::Linear, 0.0, 2.0), y(), cuts_r);
    let rows = [
        vec![Sheet::grid(&[vec![map], vec![bar]], PAPER), plot::text(&text, [SIZE[0], SIZE[1] + 150])],
        vec![over_c.draw(), over_r.draw()],
        vec![plot::legend(&over_c.series, 3, SIZE[0]), plot::legend(&over_r.series, 3, SIZE[0])],
    ];
    Sheet::grid(&rows, PAPER)
}

/// Blue at −½, white at 0, red at 1.
fn diverging(value: f64) -> [u8; 3] {
    let mix = |to: [f64; 3], t: f64| to.map(|c| (255.0 + (c - 255.0) * t.clamp(0.0, 1.0)).round() as u8);
    if value < 0.0 { mix([33.0, 102.0, 172.0], -2.0 * value) } else { mix([178.0, 24.0, 43.0], value) }
}
