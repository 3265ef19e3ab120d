//! The level passes under every transform. Everything here is `#[inline(always)]`, so that it is compiled for the
//! vector unit of the caller, which `pulp` picks once for a whole transform or batch.
//!
//! Derivation, 1D. With a, b the means of the two halves of a cell of level l, the inner product with
//! 2^{l/2} ψ(2^l v − t) is 2^{l/2}·2^{−l}·(a − b)/2 = 2^{−l/2} (a − b)/2, and the cell's mean is (a + b)/2.
//! 2D nonstandard, with quarters a b / c d: mean (a + b + c + d)/4; horizontal, vertical and diagonal details are
//! 2^l·4^{−l}/4 = 2^{−l}/4 times (a − b + c − d), (a + b − c − d), (a − b − c + d).
//!
//! The halvings come first: no sum of finite samples overflows, and the power of two costs no accuracy.

use std::hint::black_box;

use crate::Real;

/// Where level l of a mean pyramid starts: 1 + 4 + … + 4^{l−1} = (4^l − 1)/3.
#[inline(always)]
pub(super) const fn pyramid_offset(level: u32) -> usize {
    (((1u128 << (2 * level)) - 1) / 3) as usize
}

/// 2^l.
#[inline(always)]
pub(super) fn power<T: Real>(level: u32) -> T {
    T::of((1u64 << level) as f64)
}

/// 2^{l/2}: a power of two, times √2 for odd l.
#[inline(always)]
pub(super) fn root_power<T: Real>(level: u32) -> T {
    let even = (1u64 << (level / 2)) as f64;
    T::of(if level % 2 == 0 { even } else { even * std::f64::consts::SQRT_2 })
}

/// The width of a step of the wide kernels: whole vectors of every machine, in both precisions.
const WIDE: usize = 8;

/// A row of N 2 × 2 blocks → their means and details.
///
/// It works on arrays by value: everything is read before anything is written, so that the compiler need not know
/// whether the slices of the caller overlap (through `pulp` it does not), and turns straight-line code into vectors and
/// shuffles.
#[inline(always)]
fn analyse<T: Real, const N: usize>(top: &[[T; 2]; N], bottom: &[[T; 2]; N], scale: T) -> [[T; N]; 4] {
    let quarter = T::of(0.25);
    let (mut sum, mut step) = ([[T::zero(); 2]; N], [[T::zero(); 2]; N]);
    for x in 0..N {
        for side in 0..2 {
            let (a, c) = (quarter * top[x][side], quarter * bottom[x][side]);
            (sum[x][side], step[x][side]) = (a + c, a - c);
        }
    }
    let mut out = [[T::zero(); N]; 4];
    for x in 0..N {
        out[0][x] = sum[x][0] + sum[x][1];
        out[1][x] = scale * (sum[x][0] - sum[x][1]);
        out[2][x] = scale * (step[x][0] + step[x][1]);
        out[3][x] = scale * (step[x][0] - step[x][1]);
    }
    out
}

/// The inverse of [`analyse`], before its results are interleaved: [top, bottom][left, right][block].
#[inline(always)]
fn synthesise<T: Real, const N: usize>([mean, h, v, d]: [&[T; N]; 4], scale: T) -> [[[T; N]; 2]; 2] {
    // m ± h are the means of the left and right halves, v ± d half their vertical steps: bounded by the samples.
    let (mut sum, mut step) = ([[T::zero(); N]; 2], [[T::zero(); N]; 2]);
    for x in 0..N {
        let (h, v, d) = (scale * h[x], scale * v[x], scale * d[x]);
        (sum[0][x], sum[1][x], step[0][x], step[1][x]) = (mean[x] + h, mean[x] - h, v + d, v - d);
    }
    let mut out = [[[T::zero(); N]; 2]; 2];
    for side in 0..2 {
        for x in 0..N {
            out[0][side][x] = sum[side][x] + step[side][x];
            out[1][side][x] = sum[side][x] - step[side][x];
        }
    }
    out
}

#[inline(always)]
fn interleave<T: Real, const N: usize>([left, right]: &[[T; N]; 2]) -> [[T; 2]; N] {
    let mut out = [[T::zero(); 2]; N];
    for x in 0..N {
        out[x] = [left[x], right[x]];
    }
    out
}

/// Means of level l + 1 (`fine`, side 2w) → means (side w) and the three detail blocks of level l, w = 2^l.
#[inline(always)]
fn analyse_level<T: Real>(level: u32, fine: &[T], mean: &mut [T], details: &mut [T]) {
    match level {
        0 => analyse_steps::<T, 1>(level, fine, mean, details),
        1 => analyse_steps::<T, 2>(level, fine, mean, details),
        2 => analyse_steps::<T, 4>(level, fine, mean, details),
        _ => analyse_steps::<T, WIDE>(level, fine, mean, details),
    }
}

#[inline(always)]
fn analyse_steps<T: Real, const N: usize>(level: u32, fine: &[T], mean: &mut [T], details: &mut [T]) {
    let (w, scale) = (1usize << level, T::one() / power::<T>(level));
    let steps = w / N;
    let fine = fine.as_chunks::<2>().0.as_chunks::<N>().0;
    let mean = mean.as_chunks_mut::<N>().0;
    let (horizontal, rest) = details.as_chunks_mut::<N>().0.split_at_mut(w * steps);
    let (vertical, diagonal) = rest.split_at_mut(w * steps);
    for y in 0..w {
        let (top, bottom) = fine[2 * y * steps..][..2 * steps].split_at(steps);
        let row = y * steps..(y + 1) * steps;
        let (mean, h) = (&mut mean[row.clone()], &mut horizontal[row.clone()]);
        let (v, d) = (&mut vertical[row.clone()], &mut diagonal[row]);
        for x in 0..steps {
            // An index of unknown value: the compiler must not gather several steps into one, that is 3× slower.
            let x = black_box(x);
            [mean[x], h[x], v[x], d[x]] = analyse(&top[x], &bottom[x], scale);
        }
    }
}

/// The inverse of [`analyse_level`].
#[inline(always)]
fn synthesise_level<T: Real>(level: u32, mean: &[T], details: &[T], fine: &mut [T]) {
    match level {
        0 => synthesise_steps::<T, 1>(level, mean, details, fine),
        1 => synthesise_steps::<T, 2>(level, mean, details, fine),
        2 => synthesise_steps::<T, 4>(level, mean, details, fine),
        _ => synthesise_steps::<T, WIDE>(level, mean, details, fine),
    }
}

#[inline(always)]
fn synthesise_steps<T: Real, const N: usize>(level: u32, mean: &[T], details: &[T], fine: &mut [T]) {
    let (w, scale) = (1usize << level, power::<T>(level));
    let steps = w / N;
    let fine = fine.as_chunks_mut::<2>().0.as_chunks_mut::<N>().0;
    let mean = mean.as_chunks::<N>().0;
    let (horizontal, rest) = details.as_chunks::<N>().0.split_at(w * steps);
    let (vertical, diagonal) = rest.split_at(w * steps);
    for y in 0..w {
        let (top, bottom) = fine[2 * y * steps..][..2 * steps].split_at_mut(steps);
        let row = y * steps..(y + 1) * steps;
        let (mean, h) = (&mean[row.clone()], &horizontal[row.clone()]);
        let (v, d) = (&vertical[row.clone()], &diagonal[row]);
        for x in 0..steps {
            let mut out = synthesise([&mean[x], &h[x], &v[x], &d[x]], scale);
            if N == WIDE {
                // A store that must happen: arithmetic stays in whole vectors, interleaving is done on reading back.
                // Otherwise the compiler shuffles first and adds and subtracts in mixed lanes: twice the time.
                black_box(&mut out);
            }
            (top[x], bottom[x]) = (interleave(&out[0]), interleave(&out[1]));
        }
    }
}

/// Levels below `levels`, from the pyramid's means of that level to `coefs` (4^levels of them).
#[inline(always)]
fn analyse_pyramid<T: Real>(levels: u32, pyramid: &mut [T], coefs: &mut [T]) {
    for level in (0..levels).rev() {
        let (coarse, fine) = pyramid.split_at_mut(pyramid_offset(level + 1));
        let (start, end) = (1 << (2 * level), 4 << (2 * level));
        analyse_level(level, &fine[..end], &mut coarse[pyramid_offset(level)..], &mut coefs[start..end]);
    }
    coefs[0] = pyramid[0];
}

/// The inverse of [`analyse_pyramid`]: fills the pyramid's levels 0..=levels.
#[inline(always)]
fn synthesise_pyramid<T: Real>(levels: u32, coefs: &[T], pyramid: &mut [T]) {
    pyramid[0] = coefs[0];
    for level in 0..levels {
        let (coarse, fine) = pyramid.split_at_mut(pyramid_offset(level + 1));
        let (start, end) = (1 << (2 * level), 4 << (2 * level));
        synthesise_level(level, &coarse[pyramid_offset(level)..], &coefs[start..end], &mut fine[..end]);
    }
}

/// Nonstandard transform of 2^levels squared samples; `pyramid` (levels 0..levels) is filled with the means.
#[inline(always)]
pub(crate) fn nonstandard_forward<T: Real>(levels: u32, src: &[T], dst: &mut [T], pyramid: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return dst.copy_from_slice(src) };
    let quarter = 1 << (2 * last);
    analyse_level(last, src, &mut pyramid[pyramid_offset(last)..][..quarter], &mut dst[quarter..]);
    analyse_pyramid(last, pyramid, &mut dst[..quarter]);
}

/// As [`nonstandard_forward`], in place; `details` holds 3/4 of the samples' number.
#[inline(always)]
pub(super) fn nonstandard_forward_in_place<T: Real>(levels: u32, data: &mut [T], pyramid: &mut [T], details: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return };
    let quarter = 1 << (2 * last);
    analyse_level(last, data, &mut pyramid[pyramid_offset(last)..][..quarter], details);
    data[quarter..].copy_from_slice(details);
    analyse_pyramid(last, pyramid, &mut data[..quarter]);
}

/// The inverse of [`nonstandard_forward`]; fills `pyramid` (levels 0..levels) too.
#[inline(always)]
pub(super) fn nonstandard_inverse<T: Real>(levels: u32, src: &[T], dst: &mut [T], pyramid: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return dst.copy_from_slice(src) };
    let quarter = 1 << (2 * last);
    synthesise_pyramid(last, &src[..quarter], pyramid);
    synthesise_level(last, &pyramid[pyramid_offset(last)..][..quarter], &src[quarter..], dst);
}

/// As [`nonstandard_inverse`], in place.
#[inline(always)]
pub(super) fn nonstandard_inverse_in_place<T: Real>(levels: u32, data: &mut [T], pyramid: &mut [T], details: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return };
    let quarter = 1 << (2 * last);
    synthesise_pyramid(last, &data[..quarter], pyramid);
    details.copy_from_slice(&data[quarter..]);
    synthesise_level(last, &pyramid[pyramid_offset(last)..][..quarter], details, data);
}

/// Means of every level below `levels`, from the pyramid's finest.
#[inline(always)]
pub(super) fn mean_pyramid<T: Real>(levels: u32, pyramid: &mut [T]) {
    for level in (0..levels).rev() {
        let (coarse, fine) = pyramid.split_at_mut(pyramid_offset(level + 1));
        let mean = &mut coarse[pyramid_offset(level)..];
        match level {
            0 => mean_steps::<T, 1>(level, fine, mean),
            1 => mean_steps::<T, 2>(level, fine, mean),
            2 => mean_steps::<T, 4>(level, fine, mean),
            _ => mean_steps::<T, WIDE>(level, fine, mean),
        }
    }
}

/// [`analyse_steps`] without the details.
#[inline(always)]
fn mean_steps<T: Real, const N: usize>(level: u32, fine: &[T], mean: &mut [T]) {
    let w = 1usize << level;
    let steps = w / N;
    let fine = fine.as_chunks::<2>().0.as_chunks::<N>().0;
    for (y, mean) in mean.as_chunks_mut::<N>().0[..w * steps].chunks_exact_mut(steps).enumerate() {
        let (top, bottom) = fine[2 * y * steps..][..2 * steps].split_at(steps);
        for x in 0..steps {
            let x = black_box(x); // as in analyse_steps
            [mean[x], ..] = analyse(&top[x], &bottom[x], T::one());
        }
    }
}

/// Means of level l + 1 (2w of them) → means and details of level l, w = 2^l.
#[inline(always)]
fn analyse_level_1d<T: Real>(level: u32, fine: &[T], mean: &mut [T], detail: &mut [T]) {
    let w = 1usize << level;
    let (half, scale) = (T::of(0.5), T::one() / root_power::<T>(level));
    let (fine, mean, detail) = (&fine.as_chunks::<2>().0[..w], &mut mean[..w], &mut detail[..w]);
    for t in 0..w {
        let [a, b] = fine[t];
        let (a, b) = (half * a, half * b);
        mean[t] = a + b;
        detail[t] = scale * (a - b);
    }
}

/// The inverse of [`analyse_level_1d`].
#[inline(always)]
fn synthesise_level_1d<T: Real>(level: u32, mean: &[T], detail: &[T], fine: &mut [T]) {
    let w = 1usize << level;
    let scale = root_power::<T>(level);
    let (mean, detail, fine) = (&mean[..w], &detail[..w], &mut fine.as_chunks_mut::<2>().0[..w]);
    for t in 0..w {
        let d = scale * detail[t];
        (fine[t][0], fine[t][1]) = (mean[t] + d, mean[t] - d);
    }
}

/// Means of levels 0..levels lie one after another: level l starts at 2^l − 1.
#[inline(always)]
fn analyse_means_1d<T: Real>(levels: u32, means: &mut [T], coefs: &mut [T]) {
    for level in (0..levels).rev() {
        let w = 1usize << level;
        let (coarse, fine) = means.split_at_mut(2 * w - 1);
        analyse_level_1d(level, fine, &mut coarse[w - 1..], &mut coefs[w..]);
    }
    coefs[0] = means[0];
}

/// The inverse of [`analyse_means_1d`].
#[inline(always)]
fn synthesise_means_1d<T: Real>(levels: u32, coefs: &[T], means: &mut [T]) {
    means[0] = coefs[0];
    for level in 0..levels {
        let w = 1usize << level;
        let (coarse, fine) = means.split_at_mut(2 * w - 1);
        synthesise_level_1d(level, &coarse[w - 1..], &coefs[w..], fine);
    }
}

/// 1D transform of 2^levels samples; `means` holds as many.
#[inline(always)]
pub(super) fn line_forward<T: Real>(levels: u32, src: &[T], dst: &mut [T], means: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return dst.copy_from_slice(src) };
    let half = 1usize << last;
    analyse_level_1d(last, src, &mut means[half - 1..], &mut dst[half..]);
    analyse_means_1d(last, means, &mut dst[..half]);
}

/// As [`line_forward`], in place; `details` holds half the samples' number.
#[inline(always)]
pub(super) fn line_forward_in_place<T: Real>(levels: u32, data: &mut [T], means: &mut [T], details: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return };
    let half = 1usize << last;
    analyse_level_1d(last, data, &mut means[half - 1..], details);
    data[half..].copy_from_slice(&details[..half]);
    analyse_means_1d(last, means, &mut data[..half]);
}

/// The inverse of [`line_forward`].
#[inline(always)]
pub(super) fn line_inverse<T: Real>(levels: u32, src: &[T], dst: &mut [T], means: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return dst.copy_from_slice(src) };
    let half = 1usize << last;
    synthesise_means_1d(last, &src[..half], means);
    synthesise_level_1d(last, &means[half - 1..], &src[half..], dst);
}

/// The inverse of [`line_forward_in_place`].
#[inline(always)]
pub(super) fn line_inverse_in_place<T: Real>(levels: u32, data: &mut [T], means: &mut [T], details: &mut [T]) {
    let Some(last) = levels.checked_sub(1) else { return };
    let half = 1usize << last;
    synthesise_means_1d(last, &data[..half], means);
    details[..half].copy_from_slice(&data[half..]);
    synthesise_level_1d(last, &means[half - 1..], details, data);
}

/// 1D transforms of all columns of `data` (2^levels rows, `width` long; destroyed) to `coefs`.
///
/// The mean of rows 2t and 2t + 1 overwrites row t, the details go where they belong.
#[inline(always)]
pub(crate) fn columns_forward<T: Real>(levels: u32, width: usize, data: &mut [T], coefs: &mut [T]) {
    for level in (0..levels).rev() {
        let w = 1usize << level;
        let scale = T::one() / root_power::<T>(level);
        for t in 0..w {
            let detail = &mut coefs[(w + t) * width..][..width];
            let (means, rows) = data.split_at_mut((2 * t).max(1) * width);
            if t == 0 {
                analyse_first_row(means, &rows[..width], detail, scale);
            } else {
                let (a, b) = rows[..2 * width].split_at(width);
                analyse_row_pair(a, b, &mut means[t * width..][..width], detail, scale);
            }
        }
    }
    coefs[..width].copy_from_slice(&data[..width]);
}

#[inline(always)]
fn analyse_row_pair<T: Real>(a: &[T], b: &[T], mean: &mut [T], detail: &mut [T], scale: T) {
    let width = mean.len();
    let (a, b, detail, half) = (&a[..width], &b[..width], &mut detail[..width], T::of(0.5));
    for x in 0..width {
        let (a, b) = (half * a[x], half * b[x]);
        mean[x] = a + b;
        detail[x] = scale * (a - b);
    }
}

/// Row 0 is both an operand and the place of the mean.
#[inline(always)]
fn analyse_first_row<T: Real>(mean: &mut [T], b: &[T], detail: &mut [T], scale: T) {
    let width = mean.len();
    let (b, detail, half) = (&b[..width], &mut detail[..width], T::of(0.5));
    for x in 0..width {
        let (a, b) = (half * mean[x], half * b[x]);
        mean[x] = a + b;
        detail[x] = scale * (a - b);
    }
}

/// The inverse of [`columns_forward`]: `coefs` to `data`.
#[inline(always)]
pub(crate) fn columns_inverse<T: Real>(levels: u32, width: usize, coefs: &[T], data: &mut [T]) {
    data[..width].copy_from_slice(&coefs[..width]);
    for level in 0..levels {
        let w = 1usize << level;
        let scale = root_power::<T>(level);
        for t in (0..w).rev() {
            let detail = &coefs[(w + t) * width..][..width];
            let (means, rows) = data.split_at_mut((2 * t).max(1) * width);
            if t == 0 {
                synthesise_first_row(means, &mut rows[..width], detail, scale);
            } else {
                let (a, b) = rows[..2 * width].split_at_mut(width);
                synthesise_row_pair(&means[t * width..][..width], detail, a, b, scale);
            }
        }
    }
}

#[inline(always)]
fn synthesise_row_pair<T: Real>(mean: &[T], detail: &[T], a: &mut [T], b: &mut [T], scale: T) {
    let width = mean.len();
    let (detail, a, b) = (&detail[..width], &mut a[..width], &mut b[..width]);
    for x in 0..width {
        let (m, d) = (mean[x], scale * detail[x]);
        (a[x], b[x]) = (m + d, m - d);
    }
}

#[inline(always)]
fn synthesise_first_row<T: Real>(mean: &mut [T], b: &mut [T], detail: &[T], scale: T) {
    let width = mean.len();
    let (detail, b) = (&detail[..width], &mut b[..width]);
    for x in 0..width {
        let (m, d) = (mean[x], scale * detail[x]);
        (mean[x], b[x]) = (m + d, m - d);
    }
}
