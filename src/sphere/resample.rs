//! Maps into maps, energy kept.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Rotation3, Vector3};
use num_traits::{One, Zero};

use super::cube_grid::rectangle_solid_angle;
use super::overlap_lat_long::{LatLongCells, TexelQuads};
use super::{CubeGrid, CubeMap, Face, LatLongGrid, LatLongMap, Texel, overlap_cube};
use crate::parallel;

/// How a map is carried to another grid.
///
/// | method | ∫ L dω kept | constants kept | non-negative stays so | for |
/// |---|---|---|---|---|
/// | [`Area`](Self::Area) | yes, and locally | yes | yes | shrinking; turning at equal size |
/// | [`Smooth`](Self::Smooth) | yes | yes | yes | the default: enlarging without blocks; else `Area` |
/// | [`Bilinear`](Self::Bilinear) | no | yes | yes | looking at one sample a texel |
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Resampling {
    /// The mean over each destination texel of the piecewise-constant source, from exact overlaps in closed form.
    ///
    /// Every source pixel's energy is handed out completely. Accuracy: energy 1e-12 relative (1e-14 but for turns near
    /// 1e-5 rad) before rounding to the texel type.
    Area,
    /// Where the destination's texels are smaller than the source's: the mean of 2 × 2 bilinear look-ups a texel, then
    /// one factor a channel (and sign) for the whole map, which restores the energy. It is [`Area`](Self::Area)
    /// otherwise, and where that factor would leave [½, 2]: light on pixels so narrow, at the poles, that they slip
    /// between the look-ups.
    ///
    /// Sizes are compared along an edge: π/2 a face for cubes; for lat-long maps 2π/width and π/height, the smaller of
    /// them as a source, the larger as a destination.
    #[default]
    Smooth,
    /// The bilinear value at each destination centre.
    Bilinear,
}

/// A map to sample from, in its own frame.
trait Source<P: Texel>: Sized + Sync {
    /// The smallest angle between neighbouring samples, away from poles.
    fn pitch(&self) -> f64;
    fn lookup(&self, direction: &Vector3<f64>) -> P::Wide;
    fn whole(&self) -> P::Wide;
    fn transformed(&self, f: impl Fn(P) -> P) -> Self;
}

impl<P: Texel> Source<P> for CubeMap<P> {
    fn pitch(&self) -> f64 {
        Target::pitch(self.grid())
    }
    fn lookup(&self, direction: &Vector3<f64>) -> P::Wide {
        self.bilinear(direction)
    }
    fn whole(&self) -> P::Wide {
        self.integral()
    }
    fn transformed(&self, f: impl Fn(P) -> P) -> Self {
        self.map(f)
    }
}

impl<P: Texel> Source<P> for LatLongMap<P> {
    fn pitch(&self) -> f64 {
        (TAU / self.grid().width() as f64).min(PI / self.grid().height() as f64)
    }
    fn lookup(&self, direction: &Vector3<f64>) -> P::Wide {
        self.bilinear(direction)
    }
    fn whole(&self) -> P::Wide {
        self.integral()
    }
    fn transformed(&self, f: impl Fn(P) -> P) -> Self {
        self.map(f)
    }
}

/// A grid to fill: the direction of a point (s, t) ∈ [0, 1]² of a cell, and the cell's solid angle.
trait Target: Copy + Sync {
    fn len(self) -> usize;
    /// The largest angle between neighbouring cells.
    fn pitch(self) -> f64;
    fn within(self, index: usize, s: f64, t: f64) -> Vector3<f64>;
    fn weights(self) -> Vec<f64>;
    fn weight_index(self, index: usize) -> usize;
}

impl Target for CubeGrid {
    fn len(self) -> usize {
        CubeGrid::len(self)
    }
    fn pitch(self) -> f64 {
        FRAC_PI_2 / self.side() as f64
    }
    fn within(self, index: usize, s: f64, t: f64) -> Vector3<f64> {
        let (face, x, y) = self.texel(index);
        let place = |i: usize, s: f64| 2.0 * (i as f64 + s) / self.side() as f64 - 1.0;
        face.point(place(x, s), place(y, t))
    }
    fn weights(self) -> Vec<f64> {
        self.face_solid_angles()
    }
    fn weight_index(self, index: usize) -> usize {
        index % self.face_len()
    }
}

impl Target for LatLongGrid {
    fn len(self) -> usize {
        LatLongGrid::len(self)
    }
    fn pitch(self) -> f64 {
        (TAU / self.width() as f64).max(PI / self.height() as f64)
    }
    fn within(self, index: usize, s: f64, t: f64) -> Vector3<f64> {
        let (x, y) = ((index % self.width()) as f64, (index / self.width()) as f64);
        *LatLongGrid::point((x + s) / self.width() as f64, (y + t) / self.height() as f64)
    }
    fn weights(self) -> Vec<f64> {
        (0..self.height()).map(|row| self.solid_angle(row)).collect()
    }
    fn weight_index(self, index: usize) -> usize {
        index / self.width()
    }
}

/// One positive or negative half of [`Resampling::Smooth`]; `None` where its factor would leave [½, 2].
fn smooth_half<P: Texel, G: Target>(
    source: &impl Source<P>,
    target: G,
    inverse: &Rotation3<f64>,
) -> Option<Vec<P::Wide>> {
    let mut wide = vec![P::Wide::zero(); target.len()];
    parallel::fill(
        &mut wide,
        || (),
        |i, ()| {
            let at = |s, t| source.lookup(&(inverse * target.within(i, s, t)));
            (at(0.25, 0.25) + at(0.75, 0.25) + at(0.25, 0.75) + at(0.75, 0.75)) * 0.25
        },
    );
    let weights = target.weights();
    let got = wide.iter().enumerate().fold(P::Wide::zero(), |sum, (i, &t)| sum + t * weights[target.weight_index(i)]);
    let factor =
        source.whole().zip_components(got, |want, got| if want == 0.0 && got == 0.0 { 1.0 } else { want / got });
    let tame = factor.map_components(|f| if f.is_nan() || (0.5..=2.0).contains(&f) { 0.0 } else { 1.0 });
    if !tame.is_zero() {
        return None;
    }
    // NaN or infinite pixels have no energy to restore.
    let factor = factor.map_components(|f| if f.is_nan() { f64::one() } else { f });
    wide.iter_mut().for_each(|t| *t = t.zip_components(factor, |t, f| t * f));
    Some(wide)
}

/// [`Resampling::Smooth`] of light and of what is negative, each with a factor of its own.
fn smooth<P: Texel, G: Target>(source: &impl Source<P>, target: G, inverse: &Rotation3<f64>) -> Option<Vec<P>> {
    let zero = <P::Scalar as Zero>::zero();
    let negative = source.transformed(|p| p.map_components(|c| if c < zero { c } else { zero }));
    let sum = if negative.whole().is_zero() {
        smooth_half::<P, G>(source, target, inverse)?
    } else {
        let positive = source.transformed(|p| p.map_components(|c| if c < zero { zero } else { c }));
        let mut sum = smooth_half::<P, G>(&positive, target, inverse)?;
        let negative = smooth_half::<P, G>(&negative, target, inverse)?;
        sum.iter_mut().zip(negative).for_each(|(sum, n)| *sum = *sum + n);
        sum
    };
    Some(sum.into_iter().map(P::narrow).collect())
}

/// One bilinear look-up a cell.
fn bilinear<P: Texel>(source: &impl Source<P>, target: impl Target, inverse: &Rotation3<f64>) -> Vec<P> {
    let mut out = vec![P::zero(); target.len()];
    parallel::fill(&mut out, || (), |i, ()| P::narrow(source.lookup(&(inverse * target.within(i, 0.5, 0.5)))));
    out
}

/// A weighted sum and its weights.
struct Mean<W> {
    sum: W,
    weight: f64,
}

impl<W: Texel<Scalar = f64>> Mean<W> {
    fn new() -> Self {
        Self { sum: W::zero(), weight: 0.0 }
    }

    #[inline(always)]
    fn add(&mut self, value: W, weight: f64) {
        self.sum = self.sum + value * weight;
        self.weight += weight;
    }

    fn value(&self) -> W {
        self.sum.map_components(|s| s / self.weight)
    }
}

impl<P: Texel> LatLongMap<P> {
    /// This map, turned by `rotation`, on the texels of a cube: result(ω) = map(R⁻¹ω).
    ///
    /// Cost: 1024 × 512 to 64² × 6 takes 0.1 s on one core by [`Resampling::Area`].
    ///
    /// # Example
    /// ```
    /// use haarmonic::nalgebra::Rotation3;
    /// use haarmonic::sphere::{CubeGrid, LatLongGrid, LatLongMap, Resampling};
    /// let map = LatLongMap::from_fn(LatLongGrid::new(64, 32)?, |d| 1.0 + d.x);
    /// let cube = map.to_cube(CubeGrid::new(8)?, &Rotation3::identity(), Resampling::Smooth);
    /// assert!((cube.integral() / map.integral() - 1.0).abs() < 1e-12);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn to_cube(&self, grid: CubeGrid, rotation: &Rotation3<f64>, resampling: Resampling) -> CubeMap<P> {
        let inverse = rotation.inverse();
        let from = |texels| CubeMap::new(grid, texels).expect("one value a texel");
        match resampling {
            Resampling::Bilinear => from(bilinear(self, grid, &inverse)),
            Resampling::Smooth if grid.pitch() < Source::<P>::pitch(self) => {
                smooth(self, grid, &inverse).map_or_else(|| self.to_cube(grid, rotation, Resampling::Area), from)
            }
            Resampling::Area | Resampling::Smooth => {
                let (cells, quads) = (LatLongCells::new(self.grid()), TexelQuads::new(grid, &inverse));
                CubeMap::from_indices(grid, Vec::new, |i, pieces| {
                    let mut mean = Mean::new();
                    cells.overlaps(&quads.quad(i), pieces, |k, w| mean.add(self.pixels()[k].widen(), w));
                    mean.value()
                })
            }
        }
    }
}

impl<P: Texel> CubeMap<P> {
    /// This map, turned by `rotation`, on the pixels of a lat-long map: result(ω) = map(R⁻¹ω).
    pub fn to_lat_long(&self, grid: LatLongGrid, rotation: &Rotation3<f64>, resampling: Resampling) -> LatLongMap<P> {
        let inverse = rotation.inverse();
        let from = |pixels| LatLongMap::new(grid, pixels).expect("one value a pixel");
        match resampling {
            Resampling::Bilinear => from(bilinear(self, grid, &inverse)),
            Resampling::Smooth if grid.pitch() < Source::<P>::pitch(self) => {
                smooth(self, grid, &inverse).map_or_else(|| self.to_lat_long(grid, rotation, Resampling::Area), from)
            }
            Resampling::Area | Resampling::Smooth => {
                // The same overlaps as from lat-long to cube, handed out from the texels in their order.
                let (cells, quads) = (LatLongCells::new(grid), TexelQuads::new(self.grid(), rotation));
                let mut means: Vec<Mean<P::Wide>> = (0..grid.len()).map(|_| Mean::new()).collect();
                let mut pieces = Vec::new();
                for (i, texel) in self.texels().iter().enumerate() {
                    let value = texel.widen();
                    cells.overlaps(&quads.quad(i), &mut pieces, |k, w| means[k].add(value, w));
                }
                from(means.iter().map(|mean| P::narrow(mean.value())).collect())
            }
        }
    }

    /// This map, turned by `rotation`, on another cube grid (or the same): result(ω) = map(R⁻¹ω).
    pub fn to_cube(&self, grid: CubeGrid, rotation: &Rotation3<f64>, resampling: Resampling) -> Self {
        let inverse = rotation.inverse();
        let from = |texels| CubeMap::new(grid, texels).expect("one value a texel");
        match resampling {
            Resampling::Bilinear => from(bilinear(self, grid, &inverse)),
            Resampling::Smooth if grid.pitch() < Source::<P>::pitch(self) => {
                smooth(self, grid, &inverse).map_or_else(|| self.to_cube(grid, rotation, Resampling::Area), from)
            }
            Resampling::Area | Resampling::Smooth if *rotation == Rotation3::identity() => self.resized(grid),
            Resampling::Area | Resampling::Smooth => {
                let quads = TexelQuads::new(grid, &inverse);
                Self::from_indices(
                    grid,
                    || (),
                    |i, ()| {
                        let mut mean = Mean::new();
                        overlap_cube::overlaps(self.grid(), &quads.quad(i), |k, w| {
                            mean.add(self.texels()[k].widen(), w);
                        });
                        mean.value()
                    },
                )
            }
        }
    }

    /// This map at another size: every texel the mean of what it covers, weighted by solid angle.
    ///
    /// The same as [`to_cube`](Self::to_cube) by [`Resampling::Area`] without a rotation.
    pub fn resized(&self, grid: CubeGrid) -> Self {
        let source = self.grid();
        if grid == source {
            return self.clone();
        }
        let (from, to) = (source.side(), grid.side());
        // Source lines in a destination cell: the cell i is [i·from, (i + 1)·from]/to in source texels.
        let covered = |i: usize| i * from / to..((i + 1) * from).div_ceil(to);
        let common = |i: usize, k: usize| [grid.line(i).max(source.line(k)), grid.line(i + 1).min(source.line(k + 1))];
        Self::from_indices(
            grid,
            || (),
            |i, ()| {
                let (face, x, y): (Face, _, _) = grid.texel(i);
                let mut mean = Mean::new();
                for sy in covered(y) {
                    for sx in covered(x) {
                        let weight = rectangle_solid_angle(common(x, sx), common(y, sy));
                        mean.add(self.texels()[source.index(face, sx, sy)].widen(), weight);
                    }
                }
                mean.value()
            },
        )
    }
}
