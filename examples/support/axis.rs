//! Axes: what they show, how they are divided, which numbers stand on them.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Decades. Values that are not positive are left out.
    Log10,
    /// Octaves. Values that are not positive are left out.
    Log2,
}

/// One axis.
#[derive(Debug, Clone)]
pub struct Axis {
    /// What it shows, with its unit.
    pub label: String,
    pub scale: Scale,
    /// From where to where; `None` for what the points need.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// An axis that fits its points.
    pub fn new(label: &str, scale: Scale) -> Self {
        Self { label: label.to_owned(), scale, range: None }
    }

    /// An axis from `low` to `high`.
    pub fn between(label: &str, scale: Scale, low: f64, high: f64) -> Self {
        Self { range: Some([low, high]), ..Self::new(label, scale) }
    }
}

/// Values along an axis and where they lie on it.
#[derive(Debug, Clone)]
pub struct Ruler {
    scale: Scale,
    /// About how many numbers.
    count: usize,
    /// The ends, scaled.
    pub ends: [f64; 2],
}

impl Ruler {
    /// The ruler of an axis with these points, and with about `count` numbers.
    pub fn new(axis: &Axis, points: impl Iterator<Item = f64>, count: usize) -> Self {
        let mut ruler = Self { scale: axis.scale, count: count.max(2), ends: [0.0, 1.0] };
        let mut ends = match axis.range {
            Some(range) => range.map(|x| ruler.scaled(x)),
            None => {
                let scaled = points.map(|x| ruler.scaled(x)).filter(|x| x.is_finite());
                let [low, high] =
                    scaled.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
                let margin = 0.06 * (high - low);
                [low - margin, high + margin]
            }
        };
        if !(ends[0] < ends[1]) || !(ends[1] - ends[0]).is_finite() {
            let middle = if ends[0].is_finite() { ends[0] } else { 0.0 };
            ends = [middle - 1.0, middle + 1.0];
        }
        ruler.ends = ends;
        ruler
    }

    /// A value, or its logarithm.
    pub fn scaled(&self, x: f64) -> f64 {
        match self.scale {
            Scale::Linear => x,
            Scale::Log10 => x.log10(),
            Scale::Log2 => x.log2(),
        }
    }

    /// The inverse of [`Ruler::scaled`].
    pub fn unscaled(&self, x: f64) -> f64 {
        match self.scale {
            Scale::Linear => x,
            Scale::Log10 => 10f64.powf(x),
            Scale::Log2 => x.exp2(),
        }
    }

    /// The value at a share of the length.
    pub fn value(&self, share: f64) -> f64 {
        self.unscaled(self.ends[0] + share * (self.ends[1] - self.ends[0]))
    }

    /// Whether a scaled value lies on the axis.
    pub fn contains(&self, scaled: f64) -> bool {
        let slack = 1e-9 * (self.ends[1] - self.ends[0]);
        (self.ends[0] - slack..=self.ends[1] + slack).contains(&scaled)
    }

    fn multiples(&self, step: f64) -> Vec<f64> {
        let first = (self.ends[0] / step - 1e-9).ceil();
        let count = ((self.ends[1] / step + 1e-9).floor() - first).clamp(-1.0, 200.0) as i64;
        (0..=count).map(|k| (first + k as f64) * step).collect()
    }

    /// `mantissas` of every decade, scaled.
    fn decades(&self, mantissas: &[f64]) -> Vec<f64> {
        let powers = self.ends[0].floor() as i32..=self.ends[1].ceil() as i32;
        let all = powers.flat_map(|e| mantissas.iter().map(move |m| m.log10() + f64::from(e)));
        all.filter(|&x| self.contains(x)).collect()
    }

    /// Scaled places of round values.
    fn scaled_ticks(&self) -> Vec<f64> {
        let (span, count) = (self.ends[1] - self.ends[0], self.count as f64);
        match self.scale {
            Scale::Log2 => self.multiples((span / count).ceil().max(1.0)),
            Scale::Log10 if span >= 0.6 * count => self.multiples((span / count).ceil()),
            Scale::Log10 => {
                let choices: [&[f64]; 4] =
                    [&[1.0], &[1.0, 3.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0]];
                let fitting = choices.iter().map(|m| self.decades(m)).filter(|t| t.len() as f64 <= count + 1.0);
                fitting.max_by_key(Vec::len).unwrap_or_default()
            }
            Scale::Linear => {
                let power = 10f64.powf((span / count).log10().floor());
                let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s * count >= span);
                self.multiples(step.unwrap_or(10.0 * power))
            }
        }
    }

    /// Round values that get a number.
    pub fn ticks(&self) -> Vec<f64> {
        self.scaled_ticks().into_iter().map(|x| self.unscaled(x)).collect()
    }

    /// Scaled places of the finer mesh.
    fn minor_ticks(&self) -> Vec<f64> {
        match self.scale {
            Scale::Log10 if self.ends[1] - self.ends[0] < 6.0 => {
                self.decades(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
            }
            Scale::Log2 => self.multiples(1.0),
            _ => Vec::new(),
        }
    }
}

impl Ranged for Ruler {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, x: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (self.scaled(*x) - self.ends[0]) / (self.ends[1] - self.ends[0]);
        from + (share * f64::from(to - from)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            self.minor_ticks().into_iter().map(|x| self.unscaled(x)).collect()
        } else {
            self.ticks()
        }
    }

    fn range(&self) -> Range<f64> {
        self.unscaled(self.ends[0])..self.unscaled(self.ends[1])
    }
}

impl ValueFormatter<f64> for Ruler {
    fn format(x: &f64) -> String {
        number(*x)
    }
}

/// A number as people write it: 0.25, 1000, 20 000, 3·10⁶.
pub fn number(x: f64) -> String {
    if x.abs() < 1e-12 {
        return "0".to_owned();
    }
    let sign = if x < 0.0 { "\u{2212}" } else { "" };
    let power = (x.abs().log10() + 1e-9).floor() as i32;
    if !(-4..6).contains(&power) {
        let mantissa = plain(x.abs() / 10f64.powi(power), 2);
        let digits = power.to_string().chars().map(superscript).collect::<String>();
        return if mantissa == "1" { format!("{sign}10{digits}") } else { format!("{sign}{mantissa}·10{digits}") };
    }
    let text = plain(x.abs(), (3 - power).clamp(0, 6) as usize);
    match text.split_at_checked(text.len().saturating_sub(3)) {
        Some((thousands, rest)) if x.abs() >= 1e4 => format!("{sign}{thousands}\u{a0}{rest}"),
        _ => sign.to_owned() + &text,
    }
}

fn plain(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_people_write_them() {
        let cases = [
            (0.0, "0"),
            (-0.25, "−0.25"),
            (1000.0, "1000"),
            (20_000.0, "20\u{a0}000"),
            (1e6, "10⁶"),
            (2.5e-7, "2.5·10⁻⁷"),
            (0.001, "0.001"),
            (9.999_999_999_9, "10"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text, "{x}");
        }
    }

    #[test]
    fn ticks_are_round_and_on_the_axis() {
        let ticks = |scale, low, high, count| {
            Ruler::new(&Axis::between("", scale, low, high), std::iter::empty(), count)
                .ticks()
                .into_iter()
                .map(number)
                .collect::<Vec<_>>()
        };
        assert_eq!(ticks(Scale::Linear, -0.1, 1.0, 6), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(Scale::Log10, 0.01, 100.0, 5), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(ticks(Scale::Log10, 0.9, 11.0, 4), ["1", "2", "5", "10"]);
        assert_eq!(ticks(Scale::Log2, 3.0, 40.0, 8), ["4", "8", "16", "32"]);
    }

    #[test]
    fn rulers_without_points_have_a_length() {
        for points in [vec![], vec![f64::NAN], vec![2.0], vec![-1.0, 0.0]] {
            let ruler = Ruler::new(&Axis::new("", Scale::Log10), points.into_iter(), 5);
            assert!(ruler.ends[0] < ruler.ends[1] && ruler.ends.iter().all(|e| e.is_finite()));
        }
    }
}
