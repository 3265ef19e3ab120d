//! Words at points of a chart, put where they cover least.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::canvas::{Canvas, FINE};
use super::plot::Look;
use super::sheet::INK;
use super::text::Type;

/// Left, top, right, bottom in fine pixels.
type Bounds = [i32; 4];

/// The words of a chart and what they shall not cover.
pub struct Notes {
    frame: Bounds,
    points: Vec<Bounds>,
    lines: Vec<(i32, i32)>,
    notes: Vec<Note>,
}

/// Words, and the point that they belong to: where, how far its marker reaches, which colour.
struct Note {
    at: (i32, i32),
    radius: i32,
    text: String,
    colour: [u8; 3],
}

impl Notes {
    /// None yet, in a frame of columns and rows.
    pub fn new([columns, rows]: [Range<i32>; 2]) -> Self {
        let frame = [columns.start, rows.start, columns.end, rows.end];
        Self { frame, points: Vec::new(), lines: Vec::new(), notes: Vec::new() }
    }

    /// Words at a point, in the colour of its series made darker.
    pub fn push(&mut self, at: (i32, i32), look: &Look, text: &str) {
        let radius = (look.radius * f64::from(FINE)).ceil() as i32;
        self.notes.push(Note { at, radius, text: text.to_owned(), colour: look.colour });
    }

    /// There is a marker.
    pub fn avoid_point(&mut self, (x, y): (i32, i32), look: &Look) {
        let r = ((look.radius + 1.5) * f64::from(FINE)).ceil() as i32;
        self.points.push([x - r, y - r, x + r, y + r]);
    }

    /// There is a line.
    pub fn avoid_line(&mut self, path: &[(i32, i32)]) {
        for pair in path.windows(2) {
            let ((x, y), (u, v)) = (pair[0], pair[1]);
            let steps = ((u - x).abs().max((v - y).abs()) / (4 * FINE)).max(1);
            self.lines.extend((0..steps).map(|k| (x + (u - x) * k / steps, y + (v - y) * k / steps)));
        }
    }

    /// Writes each where it covers least of points, lines and other words.
    pub fn draw(&self, root: &DrawingArea<Canvas<'_>, Shift>, font: Type) {
        let mut taken: Vec<Bounds> = Vec::new();
        for Note { at: (x, y), radius, text, colour } in &self.notes {
            let (x, y) = (*x, *y);
            let (width, height) = (font.width(text).ceil() as i32, font.size.ceil() as i32);
            let candidates = [6, 20, 38].into_iter().flat_map(|away| {
                let (side, up) = (radius + away * FINE, radius + (away - 2) * FINE);
                let lefts = [x + side, x - side - width, x - width / 2];
                let tops = [y - height / 2, y - up - height, y + up];
                lefts.into_iter().flat_map(move |left| tops.map(|top| [left, top, left + width, top + height]))
            });
            let cost = |(k, b): &(usize, Bounds)| {
                // With some air around.
                let wide = [b[0] - 7 * FINE, b[1] - 2 * FINE, b[2] + 7 * FINE, b[3] + 2 * FINE];
                let boxes = |boxes: &[Bounds]| boxes.iter().map(|o| overlap(&wide, o)).sum::<i64>();
                let covered = self.lines.iter().filter(|p| (b[0]..b[2]).contains(&p.0) && (b[1]..b[3]).contains(&p.1));
                let out = i64::from(b[2] - b[0]) * i64::from(b[3] - b[1]) - overlap(b, &self.frame);
                40 * boxes(&taken)
                    + 10 * boxes(&self.points)
                    + 60 * out
                    + 4000 * covered.count() as i64
                    + *k as i64 * 300
            };
            let best = candidates.enumerate().min_by_key(cost).map(|(_, b)| b).unwrap_or_default();
            taken.push(best);
            let [r, g, b] = [0, 1, 2].map(|k| ((u16::from(colour[k]) * 3 + u16::from(INK[k]) * 2) / 5) as u8);
            let style = ("", font.size).into_font().color(&RGBColor(r, g, b)).pos(Pos::new(HPos::Left, VPos::Center));
            // A thin line to words that are not beside their point.
            let near = (x.clamp(best[0], best[2]), y.clamp(best[1], best[3]));
            if (near.0 - x).abs().max((near.1 - y).abs()) > radius + 9 * FINE {
                let line = PathElement::new(vec![(x, y), near], RGBColor(r, g, b).stroke_width(FINE as u32));
                root.draw(&line).unwrap_or_else(|failure| panic!("drawing on a canvas failed: {failure}"));
            }
            let written = root.draw(&Text::new(text.as_str(), (best[0], (best[1] + best[3]) / 2), style));
            written.unwrap_or_else(|failure| panic!("drawing on a canvas failed: {failure}"));
        }
    }
}

/// Pixels that two boxes share.
fn overlap(a: &Bounds, b: &Bounds) -> i64 {
    let width = (a[2].min(b[2]) - a[0].max(b[0])).max(0);
    let height = (a[3].min(b[3]) - a[1].max(b[1])).max(0);
    i64::from(width) * i64::from(height)
}
