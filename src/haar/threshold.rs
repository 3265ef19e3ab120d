//! A threshold for coefficients, from the error that may be made.

/// A threshold below which the coefficients hold at most `tolerance`² of the energy Σ x²: dropping what is smaller
/// makes a relative L2 error of at most `tolerance`.
///
/// The energy is binned by the top bits of the magnitude (8 bins an octave), so that no sorting is needed; the
/// threshold is the lower edge of the first bin that would exceed the budget. Coefficients must be finite.
///
/// # Example
/// ```
/// use haarmonic::haar::threshold_for_error;
/// let threshold = threshold_for_error(&[10.0, 0.5, 5.0, 0.25], 0.1);
/// assert!(threshold > 0.5 && threshold <= 5.0);
/// ```
pub fn threshold_for_error(coefs: &[f32], tolerance: f32) -> f32 {
    const SHIFT: u32 = 20;
    let mut bins = vec![0.0f64; 1 << (31 - SHIFT)];
    for x in coefs {
        bins[(x.abs().to_bits() >> SHIFT) as usize] += f64::from(*x) * f64::from(*x);
    }
    let budget = bins.iter().sum::<f64>() * f64::from(tolerance).powi(2);
    let mut dropped = 0.0;
    for (bin, energy) in bins.iter().enumerate() {
        dropped += energy;
        if dropped > budget {
            return f32::from_bits((bin as u32) << SHIFT);
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_keeps_the_energy_it_promises() {
        let coefs: Vec<f32> = (0..4096).map(|i| ((i * 37 % 1009) as f32 / 300.0).powi(5) * 1e-3).collect();
        let total: f64 = coefs.iter().map(|x| f64::from(*x).powi(2)).sum();
        for tolerance in [0.0f32, 1e-4, 0.01, 0.1, 0.5] {
            let threshold = threshold_for_error(&coefs, tolerance);
            let dropped: f64 = coefs.iter().filter(|x| x.abs() < threshold).map(|x| f64::from(*x).powi(2)).sum();
            let share = (dropped / total).sqrt();
            assert!(share <= f64::from(tolerance), "{share} dropped at {tolerance}");
            // The bins are an eighth of an octave wide: the budget is nearly used up.
            assert!(tolerance == 0.0 || share > 0.5 * f64::from(tolerance), "only {share} dropped at {tolerance}");
        }
        assert_eq!(threshold_for_error(&[0.0; 8], 0.1), 0.0);
    }
}
