//! Where the caps of a sum come from: directions with angles, or spheres and the places that see them.

use crate::Real;
use crate::sh::basis::load;

/// What is known of L caps.
pub(super) struct Disc<T, const L: usize> {
    pub direction: [[T; L]; 3],
    /// 1 − cos θ.
    pub versine: [T; L],
    /// 1, or 0 where there is no direction.
    pub directed: [T; L],
}

/// Caps of receivers.
pub(super) trait Discs<T: Real> {
    /// Caps a receiver.
    fn len(&self) -> usize;
    /// Caps from `first` of one receiver; those beyond the last are anything finite.
    fn caps<const L: usize>(&self, first: usize) -> Disc<T, L>;
    /// The cap of this number of the receivers from `first`; likewise.
    fn receivers<const L: usize>(&self, cap: usize, first: usize) -> Disc<T, L>;
}

/// Unit directions and angles: number j of receiver v at j · count + v.
pub(super) struct Caps<'a, T> {
    pub directions: [&'a [T]; 3],
    pub angles: &'a [T],
    pub largest: T,
    /// Receivers.
    pub count: usize,
}

impl<T: Real> Caps<'_, T> {
    #[inline(always)]
    fn load<const L: usize>(&self, first: usize, end: usize) -> Disc<T, L> {
        let [x, y, z] = self.directions.map(|d| load(&d[..end], first, T::zero()));
        let versine = versines(&load(&self.angles[..end], first, T::zero()), self.largest);
        Disc { direction: [x, y, z], versine, directed: [T::one(); L] }
    }
}

impl<T: Real> Discs<T> for Caps<'_, T> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.angles.len().checked_div(self.count).unwrap_or(0)
    }

    #[inline(always)]
    fn caps<const L: usize>(&self, first: usize) -> Disc<T, L> {
        self.load(first, self.angles.len())
    }

    #[inline(always)]
    fn receivers<const L: usize>(&self, cap: usize, first: usize) -> Disc<T, L> {
        self.load(cap * self.count + first, (cap + 1) * self.count)
    }
}

/// 1 − cos θ = 2 sin²(θ/2) for θ in 0…π, what is beyond held at its ends: the series of the sine.
#[inline(always)]
pub(super) fn versines<T: Real, const L: usize>(angles: &[T; L], largest: T) -> [T; L] {
    // (−1)^k/(2k+1)!; what is left out is below eps/4 at π/2.
    const SERIES: [f64; 12] = {
        let (mut terms, mut k) = ([1.0; 12], 1);
        while k < 12 {
            terms[k] = -terms[k - 1] / ((2 * k) * (2 * k + 1)) as f64;
            k += 1;
        }
        terms
    };
    let terms = if size_of::<T>() == 4 { &SERIES[..7] } else { &SERIES[..] };
    let mut out = *angles;
    for out in &mut out {
        let angle = if *out < T::zero() { T::zero() } else { *out };
        let angle = if angle > largest { largest } else { angle };
        let half = T::of(0.5) * angle;
        let square = half * half;
        let mut sum = T::of(terms[terms.len() - 1]);
        for &term in terms[..terms.len() - 1].iter().rev() {
            sum = T::of(term) + square * sum;
        }
        let sine = half * sum;
        *out = (sine + sine) * sine;
    }
    out
}

/// Spheres, all of them seen from every receiver.
pub(super) struct Spheres<'a, T> {
    pub centres: [&'a [T]; 3],
    pub radii: &'a [T],
    pub receivers: [&'a [T]; 3],
}

impl<T: Real> Discs<T> for Spheres<'_, T> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.radii.len()
    }

    #[inline(always)]
    fn caps<const L: usize>(&self, first: usize) -> Disc<T, L> {
        let centres = self.centres.map(|c| load(c, first, T::zero()));
        let receivers = self.receivers.map(|r| [r[0]; L]);
        seen(&centres, &load(self.radii, first, T::zero()), &receivers)
    }

    #[inline(always)]
    fn receivers<const L: usize>(&self, cap: usize, first: usize) -> Disc<T, L> {
        let receivers = self.receivers.map(|r| load(r, first, T::zero()));
        let centres = self.centres.map(|c| [c[cap]; L]);
        seen(&centres, &[self.radii[cap]; L], &receivers)
    }
}

/// What spheres are as caps.
///
/// ```math
/// s = r/d,  1 − cos θ = s²/(1 + √(1 − s²)),  s = 1 at d ≤ r
/// ```
#[inline(always)]
fn seen<T: Real, const L: usize>(centres: &[[T; L]; 3], radii: &[T; L], receivers: &[[T; L]; 3]) -> Disc<T, L> {
    let (zero, one) = (T::zero(), T::one());
    let (mut square, mut inverse) = ([zero; L], [zero; L]);
    let mut out = Disc { direction: *centres, versine: *radii, directed: [one; L] };
    for axis in 0..3 {
        for i in 0..L {
            out.direction[axis][i] -= receivers[axis][i];
        }
        for i in 0..L {
            square[i] += out.direction[axis][i] * out.direction[axis][i];
        }
    }
    for i in 0..L {
        inverse[i] = one / square[i].sqrt();
        out.directed[i] = if square[i] == zero { zero } else { one };
        inverse[i] = if square[i] == zero { zero } else { inverse[i] };
    }
    for axis in 0..3 {
        for i in 0..L {
            out.direction[axis][i] *= inverse[i];
        }
    }
    for i in 0..L {
        let sine = if square[i] == zero { one } else { radii[i] * inverse[i] };
        // No radius is no cap, even at the centre; NaN stays.
        let sine = if radii[i] <= zero { zero } else { sine };
        let sine = if sine > one { one } else { sine };
        out.versine[i] = sine * sine / (one + ((one - sine) * (one + sine)).sqrt());
    }
    out
}
