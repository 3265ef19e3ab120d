//! Which target coefficients are worth computing, before anything is known but the map.

use std::sync::OnceLock;

use super::coupling::levels_of;
use super::{AffineMap, MapGrid, Nonzeros1d, NonzerosNonstandard, Targets};
use crate::error::check_length;
use crate::haar::{Decomposition, Index2d, Keep};
use crate::{Error, Result, parallel};

/// What is assumed of a light whose target coefficients are to be predicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heuristic<'a> {
    /// It is constant: L̃_k = D_0k, what the thesis uses. Only wavelets that an edge of the light crosses are
    /// predicted, at most about 10 of 32 an axis.
    Constant,
    /// It has these coefficients F̃_i: L̃_k = Σ_i F̃_i D_ik                                              [Sun 2008, eq.
    /// 4.38].
    Light(&'a [f64]),
    /// Its coefficients are uncorrelated with these mean squares σ_i²: L̃_k² = Σ_i σ_i² D_ik². [`mean_squares_1d`]
    /// and [`mean_squares_2d`] make them from lights.
    Power(&'a [f64]),
}

/// The target coefficients to compute for a map: those that a heuristic light makes largest there.
///
/// [Sun 2008, §4.5.5, "target-level compression"]
///
/// `Q` is the number of axes, 1 or 2. In 2D both axes share the scale (that of the first map counts) but not the
/// offset. The choice is made once for each cell of a [`MapGrid`] (in 2D: scale × offset × offset), when it is first
/// asked for, and kept; any number of threads may ask at a time.
///
/// # Which heuristic
/// Mean relative L2 error of 32² textured lights (gradient, discs, noise) over scales ¼…4 and offsets, when 20 % and
/// 30 % of the targets are asked for on 16 × 24² cells, in the standard basis (the nonstandard one has about 0.8 times
/// the error):
///
/// | heuristic | 20 % | 30 % |
/// |---|---|---|
/// | `Constant` | .403, only 4.2 % of the targets | .403, 4.2 % |
/// | `Constant`, [union](Self::with_union) of 3³ cells | .291, 19 % | .291, 19 % |
/// | `Power` of other lights, by level | .111 | .078 |
/// | the same, mean over 3³ maps a cell ([`with_samples`](Self::with_samples)) | .082 | .042 |
/// | the `Light` itself | .090 | .067 |
/// | the same, mean over 3³ maps a cell | .037 | .015 |
/// | the largest, known afterwards | .011 | .0025 |
///
/// So: `Power` with samples where lights change all the time; the light itself with samples where it is edited now and
/// then, since choices are made only for the cells in use.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Heuristic, MapGrid, Prediction};
/// use haarmonic::haar::Keep;
/// let grid = MapGrid::new([0.25, 4.0], [16, 32])?;
/// let prediction = Prediction::<1>::new(32, Heuristic::Constant, grid, Keep::Fraction(1.0))?;
/// let targets = prediction.targets([AffineMap::new(2.0, -0.4)?]); // the light is [0.2, 0.7)
/// assert!(targets.len() <= 10 && targets[..2] == [0, 1]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug)]
pub struct Prediction<const Q: usize> {
    basis: Basis,
    /// (i, F̃_i or σ_i²), without zeros.
    source: Vec<(usize, f64)>,
    squared: bool,
    grid: MapGrid,
    keep: Keep,
    samples: usize,
    reach: usize,
    best: Vec<OnceLock<Box<[u32]>>>,
    joined: Vec<OnceLock<Box<[u32]>>>,
}

#[derive(Debug, Clone, Copy)]
enum Basis {
    Line(Nonzeros1d),
    Standard(Nonzeros1d),
    Nonstandard(NonzerosNonstandard),
}

impl Prediction<1> {
    /// A prediction for 1D signals of `size` coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is one; [`Error::Length`] unless the heuristic has as many coefficients;
    /// [`Error::NotFinite`] for those that are not; [`Error::OutOfRange`] for a negative mean square, a fraction to
    /// keep outside [0, 1] and more than 2²⁶ coefficients.
    pub fn new(size: usize, heuristic: Heuristic<'_>, grid: MapGrid, keep: Keep) -> Result<Self> {
        Self::build(Basis::Line(Nonzeros1d::new(size)?), size, heuristic, grid, keep)
    }
}

impl Prediction<2> {
    /// A prediction for images of `side`² coefficients.
    ///
    /// # Errors
    /// As in 1D (a side of 8192 has 2²⁶ coefficients), and [`Error::OutOfRange`] for a grid of more than 2²⁴ cells.
    pub fn new(
        side: usize,
        decomposition: Decomposition,
        heuristic: Heuristic<'_>,
        grid: MapGrid,
        keep: Keep,
    ) -> Result<Self> {
        let nonstandard = NonzerosNonstandard::new(side)?;
        let basis = match decomposition {
            Decomposition::Standard => Basis::Standard(Nonzeros1d::new(side)?),
            Decomposition::Nonstandard => Basis::Nonstandard(nonstandard),
        };
        Self::build(basis, side * side, heuristic, grid, keep)
    }

    /// Makes `targets` those of a pair of maps, as [`Targets::new`] makes them of [`targets`](Self::targets).
    ///
    /// This is for a renderer that goes from vertex to vertex with one `Targets` a thread: its memory grows to the
    /// longest choice, and nothing is allocated after that, but for a choice that is made for the first time
    /// ([`fill`](Self::fill) makes all of them before).
    ///
    /// # Panics
    /// If the side or the basis of the targets is not that of the prediction.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{AffineMap, Heuristic, MapGrid, Prediction, Targets};
    /// use haarmonic::haar::{Decomposition::Standard, Keep};
    /// let grid = MapGrid::new([0.25, 4.0], [8, 12])?;
    /// let prediction = Prediction::<2>::new(16, Standard, Heuristic::Constant, grid, Keep::Terms(20))?;
    /// let mut targets = Targets::new(16, Standard, &[])?;
    /// for offset in [-0.3, 0.1, 0.2] {
    ///     let maps = [AffineMap::new(1.5, offset)?, AffineMap::new(1.5, -0.2)?];
    ///     prediction.set_targets(maps, &mut targets);
    ///     assert_eq!(targets, Targets::new(16, Standard, prediction.targets(maps))?);
    /// }
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn set_targets(&self, maps: [AffineMap; 2], targets: &mut Targets) {
        let (side, decomposition) = match self.basis {
            Basis::Nonstandard(nonzeros) => (nonzeros.side(), Decomposition::Nonstandard),
            Basis::Line(nonzeros) | Basis::Standard(nonzeros) => (nonzeros.size(), Decomposition::Standard),
        };
        check_length("side of the targets", side, targets.side());
        assert!(targets.decomposition() == decomposition, "the targets must have the prediction's basis");
        targets.set_checked(self.targets(maps));
    }
}

impl<const Q: usize> Prediction<Q> {
    fn build(basis: Basis, len: usize, heuristic: Heuristic<'_>, grid: MapGrid, keep: Keep) -> Result<Self> {
        check_count("coefficients of a prediction", len)?;
        keep.check()?;
        let (source, squared) = match heuristic {
            Heuristic::Constant => (vec![(0, 1.0)], false),
            Heuristic::Light(coefs) => (nonzero(len, coefs, "coefficients of a heuristic light", false)?, false),
            Heuristic::Power(squares) => (nonzero(len, squares, "mean squares of a heuristic light", true)?, true),
        };
        let [scales, offsets] = grid.resolution();
        let cells = scales as f64 * (offsets as f64).powi(Q as i32);
        if cells > f64::from(1 << 24) {
            let allowed = "at most 2²⁴";
            return Err(Error::OutOfRange { what: "cells of a prediction", got: cells, allowed });
        }
        let empty = || (0..cells as usize).map(|_| OnceLock::new()).collect();
        Ok(Self { basis, source, squared, grid, keep, samples: 1, reach: 0, best: empty(), joined: empty() })
    }

    /// Predicts the union of what all cells at most `reach` away along each axis predict: 1 is the cell and its
    /// neighbours. 0 is the default.
    ///
    /// The constant light needs it to come to the 20–30 % of the targets of which the thesis speaks.
    pub fn with_union(mut self, reach: usize) -> Self {
        self.reach = reach;
        self.joined.iter_mut().for_each(|cell| drop(cell.take()));
        self
    }

    /// Ranks targets by the mean of L̃_k² over so many maps an axis of a cell (at least 1), rather than by its centre
    /// alone, which is the default.
    ///
    /// Edges move by a cell's width within it: a choice for the centre alone misses the finest wavelets of most maps. A
    /// choice takes `samples`^(Q + 1) times as long; more than 64 are held at 64.
    pub fn with_samples(mut self, samples: usize) -> Self {
        self.samples = samples.clamp(1, 64);
        self.best.iter_mut().chain(&mut self.joined).for_each(|cell| drop(cell.take()));
        self
    }

    /// The flat indices, ascending, of the targets to compute. None where nothing of the light is in sight; a scale
    /// outside the grid counts as its nearest.
    pub fn targets(&self, maps: [AffineMap; Q]) -> &[u32] {
        let mut place = [0; Q];
        for (place, map) in place.iter_mut().zip(maps) {
            match self.grid.nearest_offset(map) {
                Some(offset) => *place = offset,
                None => return &[],
            }
        }
        self.cell(self.grid.nearest_scale(maps[0]), place)
    }

    /// Makes every choice now, on all threads.
    pub fn fill(&self) {
        let [_, offsets] = self.grid.resolution();
        let cells = |k: usize| {
            let mut rest = k;
            let place = [(); Q].map(|()| {
                let offset = rest % offsets;
                rest /= offsets;
                offset
            });
            self.cell(rest, place);
        };
        parallel::map(self.best.len(), cells);
    }

    /// Bytes of the choices made so far.
    pub fn bytes(&self) -> usize {
        let indices = |cells: &[OnceLock<Box<[u32]>>]| {
            cells.iter().filter_map(OnceLock::get).map(|targets| size_of_val(&**targets)).sum::<usize>()
        };
        2 * size_of_val(&self.best[..]) + indices(&self.best) + indices(&self.joined)
    }

    fn flat(&self, scale: usize, place: [usize; Q]) -> usize {
        place.iter().rev().fold(scale, |flat, &offset| flat * self.grid.resolution()[1] + offset)
    }

    fn cell(&self, scale: usize, place: [usize; Q]) -> &[u32] {
        if self.reach == 0 {
            return self.best_of(scale, place);
        }
        self.joined[self.flat(scale, place)].get_or_init(|| {
            let [scales, offsets] = self.grid.resolution();
            let near = |at: usize, count: usize| {
                at.saturating_sub(self.reach)..=(at.saturating_add(self.reach)).min(count - 1)
            };
            let mut all: Vec<u32> = Vec::new();
            for s in near(scale, scales) {
                let mut at = place.map(|o| *near(o, offsets).start());
                loop {
                    all.extend(self.best_of(s, at));
                    // Count on: the first axis that is not at its end moves, those before it go back.
                    let Some(axis) = (0..Q).find(|&q| at[q] < *near(place[q], offsets).end()) else { break };
                    at[axis] += 1;
                    (0..axis).for_each(|q| at[q] = *near(place[q], offsets).start());
                }
            }
            all.sort_unstable();
            all.dedup();
            all.into()
        })
    }

    fn best_of(&self, scale: usize, place: [usize; Q]) -> &[u32] {
        self.best[self.flat(scale, place)].get_or_init(|| {
            let share = |k: usize| (k as f64 + 0.5) / self.samples as f64;
            let mut sum: Vec<f64> = Vec::new();
            for sample in 0..self.samples.pow(1 + Q as u32) {
                // The digits of the number of the sample: first the share of s, then those of the offsets.
                let mut rest = sample / self.samples;
                let maps = place.map(|offset| {
                    let digit = rest % self.samples;
                    rest /= self.samples;
                    self.grid.within([scale, offset], [share(sample % self.samples), share(digit)])
                });
                let scores = self.scores(maps);
                sum.resize(scores.len(), 0.0);
                let power = |score: f64| if self.squared { score } else { score * score };
                sum.iter_mut().zip(scores).for_each(|(sum, score)| *sum += power(score));
            }
            largest(&sum, self.keep.of(sum.len()))
        })
    }

    /// L̃_k of all targets, or its square.
    fn scores(&self, maps: [AffineMap; Q]) -> Vec<f64> {
        let measure = |d: f64| if self.squared { d * d } else { d };
        match self.basis {
            Basis::Line(nonzeros) => {
                let mut scores = vec![0.0; nonzeros.size()];
                for &(i, f) in &self.source {
                    nonzeros.row(i, maps[0], |j, d| scores[j] += f * measure(d));
                }
                scores
            }
            Basis::Nonstandard(nonzeros) => {
                let mut scores = vec![0.0; nonzeros.side() * nonzeros.side()];
                for &(i, f) in &self.source {
                    nonzeros.row(i, [maps[0], maps[1]], |j, d| scores[j] += f * measure(d));
                }
                scores
            }
            Basis::Standard(nonzeros) => {
                // The two passes of [Sun 2008, §4.5.5]: along x, then along y.
                let side = nonzeros.size();
                let mut half = vec![0.0; side * side];
                for &(i, f) in &self.source {
                    let row = &mut half[i / side * side..][..side];
                    nonzeros.row(i % side, maps[0], |j, d| row[j] += f * measure(d));
                }
                let mut scores = vec![0.0; side * side];
                for (i, row) in half.chunks_exact(side).enumerate().filter(|(_, row)| row.iter().any(|z| *z != 0.0)) {
                    nonzeros.row(i, maps[1], |j, d| {
                        let factor = measure(d);
                        scores[j * side..][..side].iter_mut().zip(row).for_each(|(sum, z)| *sum += factor * z);
                    });
                }
                scores
            }
        }
    }
}

/// Mean squares of 1D coefficients for [`Heuristic::Power`]: over the given lights and over the wavelets of a level.
///
/// Shapes: each light and the result have `size` elements. Without lights all is zero.
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless `size` is one; [`Error::Length`] for a light of another length; [`Error::NotFinite`]
/// for a coefficient that is not; [`Error::OutOfRange`] for mean squares that overflow, and above 2²⁶ coefficients.
/// Squares of less than 1e-154 vanish.
pub fn mean_squares_1d(size: usize, lights: &[&[f64]]) -> Result<Vec<f64>> {
    levels_of("size of a signal", size)?;
    mean_squares(size, lights, octave)
}

/// Mean squares of 2D coefficients for [`Heuristic::Power`]: over the given lights and over the wavelets of a level (of
/// a pair of levels, in the standard basis) and kind.
///
/// Shapes: each light and the result have `side`² elements. Without lights all is zero.
///
/// # Errors
/// As [`mean_squares_1d`], of the side and its square.
///
/// # Example
/// ```
/// use haarmonic::affine::mean_squares_2d;
/// use haarmonic::haar::Decomposition;
/// let light = [3.0, 0.0, 0.0, 1.0];
/// assert_eq!(mean_squares_2d(2, Decomposition::Standard, &[&light])?, [9.0, 0.0, 0.0, 1.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
pub fn mean_squares_2d(side: usize, decomposition: Decomposition, lights: &[&[f64]]) -> Result<Vec<f64>> {
    levels_of("side of an image", side)?;
    mean_squares(side.saturating_mul(side), lights, |i| match decomposition {
        Decomposition::Standard => octave(i / side) * 64 + octave(i % side),
        Decomposition::Nonstandard => match Index2d::from_flat(i) {
            Index2d::Scaling => 0,
            Index2d::Detail { level, kind, .. } => 4 * level as usize + kind as usize,
        },
    })
}

/// 0 of the scaling function, l + 1 of a wavelet.
fn octave(flat: usize) -> usize {
    flat.checked_ilog2().map_or(0, |level| level as usize + 1)
}

fn mean_squares(len: usize, lights: &[&[f64]], group: impl Fn(usize) -> usize) -> Result<Vec<f64>> {
    check_count("coefficients of a light", len)?;
    let groups = (0..len).map(&group).max().map_or(0, |g| g + 1);
    let (mut sums, mut counts) = (vec![0.0; groups], vec![0usize; groups]);
    for light in lights {
        if light.len() != len {
            return Err(Error::Length { what: "coefficients of a light", expected: len, got: light.len() });
        }
        for (i, f) in light.iter().enumerate() {
            if !f.is_finite() {
                return Err(Error::NotFinite { what: "coefficients of a light", index: i });
            }
            sums[group(i)] += f * f;
            counts[group(i)] += 1;
        }
    }
    if sums.contains(&f64::INFINITY) {
        let allowed = "finite: coefficients of at most about 1e150";
        return Err(Error::OutOfRange { what: "mean square of a light", got: f64::INFINITY, allowed });
    }
    Ok((0..len).map(|i| sums[group(i)] / counts[group(i)].max(1) as f64).collect())
}

/// More than this is a mistake: each choice takes a number a coefficient.
fn check_count(what: &'static str, len: usize) -> Result<()> {
    if len > 1 << 26 {
        return Err(Error::OutOfRange { what, got: len as f64, allowed: "at most 2^26" });
    }
    Ok(())
}

/// The non-zero elements, all checked, times the power of two that brings the largest near 1: only ratios count, and
/// squares of any magnitude stay in range.
fn nonzero(len: usize, values: &[f64], what: &'static str, squares: bool) -> Result<Vec<(usize, f64)>> {
    if values.len() != len {
        return Err(Error::Length { what, expected: len, got: values.len() });
    }
    if let Some(index) = values.iter().position(|v| !v.is_finite()) {
        return Err(Error::NotFinite { what, index });
    }
    if let Some(&got) = values.iter().find(|v| squares && **v < 0.0) {
        return Err(Error::OutOfRange { what, got, allowed: "not negative" });
    }
    let largest = values.iter().fold(0.0f64, |max, v| max.max(v.abs()));
    if largest == 0.0 {
        return Ok(Vec::new());
    }
    // In two steps: the reciprocal of the smallest numbers is not one.
    let half = (-0.5 * largest.log2()).floor().exp2();
    let scaled = values.iter().map(|v| v * half * half).enumerate();
    Ok(scaled.filter(|(_, v)| *v != 0.0).collect())
}

/// The places of the `keep` largest powers, ascending; ties go to the lower place. What is zero or rounding noise
/// (1e-13 in amplitude) is not worth a term.
fn largest(scores: &[f64], keep: usize) -> Box<[u32]> {
    let top = scores.iter().copied().fold(0.0, f64::max);
    let mut places: Vec<u32> = (0..scores.len() as u32).filter(|&k| scores[k as usize] > 1e-26 * top).collect();
    if places.len() > keep {
        let rank = |k: &u32| (std::cmp::Reverse(TotalOrder(scores[*k as usize])), *k);
        if keep > 0 {
            places.select_nth_unstable_by_key(keep - 1, rank);
        }
        places.truncate(keep);
        places.sort_unstable();
    }
    places.into()
}

/// Finite numbers in their order.
#[derive(PartialEq)]
struct TotalOrder(f64);

impl Eq for TotalOrder {}

impl PartialOrd for TotalOrder {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for TotalOrder {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
