//! Latitude–longitude maps: the form in which environment photographs come.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Rotation3, Unit, UnitVector3, Vector3};
use num_traits::Zero;

use super::{Axes, Texel};
use crate::{Error, Result};

/// The pixel grid of a latitude–longitude map.
///
/// ```math
/// u = ½ + atan2(x, −z)/2π,  v = acos(y)/π
/// ```
///
/// The image's centre looks along −z with +x to its right; v = 0, the top, is +y. Pixels are stored row after row from
/// the top left: index = row · width + column.
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "[usize; 2]", into = "[usize; 2]")
)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LatLongGrid {
    width: usize,
    height: usize,
}

impl TryFrom<[usize; 2]> for LatLongGrid {
    type Error = Error;

    /// As [`new`](LatLongGrid::new), of width and height.
    fn try_from([width, height]: [usize; 2]) -> Result<Self> {
        Self::new(width, height)
    }
}

impl From<LatLongGrid> for [usize; 2] {
    /// Width and height.
    fn from(grid: LatLongGrid) -> Self {
        [grid.width, grid.height]
    }
}

impl LatLongGrid {
    /// The largest width and height that are allowed.
    pub const MAX_SIZE: usize = 1 << 16;

    /// A grid of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless both are in 1…[`MAX_SIZE`](Self::MAX_SIZE).
    pub fn new(width: usize, height: usize) -> Result<Self> {
        for (what, got) in [("lat-long width", width), ("lat-long height", height)] {
            if !(1..=Self::MAX_SIZE).contains(&got) {
                return Err(Error::OutOfRange { what, got: got as f64, allowed: "in 1…65536" });
            }
        }
        Ok(Self { width, height })
    }

    /// Columns.
    #[inline]
    pub const fn width(self) -> usize {
        self.width
    }

    /// Rows.
    #[inline]
    pub const fn height(self) -> usize {
        self.height
    }

    /// Pixels, width · height.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub const fn len(self) -> usize {
        self.width * self.height
    }

    /// The image point (u, v) ∈ [0, 1]² of a direction, which need not be unit.
    ///
    /// At the poles u is ½ or 1, whatever the signs of the zeros say; the zero vector gives (½, 0) or (1, 0).
    #[inline]
    pub fn locate(direction: &Vector3<f64>) -> (f64, f64) {
        let d = direction;
        // acos(y) as an atan2 keeps its digits beside the poles and needs no unit vector.
        (0.5 + d.x.atan2(-d.z) / (2.0 * PI), d.x.hypot(d.z).atan2(d.y) / PI)
    }

    /// The unit direction of the image point (u, v), which go on around outside [0, 1]; NaN where an angle 2πu or πv is
    /// not finite.
    #[inline]
    pub fn point(u: f64, v: f64) -> UnitVector3<f64> {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((2.0 * PI * (u - 0.5)).sin_cos(), (PI * v).sin_cos());
        Unit::new_unchecked(Vector3::new(sin_v * sin_u, cos_v, -sin_v * cos_u))
    }

    /// The unit direction through the centre of a pixel.
    ///
    /// # Panics
    /// If `index` ≥ [`len`](Self::len).
    #[track_caller]
    #[inline]
    pub fn direction(self, index: usize) -> UnitVector3<f64> {
        assert!(index < self.len(), "pixel {index} of {}", self.len());
        let (x, y) = (index % self.width, index / self.width);
        Self::point((x as f64 + 0.5) / self.width as f64, (y as f64 + 0.5) / self.height as f64)
    }

    /// The flat index of the pixel that a direction falls into; of some pixel if a component is NaN.
    #[inline]
    pub fn nearest(self, direction: &Vector3<f64>) -> usize {
        let (u, v) = Self::locate(direction);
        let row = ((v * self.height as f64) as usize).min(self.height - 1);
        row * self.width + (u * self.width as f64) as usize % self.width
    }

    /// The exact solid angle of every pixel of a row, in steradians.
    ///
    /// ```math
    /// Ω = 2π/W · (cos πr/H − cos π(r + 1)/H) = 4π/W · sin(π(2r + 1)/2H) sin(π/2H)
    /// ```
    ///
    /// # Panics
    /// If there is no such row.
    #[inline]
    #[track_caller]
    pub fn solid_angle(self, row: usize) -> f64 {
        assert!(row < self.height, "row {row} of {}", self.height);
        let half = FRAC_PI_2 / self.height as f64;
        4.0 * PI / self.width as f64 * ((2 * row + 1) as f64 * half).sin() * half.sin()
    }
}

/// A function of direction sampled on a [`LatLongGrid`].
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        try_from = "Unchecked<P>",
        bound(serialize = "P: serde::Serialize", deserialize = "P: serde::Deserialize<'de>")
    )
)]
#[derive(Debug, Clone, PartialEq)]
pub struct LatLongMap<P: Texel> {
    grid: LatLongGrid,
    pixels: Vec<P>,
    /// Means of the top and the bottom row: the values at the poles themselves.
    #[cfg_attr(feature = "serde", serde(skip_serializing))]
    poles: [P::Wide; 2],
}

/// What a stored map says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked<P> {
    grid: LatLongGrid,
    pixels: Vec<P>,
}

#[cfg(feature = "serde")]
impl<P: Texel> TryFrom<Unchecked<P>> for LatLongMap<P> {
    type Error = Error;

    fn try_from(map: Unchecked<P>) -> Result<Self> {
        Self::new(map.grid, map.pixels)
    }
}

impl<P: Texel> LatLongMap<P> {
    /// A map of `pixels` in the grid's storage order.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one value a pixel.
    pub fn new(grid: LatLongGrid, pixels: Vec<P>) -> Result<Self> {
        if pixels.len() != grid.len() {
            return Err(Error::Length { what: "lat-long pixels", expected: grid.len(), got: pixels.len() });
        }
        let mean = |row: &[P]| {
            let sum = row.iter().fold(P::Wide::zero(), |sum, p| sum + p.widen());
            sum * (1.0 / grid.width as f64)
        };
        let poles = [mean(&pixels[..grid.width]), mean(&pixels[grid.len() - grid.width..])];
        Ok(Self { grid, pixels, poles })
    }

    /// A map that samples `f` at every pixel's centre.
    pub fn from_fn(grid: LatLongGrid, mut f: impl FnMut(UnitVector3<f64>) -> P) -> Self {
        let pixels = (0..grid.len()).map(|i| f(grid.direction(i))).collect();
        Self::new(grid, pixels).expect("one value a pixel")
    }

    /// The grid.
    #[inline]
    pub fn grid(&self) -> LatLongGrid {
        self.grid
    }

    /// All pixels, row after row.
    #[inline]
    pub fn pixels(&self) -> &[P] {
        &self.pixels
    }

    /// The pixels, without the map.
    pub fn into_pixels(self) -> Vec<P> {
        self.pixels
    }

    /// The map of `f` of every pixel.
    pub fn map<Q: Texel>(&self, f: impl FnMut(P) -> Q) -> LatLongMap<Q> {
        let pixels = self.pixels.iter().copied().map(f).collect();
        LatLongMap::new(self.grid, pixels).expect("one value a pixel")
    }

    /// The pixel that a direction falls into.
    #[inline]
    pub fn nearest(&self, direction: &Vector3<f64>) -> P {
        self.pixels[self.grid.nearest(direction)]
    }

    /// Bilinear between pixel centres, round the seam of u and towards the poles; continuous on the whole sphere.
    ///
    /// Between the first (last) row of centres and the pole it runs linearly to the mean of that row. A NaN direction
    /// gives NaN.
    pub fn bilinear(&self, direction: &Vector3<f64>) -> P::Wide {
        let (u, v) = LatLongGrid::locate(direction);
        let (width, height) = (self.grid.width, self.grid.height);
        // u·W − ½ shifted by one whole turn, so that the cast below rounds down.
        let x = u * width as f64 + (width as f64 - 0.5);
        let (x0, across) = (x as usize, x - x.floor());
        let (x0, x1) = (x0 % width, (x0 + 1) % width);
        let row = |y: usize| {
            let row = &self.pixels[y * width..][..width];
            row[x0].widen() * (1.0 - across) + row[x1].widen() * across
        };
        let y = v * height as f64 - 0.5;
        let mix = |a: P::Wide, b: P::Wide, t: f64| a * (1.0 - t) + b * t;
        if y < 0.0 {
            mix(self.poles[0], row(0), 2.0 * (y + 0.5))
        } else if y >= (height - 1) as f64 {
            mix(row(height - 1), self.poles[1], 2.0 * (y - (height - 1) as f64))
        } else {
            let y0 = y as usize;
            mix(row(y0), row((y0 + 1).min(height - 1)), y - y0 as f64)
        }
    }

    /// ∫ map dω over the sphere: exact for the piecewise-constant function.
    pub fn integral(&self) -> P::Wide {
        let rows = self.pixels.chunks_exact(self.grid.width).enumerate();
        rows.fold(P::Wide::zero(), |sum, (y, row)| {
            let row = row.iter().fold(P::Wide::zero(), |sum, p| sum + p.widen());
            sum + row * self.grid.solid_angle(y)
        })
    }

    /// The index of the first pixel that is NaN or infinite.
    pub fn first_not_finite(&self) -> Option<usize> {
        self.pixels.iter().position(|p| !p.is_finite())
    }
}

super::texel::approx_by_texels!(LatLongMap, pixels);

/// Where other programs put the directions of their world in the same image.
///
/// An image in such a program and in this crate differ in two things: the axes of the world, which [`axes`](Self::axes)
/// names, and a turn about the vertical, which [`rotation`](Self::rotation) gives *after* the change of axes. None of
/// them mirrors the image: seen from within a world of its own handedness, it runs from left to right in all of them.
///
/// | program | in its own coordinates, v from the top | centre, right of it | axes |
/// |---|---|---|---|
/// | [`CentreNegZ`](Self::CentreNegZ) | u = ½ + atan2(x, −z)/2π, v = acos(y)/π | −z, +x | right-handed, y up |
/// | [`Mitsuba`](Self::Mitsuba), [`Godot`](Self::Godot), [`Filament`](Self::Filament) | u = atan2(x, −z)/2π mod 1, v = acos(y)/π | +z, −x | right-handed, y up |
/// | [`ThreeJs`](Self::ThreeJs) | u = ½ + atan2(z, x)/2π, v = acos(y)/π | +x, +z | right-handed, y up |
/// | [`Blender`](Self::Blender) | u = ½ − atan2(y, x)/2π, v = acos(z)/π | +x, −y | right-handed, z up |
/// | [`Unity`](Self::Unity) | u = ½ − atan2(z, x)/2π, v = acos(y)/π | +x, −z | left-handed, y up |
/// | [`Unreal`](Self::Unreal) | u = ½ + atan2(x, −y)/2π, v = acos(z)/π | −y, +x | left-handed, z up |
/// | [`PbrtV3`](Self::PbrtV3) | u = atan2(y, x)/2π mod 1, v = acos(z)/π | −x, −y | left-handed, z up, before `LightToWorld` |
///
/// pbrt-v4 has no such images: its infinite light reads square, equal-area octahedral ones [Clarberg 2008], into which
/// its `imgtool makeequiarea` turns a lat-long map. They are not read here.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LatLongConvention {
    /// This crate: the image's centre looks along −z.
    #[default]
    CentreNegZ,
    /// Mitsuba 3's `envmap` emitter: u = atan2(x, −z)/2π mod 1, the image's centre looks along +z.
    Mitsuba,
    /// three.js' equirectangular maps (`equirectUv`): u = ½ + atan2(z, x)/2π, the image's centre looks along +x.
    ThreeJs,
    /// Blender's environment texture (Cycles' `direction_to_equirectangular`): the image's centre looks along +x.
    Blender,
    /// pbrt-v3's `infinite` light: the image's centre looks along −x of the light's space.
    PbrtV3,
    /// Unreal's cube maps from long-lat images (`LookupLongLat`): the image's centre looks along −y.
    Unreal,
    /// Unity's panoramic skybox (`ToRadialCoords`), unrotated: the image's centre looks along +x.
    Unity,
    /// Godot's panoramas (`SKY_COORDS`): the image's centre looks along +z.
    Godot,
    /// Filament's `cmgen`, with the mirror that is its default: the image's centre looks along +z.
    Filament,
}

impl LatLongConvention {
    /// All of them, this crate's first.
    pub const ALL: [Self; 9] = [
        Self::CentreNegZ,
        Self::Mitsuba,
        Self::ThreeJs,
        Self::Blender,
        Self::PbrtV3,
        Self::Unreal,
        Self::Unity,
        Self::Godot,
        Self::Filament,
    ];

    /// The program's world, seen from this crate's.
    pub const fn axes(self) -> Axes {
        match self {
            Self::CentreNegZ | Self::Mitsuba | Self::ThreeJs | Self::Godot | Self::Filament => Axes::RIGHT_HANDED_Y_UP,
            Self::Blender => Axes::RIGHT_HANDED_Z_UP,
            Self::PbrtV3 | Self::Unreal => Axes::LEFT_HANDED_Z_UP,
            Self::Unity => Axes::LEFT_HANDED_Y_UP,
        }
    }

    /// The angle in radians by which that program turns the image about our +y, against this crate, once
    /// [`axes`](Self::axes) are ours: 0, π, −π/2 or π/2.
    ///
    /// Derivation: seen from our world all of them run rightwards (from −z to +x, from +z to −x, from +x to +z, from
    /// −x to −z), so they differ by the turn that takes −z to the program's centre. A turn by α takes −z to
    /// (−sin α, 0, −cos α).
    pub fn angle(self) -> f64 {
        match self {
            Self::CentreNegZ | Self::Unreal => 0.0,
            Self::Mitsuba | Self::Godot | Self::Filament => PI,
            Self::ThreeJs | Self::Blender | Self::Unity => -FRAC_PI_2,
            Self::PbrtV3 => FRAC_PI_2,
        }
    }

    /// The turn that makes a map loaded here light the scene as it does there, the scene being in our axes.
    ///
    /// Its inverse undoes it: give it to a map that is to be shown there as it is here.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, sphere::LatLongConvention};
    /// let centre = LatLongConvention::ThreeJs.rotation() * -Vector3::z();
    /// assert!((centre - Vector3::x()).norm() < 1e-15);
    /// ```
    pub fn rotation(self) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Vector3::y_axis(), self.angle())
    }

    /// Where the program looks up a direction of its own world: u in [0, 1] from the left, v in [0, 1] from the top.
    ///
    /// What [`LatLongGrid::locate`] is for this crate: it says what happens to zero and NaN.
    ///
    /// # Example
    /// ```
    /// use haarmonic::{nalgebra::Vector3, sphere::LatLongConvention};
    /// // Blender's −y, where its front view looks from, is a quarter to the right of the centre.
    /// let (u, v) = LatLongConvention::Blender.locate(&-Vector3::y());
    /// assert!((u - 0.75).abs() < 1e-15 && (v - 0.5).abs() < 1e-15);
    /// ```
    pub fn locate(self, theirs: &Vector3<f64>) -> (f64, f64) {
        let d = self.axes().to_ours(theirs);
        // The inverse turn, exactly.
        LatLongGrid::locate(&match self {
            Self::CentreNegZ | Self::Unreal => d,
            Self::Mitsuba | Self::Godot | Self::Filament => Vector3::new(-d.x, d.y, -d.z),
            Self::ThreeJs | Self::Blender | Self::Unity => Vector3::new(d.z, d.y, -d.x),
            Self::PbrtV3 => Vector3::new(-d.z, d.y, d.x),
        })
    }
}
