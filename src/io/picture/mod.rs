//! Pictures of linear RGB pixels, and images of other numbers.

mod environment;
mod exr;
mod hdr;
mod png;
mod primaries;

use std::path::Path;

use nalgebra::Vector3;

pub use self::environment::{
    EnvironmentLayout, load_environment, load_environment_with, read_environment, read_environment_with,
};
pub use self::exr::{encode_exr, read_exr};
pub use self::hdr::{encode_hdr, read_hdr};
pub use self::png::{PngDepth, encode_png, encode_png_data, encode_png_srgb8, read_png};
use super::atomic;
use crate::approx_eq::approx_by_parts;
use crate::io::count::plural;
use crate::io::report::{Loaded, Report, read_file};
use crate::numeric::Table2d;
use crate::{Error, Result};

/// A picture: linear RGB pixels, row after row from the top left.
///
/// Its pixels may also be data, such as the normals of a normal map: [`ImageEncoding::Data`]. Which pixel belongs to
/// the texture coordinates of a mesh: [`Mesh::uv`](crate::scene::Mesh::uv).
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<Vector3<f32>>,
}

impl Image {
    /// The most pixels that a file may have: 2²⁷, a lat-long map of 16384 × 8192 (1.5 GiB in memory).
    pub const MAX_PIXELS: usize = 1 << 27;

    /// A picture of `pixels`, row after row from the top left.
    ///
    /// # Errors
    /// [`Error::Empty`] if a side is 0, [`Error::Length`] unless there are width · height pixels.
    pub fn new(width: usize, height: usize, pixels: Vec<Vector3<f32>>) -> Result<Self> {
        if width == 0 || height == 0 {
            return Err(Error::Empty { what: "picture" });
        }
        let expected = width.saturating_mul(height);
        if pixels.len() != expected {
            return Err(Error::Length { what: "pixels of a picture", expected, got: pixels.len() });
        }
        Ok(Self { width, height, pixels })
    }

    /// Pixels along a row.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row after row from the top left.
    #[inline]
    pub fn pixels(&self) -> &[Vector3<f32>] {
        &self.pixels
    }

    /// All pixels, row after row from the top left.
    #[inline]
    pub fn into_pixels(self) -> Vec<Vector3<f32>> {
        self.pixels
    }

    /// One pixel.
    ///
    /// # Panics
    /// If `x` ≥ width or `y` ≥ height.
    #[track_caller]
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> Vector3<f32> {
        assert!(x < self.width && y < self.height, "pixel ({x}, {y}) of a picture of {} × {}", self.width, self.height);
        self.pixels[y * self.width + x]
    }
}

/// What the numbers of an image file stand for.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ImageEncoding {
    /// Light or colour. The file's encoding is undone (the curve of sRGB or a gamma in PNG, `EXPOSURE` and `COLORCORR`
    /// in HDR), primaries are converted to those of Rec. 709, and negative numbers are set to 0.
    #[default]
    Radiance,
    /// Numbers that mean something else: normals, heights, roughness. They stay as the file has them: samples of PNG
    /// over their largest (255 or 65535), numbers of EXR and HDR as they are stored, negative ones too; no curve,
    /// primaries or exposure is looked at. In a normal map, a component n is often stored as (n + 1) / 2: that is the
    /// caller's to undo.
    Data,
}

impl From<&Table2d> for Image {
    /// A table as a float texture: the value of node (i, j) in all three channels of pixel (i, j), rounded to `f32`.
    ///
    /// # Example
    /// ```
    /// use haarmonic::io::Image;
    /// use haarmonic::numeric::{Spacing, Table2d, TableAxis};
    /// let axis = |nodes| TableAxis::new(0.0, 1.0, nodes, Spacing::Linear);
    /// let table = Table2d::from_fn(axis(3)?, axis(2)?, |x, y| x - 2.0 * y)?;
    /// let texture = Image::from(&table);
    /// assert_eq!((texture.width(), texture.height(), texture.pixel(1, 1).x), (3, 2, -1.5));
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    fn from(table: &Table2d) -> Self {
        let [x, y] = table.axes();
        let pixels = table.values().iter().map(|&value| Vector3::repeat(value as f32)).collect();
        // An axis has two nodes or more, and a table one value a pair of them.
        Self::new(x.nodes(), y.nodes(), pixels).expect("a table has as many values as nodes")
    }
}

/// Reads a picture: Radiance HDR, OpenEXR or PNG; the first bytes decide which.
///
/// See [`read_image`].
///
/// # Errors
/// [`Error::File`] with the place for anything that cannot be read or repaired.
pub fn load_image(path: impl AsRef<Path>) -> Result<Loaded<Image>> {
    load_image_with(path, ImageEncoding::Radiance)
}

/// Reads an image whose numbers have a given meaning; see [`read_image_with`].
///
/// # Errors
/// [`Error::File`] with the place for anything that cannot be read or repaired.
pub fn load_image_with(path: impl AsRef<Path>, encoding: ImageEncoding) -> Result<Loaded<Image>> {
    let path = path.as_ref();
    read_image_with(&read_file(path)?, path, encoding)
}

/// A picture with what its file says about its use.
pub(super) struct Tagged {
    pub(super) image: Loaded<Image>,
    pub(super) envmap: Option<exr::Envmap>,
}

impl From<Loaded<Image>> for Tagged {
    fn from(image: Loaded<Image>) -> Self {
        Self { image, envmap: None }
    }
}

/// Reads a picture from its bytes; `name` is what messages call it.
///
/// Pixels are radiance: negative ones are set to 0 with a warning that counts them.
///
/// # Errors
/// [`Error::File`] with the place for anything that cannot be read: a format that is none of the three, a pixel that
/// is NaN or infinite, more than [`Image::MAX_PIXELS`] pixels, a file cut short.
pub fn read_image(bytes: &[u8], name: impl AsRef<Path>) -> Result<Loaded<Image>> {
    read_image_with(bytes, name, ImageEncoding::Radiance)
}

/// Reads an image whose numbers have a given meaning from its bytes; `name` is what messages call it.
///
/// [`read_image`] is this with [`ImageEncoding::Radiance`]. With [`ImageEncoding::Data`] the numbers are those of the
/// file; alpha is dropped all the same, and what is said of windows and layers in [`read_exr`] holds.
///
/// # Errors
/// Those of [`read_image`]: NaN and infinity are refused in data too.
///
/// # Example
/// ```
/// use haarmonic::io::{Image, ImageEncoding, PngDepth, encode_png_data, read_image_with};
/// use haarmonic::nalgebra::Vector3;
/// let flat = Image::new(1, 1, vec![Vector3::new(0.5, 0.5, 1.0)])?;
/// let bytes = encode_png_data(&flat, PngDepth::Sixteen)?;
/// let read = read_image_with(&bytes, "normals.png", ImageEncoding::Data)?.value.pixel(0, 0);
/// assert!((read - flat.pixel(0, 0)).amax() <= 0.5 / 65535.0);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn read_image_with(bytes: &[u8], name: impl AsRef<Path>, encoding: ImageEncoding) -> Result<Loaded<Image>> {
    read_tagged(bytes, name.as_ref(), encoding).map(|tagged| tagged.image)
}

/// As [`read_image_with`], with what the file says about its use.
pub(super) fn read_tagged(bytes: &[u8], name: &Path, encoding: ImageEncoding) -> Result<Tagged> {
    match bytes {
        [] => Err(Report::new(name).error("", "the file is empty")),
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::read_tagged(bytes, name, encoding),
        [0x89, b'P', b'N', b'G', ..] => png::read(bytes, name, encoding).map(Tagged::from),
        [b'#', b'?', ..] => hdr::read(bytes, name, encoding).map(Tagged::from),
        _ => Err(Report::new(name).error("byte 0", "not a picture format that can be read: HDR, EXR, PNG")),
    }
}

/// Checks the size that a header promises, before memory is taken for it.
pub(super) fn check_size(report: &Report, place: &str, width: usize, height: usize) -> Result<()> {
    let reason = match width.checked_mul(height) {
        Some(0) => format!("a picture of {width} × {height} pixels is empty"),
        Some(n) if n <= Image::MAX_PIXELS => return Ok(()),
        _ => format!("a picture of {width} × {height} pixels; at most 2^27 can be read"),
    };
    Err(report.error(place, reason))
}

/// Checks that a picture has no pixel that a reader would refuse.
pub(super) fn check_finite(image: &Image) -> Result<()> {
    match image.pixels().iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        Some(index) => Err(Error::NotFinite { what: "pixel of a picture", index }),
        None => Ok(()),
    }
}

/// Checks and repairs the pixels that a reader found.
pub(super) fn finish(
    mut report: Report,
    width: usize,
    height: usize,
    mut pixels: Vec<Vector3<f32>>,
    encoding: ImageEncoding,
) -> Result<Loaded<Image>> {
    let (mut negative, mut first, mut lowest) = (0, 0, 0.0_f32);
    for (i, pixel) in pixels.iter_mut().enumerate() {
        if pixel.iter().all(|c| c.is_finite() && *c >= 0.0) {
            continue;
        }
        if !pixel.iter().all(|c| c.is_finite()) {
            return Err(report.error(format!("pixel ({}, {})", i % width, i / width), "NaN or infinite"));
        }
        if encoding == ImageEncoding::Data {
            continue;
        }
        if negative == 0 {
            first = i;
        }
        negative += 1;
        lowest = lowest.min(pixel.min());
        pixel.apply(|c| *c = c.max(0.0));
    }
    if negative > 0 {
        let place = format!("pixel ({}, {})", first % width, first / width);
        report.warn(
            place,
            format!("{} set to 0 (lowest {lowest})", plural(negative, "negative pixel", "negative pixels")),
        );
    }
    let image = Image::new(width, height, pixels).map_err(|e| report.error("", e.to_string()))?;
    Ok(report.loaded(image))
}

/// Writes a picture as PNG: 8 bits, sRGB-encoded; see [`encode_png`].
///
/// # Errors
/// [`Error::File`] if the file cannot be written.
pub fn save_png(path: impl AsRef<Path>, image: &Image, exposure: f32) -> Result<()> {
    let path = path.as_ref();
    atomic::write(path, &encode_png(image, exposure).map_err(|e| named(path, e))?)
}

/// Writes an image of data as PNG, without any encoding; see [`encode_png_data`].
///
/// # Errors
/// [`Error::NotFinite`] for a pixel that is NaN or infinite, [`Error::File`] if the file cannot be written.
pub fn save_png_data(path: impl AsRef<Path>, image: &Image, depth: PngDepth) -> Result<()> {
    let path = path.as_ref();
    atomic::write(path, &encode_png_data(image, depth).map_err(|e| named(path, e))?)
}

/// Writes sRGB-encoded bytes as PNG, row after row from the top left.
///
/// # Errors
/// [`Error::Empty`] if a side is 0, [`Error::Length`] unless there are width · height pixels, [`Error::File`] if the
/// file cannot be written.
pub fn save_png_srgb8(path: impl AsRef<Path>, width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<()> {
    let path = path.as_ref();
    atomic::write(path, &encode_png_srgb8(width, height, pixels).map_err(|e| named(path, e))?)
}

/// Writes a picture as OpenEXR; see [`encode_exr`].
///
/// # Errors
/// [`Error::NotFinite`] for a pixel that is NaN or infinite, [`Error::File`] if the file cannot be written.
pub fn save_exr(path: impl AsRef<Path>, image: &Image) -> Result<()> {
    let path = path.as_ref();
    atomic::write(path, &encode_exr(image).map_err(|e| named(path, e))?)
}

/// Writes a picture as Radiance HDR; see [`encode_hdr`].
///
/// # Errors
/// [`Error::NotFinite`] for a pixel that is NaN or infinite, [`Error::File`] if the file cannot be written.
pub fn save_hdr(path: impl AsRef<Path>, image: &Image) -> Result<()> {
    atomic::write(path.as_ref(), &encode_hdr(image)?)
}

/// Gives an encoder's error the name of the file.
fn named(path: &Path, e: Error) -> Error {
    match e {
        Error::File { place, reason, .. } => Error::File { path: path.to_owned(), place, reason },
        e => e,
    }
}

approx_by_parts!([] Image, f32, |i| close [&i.pixels] same [i.width, i.height]);
