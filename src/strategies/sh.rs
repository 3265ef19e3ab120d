//! Expansions in spherical harmonics.

use nalgebra::{Unit, UnitVector3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;

use super::direction;
use crate::Real;
use crate::sh::{Basis, VonMisesFisher, Zonal};
use crate::sphere::SphereQuadrature;

/// An expansion of `bands`, bands² coefficients at index l(l+1)+m: ordinary numbers in [−1, 1], smooth (falling as
/// (l+1)⁻²), huge, tiny, one-hot or zero.
///
/// Huge is up to 2^−12 √max, so that products of two are finite; tiny down to the smallest normal number.
pub fn sh_vector<T: Real>(bands: usize) -> BoxedStrategy<Vec<T>> {
    let count = bands * bands;
    let unit = move || vec((-1.0..1.0).prop_map(T::of), count);
    let times = move |factor: T| unit().prop_map(move |c| c.into_iter().map(|c| c * factor).collect::<Vec<T>>());
    let smooth = unit().prop_map(|c: Vec<T>| {
        c.into_iter().enumerate().map(|(i, c)| c * T::of((i.isqrt() as f64 + 1.0).powi(-2))).collect::<Vec<T>>()
    });
    let one_hot = (0..count.max(1), -8.0..8.0).prop_map(move |(at, value)| {
        (0..count).map(|i| if i == at { T::of(value) } else { T::zero() }).collect::<Vec<T>>()
    });
    prop_oneof![
        4 => unit(),
        2 => smooth,
        1 => times(T::max_value().sqrt() * T::of(2f64.powi(-12))),
        1 => times(T::min_positive_value() * T::of(16.0)),
        2 => one_hot,
        1 => Just(std::vec![T::zero(); count]),
    ]
    .boxed()
}

/// Up to `most` discs (axis, half angle): small, middling, a hemisphere, nested and overlapping as it happens, none at
/// all.
pub fn discs(most: usize) -> BoxedStrategy<Vec<(UnitVector3<f64>, f64)>> {
    let angle =
        prop_oneof![4 => 0.05..0.8f64, 1 => 0.8..1.5f64, 1 => Just(std::f64::consts::FRAC_PI_2), 1 => 1e-4..1e-2f64];
    vec((direction(), angle), 0..=most).boxed()
}

/// The coefficients of a function that is 0 within a union of [`discs`] and 1 elsewhere, projected by a rule of 48
/// rings: what is projected is 0 or 1 at each of its points, so the sums that hold for visibility hold, and its lobes
/// ring below 0 and above 1.
pub fn sh_visibility(bands: usize) -> BoxedStrategy<Vec<f64>> {
    let rule = SphereQuadrature::new(95).expect("a small degree");
    let basis = Basis::<f64>::new(bands).expect("bands from 1");
    discs(8)
        .prop_map(move |discs| {
            let (mut y, mut out) = (vec![0.0; bands * bands], vec![0.0; bands * bands]);
            for (direction, weight) in rule.directions().iter().zip(rule.weights()) {
                if discs.iter().all(|(axis, angle)| axis.dot(direction) < angle.cos()) {
                    basis.eval(direction, &mut y);
                    out.iter_mut().zip(&y).for_each(|(out, y)| *out += weight * y);
                }
            }
            out
        })
        .boxed()
}

/// A zonal function of 1 to `max_bands` bands: factors without a law in [−2, 2], one degree alone, zero; clamped
/// cosines and their powers (0, 1 and large among them), caps and what is outside of them (nothing, a hemisphere and
/// everything among them), densities of von Mises and Fisher from uniform to the delta.
pub fn zonal<T: Real>(max_bands: usize) -> BoxedStrategy<Zonal<T>> {
    (1..=max_bands.max(1)).prop_flat_map(zonal_of).boxed()
}

fn zonal_of<T: Real>(bands: usize) -> BoxedStrategy<Zonal<T>> {
    fn sound<T>(zonal: crate::Result<Zonal<T>>) -> Zonal<T> {
        zonal.expect("the strategy stays in range")
    }
    let one_degree = (0..bands, -2.0..2.0_f64).prop_map(move |(at, factor)| {
        sound(Zonal::from_factors((0..bands).map(|l| if l == at { T::of(factor) } else { T::zero() })))
    });
    let power =
        prop_oneof![2 => 0.0..8.0_f64, 1 => (3.0..14.0_f64).prop_map(f64::exp2), 1 => Just(0.0), 1 => Just(1.0)];
    let angle = prop_oneof![
        3 => 0.0..std::f64::consts::PI,
        1 => prop::sample::select(vec![0.0, 1e-8, std::f64::consts::FRAC_PI_2, std::f64::consts::PI]),
    ];
    let concentration =
        prop_oneof![3 => (-20.0..14.0_f64).prop_map(f64::exp2), 1 => Just(0.0), 1 => Just(f64::INFINITY)];
    let density = concentration.prop_map(|kappa| VonMisesFisher::new(kappa).expect("not negative"));
    prop_oneof![
        4 => vec((-2.0..2.0).prop_map(T::of), bands).prop_map(|factors| sound(Zonal::from_factors(factors))),
        1 => one_degree,
        1 => Just(sound(Zonal::from_factors(vec![T::zero(); bands]))),
        2 => power.prop_map(move |power| sound(Zonal::cosine_power(bands, power))),
        2 => (angle, any::<bool>()).prop_map(move |(angle, inside)| {
            sound(if inside { Zonal::cap(bands, angle) } else { Zonal::outside_cap(bands, angle) })
        }),
        2 => density.prop_map(move |density| sound(Zonal::von_mises_fisher(bands, &density))),
    ]
    .boxed()
}

/// The vertices of a convex polygon on the sphere, 3 to `max_vertices` of them, counterclockwise as they are seen from
/// the sphere's middle with the polygon's in front.
///
/// In a cap of 80° and smaller ones, down to 1e-8; slivers, a thousandth and a millionth as
/// wide as they are long; two vertices in one place, three in a line.
pub fn spherical_polygon(max_vertices: usize) -> BoxedStrategy<Vec<UnitVector3<f64>>> {
    let size = prop_oneof![2 => (-27.0..2.5_f64).prop_map(f64::exp2), 1 => 0.05..1.0_f64];
    let width = prop_oneof![4 => 0.2..=1.0_f64, 1 => Just(1e-3), 1 => Just(1e-6)];
    // Gaps between the vertices on an ellipse about the middle.
    let gaps = vec(0.2..1.0_f64, 3..=max_vertices.max(3));
    let flaw = prop_oneof![4 => Just(Flaw::None), 1 => Just(Flaw::Twice), 1 => Just(Flaw::Straight)];
    (direction(), 0.0..6.3_f64, size, width, gaps, flaw)
        .prop_map(move |(middle, turn, size, width, gaps, flaw)| {
            let a = middle.cross(&Vector3::ith(middle.iamin(), 1.0)).normalize();
            let b = middle.cross(&a);
            let (a, b) = (a * turn.cos() + b * turn.sin(), b * turn.cos() - a * turn.sin());
            let turns = std::f64::consts::TAU / gaps.iter().sum::<f64>();
            let mut angle = 0.0;
            let mut outline: Vec<Vector3<f64>> = gaps
                .iter()
                .map(|gap| {
                    angle += gap * turns;
                    *middle + (a * angle.cos() + b * (angle.sin() * width)) * size
                })
                .collect();
            let last = outline.len() - 1;
            match flaw {
                // Of three vertices three are left.
                Flaw::Twice if last > 2 => outline[last] = outline[last - 1],
                Flaw::Straight if last > 2 => outline[last] = (outline[last - 1] + outline[0]) / 2.0,
                _ => {}
            }
            outline.into_iter().map(Unit::new_normalize).collect()
        })
        .boxed()
}

/// What is wrong with a polygon.
#[derive(Debug, Clone, Copy)]
enum Flaw {
    None,
    Twice,
    Straight,
}
