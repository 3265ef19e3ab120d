//! Sums over caps: zonal functions of an angle about directions, for many receivers.

mod discs;
mod kernel;
mod pieces;
mod table;

use nalgebra::Vector3;
use pulp::Arch;

use self::discs::{Caps, Discs, Spheres, versines};
use self::kernel::{Job, factors};
use self::table::{CapTable, factor_over_coefficient};
use super::{CapLog, Zonal};
use crate::error::check_length;
use crate::numeric::arch_256;
use crate::{Real, Result};

/// Sums over caps, of each of which only a direction ω and an angular radius θ are known: zonal functions f(θ) from a
/// table, turned to ω and added up.
///
/// ```math
/// out_lm += Σ_j √(4π/(2l+1)) f_l(θ_j) y_lm(ω_j)
/// ```
///
/// With the logarithm of a disc's visibility for f this is the log of the visibility of all blockers, the inner loop of
/// soft shadows by [`Exponential`](super::Exponential) [Ren 2006; Sun 2008, §5.2]. A blocker is an angle about a
/// direction, or a sphere that a receiver sees from its place: sin θ = radius/distance.
///
/// Tabulated is f_l/(1 − cos θ) over 1 − cos θ, linear between nodes, which lie closer where it bends more. So a small
/// cap keeps its relative accuracy, a sphere needs no inverse function, and no angle in azimuth is ever formed.
///
/// Shapes: directions, centres and receivers are three slices x, y, z; out: bands², index l(l+1) + m. It is added to,
/// cap after cap, in the scalar of the plan: batches have the bits of single calls, and none depends on the machine.
/// Accuracy: that of the table, [`error`](Self::error), which falls as the square of its cells, and that of the scalar,
/// 3 eps Σ |f_l(θ_j)| and a half eps of the sum for each cap.
/// Range: θ is taken as 0 if less and as [`largest`](Self::largest) if more. NaN in an angle, a radius, a centre or a
/// receiver makes all coefficients NaN, NaN in a direction those that [`Basis`](super::Basis) says.
///
/// # Example
/// ```
/// use haarmonic::nalgebra::Vector3;
/// use haarmonic::sh::{CapFit, CapLog, CapSum, ExpMethod, Exponential};
/// let sum = CapSum::<f32>::of_logarithms(&CapLog::new(4, CapFit::default())?, 256)?;
/// // Two balls of radius 1 over a receiver at the origin: the log of what they leave visible, then that itself.
/// let (mut log, mut visible) = ([0.0; 16], [0.0; 16]);
/// sum.accumulate_spheres(&Vector3::zeros(), [&[2.0, -3.0], &[0.0, 0.5], &[3.0, 4.0]], &[1.0, 1.0], &mut log);
/// Exponential::new(4, ExpMethod::default())?.apply(&log, &mut visible);
/// // Of √4π, the coefficient of the open sky, they take √π Σ (1 − cos θ).
/// let sky = (4.0 * std::f32::consts::PI).sqrt();
/// assert!((visible[0] - (sky - 0.105)).abs() < 0.01);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CapSum<T> {
    table: CapTable<T>,
    largest: f64,
    error: f64,
    arch: Arch,
}

impl<T: Real> CapSum<T> {
    /// A plan for any zonal function of an angle: `f` writes the `bands` coefficients f_l(θ) with respect to y_{l,0}.
    ///
    /// `knots` are angles: where f_l has a kink, and last the largest angle that is tabulated. Between them the table
    /// has `cells` cells in all, and each knot is a node. f must vanish with the solid angle of the cap, so that f_l/(1
    /// − cos θ) has a limit at 0; it is called with angles above 0, four times a cell and up to 72 times a knot more.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if `bands` is not in 1…32, the knots do not ascend in (0, π], or
    /// there are fewer cells than knots or more than 65536; [`Error::Empty`](crate::Error::Empty) without knots, and
    /// [`Error::NotFinite`](crate::Error::NotFinite) if a value is.
    pub fn new(bands: usize, knots: &[f64], cells: usize, f: impl FnMut(f64, &mut [f64])) -> Result<Self> {
        let (table, error) = CapTable::new(bands, knots, cells, f)?;
        Ok(Self { table, largest: knots[knots.len() - 1], error, arch: arch_256() })
    }

    /// A plan for logarithms of visibility, with knots where those have kinks.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if there are fewer cells than kinks and one, or more than 65536.
    pub fn of_logarithms(log: &CapLog, cells: usize) -> Result<Self> {
        let knots = [log.kinks(), &[log.largest()]].concat();
        Self::new(log.bands(), &knots, cells, |theta, out| log.eval(theta, out))
    }

    /// A plan for the caps themselves, [`Zonal::cap`]: 1 within θ, 0 beyond, for θ up to π.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if `bands` is not in 1…32 or `cells` not in 1…65536.
    pub fn of_caps(bands: usize, cells: usize) -> Result<Self> {
        Self::new(bands, &[std::f64::consts::PI], cells, |theta, out| {
            let cap = Zonal::<f64>::cap(out.len(), theta).expect("one band or more");
            out.copy_from_slice(&cap.coefficients());
        })
    }

    /// The number of bands.
    #[inline]
    pub fn bands(&self) -> usize {
        self.table.bands
    }

    /// The number of cells of the table.
    #[inline]
    pub fn cells(&self) -> usize {
        self.table.nodes.len() / self.table.bands - 1
    }

    /// The largest angle of the table.
    #[inline]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// The largest difference between the table and f_l/(1 − cos θ), at three points inside each cell.
    #[inline]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// The zonal coefficients f_l(θ) of the table, one for each band.
    ///
    /// # Panics
    /// If `out.len()` is not the number of bands.
    #[track_caller]
    pub fn eval(&self, theta: T, out: &mut [T]) {
        check_length("zonal coefficients", self.bands(), out.len());
        let u = versines(&[theta], T::of(self.largest));
        factors(&self.table, self.bands(), &u, &[T::one()], out.as_chunks_mut::<1>().0);
        for (l, out) in out.iter_mut().enumerate() {
            *out *= T::of(1.0 / factor_over_coefficient(l));
        }
    }

    /// Adds caps about unit directions, of these angular radii, to the bands² coefficients of one receiver.
    ///
    /// # Panics
    /// If the slices of directions and `angles` differ in length or `out.len()` is not bands².
    #[track_caller]
    pub fn accumulate(&self, directions: [&[T]; 3], angles: &[T], out: &mut [T]) {
        self.check_caps(1, directions, angles, out);
        self.run(self.caps(1, directions, angles), None, out);
    }

    /// [`accumulate`](Self::accumulate) for `count` receivers with equally many caps each: cap j of receiver v is at j
    /// · `count` + v, and so is coefficient j.
    ///
    /// A receiver that has fewer caps is filled up with angles of 0, which add 0.
    ///
    /// # Panics
    /// If the slices of directions and `angles` differ in length or that is not a multiple of `count`, or if
    /// `out.len()` is not `count` · bands².
    #[track_caller]
    pub fn accumulate_batch(&self, count: usize, directions: [&[T]; 3], angles: &[T], out: &mut [T]) {
        self.check_caps(count, directions, angles, out);
        self.run(self.caps(count, directions, angles), Some(count), out);
    }

    /// Adds spheres to the bands² coefficients of a receiver: caps of sin θ = radius/distance about the directions to
    /// their centres.
    ///
    /// From a sphere's surface and from within it is the hemisphere towards its centre, θ = π/2. At the centre there is
    /// no direction, and degree 0 of that hemisphere alone is added. A radius of 0 or less adds nothing. Distances
    /// should be between 1e-15 and 1e15 in `f32`, since they are squared.
    ///
    /// # Panics
    /// If the slices of centres and `radii` differ in length or `out.len()` is not bands².
    #[track_caller]
    pub fn accumulate_spheres(&self, receiver: &Vector3<T>, centres: [&[T]; 3], radii: &[T], out: &mut [T]) {
        let receivers = [0, 1, 2].map(|axis| std::slice::from_ref(&receiver[axis]));
        self.check_spheres(receivers, centres, radii, out);
        self.run(Spheres { centres, radii, receivers }, None, out);
    }

    /// [`accumulate_spheres`](Self::accumulate_spheres) for many receivers that see the same spheres: coefficient i of
    /// receiver v at i · count + v.
    ///
    /// # Panics
    /// If the slices of receivers differ in length, or those of centres and `radii`, or if `out.len()` is not bands²
    /// times the number of receivers.
    #[track_caller]
    pub fn accumulate_spheres_batch(&self, receivers: [&[T]; 3], centres: [&[T]; 3], radii: &[T], out: &mut [T]) {
        self.check_spheres(receivers, centres, radii, out);
        self.run(Spheres { centres, radii, receivers }, Some(receivers[0].len()), out);
    }

    fn caps<'a>(&self, count: usize, directions: [&'a [T]; 3], angles: &'a [T]) -> Caps<'a, T> {
        Caps { directions, angles, largest: T::of(self.largest), count }
    }

    fn run(&self, discs: impl Discs<T>, receivers: Option<usize>, out: &mut [T]) {
        self.arch.dispatch(Job { table: &self.table, discs, receivers, out });
    }

    #[track_caller]
    fn check_caps(&self, count: usize, directions: [&[T]; 3], angles: &[T], out: &[T]) {
        for coordinates in directions {
            check_length("coordinates of directions", angles.len(), coordinates.len());
        }
        let rest = angles.len().checked_rem(count).unwrap_or(angles.len());
        check_length("caps, a multiple of the receivers", angles.len() - rest, angles.len());
        check_length("coefficients", self.bands().pow(2).saturating_mul(count), out.len());
    }

    #[track_caller]
    fn check_spheres(&self, receivers: [&[T]; 3], centres: [&[T]; 3], radii: &[T], out: &[T]) {
        for coordinates in receivers {
            check_length("coordinates of receivers", receivers[0].len(), coordinates.len());
        }
        for coordinates in centres {
            check_length("coordinates of centres", radii.len(), coordinates.len());
        }
        check_length("coefficients", self.bands().pow(2).saturating_mul(receivers[0].len()), out.len());
    }
}
