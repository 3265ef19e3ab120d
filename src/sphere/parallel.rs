//! Filling a slice whose elements do not depend on each other: the same bits for any number of threads.

/// Writes `f(i, scratch)` to every `out[i]`; each thread makes its own scratch.
pub(crate) fn fill_with<T: Send, S>(
    out: &mut [T],
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(usize, &mut S) -> T + Sync,
) {
    /// Elements a task takes at a time.
    const CHUNK: usize = 256;
    let fill = |start: usize, chunk: &mut [T], scratch: &mut S| {
        chunk.iter_mut().enumerate().for_each(|(i, slot)| *slot = f(start + i, scratch));
    };
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        out.par_chunks_mut(CHUNK)
            .enumerate()
            .for_each_init(&scratch, |scratch, (k, chunk)| fill(k * CHUNK, chunk, scratch));
    }
    #[cfg(not(feature = "rayon"))]
    {
        let mut scratch = scratch();
        out.chunks_mut(CHUNK).enumerate().for_each(|(k, chunk)| fill(k * CHUNK, chunk, &mut scratch));
    }
}
