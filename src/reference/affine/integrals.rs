//! Couplings, triplings and product integrals.

use super::steps::{Function, Point, integral};
use crate::affine::{AffineMap, Mother};

/// ∫ f((u − c)/2r + ½) g(u) du; 0 for r = 0, NaN for NaN.
pub fn canonical(f: Mother, g: Mother, r: f64, c: f64) -> f64 {
    if r.is_nan() || c.is_nan() {
        return f64::NAN;
    }
    // The breakpoints 0, ½ and 1 of f come to lie at c − r, c and c + r.
    let moved = Function::mother(f).moved(r < 0.0, |x| Point::sum(c, 2.0 * r * (x - 0.5)));
    integral(&[&moved, &Function::mother(g).fixed()])
}

/// D_ij = ∫ ψ_i(sv + o) ψ_j(v) dv of the 1D basis.
pub fn coupling_1d(i: usize, j: usize, map: AffineMap) -> f64 {
    integral(&[&Function::haar(i).through(map), &Function::haar(j).fixed()])
}

/// D_ijk = ∫ ψ_i(sv + o) ψ_j(v) ψ_k(v) dv of the 1D basis.
pub fn tripling_1d(i: usize, j: usize, k: usize, map: AffineMap) -> f64 {
    integral(&[&Function::haar(i).through(map), &Function::haar(j).fixed(), &Function::haar(k).fixed()])
}

/// D_ij of the standard basis in as many dimensions as there are maps: a product of 1D couplings.
pub fn coupling_standard(i: &[usize], j: &[usize], maps: &[AffineMap]) -> f64 {
    assert!(i.len() == maps.len() && j.len() == maps.len(), "one index and one map an axis");
    (0..maps.len()).map(|q| coupling_1d(i[q], j[q], maps[q])).product()
}

/// D_ijk of the standard basis in as many dimensions as there are maps: a product of 1D triplings.
pub fn tripling_standard(i: &[usize], j: &[usize], k: &[usize], maps: &[AffineMap]) -> f64 {
    assert!([i.len(), j.len(), k.len()] == [maps.len(); 3], "one index and one map an axis");
    (0..maps.len()).map(|q| tripling_1d(i[q], j[q], k[q], maps[q])).product()
}

/// D_ij of the 2D nonstandard basis, by flat index; maps of x and y.
pub fn coupling_nonstandard(i: usize, j: usize, maps: [AffineMap; 2]) -> f64 {
    let [f, g] = [i, j].map(Function::nonstandard);
    (0..2).map(|axis| integral(&[&f[axis].through(maps[axis]), &g[axis].fixed()])).product()
}

/// D_ijk of the 2D nonstandard basis, by flat index; maps of x and y.
pub fn tripling_nonstandard(i: usize, j: usize, k: usize, maps: [AffineMap; 2]) -> f64 {
    let [f, g, h] = [i, j, k].map(Function::nonstandard);
    let along = |axis: usize| integral(&[&f[axis].through(maps[axis]), &g[axis].fixed(), &h[axis].fixed()]);
    along(0) * along(1)
}

/// D_ij of the orthonormal pixels √N·1 on [k/N, (k + 1)/N).
pub fn pixel_coupling(size: usize, i: usize, j: usize, map: AffineMap) -> f64 {
    // N times the overlap, rather than √N twice.
    integral(&[&Function::cell(size, i, 1.0).through(map), &Function::cell(size, j, size as f64).fixed()])
}

/// D_ijk of the orthonormal pixels.
pub fn pixel_tripling(size: usize, i: usize, j: usize, k: usize, map: AffineMap) -> f64 {
    let cell = |k| Function::cell(size, k, 1.0);
    let overlap = integral(&[&cell(i).through(map), &cell(j).fixed(), &cell(k).fixed()]);
    size as f64 * (size as f64).sqrt() * overlap
}

/// The one-sided derivative of D_ij at (s, o) along `along` = (ds, do), by differences over `step` and half of it.
///
/// D is linear in o and of the form a + b/s in s between its kinks, so 2 Δ(h/2) − Δ(h) is right to O(h²) + O(ε/h) as
/// long as no kink lies within the step.
pub fn coupling_slope_1d(i: usize, j: usize, map: AffineMap, along: [f64; 2], step: f64) -> f64 {
    let at = |h: f64| {
        let moved =
            AffineMap::new(map.scale() + h * along[0], map.offset() + h * along[1]).expect("a map beside a map");
        coupling_1d(i, j, moved)
    };
    let here = at(0.0);
    let difference = |h: f64| (at(h) - here) / h;
    2.0 * difference(step / 2.0) - difference(step)
}

/// ∫ F(sv + o) G(v) dv of signals given by samples.
pub fn double_product(f: &[f64], g: &[f64], map: AffineMap) -> f64 {
    integral(&[&Function::cells(f).through(map), &Function::cells(g).fixed()])
}

/// ∫ F(sv + o) G(v) W(v) dv of signals given by samples.
pub fn triple_product(f: &[f64], g: &[f64], w: &[f64], map: AffineMap) -> f64 {
    integral(&[&Function::cells(f).through(map), &Function::cells(g).fixed(), &Function::cells(w).fixed()])
}
