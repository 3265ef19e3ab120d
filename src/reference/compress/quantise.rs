//! binary16 by its definition; bytes by theirs.

/// The value of a finite binary16: (−1)^s · 2^{e−15} · 1.f, or (−1)^s · 2^{−14} · 0.f if e = 0.
pub fn half_value(bits: u16) -> f64 {
    let (s, e, f) = (bits >> 15, i32::from(bits >> 10) & 31, f64::from(bits & 1023) / 1024.0);
    let magnitude = if e == 0 { f * 2f64.powi(-14) } else { (1.0 + f) * 2f64.powi(e - 15) };
    if s == 1 { -magnitude } else { magnitude }
}

/// The finite binary16 nearest to a number: all of them are tried; of equals the one whose last bit is 0. `None` from
/// 65520 on (beyond the middle between the largest one and 2^16), and for NaN.
pub fn nearest_half(x: f64) -> Option<u16> {
    if !(x.abs() < 65520.0) {
        return None;
    }
    let sign = u16::from(x.is_sign_negative()) << 15;
    let distance = |bits: &u16| (half_value(*bits) - x.abs()).abs();
    let nearest = (0..0x7c00u16).min_by(|a, b| distance(a).total_cmp(&distance(b)).then((a & 1).cmp(&(b & 1))))?;
    Some(sign | nearest)
}

/// min + (max − min)/255 · q for the q of 0…255 that is nearest, of all numbers with the same block; half a step at
/// most from x.
pub fn bytes(values: &[f64], blocks: &[usize]) -> Vec<f64> {
    let one = |(&x, &block): (&f64, &usize)| {
        let mates = || values.iter().zip(blocks).filter(|mate| *mate.1 == block).map(|mate| *mate.0);
        let (min, max) = (mates().fold(f64::INFINITY, f64::min), mates().fold(f64::NEG_INFINITY, f64::max));
        let candidates = (0..=255).map(|q| min + (max - min) / 255.0 * f64::from(q));
        candidates.min_by(|a, b| (a - x).abs().total_cmp(&(b - x).abs())).unwrap_or(x)
    };
    values.iter().zip(blocks).map(one).collect()
}
