//! The rows of a transport as images.

use super::rows::Rows;
use crate::haar::{Decomposition, Transform2d};
use crate::{Result, parallel};

/// One image of `cells`² pixels a row, column by column: what each cell's radiance is multiplied by.
#[derive(Debug, Clone)]
pub(super) struct PixelRows {
    area: usize,
    pixels: Vec<f32>,
}

impl PixelRows {
    pub(super) fn new(rows: &Rows, cells: usize) -> Result<Self> {
        let (area, transform) = (cells * cells, Transform2d::new(cells, cells, Decomposition::Standard)?);
        let mut pixels = vec![0.0; rows.len() * area];
        let memory = || (vec![0.0; area], vec![0.0; transform.scratch_len()]);
        parallel::chunks(&mut pixels, area, memory, |row, out, (image, work)| {
            image.fill(0.0);
            rows.for_each(row, |i, value| image[i] = value);
            transform.inverse_in_place(image, work);
            let scale = 1.0 / area as f32;
            for (x, column) in out.chunks_exact_mut(cells).enumerate() {
                for (y, out) in column.iter_mut().enumerate() {
                    *out = scale * image[y * cells + x];
                }
            }
        });
        Ok(Self { area, pixels })
    }

    #[inline]
    pub(super) fn of(&self, row: usize) -> &[f32] {
        &self.pixels[row * self.area..][..self.area]
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.pixels.as_slice())
    }
}
