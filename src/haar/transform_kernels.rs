//! The level passes under every transform. Everything here is `#[inline(always)]`, so that it is compiled for the vector
//! unit of the caller, which `pulp` picks once for a whole transform or batch.
//!
//! Derivation, 1D. With a, b the means of the two halves of a cell of level l, the inner product with
//! 2^{l/2} ψ(2^l v − t) is 2^{l/2}·2^{−l}·(a − b)/2 = 2^{−l/2} (a − b)/2, and the cell's mean is (a + b)/2.
//! 2D nonstandard, with quarters a b / c d: mean (a + b + c + d)/4; horizontal, vertical and diagonal details are
//! 2^l·4^{−l}/4 = 2^{−l}/4 times (a − b + c − d), (a + b − c − d), (a − b − c + d).
//!
//! The halvings come first: no sum of finite samples overflows, and the power of two costs no accuracy.

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

/// Two rows of samples → one row of means and of each detail.
#[inline(always)]
fn analyse_rows<T: Real>(
    [top, bottom]: [&[T]; 2],
    mean: &mut [T],
    [horizontal, vertical, diagonal]: [&mut [T]; 3],
    scale: T,
) {
    let w = mean.len();
    let (top, bottom) = (&top.as_chunks::<2>().0[..w], &bottom.as_chunks::<2>().0[..w]);
    let (horizontal, vertical, diagonal) = (&mut horizontal[..w], &mut vertical[..w], &mut diagonal[..w]);
    let quarter = T::of(0.25);
    for x in 0..w {
        let ([a, b], [c, d]) = (top[x], bottom[x]);
        let (a, b, c, d) = (quarter * a, quarter * b, quarter * c, quarter * d);
        let (sum_left, sum_right, step_left, step_right) = (a + c, b + d, a - c, b - d);
        mean[x] = sum_left + sum_right;
        horizontal[x] = scale * (sum_left - sum_right);
        vertical[x] = scale * (step_left + step_right);
        diagonal[x] = scale * (step_left - step_right);
    }
}

/// One row of means and of each detail → two rows of samples.
#[inline(always)]
fn synthesise_rows<T: Real>(
    mean: &[T],
    [horizontal, vertical, diagonal]: [&[T]; 3],
    [top, bottom]: [&mut [T]; 2],
    scale: T,
) {
    let w = mean.len();
    let (top, bottom) = (&mut top.as_chunks_mut::<2>().0[..w], &mut bottom.as_chunks_mut::<2>().0[..w]);
    let (horizontal, vertical, diagonal) = (&horizontal[..w], &vertical[..w], &diagonal[..w]);
    for x in 0..w {
        let (h, v, d) = (scale * horizontal[x], scale * vertical[x], scale * diagonal[x]);
        // m ± h are the means of the left and right halves, v ± d half their vertical steps: bounded by the samples.
        let (left, right, step_left, step_right) = (mean[x] + h, mean[x] - h, v + d, v - d);
        top[x] = [left + step_left, right + step_right];
        bottom[x] = [left - step_left, right - step_right];
    }
}

/// Means of level l + 1 (`fine`, side 2w) → means (side w) and the three detail blocks of level l, w = 2^l.
#[inline(always)]
fn analyse_level<T: Real>(level: u32, fine: &[T], mean: &mut [T], details: &mut [T]) {
    let w = 1usize << level;
    let scale = T::one() / power::<T>(level);
    let (horizontal, rest) = details.split_at_mut(w * w);
    let (vertical, diagonal) = rest.split_at_mut(w * w);
    let rows = fine.chunks_exact(4 * w).zip(mean.chunks_exact_mut(w));
    let details = horizontal.chunks_exact_mut(w).zip(vertical.chunks_exact_mut(w)).zip(diagonal.chunks_exact_mut(w));
    for ((fine, mean), ((h, v), d)) in rows.zip(details) {
        let (top, bottom) = fine.split_at(2 * w);
        analyse_rows([top, bottom], mean, [h, v, d], scale);
    }
}

/// The inverse of [`analyse_level`].
#[inline(always)]
fn synthesise_level<T: Real>(level: u32, mean: &[T], details: &[T], fine: &mut [T]) {
    let w = 1usize << level;
    let scale = power::<T>(level);
    let (horizontal, rest) = details.split_at(w * w);
    let (vertical, diagonal) = rest.split_at(w * w);
    let rows = fine.chunks_exact_mut(4 * w).zip(mean.chunks_exact(w));
    let details = horizontal.chunks_exact(w).zip(vertical.chunks_exact(w)).zip(diagonal.chunks_exact(w));
    for ((fine, mean), ((h, v), d)) in rows.zip(details) {
        let (top, bottom) = fine.split_at_mut(2 * w);
        synthesise_rows(mean, [h, v, d], [top, bottom], scale);
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
pub(super) fn nonstandard_forward<T: Real>(levels: u32, src: &[T], dst: &mut [T], pyramid: &mut [T]) {
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
    let quarter = T::of(0.25);
    for level in (0..levels).rev() {
        let w = 1usize << level;
        let (coarse, fine) = pyramid.split_at_mut(pyramid_offset(level + 1));
        let coarse = coarse[pyramid_offset(level)..].chunks_exact_mut(w);
        for (mean, fine) in coarse.zip(fine.chunks_exact(4 * w)) {
            let (top, bottom) = fine.split_at(2 * w);
            let (top, bottom) = (&top.as_chunks::<2>().0[..w], &bottom.as_chunks::<2>().0[..w]);
            for x in 0..w {
                let ([a, b], [c, d]) = (top[x], bottom[x]);
                mean[x] = (quarter * a + quarter * c) + (quarter * b + quarter * d);
            }
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
        fine[t] = [mean[t] + d, mean[t] - d];
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

/// 1D transforms of all columns of rows `width` long, 2^levels rows, in place; `details` holds as much as `data`.
///
/// The mean of rows 2t and 2t + 1 overwrites row t, the details wait in `details` until no mean is left to read.
#[inline(always)]
pub(super) fn columns_forward<T: Real>(levels: u32, width: usize, data: &mut [T], details: &mut [T]) {
    let half = T::of(0.5);
    for level in (0..levels).rev() {
        let w = 1usize << level;
        let scale = T::one() / root_power::<T>(level);
        for (t, detail) in details[w * width..2 * w * width].chunks_exact_mut(width).enumerate() {
            let (means, rows) = data.split_at_mut((2 * t).max(1) * width);
            if t == 0 {
                // Row 0 is both an operand and the place of the mean.
                let (mean, b) = (&mut means[..width], &rows[..width]);
                for x in 0..width {
                    let (a, b) = (half * mean[x], half * b[x]);
                    mean[x] = a + b;
                    detail[x] = scale * (a - b);
                }
            } else {
                let (mean, a, b) = (&mut means[t * width..][..width], &rows[..width], &rows[width..2 * width]);
                for x in 0..width {
                    let (a, b) = (half * a[x], half * b[x]);
                    mean[x] = a + b;
                    detail[x] = scale * (a - b);
                }
            }
        }
    }
    data[width..].copy_from_slice(&details[width..]);
}

/// The inverse of [`columns_forward`].
#[inline(always)]
pub(super) fn columns_inverse<T: Real>(levels: u32, width: usize, data: &mut [T], details: &mut [T]) {
    details[width..].copy_from_slice(&data[width..]);
    for level in 0..levels {
        let w = 1usize << level;
        let scale = root_power::<T>(level);
        for (t, detail) in details[w * width..2 * w * width].chunks_exact(width).enumerate().rev() {
            let (means, rows) = data.split_at_mut((2 * t).max(1) * width);
            if t == 0 {
                let (mean, b) = (&mut means[..width], &mut rows[..width]);
                for x in 0..width {
                    let (m, d) = (mean[x], scale * detail[x]);
                    (mean[x], b[x]) = (m + d, m - d);
                }
            } else {
                let mean = &means[t * width..][..width];
                let (a, b) = rows[..2 * width].split_at_mut(width);
                for x in 0..width {
                    let (m, d) = (mean[x], scale * detail[x]);
                    (a[x], b[x]) = (m + d, m - d);
                }
            }
        }
    }
}
