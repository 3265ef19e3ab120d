//! Triple integrals: a product and a dot product.

use pulp::{Simd, WithSimd};

use super::{Product, square};
use crate::Real;
use crate::error::check_length;

impl<T: Real> Product<T> {
    /// ∫ a b c over the sphere, c of bands_out, summed over c in f64.
    ///
    /// ```math
    /// Σ_ijk a_i b_j c_k Γ_ijk
    /// ```
    ///
    /// Cost: a product and a dot product.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or `c.len()` is not the square of its bands.
    #[track_caller]
    pub fn integral(&self, a: &[T], b: &[T], c: &[T]) -> T {
        check_length("factor c", square(self.bands[2]), c.len());
        let (mut few, mut many) = ([T::zero(); 256], Vec::new());
        let product = match few.get_mut(..c.len()) {
            Some(few) => few,
            None => {
                many.resize(c.len(), T::zero());
                &mut many[..]
            }
        };
        self.apply(a, b, product);
        T::of(product.iter().zip(c).map(|(p, c)| p.widen() * c.widen()).sum())
    }

    /// `count` integrals ∫ a b c at once, coefficient-major, for each channel of c its own: coefficient i of vector v
    /// is at i·`count` + v in `a`, `b` and the channels of `c`; integral v of a channel at v of its `out`.
    ///
    /// The channels share the product of a and b: for a light in RGB let c be the light, a and b what all colours have
    /// in common, such as visibility and a lobe. The same bits as [`integral`](Self::integral) vector by vector and
    /// channel by channel.
    ///
    /// # Panics
    /// If `a.len()`, `b.len()` or that of a channel of `c` is not `count` times the square of its bands, an `out` is
    /// not `count` long, or `scratch` not [`scratch_len`](Self::scratch_len).
    ///
    /// # Example
    /// ```
    /// use haarmonic::sh::Product;
    /// let product = Product::<f64>::new(2, 2, 2)?;
    /// // Two vectors: the constants 1 and 2, each times z and the light; the light is z in red and 0 in green.
    /// let one = (4.0 * std::f64::consts::PI).sqrt();
    /// let constants = [one, 2.0 * one, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    /// let z = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
    /// let ([mut red, mut green], mut scratch) = ([[0.0; 2]; 2], vec![0.0; product.scratch_len(2)]);
    /// product.integral_batch(2, &constants, &z, [&z, &[0.0; 8]], [&mut red, &mut green], &mut scratch);
    /// assert!((red[1] - 2.0).abs() < 1e-15 && green == [0.0; 2]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn integral_batch<const C: usize>(
        &self,
        count: usize,
        a: &[T],
        b: &[T],
        c: [&[T]; C],
        out: [&mut [T]; C],
        scratch: &mut [T],
    ) {
        for (c, out) in c.iter().zip(&out) {
            check_length("factor c", self.scratch_len(count), c.len());
            check_length("integrals", count, out.len());
        }
        check_length("scratch", self.scratch_len(count), scratch.len());
        self.apply_batch(count, a, b, scratch);
        for (c, out) in c.into_iter().zip(out) {
            self.arch.dispatch(Dots { product: scratch, c, out });
        }
    }

    /// Length of the scratch of [`integral_batch`](Self::integral_batch): `count` · bands_out².
    #[inline]
    pub fn scratch_len(&self, count: usize) -> usize {
        square(self.bands[2]).saturating_mul(count)
    }
}

/// Dot products of vectors side by side, each summed in f64 in the order of its coefficients.
struct Dots<'a, T> {
    product: &'a [T],
    c: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> WithSimd for Dots<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        const L: usize = 16;
        let Self { product, c, out } = self;
        let count = out.len();
        for first in (0..count).step_by(L) {
            let lanes = L.min(count - first);
            let mut sums = [0.0; L];
            for (p, c) in product.chunks_exact(count).zip(c.chunks_exact(count)) {
                match (p[first..].first_chunk::<L>(), c[first..].first_chunk::<L>()) {
                    (Some(p), Some(c)) => (0..L).for_each(|i| sums[i] += p[i].widen() * c[i].widen()),
                    _ => (0..lanes).for_each(|i| sums[i] += p[first + i].widen() * c[first + i].widen()),
                }
            }
            out[first..first + lanes].iter_mut().zip(sums).for_each(|(out, sum)| *out = T::of(sum));
        }
    }
}
