//! The rays, or the cells with rays, of one patch that have met nothing yet.

/// One bit a cell of a patch of `side`² cells, rows padded to whole words.
#[derive(Debug, Clone, Default)]
pub(super) struct LiveRays {
    side: usize,
    stride: usize,
    rows: Vec<u64>,
}

impl LiveRays {
    pub(super) fn new(side: usize) -> Self {
        let stride = side.div_ceil(64);
        Self { side, stride, rows: vec![0; side * stride] }
    }

    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// Nothing lives.
    pub(super) fn clear(&mut self) {
        self.rows.fill(0);
    }

    /// The cell x of row y lives.
    pub(super) fn revive(&mut self, y: usize, x: usize) {
        self.rows[y * self.stride + x / 64] |= 1 << (x % 64);
    }

    /// Everything lives. Returns how many cells there are.
    pub(super) fn keep_all(&mut self) -> u64 {
        for row in self.rows.chunks_exact_mut(self.stride) {
            row.iter_mut().enumerate().for_each(|(w, word)| *word = run(0, self.side, w));
        }
        (self.side * self.side) as u64
    }

    /// Keeps the texels whose centre is above the plane of `normal` (components along the face's right, down and
    /// outward axes): n·d > 0. Returns how many there are.
    ///
    /// Along a row n·d is n_u u + (n_v v + n_w), monotone in u even as computed, so the texels of a row are a run
    /// whose end is found from the root of that line and then set right with the predicate itself.
    pub(super) fn keep_above(&mut self, normal: [f64; 3], centres: &[f64]) -> u64 {
        let side = self.side;
        let mut count = 0;
        for (y, row) in self.rows.chunks_exact_mut(self.stride).enumerate() {
            let base = normal[1] * centres[y] + normal[2];
            let above = |x: usize| normal[0] * centres[x] + base > 0.0;
            let root = (1.0 - base / normal[0]) * 0.5 * side as f64;
            let (mut first, mut end) = (0, side);
            if normal[0] > 0.0 {
                first = (root as usize).min(side);
                while first > 0 && above(first - 1) {
                    first -= 1;
                }
                while first < side && !above(first) {
                    first += 1;
                }
            } else if normal[0] < 0.0 {
                end = (root as usize).min(side);
                while end > 0 && !above(end - 1) {
                    end -= 1;
                }
                while end < side && above(end) {
                    end += 1;
                }
            } else if base <= 0.0 || base.is_nan() {
                end = 0;
            }
            for (w, word) in row.iter_mut().enumerate() {
                *word = run(first, end, w);
            }
            count += end.saturating_sub(first) as u64;
        }
        count
    }

    /// Whether any texel of columns x.0..x.1 and rows y.0..y.1 lives.
    #[inline(always)]
    pub(super) fn any(&self, x: [u32; 2], y: [u32; 2]) -> bool {
        let (first, end) = (x[0] as usize, x[1] as usize);
        if self.stride == 1 {
            let mask = run(first, end, 0);
            return self.rows[y[0] as usize..y[1] as usize].iter().any(|row| row & mask != 0);
        }
        (y[0] as usize..y[1] as usize)
            .any(|y| (first / 64..end.div_ceil(64)).any(|w| self.rows[y * self.stride + w] & run(first, end, w) != 0))
    }

    /// Kills the texels first..end of row y.
    #[inline(always)]
    pub(super) fn kill(&mut self, y: usize, first: usize, end: usize) {
        if self.stride == 1 {
            self.rows[y] &= !run(first, end, 0);
            return;
        }
        for w in first / 64..end.div_ceil(64) {
            self.rows[y * self.stride + w] &= !run(first, end, w);
        }
    }

    /// Packs the rows without padding into `words`, which must be zero: bit y · side + x.
    pub(super) fn pack(&self, words: &mut [u64]) {
        if self.side.is_multiple_of(64) {
            words.copy_from_slice(&self.rows);
            return;
        }
        for (y, row) in self.rows.chunks_exact(self.stride).enumerate() {
            for (w, &bits) in row.iter().enumerate() {
                let at = y * self.side + w * 64;
                words[at / 64] |= bits << (at % 64);
                if !at.is_multiple_of(64) && bits >> (64 - at % 64) != 0 {
                    words[at / 64 + 1] |= bits >> (64 - at % 64);
                }
            }
        }
    }

    /// Adds to every count of a face of (side / samples)² texels the rays of its samples² that live.
    pub(super) fn count(&self, samples: usize, counts: &mut [u8]) {
        let texels = self.side / samples;
        for (y, row) in self.rows.chunks_exact(self.stride).enumerate() {
            let counts = &mut counts[y / samples * texels..][..texels];
            for (x, count) in counts.iter_mut().enumerate() {
                *count += (x * samples..(x + 1) * samples).map(|i| (row[i / 64] >> (i % 64) & 1) as u8).sum::<u8>();
            }
        }
    }
}

/// The bits of word `w` that belong to the columns first..end.
#[inline(always)]
fn run(first: usize, end: usize, w: usize) -> u64 {
    let (first, end) = (first.saturating_sub(w * 64).min(64), end.saturating_sub(w * 64).min(64));
    let below = |n: usize| if n < 64 { (1_u64 << n) - 1 } else { u64::MAX };
    below(end) & !below(first)
}
