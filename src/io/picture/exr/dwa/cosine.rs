//! Squares of 8 × 8 pixels from their cosine transforms.

use std::sync::LazyLock;

use super::Group;
use crate::io::picture::exr::block::Block;
use crate::io::picture::exr::half;
use crate::io::picture::exr::header::SampleType;

/// What is left of the two streams of coefficients, halves both.
pub(super) struct Coefficients<'a> {
    /// Of a group: the means of all squares of its first channel, then of the next.
    pub(super) means: &'a [[u8; 2]],
    /// Square by square, in it channel by channel, the other coefficients.
    pub(super) waves: &'a [u16],
}

impl Coefficients<'_> {
    /// Decodes the squares of a group of channels into the lines of a block.
    pub(super) fn decode(&mut self, block: &Block, group: &Group, raw: &mut [u8]) -> Result<(), String> {
        let (across, down) = (block.width.div_ceil(8), block.height.div_ceil(8));
        let starts = block.channel_starts();
        let line_size = block.line_size();
        let count = group.channels.len();
        let mut squares = [[0.0; 64]; 3];
        for i in 0..across * down {
            for (c, square) in squares.iter_mut().enumerate().take(count) {
                *square = self.square(u16::from_le_bytes(self.means[c * across * down + i]))?;
            }
            if count == 3 {
                undo_luma(&mut squares);
            }
            let (x, y) = (i % across * 8, i / across * 8);
            for (square, &channel) in squares.iter().zip(&group.channels) {
                let samples = block.channels[channel].samples;
                for (row, line) in square.as_chunks::<8>().0.iter().zip(raw.chunks_exact_mut(line_size).skip(y)) {
                    let start = starts[channel] + samples.size() * x;
                    let out = &mut line[start..][..samples.size() * (block.width - x).min(8)];
                    for (out, &value) in out.chunks_exact_mut(samples.size()).zip(row) {
                        let stored = half::from_f32(value);
                        let sample = if group.curved { LINEAR[usize::from(stored)] } else { stored };
                        if samples == SampleType::Half {
                            out.copy_from_slice(&sample.to_le_bytes());
                        } else {
                            out.copy_from_slice(&half::to_f32(sample).to_le_bytes());
                        }
                    }
                }
            }
        }
        self.means = &self.means[count * across * down..];
        Ok(())
    }

    /// The next square: its coefficients, transformed.
    fn square(&mut self, mean: u16) -> Result<[f32; 64], String> {
        let mut square = [0.0; 64];
        square[0] = half::to_f32(mean);
        // 0xff00 + n: n zeros; 0xff00: zeros to the end. As halves these would be NaN.
        let (mut at, mut flat) = (1, true);
        while at < 64 {
            let (&wave, rest) = self.waves.split_first().ok_or("the coefficients end too early")?;
            self.waves = rest;
            match wave {
                0xff00 => break,
                0xff01.. => at += usize::from(wave & 0xff),
                _ => {
                    square[ZIG_ZAG[at]] = half::to_f32(wave);
                    flat = false;
                    at += 1;
                }
            }
        }
        if flat {
            square = [square[0] * BASIS[0] * BASIS[0]; 64];
        } else {
            inverse_cosine(&mut square);
        }
        Ok(square)
    }
}

/// Where the coefficients of a square are, row by row, in the order of the diagonals that the file has them in.
const ZIG_ZAG: [usize; 64] = {
    let mut order = [0; 64];
    let (mut x, mut y, mut i) = (0, 0, 0);
    while i < 64 {
        order[i] = 8 * y + x;
        // Even diagonals go up, odd ones down; at an edge, one step along it.
        let up = (x + y) % 2 == 0;
        (x, y) = match (up, x, y) {
            (true, 7, _) => (x, y + 1),
            (true, _, 0) => (x + 1, y),
            (true, ..) => (x + 1, y - 1),
            (false, _, 7) => (x + 1, y),
            (false, 0, _) => (x, y + 1),
            (false, ..) => (x - 1, y + 1),
        };
        i += 1;
    }
    order
};

/// The π of OpenEXR's own decoder. It makes the means of squares 7 · 10⁻⁷ too large along either side, which the curve
/// takes to 3 · 10⁻⁶ of the picture's mean: small, but what everybody else reads.
#[expect(clippy::approx_constant, reason = "the format's constant")]
const PI: f64 = 3.14159;

/// ½ cos(kπ/16), of k = 4 for the mean too: ½ · √½.
static BASIS: LazyLock<[f32; 8]> = LazyLock::new(|| {
    let basis = |k: usize| if k == 0 { 4 } else { k } as f64 * PI / 16.0;
    std::array::from_fn(|k| (0.5 * basis(k).cos()) as f32)
});

/// The orthonormal inverse cosine transform of 8 × 8 values, rows first: x_i = Σ_k X_k b_k cos((2i + 1) kπ/16).
///
/// By halves: x_i and x_(7−i) share the sum over even k and differ in the sign of that over odd k.
fn inverse_cosine(square: &mut [f32; 64]) {
    let basis = *BASIS;
    let [mean, b1, b2, b3, _, b5, b6, b7] = basis;
    let mut transform = |start: usize, step: usize| {
        let at = |k: usize| start + step * k;
        let x: [f32; 8] = std::array::from_fn(|k| square[at(k)]);
        let (sum, difference) = (mean * (x[0] + x[4]), mean * (x[0] - x[4]));
        let (outer, inner) = (b2 * x[2] + b6 * x[6], b6 * x[2] - b2 * x[6]);
        let even = [sum + outer, difference + inner, difference - inner, sum - outer];
        let odd = [
            b1 * x[1] + b3 * x[3] + b5 * x[5] + b7 * x[7],
            b3 * x[1] - b7 * x[3] - b1 * x[5] - b5 * x[7],
            b5 * x[1] - b1 * x[3] + b7 * x[5] + b3 * x[7],
            b7 * x[1] - b5 * x[3] + b3 * x[5] - b1 * x[7],
        ];
        for i in 0..4 {
            square[at(i)] = even[i] + odd[i];
            square[at(7 - i)] = even[i] - odd[i];
        }
    };
    (0..8).for_each(|row| transform(8 * row, 1));
    (0..8).for_each(|column| transform(column, 8));
}

/// Red, green and blue from luma and the chromas of blue and red (those of Rec. 709, around 0).
fn undo_luma([first, second, third]: &mut [[f32; 64]; 3]) {
    for ((a, b), c) in first.iter_mut().zip(second).zip(third) {
        let (luma, blue, red) = (*a, *b, *c);
        *a = luma + 1.5747 * red;
        *b = luma - 0.1873 * blue - 0.4682 * red;
        *c = luma + 1.8556 * blue;
    }
}

/// By the bits of a stored half x: the half nearest to |x|^2.2 up to 1, to exp(2.2 (|x| − 1)) beyond, with x's sign; 0
/// for what is not finite.
static LINEAR: LazyLock<Box<[u16]>> = LazyLock::new(|| {
    let linear = |bits: u16| {
        let x = f64::from(half::to_f32(bits));
        let magnitude = if x.abs() <= 1.0 { x.abs().powf(2.2) } else { (2.2 * (x.abs() - 1.0)).exp() };
        if x.is_finite() { half::from_f32(magnitude.copysign(x) as f32) } else { 0 }
    };
    (0..=u16::MAX).map(linear).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_cosine_is_the_definition() {
        let mut state = 1_u32;
        let coefficients: [f32; 64] = std::array::from_fn(|_| {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as f32 / 8388608.0 - 1.0
        });
        let basis = |k: usize, i: usize| {
            let scale = if k == 0 { 0.125f64.sqrt() } else { 0.5 };
            scale * ((2 * i + 1) as f64 * k as f64 * std::f64::consts::PI / 16.0).cos()
        };
        let mut got = coefficients;
        inverse_cosine(&mut got);
        for y in 0..8 {
            for x in 0..8 {
                let expected: f64 =
                    (0..64).map(|k| f64::from(coefficients[k]) * basis(k / 8, y) * basis(k % 8, x)).sum();
                // The format's π is 2.7e-6 too small: a cosine of up to 7π/16 is off by 1.2e-6 in each of two sums of 8
                // terms of either sign.
                assert!((f64::from(got[8 * y + x]) - expected).abs() < 1e-5, "({x}, {y})");
            }
        }
    }

    #[test]
    fn zig_zag_begins_and_ends_as_in_jpeg() {
        assert_eq!(ZIG_ZAG[..10], [0, 1, 8, 16, 9, 2, 3, 10, 17, 24]);
        assert_eq!(ZIG_ZAG[60..], [47, 55, 62, 63]);
        let mut sorted = ZIG_ZAG;
        sorted.sort_unstable();
        assert_eq!(sorted, std::array::from_fn(|i| i));
    }
}
