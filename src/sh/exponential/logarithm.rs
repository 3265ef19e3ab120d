//! Logarithms of expansions.

use super::ONE;
use super::grid::GridFunction;
use super::series::check_bands;
use super::spectrum::{ProductSpectrum, check_input};
use super::zonal::{Zonal, check_largest, log_ratio};
use crate::error::check_length;
use crate::sh::Product;
use crate::{Error, Real, Result};

/// How a logarithm treats values that are 0 or negative, which have none.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum LogMethod {
    /// The inverse of exp by products: eigenvalues of M_g below `floor` times the largest of them are raised to that
    /// [Sun 2008, eqs. 5.33, 5.35].
    Eigenvalues {
        /// ε, as a share of the largest eigenvalue.
        floor: f64,
    },
    /// log(max(g, floor · max g)) point by point on a grid [Sun 2008, eq. 5.28], for comparison: the inverse of no
    /// truncated exp, and the kink at the floor rings.
    Clipped {
        /// ε, as a share of the largest value on the grid.
        floor: f64,
    },
}

impl Default for LogMethod {
    /// Eigenvalues, 0.02 of the largest.
    fn default() -> Self {
        Self::Eigenvalues { floor: 0.02 }
    }
}

/// log g of expansions whose function may be 0 or negative here and there, as projected visibility is.
///
/// ```math
/// log g = Rᵀ q′(max(D, ε λ_max)) R (g − 1),  q′(x) = log x/(x − 1),  M_g = Rᵀ D R     [Sun 2008, eqs. 5.33–5.35]
/// ```
///
/// Where no eigenvalue is clipped this is log(M_g)·1, and exp(M_f)·1 gives g back to some 1e-5 (M of log g is not log
/// of M_g but for the first column). The largest eigenvalue is that of all of M_g.
///
/// Shapes: g, out: bands², index l(l+1)+m. Accuracy: 1e-11 of golden values in f64. Cost: about 10 bands⁶ operations
/// and allocations: for precomputation. A vector about the z axis is cheap by [`apply_zonal`](Self::apply_zonal); discs
/// are tabulated by [`CapLog`](super::CapLog).
///
/// # Example
/// ```
/// use haarmonic::sh::{LogMethod, Logarithm};
/// let one = (4.0 * std::f64::consts::PI).sqrt();
/// let log = Logarithm::new(3, LogMethod::default())?;
/// let mut out = [0.0f64; 9];
/// log.apply(&[0.5 * one, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &mut out)?;
/// assert!((out[0] / one - 0.5f64.ln()).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Logarithm {
    bands: usize,
    method: LogMethod,
    product: Product<f64>,
    zonal: Zonal,
    grid: GridFunction<f64>,
}

impl Logarithm {
    /// A plan of log for expansions of `bands` bands.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if `bands` is not in 1…32, or the floor is not above 0 and below 1.
    pub fn new(bands: usize, method: LogMethod) -> Result<Self> {
        check_bands(bands)?;
        let (LogMethod::Eigenvalues { floor } | LogMethod::Clipped { floor }) = method;
        if !(floor > 0.0 && floor < 1.0) {
            return Err(Error::OutOfRange {
                what: "floor of the logarithm",
                got: floor,
                allowed: "above 0 and below 1",
            });
        }
        Ok(Self {
            bands,
            method,
            product: Product::new(bands, bands, bands)?,
            zonal: Zonal::new(bands)?,
            grid: GridFunction::with_rings(bands, (6 * bands).clamp(32, 128))?,
        })
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// `out` = log g.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if g has NaN or infinity, [`Error::OutOfRange`] if nothing of g is positive (the largest
    /// eigenvalue or value, as of the zero vector, which is the visibility of nothing at all: give what is hidden
    /// everywhere a small constant instead).
    ///
    /// # Panics
    /// If `g.len()` or `out.len()` is not bands².
    #[track_caller]
    pub fn apply<T: Real>(&self, g: &[T], out: &mut [T]) -> Result<()> {
        let size = self.bands * self.bands;
        let g: Vec<f64> = g.iter().map(|x| x.widen()).collect();
        check_length("expansion", size, g.len());
        check_length("logarithm", size, out.len());
        check_input("expansion", size, &g)?;
        let log = match self.method {
            LogMethod::Eigenvalues { floor } => self.by_eigenvalues(&g, floor)?,
            LogMethod::Clipped { floor } => self.on_grid(&g, floor)?,
        };
        out.iter_mut().zip(log).for_each(|(out, x)| *out = T::of(x));
        Ok(())
    }

    fn by_eigenvalues(&self, g: &[f64], floor: f64) -> Result<Vec<f64>> {
        let spectrum = ProductSpectrum::new(&self.product, g)?;
        let lowest = floor * check_largest(spectrum.largest())?;
        let mut less_one = g.to_vec();
        less_one[0] -= ONE;
        let ratio = |x: f64| log_ratio(x.max(lowest), x.max(lowest) - 1.0);
        Ok(spectrum.multiply(ratio, &less_one))
    }

    fn on_grid(&self, g: &[f64], floor: f64) -> Result<Vec<f64>> {
        let (mut log, largest) = (vec![0.0; g.len()], std::cell::Cell::new(f64::NEG_INFINITY));
        let note = |x: f64| {
            largest.set(largest.get().max(x));
            x
        };
        self.grid.apply(g, note, &mut log);
        let lowest = floor * check_largest(largest.get())?;
        self.grid.apply(g, |x| x.max(lowest).ln(), &mut log);
        Ok(log)
    }

    /// The same of a function of z alone: `g` and `out` are the coefficients (l, 0), one for each band. M_g falls into
    /// a block for each order m: about bands⁴ operations.
    ///
    /// # Errors
    /// As [`apply`](Self::apply).
    ///
    /// # Panics
    /// If `g.len()` or `out.len()` is not the number of bands.
    #[track_caller]
    pub fn apply_zonal<T: Real>(&self, g: &[T], out: &mut [T]) -> Result<()> {
        let zonal: Vec<f64> = g.iter().map(|x| x.widen()).collect();
        check_length("zonal expansion", self.bands, zonal.len());
        check_length("zonal logarithm", self.bands, out.len());
        check_input("zonal expansion", self.bands, &zonal)?;
        let log = match self.method {
            LogMethod::Eigenvalues { floor } => self.zonal.log(&zonal, 0.0, floor)?.log,
            LogMethod::Clipped { floor } => {
                let mut full = vec![0.0; self.bands * self.bands];
                zonal.iter().enumerate().for_each(|(l, &g)| full[l * l + l] = g);
                let log = self.on_grid(&full, floor)?;
                (0..self.bands).map(|l| log[l * l + l]).collect()
            }
        };
        out.iter_mut().zip(log).for_each(|(out, x)| *out = T::of(x));
        Ok(())
    }
}
