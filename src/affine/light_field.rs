//! Light fields: a light that depends on where it leaves its plane and on where it goes.

use super::{AffineMap, TripleNonzeros1d};
use crate::approx_eq::approx_by_parts;
use crate::error::check_length;
use crate::haar::SparseVector;
use crate::{Error, Real, Result, parallel};

/// Vertices that a task of a batch takes at a time.
const TOGETHER: usize = 16;

/// The light of a light field that arrives at a point.
///
/// ```math
/// L(v) = F(z v + x, v),   L_k(z, x) = Σ_ij F_ij D_ijk(z, x)                         [Sun 2008, §4.5.3, eq. 4.37]
/// ```
///
/// for F(v₁, v₂) = Σ F_ij ψ_i(v₁) ψ_j(v₂): v₁ on the light's plane, v₂ the direction (the intercept on a plane at unit
/// distance); s = z is the height of the point, o = x its place. In space each axis has its own map, and F has four
/// indices. The result is the L² projection of L, with L = 0 where z v + x leaves [0, 1).
///
/// Cost: O(log N) a term in the plane, O(log² N) in space, by the D_ijk that are not zero; nothing is allocated.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, LightField};
/// use haarmonic::haar::SparseVector;
/// // F(v₁, v₂) = 1 + ψ(v₁) ψ(v₂), seen from height 1: 1 + ψ² = 2.
/// let field = SparseVector::from_dense(&[1.0, 0.0, 0.0, 1.0]);
/// let mut light = [0.0; 2];
/// LightField::new(2)?.propagate(&field, AffineMap::IDENTITY, &mut light);
/// assert_eq!(light, [2.0, 0.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightField {
    nonzeros: TripleNonzeros1d,
}

/// A term of a light field in space: the 1D flat indices of its factors in x and y of the plane and of the direction,
/// and F of each channel there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightFieldTerm<T, const C: usize = 1> {
    /// [i_x, i_y].
    pub plane: [u32; 2],
    /// [j_x, j_y].
    pub direction: [u32; 2],
    /// F_ij of each channel.
    pub value: [T; C],
}

/// The D_ijk of one i and j, at most 3 log₂ N + 2 of them.
struct Partners {
    entries: [(usize, f64); Self::CAPACITY],
    len: usize,
}

impl Partners {
    const CAPACITY: usize = 64;
}

impl LightField {
    /// A plan for light fields of `size` functions an axis.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless `size` is one; [`Error::OutOfRange`] above 2¹⁵.
    pub fn new(size: usize) -> Result<Self> {
        if size > 1 << 15 {
            return Err(Error::OutOfRange {
                what: "size of a light field",
                got: size as f64,
                allowed: "at most 32768",
            });
        }
        Ok(Self { nonzeros: TripleNonzeros1d::new(size)? })
    }

    /// The number of functions an axis.
    #[inline]
    pub fn size(self) -> usize {
        self.nonzeros.size()
    }

    /// The coefficients of F(s v + o, v).
    ///
    /// Shapes: field: size², standard basis, F_ij at j·size + i (direction by direction, as
    /// [`Transform2d`](crate::haar::Transform2d) makes it of rows of the plane); out: size, flat 1D index, overwritten.
    ///
    /// # Panics
    /// If a length is wrong.
    #[track_caller]
    pub fn propagate<T: Real>(self, field: &SparseVector<T>, map: AffineMap, out: &mut [T]) {
        let size = self.size();
        check_length("light field", size * size, field.len());
        check_length("arriving light", size, out.len());
        out.fill(T::zero());
        for (flat, value) in field.iter() {
            let (i, j) = (flat & (size - 1), flat >> size.ilog2());
            self.nonzeros.partners(i, j, map, |k, d| out[k] += T::of(d) * value);
        }
    }

    /// The coefficients of F(s_x x + o_x, s_y y + o_y, x, y), of each channel.
    ///
    /// Shapes: out: size², standard basis, L_{k_x k_y} at k_y·size + k_x, overwritten. Terms of equal indices add up.
    ///
    /// # Panics
    /// If the length is wrong, or an index is not below the size.
    #[track_caller]
    pub fn propagate_in_space<T: Real, const C: usize>(
        self,
        field: &[LightFieldTerm<T, C>],
        maps: [AffineMap; 2],
        out: &mut [[T; C]],
    ) {
        let size = self.size();
        check_length("arriving light", size * size, out.len());
        out.fill([T::zero(); C]);
        for term in field {
            let [x, y] = [0, 1].map(|q| self.partners(term.plane[q] as usize, term.direction[q] as usize, maps[q]));
            for &(ky, dy) in &y.entries[..y.len] {
                for &(kx, dx) in &x.entries[..x.len] {
                    let d = T::of(dx * dy);
                    for (sum, &value) in out[ky * size + kx].iter_mut().zip(&term.value) {
                        *sum += d * value;
                    }
                }
            }
        }
    }

    /// [`propagate`](Self::propagate) to many vertices, in parallel: of vertex v, `out` holds `size` coefficients from
    /// v·`size` on.
    ///
    /// The same bits for any number of threads, and as of one vertex.
    ///
    /// # Panics
    /// If the field's length is not `size`², or `out.len()` not maps × `size`.
    #[track_caller]
    pub fn propagate_batch<T: Real>(self, field: &SparseVector<T>, maps: &[AffineMap], out: &mut [T]) {
        let size = self.size();
        check_length("light field", size * size, field.len());
        check_length("arriving light of a batch", maps.len() * size, out.len());
        parallel::rows(out, size, TOGETHER, |v, out| self.propagate(field, maps[v], out));
    }

    /// [`propagate_in_space`](Self::propagate_in_space) to many vertices, in parallel: of vertex v, `out` holds `size`²
    /// coefficients of all channels from v·`size`² on.
    ///
    /// The same bits for any number of threads, and as of one vertex.
    ///
    /// # Panics
    /// If `out.len()` is not maps × `size`², or an index of a term not below the size.
    #[track_caller]
    pub fn propagate_in_space_batch<T: Real, const C: usize>(
        self,
        field: &[LightFieldTerm<T, C>],
        maps: &[[AffineMap; 2]],
        out: &mut [[T; C]],
    ) {
        let area = self.size() * self.size();
        check_length("arriving light of a batch", maps.len() * area, out.len());
        for term in field {
            let indices = [term.plane, term.direction];
            let inside = indices.as_flattened().iter().all(|&i| (i as usize) < self.size());
            assert!(inside, "light field: an index of {indices:?} is not below {}", self.size());
        }
        parallel::rows(out, area, TOGETHER, |v, out| self.propagate_in_space(field, maps[v], out));
    }

    #[track_caller]
    fn partners(self, i: usize, j: usize, map: AffineMap) -> Partners {
        assert!(i < self.size() && j < self.size(), "light field: index {i} or {j} of {}", self.size());
        let mut partners = Partners { entries: [(0, 0.0); Partners::CAPACITY], len: 0 };
        self.nonzeros.partners(i, j, map, |k, d| {
            partners.entries[partners.len] = (k, d);
            partners.len += 1;
        });
        partners
    }
}

approx_by_parts!(
    [T: Real + approx::RelativeEq<Epsilon = T> + approx::UlpsEq<Epsilon = T>, const C: usize] LightFieldTerm<T, C>, T,
    |t| close [&t.value] same [t.plane, t.direction]
);
