//! Pictures as environment light.

use std::path::Path;

use nalgebra::Vector3;

use super::Image;
use super::exr::Envmap;
use super::{ImageEncoding, Tagged, read_tagged};
use crate::io::report::{Loaded, Report, read_file};
use crate::scene::EnvironmentLight;
use crate::sphere::{CubeGrid, CubeMap, DiskMap, DiskProjection, Face, LatLongGrid, LatLongMap};
use crate::{Error, Result};

/// How directions lie in the picture of an environment.
///
/// Every layout is seen from inside, except for the mirror ball, which is photographed from outside.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum EnvironmentLayout {
    /// What the file says, or else its proportions: see [`load_environment`].
    #[default]
    Auto,
    /// Latitude–longitude map: the centre looks along −z, +x to its right, +y above. Any proportions.
    LatLong,
    /// Unfolded cube of 4 : 3 (+Y above, −X −Z +X +Z in the middle row, −Y below the second) or 3 : 4 (+Y above, −X −Z
    /// +X in the second row, below them −Y and, upside down, +Z). Its middle looks along −z, +x to its right.
    Cross,
    /// The faces +X −X +Y −Y +Z −Z side by side or one below the other, each oriented as OpenGL samples it.
    CubeStrip,
    /// The faces +X −X +Y −Y +Z −Z one below the other, as OpenEXR has them in a file with the attribute `envmap` =
    /// cube: seen from inside, their outermost pixels on the edges of the cube. As OpenEXR's latitude–longitude maps
    /// have +z in the centre, but those here −z, the cube too is turned by 180° about y: its +Z is −z here, its +X is
    /// −x.
    OpenExrCube,
    /// Angular map, as light probes are published [Debevec 1998]: a disc in a square; the centre looks along −z, +x to
    /// its right, +y above, and the distance from the centre is proportional to the angle from −z, up to 180° at the
    /// rim.
    AngularMap,
    /// Mirror ball photographed from far away along −z, its outline touching the four sides of the square: the centre
    /// shows what is at +z behind the camera, the rim what is at −z behind the ball; +x is at the right, +y above.
    MirrorBall,
}

/// Reads an environment light from a picture: Radiance HDR, OpenEXR or PNG.
///
/// | width : height | taken as |
/// |---|---|
/// | 2 : 1 | [`EnvironmentLayout::LatLong`] |
/// | 4 : 3 or 3 : 4 | [`EnvironmentLayout::Cross`] |
/// | 6 : 1 or 1 : 6 | [`EnvironmentLayout::CubeStrip`] |
/// | 1 : 1 | [`EnvironmentLayout::AngularMap`], with a warning, since a mirror ball is square too |
/// | anything else | [`EnvironmentLayout::LatLong`], with a warning |
///
/// The attribute `envmap` of an OpenEXR file goes before its proportions: latlong, or cube with 1 : 6, which is
/// [`EnvironmentLayout::OpenExrCube`]. (A cube of other proportions is a warning.)
/// Crosses and strips need sides that divide evenly; else they too are taken as latitude–longitude maps.
///
/// # Errors
/// Those of [`read_image`](super::read_image), and [`Error::File`] for a side beyond [`LatLongGrid::MAX_SIZE`] or
/// [`CubeGrid::MAX_SIDE`].
pub fn load_environment(path: impl AsRef<Path>) -> Result<Loaded<EnvironmentLight>> {
    load_environment_with(path, EnvironmentLayout::Auto)
}

/// Reads an environment light from a picture of a given layout, whatever the file and its proportions say.
///
/// # Errors
/// Those of [`load_environment`], and [`Error::File`] if the picture's proportions are not those of the layout.
pub fn load_environment_with(path: impl AsRef<Path>, layout: EnvironmentLayout) -> Result<Loaded<EnvironmentLight>> {
    let path = path.as_ref();
    to_light(read_tagged(&read_file(path)?, path, ImageEncoding::Radiance)?, path, layout)
}

/// Reads an environment light from the bytes of a picture, as [`load_environment`]; `name` is what messages call it.
///
/// # Errors
/// Those of [`load_environment`].
pub fn read_environment(bytes: &[u8], name: impl AsRef<Path>) -> Result<Loaded<EnvironmentLight>> {
    read_environment_with(bytes, name, EnvironmentLayout::Auto)
}

/// Reads an environment light from the bytes of a picture of a given layout, as [`load_environment_with`].
///
/// # Errors
/// Those of [`load_environment_with`].
pub fn read_environment_with(
    bytes: &[u8],
    name: impl AsRef<Path>,
    layout: EnvironmentLayout,
) -> Result<Loaded<EnvironmentLight>> {
    let name = name.as_ref();
    to_light(read_tagged(bytes, name, ImageEncoding::Radiance)?, name, layout)
}

fn to_light(tagged: Tagged, name: &Path, layout: EnvironmentLayout) -> Result<Loaded<EnvironmentLight>> {
    let mut report = Report { path: name.to_owned(), warnings: tagged.image.warnings };
    let image = tagged.image.value;
    let (w, h) = (image.width(), image.height());
    let layout = match layout {
        EnvironmentLayout::Auto => guess(w, h, tagged.envmap, &mut report),
        given => given,
    };
    let needs = |ratio: &str| report.error("", format!("{w} × {h} pixels; this layout needs {ratio}"));
    let cube = match layout {
        EnvironmentLayout::Auto | EnvironmentLayout::LatLong => {
            let light = LatLongMap::try_from(image).and_then(EnvironmentLight::from_lat_long);
            let light = light.map_err(|e| report.error("", e.to_string()))?;
            return Ok(report.loaded(light));
        }
        EnvironmentLayout::Cross => Unfolded::cross(w, h).ok_or_else(|| needs("4 : 3 or 3 : 4"))?.cube(&image),
        EnvironmentLayout::CubeStrip => Unfolded::strip(w, h).ok_or_else(|| needs("6 : 1 or 1 : 6"))?.cube(&image),
        EnvironmentLayout::OpenExrCube if h == 6 * w => open_exr_cube(&image),
        EnvironmentLayout::OpenExrCube => return Err(needs("1 : 6")),
        EnvironmentLayout::AngularMap if w == h => disk(image, DiskProjection::AngularMap),
        EnvironmentLayout::MirrorBall if w == h => disk(image, DiskProjection::SphereMap),
        EnvironmentLayout::AngularMap | EnvironmentLayout::MirrorBall => return Err(needs("1 : 1")),
    };
    let light = cube.and_then(EnvironmentLight::from_cube).map_err(|e| report.error("", e.to_string()))?;
    Ok(report.loaded(light))
}

/// The layout that a file says, or else its proportions.
fn guess(w: usize, h: usize, envmap: Option<Envmap>, report: &mut Report) -> EnvironmentLayout {
    match envmap {
        Some(Envmap::Cube) if h == 6 * w => return EnvironmentLayout::OpenExrCube,
        Some(Envmap::Cube) => {
            report.warn("header", format!("envmap is cube, but {w} × {h} pixels are not 1 : 6; ignored"));
        }
        _ => {}
    }
    let lat_long = envmap == Some(Envmap::LatLong) || w == 2 * h;
    if !lat_long && Unfolded::cross(w, h).is_some() {
        return EnvironmentLayout::Cross;
    }
    if !lat_long && Unfolded::strip(w, h).is_some() {
        return EnvironmentLayout::CubeStrip;
    }
    if !lat_long && w == h {
        let message = "pixels are square; taken as an angular map (light probe); for a mirror ball or a \
                       latitude–longitude map say so (EnvironmentLayout, --env-layout)";
        report.warn("", format!("{w} × {h} {message}"));
        return EnvironmentLayout::AngularMap;
    }
    if w != 2 * h {
        report.warn("", format!("{w} × {h} pixels are not 2 : 1; taken as a latitude–longitude map all the same"));
    }
    EnvironmentLayout::LatLong
}

/// A cell of an unfolded cube: its column and row, and the axes (right, down, outward) of its picture.
type Cell = (usize, usize, [[f64; 3]; 3]);

/// How the faces of a cube are laid out in a picture.
struct Unfolded {
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

impl Unfolded {
    fn cross(w: usize, h: usize) -> Option<Self> {
        // What both crosses share: the four faces around the one that looks along −z.
        let cells = |far: Cell| {
            [(1, 1, [X, NY, NZ]), (0, 1, [NZ, NY, NX]), (2, 1, [Z, NY, X]), (1, 0, [X, NZ, Y]), (1, 2, [X, Z, NY]), far]
        };
        if w % 4 == 0 && w / 4 * 3 == h {
            Some(Self { side: w / 4, cells: cells((3, 1, [NX, NY, Z])) })
        } else if w % 3 == 0 && w / 3 * 4 == h {
            Some(Self { side: w / 3, cells: cells((1, 3, [X, Y, Z])) })
        } else {
            None
        }
    }

    fn strip(w: usize, h: usize) -> Option<Self> {
        let cells = |at: fn(usize) -> (usize, usize)| {
            Face::ALL.map(|face| {
                let (x, y) = at(face as usize);
                (x, y, face.axes())
            })
        };
        if w == 6 * h {
            Some(Self { side: h, cells: cells(|i| (i, 0)) })
        } else if h == 6 * w {
            Some(Self { side: w, cells: cells(|i| (0, i)) })
        } else {
            None
        }
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

/// The cube map of OpenEXR's cube.
///
/// Its outermost pixels are on the edges of the cube, those of a [`CubeGrid`] half a texel inside, so that texels lie
/// between pixels: bilinear interpolation within the face. The axes are those of `CubeMap::pixelPosition` in OpenEXR's
/// ImfEnvmap: each face right and down as somebody in the middle, who stands upright, sees it.
fn open_exr_cube(image: &Image) -> Result<CubeMap<Vector3<f32>>> {
    const FACES: [[[f64; 3]; 3]; 6] = [[Z, NY, X], [NZ, NY, NX], [X, NZ, Y], [X, Z, NY], [NX, NY, Z], [X, NY, NZ]];
    let side = image.width();
    let grid = CubeGrid::new(side)?;
    Ok(CubeMap::from_fn(grid, |d| {
        // The turn by 180° about y.
        let d = Vector3::new(-d.x, d.y, -d.z);
        let (face, [right, down, out]) = FACES.iter().enumerate().fold((0, FACES[0]), |best, face| {
            if along(&d, face.1[2]) > along(&d, best.1[2]) { (face.0, *face.1) } else { best }
        });
        let place = |axis| (along(&d, axis) / along(&d, out) + 1.0) / 2.0 * (side - 1) as f64;
        bilinear(image, [place(right), place(down)], side, face * side)
    }))
}

fn along(direction: &Vector3<f64>, axis: [f64; 3]) -> f64 {
    direction.dot(&Vector3::from(axis))
}

/// The cube map of a picture of which a disk is used.
///
/// Half as many texels along a face as pixels along the picture: in the middle of a face these are denser than the
/// pixels in the middle of either kind of disk, 4/n radians for 2π/n and 4/n.
fn disk(image: Image, projection: DiskProjection) -> Result<CubeMap<Vector3<f32>>> {
    let side = image.width();
    Ok(DiskMap::new(projection, side, image.into_pixels())?.to_cube(CubeGrid::new(side.div_ceil(2))?))
}

/// Bilinear interpolation at a place in pixels (their centres are whole numbers) of the square of `side` pixels from
/// row `top` on.
fn bilinear(image: &Image, place: [f64; 2], side: usize, top: usize) -> Vector3<f32> {
    let [x, y] = place.map(|p| p.clamp(0.0, (side - 1) as f64));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(side - 1), (y0 + 1).min(side - 1));
    let (s, t) = (x - x0 as f64, y - y0 as f64);
    let at = |x: usize, y: usize| image.pixel(x, top + y).cast::<f64>();
    let row = |y: usize| at(x0, y) * (1.0 - s) + at(x1, y) * s;
    // A mean of finite numbers is not beyond the largest of them, but for rounding.
    (row(y0) * (1.0 - t) + row(y1) * t).map(|c| c.min(f64::from(f32::MAX)) as f32)
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
