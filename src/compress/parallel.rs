//! Loops over independent outputs: the same bits for any number of threads.

/// Calls `f(j, &mut out[j·chunk..][..chunk])` for every j, the last one with what is left.
pub(super) fn for_chunks<T: Send>(out: &mut [T], chunk: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    if chunk == 0 {
        return;
    }
    let task = |(index, part)| f(index, part);
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        out.par_chunks_mut(chunk).enumerate().for_each(task);
    }
    #[cfg(not(feature = "rayon"))]
    out.chunks_mut(chunk).enumerate().for_each(task);
}

/// Calls `f(j, &mut out[j·sides..][..sides])` for every j, `chunk` of them a task.
pub(super) fn for_rows<T: Send>(out: &mut [T], sides: usize, chunk: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    if sides == 0 {
        return;
    }
    for_chunks(out, chunk * sides, |index, part| {
        part.chunks_exact_mut(sides).enumerate().for_each(|(k, slot)| f(index * chunk + k, slot));
    });
}

/// f(0), f(1), … in order.
pub(super) fn map<R: Send>(count: usize, f: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(f).collect()
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).map(f).collect()
}
