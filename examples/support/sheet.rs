//! Contact sheets: pictures in a grid, each with a caption.

use embedded_graphics::mono_font::ascii::FONT_6X13;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::text::{Baseline, Text};
use haarmonic::nalgebra::Vector3;

const FONT: MonoFont<'static> = FONT_6X13;
const LINE: usize = 15;
const MARGIN: usize = 8;
const BACKGROUND: [u8; 3] = [24, 25, 28];

/// An 8-bit sRGB picture with room for text.
pub struct Sheet {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

/// One picture of the sheet.
pub struct Panel {
    pub caption: Vec<String>,
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

impl Sheet {
    /// Lays the panels out in rows; a `None` leaves its cell empty. All panels of a sheet have one size.
    pub fn new(title: &str, rows: &[Vec<Option<Panel>>]) -> Self {
        let panels = || rows.iter().flatten().flatten();
        let cell_width = panels().map(|p| p.width).max().unwrap_or(1);
        let cell_height = panels().map(|p| p.height + p.caption.len() * LINE).max().unwrap_or(1);
        let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
        let width = MARGIN + columns * (cell_width + MARGIN);
        let top = 2 * MARGIN + LINE;
        let height = top + rows.len() * (cell_height + MARGIN);
        let mut sheet = Self { width, height, pixels: vec![BACKGROUND; width * height] };
        sheet.write(title, MARGIN, MARGIN, Rgb888::new(255, 214, 140));
        for (row, panels) in rows.iter().enumerate() {
            for (column, panel) in panels.iter().enumerate() {
                let Some(panel) = panel else { continue };
                let (x, y) = (MARGIN + column * (cell_width + MARGIN), top + row * (cell_height + MARGIN));
                sheet.place(panel, x, y);
            }
        }
        sheet
    }

    fn place(&mut self, panel: &Panel, x: usize, y: usize) {
        for (line, pixels) in panel.pixels.chunks_exact(panel.width).enumerate() {
            let start = (y + line) * self.width + x;
            self.pixels[start..start + panel.width].copy_from_slice(pixels);
        }
        for (i, line) in panel.caption.iter().enumerate() {
            self.write(line, x, y + panel.height + 2 + i * LINE, Rgb888::new(225, 225, 225));
        }
    }

    fn write(&mut self, text: &str, x: usize, y: usize, colour: Rgb888) {
        let style = MonoTextStyle::new(&FONT, colour);
        let drawn = Text::with_baseline(text, Point::new(x as i32, y as i32), style, Baseline::Top).draw(self);
        drawn.unwrap_or_else(|never| match never {});
    }
}

impl OriginDimensions for Sheet {
    fn size(&self) -> Size {
        Size::new(self.width as u32, self.height as u32)
    }
}

impl DrawTarget for Sheet {
    type Color = Rgb888;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Self::Error> {
        for Pixel(p, c) in pixels {
            if (0..self.width as i32).contains(&p.x) && (0..self.height as i32).contains(&p.y) {
                self.pixels[p.y as usize * self.width + p.x as usize] = [c.r(), c.g(), c.b()];
            }
        }
        Ok(())
    }
}

/// The colour of an error: black at 0 through red and yellow to white at 1 and above.
pub fn heat(t: f32) -> [u8; 3] {
    let t = t.clamp(0.0, 1.0);
    Vector3::new(3.0 * t, 3.0 * t - 1.0, 3.0 * t - 2.0).map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8).into()
}
