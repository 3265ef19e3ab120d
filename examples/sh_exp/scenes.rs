//! Unions of discs and their projected visibility.

use std::f64::consts::PI;

use haarmonic::Progress;
use haarmonic::nalgebra::{UnitVector3, Vector3};
use haarmonic::sh::Basis;
use haarmonic::sphere::SphereQuadrature;
use rayon::prelude::*;

use crate::support::Failure;

/// Sizes that are measured.
pub const BANDS: std::ops::RangeInclusive<usize> = 2..=6;
/// The smallest half angle of a disc.
pub const SMALLEST: f64 = 0.2;
/// Degree of the rule that projects the unions: 128 rings of 256 points, an error of 1e-3 at their edges.
const DEGREE: usize = 255;

/// One disc: what hides.
#[derive(Clone, Copy)]
pub struct Disc {
    pub axis: UnitVector3<f64>,
    pub angle: f64,
}

/// Unions of discs.
pub struct Scenes {
    pub discs: Vec<Vec<Disc>>,
    /// Their visibility to the most bands; fewer bands are its first coefficients.
    visibility: Vec<Vec<f64>>,
}

impl Scenes {
    /// `count` unions of 1, 2, … 8, 1, 2, … discs of half angles up to `largest`.
    pub fn new(count: usize, largest: f64, bands: usize, progress: &dyn Progress) -> Result<Self, Failure> {
        let mut random = Random(1);
        let mut disc = || {
            let (z, phi) = (2.0 * random.next() - 1.0, 2.0 * PI * random.next());
            let across = (1.0 - z * z).sqrt();
            let axis = UnitVector3::new_normalize(Vector3::new(across * phi.cos(), across * phi.sin(), z));
            Disc { axis, angle: SMALLEST + (largest - SMALLEST) * random.next() }
        };
        let discs: Vec<Vec<Disc>> = (0..count).map(|k| (0..k % 8 + 1).map(|_| disc()).collect()).collect();
        let rule = SphereQuadrature::new(DEGREE)?;
        let basis = Basis::<f64>::new(bands)?;
        let done = std::sync::atomic::AtomicUsize::new(0);
        let visibility = discs
            .par_iter()
            .map(|discs| {
                let seen = project(&rule, &basis, discs);
                progress.advance(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed), count);
                seen
            })
            .collect();
        Ok(Self { discs, visibility })
    }

    /// The visibility of a union.
    pub fn visibility(&self, k: usize, bands: usize) -> &[f64] {
        &self.visibility[k][..bands * bands]
    }

    pub fn len(&self) -> usize {
        self.discs.len()
    }
}

fn project(rule: &SphereQuadrature, basis: &Basis<f64>, discs: &[Disc]) -> Vec<f64> {
    let cosines: Vec<f64> = discs.iter().map(|disc| disc.angle.cos()).collect();
    let (mut points, mut weights) = ([Vec::new(), Vec::new(), Vec::new()], Vec::new());
    for (d, weight) in rule.directions().iter().zip(rule.weights()) {
        if discs.iter().zip(&cosines).all(|(disc, &cosine)| disc.axis.dot(d) < cosine) {
            points.iter_mut().zip(d.iter()).for_each(|(list, x)| list.push(*x));
            weights.push(*weight);
        }
    }
    let mut out = vec![0.0; basis.coefficient_count()];
    basis.accumulate(&points[0], &points[1], &points[2], [&weights], [&mut out]);
    out
}

/// A small generator, the same numbers every time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A zonal expansion about another axis than z: f_lm = √(4π/(2l+1)) f_l y_lm(axis).
pub fn turned(zonal: &[f64], axis: &UnitVector3<f64>, basis: &Basis<f64>) -> Vec<f64> {
    let mut y = vec![0.0; basis.coefficient_count()];
    basis.eval(axis, &mut y);
    for (i, y) in y.iter_mut().enumerate() {
        let l = i.isqrt();
        *y *= (4.0 * PI / (2 * l + 1) as f64).sqrt() * zonal[l];
    }
    y
}

/// Visibility of a disc about z [Sun 2008, eq. 5.36].
pub fn disc(bands: usize, angle: f64) -> Vec<f64> {
    let c = angle.cos();
    let mut p = vec![1.0, c];
    for l in 1..=bands {
        let n = l as f64;
        p.push(((2.0 * n + 1.0) * c * p[l] - n * p[l - 1]) / (n + 1.0));
    }
    let coefficient = |l: usize| match l {
        0 => PI.sqrt() * (1.0 + c),
        _ => -(PI / (2 * l + 1) as f64).sqrt() * (p[l - 1] - p[l + 1]),
    };
    (0..bands).map(coefficient).collect()
}
