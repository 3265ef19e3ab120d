//! Tables of suffix sums, and what a look-up adds.

use std::ops::Index;

/// A row of sums over light × cardinal functions: the four nodes for R, for G, for B.
pub(super) type NodeSums = [f32; 12];

/// Eight numbers as a register holds them.
#[repr(C, align(32))]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Lanes(pub(super) [f32; 8]);

/// Σ L V ω: x, y, z for R, for G, for B.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct MomentSums {
    pub(super) eight: Lanes,
    pub(super) ninth: f32,
}

impl MomentSums {
    /// n · Σ L V ω of R, G and B.
    pub(super) fn along(&self, n: [f64; 3]) -> [f64; 3] {
        let [rx, ry, rz, gx, gy, gz, bx, by] = self.eight.0.map(f64::from);
        let dot = |m: [f64; 3]| m[0] * n[0] + m[1] * n[1] + m[2] * n[2];
        [dot([rx, ry, rz]), dot([gx, gy, gz]), dot([bx, by, f64::from(self.ninth)])]
    }
}

/// Suffix sums of a block.
pub(super) trait Table: Copy {
    /// A row, or the sum of some.
    type Sum: Copy;
    /// Adds row `on` and takes row `off` away: a run of visible places.
    fn run(self, sum: &mut Self::Sum, on: usize, off: usize);
    /// Adds `weight` times row `at`.
    fn step(self, sum: &mut Self::Sum, at: usize, weight: f32);
}

/// Rows of a block.
impl<R: Index<usize, Output = NodeSums> + ?Sized> Table for &R {
    type Sum = NodeSums;

    #[inline(always)]
    fn run(self, sum: &mut NodeSums, on: usize, off: usize) {
        let (on, off) = (&self[on], &self[off]);
        for k in 0..12 {
            sum[k] += on[k] - off[k];
        }
    }

    #[inline(always)]
    fn step(self, sum: &mut NodeSums, at: usize, weight: f32) {
        let row = &self[at];
        for k in 0..12 {
            sum[k] += weight * row[k];
        }
    }
}

/// Rows of a block, in two columns: no row of eight numbers crosses a line of the cache.
#[derive(Debug)]
pub(super) struct MomentTable<'a, E: ?Sized, N: ?Sized> {
    pub(super) eights: &'a E,
    pub(super) ninths: &'a N,
}

impl<E: ?Sized, N: ?Sized> Clone for MomentTable<'_, E, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E: ?Sized, N: ?Sized> Copy for MomentTable<'_, E, N> {}

impl<E: Index<usize, Output = Lanes> + ?Sized, N: Index<usize, Output = f32> + ?Sized> Table for MomentTable<'_, E, N> {
    type Sum = MomentSums;

    #[inline(always)]
    fn run(self, sum: &mut MomentSums, on: usize, off: usize) {
        let (a, b) = (&self.eights[on].0, &self.eights[off].0);
        for k in 0..8 {
            sum.eight.0[k] += a[k] - b[k];
        }
        sum.ninth += self.ninths[on] - self.ninths[off];
    }

    #[inline(always)]
    fn step(self, sum: &mut MomentSums, at: usize, weight: f32) {
        let row = &self.eights[at].0;
        for k in 0..8 {
            sum.eight.0[k] += weight * row[k];
        }
        sum.ninth += weight * self.ninths[at];
    }
}
