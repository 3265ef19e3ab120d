//! How long things take.

use std::time::Instant;

/// What a call returns, and the seconds that it took.
pub fn seconds<T>(call: impl FnOnce() -> T) -> (T, f64) {
    let started = Instant::now();
    let value = call();
    (value, started.elapsed().as_secs_f64())
}

/// Times of frames, or of rounds of anything that is done again and again.
#[derive(Debug, Clone, Default)]
pub struct Timer {
    milliseconds: Vec<f64>,
}

impl Timer {
    /// Times one frame.
    pub fn time<T>(&mut self, frame: impl FnOnce() -> T) -> T {
        let (value, seconds) = seconds(frame);
        self.milliseconds.push(seconds * 1e3);
        value
    }

    /// Milliseconds of the first frame; NaN before it.
    pub fn first(&self) -> f64 {
        self.milliseconds.first().copied().unwrap_or(f64::NAN)
    }

    /// Milliseconds of the shortest frame, which is nearest to what the work costs on a machine that is shared;
    /// infinite before the first.
    pub fn least(&self) -> f64 {
        self.milliseconds.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The median in milliseconds, of an even number the mean of the middle two; NaN before the first frame.
    pub fn median(&self) -> f64 {
        let mut sorted = self.milliseconds.clone();
        sorted.sort_by(f64::total_cmp);
        match sorted.len() {
            0 => f64::NAN,
            n if n % 2 == 1 => sorted[n / 2],
            n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_odd_even_and_no_frames() {
        let of = |times: &[f64]| Timer { milliseconds: times.to_vec() };
        assert_eq!([of(&[3.0, 1.0, 2.0]).median(), of(&[4.0, 1.0, 3.0, 2.0]).median()], [2.0, 2.5]);
        assert_eq!((of(&[3.0, 1.0]).first(), of(&[3.0, 1.0, 2.0]).least()), (3.0, 1.0));
        assert!(of(&[]).median().is_nan() && of(&[]).first().is_nan());
    }
}
