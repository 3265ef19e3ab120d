//! Products and sums of `f64` without rounding, as numbers that do not overlap.

/// a·b = high + low.
#[inline]
pub(crate) fn exact_product(a: f64, b: f64) -> (f64, f64) {
    let high = a * b;
    (high, a.mul_add(b, -high))
}

/// a + b = high + low [Knuth].
#[inline]
pub(super) fn exact_sum(a: f64, b: f64) -> (f64, f64) {
    let high = a + b;
    let from_b = high - a;
    (high, (a - (high - from_b)) + (b - from_b))
}

/// x − p − o of p and o that are given as pairs of numbers: to a few ε of itself, and its sign is exact.
#[inline]
pub(super) fn separation(x: f64, (p, p_low): (f64, f64), (o, o_low): (f64, f64)) -> f64 {
    let (part, lost) = exact_sum(x, -p);
    let (rest, more) = exact_sum(part, -o);
    let sum = rest + ((lost + more) - (p_low + o_low));
    // The last line rounds off a few ε² of the largest number. Where that could show beside ε of the sum, all over
    // again.
    let certain = sum.abs() > f64::EPSILON * (x.abs() + p.abs() + o.abs());
    if certain { sum } else { sum_of([-p_low, -o_low, -p, -o, x]) }
}

/// The sum of numbers to an ε or so of itself, however much of it cancels: its sign is right, and it is 0 if and only
/// if the sum is.
pub(super) fn sum_of<const N: usize>(terms: [f64; N]) -> f64 {
    // An expansion of parts that do not overlap, lowest first: each new term ripples upwards [Shewchuk 1997,
    // Grow-Expansion]. The highest part that is not 0 exceeds the sum of those below it.
    let mut parts = [0.0; N];
    for (count, &term) in terms.iter().enumerate() {
        let mut carry = term;
        for part in &mut parts[..count] {
            (carry, *part) = exact_sum(carry, *part);
        }
        parts[count] = carry;
    }
    parts.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_leaves_the_rest() {
        assert_eq!(exact_product(1.0 + f64::EPSILON, 1.0 + f64::EPSILON).1, f64::EPSILON * f64::EPSILON);
        assert_eq!(exact_sum(1.0, 1e-30), (1.0, 1e-30));
        for terms in [[1e-40, 1e30, 1.0, -1e30, -1.0], [1.0, 1e30, 1e-40, -1.0, -1e30]] {
            assert_eq!(sum_of(terms), 1e-40);
            assert_eq!(sum_of(terms.map(|x| -x)), -1e-40);
        }
        assert_eq!(sum_of([0.5, 0.25, -0.75, 1e300, -1e300]), 0.0);
    }

    #[test]
    fn sums_that_cancel_are_zero_and_others_keep_their_sign() {
        assert_eq!(sum_of([1e300, 1.0, -1e300, -1.0]), 0.0);
        assert!(sum_of([1e300, 1e-300, -1e300]) > 0.0);
        assert!(sum_of([0.1, 0.2, -0.3, -1e-16]) < 0.0); // 0.1 + 0.2 − 0.3 = 2.8e-17 as f64
    }

    #[test]
    fn a_separation_far_below_the_rounding_of_its_terms_is_right() {
        let third = 1.0 / 3.0;
        // 1 − 3·fl(⅓) = 2⁻⁵⁴.
        assert_eq!(separation(1.0, exact_product(3.0, third), (0.0, 0.0)), 2f64.powi(-54));
        assert_eq!(separation(0.5, (1e-40, 0.0), (0.5, 0.0)), -1e-40);
        assert_eq!(separation(0.5, (0.25, 0.0), (0.25, 1e-60)), -1e-60);
    }
}
