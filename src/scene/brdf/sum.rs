//! BRDFs made of BRDFs, and of closures.

use std::sync::Arc;

use nalgebra::Vector3;

use super::{Brdf, DirectionTable, Structure, plane_count};
use crate::scene::LocalFrame;
use crate::{Error, Result};

/// A weighted sum of BRDFs: diffuse plus specular.
///
/// Energy is the caller's: the directional albedo is at most the sum of weight × the terms' albedos.
/// [`BrdfSpec`](super::BrdfSpec) keeps it at or below 1.
#[derive(Debug, Clone)]
pub struct Sum {
    terms: Vec<(f64, Arc<dyn Brdf>)>,
}

impl Sum {
    /// Σ weight · term.
    ///
    /// # Errors
    /// [`Error::Empty`] without terms, [`Error::OutOfRange`] for a weight that is negative, infinite or NaN, or for
    /// sums within sums more than 64 deep or of more than 4096 terms in all.
    pub fn new(terms: Vec<(f64, Arc<dyn Brdf>)>) -> Result<Self> {
        if terms.is_empty() {
            return Err(Error::Empty { what: "sum of BRDFs" });
        }
        if let Some(&(got, _)) = terms.iter().find(|(w, _)| !(*w >= 0.0 && w.is_finite())) {
            return Err(Error::OutOfRange { what: "weight of a BRDF", got, allowed: "finite and at least 0" });
        }
        check_size(&terms, MOST_DEEP, &mut 0)?;
        Ok(Self { terms })
    }
}

/// How deep sums may be: what visits the terms calls itself for each sum among them.
const MOST_DEEP: usize = 64;
/// How many terms they may have in all, each counted as often as it is met.
const MOST_TERMS: usize = 4096;

fn check_size(terms: &[(f64, Arc<dyn Brdf>)], deep: usize, count: &mut usize) -> Result<()> {
    *count += terms.len();
    if *count > MOST_TERMS {
        let got = *count as f64;
        return Err(Error::OutOfRange { what: "terms of a sum of BRDFs", got, allowed: "at most 4096 in all" });
    }
    if deep == 0 {
        let got = (MOST_DEEP + 1) as f64;
        return Err(Error::OutOfRange { what: "depth of a sum of BRDFs", got, allowed: "at most 64" });
    }
    terms.iter().try_for_each(|(_, brdf)| match brdf.structure() {
        Structure::Sum(terms) => check_size(terms, deep - 1, count),
        _ => Ok(()),
    })
}

impl Brdf for Sum {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        self.terms.iter().map(|(weight, brdf)| brdf.eval(wi, wo) * *weight).sum()
    }

    /// The terms' colour if all of them have the same one.
    fn colour(&self) -> Option<Vector3<f64>> {
        let first = self.terms[0].1.colour()?;
        self.terms[1..].iter().all(|(_, brdf)| brdf.colour() == Some(first)).then_some(first)
    }

    fn structure(&self) -> Structure<'_> {
        Structure::Sum(&self.terms)
    }

    fn is_isotropic(&self) -> bool {
        self.terms.iter().all(|(_, brdf)| brdf.is_isotropic())
    }

    fn is_view_independent(&self) -> bool {
        self.terms.iter().all(|(_, brdf)| brdf.is_view_independent())
    }

    fn add_cos(&self, frame: &LocalFrame, wo: &Vector3<f64>, directions: &DirectionTable, scale: f64, out: &mut [f32]) {
        plane_count(self.colour().is_some(), directions.len(), out.len());
        for (weight, brdf) in &self.terms {
            brdf.add_cos(frame, wo, directions, scale * weight, out);
        }
    }
}

/// A BRDF from a closure (wi, wo) → RGB in local coordinates.
///
/// The closure is only called with both directions above the horizon.
#[derive(Clone)]
pub struct BrdfFn<F> {
    f: F,
    colour: Option<Vector3<f64>>,
}

impl<F: Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64> + Send + Sync> BrdfFn<F> {
    /// Wraps an RGB closure.
    pub fn new(f: F) -> Self {
        Self { f, colour: None }
    }
}

impl BrdfFn<()> {
    /// Wraps a scalar closure: the same value in all three channels, so that back ends integrate one.
    pub fn grey<F>(f: F) -> BrdfFn<impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64> + Send + Sync>
    where
        F: Fn(&Vector3<f64>, &Vector3<f64>) -> f64 + Send + Sync,
    {
        BrdfFn {
            f: move |wi: &Vector3<f64>, wo: &Vector3<f64>| Vector3::repeat(f(wi, wo)),
            colour: Some(Vector3::repeat(1.0)),
        }
    }
}

impl<F> std::fmt::Debug for BrdfFn<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BrdfFn").field("colour", &self.colour).finish_non_exhaustive()
    }
}

impl<F: Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64> + Send + Sync> Brdf for BrdfFn<F> {
    fn eval(&self, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
        super::off_surface(wi, wo).unwrap_or_else(|| (self.f)(wi, wo))
    }

    fn colour(&self) -> Option<Vector3<f64>> {
        self.colour
    }
}
