//! Flat index ↔ (degree, order).

/// The flat index l(l+1) + m of degree l, order m.
///
/// # Panics
/// If |m| > l, or the index is more than a `usize` holds.
///
/// # Example
/// ```
/// assert_eq!(haarmonic::sh::index(2, -1), 5);
/// ```
#[inline]
#[track_caller]
pub const fn index(l: usize, m: isize) -> usize {
    assert!(m.unsigned_abs() <= l, "the order m of a spherical harmonic is at most its degree l");
    assert!(l < usize::MAX.isqrt(), "the flat index of this degree is more than a usize holds");
    (l * (l + 1)).wrapping_add_signed(m)
}

/// The (l, m) of a flat index: l = ⌊√index⌋, m = index − l(l+1). Inverse of [`index`].
#[inline]
pub const fn degree_order(index: usize) -> (usize, isize) {
    let l = index.isqrt();
    (l, index as isize - (l * (l + 1)) as isize)
}

/// The number of coefficients of `bands`: bands², or `usize::MAX` where that is less.
#[inline]
pub const fn coefficient_count(bands: usize) -> usize {
    bands.saturating_mul(bands)
}

/// The `bands` that have this number of coefficients; `None` if it is not a square.
#[inline]
pub const fn bands_of(coefficients: usize) -> Option<usize> {
    let bands = coefficients.isqrt();
    if bands * bands == coefficients { Some(bands) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_and_structured_indices_are_inverse() {
        let mut flat = 0;
        for l in 0..70 {
            for m in -(l as isize)..=l as isize {
                assert_eq!(index(l, m), flat);
                assert_eq!(degree_order(flat), (l, m));
                flat += 1;
            }
            assert_eq!(coefficient_count(l + 1), flat);
            assert_eq!(bands_of(flat), Some(l + 1));
            assert_eq!(bands_of(flat + 1), None);
        }
        assert_eq!(bands_of(0), Some(0));
    }

    #[test]
    #[should_panic(expected = "at most its degree")]
    fn order_beyond_degree_panics() {
        index(2, 3);
    }
}
