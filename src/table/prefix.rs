//! The passes under every summed-area table. Everything here is `#[inline(always)]`, so that it is compiled for the vector unit
//! of the caller, which `pulp` picks once for a whole table or batch.
//!
//! Row r + 1 of the exclusive table is the prefix sum, over the columns, of the column sums C_r = x_0 + … + x_r. The column sums are
//! carried in two parts, of the rows of this band so far and of the bands above: bands can then be summed apart, on any thread,
//! and give the same bits.

use crate::Real;

/// The width of a step: whole vectors of every machine, in both precisions.
const STEP: usize = 8;

/// Columns that pass through the buffers of a row together; they stay in the first-level cache.
const CHUNK: usize = 256;

/// Rows of a band.
pub(super) const BAND: usize = 64;

#[inline(always)]
fn convert<S: Real, T: Real>(x: S) -> T {
    T::of(x.widen())
}

/// Adds the samples of a band's rows to its column sums.
#[cfg(feature = "rayon")]
#[inline(always)]
pub(super) fn column_sums<S: Real, T: Real>(samples: &[S], sums: &mut [T]) {
    for row in samples.chunks_exact(sums.len()) {
        for (sum, &x) in sums.iter_mut().zip(row) {
            *sum += convert(x);
        }
    }
}

/// The column sums above a row: of the bands above, and of the rows of this band.
pub(super) struct Columns<'a, T> {
    pub(super) above: &'a [T],
    pub(super) band: &'a mut [T],
}

/// The rows of a table below a band of samples. `table` has one row of width + 1 entries for each row of samples.
#[inline(always)]
pub(super) fn band<S: Real, T: Real>(samples: &[S], columns: &mut Columns<'_, T>, table: &mut [T]) {
    let width = columns.above.len();
    let mut window = Window { sums: [T::zero(); STEP + CHUNK], pairs: [T::zero(); STEP + CHUNK] };
    for (samples, table) in samples.chunks_exact(width).zip(table.chunks_exact_mut(width + 1)) {
        table[0] = T::zero();
        let mut carry = [T::zero(); STEP];
        window.start();
        let chunks = samples.chunks(CHUNK).zip(table[1..].chunks_mut(CHUNK));
        let columns = columns.above.chunks(CHUNK).zip(columns.band.chunks_mut(CHUNK));
        for (k, ((samples, table), (above, band))) in chunks.zip(columns).enumerate() {
            if k > 0 {
                window.slide();
            }
            window.add_row(samples, above, band);
            window.prefix(table, &mut carry);
        }
    }
}

/// A chunk of a row of column sums, and their sums two by two, each behind the last STEP of the chunk before.
struct Window<T> {
    sums: [T; STEP + CHUNK],
    pairs: [T; STEP + CHUNK],
}

impl<T: Real> Window<T> {
    #[inline(always)]
    fn start(&mut self) {
        self.sums[..STEP].fill(T::zero());
        self.pairs[..STEP].fill(T::zero());
    }

    /// To the next chunk of the same row.
    #[inline(always)]
    fn slide(&mut self) {
        for buffer in [&mut self.sums, &mut self.pairs] {
            let last: [T; STEP] = *buffer.last_chunk().expect("longer than a step");
            *buffer.first_chunk_mut().expect("longer than a step") = last;
        }
    }

    #[inline(always)]
    fn add_row<S: Real>(&mut self, samples: &[S], above: &[T], band: &mut [T]) {
        let count = samples.len();
        let (above, band) = (&above[..count], &mut band[..count]);
        let sums = &mut self.sums[STEP..][..count];
        let (steps, rest) = samples.as_chunks::<STEP>();
        let band_steps = &mut band.as_chunks_mut::<STEP>().0[..steps.len()];
        let above_steps = &above.as_chunks::<STEP>().0[..steps.len()];
        let sums_steps = &mut sums.as_chunks_mut::<STEP>().0[..steps.len()];
        for k in 0..steps.len() {
            let (x, mut band, above) = (steps[k], band_steps[k], above_steps[k]);
            let mut sum = [T::zero(); STEP];
            for i in 0..STEP {
                band[i] += convert(x[i]);
                sum[i] = band[i] + above[i];
            }
            band_steps[k] = band;
            sums_steps[k] = sum;
        }
        for i in count - rest.len()..count {
            band[i] += convert(samples[i]);
            sums[i] = band[i] + above[i];
        }
    }

    /// The sum of the STEP entries up to each, and of everything STEP places before.
    #[inline(always)]
    fn prefix(&mut self, table: &mut [T], carry: &mut [T; STEP]) {
        let whole = table.len().div_ceil(STEP);
        let count = whole * STEP;
        let (before, sums) = (&self.sums[STEP - 1..][..count], &self.sums[STEP..][..count]);
        let pairs = &mut self.pairs[STEP..][..count];
        for i in 0..count {
            pairs[i] = before[i] + sums[i];
        }
        let (steps, rest) = table.as_chunks_mut::<STEP>();
        let whole = steps.len();
        for k in 0..whole {
            steps[k] = self.step(k, carry);
        }
        if !rest.is_empty() {
            let last = self.step(whole, carry);
            rest.copy_from_slice(&last[..rest.len()]);
        }
    }

    #[inline(always)]
    fn step(&self, k: usize, carry: &mut [T; STEP]) -> [T; STEP] {
        let at = |back: usize| -> &[T; STEP] { self.pairs[(k + 1) * STEP - back..].first_chunk().expect("inside") };
        let [a, b, c, d] = [at(0), at(2), at(4), at(6)];
        for i in 0..STEP {
            carry[i] += (a[i] + b[i]) + (c[i] + d[i]);
        }
        *carry
    }
}
