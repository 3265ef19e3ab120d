//! The passes under every summed-area table. Everything here is `#[inline(always)]`, so that it is compiled for the vector unit
//! of the caller, which `pulp` picks once for a whole table or batch.
//!
//! Row r + 1 of the exclusive table is row r and the prefix sums of the samples of row r. Rows add up in two parts, of this band so far
//! and of the bands above: bands can then be summed apart, on any thread, and give the same bits.

use crate::Real;

/// The width of a step: whole vectors of every machine, in both precisions.
const STEP: usize = 8;

/// Rows of a band.
pub(super) const BAND: usize = 64;

/// The rows of a table below a band of samples. `table` has one row of width + 1 entries for each row of samples; `above` is the table's
/// row above them without its first entry, and `sums` zero: it leaves as what the band adds to it.
#[inline(always)]
pub(super) fn band<S: Real, T: Real>(samples: &[S], above: &[T], sums: &mut [T], table: &mut [T]) {
    let width = above.len();
    for (samples, table) in samples.chunks_exact(width).zip(table.chunks_exact_mut(width + 1)) {
        table[0] = T::zero();
        row(samples, above, sums, &mut table[1..]);
    }
}

/// A row, whole steps first. Ends of a row are whole steps as well, or LLVM would not keep what passes to them in vectors.
#[inline(always)]
fn row<S: Real, T: Real>(samples: &[S], above: &[T], sums: &mut [T], table: &mut [T]) {
    let zeros = [T::zero(); STEP];
    let mut prefix = Prefix { pairs: zeros, fours: zeros, sums: zeros };
    let (here, rest) = samples.as_chunks::<STEP>();
    let (above, above_rest) = above.as_chunks::<STEP>();
    let (sums, sums_rest) = sums.as_chunks_mut::<STEP>();
    let (table, table_rest) = table.as_chunks_mut::<STEP>();
    let steps = here.len();
    let (above, sums, table) = (&above[..steps], &mut sums[..steps], &mut table[..steps]);
    if steps > 0 {
        let first = convert(&here[0]);
        prefix = prefix.next([first, behind::<T, 1>(zeros, first)]);
        sums[0] = add(sums[0], prefix.sums);
        table[0] = add(sums[0], above[0]);
        let before = &samples[STEP - 1..].as_chunks::<STEP>().0[..steps - 1];
        for k in 1..steps {
            prefix = prefix.next([convert(&here[k]), convert(&before[k - 1])]);
            sums[k] = add(sums[k], prefix.sums);
            table[k] = add(sums[k], above[k]);
        }
    }
    if !rest.is_empty() {
        let [last, above] = [filled(sums_rest), filled(above_rest)];
        let before = here.last().map_or(S::zero(), |here| here[STEP - 1]);
        let last = add(last, prefix.next(last_step(before, rest)).sums);
        sums_rest.copy_from_slice(&last[..rest.len()]);
        table_rest.copy_from_slice(&add(last, above)[..rest.len()]);
    }
}

/// A step of samples, zeros behind them, and the step one place before it.
#[inline(always)]
fn last_step<S: Real, T: Real>(before: S, samples: &[S]) -> [[T; STEP]; 2] {
    let mut last = [S::zero(); STEP + 1];
    last[0] = before;
    last[1..=samples.len()].copy_from_slice(samples);
    [1, 0].map(|at| convert(last[at..].first_chunk().expect("a step")))
}

/// A step that begins with `values`.
#[inline(always)]
fn filled<T: Real>(values: &[T]) -> [T; STEP] {
    let mut step = [T::zero(); STEP];
    step[..values.len()].copy_from_slice(values);
    step
}

#[inline(always)]
fn convert<S: Real, T: Real>(samples: &[S; STEP]) -> [T; STEP] {
    let mut out = [T::zero(); STEP];
    for i in 0..STEP {
        out[i] = T::of(samples[i].widen());
    }
    out
}

/// Prefix sums of a row, a step at a time: the sum of the STEP samples up to each, and of everything STEP places before. Samples come a
/// second time from memory, one place off; sums of two and four are shifted in registers.
struct Prefix<T> {
    pairs: [T; STEP],
    fours: [T; STEP],
    sums: [T; STEP],
}

impl<T: Real> Prefix<T> {
    #[inline(always)]
    fn next(self, [here, before]: [[T; STEP]; 2]) -> Self {
        let pairs = add(here, before);
        let fours = add(pairs, behind::<T, 2>(self.pairs, pairs));
        let eights = add(fours, behind::<T, 4>(self.fours, fours));
        Self { pairs, fours, sums: add(self.sums, eights) }
    }
}

#[inline(always)]
fn add<T: Real>(a: [T; STEP], b: [T; STEP]) -> [T; STEP] {
    let mut out = [T::zero(); STEP];
    for i in 0..STEP {
        out[i] = a[i] + b[i];
    }
    out
}

/// What lies N places before each of a step.
#[inline(always)]
fn behind<T: Real, const N: usize>(before: [T; STEP], here: [T; STEP]) -> [T; STEP] {
    let mut out = [T::zero(); STEP];
    for i in 0..STEP {
        out[i] = if i < N { before[STEP - N + i] } else { here[i - N] };
    }
    out
}
