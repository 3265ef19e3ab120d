//! PXR24: floats rounded to 24 bits, differences along a line, planes of bytes, zlib.

use super::block::Block;
use super::deflate::inflate;
use super::header::SampleType;

pub(super) fn decode(block: &Block, bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
    // Of a float the lowest byte is not stored.
    let stored = |samples: SampleType| if samples == SampleType::F32 { 3 } else { samples.size() };
    let size: usize = block.channels.iter().map(|c| stored(c.samples)).sum();
    let mut planes = vec![0; size * block.samples()];
    inflate(bytes, &mut planes)?;
    let (mut planes, mut raw) = (planes.as_slice(), raw);
    for _ in 0..block.height {
        for channel in block.channels {
            let (count, size) = (stored(channel.samples), channel.samples.size());
            let (line, rest) = planes.split_at(count * block.width);
            let (out, rest_of_raw) = std::mem::take(&mut raw).split_at_mut(size * block.width);
            (planes, raw) = (rest, rest_of_raw);
            let mut value = 0_u32;
            for (x, sample) in out.chunks_exact_mut(size).enumerate() {
                // The planes go from the highest byte down; what they hold is moved to the top of the word.
                let difference = (0..count).fold(0, |d, p| d | u32::from(line[p * block.width + x]) << (24 - 8 * p));
                value = value.wrapping_add(difference);
                sample.copy_from_slice(&value.to_le_bytes()[4 - size..]);
            }
        }
    }
    Ok(())
}
