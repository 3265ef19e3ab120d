//! Rows to begin with.

use pulp::{Arch, Simd, WithSimd};

use super::super::dense::Scaling;
use super::super::random::Random;
use crate::{Real, parallel};

/// Rows of the sample for each cluster.
const SAMPLE: usize = 16;

/// At most `clusters` different rows that are far from each other: of a random sample of 16 rows a cluster the next one
/// is drawn with a probability that is proportional to its squared distance from those drawn [k-means++, Arthur &
/// Vassilvitskii 2007].
///
/// Differences are scaled before they are squared, so that those of tiny numbers do not vanish.
pub(super) fn far_rows<T: Real>(
    matrix: &[T],
    columns: usize,
    clusters: usize,
    seed: u64,
    scaling: Scaling,
) -> Vec<usize> {
    let rows = matrix.len() / columns;
    let mut random = Random::new(seed, u64::MAX);
    let mut sample: Vec<usize> = (0..rows).collect();
    random.shuffle(&mut sample);
    sample.truncate(clusters.saturating_mul(SAMPLE));
    sample.sort_unstable(); // memory is read in order
    let arch = Arch::new();
    let row = |i: usize| &matrix[i * columns..][..columns];
    let mut distances = vec![f64::INFINITY; sample.len()];
    let mut drawn = vec![sample[random.below(sample.len())]];
    while drawn.len() < clusters {
        let last = row(drawn[drawn.len() - 1]);
        parallel::rows(&mut distances, 1, 64, |i, distance| {
            distance[0] =
                distance[0].min(arch.dispatch(Distance { a: row(sample[i]), b: last, factor: scaling.factor() }));
        });
        let total: f64 = distances.iter().sum();
        if !(total > 0.0) {
            break; // every row of the sample is drawn already
        }
        let mut left = random.unit() * total;
        let next = distances.iter().position(|&d| {
            left -= d;
            d > 0.0 && left < 0.0
        });
        // Rounding may leave a little beyond the last.
        let next = next.or_else(|| distances.iter().rposition(|&d| d > 0.0));
        drawn.extend(next.map(|i| sample[i]));
    }
    drawn
}

/// |factor · (a − b)|².
struct Distance<'a, T> {
    a: &'a [T],
    b: &'a [T],
    factor: f64,
}

impl<T: Real> WithSimd for Distance<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let ((a, a_rest), (b, b_rest)) = (self.a.as_chunks::<8>(), self.b.as_chunks::<8>());
        let mut sums = [0.0; 8];
        for (a, b) in a.iter().zip(b) {
            for l in 0..8 {
                let d = self.factor * (a[l].widen() - b[l].widen());
                sums[l] += d * d;
            }
        }
        let rest = a_rest.iter().zip(b_rest).map(|(a, b)| (self.factor * (a.widen() - b.widen())).powi(2)).sum::<f64>();
        sums.iter().fold(rest, |sum, x| sum + x)
    }
}
