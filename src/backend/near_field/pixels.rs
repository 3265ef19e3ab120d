//! The rows of a transport as images.

use pulp::{Arch, Simd, WithSimd};

use super::rows::{Rows, Values};
use crate::haar::{Decomposition, Transform2d};
use crate::{Result, parallel};

/// One image of `cells`² pixels a row, column by column: what each cell's radiance is multiplied by.
///
/// Rows that are stored in 16 bits have images of 16 bits: frames read them all, and memory is what they wait for.
#[derive(Debug, Clone)]
pub(super) struct PixelRows {
    area: usize,
    images: Images,
    arch: Arch,
}

#[derive(Debug, Clone)]
enum Images {
    Full(Vec<f32>),
    /// And a scale a row.
    Bits16(Vec<i16>, Vec<f32>),
}

impl PixelRows {
    pub(super) fn new(rows: &Rows, cells: usize) -> Result<Self> {
        let (area, transform) = (cells * cells, Transform2d::new(cells, cells, Decomposition::Standard)?);
        let memory = || (vec![0.0; area], vec![0.0; area], vec![0.0; transform.scratch_len()]);
        let image = |row: usize, (image, columns, work): &mut (Vec<f32>, Vec<f32>, Vec<f32>)| {
            image.fill(0.0);
            rows.for_each(row, |i, value| image[i] = value);
            transform.inverse_in_place(image, work);
            let scale = 1.0 / area as f32;
            for (i, out) in columns.iter_mut().enumerate() {
                *out = scale * image[i % cells * cells + i / cells];
            }
        };
        let images = match rows.values {
            Values::Full(_) => {
                let mut all = vec![0.0; rows.len() * area];
                parallel::chunks(&mut all, area, memory, |row, out, memory| {
                    image(row, memory);
                    out.copy_from_slice(&memory.1);
                });
                Images::Full(all)
            }
            Values::Bits16(_) => {
                let mut all = vec![(0.0_f32, vec![]); rows.len()];
                parallel::chunks(&mut all, 1, memory, |row, out, memory| {
                    image(row, memory);
                    let largest = memory.1.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
                    // What is not finite stays so, in the scale.
                    let scale = if largest > 0.0 { largest / 32767.0 } else { 1.0 };
                    out[0] = (scale, memory.1.iter().map(|x| (x / scale).round() as i16).collect());
                });
                let mut values = Vec::with_capacity(rows.len() * area);
                all.iter().for_each(|(_, image): &(f32, Vec<i16>)| values.extend_from_slice(image));
                Images::Bits16(values, all.iter().map(|row| row.0).collect())
            }
        };
        Ok(Self { area, images, arch: Arch::new() })
    }

    /// The image of a row but for a factor; `memory`, of one image, may hold it.
    #[inline]
    pub(super) fn of<'a>(&'a self, row: usize, memory: &'a mut [f32]) -> (&'a [f32], f32) {
        let range = row * self.area..(row + 1) * self.area;
        match &self.images {
            Images::Full(images) => (&images[range], 1.0),
            Images::Bits16(images, scales) => {
                self.arch.dispatch(Widen { from: &images[range], to: memory });
                (memory, scales[row])
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match &self.images {
            Images::Full(images) => size_of_val(images.as_slice()),
            Images::Bits16(images, scales) => size_of_val(images.as_slice()) + size_of_val(scales.as_slice()),
        }
    }
}

struct Widen<'a> {
    from: &'a [i16],
    to: &'a mut [f32],
}

impl WithSimd for Widen<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.to.iter_mut().zip(self.from).for_each(|(to, &from)| *to = f32::from(from));
    }
}
