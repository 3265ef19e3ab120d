//! What plotters draws on: a sheet three times as fine, averaged at the end; text comes from our own font.

use std::convert::Infallible;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle};

use super::sheet::Sheet;
use super::text::{CAPITAL, Type};

/// Subpixels along a side.
pub const FINE: i32 = 3;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// The fine picture.
pub struct Canvas<'a> {
    pub fine: &'a mut Sheet,
}

fn font<S: BackendTextStyle>(style: &S) -> Type {
    Type { bold: matches!(style.style(), FontStyle::Bold), size: style.size() as f32 }
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.fine.width as u32, self.fine.height as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        let (r, g, b) = colour.rgb;
        self.fine.mix([x, y], [r, g, b], colour.alpha as f32);
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let font = font(style);
        Ok((font.width(text).ceil() as u32, font.size.ceil() as u32))
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let (font, anchor, turn, colour) = (font(style), style.anchor(), style.transform(), style.color());
        let left = match anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * font.width(text),
            HPos::Right => -font.width(text),
        };
        // The box goes from the top of the capitals and a little more to the bottom of letters such as g.
        let baseline = match anchor.v_pos {
            VPos::Top => 0.8,
            VPos::Center => 0.5 * CAPITAL,
            VPos::Bottom => -0.24,
        };
        let (left, baseline) = (left.round() as i32, (baseline * font.size).round() as i32);
        let (r, g, b) = colour.rgb;
        font.draw(text, |x, y, share| {
            let (x, y) = turn.transform(x + left, y + baseline);
            self.fine.mix([at.0 + x, at.1 + y], [r, g, b], share * colour.alpha as f32);
        });
        Ok(())
    }
}

/// The mean of each square of FINE × FINE pixels.
pub fn shrink(fine: &Sheet) -> Sheet {
    let k = FINE as usize;
    let size = [fine.width / k, fine.height / k];
    let mut sheet = Sheet::blank(size, [0; 3]);
    for (i, pixel) in sheet.pixels.iter_mut().enumerate() {
        let (x, y) = (i % size[0] * k, i / size[0] * k);
        let square = (0..k * k).map(|s| fine.pixels[(y + s / k) * fine.width + x + s % k]);
        let sums = square.fold([0usize; 3], |sums, p| std::array::from_fn(|c| sums[c] + usize::from(p[c])));
        *pixel = sums.map(|sum| ((sum + k * k / 2) / (k * k)) as u8);
    }
    sheet
}
