//! A function of direction, held on the texels of a cube.

use nalgebra::{UnitVector3, Vector3};
use num_traits::Zero;

use super::{CubeGrid, Face, Texel};
use crate::error::check_length;
use crate::{Error, Real, Result, parallel};

/// A function of direction sampled on a [`CubeGrid`].
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked<P>", bound(deserialize = "P: Texel + serde::Deserialize<'de>"))
)]
#[derive(Debug, Clone, PartialEq)]
pub struct CubeMap<P> {
    grid: CubeGrid,
    texels: Vec<P>,
}

/// What a stored map says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked<P> {
    grid: CubeGrid,
    texels: Vec<P>,
}

#[cfg(feature = "serde")]
impl<P: Texel> TryFrom<Unchecked<P>> for CubeMap<P> {
    type Error = Error;

    fn try_from(map: Unchecked<P>) -> Result<Self> {
        Self::new(map.grid, map.texels)
    }
}

impl<P: Texel> CubeMap<P> {
    /// A map of `texels` in the grid's storage order.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one value a texel.
    pub fn new(grid: CubeGrid, texels: Vec<P>) -> Result<Self> {
        if texels.len() != grid.len() {
            return Err(Error::Length { what: "cube map texels", expected: grid.len(), got: texels.len() });
        }
        Ok(Self { grid, texels })
    }

    /// A map that samples `f` at every texel's centre.
    pub fn from_fn(grid: CubeGrid, mut f: impl FnMut(UnitVector3<f64>) -> P) -> Self {
        Self { grid, texels: (0..grid.len()).map(|i| f(grid.direction(i))).collect() }
    }

    /// The grid.
    #[inline]
    pub fn grid(&self) -> CubeGrid {
        self.grid
    }

    /// All texels, face after face.
    #[inline]
    pub fn texels(&self) -> &[P] {
        &self.texels
    }

    /// All texels, to write.
    #[inline]
    pub fn texels_mut(&mut self) -> &mut [P] {
        &mut self.texels
    }

    /// The texels of one face, row after row.
    #[inline]
    pub fn face(&self, face: Face) -> &[P] {
        let n = self.grid.face_len();
        &self.texels[face as usize * n..][..n]
    }

    /// Takes the texels out of the map.
    pub fn into_texels(self) -> Vec<P> {
        self.texels
    }

    /// The map of `f` of every texel.
    pub fn map<Q: Texel>(&self, f: impl FnMut(P) -> Q) -> CubeMap<Q> {
        CubeMap { grid: self.grid, texels: self.texels.iter().copied().map(f).collect() }
    }

    /// The map of `f` of the texels of two maps.
    ///
    /// # Panics
    /// If the grids differ.
    #[track_caller]
    pub fn zip_map<Q: Texel, R: Texel>(&self, other: &CubeMap<Q>, mut f: impl FnMut(P, Q) -> R) -> CubeMap<R> {
        check_length("cube map side", self.grid.side(), other.grid.side());
        let pairs = self.texels.iter().zip(&other.texels);
        CubeMap { grid: self.grid, texels: pairs.map(|(&a, &b)| f(a, b)).collect() }
    }

    /// The index of the first texel that is NaN or infinite.
    pub fn first_not_finite(&self) -> Option<usize> {
        self.texels.iter().position(|t| !t.is_finite())
    }

    /// The texel that a direction falls into; some texel if a component is NaN or infinite.
    #[inline]
    pub fn nearest(&self, direction: &Vector3<f64>) -> P {
        self.texels[self.grid.nearest(direction)]
    }

    /// Bilinear between texel centres, across the edges and corners of the cube; continuous on the whole sphere.
    ///
    /// Beyond an edge lies the row of texels of the adjacent face: on the edge itself both faces see the same two
    /// texels with the same weights, because their coordinates along the edge agree. At a corner there is no fourth
    /// texel; the mean of the three stands in for it, and all three faces agree on (a + b + c)/3. A direction with a
    /// component that is NaN or infinite gives NaN.
    pub fn bilinear(&self, direction: &Vector3<f64>) -> P::Wide {
        let (face, u, v) = Face::locate(direction);
        let side = self.grid.side();
        // (u + 1)/2·side − ½, plus one so that the casts round down; cell i holds the centres i − 1 and i.
        let position = |t: f64| (t + 1.0) * 0.5 * side as f64 + 0.5;
        let (x, y) = (position(u), position(v));
        let (x1, y1) = ((x as usize).min(side), (y as usize).min(side));
        let (right, down) = (x - x1 as f64, y - y1 as f64);
        let inside = |i: usize| (1..side).contains(&i);
        let [a, b, c, d] = if inside(x1) && inside(y1) {
            let at = |x: usize, y: usize| self.texels[self.grid.index(face, x, y)].widen();
            [at(x1 - 1, y1 - 1), at(x1, y1 - 1), at(x1 - 1, y1), at(x1, y1)]
        } else {
            self.square_over_edge(face, x1, y1)
        };
        (a * (1.0 - right) + b * right) * (1.0 - down) + (c * (1.0 - right) + d * right) * down
    }

    /// The texels (x − 1, y − 1), (x, y − 1), (x − 1, y), (x, y) of a face, 0 ≤ x, y ≤ side, where some lie beyond an
    /// edge.
    fn square_over_edge(&self, face: Face, x: usize, y: usize) -> [P::Wide; 4] {
        let last = self.grid.side() as isize - 1;
        let corners = [(-1, -1), (0, -1), (-1, 0), (0, 0)];
        corners.map(|(dx, dy)| {
            let (tx, ty) = (x as isize + dx, y as isize + dy);
            // Into the face, and how far beyond it.
            let (cx, cy) = (tx.clamp(0, last), ty.clamp(0, last));
            let (sx, sy) = (tx - cx, ty - cy);
            let at = |step| self.texels[self.grid.neighbour(face, cx as usize, cy as usize, step)].widen();
            if sx != 0 && sy != 0 { (at((0, 0)) + at((sx, 0)) + at((0, sy))) * (1.0 / 3.0) } else { at((sx, sy)) }
        })
    }

    /// ∫ map dω over the sphere: exact for the piecewise-constant function.
    pub fn integral(&self) -> P::Wide {
        let omega = self.grid.face_solid_angles();
        self.texels.iter().enumerate().fold(P::Wide::zero(), |sum, (i, t)| sum + t.widen() * omega[i % omega.len()])
    }

    /// Computes every texel from its index, in parallel, with a scratch of each thread's own.
    pub(crate) fn from_indices<S>(
        grid: CubeGrid,
        scratch: impl Fn() -> S + Sync,
        f: impl Fn(usize, &mut S) -> P::Wide + Sync,
    ) -> Self {
        let mut texels = vec![P::zero(); grid.len()];
        parallel::fill(&mut texels, scratch, |i, scratch| P::narrow(f(i, scratch)));
        Self { grid, texels }
    }
}

impl<T: Real> CubeMap<Vector3<T>>
where
    Vector3<T>: Texel,
    T: Texel,
{
    /// Checks that a light lies on a grid and is finite.
    pub(crate) fn check_light_on(&self, grid: CubeGrid) -> Result<()> {
        if self.grid() != grid {
            let (expected, got) = (grid.side(), self.grid().side());
            return Err(Error::Length { what: "side of the light's cube map", expected, got });
        }
        match self.texels().iter().position(|t| !t.iter().all(|c| Real::widen(*c).is_finite())) {
            Some(index) => Err(Error::NotFinite { what: "texel of the light", index }),
            None => Ok(()),
        }
    }

    /// The three colour channels as maps of their own.
    pub fn planes(&self) -> [CubeMap<T>; 3] {
        std::array::from_fn(|c| CubeMap { grid: self.grid, texels: self.texels.iter().map(|t| t[c]).collect() })
    }

    /// The colour map of three channels.
    ///
    /// # Errors
    /// [`Error::Length`] unless the grids are alike.
    pub fn from_planes(planes: &[CubeMap<T>; 3]) -> Result<Self> {
        let [r, g, b] = planes;
        for other in [g, b] {
            if other.grid != r.grid {
                let (expected, got) = (r.grid.side(), other.grid.side());
                return Err(Error::Length { what: "side of a colour plane", expected, got });
            }
        }
        let texels = (0..r.grid.len()).map(|i| Vector3::new(r.texels[i], g.texels[i], b.texels[i])).collect();
        Ok(Self { grid: r.grid, texels })
    }
}

super::texel::approx_by_texels!(CubeMap, texels);
