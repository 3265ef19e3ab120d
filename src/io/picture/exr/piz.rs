//! PIZ: values numbered in order, a Haar-like wavelet of integers, Huffman code.

use super::block::Block;
use super::huffman;
use super::input::Input;

/// Bytes of a bit for each 16-bit value.
const BITMAP: usize = 1 << 13;

pub(super) fn decode(block: &Block, bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
    let mut input = Input(bytes);
    let cut = "the block is cut short";
    let (first, last) = (usize::from(input.u16().ok_or(cut)?), usize::from(input.u16().ok_or(cut)?));
    if first >= BITMAP || last >= BITMAP {
        return Err(format!("bytes {first} to {last} of a bit map of {BITMAP}"));
    }
    let mut bitmap = [0; BITMAP];
    if first <= last {
        bitmap[first..=last].copy_from_slice(input.take(last - first + 1).ok_or(cut)?);
    }
    // Zero is a value whatever its bit says.
    bitmap[0] |= 1;
    let mut values: Vec<u16> = (0..=u16::MAX).filter(|&v| bitmap[usize::from(v >> 3)] >> (v & 7) & 1 == 1).collect();
    let largest = values.len() - 1;
    let mut words = huffman::decode(input.sized().ok_or(cut)?, raw.len() / 2)?;

    // Channel after channel; the two halves of a 32-bit sample side by side, but transformed each by itself.
    let mut start = 0;
    for channel in block.channels {
        let halves = channel.samples.size() / 2;
        let plane = &mut words[start..start + halves * block.samples()];
        for half in 0..halves {
            inverse_wavelet(&mut plane[half..], [block.width, block.height], halves, largest < 1 << 14);
        }
        start += halves * block.samples();
    }
    values.resize(1 << 16, 0);
    let mut start = 0;
    let mut at = 0;
    let line_size = block.line_size();
    for channel in block.channels {
        let length = channel.samples.size() / 2 * block.width;
        for y in 0..block.height {
            let line = &words[start + y * length..][..length];
            let out = &mut raw[y * line_size + at..][..2 * length];
            for (out, &word) in out.as_chunks_mut::<2>().0.iter_mut().zip(line) {
                *out = values[usize::from(word)].to_le_bytes();
            }
        }
        start += length * block.height;
        at += 2 * length;
    }
    Ok(())
}

/// A pair from its mean, rounded down, and its difference, where both have at most 14 bits.
fn pair14(mean: u16, difference: u16) -> (u16, u16) {
    let (mean, difference) = (mean.cast_signed(), difference.cast_signed());
    let a = mean.wrapping_add(difference & 1).wrapping_add(difference >> 1);
    (a.cast_unsigned(), a.wrapping_sub(difference).cast_unsigned())
}

/// A pair from its mean and its difference, modulo 2¹⁶ so that neither needs a 17th bit.
fn pair16(mean: u16, difference: u16) -> (u16, u16) {
    let b = mean.wrapping_sub(difference >> 1);
    (difference.wrapping_add(b).wrapping_sub(1 << 15), b)
}

/// Undoes the wavelet of a plane of width × height words that are `step` apart, from the coarsest level to the finest.
///
/// A level with cells of 2p × 2p turns the words at its corners (0, 0), (p, 0), (0, p), (p, p) from a mean and three
/// differences into four means. A column or row that is left over at a level has pairs instead of squares.
fn inverse_wavelet(plane: &mut [u16], [width, height]: [usize; 2], step: usize, small: bool) {
    let pair = if small { pair14 } else { pair16 };
    let at = |x: usize, y: usize| (y * width + x) * step;
    let mut apply = |i: usize, j: usize| (plane[i], plane[j]) = pair(plane[i], plane[j]);
    let shorter = width.min(height);
    let mut p = if shorter < 2 { 0 } else { 1 << (shorter.ilog2() - 1) };
    while p > 0 {
        // What is left of each side beyond the last whole cell, if a pair begins there.
        let (whole_x, whole_y) = (width / (2 * p) * 2 * p, height / (2 * p) * 2 * p);
        for y in (0..whole_y).step_by(2 * p) {
            for x in (0..whole_x).step_by(2 * p) {
                apply(at(x, y), at(x, y + p));
                apply(at(x + p, y), at(x + p, y + p));
                apply(at(x, y), at(x + p, y));
                apply(at(x, y + p), at(x + p, y + p));
            }
            if width & p != 0 {
                apply(at(whole_x, y), at(whole_x, y + p));
            }
        }
        if height & p != 0 {
            for x in (0..whole_x).step_by(2 * p) {
                apply(at(x, whole_y), at(x + p, whole_y));
            }
        }
        p /= 2;
    }
}
