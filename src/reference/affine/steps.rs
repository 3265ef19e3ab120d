//! Piecewise constant functions as breakpoints and values.

use std::iter::Product;

use crate::affine::{AffineMap, Mother};
use crate::haar::{Index1d, Index2d, WaveletKind};
use crate::numeric::CompensatedSum;

/// The number hi + lo with hi = fl(hi + lo): 106 bits, ordered as its parts are.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Point(f64, f64);

impl Point {
    /// a + b, exactly.
    pub(super) fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let from_b = sum - a;
        Self(sum, (a - (sum - from_b)) + (b - from_b))
    }

    /// (x − o)/s.
    fn solve(x: f64, map: AffineMap) -> Self {
        let Self(numerator, lost) = Self::sum(x, -map.offset());
        let quotient = numerator / map.scale();
        let rest = (-quotient).mul_add(map.scale(), numerator) + lost;
        Self::sum(quotient, rest / map.scale())
    }
}

/// The function that is `values[k]` on [`at[k]`, `at[k + 1]`) and 0 elsewhere; `at` ascends.
#[derive(Debug, Clone)]
pub(super) struct Steps<P, V> {
    pub(super) at: Vec<P>,
    pub(super) values: Vec<V>,
}

impl<P: Copy, V: Copy> Steps<P, V> {
    /// The function with its breakpoints moved by a monotone `to`, falling if `mirrored`.
    pub(super) fn moved<Q>(&self, mirrored: bool, to: impl Fn(P) -> Q) -> Steps<Q, V> {
        let mut at: Vec<Q> = self.at.iter().map(|&x| to(x)).collect();
        let mut values = self.values.clone();
        if mirrored {
            at.reverse();
            values.reverse();
        }
        Steps { at, values }
    }

    fn value_after(&self, x: P) -> V
    where
        P: PartialOrd,
    {
        self.values[self.at.partition_point(|&p| p <= x) - 1]
    }
}

/// (from, to, product of the factors there) of every piece on which all factors are constant and none is past its ends.
pub(super) fn pieces<P: Copy + PartialOrd, V: Copy + Product>(factors: &[&Steps<P, V>]) -> Vec<(P, P, V)> {
    let larger = |a: P, b: P| if a < b { b } else { a };
    let smaller = |a: P, b: P| if b < a { b } else { a };
    let from = factors.iter().map(|f| f.at[0]).reduce(larger).expect("a factor");
    let to = factors.iter().map(|f| f.at[f.values.len()]).reduce(smaller).expect("a factor");
    if !(from < to) {
        return Vec::new();
    }
    let mut cuts = vec![from, to];
    for factor in factors {
        cuts.extend(factor.at.iter().copied().filter(|&x| from < x && x < to));
    }
    cuts.sort_by(|a, b| a.partial_cmp(b).expect("breakpoints are not NaN"));
    cuts.dedup_by(|a, b| a == b);
    let product = |x| factors.iter().map(|f| f.value_after(x)).product();
    cuts.windows(2).map(|cut| (cut[0], cut[1], product(cut[0]))).collect()
}

/// A function of real breakpoints, given as `f64`.
pub(super) type Function = Steps<f64, f64>;

/// The same, seen through a map: breakpoints of 106 bits.
pub(super) type Placed = Steps<Point, f64>;

impl Function {
    pub(super) fn new(at: impl Into<Vec<f64>>, values: impl Into<Vec<f64>>) -> Self {
        Self { at: at.into(), values: values.into() }
    }

    pub(super) fn mother(mother: Mother) -> Self {
        match mother {
            Mother::Scaling => Self::new([0.0, 1.0], [1.0]),
            Mother::Wavelet => Self::new([0.0, 0.5, 1.0], [1.0, -1.0]),
        }
    }

    /// 2^{l/2} f(2^l v − t).
    fn member(mother: Mother, level: u32, offset: usize) -> Self {
        let scale = (1u64 << level) as f64;
        let mut member = Self::mother(mother).moved(false, |x| (x + offset as f64) / scale);
        member.values.iter_mut().for_each(|v| *v *= scale.sqrt());
        member
    }

    /// The function of the 1D Haar basis.
    pub(super) fn haar(flat: usize) -> Self {
        match Index1d::from_flat(flat) {
            Index1d::Scaling => Self::mother(Mother::Scaling),
            Index1d::Detail { level, offset } => Self::member(Mother::Wavelet, level, offset),
        }
    }

    /// The factors in x and y of the function of the nonstandard basis.
    pub(super) fn nonstandard(flat: usize) -> [Self; 2] {
        let Index2d::Detail { level, kind, x, y } = Index2d::from_flat(flat) else {
            return [Self::mother(Mother::Scaling), Self::mother(Mother::Scaling)];
        };
        let [along_x, along_y] = match kind {
            WaveletKind::Horizontal => [Mother::Wavelet, Mother::Scaling],
            WaveletKind::Vertical => [Mother::Scaling, Mother::Wavelet],
            WaveletKind::Diagonal => [Mother::Wavelet, Mother::Wavelet],
        };
        [Self::member(along_x, level, x), Self::member(along_y, level, y)]
    }

    /// The signal of these samples on equal cells of [0, 1].
    pub(super) fn cells(samples: &[f64]) -> Self {
        let boundary = |k: usize| k as f64 / samples.len() as f64;
        Self::new((0..=samples.len()).map(boundary).collect::<Vec<_>>(), samples)
    }

    /// `height` on cell `k` of `count`.
    pub(super) fn cell(count: usize, k: usize, height: f64) -> Self {
        Self::new([k, k + 1].map(|k| k as f64 / count as f64), [height])
    }

    /// The function as it is.
    pub(super) fn fixed(&self) -> Placed {
        self.moved(false, |x| Point(x, 0.0))
    }

    /// v ↦ f(s v + o).
    pub(super) fn through(&self, map: AffineMap) -> Placed {
        self.moved(map.scale() < 0.0, |x| Point::solve(x, map))
    }
}

/// ∫ of the product of the factors over the whole line.
pub(super) fn integral(factors: &[&Placed]) -> f64 {
    let length = |a: Point, b: Point| (b.0 - a.0) + (b.1 - a.1);
    pieces(factors).into_iter().map(|(a, b, value)| length(a, b) * value).collect::<CompensatedSum>().total()
}
