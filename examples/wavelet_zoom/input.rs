//! The picture that is compressed.

use haarmonic::affine::{WaveletImage, ZoomWindow};
use haarmonic::haar::Keep;
use haarmonic::io;

use crate::args::Args;
use crate::picture;
use crate::support::Failure;
use crate::support::environment::{file_name, warn};

/// Planes of red, green and blue as a screen wants them, between 0 and 1.
pub struct Input {
    pub name: String,
    pub side: usize,
    pub planes: [Vec<f32>; 3],
}

impl Input {
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let side = args.side;
        let Some(path) = &args.image else {
            return Ok(Self { name: "built-in street".to_owned(), side, planes: picture::photograph(side) });
        };
        let loaded = io::load_image(path)?;
        loaded.warnings.iter().for_each(warn);
        let image = loaded.value;
        // The largest square in the middle, by area averages: a zoom too.
        let size = [image.width(), image.height()];
        let planes: [Vec<f32>; 3] =
            std::array::from_fn(|c| image.pixels().iter().map(|pixel| encode(pixel[c])).collect());
        let whole = WaveletImage::from_pixels(size, planes.each_ref().map(Vec::as_slice), Keep::Fraction(1.0))?;
        let least = size[0].min(size[1]) as f64;
        let window = ZoomWindow::new([0.5; 2], size.map(|side| side as f64 / least))?;
        Ok(Self { name: file_name(path), side, planes: whole.zoom(window, [side; 2])?.to_pixels() })
    }

    pub fn compressed(&self, keep: Keep) -> Result<WaveletImage<f32, 3>, Failure> {
        let planes = self.planes.each_ref().map(Vec::as_slice);
        Ok(WaveletImage::from_pixels([self.side; 2], planes, keep)?)
    }
}

impl Args {
    /// The centre of the window.
    pub fn centre(&self) -> [f64; 2] {
        match self.at[..] {
            [x, y] => [x, y],
            _ if self.image.is_none() => picture::FACADE,
            _ => [0.5, 0.5],
        }
    }
}

/// Linear light as sRGB has it.
fn encode(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
