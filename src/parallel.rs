//! Loops over pieces that do not depend on each other, on all threads (feature `rayon`) or one after the other: the
//! only place that knows which. Nothing here adds up what pieces give, so results are the same bits for any number of
//! threads, and without them.
//!
//! | you have | use |
//! |---|---|
//! | a number of things to make | [`map`], [`try_map`] |
//! | a number of things to do | [`try_each`] |
//! | a slice to fill, an element or a row at a time | [`fill`], [`rows`] |
//! | a slice to fill, a chunk at a time | [`chunks`], [`try_chunks`] |
//! | the same, of chunks of different lengths | [`ragged`] |
//! | the same, with scratch that outlives the loop | [`pieces`], [`with_scratch`] |
//! | a caller who watches | [`Watch`] |
//!
//! Chunks are counted from 0 and all have the length that was asked for, but for the last.

use std::sync::atomic::{AtomicUsize, Ordering};

#[cfg(feature = "rayon")]
use rayon::prelude::*;

use crate::{Error, Progress, Result};

/// Elements that a task of [`fill`] takes at a time.
const FILLED_TOGETHER: usize = 256;

/// Into how many pieces a loop is cut that keeps scratch for each: some a thread, so that they balance.
pub(crate) fn pieces() -> usize {
    #[cfg(feature = "rayon")]
    return 4 * rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    return 1;
}

/// f(0), f(1), … f(count − 1).
pub(crate) fn map<R: Send>(count: usize, f: impl Fn(usize) -> R + Sync) -> Vec<R> {
    #[cfg(feature = "rayon")]
    return (0..count).into_par_iter().map(&f).collect();
    #[cfg(not(feature = "rayon"))]
    return (0..count).map(f).collect();
}

/// As [`map`] of what can fail, with scratch that each thread makes for itself. One of the errors, if there are
/// several.
pub(crate) fn try_map<R: Send, S>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(usize, &mut S) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    #[cfg(feature = "rayon")]
    return (0..count).into_par_iter().map_init(&scratch, |scratch, i| f(i, scratch)).collect();
    #[cfg(not(feature = "rayon"))]
    {
        let mut scratch = scratch();
        (0..count).map(|i| f(i, &mut scratch)).collect()
    }
}

/// Calls f(0), f(1), … f(count − 1), with scratch that each thread makes for itself. One of the errors, if there are
/// several.
#[allow(dead_code, reason = "for those features that ask for it")]
pub(crate) fn try_each<S>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(usize, &mut S) -> Result<()> + Sync,
) -> Result<()> {
    #[cfg(feature = "rayon")]
    return (0..count).into_par_iter().try_for_each_init(&scratch, |scratch, i| f(i, scratch));
    #[cfg(not(feature = "rayon"))]
    {
        let mut scratch = scratch();
        (0..count).try_for_each(|i| f(i, &mut scratch))
    }
}

/// Calls `f(k, chunk, scratch)` for every chunk of `out`, with scratch that each thread makes for itself.
pub(crate) fn chunks<T: Send, S>(
    out: &mut [T],
    chunk: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(usize, &mut [T], &mut S) + Sync,
) {
    if out.is_empty() {
        return;
    }
    #[cfg(feature = "rayon")]
    out.par_chunks_mut(chunk).enumerate().for_each_init(&scratch, |scratch, (k, part)| f(k, part, scratch));
    #[cfg(not(feature = "rayon"))]
    {
        let mut scratch = scratch();
        out.chunks_mut(chunk).enumerate().for_each(|(k, part)| f(k, part, &mut scratch));
    }
}

/// As [`chunks`], of `count` chunks of different lengths: number k ends where number k + 1 begins, at `start(k + 1)`.
pub(crate) fn ragged<T: Send, S>(
    out: &mut [T],
    count: usize,
    start: impl Fn(usize) -> usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(usize, &mut [T], &mut S) + Sync,
) {
    let mut rest = out;
    let parts = (0..count).map(|k| {
        let (part, others) = std::mem::take(&mut rest).split_at_mut(start(k + 1) - start(k));
        rest = others;
        (k, part)
    });
    #[cfg(feature = "rayon")]
    {
        let parts: Vec<_> = parts.collect();
        parts.into_par_iter().for_each_init(&scratch, |scratch, (k, part)| f(k, part, scratch));
    }
    #[cfg(not(feature = "rayon"))]
    {
        let mut scratch = scratch();
        parts.for_each(|(k, part)| f(k, part, &mut scratch));
    }
}

/// As [`chunks`] of what can fail: one of the errors, and `out` is of no use then.
pub(crate) fn try_chunks<T: Send, S>(
    out: &mut [T],
    chunk: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(usize, &mut [T], &mut S) -> Result<()> + Sync,
) -> Result<()> {
    if out.is_empty() {
        return Ok(());
    }
    #[cfg(feature = "rayon")]
    return out.par_chunks_mut(chunk).enumerate().try_for_each_init(&scratch, |scratch, (k, part)| f(k, part, scratch));
    #[cfg(not(feature = "rayon"))]
    {
        let mut scratch = scratch();
        out.chunks_mut(chunk).enumerate().try_for_each(|(k, part)| f(k, part, &mut scratch))
    }
}

/// Cuts `out` into as many chunks as there is scratch, at most, each a multiple of `multiple` long (but the last), and
/// calls `f(first, chunk, scratch)` for each, `first` the number of its first element. Nothing is allocated.
#[allow(dead_code, reason = "for those back ends that ask for it")]
pub(crate) fn with_scratch<T: Send, S: Send>(
    out: &mut [T],
    multiple: usize,
    scratch: &mut [S],
    f: impl Fn(usize, &mut [T], &mut S) -> Result<()> + Sync,
) -> Result<()> {
    if out.is_empty() {
        return Ok(());
    }
    let chunk = out.len().div_ceil(scratch.len()).next_multiple_of(multiple);
    let run = |(k, (part, scratch)): (usize, (&mut [T], &mut S))| f(k * chunk, part, scratch);
    #[cfg(feature = "rayon")]
    return out.par_chunks_mut(chunk).zip(scratch).enumerate().try_for_each(run);
    #[cfg(not(feature = "rayon"))]
    return out.chunks_mut(chunk).zip(scratch).enumerate().try_for_each(run);
}

/// Writes `f(i, scratch)` to every `out[i]`, with scratch that each thread makes for itself.
pub(crate) fn fill<T: Send, S>(out: &mut [T], scratch: impl Fn() -> S + Sync, f: impl Fn(usize, &mut S) -> T + Sync) {
    chunks(out, FILLED_TOGETHER, scratch, |k, part, scratch| {
        part.iter_mut().enumerate().for_each(|(i, slot)| *slot = f(k * FILLED_TOGETHER + i, scratch));
    });
}

/// Calls `f(j, row)` for every row of `len` elements, `together` rows a task. Rows of no elements are none.
pub(crate) fn rows<T: Send>(out: &mut [T], len: usize, together: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    if len == 0 {
        return;
    }
    chunks(
        out,
        together * len,
        || (),
        |k, part, ()| {
            part.chunks_exact_mut(len).enumerate().for_each(|(j, row)| f(k * together + j, row));
        },
    );
}

/// Tells a caller's [`Progress`] how much of a loop is done, and whether to go on.
pub(crate) struct Watch<'a> {
    progress: &'a dyn Progress,
    done: AtomicUsize,
    total: usize,
}

impl<'a> Watch<'a> {
    /// Of `total` pieces, none of them done.
    pub(crate) fn new(progress: &'a dyn Progress, total: usize) -> Self {
        Self { progress, done: AtomicUsize::new(0), total }
    }

    /// How many pieces there are.
    pub(crate) fn total(&self) -> usize {
        self.total
    }

    /// [`Error::Cancelled`] if the caller wants no more.
    pub(crate) fn check(&self) -> Result<()> {
        if self.progress.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// So many more pieces are done. More than there are count as all.
    pub(crate) fn advance(&self, pieces: usize) {
        let before = self.done.fetch_add(pieces, Ordering::Relaxed);
        self.progress.advance(before.saturating_add(pieces).min(self.total), self.total);
    }

    /// So many pieces are done, whatever was counted until now.
    pub(crate) fn skip_to(&self, pieces: usize) {
        self.done.store(pieces, Ordering::Relaxed);
        self.progress.advance(pieces, self.total);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn every_element_is_filled_by_its_own_number() {
        for len in [0, 1, 255, 256, 257, 1000] {
            let mut out = vec![usize::MAX; len];
            fill(&mut out, || 7, |i, seven| i * *seven);
            assert!(out.iter().enumerate().all(|(i, &x)| x == 7 * i), "{len}");
            assert_eq!(map(len, |i| 3 * i), (0..len).map(|i| 3 * i).collect::<Vec<_>>());
        }
    }

    #[test]
    fn rows_and_chunks_know_their_numbers() {
        let mut out = vec![0; 3 * 11];
        rows(&mut out, 3, 4, |j, row| row.fill(j + 1));
        assert!(out.iter().enumerate().all(|(i, &x)| x == i / 3 + 1));
        rows(&mut out, 0, 4, |_, _| unreachable!());
        chunks(&mut out, 8, || (), |k, part, ()| part.fill(k));
        assert!(out.iter().enumerate().all(|(i, &x)| x == i / 8));
    }

    #[test]
    fn ragged_chunks_begin_where_they_say() {
        let starts = [0, 3, 3, 10, 11];
        let mut out = vec![usize::MAX; 11];
        ragged(&mut out, 4, |k| starts[k], || (), |k, part, ()| part.fill(k));
        assert_eq!(out, [0, 0, 0, 2, 2, 2, 2, 2, 2, 2, 3]);
        ragged(&mut out, 0, |k| starts[k], || (), |_, _, ()| unreachable!());
    }

    #[test]
    fn pieces_with_scratch_begin_at_multiples() {
        for len in [0, 1, 63, 64, 65, 1000] {
            let mut out = vec![usize::MAX; len];
            let mut scratch = vec![0; 5];
            with_scratch(&mut out, 16, &mut scratch, |first, part, count| {
                assert_eq!(first % 16, 0);
                *count += part.len();
                part.iter_mut().enumerate().for_each(|(i, x)| *x = first + i);
                Ok(())
            })
            .unwrap();
            assert!(out.iter().enumerate().all(|(i, &x)| x == i), "{len}");
            assert_eq!(scratch.iter().sum::<usize>(), len);
        }
    }

    #[test]
    fn errors_come_out() {
        let fails = |i: usize| if i == 300 { Err(Error::Cancelled) } else { Ok(i) };
        assert_eq!(try_map(301, || (), |i, ()| fails(i)), Err(Error::Cancelled));
        assert_eq!(try_map(300, || (), |i, ()| fails(i)).map(|all| all.len()), Ok(300));
        let mut out = vec![0; 301];
        assert_eq!(try_chunks(&mut out, 1, || (), |k, _, ()| fails(k).map(drop)), Err(Error::Cancelled));
        assert_eq!(with_scratch(&mut out, 1, &mut [0; 2], |_, _, _| Err(Error::Cancelled)), Err(Error::Cancelled));
    }

    #[test]
    fn a_watch_counts_and_stops() {
        #[derive(Default)]
        struct Seen(Mutex<Vec<(usize, usize)>>);
        impl Progress for Seen {
            fn advance(&self, done: usize, total: usize) {
                self.0.lock().unwrap().push((done, total));
            }
            fn is_cancelled(&self) -> bool {
                self.0.lock().unwrap().len() > 2
            }
        }
        let seen = Seen::default();
        let watch = Watch::new(&seen, 10);
        watch.advance(4);
        watch.skip_to(8);
        assert_eq!(watch.check(), Ok(()));
        watch.advance(usize::MAX);
        assert_eq!(*seen.0.lock().unwrap(), [(4, 10), (8, 10), (10, 10)]);
        assert_eq!(watch.check(), Err(Error::Cancelled));
    }
}
