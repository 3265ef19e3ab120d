//! The constants of one block size.

use crate::Real;

/// cos(2π·m/of), to about an ulp: the angle is reduced in integers to the nearest quarter turn.
fn cos_of_turn(m: usize, of: usize) -> f64 {
    let m = m % of;
    let quarter = (8 * m / of).div_ceil(2);
    let rest = std::f64::consts::TAU * (4.0 * m as f64 - (quarter * of) as f64) / (4 * of) as f64;
    match quarter {
        0 | 4 => rest.cos(),
        1 => -rest.sin(),
        2 => -rest.cos(),
        _ => rest.sin(),
    }
}

/// The basis of one axis: √((2 − δ_u0)/n) cos((2x + 1)uπ/2n).
pub(super) fn basis(n: usize, u: usize, x: usize) -> f64 {
    let scale = if u == 0 { 1.0 } else { 2.0 };
    (scale / n as f64).sqrt() * cos_of_turn((2 * x + 1) * u, 4 * n)
}

/// The matrices of a block with `side` n, rounded once from `f64`.
#[derive(Debug, Clone)]
pub(super) struct Tables<T> {
    /// For half-lengths n/2, n/4, …, 1: the basis functions that change sign under reflection, [frequency][x],
    /// symmetric.
    pub odd: Vec<T>,
    /// The basis as [x][u], in columns of `lanes`: the first `lanes` of each row, the next of each, …
    pub by_sample: Vec<T>,
    /// The same of [u][x].
    pub by_frequency: Vec<T>,
    /// 1/√n.
    pub dc: T,
}

impl<T: Real> Tables<T> {
    pub(super) fn new(n: usize, lanes: usize) -> Self {
        let mut odd = Vec::new();
        let (mut half, mut step) = (n / 2, 1);
        while half > 0 {
            // The frequency (2k+1)·step of n at the sample x of the folded signal of length 2·half.
            odd.extend((0..half * half).map(|i| {
                let m = (2 * (i % half) + 1) * (2 * (i / half) + 1);
                T::of((2.0 / n as f64).sqrt() * cos_of_turn(m, 8 * half))
            }));
            half /= 2;
            step *= 2;
        }
        debug_assert_eq!(step, n);
        // (row, column) of the number at i.
        let place = |i: usize| (i / lanes % n, i / (lanes * n) * lanes + i % lanes);
        let in_columns = |value: &dyn Fn(usize, usize) -> f64| {
            (0..n * n).map(place).map(|(row, column)| T::of(value(row, column))).collect()
        };
        Self {
            odd,
            by_sample: in_columns(&|x, u| basis(n, u, x)),
            by_frequency: in_columns(&|u, x| basis(n, u, x)),
            dc: T::of((1.0 / n as f64).sqrt()),
        }
    }
}
