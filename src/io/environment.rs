//! Pictures as environment light.

use std::path::Path;

use nalgebra::Vector3;

use super::{Image, Loaded, Report, load_image, read_image};
use crate::scene::EnvironmentLight;
use crate::sphere::{CubeGrid, CubeMap, Face, LatLongGrid, LatLongMap};
use crate::{Error, Result};

/// Reads an environment light from a picture: Radiance HDR, OpenEXR or PNG.
///
/// | width : height | taken as |
/// |---|---|
/// | 2 : 1 | latitude–longitude map, the centre looking along −z, +x to its right |
/// | 4 : 3 | horizontal cross: +Y above, −X −Z +X +Z in the middle row, −Y below the second |
/// | 3 : 4 | vertical cross: +Y above, −X −Z +X in the second row, below them −Y and, upside down, +Z |
/// | 6 : 1 or 1 : 6 | the faces +X −X +Y −Y +Z −Z, each oriented as OpenGL samples it |
/// | anything else | latitude–longitude map, with a warning |
///
/// A cross is a picture seen from inside, like the latitude–longitude map: its middle looks along −z, +x to its right.
/// Crosses and strips need sides that divide evenly; else they too are taken as latitude–longitude maps.
///
/// # Errors
/// Those of [`read_image`], and [`Error::File`] for a side beyond [`LatLongGrid::MAX_SIZE`] or
/// [`CubeGrid::MAX_SIDE`].
pub fn load_environment(path: impl AsRef<Path>) -> Result<Loaded<EnvironmentLight>> {
    let path = path.as_ref();
    to_light(load_image(path)?, path)
}

/// Reads an environment light from the bytes of a picture, as [`load_environment`]; `name` is what messages call it.
///
/// # Errors
/// Those of [`load_environment`].
pub fn read_environment(bytes: &[u8], name: impl AsRef<Path>) -> Result<Loaded<EnvironmentLight>> {
    let name = name.as_ref();
    to_light(read_image(bytes, name)?, name)
}

fn to_light(image: Loaded<Image>, name: &Path) -> Result<Loaded<EnvironmentLight>> {
    let mut report = Report { path: name.to_owned(), warnings: image.warnings };
    let image = image.value;
    let light = match Layout::of(&image) {
        Some(layout) => layout.cube(&image).and_then(EnvironmentLight::from_cube),
        None => {
            let (w, h) = (image.width(), image.height());
            if w != 2 * h {
                report.warn(
                    "",
                    format!("{w} × {h} pixels are not 2 : 1; taken as a latitude–longitude map all the same"),
                );
            }
            LatLongMap::try_from(image).and_then(EnvironmentLight::from_lat_long)
        }
    };
    let light = light.map_err(|e| report.error("", e.to_string()))?;
    Ok(report.loaded(light))
}

/// A cell of an unfolded cube: its column and row, and the axes (right, down, outward) of its picture.
type Cell = (usize, usize, [[f64; 3]; 3]);

/// How the faces of a cube are laid out in a picture.
struct Layout {
    /// Pixels along an edge of a face.
    side: usize,
    cells: [Cell; 6],
}

const X: [f64; 3] = [1., 0., 0.];
const Y: [f64; 3] = [0., 1., 0.];
const Z: [f64; 3] = [0., 0., 1.];
const NX: [f64; 3] = [-1., 0., 0.];
const NY: [f64; 3] = [0., -1., 0.];
const NZ: [f64; 3] = [0., 0., -1.];

impl Layout {
    /// The layout that a picture's proportions say, if any.
    fn of(image: &Image) -> Option<Self> {
        let (w, h) = (image.width(), image.height());
        // What both crosses share: the four faces around the one that looks along −z.
        let cross = |far: Cell| {
            [(1, 1, [X, NY, NZ]), (0, 1, [NZ, NY, NX]), (2, 1, [Z, NY, X]), (1, 0, [X, NZ, Y]), (1, 2, [X, Z, NY]), far]
        };
        let strip = |at: fn(usize) -> (usize, usize)| {
            Face::ALL.map(|face| {
                let (x, y) = at(face as usize);
                (x, y, face.axes())
            })
        };
        let (side, cells) = if w % 4 == 0 && w / 4 * 3 == h {
            (w / 4, cross((3, 1, [NX, NY, Z])))
        } else if w % 3 == 0 && w / 3 * 4 == h {
            (w / 3, cross((1, 3, [X, Y, Z])))
        } else if w == 6 * h {
            (h, strip(|i| (i, 0)))
        } else if h == 6 * w {
            (w, strip(|i| (0, i)))
        } else {
            return None;
        };
        Some(Self { side, cells })
    }

    /// The cube map of a picture: the same pixels in another order.
    fn cube(&self, image: &Image) -> Result<CubeMap<Vector3<f32>>> {
        let grid = CubeGrid::new(self.side)?;
        let mut texels = vec![Vector3::zeros(); grid.len()];
        for (column, row, [right, down, out]) in self.cells {
            for y in 0..self.side {
                for x in 0..self.side {
                    let (u, v) = (grid.centre(x), grid.centre(y));
                    let direction = Vector3::from_fn(|i, _| out[i] + u * right[i] + v * down[i]);
                    texels[grid.nearest(&direction)] = image.pixel(column * self.side + x, row * self.side + y);
                }
            }
        }
        CubeMap::new(grid, texels)
    }
}

impl TryFrom<Image> for LatLongMap<Vector3<f32>> {
    type Error = Error;

    /// Takes the picture as a latitude–longitude map, whatever its proportions.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a side is beyond [`LatLongGrid::MAX_SIZE`].
    fn try_from(image: Image) -> Result<Self> {
        Self::new(LatLongGrid::new(image.width(), image.height())?, image.into_pixels())
    }
}

impl From<LatLongMap<Vector3<f32>>> for Image {
    fn from(map: LatLongMap<Vector3<f32>>) -> Self {
        let (width, height) = (map.grid().width(), map.grid().height());
        // A grid has at least one row and column, and a map one value a pixel.
        Self::new(width, height, map.into_pixels()).expect("a map has as many pixels as its grid")
    }
}
