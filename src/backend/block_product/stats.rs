//! What a frame did.

/// How the blocks of a frame were integrated, as tables 1 and 2 [Inger 2013] count them.
///
/// A block of a vertex is counted once, under the most expensive of its lobes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct FrameStats {
    /// Vertices that were shaded.
    pub vertices: usize,
    /// Blocks that are hidden, below the horizon, or where no lobe reflects anything to speak of.
    pub zero: usize,
    /// Free blocks: reflectance samples × weights (line 6 of algorithm 1), or the cosine exactly.
    pub coefficients: usize,
    /// Partly hidden blocks through suffix sums (line 9).
    pub sums: usize,
    /// Blocks through their pixels (line 11).
    pub pixels: usize,
    /// Blocks by samples of reflectance: 1 (or a cosine), 4, 16, all pixels.
    pub samples: [usize; 4],
}

impl FrameStats {
    /// Shares of `zero`, `coefficients`, `sums` and `pixels` in percent of all blocks; 0 without blocks.
    pub fn case_percent(&self) -> [f64; 4] {
        percent([self.zero, self.coefficients, self.sums, self.pixels])
    }

    /// Shares of `samples` in percent of the blocks that are sampled; 0 without any.
    pub fn samples_percent(&self) -> [f64; 4] {
        percent(self.samples)
    }

    /// Adds another's counts.
    pub(super) fn add(mut self, other: Self) -> Self {
        self.vertices += other.vertices;
        self.zero += other.zero;
        self.coefficients += other.coefficients;
        self.sums += other.sums;
        self.pixels += other.pixels;
        self.samples.iter_mut().zip(other.samples).for_each(|(a, b)| *a += b);
        self
    }
}

fn percent(counts: [usize; 4]) -> [f64; 4] {
    let all = counts.iter().sum::<usize>().max(1) as f64;
    counts.map(|count| 100.0 * count as f64 / all)
}
