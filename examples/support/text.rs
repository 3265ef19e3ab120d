//! Text in pictures: one font for all of them, from the files beside this one, so that every machine draws the same
//! pixels.

use ab_glyph::{Font, FontRef, GlyphId, PxScale, ScaleFont, point};

/// DejaVu Sans, the characters that examples use; `font/README.md` says how it was made.
pub const REGULAR: &[u8] = include_bytes!("font/DejaVuSans.ttf");
/// The same, bold.
pub const BOLD: &[u8] = include_bytes!("font/DejaVuSans-Bold.ttf");

/// Height of a capital letter over the size of the font.
pub const CAPITAL: f32 = 0.73;

/// A weight and a size: pixels of an em.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Type {
    pub bold: bool,
    pub size: f32,
}

impl Type {
    /// The usual weight.
    pub fn new(size: f32) -> Self {
        Self { bold: false, size }
    }

    /// The weight of titles.
    pub fn bold(size: f32) -> Self {
        Self { bold: true, size }
    }

    /// Pixels from one line of text to the next.
    pub fn line(self) -> usize {
        (1.3 * self.size).round() as usize
    }

    fn font(self) -> FontRef<'static> {
        FontRef::try_from_slice(if self.bold { BOLD } else { REGULAR }).expect("the font files are part of the program")
    }

    /// Calls `glyph` with every character's outline and its place along the line; returns the width in pixels.
    fn layout(self, text: &str, mut glyph: impl FnMut(&FontRef<'_>, GlyphId, PxScale, [f32; 2])) -> f32 {
        let font = self.font();
        let em = font.units_per_em().expect("the font says its units");
        let scale = PxScale::from(self.size * font.height_unscaled() / em);
        let scaled = font.as_scaled(scale);
        let (mut x, mut last) = (0.0, ' ');
        for c in text.chars() {
            let id = font.glyph_id(c);
            // A combining sign is made for letters as high as x; over an f it sits higher.
            let lift = if c == '\u{302}' && last == 'f' { 0.2 * self.size } else { 0.0 };
            glyph(&font, id, scale, [x, -lift]);
            x += scaled.h_advance(id);
            last = c;
        }
        x
    }

    /// Width of a line of text in pixels.
    pub fn width(self, text: &str) -> f32 {
        self.layout(text, |_, _, _, _| ())
    }

    /// Calls `pixel(x, y, coverage)` for what the text covers; its baseline begins at (0, 0), y points down.
    pub fn draw(self, text: &str, mut pixel: impl FnMut(i32, i32, f32)) {
        self.layout(text, |font, id, scale, [x, y]| {
            let Some(outline) = font.outline_glyph(id.with_scale_and_position(scale, point(x, y))) else { return };
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, c| pixel(corner.x as i32 + dx as i32, corner.y as i32 + dy as i32, c.min(1.0)));
        });
    }

    /// The text in lines that are no wider than `width` pixels, broken at spaces.
    pub fn wrap(self, text: &str, width: usize) -> Vec<String> {
        let mut lines = vec![String::new()];
        for word in text.split(' ') {
            let line = lines.last_mut().expect("never empty");
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if line.is_empty() || self.width(&longer) <= width as f32 {
                *line = longer;
            } else {
                lines.push(word.to_owned());
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_has_the_size_that_it_says() {
        // The letter H: as high as the capitals of the font, standing on the baseline.
        let (mut top, mut bottom) = (i32::MAX, i32::MIN);
        Type::new(100.0).draw("H", |_, y, share| {
            if share > 0.5 {
                (top, bottom) = (top.min(y), bottom.max(y));
            }
        });
        assert!((bottom + 1).abs() <= 1 && (-top - (100.0 * CAPITAL) as i32).abs() <= 1, "{top} {bottom}");
        let font = Type::new(20.0);
        assert!((font.width("ab") - font.width("a") - font.width("b")).abs() < 1e-3);
        assert_eq!(font.wrap("one two", 1), ["one", "two"]);
        assert_eq!(font.wrap("one two", 1000), ["one two"]);
    }

    #[test]
    fn the_font_has_what_examples_write() {
        for font in [Type::new(10.0), Type::bold(10.0)] {
            for c in "abcXYZ0189 −×·²³⁰¹⁴⁵⁶⁷⁸⁹⁻₂≤≥≠≈∫ψµ‖|½\u{302}\u{a0}".chars()
            {
                assert_ne!(font.font().glyph_id(c), GlyphId(0), "{c}");
            }
        }
    }
}
