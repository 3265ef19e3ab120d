//! Pictures as environment light.

use std::path::Path;

use nalgebra::Vector3;

use super::Image;
use super::exr::Envmap;
use super::{Tagged, read_tagged};
use crate::io::report::{Loaded, Report, read_file};
use crate::scene::EnvironmentLight;
use crate::sphere::{CubeGrid, CubeMap, Face, LatLongGrid, LatLongMap};
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
    to_light(read_tagged(&read_file(path)?, path)?, path, layout)
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
    to_light(read_tagged(bytes, name)?, name, layout)
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
        EnvironmentLayout::AngularMap if w == h => disc(&image, angular_map),
        EnvironmentLayout::MirrorBall if w == h => disc(&image, mirror_ball),
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
        bilinear(image, [place(right), place(down)], [side, side], face * side, |_, _| true)
    }))
}

fn along(direction: &Vector3<f64>, axis: [f64; 3]) -> f64 {
    direction.dot(&Vector3::from(axis))
}

/// The cube map of a picture of which a disc is used: `place` gives the point of the unit disc, x to the right and y
/// up, that shows a direction.
///
/// Half as many texels along a face as pixels along the picture: in the middle of a face these are denser than the
/// pixels in the middle of either kind of disc, 4/n radians for 2π/n and 4/n.
fn disc(image: &Image, place: fn(&Vector3<f64>) -> [f64; 2]) -> Result<CubeMap<Vector3<f32>>> {
    let n = image.width();
    let grid = CubeGrid::new(n.div_ceil(2))?;
    let centre = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
    // What is outside shows nothing, and is mostly black.
    let shows = |x: usize, y: usize| centre(x).hypot(centre(y)) <= 1.0;
    Ok(CubeMap::from_fn(grid, |d| {
        let [u, v] = place(&d);
        let at = |u: f64| (u + 1.0) / 2.0 * n as f64 - 0.5;
        bilinear(image, [at(u), at(-v)], [n, n], 0, shows)
    }))
}

fn angular_map(direction: &Vector3<f64>) -> [f64; 2] {
    let across = direction.x.hypot(direction.y);
    let radius = across.atan2(-direction.z) / std::f64::consts::PI;
    if across == 0.0 { [radius, 0.0] } else { [radius * direction.x / across, radius * direction.y / across] }
}

fn mirror_ball(direction: &Vector3<f64>) -> [f64; 2] {
    // The normal is half-way between the direction and that of the camera, +z.
    let normal = direction.normalize() + Vector3::z();
    let length = normal.norm();
    if length == 0.0 { [1.0, 0.0] } else { [normal.x / length, normal.y / length] }
}

/// Bilinear interpolation at a place in pixels (their centres are whole numbers) of a box of `size` from row `top` on,
/// between those pixels that show something; if none of the four does, the one nearest to the middle.
fn bilinear(
    image: &Image,
    place: [f64; 2],
    size: [usize; 2],
    top: usize,
    shows: impl Fn(usize, usize) -> bool,
) -> Vector3<f32> {
    let [x, y] = [0, 1].map(|i| place[i].clamp(0.0, (size[i] - 1) as f64));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(size[0] - 1), (y0 + 1).min(size[1] - 1));
    let (s, t) = (x - x0 as f64, y - y0 as f64);
    let mut sum = Vector3::<f64>::zeros();
    let mut weights = 0.0;
    for (x, y, weight) in
        [(x0, y0, (1.0 - s) * (1.0 - t)), (x1, y0, s * (1.0 - t)), (x0, y1, (1.0 - s) * t), (x1, y1, s * t)]
    {
        if weight > 0.0 && shows(x, y) {
            sum += weight * image.pixel(x, top + y).cast::<f64>();
            weights += weight;
        }
    }
    if weights == 0.0 {
        let inwards = |i: usize, n: usize, j: usize| if 2 * i < n { j } else { i };
        return image.pixel(inwards(x0, size[0], x1), top + inwards(y0, size[1], y1));
    }
    // A mean of finite numbers is not beyond the largest of them, but for rounding.
    (sum / weights).map(|c| c.min(f64::from(f32::MAX)) as f32)
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
