//! The header of a file of one flat part.

use super::input::Input;

/// The type of a channel's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SampleType {
    U32,
    Half,
    F32,
}

impl SampleType {
    pub(super) fn of(code: u32) -> Option<Self> {
        Some(match code {
            0 => Self::U32,
            1 => Self::Half,
            2 => Self::F32,
            _ => return None,
        })
    }

    /// Bytes of a sample.
    pub(super) fn size(self) -> usize {
        if self == Self::Half { 2 } else { 4 }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) samples: SampleType,
    /// Whether lossy compression keeps the samples linear (`pLinear`).
    pub(super) linear: bool,
    pub(super) subsampled: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Rle,
    Zips,
    Zip,
    Piz,
    Pxr24,
    B44,
    Dwaa,
    Dwab,
}

impl Compression {
    fn of(code: u8) -> Result<Self, String> {
        Ok(match code {
            0 => Self::None,
            1 => Self::Rle,
            2 => Self::Zips,
            3 => Self::Zip,
            4 => Self::Piz,
            5 => Self::Pxr24,
            // B44A differs in what it writes only.
            6 | 7 => Self::B44,
            8 => Self::Dwaa,
            9 => Self::Dwab,
            10 | 11 => {
                return Err("HTJ2K compression cannot be read; save the picture with another one, such as ZIP".into());
            }
            _ => return Err(format!("compression number {code} is not known")),
        })
    }

    /// Scan lines of a block.
    fn lines(self) -> usize {
        match self {
            Self::None | Self::Rle | Self::Zips => 1,
            Self::Zip | Self::Pxr24 => 16,
            Self::Piz | Self::B44 | Self::Dwaa => 32,
            Self::Dwab => 256,
        }
    }
}

/// A box of pixels: its first column and row, its width and height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) at: [i64; 2],
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Window {
    fn read(value: &mut Input) -> Option<Self> {
        let [x0, y0, x1, y1] = [value.i32()?, value.i32()?, value.i32()?, value.i32()?].map(i64::from);
        let side = |a: i64, b: i64| usize::try_from(b - a + 1).ok();
        Some(Self { at: [x0, y0], width: side(x0, x1)?, height: side(y0, y1)? })
    }
}

/// What the picture says it is, of the whole sphere around a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Envmap {
    LatLong,
    Cube,
}

#[derive(Debug)]
pub(super) struct Header {
    /// In the order of the file, which is that of the samples.
    pub(super) channels: Vec<Channel>,
    pub(super) compression: Compression,
    pub(super) data: Window,
    pub(super) display: Window,
    /// Width and height of a block; a block at the right or lower edge may be smaller.
    pub(super) block: [usize; 2],
    pub(super) tiled: bool,
    pub(super) envmap: Option<Envmap>,
    /// x and y of red, green, blue and white.
    pub(super) chromaticities: Option<[f32; 8]>,
    /// Where the table of the blocks' offsets begins.
    pub(super) end: usize,
}

impl Header {
    /// Reads the header. `bytes` is the whole file.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut input = Input(bytes);
        if input.array() != Some([0x76, 0x2f, 0x31, 0x01]) {
            return Err("not an OpenEXR file: it does not begin with the bytes 76 2f 31 01".into());
        }
        let version = input.u32().ok_or("the file ends here")?;
        if version & 0xff != 2 {
            return Err(format!("version {} of the format; only 2 can be read", version & 0xff));
        }
        if version & 0x800 != 0 {
            return Err("deep data cannot be read; flatten the picture first".into());
        }
        if version & 0x1000 != 0 {
            return Err("a file of several parts cannot be read; save one part by itself".into());
        }
        let mut found = Attributes::default();
        loop {
            let name = input.name().ok_or("the file ends in the header")?;
            if name.is_empty() {
                break;
            }
            let attribute = input.name().and_then(|kind| Some((kind, input.sized()?)));
            let (kind, value) = attribute.ok_or("the file ends in the header")?;
            found.take(name, kind, value)?;
        }
        let missing = |what: &str| format!("the attribute \"{what}\" is not there");
        let channels = found.channels.ok_or_else(|| missing("channels"))?;
        let compression = found.compression.ok_or_else(|| missing("compression"))?;
        let data = found.data.ok_or_else(|| missing("dataWindow"))?;
        let display = found.display.ok_or_else(|| missing("displayWindow"))?;
        let tiled = version & 0x200 != 0;
        let block = if tiled { found.tile.ok_or_else(|| missing("tiles"))? } else { [data.width, compression.lines()] };
        let (envmap, chromaticities) = (found.envmap, found.chromaticities);
        let end = bytes.len() - input.0.len();
        Ok(Self { channels, compression, data, display, block, tiled, envmap, chromaticities, end })
    }

    /// Bytes of a pixel, over all channels.
    pub(super) fn pixel_size(&self) -> usize {
        self.channels.iter().map(|c| c.samples.size()).sum()
    }

    /// Blocks across and down, of the finest resolution.
    pub(super) fn blocks(&self) -> [usize; 2] {
        [self.data.width.div_ceil(self.block[0]), self.data.height.div_ceil(self.block[1])]
    }
}

/// The attributes that the reader needs, as far as they have been found.
#[derive(Default)]
struct Attributes {
    channels: Option<Vec<Channel>>,
    compression: Option<Compression>,
    data: Option<Window>,
    display: Option<Window>,
    tile: Option<[usize; 2]>,
    envmap: Option<Envmap>,
    chromaticities: Option<[f32; 8]>,
}

impl Attributes {
    fn take(&mut self, name: &[u8], kind: &[u8], value: &[u8]) -> Result<(), String> {
        let mut value = Input(value);
        let wrong = || format!("the attribute \"{}\" has no valid value", String::from_utf8_lossy(name));
        match (name, kind) {
            (b"channels", b"chlist") => self.channels = Some(channels(value)?),
            (b"compression", b"compression") => {
                self.compression = Some(Compression::of(value.u8().ok_or_else(wrong)?)?);
            }
            (b"dataWindow", b"box2i") => self.data = Some(Window::read(&mut value).ok_or_else(wrong)?),
            (b"displayWindow", b"box2i") => self.display = Some(Window::read(&mut value).ok_or_else(wrong)?),
            (b"tiles", b"tiledesc") => {
                let side = |n: Option<u32>| n.filter(|&n| n > 0).and_then(|n| usize::try_from(n).ok());
                let tile = side(value.u32()).zip(side(value.u32()));
                let (width, height) = tile.ok_or_else(wrong)?;
                self.tile = Some([width, height]);
            }
            (b"envmap", b"envmap") => {
                self.envmap = match value.u8().ok_or_else(wrong)? {
                    0 => Some(Envmap::LatLong),
                    1 => Some(Envmap::Cube),
                    n => return Err(format!("environment map number {n} is not known")),
                };
            }
            (b"chromaticities", b"chromaticities") => {
                let mut numbers = [0.0; 8];
                for number in &mut numbers {
                    *number = value.f32().ok_or_else(wrong)?;
                }
                self.chromaticities = Some(numbers);
            }
            _ => {}
        }
        Ok(())
    }
}

/// The most channels of a file: names are compared with each other.
const MAX_CHANNELS: usize = 4096;

fn channels(mut value: Input) -> Result<Vec<Channel>, String> {
    let mut channels = Vec::new();
    let cut = || "the list of channels is cut short".to_owned();
    loop {
        let name = value.name().ok_or_else(cut)?;
        if name.is_empty() {
            break;
        }
        if channels.len() == MAX_CHANNELS {
            return Err(format!("more than {MAX_CHANNELS} channels"));
        }
        let name = String::from_utf8_lossy(name).into_owned();
        let code = value.u32().ok_or_else(cut)?;
        let samples = SampleType::of(code).ok_or_else(|| format!("channel \"{name}\" has samples of type {code}"))?;
        let [linear, _, _, _] = value.array().ok_or_else(cut)?;
        let sampling = [value.i32().ok_or_else(cut)?, value.i32().ok_or_else(cut)?];
        channels.push(Channel { name, samples, linear: linear != 0, subsampled: sampling != [1, 1] });
    }
    if channels.is_empty() {
        return Err("there are no channels".into());
    }
    Ok(channels)
}
