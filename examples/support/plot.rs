//! Charts by plotters, all in one look: series that differ in colour, marker and dashes, numbers on every axis, legends
//! that are pictures of their own and so cover nothing.

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::axis::{Axis, Ruler, number};
use super::canvas::{Canvas, FINE, shrink};
use super::notes;
use super::sheet::{Align, INK, PAPER, Sheet};
use super::text::Type;

const TEXT: f32 = 20.0;
const TITLE: f32 = 23.0;
const MESH: RGBColor = RGBColor(206, 209, 216);
const FAINT: RGBColor = RGBColor(236, 238, 242);

type Area<'a> = DrawingArea<Canvas<'a>, Shift>;
type Plane = Cartesian2d<Ruler, Ruler>;

/// What stands at the points of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    None,
    Disc,
    Square,
    Up,
    Diamond,
    Down,
    Ring,
    Cross,
}

/// How a series is drawn: colour, marker, width of the line, lengths of dashes and gaps (no gaps: a full line), in
/// pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    pub colour: [u8; 3],
    pub marker: Marker,
    /// Half the size of the marker.
    pub radius: f64,
    pub width: f64,
    pub dashes: [i32; 2],
}

const fn look(colour: [u8; 3], marker: Marker, dashes: [i32; 2]) -> Look {
    Look { colour, marker, radius: 6.5, width: 2.6, dashes }
}

/// The looks of all charts: colours that are told apart by most eyes [Okabe and Ito], each with a marker and dashes of
/// its own.
pub const LOOKS: [Look; 7] = [
    look([0, 114, 178], Marker::Disc, [0, 0]),
    look([213, 94, 0], Marker::Square, [14, 7]),
    look([0, 158, 115], Marker::Up, [5, 5]),
    look([204, 121, 167], Marker::Diamond, [22, 8]),
    look([86, 180, 233], Marker::Down, [9, 9]),
    look([230, 159, 0], Marker::Ring, [14, 4]),
    look([90, 90, 90], Marker::Cross, [3, 6]),
];

/// One line of a chart, or points without a line.
#[derive(Debug, Clone)]
pub struct Series {
    /// Its name in the legend; empty for none.
    pub label: String,
    /// (x, y); the line is interrupted at what is not finite.
    pub points: Vec<[f64; 2]>,
    pub look: Look,
    /// What is written at the points; fewer than points are fine.
    pub notes: Vec<String>,
}

impl Series {
    /// Measurements: a line with markers in the look of number `k`.
    pub fn new(label: &str, k: usize, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.to_owned(), points, look: LOOKS[k], notes: Vec::new() }
    }

    /// A curve: the same without markers.
    pub fn curve(label: &str, k: usize, points: Vec<[f64; 2]>) -> Self {
        Self { look: Look { marker: Marker::None, ..LOOKS[k] }, ..Self::new(label, k, points) }
    }

    /// Points alone.
    pub fn points(label: &str, k: usize, points: Vec<[f64; 2]>) -> Self {
        Self { look: Look { width: 0.0, ..LOOKS[k] }, ..Self::new(label, k, points) }
    }

    /// Bounds and laws: a thin dark line in dashes.
    pub fn law(label: &str, dashes: [i32; 2], points: Vec<[f64; 2]>) -> Self {
        let look = Look { colour: INK, marker: Marker::None, radius: 0.0, width: 2.0, dashes };
        Self { look, ..Self::new(label, 0, points) }
    }

    /// Writes something at each point.
    pub fn with_notes(self, notes: impl IntoIterator<Item = String>) -> Self {
        Self { notes: notes.into_iter().collect(), ..self }
    }
}

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    /// Width and height of the picture in pixels.
    pub size: [usize; 2],
}

impl Look {
    /// Wide and pale, without markers: to lie under another line.
    pub const PALE: Self =
        Self { colour: [245, 214, 96], marker: Marker::None, radius: 0.0, width: 13.0, dashes: [0, 0] };

    /// A full line and markers that are wider than usual by `more` pixels on each side: seen under others that lie on
    /// it.
    pub fn wider(self, more: f64) -> Self {
        Self { radius: self.radius + more, width: self.width + 2.0 * more, dashes: [0, 0], ..self }
    }
}

impl Chart {
    /// Draws it.
    pub fn draw(&self) -> Sheet {
        self.draw_over(None)
    }

    /// Draws it over colours that depend on x and y.
    pub fn draw_over(&self, picture: Option<&dyn Fn(f64, f64) -> [u8; 3]>) -> Sheet {
        let points = || self.series.iter().flat_map(|s| s.points.iter());
        let x = Ruler::new(&self.x, points().map(|p| p[0]), self.size[0] / 85);
        let y = Ruler::new(&self.y, points().map(|p| p[1]), self.size[1] / 62);
        figure(self.size, |root| {
            let chart = self.frame(root, [&x, &y]);
            let (columns, rows) = chart.plotting_area().get_pixel_range();
            if let Some(picture) = picture {
                let share = |at: i32, from: i32, to: i32| (f64::from(at - from) + 0.5) / f64::from(to - from);
                for (column, row) in columns.clone().flat_map(|column| rows.clone().map(move |row| (column, row))) {
                    let (u, v) = (share(column, columns.start, columns.end), 1.0 - share(row, rows.start, rows.end));
                    let [r, g, b] = picture(x.value(u), y.value(v));
                    done(root.draw_pixel((column, row), &RGBColor(r, g, b)));
                }
            }
            let place = |p: [f64; 2]| chart.backend_coord(&(x.unscaled(p[0]), y.unscaled(p[1])));
            let mut labels = notes::Notes::new([columns, rows]);
            for series in &self.series {
                let scaled: Vec<[f64; 2]> = series.points.iter().map(|p| [x.scaled(p[0]), y.scaled(p[1])]).collect();
                for run in scaled.split(|p| !p.iter().all(|c| c.is_finite())) {
                    for piece in inside(run, [x.ends, y.ends]) {
                        let path: Vec<(i32, i32)> = piece.into_iter().map(place).collect();
                        labels.avoid_line(&path);
                        stroke(root, &series.look, &path);
                    }
                }
                for (k, &p) in scaled.iter().enumerate() {
                    if x.contains(p[0]) && y.contains(p[1]) && series.look.marker != Marker::None {
                        mark(root, &series.look, place(p));
                        labels.avoid_point(place(p), &series.look);
                        if let Some(note) = series.notes.get(k) {
                            labels.push(place(p), &series.look, note);
                        }
                    }
                }
            }
            labels.draw(root, Type::new(TEXT * FINE as f32));
        })
    }

    /// Title, axes, their numbers and the mesh.
    fn frame<'a>(&self, root: &Area<'a>, [x, y]: [&Ruler; 2]) -> ChartContext<'a, Canvas<'a>, Plane> {
        let font = Type::new(TEXT);
        let widest = y.ticks().into_iter().map(|t| font.width(&number(t))).fold(0.0, f32::max).ceil() as i32;
        let room = (self.size[0] - 40) as f32 / Type::bold(TITLE).width(&self.title);
        let mut builder = ChartBuilder::on(root);
        if !self.title.is_empty() {
            let size = TITLE * room.min(1.0) * FINE as f32;
            builder.caption(&self.title, ("", size).into_font().style(FontStyle::Bold).color(&ink()));
        }
        builder.margin(14 * FINE).margin_right(30 * FINE);
        builder.x_label_area_size(76 * FINE).y_label_area_size((widest + 50) * FINE);
        let mut chart = done(builder.build_cartesian_2d(x.clone(), y.clone()));
        let text = |size: f32| ("", size * FINE as f32).into_font().color(&ink());
        let mut mesh = chart.configure_mesh();
        mesh.axis_style(ink().stroke_width(FINE as u32)).bold_line_style(MESH.stroke_width(FINE as u32));
        mesh.light_line_style(FAINT.stroke_width(FINE as u32)).set_all_tick_mark_size(5 * FINE);
        mesh.label_style(text(TEXT)).axis_desc_style(text(TEXT + 1.0));
        done(mesh.x_desc(self.x.label.clone()).y_desc(self.y.label.clone()).draw());
        chart
    }
}

/// The names of series beside their lines and markers, in columns, as a picture of a given width.
pub fn legend<'a>(series: impl IntoIterator<Item = &'a Series>, columns: usize, width: usize) -> Sheet {
    let named: Vec<&Series> = series.into_iter().filter(|s| !s.label.is_empty()).collect();
    let (font, rows) = (Type::new(TEXT), named.len().div_ceil(columns));
    let (line, swatch, left) = (font.line() + 6, 56, 30);
    let place = |k: usize| {
        let (column, row) = (k / rows, k % rows);
        [left + column * (width - left) / columns, 12 + row * line + line / 2].map(|c| c as i32)
    };
    let mut sheet = figure([width, 24 + rows * line], |root| {
        for (k, series) in named.iter().enumerate() {
            let [x, y] = place(k).map(|c| c * FINE);
            let middle = swatch / 2 * FINE;
            stroke(root, &series.look, &[(x, y), (x + middle, y), (x + 2 * middle, y)]);
            mark(root, &series.look, (x + middle, y));
        }
    });
    for (k, series) in named.iter().enumerate() {
        let [x, y] = place(k).map(|c| c as f32);
        sheet.write(&series.label, [x + swatch as f32 + 12.0, y], font, INK, Align::Left);
    }
    sheet
}

/// Lines of text as a picture.
pub fn text(lines: &[String], size: [usize; 2]) -> Sheet {
    let (mut sheet, font) = (Sheet::blank(size, PAPER), Type::new(TEXT));
    for (k, line) in lines.iter().enumerate() {
        let middle = 16.0 + (k as f32 + 0.5) * font.line() as f32;
        sheet.write(line, [30.0, middle], font, INK, Align::Left);
    }
    sheet
}

/// A table as a picture: a title, a header, rows; the first column to the left, the others to the right.
pub fn table(title: &str, header: &[String], rows: &[Vec<String>], width: usize) -> Sheet {
    let font = Type::new(TEXT - 1.0);
    let bold = Type { bold: true, ..font };
    let line = font.line() + 5;
    let mut sheet = Sheet::blank([width, (rows.len() + 2) * line + 40], PAPER);
    let middle = |row: usize| 16.0 + (row as f32 + 0.5) * line as f32;
    sheet.write(title, [30.0, middle(0)], Type::bold(TITLE), INK, Align::Left);
    let first = rows.iter().chain([&header.to_vec()]).map(|row| font.width(&row[0])).fold(0.0, f32::max) + 30.0;
    let step = (width as f32 - 30.0 - first) / (header.len() - 1).max(1) as f32;
    for (k, row) in [header].into_iter().chain(rows.iter().map(Vec::as_slice)).enumerate() {
        let font = if k == 0 { bold } else { font };
        for (column, cell) in row.iter().enumerate() {
            let (x, align) =
                if column == 0 { (30.0, Align::Left) } else { (first + column as f32 * step, Align::Right) };
            sheet.write(cell, [x, middle(k + 1)], font, INK, align);
        }
    }
    sheet
}

/// Draws on a fine picture and averages it.
fn figure(size: [usize; 2], draw: impl FnOnce(&Area<'_>)) -> Sheet {
    let mut fine = Sheet::blank(size.map(|s| s * FINE as usize), PAPER);
    draw(&Canvas { fine: &mut fine }.into_drawing_area());
    shrink(&fine)
}

fn ink() -> RGBColor {
    RGBColor(INK[0], INK[1], INK[2])
}

/// The canvas never fails.
fn done<T, E: std::error::Error>(drawn: Result<T, E>) -> T {
    drawn.unwrap_or_else(|failure| panic!("drawing on a canvas failed: {failure}"))
}

/// A polyline, full or in dashes, in fine pixels.
fn stroke(root: &Area<'_>, look: &Look, path: &[(i32, i32)]) {
    let width = (look.width * f64::from(FINE)).round() as u32;
    if width == 0 || path.len() < 2 {
        return;
    }
    let style = RGBColor(look.colour[0], look.colour[1], look.colour[2]).stroke_width(width);
    let [dash, gap] = look.dashes.map(|d| d * FINE);
    if gap == 0 {
        done(root.draw(&PathElement::new(path.to_vec(), style)));
    } else {
        done(root.draw(&DashedPathElement::new(path.iter().copied(), dash, gap, style)));
    }
}

/// A marker with a rim of paper, so that two that overlap are seen as two.
fn mark(root: &Area<'_>, look: &Look, (x, y): (i32, i32)) {
    let fill = |colour: [u8; 3], radius: f64| {
        let r = radius * f64::from(FINE);
        let style = RGBColor(colour[0], colour[1], colour[2]).filled();
        let corner = |&(dx, dy): &(f64, f64)| (x + (r * dx).round() as i32, y + (r * dy).round() as i32);
        let polygon = |corners: &[(f64, f64)]| {
            done(root.draw(&Polygon::new(corners.iter().map(corner).collect::<Vec<_>>(), style)));
        };
        match look.marker {
            Marker::None => {}
            Marker::Disc | Marker::Ring => done(root.draw(&Circle::new((x, y), r.round() as i32, style))),
            Marker::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Marker::Up => polygon(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
            Marker::Down => polygon(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
            Marker::Diamond => polygon(&[(0.0, -1.3), (1.1, 0.0), (0.0, 1.3), (-1.1, 0.0)]),
            Marker::Cross => {
                polygon(&[(-1.1, -0.6), (-0.6, -1.1), (1.1, 0.6), (0.6, 1.1)]);
                polygon(&[(1.1, -0.6), (0.6, -1.1), (-1.1, 0.6), (-0.6, 1.1)]);
            }
        }
    };
    fill(PAPER, look.radius + 1.5);
    fill(look.colour, look.radius);
    if look.marker == Marker::Ring {
        fill(PAPER, 0.55 * look.radius);
    }
}

/// The parts of a polyline that lie in a rectangle.
fn inside(run: &[[f64; 2]], ends: [[f64; 2]; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    for pair in run.windows(2) {
        let step = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let [mut from, mut to] = [0.0f64, 1.0];
        for k in 0..2 {
            let [low, high] = ends[k];
            if step[k] == 0.0 {
                to = if (low..=high).contains(&pair[0][k]) { to } else { -1.0 };
                continue;
            }
            let [a, b] = [low, high].map(|end| (end - pair[0][k]) / step[k]);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        if from < to {
            let at = |t: f64| [pair[0][0] + t * step[0], pair[0][1] + t * step[1]];
            match pieces.last_mut() {
                Some(piece) if from == 0.0 && piece.last() == Some(&pair[0]) => piece.push(at(to)),
                _ => pieces.push(vec![at(from), at(to)]),
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_frame() {
        let ends = [[0.0, 1.0], [0.0, 1.0]];
        // Through two corners' sides, out and in again, never in.
        assert_eq!(inside(&[[-1.0, 0.5], [2.0, 0.5]], ends), [[[0.0, 0.5], [1.0, 0.5]]]);
        let zigzag = inside(&[[0.5, 0.5], [0.5, 2.0], [0.75, 2.0], [0.75, 0.5]], ends);
        assert_eq!(zigzag, [[[0.5, 0.5], [0.5, 1.0]], [[0.75, 1.0], [0.75, 0.5]]]);
        assert!(inside(&[[-1.0, 0.0], [-1.0, 1.0]], ends).is_empty());
        assert_eq!(inside(&[[0.0, 0.0], [0.5, 0.5], [1.0, 0.0]], ends)[0].len(), 3);
    }
}
