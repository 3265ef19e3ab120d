//! Any BRDF as a table of few directions.

use nalgebra::Vector3;

use super::{Brdf, off_surface};
use crate::{Error, Result};

/// A BRDF read off once at some hundred or thousand pairs of directions, for measured data whose look-ups are slow and
/// whose resolution is no finer than that of a table [Inger 2013, §4.1].
///
/// A hemisphere is cut into `rings` rings of equal height and each ring into 4 · `rings` cells, all of the same solid
/// angle, π/(2 rings²). An isotropic BRDF takes a row of `rings` cells for the viewer, others all of them; a cell of
/// both directions holds the mean of 3 × 3 values over the cell of the light, seen from the middle of the viewer's. The
/// nearest cell is read.
///
/// What that loses: lobes narrower than a cell become as wide as one, the value at grazing angles is that of the lowest
/// ring, and a table is no longer reciprocal. Bytes: 12 · 4 rings³ if isotropic, 12 · 16 rings⁴ if not (rings = 8: 24
/// kB, 786 kB).
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, scene::{Brdf, Lambert, TabulatedBrdf}};
/// let lambert = Lambert::new([0.5; 3])?;
/// let table = TabulatedBrdf::new(&lambert, 8)?;
/// let (wi, wo) = (Vector3::new(0.6, 0.0, 0.8), Vector3::z());
/// assert!((table.eval(&wi, &wo) - lambert.eval(&wi, &wo)).norm() < 1e-7);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedBrdf {
    rings: usize,
    is_isotropic: bool,
    is_view_independent: bool,
    colour: Option<Vector3<f64>>,
    /// [viewer's ring][viewer's cell, one if isotropic][ring][cell]
    values: Vec<[f32; 3]>,
}

impl TabulatedBrdf {
    /// The table of a BRDF.
    ///
    /// Cost: 9 values a cell: a few milliseconds if isotropic, some hundred if not, at 8 rings.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless 1 ≤ `rings` ≤ 32.
    pub fn new(brdf: &(impl Brdf + ?Sized), rings: usize) -> Result<Self> {
        if !(1..=32).contains(&rings) {
            return Err(Error::OutOfRange { what: "rings of a BRDF table", got: rings as f64, allowed: "in 1…32" });
        }
        let is_isotropic = brdf.is_isotropic();
        let around = if is_isotropic { 1 } else { 4 * rings };
        let mut values = Vec::with_capacity(rings * around * 4 * rings * rings);
        for ring in 0..rings {
            for cell in 0..around {
                let wo = direction(rings, ring as f64 + 0.5, if is_isotropic { 0.0 } else { cell as f64 + 0.5 });
                for i in 0..4 * rings * rings {
                    values.push(mean(brdf, rings, [i / (4 * rings), i % (4 * rings)], &wo));
                }
            }
        }
        let (colour, is_view_independent) = (brdf.colour(), brdf.is_view_independent());
        Ok(Self { rings, is_isotropic, is_view_independent, colour, values })
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }
}

impl Brdf for TabulatedBrdf {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        if let Some(value) = off_surface(wi, wo) {
            return value;
        }
        let flat = wo.x.hypot(wo.y);
        let (viewer, wi) = if self.is_isotropic {
            // Turned until the viewer's azimuth is 0.
            let (c, s) = if flat > 0.0 { (wo.x / flat, wo.y / flat) } else { (1.0, 0.0) };
            (ring(self.rings, wo.z), Vector3::new(c * wi.x + s * wi.y, c * wi.y - s * wi.x, wi.z))
        } else {
            (ring(self.rings, wo.z) * 4 * self.rings + cell(self.rings, wo), *wi)
        };
        let light = ring(self.rings, wi.z) * 4 * self.rings + cell(self.rings, &wi);
        Vector3::from(self.values[viewer * 4 * self.rings * self.rings + light]).cast()
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        self.colour
    }

    fn is_isotropic(&self) -> bool {
        self.is_isotropic
    }

    fn is_view_independent(&self) -> bool {
        self.is_view_independent
    }
}

/// The mean over a cell of the light.
fn mean(brdf: &(impl Brdf + ?Sized), rings: usize, [ring, cell]: [usize; 2], wo: &Vector3<f64>) -> [f32; 3] {
    let offsets = [1.0 / 6.0, 0.5, 5.0 / 6.0];
    let at = |u: f64, v: f64| brdf.eval(&direction(rings, ring as f64 + u, cell as f64 + v), wo);
    let sum: Vector3<f64> =
        offsets.iter().flat_map(|&u| offsets.iter().map(move |&v| (u, v))).map(|(u, v)| at(u, v)).sum();
    (sum / 9.0).cast().into()
}

/// Rings count from the normal down.
fn ring(rings: usize, z: f64) -> usize {
    (((1.0 - z) * rings as f64) as usize).min(rings - 1)
}

fn cell(rings: usize, d: &Vector3<f64>) -> usize {
    let turn = d.y.atan2(d.x) / std::f64::consts::TAU;
    ((turn.rem_euclid(1.0) * 4.0 * rings as f64) as usize).min(4 * rings - 1)
}

fn direction(rings: usize, ring: f64, cell: f64) -> Vector3<f64> {
    let z = 1.0 - ring / rings as f64;
    let (flat, azimuth) = ((1.0 - z * z).sqrt(), cell / (4 * rings) as f64 * std::f64::consts::TAU);
    Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Phong, Ward};

    #[test]
    fn the_middle_of_a_cell_reads_the_mean_over_it() {
        let models: [&dyn Brdf; 2] =
            [&Phong::new([0.5, 0.3, 0.1], 3.0).unwrap(), &Ward::new([0.4; 3], 0.5, 0.9).unwrap()];
        for (model, rings) in models.into_iter().zip([7, 4]) {
            let table = TabulatedBrdf::new(model, rings).unwrap();
            let viewers = if model.is_isotropic() { 1 } else { 4 * rings };
            assert_eq!(table.bytes(), 12 * 4 * rings * rings * rings * viewers);
            for i in 0..4 * rings * rings {
                let at = [i / (4 * rings), i % (4 * rings)];
                let wo = direction(rings, 2.5, if model.is_isotropic() { 0.0 } else { 5.5 });
                let wi = direction(rings, at[0] as f64 + 0.5, at[1] as f64 + 0.5);
                let expected = Vector3::from(mean(model, rings, at, &wo)).cast::<f64>();
                assert_eq!(table.eval(&wi, &wo), expected);
                if model.is_isotropic() {
                    let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 1.2345);
                    assert_eq!(table.eval(&(turn * wi), &(turn * wo)), expected);
                }
            }
        }
    }

    #[test]
    fn a_finer_table_is_nearer() {
        let model = Phong::new([0.5; 3], 4.0).unwrap();
        let error = |rings: usize| {
            let table = TabulatedBrdf::new(&model, rings).unwrap();
            let wo = Vector3::new(0.48, 0.36, 0.8);
            let difference = |k: usize| {
                let wi = direction(1, (k as f64 + 0.5) / 500.0, 4.0 * (k as f64 * 0.618).fract());
                (table.eval(&wi, &wo) - model.eval(&wi, &wo)).x.powi(2)
            };
            (0..500).map(difference).sum::<f64>().sqrt()
        };
        let errors = [4, 8, 16, 32].map(error);
        assert!(errors.windows(2).all(|pair| pair[1] < 0.7 * pair[0]), "{errors:?}");
        assert!(TabulatedBrdf::new(&model, 0).is_err() && TabulatedBrdf::new(&model, 33).is_err());
    }
}
