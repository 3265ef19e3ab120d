//! The canonical coupling M(r, c) and its companions with the scaling function.

use pulp::{Arch, Simd, WithSimd};

use crate::Real;
use crate::error::check_length;

/// A mother function on [0, 1).
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mother {
    /// φ: 1 on [0, 1).
    Scaling,
    /// ψ: +1 on [0, ½), −1 on [½, 1).
    Wavelet,
}

impl Mother {
    /// Both functions.
    pub const ALL: [Self; 2] = [Self::Scaling, Self::Wavelet];

    /// ∫ of the function from −∞ to x: B(x) = clamp(x, 0, 1) of φ, Λ(x) = max(0, ½ − |x − ½|) of ψ.
    #[inline(always)]
    pub(super) fn primitive<T: Real>(self, x: T) -> T {
        let (zero, half, one) = (T::zero(), T::of(0.5), T::one());
        // Not `max` and `min`: those would turn NaN into a number.
        let positive = |x: T| if x < zero { zero } else { x };
        match self {
            Self::Scaling if x > one => one,
            Self::Scaling => positive(x),
            Self::Wavelet => positive(half - (x - half).abs()),
        }
    }

    /// The derivative of the primitive at x towards `side` (its sign): the function's value just after or just before
    /// x.
    #[inline(always)]
    pub(super) fn slope(self, x: f64, side: f64) -> f64 {
        self.beside([x, x - 0.5, x - 1.0], side)
    }

    /// As [`slope`](Self::slope), from x, x − ½ and x − 1, of which only the signs count.
    #[inline(always)]
    pub(super) fn beside(self, beyond: [f64; 3], side: f64) -> f64 {
        let [from, middle, to] = beyond.map(|x| if side >= 0.0 { x >= 0.0 } else { x > 0.0 });
        match (self, from && !to, middle) {
            (_, false, _) => 0.0,
            (Self::Wavelet, true, true) => -1.0,
            _ => 1.0,
        }
    }

    /// Minus the jumps at 0, ½ and 1.
    #[inline(always)]
    pub(super) fn weights(self) -> [f64; 3] {
        match self {
            Self::Wavelet => [-1.0, 2.0, -1.0],
            Self::Scaling => [-1.0, 0.0, 1.0],
        }
    }
}

/// The canonical coupling of a transformed function f with a fixed function g, each φ or ψ.
///
/// ```math
/// M_fg(r, c) = ∫ f((u − c)/2r + ½) g(u) du                                    [Sun 2008, eq. 4.22, for ψψ]
/// ```
///
/// c is the centre and |r| half the width of the transformed function; r < 0 mirrors it. With G the primitive of g
/// (Λ of ψ, B of φ),
///
/// ```math
/// M_ψg = sgn(r) [2G(c) − G(c − |r|) − G(c + |r|)],    M_φg = G(c + |r|) − G(c − |r|),
/// ```
///
/// exact for all r ≠ 0, without a branch on the data. The table of branches of [Sun 2008, fig. 4.4] lost its absolute
/// values in print, and the three companions of M_ψψ are missing there; see docs/errata.md.
///
/// Bounds: −min(r, ½) ≤ M_ψψ ≤ 2 min(r, ½) for r > 0. M(r, ½ + c) = M(r, ½ − c); M(r, c) = 2r M(1/4r, ½ + 1/4r − c/2r).
/// M is zero at r = 0; NaN gives NaN. Many values at once: [`canonical_batch`].
///
/// # Example
/// ```
/// use haarmonic::affine::{Mother, canonical};
/// assert_eq!(canonical(Mother::Wavelet, Mother::Wavelet, 0.5, 0.5), 1.0); // ψ with itself
/// assert_eq!(canonical(Mother::Wavelet, Mother::Wavelet, 0.5, 1.0), -0.5); // moved by half its width
/// assert_eq!(canonical(Mother::Scaling, Mother::Scaling, 0.5, 1.0), 0.5);
/// ```
#[inline(always)]
pub fn canonical<T: Real>(f: Mother, g: Mother, r: T, c: T) -> T {
    let half_width = r.abs();
    let (low, high) = (g.primitive(c - half_width), g.primitive(c + half_width));
    match f {
        Mother::Scaling => high - low,
        Mother::Wavelet => {
            let middle = g.primitive(c);
            // (m − low) − (high − m) is exact where the three lie on one line with exact steps.
            let m = (middle - low) - (high - middle);
            if r < T::zero() { -m } else { m }
        }
    }
}

/// The one-sided derivative of [`canonical`] at (r, c) along (dr, dc): lim (M(r + ε dr, c + ε dc) − M(r, c))/ε for ε →
/// 0 from above.
///
/// M is piecewise linear; this is exact everywhere, kinks included. r = 0 is taken as the limit r → +0.
///
/// # Example
/// ```
/// use haarmonic::affine::{Mother, canonical_slope};
/// let slope = |dc| canonical_slope(Mother::Wavelet, Mother::Wavelet, [0.5, 0.5], [0.0, dc]);
/// assert_eq!((slope(1.0), slope(-1.0)), (-3.0, -3.0)); // a peak: it falls to both sides
/// ```
pub fn canonical_slope(f: Mother, g: Mother, [r, c]: [f64; 2], [dr, dc]: [f64; 2]) -> f64 {
    let sign = if r < 0.0 { -1.0 } else { 1.0 };
    let (half_width, widening) = (r.abs(), sign * dr);
    let at = |x: f64, step: f64| if step == 0.0 { 0.0 } else { step * g.slope(x, step) };
    let (low, high) = (at(c - half_width, dc - widening), at(c + half_width, dc + widening));
    match f {
        Mother::Scaling => high - low,
        Mother::Wavelet => sign * (2.0 * at(c, dc) - low - high),
    }
}

/// [∂M/∂r, ∂M/∂c] of [`canonical`], each the right-hand derivative where M has a kink.
///
/// ```math
/// ∂M_ψg/∂r = g(c − r) − g(c + r),  ∂M_ψg/∂c = 2g(c) − g(c − r) − g(c + r)       [Sun 2008, eqs. 4.25, 4.26]
/// ```
///
/// For r > 0 the slopes of M_ψψ are {−1, 0, 1, 2} in r and {0, ±1, ±2, ±3} in c (the thesis has ±2 in r). A derivative
/// along any direction, right- or left-handed: [`canonical_slope`].
///
/// # Example
/// ```
/// use haarmonic::affine::{Mother, canonical_gradient};
/// assert_eq!(canonical_gradient(Mother::Wavelet, Mother::Wavelet, 0.25, 0.5), [2.0, -2.0]);
/// ```
pub fn canonical_gradient(f: Mother, g: Mother, r: f64, c: f64) -> [f64; 2] {
    [[1.0, 0.0], [0.0, 1.0]].map(|along| canonical_slope(f, g, [r, c], along))
}

/// [`canonical`] of many (r, c), on the vector unit that the machine has.
///
/// Shapes: r, c, out of one length. The same bits as one by one.
/// Cost: about a nanosecond a value in f64; see docs/performance.md.
///
/// # Panics
/// If the lengths differ.
#[track_caller]
pub fn canonical_batch<T: Real>(f: Mother, g: Mother, r: &[T], c: &[T], out: &mut [T]) {
    check_length("centres", r.len(), c.len());
    check_length("couplings", r.len(), out.len());
    Arch::new().dispatch(Batch { f, g, r, c, out });
}

struct Batch<'a, T> {
    f: Mother,
    g: Mother,
    r: &'a [T],
    c: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for Batch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { f, g, r, c, out } = self;
        // One loop a pair of functions, so that nothing is decided inside.
        match (f, g) {
            (Mother::Wavelet, Mother::Wavelet) => run(Mother::Wavelet, Mother::Wavelet, r, c, out),
            (Mother::Wavelet, Mother::Scaling) => run(Mother::Wavelet, Mother::Scaling, r, c, out),
            (Mother::Scaling, Mother::Wavelet) => run(Mother::Scaling, Mother::Wavelet, r, c, out),
            (Mother::Scaling, Mother::Scaling) => run(Mother::Scaling, Mother::Scaling, r, c, out),
        }
    }
}

#[inline(always)]
fn run<T: Real>(f: Mother, g: Mother, r: &[T], c: &[T], out: &mut [T]) {
    const LANES: usize = 16;
    let (r_blocks, r_rest) = r.as_chunks::<LANES>();
    let (c_blocks, c_rest) = c.as_chunks::<LANES>();
    let (blocks, rest) = out.as_chunks_mut::<LANES>();
    for ((r, c), out) in r_blocks.iter().zip(c_blocks).zip(blocks) {
        // By value: the compiler need not ask whether the slices overlap.
        let mut m = [T::zero(); LANES];
        for k in 0..LANES {
            m[k] = canonical(f, g, r[k], c[k]);
        }
        *out = m;
    }
    for ((&r, &c), out) in r_rest.iter().zip(c_rest).zip(rest) {
        *out = canonical(f, g, r, c);
    }
}
