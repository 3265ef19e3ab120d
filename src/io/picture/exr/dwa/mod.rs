//! DWAA and DWAB: colours as quantised cosine transforms of 8 × 8 pixels, alpha in runs, other channels by zlib.

mod cosine;

use self::cosine::Coefficients;
use super::block::Block;
use super::deflate::{inflate, undo_prediction, undo_runs};
use super::header::SampleType;
use super::huffman;
use super::input::Input;

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
