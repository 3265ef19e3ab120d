//! The passes under every summed-area table. Everything here is `#[inline(always)]`, so that it is compiled for the
//! vector unit of the caller, which `pulp` picks once for a whole table or batch.
//!
//! Row r + 1 of the exclusive table is row r and the prefix sums of the samples of row r. Rows add up in two parts, of
//! this band so far and of the bands above: bands can then be summed apart, on any thread, and give the same bits.
//!
//! Rows are taken R at a time and L columns to a step. Neither changes an operation on a number, so neither changes a
//! bit: two rows read and write what is above them once, and keep two chains of additions busy.

use crate::Real;

/// Samples that are added up apart: a prefix sum is that of this many samples and the one as many places before. L is a
/// multiple of it.
const WINDOW: usize = 8;

/// Rows of a band.
pub(super) const BAND: usize = 64;

/// Whether tables of `T` from samples of `S` are summed by two rows and sixteen columns: those of `f32`. Sums in `f64`
/// would fill the registers with that, and spill.
#[inline(always)]
pub(super) const fn by_two<S, T>() -> bool {
    size_of::<S>() == 4 && size_of::<T>() == 4
}

/// The rows of a table below a band of samples. `table` has one row of width + 1 entries for each row of samples;
/// `above` is the table's row above them without its first entry, and `sums` zero: it leaves as what the band adds to
/// it.
#[inline(always)]
pub(super) fn band<S: Real, T: Real>(samples: &[S], above: &[T], sums: &mut [T], table: &mut [T]) {
    let (width, pitch) = (above.len(), above.len() + 1);
    let pairs = if by_two::<S, T>() { table.len() / (2 * pitch) } else { 0 };
    let (samples, last_samples) = samples.split_at(pairs * 2 * width);
    let (table, last) = table.split_at_mut(pairs * 2 * pitch);
    for (samples, table) in samples.chunks_exact(2 * width).zip(table.chunks_exact_mut(2 * pitch)) {
        rows::<S, T, 2, 16>(samples, above, sums, table);
    }
    for (samples, table) in last_samples.chunks_exact(width).zip(last.chunks_exact_mut(pitch)) {
        rows::<S, T, 1, WINDOW>(samples, above, sums, table);
    }
}

/// R rows, whole steps first. Ends of rows are whole steps as well, or LLVM would not keep what passes to them in
/// vectors.
#[inline(always)]
fn rows<S: Real, T: Real, const R: usize, const L: usize>(samples: &[S], above: &[T], sums: &mut [T], table: &mut [T]) {
    let (width, steps, zeros) = (above.len(), above.len() / L, [T::zero(); L]);
    let (mut samples, mut table) = (samples.chunks_exact(width), table.chunks_exact_mut(width + 1));
    let samples: [&[S]; R] = std::array::from_fn(|_| samples.next().expect("a row of samples"));
    let mut table: [&mut [T]; R] = std::array::from_fn(|_| {
        let (first, rest) = table.next().and_then(<[T]>::split_first_mut).expect("a row of the table");
        *first = T::zero();
        rest
    });
    let mut prefix: [Prefix<T, L>; R] = std::array::from_fn(|_| Prefix { pairs: zeros, fours: zeros, sums: zeros });
    let (above, above_rest) = above.as_chunks::<L>();
    let (sums, sums_rest) = sums.as_chunks_mut::<L>();
    let (above, sums) = (&above[..steps], &mut sums[..steps]);
    if steps > 0 {
        let here: [&[[S; L]]; R] = std::array::from_fn(|r| &samples[r].as_chunks::<L>().0[..steps]);
        let before: [&[[S; L]]; R] = std::array::from_fn(|r| &samples[r][L - 1..].as_chunks::<L>().0[..steps - 1]);
        let table = table.each_mut().map(|row| &mut row.as_chunks_mut::<L>().0[..steps]);
        let mut sum = sums[0];
        for r in 0..R {
            let first = convert(&here[r][0]);
            prefix[r].advance([first, behind::<T, L, 1>(zeros, first)]);
            sum = add(sum, prefix[r].sums);
            table[r][0] = add(sum, above[0]);
        }
        sums[0] = sum;
        for k in 1..steps {
            let (mut sum, above) = (sums[k], above[k]);
            for r in 0..R {
                prefix[r].advance([convert(&here[r][k]), convert(&before[r][k - 1])]);
                sum = add(sum, prefix[r].sums);
                table[r][k] = add(sum, above);
            }
            sums[k] = sum;
        }
    }
    let end = steps * L;
    if end < width {
        let [mut sum, above] = [filled(sums_rest), filled(above_rest)];
        for r in 0..R {
            let before = if end > 0 { samples[r][end - 1] } else { S::zero() };
            prefix[r].advance(last_step(before, &samples[r][end..]));
            sum = add(sum, prefix[r].sums);
            table[r][end..].copy_from_slice(&add(sum, above)[..width - end]);
        }
        sums_rest.copy_from_slice(&sum[..width - end]);
    }
}

/// A step of samples, zeros behind them, and the step one place before it.
#[inline(always)]
fn last_step<S: Real, T: Real, const L: usize>(before: S, samples: &[S]) -> [[T; L]; 2] {
    let mut here = [S::zero(); L];
    here[..samples.len()].copy_from_slice(samples);
    let mut behind = here;
    behind.rotate_right(1);
    behind[0] = before;
    [convert(&here), convert(&behind)]
}

/// A step that begins with `values`.
#[inline(always)]
fn filled<T: Real, const L: usize>(values: &[T]) -> [T; L] {
    let mut step = [T::zero(); L];
    step[..values.len()].copy_from_slice(values);
    step
}

#[inline(always)]
fn convert<S: Real, T: Real, const L: usize>(samples: &[S; L]) -> [T; L] {
    let mut out = [T::zero(); L];
    for i in 0..L {
        out[i] = T::of(samples[i].widen());
    }
    out
}

/// Prefix sums of a row, a step at a time: the sum of the WINDOW samples up to each, and of everything WINDOW places
/// before. Samples come a second time from memory, one place off; sums of two and four are shifted in registers.
struct Prefix<T, const L: usize> {
    pairs: [T; L],
    fours: [T; L],
    sums: [T; L],
}

impl<T: Real, const L: usize> Prefix<T, L> {
    #[inline(always)]
    fn advance(&mut self, [here, before]: [[T; L]; 2]) {
        let pairs = add(here, before);
        let fours = add(pairs, behind::<T, L, 2>(self.pairs, pairs));
        let eights = add(fours, behind::<T, L, 4>(self.fours, fours));
        let mut sums = self.sums;
        for i in 0..WINDOW {
            sums[i] = self.sums[L - WINDOW + i] + eights[i];
        }
        for i in WINDOW..L {
            sums[i] = sums[i - WINDOW] + eights[i];
        }
        *self = Self { pairs, fours, sums };
    }
}

#[inline(always)]
fn add<T: Real, const L: usize>(a: [T; L], b: [T; L]) -> [T; L] {
    let mut out = [T::zero(); L];
    for i in 0..L {
        out[i] = a[i] + b[i];
    }
    out
}

/// What lies N places before each of a step.
#[inline(always)]
fn behind<T: Real, const L: usize, const N: usize>(before: [T; L], here: [T; L]) -> [T; L] {
    let mut out = [T::zero(); L];
    for i in 0..L {
        out[i] = if i < N { before[L - N + i] } else { here[i - N] };
    }
    out
}
