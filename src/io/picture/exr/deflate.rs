//! zlib and run-length codes, and the prediction that goes before them.

use miniz_oxide::inflate::decompress_slice_iter_to_slice;

use super::input::Input;

/// Fills `out` from zlib-compressed bytes; more or less than its length is an error, and so is a wrong checksum.
pub(super) fn inflate(bytes: &[u8], out: &mut [u8]) -> Result<(), String> {
    match decompress_slice_iter_to_slice(out, std::iter::once(bytes), true, false) {
        Ok(n) if n == out.len() => Ok(()),
        Ok(n) => Err(format!("the zlib-compressed data hold {n} bytes where {} are needed", out.len())),
        Err(_) => Err("the zlib-compressed data are damaged".into()),
    }
}

/// ZIP and ZIPS: prediction, then zlib.
pub(super) fn zip(bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
    let mut differences = vec![0; raw.len()];
    inflate(bytes, &mut differences)?;
    undo_prediction(&mut differences, raw);
    Ok(())
}

/// RLE: prediction, then runs.
pub(super) fn run_length(bytes: &[u8], raw: &mut [u8]) -> Result<(), String> {
    let mut differences = vec![0; raw.len()];
    undo_runs(bytes, &mut differences)?;
    undo_prediction(&mut differences, raw);
    Ok(())
}

/// Fills `out` from runs: a count n ≥ 0 and a byte that is there n + 1 times, or a count −n < 0 and n bytes.
pub(super) fn undo_runs(bytes: &[u8], out: &mut [u8]) -> Result<(), String> {
    let (mut input, mut at) = (Input(bytes), 0);
    while at < out.len() {
        let count = input.u8().ok_or("the runs end too early")?.cast_signed();
        let n = if count < 0 { usize::from(count.unsigned_abs()) } else { count as usize + 1 };
        let left = out.len() - at;
        let run = out.get_mut(at..at + n).ok_or_else(|| format!("a run of {n} bytes where {left} are left"))?;
        if count < 0 {
            run.copy_from_slice(input.take(n).ok_or("the runs end too early")?);
        } else {
            run.fill(input.u8().ok_or("the runs end too early")?);
        }
        at += n;
    }
    Ok(())
}

/// Undoes what makes samples easier to compress: the bytes at even places were taken first, then those at odd ones, and
/// each but the first was replaced by its difference to the one before, plus 128.
pub(super) fn undo_prediction(differences: &mut [u8], raw: &mut [u8]) {
    let mut last = 128_u8;
    for byte in differences.iter_mut() {
        // The first byte is itself: 128 − 128 is added.
        last = last.wrapping_add(*byte).wrapping_sub(128);
        *byte = last;
    }
    let (even, odd) = differences.split_at(raw.len().div_ceil(2));
    let (pairs, tail) = raw.as_chunks_mut::<2>();
    for ((pair, &a), &b) in pairs.iter_mut().zip(even).zip(odd) {
        *pair = [a, b];
    }
    if let ([last], [.., a]) = (tail, even) {
        *last = *a;
    }
}
