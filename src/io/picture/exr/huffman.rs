//! The canonical Huffman code of 16-bit symbols that PIZ and DWA share.
//!
//! Codes have up to 58 bits; longer ones are the smaller numbers. The last symbol of the table is none: it repeats the
//! symbol before it as often as the 8 bits after it say.

use super::input::Input;

/// The most bits of a code.
const LONGEST: usize = 58;
/// Codes up to this length are looked up at once. 4096 entries fit the first-level cache.
const FAST: usize = 12;
/// Symbols: 2¹⁶ values and the one that repeats.
const SYMBOLS: u32 = (1 << 16) + 1;

/// Decodes exactly `count` symbols.
///
/// # Errors
/// What is wrong with the bytes, in words.
pub(super) fn decode(bytes: &[u8], count: usize) -> Result<Vec<u16>, String> {
    let mut input = Input(bytes);
    let mut number = || input.u32().ok_or("the Huffman code is cut short");
    let (first, last, _, bits, _) = (number()?, number()?, number()?, number()?, number()?);
    if first > last || last >= SYMBOLS {
        return Err(format!("the Huffman table goes from symbol {first} to {last}"));
    }
    let mut lengths = Bits { bytes: input.0, at: 0, end: 8 * input.0.len() };
    let table = Table::read(&mut lengths, first, last)?;
    let bytes = &input.0[lengths.at.div_ceil(8)..];
    let bits = bits as usize;
    if bits > 8 * bytes.len() {
        return Err("the Huffman code is cut short".into());
    }
    // Each symbol has a bit at least, and 255 more with the 8 bits that repeat it.
    if count / 256 > bits {
        return Err(format!("{bits} bits of Huffman code cannot hold {count} values"));
    }
    table.decode(Bits { bytes, at: 0, end: bits }, last, count)
}

/// Bits from the highest of each byte down.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
}

impl Bits<'_> {
    /// The next 64 bits; beyond the last byte there are zeros.
    fn window(&self) -> u64 {
        let mut next = [0; 9];
        let (byte, shift) = (self.at / 8, self.at % 8);
        let rest = self.bytes.get(byte..).unwrap_or(&[]);
        if let Some(chunk) = rest.first_chunk() {
            next = *chunk;
        } else {
            next[..rest.len()].copy_from_slice(rest);
        }
        let [high @ .., low] = next;
        u64::from_be_bytes(high) << shift | u64::from(low) >> (8 - shift)
    }

    fn skip(&mut self, n: usize) -> Option<()> {
        self.at += n;
        (self.at <= self.end).then_some(())
    }

    fn take(&mut self, n: usize) -> Option<usize> {
        let value = self.window() >> (64 - n);
        self.skip(n)?;
        Some(value as usize)
    }
}

struct Table {
    /// By the next 12 bits: symbol · 64 + length, 0 where the code is longer.
    fast: Vec<u32>,
    /// Per length the first code, and how many there are.
    codes: [(u64, u64); LONGEST + 1],
    /// Per length where its symbols begin in `symbols`.
    starts: [usize; LONGEST + 1],
    /// By length, then by value.
    symbols: Vec<u32>,
}

impl Table {
    /// Reads the lengths of the codes of the symbols `first..=last` and numbers the codes.
    fn read(bits: &mut Bits, first: u32, last: u32) -> Result<Self, String> {
        let mut lengths = vec![0_u8; (last - first + 1) as usize];
        let mut at = 0;
        while at < lengths.len() {
            let cut = "the Huffman table is cut short";
            // 6 bits: a length, or 2 … 5 symbols without a code, or, with 8 bits more, 6 … 261 of them.
            let run = match bits.take(6).ok_or(cut)? {
                63 => bits.take(8).ok_or(cut)? + 6,
                n @ 59.. => n - 57,
                length => {
                    lengths[at] = length as u8;
                    at += 1;
                    continue;
                }
            };
            if run > lengths.len() - at {
                return Err("the Huffman table is longer than its symbols".into());
            }
            at += run;
        }
        let mut codes = [(0, 0); LONGEST + 1];
        for &length in &lengths {
            codes[usize::from(length)].1 += 1;
        }
        codes[0] = (0, 0);
        // From the longest: half of the numbers used up at a length, by codes and by what is longer, are used up at the
        // next shorter one. Were one left over, it would be the beginning of a longer code and a code of its own.
        let mut used = 0_u64;
        for (length, code) in codes.iter_mut().enumerate().skip(1).rev() {
            code.0 = used;
            used += code.1;
            if length > 1 && used % 2 == 1 || length == 1 && used > 2 {
                return Err("the Huffman table is no prefix code".into());
            }
            used /= 2;
        }
        let mut starts = [0; LONGEST + 1];
        for length in 1..LONGEST {
            starts[length + 1] = starts[length] + codes[length].1 as usize;
        }
        let mut symbols = vec![0; starts[LONGEST] + codes[LONGEST].1 as usize];
        let mut fast = vec![0; 1 << FAST];
        let mut next = starts;
        for (symbol, &length) in (first..).zip(&lengths).filter(|(_, length)| **length > 0) {
            let length = usize::from(length);
            let index = next[length] - starts[length];
            symbols[next[length]] = symbol;
            next[length] += 1;
            if length <= FAST {
                let code = codes[length].0 as usize + index;
                fast[code << (FAST - length)..(code + 1) << (FAST - length)].fill(symbol << 6 | length as u32);
            }
        }
        Ok(Self { fast, codes, starts, symbols })
    }

    /// The symbol whose code begins a window of bits, and the code's length.
    fn symbol(&self, window: u64) -> Option<(u32, usize)> {
        let entry = self.fast[(window >> (64 - FAST)) as usize];
        if entry != 0 {
            return Some((entry >> 6, (entry & 63) as usize));
        }
        (FAST + 1..=LONGEST).find_map(|length| {
            let (first, count) = self.codes[length];
            let index = (window >> (64 - length)).checked_sub(first).filter(|i| *i < count)?;
            Some((self.symbols[self.starts[length] + index as usize], length))
        })
    }

    fn decode(&self, mut bits: Bits, repeat: u32, count: usize) -> Result<Vec<u16>, String> {
        let mut out: Vec<u16> = Vec::with_capacity(count);
        let cut = "the Huffman code is cut short";
        while out.len() < count {
            let (symbol, length) = self.symbol(bits.window()).ok_or("a Huffman code that is not in the table")?;
            bits.skip(length).ok_or(cut)?;
            if symbol == repeat {
                let n = bits.take(8).ok_or(cut)?;
                let value = *out.last().ok_or("a Huffman run before any value")?;
                if n > count - out.len() {
                    return Err(format!("a Huffman run of {n} values where {} are left", count - out.len()));
                }
                out.resize(out.len() + n, value);
            } else {
                // The one symbol beyond 16 bits is the last of the largest table, which repeats.
                out.push(symbol as u16);
            }
        }
        Ok(out)
    }
}
