//! Pictures of 8 bits and text on them; contact sheets: pictures in a grid, each with a caption.

use haarmonic::nalgebra::Vector3;

use super::text::{CAPITAL, Type};

/// Ground of contact sheets.
pub const DARK: [u8; 3] = [24, 25, 28];
/// Text on it.
pub const BRIGHT: [u8; 3] = [228, 228, 228];
/// Titles on it.
const TITLE: [u8; 3] = [255, 214, 140];
/// Ground of charts.
pub const PAPER: [u8; 3] = [255, 255, 255];
/// Text on it.
pub const INK: [u8; 3] = [30, 32, 38];

const CAPTION: f32 = 19.0;
const MARGIN: usize = 12;

/// Which part of a line of text lies where it is put.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left,
    Middle,
    Right,
}

/// An 8-bit sRGB picture.
#[derive(Debug, Clone)]
pub struct Sheet {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

/// One picture of a contact sheet.
pub struct Panel {
    /// Lines below; those that are wider than the picture are broken.
    pub caption: Vec<String>,
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

impl Sheet {
    /// One colour.
    pub fn blank([width, height]: [usize; 2], colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// A contact sheet of panels in rows; a `None` leaves its cell empty.
    pub fn new(title: &str, rows: &[Vec<Option<Panel>>]) -> Self {
        let (caption, heading) = (Type::new(CAPTION), Type::bold(CAPTION + 2.0));
        let cell_width = rows.iter().flatten().flatten().map(|p| p.width).max().unwrap_or(1);
        let lines = |p: &Panel| p.caption.iter().flat_map(|l| caption.wrap(l, cell_width)).collect::<Vec<_>>();
        let height_of = |row: &Vec<Option<Panel>>| {
            row.iter().flatten().map(|p| p.height + lines(p).len() * caption.line()).max().unwrap_or(0)
        };
        let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
        let width = MARGIN + columns * (cell_width + MARGIN);
        let title = heading.wrap(title, width - 2 * MARGIN);
        let top = 2 * MARGIN + title.len() * heading.line();
        let height = top + rows.iter().map(|row| height_of(row) + MARGIN).sum::<usize>();
        let mut sheet = Self::blank([width, height], DARK);
        for (k, line) in title.iter().enumerate() {
            let middle = (MARGIN + k * heading.line()) as f32 + 0.5 * heading.line() as f32;
            sheet.write(line, [MARGIN as f32, middle], heading, TITLE, Align::Left);
        }
        let mut y = top;
        for row in rows {
            for (column, panel) in row.iter().enumerate() {
                let Some(panel) = panel else { continue };
                let x = MARGIN + column * (cell_width + MARGIN);
                sheet.place(&panel.pixels, panel.width, [x, y]);
                for (k, line) in lines(panel).iter().enumerate() {
                    let middle = (y + panel.height + 3 + k * caption.line()) as f32 + 0.5 * caption.line() as f32;
                    sheet.write(line, [x as f32, middle], caption, BRIGHT, Align::Left);
                }
            }
            y += height_of(row) + MARGIN;
        }
        sheet
    }

    /// Pictures beside each other in rows, each row in the middle.
    pub fn grid(rows: &[Vec<Self>], ground: [u8; 3]) -> Self {
        let width_of = |row: &Vec<Self>| row.iter().map(|s| s.width).sum::<usize>();
        let height_of = |row: &Vec<Self>| row.iter().map(|s| s.height).max().unwrap_or(0);
        let width = rows.iter().map(width_of).max().unwrap_or(1);
        let mut all = Self::blank([width, rows.iter().map(height_of).sum()], ground);
        let mut y = 0;
        for row in rows {
            let mut x = (width - width_of(row)) / 2;
            for part in row {
                all.place(&part.pixels, part.width, [x, y]);
                x += part.width;
            }
            y += height_of(row);
        }
        all
    }

    /// Copies a picture to a place.
    pub fn place(&mut self, pixels: &[[u8; 3]], width: usize, [x, y]: [usize; 2]) {
        for (line, pixels) in pixels.chunks_exact(width).enumerate() {
            let start = (y + line) * self.width + x;
            self.pixels[start..start + width].copy_from_slice(pixels);
        }
    }

    /// Mixes a colour into a pixel; outside of the picture, nothing.
    pub fn mix(&mut self, [x, y]: [i32; 2], colour: [u8; 3], share: f32) {
        if (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y) {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            *pixel = std::array::from_fn(|k| {
                let [from, to] = [pixel[k], colour[k]].map(f32::from);
                (from + share * (to - from)).round() as u8
            });
        }
    }

    /// Writes a line of text, the middle of its capitals at the height of `at`.
    pub fn write(&mut self, text: &str, at: [f32; 2], font: Type, colour: [u8; 3], align: Align) {
        let before = match align {
            Align::Left => 0.0,
            Align::Middle => 0.5 * font.width(text),
            Align::Right => font.width(text),
        };
        let [x, y] = [at[0] - before, at[1] + 0.5 * CAPITAL * font.size].map(|c| c.round() as i32);
        font.draw(text, |dx, dy, share| self.mix([x + dx, y + dy], colour, share));
    }
}

/// A scale of colours as a bar with numbers below it, and what they mean below these.
pub struct ColourBar<'a> {
    pub label: &'a str,
    /// Where on the bar, from 0 to 1, and what is written there.
    pub ticks: &'a [(f32, String)],
    /// Of a place on the bar.
    pub colour: &'a dyn Fn(f32) -> [u8; 3],
}

impl ColourBar<'_> {
    /// Draws it in the middle of a picture of its own.
    pub fn draw(&self, size: [usize; 2], font: Type, [ink, ground]: [[u8; 3]; 2]) -> Sheet {
        let mut sheet = Sheet::blank(size, ground);
        let (line, label) = (font.line(), font.wrap(self.label, size[0]));
        let (left, right) = (size[0] / 10, size[0] - size[0] / 10);
        let bar = 2 * line;
        let top = size[1].saturating_sub(bar + 10 + (1 + label.len()) * line) / 2;
        let share = |x: usize| (x as f32 + 0.5 - left as f32) / (right - left) as f32;
        for (x, y) in (left..right).flat_map(|x| (top..top + bar).map(move |y| (x, y))) {
            let edge = x == left || x + 1 == right || y == top || y + 1 == top + bar;
            sheet.mix([x as i32, y as i32], if edge { ink } else { (self.colour)(share(x)) }, 1.0);
        }
        for (at, text) in self.ticks {
            let x = left as f32 + at * (right - 1 - left) as f32;
            (0..8).for_each(|dy| sheet.mix([x as i32, (top + bar + dy) as i32], ink, 1.0));
            sheet.write(text, [x, (top + bar + 10) as f32 + 0.5 * line as f32], font, ink, Align::Middle);
        }
        for (k, text) in label.iter().enumerate() {
            let middle = (top + bar + 10 + (k + 1) * line) as f32 + 0.5 * line as f32;
            sheet.write(text, [0.5 * size[0] as f32, middle], font, ink, Align::Middle);
        }
        sheet
    }
}

/// The colour of an error: black at 0 through red and yellow to white at 1 and above.
pub fn heat(t: f32) -> [u8; 3] {
    let t = t.clamp(0.0, 1.0);
    Vector3::new(3.0 * t, 3.0 * t - 1.0, 3.0 * t - 2.0).map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8).into()
}
