//! DWAA and DWAB: colours as quantised cosine transforms of 8 × 8 pixels, alpha in runs, other channels by zlib.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::block::Block;
use super::deflate::{inflate, undo_prediction, undo_runs};
use super::header::SampleType;
use super::input::Input;
use super::{half, huffman};

/// How a channel is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scheme {
    Zlib,
    Cosines,
    Runs,
}

/// Which scheme the channels of a name and type have.
#[derive(Debug, Clone, Copy)]
struct Rule<'a> {
    /// The part of a channel's name after its last dot.
    suffix: &'a [u8],
    samples: SampleType,
    scheme: Scheme,
    /// Whether this is the red, green or blue of three that are stored as luma and two chromas.
    colour: Option<usize>,
    ignores_case: bool,
}

pub(super) fn decode(block: &Block, bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
    let mut input = Input(bytes);
    let sizes = Sizes::read(&mut input)?;
    let rules = if sizes.version < 2 { old_rules() } else { read_rules(&mut input)? };
    let schemes = schemes(block, &rules);
    let groups = groups(block, &rules, &schemes)?;
    let samples = block.samples();
    let bytes_of = |scheme: Scheme| -> usize {
        let channels = block.channels.iter().zip(&schemes).filter(|(_, s)| **s == scheme);
        samples * channels.map(|(c, _)| c.samples.size()).sum::<usize>()
    };
    let squares = block.width.div_ceil(8) * block.height.div_ceil(8);
    let transformed = squares * groups.iter().map(|g| g.channels.len()).sum::<usize>();
    // What each section must hold, from the picture's size: nothing is taken for what a block merely says.
    let exact = [
        ("bytes of zlib", sizes.zlib_raw, bytes_of(Scheme::Zlib)),
        ("bytes of runs", sizes.runs_raw, bytes_of(Scheme::Runs)),
        ("means of squares", sizes.means, transformed),
    ];
    for (what, got, expected) in exact {
        if got != expected {
            return Err(format!("{got} {what} where {expected} are needed"));
        }
    }
    // A square has 63 coefficients besides its mean; a run of n ≥ 1 bytes takes at most n + 1.
    for (what, got, most) in
        [("coefficients", sizes.waves, 63 * transformed), ("bytes of runs", sizes.runs, 2 * sizes.runs_raw)]
    {
        if got > most {
            return Err(format!("{got} {what} where at most {most} can be"));
        }
    }
    let cut = "the block is cut short";
    let mut section = |n: usize| input.take(n).ok_or(cut);
    let [zlib, waves, means, runs] =
        [section(sizes.zlib)?, section(sizes.packed_waves)?, section(sizes.packed_means)?, section(sizes.packed_runs)?];

    if sizes.zlib_raw > 0 {
        let mut planes = vec![0; sizes.zlib_raw];
        inflate(zlib, &mut planes)?;
        copy_planes(block, &schemes, &planes, raw);
    }
    if sizes.runs_raw > 0 {
        let mut packed = vec![0; sizes.runs];
        inflate(runs, &mut packed)?;
        let mut planes = vec![0; sizes.runs_raw];
        undo_runs(&packed, &mut planes)?;
        copy_byte_planes(block, &schemes, &planes, raw);
    }
    if transformed > 0 {
        let mut differences = vec![0; 2 * sizes.means];
        inflate(means, &mut differences)?;
        let mut means = vec![0; differences.len()];
        undo_prediction(&mut differences, &mut means);
        let waves = if sizes.waves == 0 {
            Vec::new()
        } else if sizes.huffman {
            huffman::decode(waves, sizes.waves)?
        } else {
            let mut bytes = vec![0; 2 * sizes.waves];
            inflate(waves, &mut bytes)?;
            bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect()
        };
        let mut stream = Coefficients { means: means.as_chunks().0, waves: &waves };
        for group in &groups {
            stream.decode(block, group, raw)?;
        }
    }
    Ok(())
}

/// The eleven numbers at the head of a block.
struct Sizes {
    version: usize,
    zlib_raw: usize,
    zlib: usize,
    packed_waves: usize,
    packed_means: usize,
    packed_runs: usize,
    runs: usize,
    runs_raw: usize,
    waves: usize,
    means: usize,
    /// Whether coefficients are Huffman-coded; else they are zlib-compressed.
    huffman: bool,
}

impl Sizes {
    fn read(input: &mut Input) -> Result<Self, String> {
        let mut number = || input.size().ok_or("the head of the block is cut short or has sizes beyond all memory");
        Ok(Self {
            version: number()?,
            zlib_raw: number()?,
            zlib: number()?,
            packed_waves: number()?,
            packed_means: number()?,
            packed_runs: number()?,
            runs: number()?,
            runs_raw: number()?,
            waves: number()?,
            means: number()?,
            huffman: match number()? {
                0 => true,
                1 => false,
                n => return Err(format!("code number {n} of the coefficients is not known")),
            },
        })
    }
}

/// The rules of a block of version 2: their size with its own two bytes, then name, flags and type of each.
fn read_rules<'a>(input: &mut Input<'a>) -> Result<Vec<Rule<'a>>, String> {
    let wrong = || "the rules of the channels are damaged".to_owned();
    let size = input.u16().and_then(|n| usize::from(n).checked_sub(2));
    let mut input = Input(size.and_then(|n| input.take(n)).ok_or_else(wrong)?);
    let mut rules = Vec::new();
    // Writers have some 25; each is compared with each channel.
    while !input.0.is_empty() && rules.len() < 256 {
        let (suffix, flags, samples) = (input.name(), input.u8(), input.u8());
        let (Some(suffix), Some(flags), Some(samples)) = (suffix, flags, samples) else { return Err(wrong()) };
        rules.push(Rule {
            suffix,
            samples: SampleType::of(samples.into()).ok_or_else(wrong)?,
            scheme: match flags >> 2 & 3 {
                0 => Scheme::Zlib,
                1 => Scheme::Cosines,
                2 => Scheme::Runs,
                _ => return Err(wrong()),
            },
            colour: match flags >> 4 {
                0 => None,
                n @ 1..=3 => Some(usize::from(n) - 1),
                _ => return Err(wrong()),
            },
            ignores_case: flags & 1 != 0,
        });
    }
    Ok(rules)
}

/// What blocks before version 2 take for granted.
fn old_rules() -> Vec<Rule<'static>> {
    let colours: [(&[u8], Option<usize>); 11] = [
        (b"r", Some(0)),
        (b"red", Some(0)),
        (b"g", Some(1)),
        (b"grn", Some(1)),
        (b"green", Some(1)),
        (b"b", Some(2)),
        (b"blu", Some(2)),
        (b"blue", Some(2)),
        (b"y", None),
        (b"by", None),
        (b"ry", None),
    ];
    let colours = colours.into_iter().flat_map(|(suffix, colour)| {
        let rule = move |samples| Rule { suffix, samples, scheme: Scheme::Cosines, colour, ignores_case: true };
        [SampleType::Half, SampleType::F32].map(rule)
    });
    let alpha = [SampleType::U32, SampleType::Half, SampleType::F32];
    colours
        .chain(alpha.map(|samples| Rule {
            suffix: b"a",
            samples,
            scheme: Scheme::Runs,
            colour: None,
            ignores_case: true,
        }))
        .collect()
}

impl Rule<'_> {
    fn fits(&self, suffix: &[u8], samples: SampleType) -> bool {
        let same = if self.ignores_case { suffix.eq_ignore_ascii_case(self.suffix) } else { suffix == self.suffix };
        same && samples == self.samples
    }
}

/// A channel's name up to its last dot, and the rest.
fn split_name(name: &str) -> (&str, &str) {
    name.split_at(name.rfind('.').map_or(0, |dot| dot + 1))
}

/// Of each channel the scheme; the last rule that fits counts.
fn schemes(block: &Block, rules: &[Rule]) -> Vec<Scheme> {
    let scheme = |name: &str, samples| {
        let suffix = split_name(name).1.as_bytes();
        rules.iter().rfind(|r| r.fits(suffix, samples)).map_or(Scheme::Zlib, |r| r.scheme)
    };
    block.channels.iter().map(|c| scheme(&c.name, c.samples)).collect()
}

/// Channels whose squares follow each other in the streams of coefficients: red, green and blue, or one alone.
struct Group {
    channels: Vec<usize>,
    /// Whether values above 1 are logarithms and those below 2.2th roots.
    curved: bool,
}

/// First the triples of one prefix each, by the prefixes' first appearance, then what is left over, by channel.
fn groups(block: &Block, rules: &[Rule], schemes: &[Scheme]) -> Result<Vec<Group>, String> {
    let mut triples: Vec<(&str, [Option<usize>; 3])> = Vec::new();
    for (i, channel) in block.channels.iter().enumerate() {
        let (prefix, suffix) = split_name(&channel.name);
        let known = triples.iter().position(|(p, _)| *p == prefix);
        let known = known.unwrap_or_else(|| {
            triples.push((prefix, [None; 3]));
            triples.len() - 1
        });
        for rule in rules.iter().filter(|r| r.fits(suffix.as_bytes(), channel.samples)) {
            if let Some(colour) = rule.colour {
                triples[known].1[colour] = Some(i);
            }
        }
    }
    let cosines = |i: usize| schemes[i] == Scheme::Cosines;
    let mut groups = Vec::new();
    let mut grouped = vec![false; schemes.len()];
    for (_, triple) in triples {
        if let [Some(r), Some(g), Some(b)] = triple
            && [r, g, b].into_iter().all(cosines)
        {
            // Rules that name one channel twice make no triple of it.
            if r == g || g == b || b == r {
                return Err("the rules of the channels are damaged".into());
            }
            [r, g, b].into_iter().for_each(|i| grouped[i] = true);
            groups.push(Group { channels: vec![r, g, b], curved: true });
        }
    }
    for (i, channel) in block.channels.iter().enumerate() {
        if cosines(i) && channel.samples == SampleType::U32 {
            return Err("32-bit integers as cosine transforms cannot be read".into());
        }
        if cosines(i) && !grouped[i] {
            groups.push(Group { channels: vec![i], curved: !channel.linear });
        }
    }
    Ok(groups)
}

/// Puts the channels that zlib alone compresses, one after the other, into their lines.
fn copy_planes(block: &Block, schemes: &[Scheme], mut planes: &[u8], raw: &mut [u8]) {
    for (i, start) in block.channel_starts().into_iter().enumerate().filter(|(i, _)| schemes[*i] == Scheme::Zlib) {
        let length = block.width * block.channels[i].samples.size();
        let (plane, rest) = planes.split_at(length * block.height);
        planes = rest;
        for (line, out) in plane.chunks_exact(length).zip(raw.chunks_exact_mut(block.line_size())) {
            out[start..][..length].copy_from_slice(line);
        }
    }
}

/// Puts the channels in runs into their lines: of each first the lowest bytes of all samples, then the next ones.
fn copy_byte_planes(block: &Block, schemes: &[Scheme], mut planes: &[u8], raw: &mut [u8]) {
    let line_size = block.line_size();
    for (i, start) in block.channel_starts().into_iter().enumerate().filter(|(i, _)| schemes[*i] == Scheme::Runs) {
        let size = block.channels[i].samples.size();
        for byte in 0..size {
            let (plane, rest) = planes.split_at(block.samples());
            planes = rest;
            for (line, out) in plane.chunks_exact(block.width).zip(raw.chunks_exact_mut(line_size)) {
                let out = out[start + byte..].iter_mut().step_by(size);
                out.zip(line).for_each(|(out, &b)| *out = b);
            }
        }
    }
}

/// What is left of the two streams of coefficients, halves both.
struct Coefficients<'a> {
    /// Of a group: the means of all squares of its first channel, then of the next.
    means: &'a [[u8; 2]],
    /// Square by square, in it channel by channel, the other coefficients.
    waves: &'a [u16],
}

impl Coefficients<'_> {
    fn decode(&mut self, block: &Block, group: &Group, raw: &mut [u8]) -> Result<(), String> {
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

/// By the bits of a stored half x: the half nearest to |x|^2.2 up to 1, to exp(2.2 (|x| − 1)) beyond, with x's sign; 0 for
/// what is not finite.
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
            scale * ((2 * i + 1) as f64 * k as f64 * PI / 16.0).cos()
        };
        let mut got = coefficients;
        inverse_cosine(&mut got);
        for y in 0..8 {
            for x in 0..8 {
                let expected: f64 =
                    (0..64).map(|k| f64::from(coefficients[k]) * basis(k / 8, y) * basis(k % 8, x)).sum();
                // Sums of 8 terms of up to ½, twice: some 16 roundings of numbers up to 8, measured 4e-7.
                assert!((f64::from(got[8 * y + x]) - expected).abs() < 2e-6, "({x}, {y})");
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
