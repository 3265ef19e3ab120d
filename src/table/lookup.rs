//! Integrals over rectangles, from the entries at their corners.

use super::{Outside, Rectangle, SummedAreaPlan};
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::{Error, Real, Result};

/// Where a bound lies between two rows or columns of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) low: usize,
    pub(super) high: usize,
    pub(super) within: f64,
}

impl Place {
    /// A bound is held inside the image: beyond it there is nothing to add.
    #[inline(always)]
    pub(super) fn new(bound: f64, size: usize) -> Self {
        let held = bound.clamp(0.0, size as f64);
        let low = held as usize;
        let within = held - low as f64;
        // A bound on a grid line needs the entry of that line alone. The next entry has weight 0, but it may be NaN,
        // and 0 · NaN is NaN: `high` is `low` there, so that it is not read.
        Self { low, high: low + usize::from(within > 0.0), within }
    }
}

/// The two bounds of an axis and, where it wraps, how many whole images lie between them.
#[derive(Debug, Clone, Copy)]
struct Axis {
    bounds: [Place; 2],
    turns: f64,
}

impl Axis {
    #[inline(always)]
    fn new(bounds: [f64; 2], size: usize, outside: Outside) -> Self {
        if outside == Outside::Zero || size == 0 {
            return Self { bounds: bounds.map(|bound| Place::new(bound, size)), turns: 0.0 };
        }
        let period = size as f64;
        let turn = bounds.map(|bound| (bound / period).floor());
        let place = |k: usize| Place::new(bounds[k] - turn[k] * period, size);
        Self { bounds: [place(0), place(1)], turns: turn[1] - turn[0] }
    }
}

/// A summed-area table to look integrals up in: a borrowed [`SummedArea`], or one of many tables in the caller's
/// memory.
///
/// The table is bilinear within pixels, as the integral of a function constant on each pixel is: look-ups are exact for
/// any rectangle. They widen entries to `f64` before they subtract, and return `f64`. A bound that is NaN gives NaN;
/// infinite bounds reach to the image's end ([`Outside::Wrap`]: NaN).
#[derive(Debug, Clone, Copy)]
pub struct SummedAreaRef<'a, T> {
    width: usize,
    height: usize,
    entries: &'a [T],
}

impl<'a, T: Real> SummedAreaRef<'a, T> {
    /// Looks at a table that [`SummedAreaPlan`] filled.
    ///
    /// # Panics
    /// If `entries.len()` is not the plan's [`table_len`](SummedAreaPlan::table_len).
    #[inline]
    #[track_caller]
    pub fn new(plan: &SummedAreaPlan, entries: &'a [T]) -> Self {
        check_length("table", plan.table_len(), entries.len());
        Self { width: plan.width(), height: plan.height(), entries }
    }

    /// The width of the image.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The height of the image.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All entries, row by row.
    #[inline]
    pub fn entries(&self) -> &'a [T] {
        self.entries
    }

    /// ∫ f over a rectangle, nothing outside the image; negative where the rectangle is inverted along one axis, 0
    /// where it is empty.
    /// ```math
    /// (S(b, r) − S(b, l)) − (S(t, r) − S(t, l))                    [Xu 2006 eq. 2]
    /// ```
    ///
    /// Accuracy: some ε of the largest entry it meets, absolute.
    #[inline]
    pub fn sum(&self, rectangle: Rectangle) -> f64 {
        let Rectangle { left, top, right, bottom } = rectangle;
        let x = [left, right].map(|bound| Place::new(bound, self.width));
        self.across(Place::new(bottom, self.height), x) - self.across(Place::new(top, self.height), x)
    }

    /// [`sum`](Self::sum) with a choice of what lies [outside](Outside), along x and along y.
    ///
    /// Accuracy: bounds many images away lose the digits that their turns take.
    #[inline]
    pub fn sum_beyond(&self, rectangle: Rectangle, outside: [Outside; 2]) -> f64 {
        let Rectangle { left, top, right, bottom } = rectangle;
        let x = Axis::new([left, right], self.width, outside[0]);
        let y = Axis::new([top, bottom], self.height, outside[1]);
        let row = |at: Place| {
            let within = self.across(at, x.bounds);
            if x.turns == 0.0 {
                return within;
            }
            within + x.turns * self.at(at, Place::new(self.width as f64, self.width))
        };
        let within = row(y.bounds[1]) - row(y.bounds[0]);
        if y.turns == 0.0 {
            return within;
        }
        within + y.turns * row(Place::new(self.height as f64, self.height))
    }

    /// The integral over the whole area of the rectangle, also of what is outside the image.
    ///
    /// A rectangle without area gives the pixel at its first corner, 0 outside.
    #[inline]
    pub fn mean(&self, rectangle: Rectangle) -> f64 {
        let area = rectangle.area();
        if area == 0.0 { self.pixel([rectangle.left, rectangle.top]) } else { self.sum(rectangle) / area }
    }

    /// The value of the pixel at a point; 0 outside the image.
    #[inline]
    pub fn pixel(&self, [x, y]: [f64; 2]) -> f64 {
        let inside = (0.0..self.width as f64).contains(&x) && (0.0..self.height as f64).contains(&y);
        if !inside {
            return if x.is_nan() || y.is_nan() { f64::NAN } else { 0.0 };
        }
        let (left, top) = (x.floor(), y.floor());
        self.sum(Rectangle { left, top, right: left + 1.0, bottom: top + 1.0 })
    }

    /// S(y, right) − S(y, left).
    #[inline(always)]
    fn across(&self, y: Place, [left, right]: [Place; 2]) -> f64 {
        self.at(y, right) - self.at(y, left)
    }

    /// S between four entries.
    #[inline(always)]
    fn at(&self, y: Place, x: Place) -> f64 {
        let pitch = self.width + 1;
        let [upper, lower] = [y.low, y.high].map(|row| {
            let row = &self.entries[row * pitch..][..pitch];
            let [low, high] = [x.low, x.high].map(|column| row[column].widen());
            low + x.within * (high - low)
        });
        upper + y.within * (lower - upper)
    }
}

/// A summed-area table of its own: any integral over a rectangle by looking at its corners.
///
/// A convenience that allocates, see [`SummedAreaPlan`]; `SummedArea<f64>` is the one to take unless memory says
/// otherwise.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::table::{Rectangle, SummedArea};
/// let table: SummedArea<f64> = SummedArea::new(2, 2, &[1.0_f32, 2.0, 3.0, 4.0])?;
/// let right_half_of_all = Rectangle { left: 0.5, top: 0.0, right: 1.5, bottom: 2.0 };
/// assert_eq!(table.as_ref().sum(right_half_of_all), 5.0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SummedArea<T> {
    width: usize,
    height: usize,
    entries: Vec<T>,
}

impl<T: Real> SummedArea<T> {
    /// The table of row-major samples.
    ///
    /// # Errors
    /// Those of [`SummedAreaPlan::new`]; [`Error::Length`] unless there are width·height samples.
    pub fn new<S: Real>(width: usize, height: usize, samples: &[S]) -> Result<Self> {
        let plan = SummedAreaPlan::new(width, height)?;
        if samples.len() != plan.samples_len() {
            return Err(Error::Length { what: "samples", expected: plan.samples_len(), got: samples.len() });
        }
        let mut entries = vec![T::zero(); plan.table_len()];
        plan.build_parallel(samples, &mut entries);
        Ok(Self { width, height, entries })
    }

    /// The table to look up in.
    #[inline]
    pub fn as_ref(&self) -> SummedAreaRef<'_, T> {
        SummedAreaRef { width: self.width, height: self.height, entries: &self.entries }
    }

    /// ∫ f over a rectangle, as [`SummedAreaRef::sum`].
    #[inline]
    pub fn sum(&self, rectangle: Rectangle) -> f64 {
        self.as_ref().sum(rectangle)
    }

    /// The integral over the area, as [`SummedAreaRef::mean`].
    #[inline]
    pub fn mean(&self, rectangle: Rectangle) -> f64 {
        self.as_ref().mean(rectangle)
    }
}

approx_by_parts!([T] SummedArea<T>, T, |t| close [&t.entries] same [t.width, t.height]);
