//! The affine map of a whole 2D signal: a light carried to a place, an image zoomed and moved.

pub(super) mod band;
mod cost;
mod lists;
mod lookups;
mod pixel_operator;
pub(super) mod pixels;
mod source;
mod targets;
mod vertices;
mod wavelets;

use pulp::Arch;

use band::{Band, Weights};
pub use lists::TargetLists;
pub use pixel_operator::PixelOperator;
use pixels::{Resample, Scatter};
pub use source::PropagationSource;
pub use targets::Targets;
use wavelets::{Rows, TwoPass};

use super::{AffineMap, Atom, NonzerosNonstandard, Parameter};
use crate::error::check_length;
use crate::haar::{Decomposition, Transform2d};
use crate::{Error, Real, Result, parallel};

/// How a propagation is computed; all give the same numbers to rounding.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PropagationRoute {
    /// Couplings of the source's terms: in two passes, one axis after the other (standard basis), or as products
    /// (nonstandard). Its cost grows with the terms: sparse sources.
    Wavelets,
    /// Exact area resampling of the decoded pixels, one axis after the other, then the Haar transform. Its cost hardly
    /// depends on the terms: dense sources.
    Pixels,
    /// Each wanted coefficient from nine look-ups in a summed-area table: a few targets of a dense source. In f64;
    /// differences of a table lose digits where |s| is small, about ε/(s_x s_y). Below |s_x s_y| = 2⁻²⁰ pixels are
    /// resampled instead.
    Lookups,
}

impl PropagationRoute {
    /// All routes.
    pub const ALL: [Self; 3] = [Self::Wavelets, Self::Pixels, Self::Lookups];
}

/// An axis of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Columns.
    X,
    /// Rows.
    Y,
}

/// Plan of L(x, y) = F(s_x x + o_x, s_y y + o_y) in the wavelet domain, for sources of one side and targets of another
/// or the same.
///
/// ```math
/// L_k(s, o) = Σ_i F_i D_ik(s, o)                                              [Sun 2008, eq. 4.35]
/// ```
///
/// F is 0 outside [0, 1)²; L is the L² projection, exact against every image of the target's side. A light's
/// coefficients are prepared once ([`PropagationSource`]); then each place has its pair of maps and, where only a part
/// of L matters, its [`Targets`].
///
/// The two sides are one, by [`new`](Self::new), or differ, by [`between`](Self::between): a light of 64² texels seen
/// in 16² coefficients loses nothing but the details of the result that are finer.
///
/// Shapes: coefficients `source_side`² of the source and `side`² of the target, flat index of the decomposition;
/// `out`: C planes, one value a target.
/// Accuracy: a few ε of max |F| at every scale, by any route but for the caveat of [`PropagationRoute::Lookups`]; in
/// `f64`, at a target pixel k that an end of a source pixel falls into, k ε: ends are rounded by ε of their place.
/// Cost: [`route`](Self::route) picks by a fixed model of counts, never by timing. See docs/performance.md.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, Propagation, PropagationScratch, PropagationSource, Targets};
/// use haarmonic::haar::{Decomposition::Standard, forward_2d};
/// let light = forward_2d(&[0.0, 4.0, 0.0, 8.0], 2, 2, Standard)?; // bright at the right, more so below
/// let source = PropagationSource::from_dense(2, Standard, [&light])?;
/// let (plan, all) = (Propagation::new(2, Standard)?, Targets::all(2, Standard)?);
/// let right_half = [AffineMap::new(0.5, 0.5)?, AffineMap::IDENTITY];
/// let mut seen = [0.0; 4];
/// plan.apply(&source, right_half, &all, [&mut seen], &mut PropagationScratch::new());
/// assert_eq!(seen, forward_2d(&[4.0, 4.0, 8.0, 8.0], 2, 2, Standard)?[..]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Propagation<T> {
    levels: u32,
    transform: Transform2d<T>,
    source_transform: Transform2d<T>,
    arch: Arch,
}

/// Working memory of [`Propagation`]; grows on first use, then is used again. One for each thread.
#[derive(Debug, Clone)]
pub struct PropagationScratch<T> {
    bands: [Band<T>; 2],
    planes: Vec<T>,
    result: Vec<T>,
    transform: Vec<T>,
    rows: [Rows<T>; 2],
    reach: Vec<(u32, T)>,
    reach_end: Vec<u32>,
    half: Vec<T>,
}

impl<T: Real> PropagationScratch<T> {
    /// Working memory that has not grown yet.
    pub fn new() -> Self {
        Self {
            bands: [Band::new(), Band::new()],
            planes: Vec::new(),
            result: Vec::new(),
            transform: Vec::new(),
            rows: [Rows::default(), Rows::default()],
            reach: Vec::new(),
            reach_end: Vec::new(),
            half: Vec::new(),
        }
    }
}

impl<T: Real> Default for PropagationScratch<T> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a pixel of the target sees of the source, below which differences of a table are mostly rounding.
const SMALLEST_AREA: f64 = 1.0 / (1u64 << 20) as f64;

/// The largest side of a propagation.
const LARGEST: usize = 4096;

fn check_side(side: usize) -> Result<u32> {
    if side > LARGEST {
        return Err(Error::OutOfRange { what: "side of an image", got: side as f64, allowed: "at most 4096" });
    }
    super::coupling::levels_of("side of an image", side)
}

impl<T: Real> Propagation<T> {
    /// A plan for images of `side`² coefficients.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `side` is one; [`Error::OutOfRange`] above 4096.
    pub fn new(side: usize, decomposition: Decomposition) -> Result<Self> {
        Self::between(side, side, decomposition)
    }

    /// A plan for sources of `source_side`² and targets of `side`² coefficients.
    ///
    /// # Errors
    /// As [`new`](Self::new), of both sides.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{AffineMap, Propagation, PropagationScratch, PropagationSource, Targets};
    /// use haarmonic::haar::Decomposition::Standard;
    /// let source = PropagationSource::from_pixels(2, Standard, [&[0.0, 4.0, 0.0, 8.0]])?;
    /// let (plan, mean) = (Propagation::between(2, 1, Standard)?, Targets::all(1, Standard)?);
    /// let mut seen = [0.0];
    /// plan.apply(&source, [AffineMap::IDENTITY; 2], &mean, [&mut seen], &mut PropagationScratch::new());
    /// assert_eq!(seen, [3.0]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    pub fn between(source_side: usize, side: usize, decomposition: Decomposition) -> Result<Self> {
        check_side(source_side)?;
        Ok(Self {
            levels: check_side(side)?,
            transform: Transform2d::new(side, side, decomposition)?,
            source_transform: Transform2d::new(source_side, source_side, decomposition)?,
            arch: Arch::new(),
        })
    }

    /// The side of the target's images.
    #[inline]
    pub fn side(&self) -> usize {
        1 << self.levels
    }

    /// The side of the source's image.
    #[inline]
    pub fn source_side(&self) -> usize {
        self.source_transform.width()
    }

    /// The basis.
    #[inline]
    pub fn decomposition(&self) -> Decomposition {
        self.transform.decomposition()
    }

    /// The route that the cost model prefers; the same on every machine and at every time.
    pub fn route<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        targets: &Targets,
    ) -> PropagationRoute {
        cost::choose(self.levels, source, maps, targets)
    }

    /// L at the targets, for each channel of the source, by the cheapest route.
    ///
    /// # Panics
    /// If the source's or the targets' side or basis is not the plan's, or the length of a plane of `out` not the
    /// number of targets.
    #[track_caller]
    pub fn apply<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        targets: &Targets,
        out: [&mut [T]; C],
        scratch: &mut PropagationScratch<T>,
    ) {
        self.apply_by(self.route(source, maps, targets), source, maps, targets, out, scratch);
    }

    /// L at the targets by a given route.
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    #[track_caller]
    pub fn apply_by<const C: usize>(
        &self,
        route: PropagationRoute,
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        targets: &Targets,
        out: [&mut [T]; C],
        scratch: &mut PropagationScratch<T>,
    ) {
        self.check(source, targets, &out);
        let area = (maps[0].scale() * maps[1].scale()).abs();
        match route {
            PropagationRoute::Lookups if area < SMALLEST_AREA => {
                self.resample(source, maps, [Weights::Value; 2], targets, out, scratch);
            }
            PropagationRoute::Pixels => self.resample(source, maps, [Weights::Value; 2], targets, out, scratch),
            PropagationRoute::Lookups => self.look_up(source, maps, targets, out),
            PropagationRoute::Wavelets => match self.decomposition() {
                Decomposition::Nonstandard => {
                    let nonzeros = NonzerosNonstandard::new(self.side()).expect("the plan has checked the side");
                    wavelets::products(nonzeros, maps, &source.terms, targets, out);
                }
                Decomposition::Standard => {
                    let PropagationScratch { rows, reach, reach_end, half, .. } = scratch;
                    let (levels, terms) = (self.levels, &source.terms);
                    self.arch.dispatch(TwoPass { levels, maps, terms, targets, rows, reach, reach_end, half, out });
                }
            },
        }
    }

    /// ∂L/∂s or ∂L/∂o of one axis at the targets, right-hand where L has a kink; through pixels.
    ///
    /// # Panics
    /// As [`apply`](Self::apply).
    #[track_caller]
    pub fn derivative<const C: usize>(
        &self,
        (axis, parameter): (Axis, Parameter),
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        targets: &Targets,
        out: [&mut [T]; C],
        scratch: &mut PropagationScratch<T>,
    ) {
        self.check(source, targets, &out);
        let mut weights = [Weights::Value; 2];
        weights[axis as usize] = Weights::Slope(parameter);
        self.resample(source, maps, weights, targets, out, scratch);
    }

    /// [[∂J/∂s_x, ∂J/∂o_x], [∂J/∂s_y, ∂J/∂o_y]] of J = Σ_k g_k L_k, right-hand where L has a kink: what an optimiser of
    /// a light's place needs, with `cotangent` = ∂J/∂L.
    ///
    /// # Panics
    /// As [`apply`](Self::apply), of `cotangent` too.
    #[track_caller]
    pub fn gradient<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        targets: &Targets,
        cotangent: [&[T]; C],
        scratch: &mut PropagationScratch<T>,
    ) -> [[f64; 2]; 2] {
        for plane in cotangent {
            check_length("cotangent", targets.len(), plane.len());
        }
        let mut slope = std::mem::take(&mut scratch.half);
        slope.clear();
        slope.resize(C * targets.len(), T::zero());
        let gradient = [Axis::X, Axis::Y].map(|axis| {
            Parameter::ALL.map(|parameter| {
                let out = planes_of(&mut slope, targets.len());
                self.derivative((axis, parameter), source, maps, targets, out, scratch);
                let dot = |c: usize| -> f64 {
                    let slope = &slope[c * targets.len()..][..targets.len()];
                    slope.iter().zip(cotangent[c]).map(|(&l, &g)| l.widen() * g.widen()).sum()
                };
                (0..C).map(dot).sum()
            })
        });
        scratch.half = slope;
        gradient
    }

    /// G_i = Σ_k D_ik(s, o) g_k of all coefficients of one channel: the transpose, with ⟨apply(F), g⟩ = ⟨F,
    /// adjoint(g)⟩.
    ///
    /// # Panics
    /// If the length of `cotangent` is not `side`², or that of `out` not `source_side`².
    #[track_caller]
    pub fn adjoint(&self, maps: [AffineMap; 2], cotangent: &[T], out: &mut [T], scratch: &mut PropagationScratch<T>) {
        check_length("cotangent", self.side() * self.side(), cotangent.len());
        check_length("gradient", self.source_side() * self.source_side(), out.len());
        self.adjoint_pixels(maps, cotangent, out, scratch);
        self.adjoint_transform(out, scratch);
    }

    /// The adjoint but for the transform of the source: linear, so that many may be summed before it.
    fn adjoint_pixels(
        &self,
        maps: [AffineMap; 2],
        cotangent: &[T],
        out: &mut [T],
        scratch: &mut PropagationScratch<T>,
    ) {
        let sides @ [_, side] = [self.source_side(), self.side()];
        let PropagationScratch { bands, planes, transform, .. } = scratch;
        planes.resize(self.planes_len(), T::zero());
        transform.resize(self.transform.scratch_len(), T::zero());
        let planes: [&mut [T]; 2] = planes_of(planes, self.planes_len() / 2);
        self.transform.inverse(cotangent, &mut planes[0][..side * side], transform);
        self.arch.dispatch(Scatter { sides, maps, bands, out, planes });
    }

    /// A transform of side N is 1/N times an isometry: its transpose is N⁻² times its inverse.
    fn adjoint_transform(&self, out: &mut [T], scratch: &mut PropagationScratch<T>) {
        scratch.transform.resize(self.source_transform.scratch_len(), T::zero());
        self.source_transform.forward_in_place(out, &mut scratch.transform);
        if self.source_side() != self.side() {
            let factor = T::of((self.source_side() as f64 / self.side() as f64).powi(2));
            out.iter_mut().for_each(|g| *g *= factor);
        }
    }

    /// L at the targets for many pairs of maps, in parallel: `out` holds, for each pair, C planes of one value a
    /// target.
    ///
    /// The same bits for any number of threads.
    ///
    /// # Panics
    /// As [`apply`](Self::apply), or if `out.len()` is not maps × C × targets.
    #[track_caller]
    pub fn apply_batch<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: &[[AffineMap; 2]],
        targets: &Targets,
        out: &mut [T],
    ) {
        let piece = C * targets.len();
        check_length("batch of target coefficients", maps.len() * piece, out.len());
        if piece == 0 {
            return;
        }
        const CHUNK: usize = 64;
        parallel::chunks(out, CHUNK * piece, PropagationScratch::new, |k, out, scratch| {
            for (&maps, out) in maps[k * CHUNK..].iter().zip(out.chunks_exact_mut(piece)) {
                self.apply(source, maps, targets, planes_of(out, targets.len()), scratch);
            }
        });
    }

    #[track_caller]
    fn check<const C: usize>(&self, source: &PropagationSource<T, C>, targets: &Targets, out: &[&mut [T]; C]) {
        self.check_source(source);
        check_length("side of the targets", self.side(), targets.side);
        self.check_basis(targets.decomposition);
        for plane in out {
            check_length("target coefficients", targets.len(), plane.len());
        }
    }

    #[track_caller]
    fn check_source<const C: usize>(&self, source: &PropagationSource<T, C>) {
        check_length("side of the source", self.source_side(), source.side);
        self.check_basis(source.decomposition);
    }

    #[track_caller]
    fn check_basis(&self, decomposition: Decomposition) {
        let basis = self.decomposition();
        assert!(decomposition == basis, "the source and the targets must have the plan's basis, {basis:?}");
    }

    /// Two planes of the larger side.
    fn planes_len(&self) -> usize {
        2 * self.side().max(self.source_side()).pow(2)
    }

    fn resample<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        weights: [Weights; 2],
        targets: &Targets,
        out: [&mut [T]; C],
        scratch: &mut PropagationScratch<T>,
    ) {
        let PropagationScratch { bands, planes, result, transform, .. } = scratch;
        let (sides, decomposition) = ([self.source_side(), self.side()], self.decomposition());
        let area = self.side() * self.side();
        planes.resize(self.planes_len(), T::zero());
        transform.resize(self.transform.scratch_len(), T::zero());
        let mut run = |out: [&mut [T]; C]| {
            let scratch = (&mut planes[..], &mut transform[..]);
            let source = &source.pixels;
            self.arch.dispatch(Resample { sides, decomposition, maps, weights, bands, source, out, scratch });
        };
        let Some(chosen) = &targets.chosen else { return run(out) };
        result.resize(C * area, T::zero());
        run(planes_of(result, area));
        for (plane, out) in result.chunks_exact(area).zip(out) {
            for (out, &k) in out.iter_mut().zip(&chosen.index) {
                *out = plane[k as usize];
            }
        }
    }

    fn look_up<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: [AffineMap; 2],
        targets: &Targets,
        mut out: [&mut [T]; C],
    ) {
        let side = self.side();
        let mut one = |at: usize, [x, y]: [Atom; 2]| {
            let table = &source.table;
            let value = table.coefficient(&table.places(x, maps[0]), &table.places(y, maps[1]));
            for c in 0..C {
                out[c][at] = T::of(value[c]);
            }
        };
        let atoms = |k: usize| match self.transform.decomposition() {
            Decomposition::Standard => [Atom::from_flat(k % side), Atom::from_flat(k / side)],
            Decomposition::Nonstandard => Atom::from_nonstandard(k),
        };
        match &targets.chosen {
            None => (0..side * side).for_each(|k| one(k, atoms(k))),
            Some(chosen) => chosen.index.iter().enumerate().for_each(|(at, &k)| one(at, atoms(k as usize))),
        }
    }
}

/// C planes of `len` values.
fn planes_of<T, const C: usize>(all: &mut [T], len: usize) -> [&mut [T]; C] {
    let mut rest = all;
    std::array::from_fn(|_| {
        let (plane, others) = std::mem::take(&mut rest).split_at_mut(len);
        rest = others;
        plane
    })
}
