//! Differential coding by its matrices: D, its inverse's transpose, and plain sums.

/// V_d = D V, eq. 5 of [Inger 2013]: (place, difference) where it is not 0.
pub fn differences(map: &[f64]) -> Vec<(usize, f64)> {
    let before = |i: usize| if i == 0 { 0.0 } else { map[i - 1] };
    (0..map.len()).map(|i| (i, map[i] - before(i))).filter(|&(_, d)| d != 0.0).collect()
}

/// V = D⁻¹ V_d: each pixel is the sum of the differences up to it.
pub fn integrate(len: usize, differences: &[(usize, f64)]) -> Vec<f64> {
    (0..len).map(|i| differences.iter().filter(|&&(at, _)| at <= i).map(|&(_, d)| d).sum()).collect()
}

/// L_int = D⁻ᵀ L, eq. 6: each entry is the sum of the signal from it on.
pub fn suffix_sums(signal: &[f64]) -> Vec<f64> {
    (0..signal.len()).map(|i| signal[i..].iter().rev().sum()).collect()
}

/// A number in base 128, lowest digit first, 128 added to all digits but the last.
pub fn varint(x: u64) -> Vec<u8> {
    if x < 128 { vec![x as u8] } else { [vec![(x % 128) as u8 + 128], varint(x / 128)].concat() }
}

/// The pixels (x, y) of Hilbert's curve of 2^k a side, from the top left to the top right: four smaller curves, the
/// first and the last transposed about the diagonals so that the ends meet.
pub fn hilbert(levels: u32) -> Vec<(usize, usize)> {
    let Some(finer) = levels.checked_sub(1) else { return vec![(0, 0)] };
    let (curve, half) = (hilbert(finer), 1 << finer);
    let quadrants: [&dyn Fn(usize, usize) -> (usize, usize); 4] =
        [&|x, y| (y, x), &|x, y| (x, y + half), &|x, y| (x + half, y + half), &|x, y| (2 * half - 1 - y, half - 1 - x)];
    quadrants.iter().flat_map(|place| curve.iter().map(|&(x, y)| place(x, y)).collect::<Vec<_>>()).collect()
}
