//! Products and sums of `f64` without rounding, as numbers that do not overlap.

/// a·b = high + low.
#[inline]
pub(super) fn exact_product(a: f64, b: f64) -> (f64, f64) {
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

/// The sum of five numbers to an ε or so of itself, however much of it cancels: its sign is right, and 0 is 0.
pub(super) fn sum_of_five(terms: [f64; 5]) -> f64 {
    // An expansion of parts that do not overlap, lowest first: each new term ripples upwards [Shewchuk 1997, Grow-Expansion].
    // The highest part that is not 0 exceeds the sum of those below it.
    let mut parts = [0.0; 5];
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
            assert_eq!(sum_of_five(terms), 1e-40);
            assert_eq!(sum_of_five(terms.map(|x| -x)), -1e-40);
        }
        assert_eq!(sum_of_five([0.5, 0.25, -0.75, 1e300, -1e300]), 0.0);
    }
}
