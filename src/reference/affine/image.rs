//! Pictures by their definition: a basis function at a time, a pixel at a time, a tap at a time.

/// The value of function `k` of the 1D Haar basis at v in [0, 1).
fn haar(k: usize, v: f64) -> f64 {
    if k == 0 {
        return 1.0;
    }
    let level = k.ilog2() as i32;
    let place = v * 2f64.powi(level) - (k as f64 - 2f64.powi(level));
    let sign = match place {
        p if (0.0..0.5).contains(&p) => 1.0,
        p if (0.5..1.0).contains(&p) => -1.0,
        _ => 0.0,
    };
    sign * 2f64.powf(0.5 * f64::from(level))
}

/// The pixels, row-major, of a grid of `across` × `down` from its terms in the standard basis, (k_y · across + k_x,
/// value): the sum of their functions at the pixels' centres.
pub fn decode_standard([across, down]: [usize; 2], terms: impl IntoIterator<Item = (usize, f64)>) -> Vec<f64> {
    let mut pixels = vec![0.0; across * down];
    for (k, value) in terms {
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let [x, y] = [(i % across, across), (i / across, down)].map(|(i, side)| (i as f64 + 0.5) / side as f64);
            *pixel += value * haar(k % across, x) * haar(k / across, y);
        }
    }
    pixels
}

/// Σ t_m s_n f(x − m, y − n) of an image that is 0 beyond its border, with the taps (m, t_m) along x and (n, s_n) along
/// y.
///
/// # Panics
/// If the image is not of whole rows of `width`.
#[track_caller]
pub fn convolve_2d(image: &[f64], width: usize, [across, down]: [&[(i64, f64)]; 2]) -> Vec<f64> {
    assert!(width > 0 && image.len() % width == 0, "whole rows of {width} pixels");
    let height = image.len() / width;
    let at = |x: i64, y: i64| {
        let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
        if inside { image[y as usize * width + x as usize] } else { 0.0 }
    };
    let pixel = |i: usize| {
        let (x, y) = ((i % width) as i64, (i / width) as i64);
        let row = |n: i64| across.iter().map(|&(m, t)| t * at(x - m, y - n)).sum::<f64>();
        down.iter().map(|&(n, s)| s * row(n)).sum()
    };
    (0..image.len()).map(pixel).collect()
}

/// The mean over each sample of ∫ g(y) f(x − y) dy, y in samples, of a signal that is 0 beyond its ends: a sum of
/// `steps` translations by numbers of samples between −reach and reach, each an exact overlap.
///
/// Good to O(1/steps²) where g is smooth between the middles of its steps.
pub fn convolve_density(samples: &[f64], density: impl Fn(f64) -> f64, reach: f64, steps: usize) -> Vec<f64> {
    let step = 2.0 * reach / steps as f64;
    let mut out = vec![0.0; samples.len()];
    for k in 0..steps {
        let y = -reach + (k as f64 + 0.5) * step;
        let weight = density(y) * step;
        for (i, f) in samples.iter().enumerate() {
            for (p, out) in out.iter_mut().enumerate() {
                // Sample i, moved by y, and sample p.
                let overlap = (1.0 - (i as f64 + y - p as f64).abs()).max(0.0);
                *out += weight * overlap * f;
            }
        }
    }
    out
}
