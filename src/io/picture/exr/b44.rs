//! B44 and B44A: halves in squares of 4 × 4 pixels, as one value and 15 differences of 6 bits; other samples as they
//! are.

use std::sync::LazyLock;

use super::block::Block;
use super::half;
use super::header::SampleType;
use super::input::Input;

pub(super) fn decode(block: &Block, bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
    let mut input = Input(bytes);
    let cut = "the block is cut short";
    let line_size = block.line_size();
    for (channel, start) in block.channels.iter().zip(block.channel_starts()) {
        let size = channel.samples.size();
        if channel.samples != SampleType::Half {
            for y in 0..block.height {
                let line = input.take(size * block.width).ok_or(cut)?;
                raw[y * line_size + start..][..line.len()].copy_from_slice(line);
            }
            continue;
        }
        for y in (0..block.height).step_by(4) {
            for x in (0..block.width).step_by(4) {
                let mut square = square(&mut input).ok_or(cut)?;
                if channel.linear {
                    square = square.map(|row| row.map(|half| LOG[usize::from(half)]));
                }
                let columns = (block.width - x).min(4);
                for (i, row) in square.iter().enumerate().take(block.height - y) {
                    let out = &mut raw[(y + i) * line_size + start + size * x..][..size * columns];
                    for (out, half) in out.as_chunks_mut::<2>().0.iter_mut().zip(row) {
                        *out = half.to_le_bytes();
                    }
                }
            }
        }
    }
    Ok(())
}

/// The rows of a square, the first of which may be all that the picture has.
fn square(input: &mut Input) -> Option<[[u16; 4]; 4]> {
    let [high, low, shift] = input.array()?;
    let first = u16::from_be_bytes([high, low]);
    // A shift of 13 and more would leave no difference: all values are the same.
    if shift >= 13 << 2 {
        return Some([[unordered(first); 4]; 4]);
    }
    // The shift has the upper 6 bits of its byte, the differences the 90 bits that follow them.
    let rest: [u8; 11] = input.array()?;
    let bits = rest.iter().fold(u128::from(shift & 3), |bits, &b| bits << 8 | u128::from(b));
    let shift = shift >> 2;
    let mut differences = (0..15).rev().map(|i| ((bits >> (6 * i)) & 63) as u16);
    // Differences are stored plus 32, so that none is negative; a sum that leaves 16 bits comes from damage.
    let mut next = |from: u16| {
        let difference = differences.next().unwrap_or(32);
        from.wrapping_add(difference << shift).wrapping_sub(32 << shift)
    };
    // Down the first column, then from each column to the right.
    let mut square = [[first; 4]; 4];
    for y in 1..4 {
        square[y][0] = next(square[y - 1][0]);
    }
    for x in 1..4 {
        for row in &mut square {
            row[x] = next(row[x - 1]);
        }
    }
    Some(square.map(|row| row.map(unordered)))
}

/// A half from the code whose order as a number is that of the halves: the upper half of the codes is positive.
fn unordered(code: u16) -> u16 {
    if code & 0x8000 != 0 { code & 0x7fff } else { !code }
}

/// By the bits of a half x: 8 ln x, to the nearest half; 0 for what is negative or not finite. Writers store exp(x / 8)
/// of samples that are linear for the eye: of logarithms.
static LOG: LazyLock<Box<[u16]>> = LazyLock::new(|| {
    let log = |bits: u16| {
        let x = f64::from(half::to_f32(bits));
        if x.is_finite() && x >= 0.0 { half::from_f32((8.0 * x.ln()) as f32) } else { 0 }
    };
    (0..=u16::MAX).map(log).collect()
});
