//! Look-ups in visibility distance tables.

use super::binary_map::BinaryMap;
use super::coverage::{self, Coverage};
use super::visibility_distance::{Border, VisibilityDistancePlan, VisibilityDistanceScratch};
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::{Error, Result};

/// A visibility distance table to look up in: a borrowed [`VisibilityDistance`], or one of many in the caller's memory.
///
/// Points are in pixels: pixel (x, y) is [x, x + 1] × [y, y + 1], and its entry holds at its centre.
#[derive(Debug, Clone, Copy)]
pub struct VisibilityDistanceRef<'a> {
    width: usize,
    height: usize,
    border: Border,
    distances: &'a [f32],
}

/// What one look-up finds.
#[derive(Debug, Clone, Copy)]
struct Found {
    distance: f64,
    gradient: [f64; 2],
}

impl<'a> VisibilityDistanceRef<'a> {
    /// Looks at a table that [`VisibilityDistancePlan`] filled.
    ///
    /// # Panics
    /// If `distances.len()` is not the plan's [`len`](VisibilityDistancePlan::len), or is 0.
    #[inline]
    #[track_caller]
    pub fn new(plan: &VisibilityDistancePlan, distances: &'a [f32]) -> Self {
        check_length("distances", plan.len(), distances.len());
        assert!(!distances.is_empty(), "a distance table to look up in is empty");
        Self { width: plan.width(), height: plan.height(), border: plan.border(), distances }
    }

    /// The entries, row by row.
    #[inline]
    pub fn distances(&self) -> &'a [f32] {
        self.distances
    }

    /// D at a point, bilinear between the centres of pixels.
    ///
    /// Beyond the outermost centres it is held ([`Border::Open`]), or falls by the distance to them ([`Border::Zero`]):
    /// there is nothing to see outside. NaN gives NaN.
    #[inline]
    pub fn at(&self, point: [f64; 2]) -> f64 {
        self.find(point).distance
    }

    /// The gradient of [`at`](Self::at); its direction is that from the nearest boundary into what is visible.
    ///
    /// Beyond the outermost centres of an open map, where [`at`](Self::at) is held, that of the nearest place inside.
    /// NaN gives NaN.
    #[inline]
    pub fn gradient(&self, point: [f64; 2]) -> [f64; 2] {
        self.find(point).gradient
    }

    /// The visible share of a square of edge `edge` around a point, from one look-up.  [Xu 2006 eq. 9, corrected]
    ///
    /// An infinite centre is beyond the border, with all that follows of it; NaN gives NaN.
    /// Accuracy: see docs/table.md for each form; none sees what is thinner than the square, where a
    /// [`SummedArea`](crate::table::SummedArea) of the map does.
    #[inline]
    pub fn coverage(&self, centre: [f64; 2], edge: f64, form: Coverage) -> f64 {
        let Found { distance, gradient } = self.find(centre);
        match form {
            Coverage::Gradient => coverage::half_plane_coverage(distance, edge, gradient),
            Coverage::Mean => coverage::mean_coverage(distance, edge),
            Coverage::Smoothstep => coverage::smoothstep_coverage(distance, edge),
            Coverage::Linear => coverage::linear_coverage(distance, edge),
        }
    }

    #[inline(always)]
    fn find(&self, [x, y]: [f64; 2]) -> Found {
        let (u, v) = (axis(x, self.width), axis(y, self.height));
        let [[a, b], [c, d]] = [v.low, v.high].map(|row| {
            let row = &self.distances[row * self.width..][..self.width];
            [row[u.low], row[u.high]].map(f64::from)
        });
        let (top, bottom) = (a + u.within * (b - a), c + u.within * (d - c));
        let mut distance = top + v.within * (bottom - top);
        let mut gradient = [(b - a) + v.within * ((d - c) - (b - a)), bottom - top];
        if u.within.is_nan() || v.within.is_nan() {
            gradient = [f64::NAN; 2];
        }
        if self.border == Border::Zero {
            let away = u.beyond.hypot(v.beyond);
            if away > 0.0 {
                distance -= away;
                // Of an infinite or nearly infinite distance only the direction is left.
                let far = away > 1e300;
                let size = u.beyond.abs().max(v.beyond.abs());
                let [x, y] = [u.beyond, v.beyond].map(|beyond| match beyond {
                    _ if !far => beyond,
                    _ if size.is_finite() => beyond / size,
                    _ if beyond.is_infinite() => beyond.signum(),
                    _ => 0.0 * beyond, // NaN stays
                });
                let away = if far { x.hypot(y) } else { away };
                for (slope, (beyond, step)) in gradient.iter_mut().zip([(u.beyond, x), (v.beyond, y)]) {
                    *slope = if beyond == 0.0 { *slope } else { -step / away };
                }
            }
        }
        Found { distance, gradient }
    }
}

/// A coordinate between the centres of two pixels, and how far it is beyond the outermost.
#[derive(Debug, Clone, Copy)]
struct Between {
    low: usize,
    high: usize,
    within: f64,
    beyond: f64,
}

#[inline(always)]
fn axis(x: f64, size: usize) -> Between {
    let last = (size - 1) as f64;
    let from_centre = x - 0.5;
    let held = from_centre.clamp(0.0, last);
    let low = (held as usize).min(size.saturating_sub(2));
    Between { low, high: (low + 1).min(size - 1), within: held - low as f64, beyond: from_centre - held }
}

/// A visibility distance table of its own; a convenience that allocates, see [`VisibilityDistancePlan`].
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::table::{Coverage, Border, VisibilityDistance};
/// // The left half is visible; so is a quarter of a square that reaches that far into it.
/// let map: Vec<bool> = (0..64).map(|i| i % 8 < 4).collect();
/// let table = VisibilityDistance::new([8, 8], map.as_slice(), Border::Open)?;
/// assert_eq!(table.as_ref().at([4.5, 4.0]), -0.5);
/// assert_eq!(table.as_ref().coverage([4.5, 4.0], 2.0, Coverage::Gradient), 0.25);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct VisibilityDistance {
    size: [usize; 2],
    border: Border,
    distances: Vec<f32>,
}

impl VisibilityDistance {
    /// The table of a map of size [width, height].
    ///
    /// # Errors
    /// Those of [`VisibilityDistancePlan::new`]; [`Error::Empty`] if the map has no pixels; [`Error::Length`] if its
    /// length is not that of its size (see [`BinaryMap`]).
    pub fn new<'m>(size: [usize; 2], map: impl Into<BinaryMap<'m>>, border: Border) -> Result<Self> {
        let plan = VisibilityDistancePlan::new(size[0], size[1], border)?;
        let map = map.into();
        if plan.len() == 0 {
            return Err(Error::Empty { what: "binary map" });
        }
        map.length_error(plan.len(), 1)?;
        let mut distances = vec![0.0; plan.len()];
        plan.distances(map, &mut distances, &mut VisibilityDistanceScratch::default());
        Ok(Self { size, border, distances })
    }

    /// The table to look up in.
    #[inline]
    pub fn as_ref(&self) -> VisibilityDistanceRef<'_> {
        let [width, height] = self.size;
        VisibilityDistanceRef { width, height, border: self.border, distances: &self.distances }
    }
}

approx_by_parts!([] VisibilityDistance, f32, |t| close [&t.distances] same [t.size, t.border]);
