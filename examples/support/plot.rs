//! Line charts: series, linear or logarithmic axes, legend, caption.
//!
//! Lines are drawn three times as large and averaged down, text afterwards at its own size.

use embedded_graphics::mono_font::iso_8859_1::{FONT_6X13, FONT_7X13_BOLD};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, Line, Polyline, PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};

use super::sheet::Sheet;

/// Subpixels along a side.
const FINE: i32 = 3;
const LINE: i32 = 15;
const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [40, 42, 48];
const GRID: [u8; 3] = [226, 228, 232];

/// Colours that are told apart by most eyes and in print [Okabe and Ito], the first ones first.
pub const COLOURS: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [230, 159, 0], [110, 110, 110]];

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Decades. Values that are not positive are left out.
    Log10,
    /// Octaves. Values that are not positive are left out.
    Log2,
}

/// One axis.
#[derive(Debug, Clone)]
pub struct Axis {
    /// What it shows, with its unit.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
    /// From where to where; `None` for what the series need.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// An axis that fits its series.
    pub fn new(label: &str, scale: Scale) -> Self {
        Self { label: label.to_owned(), scale, range: None }
    }

    /// An axis from `low` to `high`.
    pub fn between(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        Self { range: Some([low, high]), ..Self::new(label, scale) }
    }
}

/// One line of the chart.
#[derive(Debug, Clone)]
pub struct Series {
    /// Its name in the legend; empty for none.
    pub label: String,
    /// (x, y); the line is interrupted at what is not finite.
    pub points: Vec<[f64; 2]>,
    /// Its colour.
    pub colour: [u8; 3],
    /// Width of the line in pixels; 0 for none.
    pub width: f64,
    /// Whether the line is broken into dashes: for bounds and laws.
    pub dashed: bool,
    /// Diameter of the dots at the points, in pixels; 0 for none.
    pub dots: f64,
}

impl Series {
    /// A full line.
    pub fn line(label: &str, colour: [u8; 3], points: Vec<[f64; 2]>) -> Self {
        Self { label: label.to_owned(), points, colour, width: 2.0, dashed: false, dots: 0.0 }
    }

    /// A line with a dot at each point: for measurements.
    pub fn dotted(label: &str, colour: [u8; 3], points: Vec<[f64; 2]>) -> Self {
        Self { dots: 7.0, ..Self::line(label, colour, points) }
    }

    /// Dashes: for bounds and laws.
    pub fn dashed(label: &str, colour: [u8; 3], points: Vec<[f64; 2]>) -> Self {
        Self { dashed: true, ..Self::line(label, colour, points) }
    }
}

/// Where the legend goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Legend {
    None,
    TopLeft,
    TopRight,
    BottomLeft,
    BottomRight,
    /// Beside the chart.
    Right,
}

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub legend: Legend,
    /// Lines of text below.
    pub caption: Vec<String>,
    /// Width and height of the picture in pixels.
    pub size: [usize; 2],
}

impl Chart {
    /// Draws it.
    pub fn draw(&self) -> Sheet {
        let [width, height] = self.size.map(|s| s as i32);
        let names = self.series.iter().filter(|s| !s.label.is_empty());
        let legend_width = 44 + 6 * names.clone().map(|s| s.label.chars().count()).max().unwrap_or(0) as i32;
        let (x, y) = (Ruler::new(&self.x, &self.series, 0), Ruler::new(&self.y, &self.series, 1));
        let ticks = y.ticks((height / 50) as usize);
        let tick_width = 6 * ticks.iter().map(|t| format(*t).len()).max().unwrap_or(0) as i32;
        let right = if self.legend == Legend::Right { legend_width + 16 } else { 20 };
        let area = Area {
            left: tick_width + 40,
            right: width - right,
            top: 34,
            bottom: height - 46 - LINE * self.caption.len() as i32,
            x,
            y,
        };
        let mut fine = blank(width * FINE, height * FINE);
        area.grid(&mut fine, &ticks);
        for series in &self.series {
            area.series(&mut fine, series);
        }
        let corner = self.legend_corner(&area, legend_width, names.clone().count() as i32);
        if let Some(corner) = corner {
            let size = Size::new(legend_width as u32, (LINE * names.clone().count() as i32 + 8) as u32) * FINE as u32;
            let box_style = PrimitiveStyle::with_fill(colour(PAPER));
            never(Rectangle::new(corner * FINE, size).into_styled(box_style).draw(&mut fine));
            for (k, series) in names.clone().enumerate() {
                let middle = corner.y + 4 + LINE * k as i32 + LINE / 2;
                let ends = [6, 30].map(|dx| [f64::from(corner.x + dx), f64::from(middle)].map(|c| c * f64::from(FINE)));
                stroke(&mut fine, series, &ends);
                dot(&mut fine, series, [0, 1].map(|k| (ends[0][k] + ends[1][k]) / 2.0));
            }
        }
        let mut sheet = shrink(&fine);
        area.labels(&mut sheet, &ticks, self);
        if let Some(corner) = corner {
            for (k, series) in names.enumerate() {
                let at = corner + Point::new(38, 4 + LINE * k as i32 + LINE / 2);
                write(&mut sheet, &series.label, at, &FONT_6X13, Alignment::Left);
            }
        }
        for (k, line) in self.caption.iter().enumerate() {
            let y = height - LINE * (self.caption.len() - k) as i32 + LINE / 2 - 4;
            write(&mut sheet, line, Point::new(12, y), &FONT_6X13, Alignment::Left);
        }
        sheet
    }

    fn legend_corner(&self, area: &Area, width: i32, names: i32) -> Option<Point> {
        let height = LINE * names + 8;
        let (left, right) = (area.left + 8, area.right - width - 8);
        let (top, bottom) = (area.top + 8, area.bottom - height - 8);
        match self.legend {
            Legend::None => None,
            Legend::TopLeft => Some(Point::new(left, top)),
            Legend::TopRight => Some(Point::new(right, top)),
            Legend::BottomLeft => Some(Point::new(left, bottom)),
            Legend::BottomRight => Some(Point::new(right, bottom)),
            Legend::Right => Some(Point::new(area.right + 12, area.top)),
        }
    }
}

/// Charts and pictures below and beside each other on white.
pub fn grid(rows: &[Vec<Sheet>]) -> Sheet {
    let width = rows.iter().map(|row| row.iter().map(|s| s.width).sum()).max().unwrap_or(1);
    let heights: Vec<usize> = rows.iter().map(|row| row.iter().map(|s| s.height).max().unwrap_or(0)).collect();
    let mut all = blank(width as i32, heights.iter().sum::<usize>() as i32);
    let mut top = 0;
    for (row, height) in rows.iter().zip(heights) {
        let mut left = 0;
        for part in row {
            place(&mut all, part, left, top);
            left += part.width;
        }
        top += height;
    }
    all
}

/// Lines of text as a picture.
pub fn text(lines: &[String], [width, height]: [usize; 2]) -> Sheet {
    let mut sheet = blank(width as i32, height as i32);
    for (k, line) in lines.iter().enumerate() {
        write(&mut sheet, line, Point::new(16, 16 + LINE * k as i32), &FONT_6X13, Alignment::Left);
    }
    sheet
}

/// A picture of a function of two numbers with its axes.
pub fn image(title: &str, [x, y]: [&Axis; 2], size: [usize; 2], pixel: impl Fn(f64, f64) -> [u8; 3]) -> Sheet {
    let chart = Chart {
        title: title.to_owned(),
        x: x.clone(),
        y: y.clone(),
        series: Vec::new(),
        legend: Legend::None,
        caption: Vec::new(),
        size,
    };
    let mut sheet = chart.draw();
    let (x, y) = (Ruler::new(x, &[], 0), Ruler::new(y, &[], 1));
    let tick_width = 6 * y.ticks(size[1] / 50).iter().map(|t| format(*t).len()).max().unwrap_or(0) as i32;
    let area = Area { left: tick_width + 40, right: size[0] as i32 - 20, top: 34, bottom: size[1] as i32 - 46, x, y };
    for row in area.top + 1..area.bottom {
        for column in area.left + 1..area.right {
            let share = |at: i32, from: i32, to: i32| (f64::from(at) + 0.5 - f64::from(from)) / f64::from(to - from);
            let u = area.x.value(share(column, area.left, area.right));
            let v = area.y.value(share(row, area.bottom, area.top));
            sheet.pixels[row as usize * sheet.width + column as usize] = pixel(u, v);
        }
    }
    sheet
}

fn place(all: &mut Sheet, part: &Sheet, left: usize, top: usize) {
    for (row, pixels) in part.pixels.chunks_exact(part.width).enumerate() {
        let start = (top + row) * all.width + left;
        all.pixels[start..start + part.width].copy_from_slice(pixels);
    }
}

/// Values along an axis ↔ the share of its length.
#[derive(Debug, Clone)]
struct Ruler {
    scale: Scale,
    /// The ends, after the logarithm.
    ends: [f64; 2],
}

impl Ruler {
    fn new(axis: &Axis, series: &[Series], k: usize) -> Self {
        let log = |x: f64| match axis.scale {
            Scale::Linear => x,
            Scale::Log10 => x.log10(),
            Scale::Log2 => x.log2(),
        };
        let ends = axis.range.unwrap_or_else(|| {
            let values = series.iter().flat_map(|s| &s.points).map(|p| p[k]).filter(|&x| log(x).is_finite());
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        });
        let mut ends = ends.map(log);
        if !(ends[0] < ends[1]) || !(ends[1] - ends[0]).is_finite() {
            let middle = if ends[0].is_finite() { ends[0] } else { 0.0 };
            ends = [middle - 1.0, middle + 1.0];
        } else if axis.range.is_none() {
            let room = 0.04 * (ends[1] - ends[0]);
            ends = [ends[0] - room, ends[1] + room];
        }
        Self { scale: axis.scale, ends }
    }

    fn share(&self, x: f64) -> f64 {
        let x = match self.scale {
            Scale::Linear => x,
            Scale::Log10 => x.log10(),
            Scale::Log2 => x.log2(),
        };
        (x - self.ends[0]) / (self.ends[1] - self.ends[0])
    }

    fn value(&self, share: f64) -> f64 {
        let x = self.ends[0] + share * (self.ends[1] - self.ends[0]);
        match self.scale {
            Scale::Linear => x,
            Scale::Log10 => 10f64.powf(x),
            Scale::Log2 => x.exp2(),
        }
    }

    /// Round values, about `count` of them.
    fn ticks(&self, count: usize) -> Vec<f64> {
        let span = self.ends[1] - self.ends[0];
        let count = count.max(2) as f64;
        let multiples = |step: f64| {
            let first = (self.ends[0] / step - 1e-9).ceil();
            let number = ((self.ends[1] / step + 1e-9).floor() - first).clamp(-1.0, 200.0) as i64;
            (0..=number).map(move |k| (first + k as f64) * step)
        };
        match self.scale {
            Scale::Log2 => multiples((span / count).ceil().max(1.0)).map(f64::exp2).collect(),
            Scale::Log10 if span >= 2.0 => multiples((span / count).ceil()).map(|x| 10f64.powf(x)).collect(),
            Scale::Log10 => {
                let decades = self.ends[0].floor() as i32..=self.ends[1].ceil() as i32;
                let all = decades.flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(e)));
                all.filter(|&x| (-1e-9..=1.0 + 1e-9).contains(&self.share(x))).collect()
            }
            Scale::Linear => {
                let power = 10f64.powf((span / count).log10().floor());
                let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s * count >= span);
                multiples(step.unwrap_or(10.0 * power)).collect()
            }
        }
    }
}

/// A short form of a number: 0.25, 1000, 1e6.
fn format(x: f64) -> String {
    if x == 0.0 || x.abs() < 1e-12 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&x.abs()) {
        return format!("{x:.1e}").replace(".0e", "e");
    }
    let decimals = (3 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The frame in pixels and what it stands for.
struct Area {
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
    x: Ruler,
    y: Ruler,
}

impl Area {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let along = |share: f64, from: i32, to: i32| f64::from(FINE) * (f64::from(from) + share * f64::from(to - from));
        [along(self.x.share(x), self.left, self.right), along(self.y.share(y), self.bottom, self.top)]
    }

    fn x_ticks(&self) -> Vec<f64> {
        self.x.ticks(((self.right - self.left) / 56) as usize)
    }

    fn grid(&self, fine: &mut Sheet, y_ticks: &[f64]) {
        let [left, right, top, bottom] = [self.left, self.right, self.top, self.bottom].map(|c| c * FINE);
        let thin = |c| PrimitiveStyle::with_stroke(colour(c), FINE as u32);
        let mut line = |a: [i32; 2], b: [i32; 2], c| {
            let ends = [a, b].map(|[x, y]| Point::new(x, y));
            never(Line::new(ends[0], ends[1]).into_styled(thin(c)).draw(fine));
        };
        for tick in self.x_ticks() {
            let x = left + (self.x.share(tick) * f64::from(right - left)) as i32;
            line([x, top], [x, bottom + 4 * FINE], GRID);
        }
        for &tick in y_ticks {
            let y = bottom - (self.y.share(tick) * f64::from(bottom - top)) as i32;
            line([left - 4 * FINE, y], [right, y], GRID);
        }
        line([left, bottom], [right, bottom], INK);
        line([left, top], [left, bottom], INK);
    }

    fn series(&self, fine: &mut Sheet, series: &Series) {
        let size = Size::new((self.right - self.left) as u32, (self.bottom - self.top) as u32);
        let frame = Rectangle::new(Point::new(self.left, self.top) * FINE, size * FINE as u32);
        let mut inside = fine.clipped(&frame);
        let points: Vec<[f64; 2]> = series.points.iter().map(|&p| self.at(p)).collect();
        for run in points.split(|p| !p.iter().all(|c| c.is_finite() && c.abs() < 1e6)) {
            stroke(&mut inside, series, run);
            run.iter().for_each(|&p| dot(&mut inside, series, p));
        }
    }

    fn labels(&self, sheet: &mut Sheet, y_ticks: &[f64], chart: &Chart) {
        for tick in self.x_ticks() {
            let x = self.left + (self.x.share(tick) * f64::from(self.right - self.left)).round() as i32;
            write(sheet, &format(tick), Point::new(x, self.bottom + 12), &FONT_6X13, Alignment::Center);
        }
        for &tick in y_ticks {
            let y = self.bottom - (self.y.share(tick) * f64::from(self.bottom - self.top)).round() as i32;
            write(sheet, &format(tick), Point::new(self.left - 7, y), &FONT_6X13, Alignment::Right);
        }
        let middle = Point::new((self.left + self.right) / 2, self.bottom + 30);
        write(sheet, &chart.x.label, middle, &FONT_6X13, Alignment::Center);
        write(sheet, &chart.title, Point::new(self.left, 16), &FONT_7X13_BOLD, Alignment::Left);
        let width = 6 * chart.y.label.chars().count() as i32;
        let mut upright = blank(width.max(1), LINE);
        write(&mut upright, &chart.y.label, Point::new(0, LINE / 2), &FONT_6X13, Alignment::Left);
        let mut turned = blank(LINE, upright.width as i32);
        for (i, pixel) in upright.pixels.iter().enumerate() {
            let (x, y) = (i % upright.width, i / upright.width);
            turned.pixels[(upright.width - 1 - x) * turned.width + y] = *pixel;
        }
        let top = ((self.top + self.bottom - width) / 2).max(0) as usize;
        let fits = top + turned.height <= sheet.height;
        if fits {
            place(sheet, &turned, 6, top);
        }
    }
}

/// A polyline, full or dashed, in fine pixels.
fn stroke<D: DrawTarget<Color = Rgb888, Error = std::convert::Infallible>>(
    to: &mut D,
    series: &Series,
    run: &[[f64; 2]],
) {
    let width = (series.width * f64::from(FINE)).round() as u32;
    if width == 0 || run.len() < 2 {
        return;
    }
    let style = PrimitiveStyle::with_stroke(colour(series.colour), width);
    let mut draw = |points: &[[f64; 2]]| {
        let points: Vec<Point> = points.iter().map(|p| Point::new(p[0].round() as i32, p[1].round() as i32)).collect();
        never(Polyline::new(&points).into_styled(style).draw(to));
    };
    if !series.dashed {
        return draw(run);
    }
    let (dash, mut gone) = (f64::from(FINE) * 6.0, 0.0);
    for ends in run.windows(2) {
        let step = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let length = step[0].hypot(step[1]);
        let at = |t: f64| [ends[0][0] + step[0] * t / length, ends[0][1] + step[1] * t / length];
        let mut t = 0.0;
        while t < length {
            let phase = (gone + t) % (2.0 * dash);
            let next = t + if phase < dash { dash - phase } else { 2.0 * dash - phase }.max(1e-3);
            if phase < dash {
                draw(&[at(t), at(next.min(length))]);
            }
            t = next;
        }
        gone += length;
    }
}

fn dot<D: DrawTarget<Color = Rgb888, Error = std::convert::Infallible>>(to: &mut D, series: &Series, [x, y]: [f64; 2]) {
    let diameter = (series.dots * f64::from(FINE)).round() as u32;
    if diameter > 0 {
        let centre = Point::new(x.round() as i32, y.round() as i32);
        let style = PrimitiveStyle::with_fill(colour(series.colour));
        never(Circle::with_center(centre, diameter).into_styled(style).draw(to));
    }
}

fn blank(width: i32, height: i32) -> Sheet {
    let (width, height) = (width as usize, height as usize);
    Sheet { width, height, pixels: vec![PAPER; width * height] }
}

/// The mean of each FINE × FINE square.
fn shrink(fine: &Sheet) -> Sheet {
    let k = FINE as usize;
    let mut sheet = blank((fine.width / k) as i32, (fine.height / k) as i32);
    for (i, pixel) in sheet.pixels.iter_mut().enumerate() {
        let (x, y) = (i % sheet.width * k, i / sheet.width * k);
        *pixel = std::array::from_fn(|c| {
            let sum: usize =
                (0..k * k).map(|s| usize::from(fine.pixels[(y + s / k) * fine.width + x + s % k][c])).sum();
            ((sum + k * k / 2) / (k * k)) as u8
        });
    }
    sheet
}

/// One line of text, centred on the height of `at`.
fn write(sheet: &mut Sheet, text: &str, at: Point, font: &MonoFont<'_>, alignment: Alignment) {
    let style = TextStyleBuilder::new().alignment(alignment).baseline(Baseline::Middle).build();
    never(Text::with_text_style(text, at, MonoTextStyle::new(font, colour(INK)), style).draw(sheet));
}

fn colour([r, g, b]: [u8; 3]) -> Rgb888 {
    Rgb888::new(r, g, b)
}

fn never<T>(drawn: Result<T, std::convert::Infallible>) -> T {
    drawn.unwrap_or_else(|never| match never {})
}
