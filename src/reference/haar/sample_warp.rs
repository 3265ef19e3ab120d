//! Sample warping from the pixels themselves.

/// The sample of a uniform number and its density, by the inverse of the cumulated samples.
///
/// Samples are not negative, and not all are zero.
pub fn warp_1d(samples: &[f64], uniform: f64) -> (f64, f64) {
    let (total, n): (f64, f64) = (samples.iter().sum(), samples.len() as f64);
    let mut before = 0.0;
    let last = samples.iter().rposition(|&s| s > 0.0).expect("a sample above 0");
    for (i, &sample) in samples.iter().enumerate() {
        let share = sample / total;
        if uniform < before + share || i == last {
            return ((i as f64 + (uniform - before) / share) / n, share * n);
        }
        before += share;
    }
    unreachable!("the last sample above 0 takes what is left")
}

/// The sample [x, y] of two uniform numbers and its density: y by the sums of rows, then x by the row that it lies in.
pub fn warp_standard(pixels: &[f64], width: usize, height: usize, [u, v]: [f64; 2]) -> ([f64; 2], f64) {
    let rows: Vec<f64> = pixels.chunks(width).map(|row| row.iter().sum()).collect();
    let (y, density_y) = warp_1d(&rows, v);
    let row = ((y * height as f64) as usize).min(height - 1);
    let (x, density_x) = warp_1d(&pixels[row * width..][..width], u);
    ([x, y], density_x * density_y)
}

/// The sample [x, y] of two uniform numbers and its density, square by square: the upper or the lower half, then the
/// left or the right, by sums of the pixels of each.
pub fn warp_nonstandard(pixels: &[f64], side: usize, uniform: [f64; 2]) -> ([f64; 2], f64) {
    let sum = |x: usize, y: usize, w: usize, h: usize| -> f64 {
        (y..y + h).map(|y| pixels[y * side + x..][..w].iter().sum::<f64>()).sum()
    };
    let total = sum(0, 0, side, side);
    let ([mut u, mut v], [mut x, mut y], mut size) = (uniform, [0, 0], side);
    while size > 1 {
        let half = size / 2;
        let upper = sum(x, y, size, half) / sum(x, y, size, size);
        (v, y) = if v < upper { (v / upper, y) } else { ((v - upper) / (1.0 - upper), y + half) };
        let left = sum(x, y, half, half) / sum(x, y, size, half);
        (u, x) = if u < left { (u / left, x) } else { ((u - left) / (1.0 - left), x + half) };
        size = half;
    }
    let n = side as f64;
    ([(x as f64 + u) / n, (y as f64 + v) / n], pixels[y * side + x] / total * n * n)
}
