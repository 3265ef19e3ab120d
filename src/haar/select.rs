//! Which coefficients to keep: non-linear approximation.

use std::fmt;
use std::str::FromStr;

use super::{Index2d, Pyramid, SparseVector};
use crate::numeric::SquareSum;
use crate::{Error, Real, Result};

/// What a term is worth: the key κ_i by which terms are ranked, largest first.
///
/// A detail of level l has amplitude 2^l on a support of area 4^{−l}: ∫Ψ² = 1, ∫|Ψ| = 2^{−l}. With f the full and f̃
/// the kept function:
///
/// | weighting | κ_i | what the choice of the n largest κ does |
/// |---|---|---|
/// | `Magnitude` | \|c_i\| | minimises ‖f − f̃‖₂, by Parseval [Ng 2003, unweighted] |
/// | `Integral` | \|c_i\|·∫\|Ψ_i\| = \|c_i\|·2^{−l} | minimises the bound Σ_dropped κ_i ≥ \|∫(f − f̃) g\| over all \|g\| ≤ 1 |
/// | `IntegralOver` | \|c_i\|·∫\|Ψ_i\| dμ | the same for integrals against a measure μ, such as solid angle |
/// | `Area` | \|c_i\|·area = \|c_i\|·4^{−l} | leans further to coarse terms [Ng 2003, area-weighted] |
/// | `Transport` | \|c_i\|·w_i, w_i = √(Σ_v T_vi²) | minimises Σ_v error_v² where the dropped terms' errors are uncorrelated [Ng 2003, transport-weighted] |
///
/// Light that is looked at wants `Magnitude`. Light that is integrated against visibility and reflection wants
/// `Integral`: a magnitude choice spends its terms on the rim of a small bright source, whose fine details hardly move
/// any integral. `Transport` is the best where a transport matrix is at hand, and the only one that has seen the scene.
#[derive(Debug, Clone, Copy, Default)]
pub enum Weighting<'a, T> {
    /// |c|.
    Magnitude,
    /// |c| times the area of the support, 4^{−l}.
    Area,
    /// |c| times ∫|Ψ| = 2^{−l}.
    #[default]
    Integral,
    /// |c| times ∫|Ψ| dμ, the measure given by the mean pyramid of its density (any constant factor does).
    IntegralOver(&'a Pyramid<T>),
    /// |c| times a weight of its own: the norm of the transport matrix's column, [`transport_weights`].
    Transport(&'a [T]),
}

/// How many terms to keep.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(try_from = "Unchecked"))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Keep {
    /// This number of terms; all of them, if there are fewer.
    Terms(usize),
    /// This part of the vector's length, in [0, 1], rounded up to whole terms.
    Fraction(f64),
}

/// What a stored choice says of itself.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Keep")]
enum Unchecked {
    Terms(usize),
    Fraction(f64),
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for Keep {
    type Error = Error;

    fn try_from(keep: Unchecked) -> Result<Self> {
        let keep = match keep {
            Unchecked::Terms(n) => Self::Terms(n),
            Unchecked::Fraction(f) => Self::Fraction(f),
        };
        keep.check().map(|()| keep)
    }
}

impl Keep {
    /// How many terms of `len` are kept, before scaling functions that are always kept: at most `len`, and all of them
    /// for a fraction above 1, none for one that is negative or NaN (which what takes a `Keep` refuses).
    pub fn of(self, len: usize) -> usize {
        match self {
            Self::Terms(n) => n.min(len),
            // The product's own rounding must not cost a term: 0.07·100 is 7.000000000000001.
            Self::Fraction(f) => ((f * len as f64 * (1.0 - 2.0 * f64::EPSILON)).ceil() as usize).min(len),
        }
    }

    /// # Errors
    /// [`Error::OutOfRange`] for a fraction outside [0, 1].
    pub(crate) fn check(self) -> Result<()> {
        match self {
            Self::Fraction(got) if !(0.0..=1.0).contains(&got) => {
                Err(Error::OutOfRange { what: "fraction of terms", got, allowed: "in [0, 1]" })
            }
            _ => Ok(()),
        }
    }
}

/// `all`, a count (`246`), or a percentage (`1%`).
impl FromStr for Keep {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parsed = match text.strip_suffix('%') {
            _ if text == "all" => Some(Self::Fraction(1.0)),
            Some(percent) => {
                percent.parse::<f64>().ok().filter(|p| *p > 0.0 && *p <= 100.0).map(|p| Self::Fraction(p / 100.0))
            }
            None => text.parse().ok().filter(|n| *n > 0).map(Self::Terms),
        };
        parsed.ok_or_else(|| Error::Syntax {
            what: "number of terms",
            given: text.to_owned(),
            reason: "give `all`, a count such as 246, or a percentage such as 1%".to_owned(),
        })
    }
}

impl fmt::Display for Keep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Terms(n) => write!(f, "{n}"),
            Self::Fraction(1.0) => f.write_str("all"),
            Self::Fraction(x) => write!(f, "{}%", x * 100.0),
        }
    }
}

/// Whether scaling functions (the first coefficient of each block) must earn their place.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ScalingTerms {
    /// They compete like any other term.
    Compete,
    /// They are kept first, even where they are 0 or outnumber the terms asked for; the mean is then exact.
    #[default]
    Always,
}

/// How the channels of one coefficient make one magnitude |c|: the channels share one set of indices.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ChannelRule {
    /// √(Σ c²) over the channels: the choice then minimises the summed squared error of all of them.
    #[default]
    Norm,
    /// |0.2126 r + 0.7152 g + 0.0722 b|, linear Rec. 709, three channels: spends nothing on edges between colours of one
    /// luminance, so colours bleed there.
    Luminance,
}

/// A rule for choosing terms.
///
/// Without settings: [`Weighting::Integral`], [`ScalingTerms::Always`], [`ChannelRule::Norm`], one block. Of equal keys
/// the lower index is kept; terms whose key is 0 never are (but see [`ScalingTerms`]): the result is deterministic and
/// may have fewer terms than asked for.
///
/// Cost: linear in the length (a selection, not a sort), plus sorting the kept indices.
///
/// # Example
/// ```
/// # fn main() -> Result<(), haarmonic::Error> {
/// use haarmonic::haar::{Keep, Selection, Weighting};
/// let coefs = [1.0, 0.5, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.9];
/// let by_magnitude = Selection::new(Keep::Terms(2)).with_weighting(Weighting::Magnitude).apply(&coefs)?;
/// assert_eq!(by_magnitude.indices(), [0, 15]);
/// let by_integral = Selection::new(Keep::Terms(3)).apply(&coefs)?; // 1.5 = 3·½ and 1.95 = 3.9·½ beat 0.5
/// assert_eq!(by_integral.indices(), [0, 4, 15]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Selection<'a, T> {
    keep: Keep,
    weighting: Weighting<'a, T>,
    scaling: ScalingTerms,
    channels: ChannelRule,
    block: Option<usize>,
}

/// Memory that [`Selection::indices`] uses again: nothing is allocated once it has grown.
#[derive(Debug, Clone, Default)]
pub struct SelectionScratch {
    keys: Vec<f64>,
    bins: Vec<u32>,
    ranked: Vec<(f64, u32)>,
    indices: Vec<u32>,
}

impl SelectionScratch {
    /// The indices that the last selection kept, ascending.
    pub fn kept(&self) -> &[u32] {
        &self.indices
    }
}

impl<'a, T: Real> Selection<'a, T> {
    /// A rule that keeps `keep` of the terms, otherwise with the defaults of [`Selection`].
    pub fn new(keep: Keep) -> Self {
        let (scaling, channels) = (ScalingTerms::default(), ChannelRule::default());
        Self { keep, weighting: Weighting::default(), scaling, channels, block: None }
    }

    /// The same rule with another weighting, the key by which terms are ranked.
    #[must_use]
    pub fn with_weighting(mut self, weighting: Weighting<'a, T>) -> Self {
        self.weighting = weighting;
        self
    }

    /// The same rule with another treatment of scaling functions.
    #[must_use]
    pub fn with_scaling_terms(mut self, scaling: ScalingTerms) -> Self {
        self.scaling = scaling;
        self
    }

    /// The same rule with another way to join the channels of a coefficient.
    #[must_use]
    pub fn with_channels(mut self, channels: ChannelRule) -> Self {
        self.channels = channels;
        self
    }

    /// The vector is a row of blocks of `len` coefficients, each a basis of its own (a cube map: six faces), which
    /// compete with each other for the same terms.
    #[must_use]
    pub fn with_blocks_of(mut self, len: usize) -> Self {
        self.block = Some(len);
        self
    }

    /// The kept indices, ascending, of coefficients in one or more channels.
    ///
    /// # Errors
    /// [`Error::Empty`] without channels; [`Error::Length`] if channels differ in length, the length is not a multiple
    /// of the block, or a weighting's weights do not fit; [`Error::NotFinite`] where a coefficient or weight is NaN or
    /// infinite; [`Error::OutOfRange`] for a fraction outside [0, 1], a negative weight, a length above `u32::MAX`, an
    /// empty block, blocks that are no square images (4^k coefficients) under a weighting by area or integral, or
    /// [`ChannelRule::Luminance`] of other than three channels.
    pub fn indices<'w>(&self, channels: &[&[T]], work: &'w mut SelectionScratch) -> Result<&'w [u32]> {
        let len = self.check(channels)?;
        let block = self.block.unwrap_or(len);
        let mut terms = self.terms(len)?;
        if self.scaling == ScalingTerms::Always && len > 0 {
            terms = terms.max(len / block);
        }
        self.rank(channels, block, &mut work.keys)?;
        let floor = floor_key(&work.keys, terms, &mut work.bins);
        work.ranked.clear();
        for (block, keys) in work.keys.chunks(RUN).enumerate() {
            // Most runs of keys hold none that is kept: look at a run without branches first.
            if keys.iter().fold(false, |any, &k| any | (k >= floor)) {
                let numbered = (block * RUN..).zip(keys).filter(|&(_, &k)| k >= floor && k > 0.0);
                work.ranked.extend(numbered.map(|(i, &k)| (k, i as u32)));
            }
        }
        if terms < work.ranked.len() {
            // Keys are never NaN; index breaks ties, so this is a total order.
            work.ranked.select_nth_unstable_by(terms, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            work.ranked.truncate(terms);
        }
        work.indices.clear();
        work.indices.extend(work.ranked.iter().map(|&(_, i)| i));
        work.indices.sort_unstable();
        Ok(&work.indices)
    }

    /// The key of every coefficient; infinite for scaling functions that are always kept.
    fn rank(&self, channels: &[&[T]], block: usize, keys: &mut Vec<f64>) -> Result<()> {
        keys.clear();
        match (self.channels, channels) {
            (ChannelRule::Luminance, [r, g, b]) => {
                keys.extend(r.iter().zip(*g).zip(*b).map(|((r, g), b)| {
                    (0.2126 * r.widen() + 0.7152 * g.widen() + 0.0722 * b.widen()).abs().min(f64::MAX)
                }))
            }
            (_, [only]) => keys.extend(only.iter().map(|c| c.widen().abs())),
            // Squares of f32 neither overflow nor underflow in f64; those of f64 do.
            (_, [first, rest @ ..]) if size_of::<T>() == size_of::<f32>() => {
                keys.extend(first.iter().map(|c| c.widen() * c.widen()));
                for channel in rest {
                    keys.iter_mut().zip(*channel).for_each(|(k, c)| *k += c.widen() * c.widen());
                }
                keys.iter_mut().for_each(|k| *k = k.sqrt());
            }
            _ => keys.extend(
                (0..channels.first().map_or(0, |c| c.len()))
                    .map(|i| channels.iter().fold(0.0, |m: f64, c| m.hypot(c[i].widen())).min(f64::MAX)),
            ),
        }
        // Infinity passes for NaN in hypot, and a finite sum may overflow: look at the values themselves.
        for channel in channels {
            if channel.iter().fold(false, |any, c| any | !c.is_finite()) {
                let index = channel.iter().position(|c| !c.is_finite()).unwrap_or_default();
                return Err(Error::NotFinite { what: "coefficient", index });
            }
        }
        match self.weighting {
            Weighting::Magnitude => {}
            Weighting::Integral => scale_levels(keys, block, 0.5),
            Weighting::Area => scale_levels(keys, block, 0.25),
            Weighting::IntegralOver(_) | Weighting::Transport(_) => {
                for (i, key) in keys.iter_mut().enumerate() {
                    *key = (*key * self.weight(i, block)?).min(f64::MAX);
                }
            }
        }
        if self.scaling == ScalingTerms::Always && block > 0 {
            keys.iter_mut().step_by(block).for_each(|k| *k = f64::INFINITY);
        }
        Ok(())
    }

    /// The kept terms of one vector.
    ///
    /// # Errors
    /// As [`indices`](Self::indices).
    pub fn apply(&self, coefs: &[T]) -> Result<SparseVector<T>> {
        let [kept] = self.apply_channels([coefs])?;
        Ok(kept)
    }

    /// The kept terms of several channels: the same indices in each.
    ///
    /// # Errors
    /// As [`indices`](Self::indices).
    pub fn apply_channels<const C: usize>(&self, channels: [&[T]; C]) -> Result<[SparseVector<T>; C]> {
        let mut work = SelectionScratch::default();
        let indices = self.indices(&channels, &mut work)?;
        let mut kept = std::array::from_fn(|_| SparseVector::default());
        for (kept, channel) in kept.iter_mut().zip(channels) {
            *kept = SparseVector::gather(channel, indices)?;
        }
        Ok(kept)
    }

    fn check(&self, channels: &[&[T]]) -> Result<usize> {
        let Some(first) = channels.first() else { return Err(Error::Empty { what: "list of channels" }) };
        let len = first.len();
        if let Some(other) = channels.iter().find(|c| c.len() != len) {
            return Err(Error::Length { what: "channel", expected: len, got: other.len() });
        }
        if u32::try_from(len).is_err() {
            return Err(Error::OutOfRange { what: "coefficients", got: len as f64, allowed: "at most 2^32 − 1" });
        }
        if self.channels == ChannelRule::Luminance && channels.len() != 3 {
            let got = channels.len() as f64;
            return Err(Error::OutOfRange { what: "number of channels", got, allowed: "3 (r, g, b) for luminance" });
        }
        let block = self.block.unwrap_or(len);
        if self.block == Some(0) {
            return Err(Error::OutOfRange { what: "block length", got: 0.0, allowed: "at least 1" });
        }
        if block > 0 && len % block != 0 {
            return Err(Error::Length {
                what: "coefficients, in whole blocks,",
                expected: len / block * block,
                got: len,
            });
        }
        match self.weighting {
            Weighting::Transport(w) if w.len() != len => {
                Err(Error::Length { what: "transport weights", expected: len, got: w.len() })
            }
            Weighting::IntegralOver(p) if len > 0 && p.size() * p.size() != block => {
                Err(Error::Length { what: "pixels of the measure", expected: block, got: p.size() * p.size() })
            }
            Weighting::Area | Weighting::Integral
                if len > 0 && !(block.is_power_of_two() && block.trailing_zeros() % 2 == 0) =>
            {
                let allowed = "1, 4, 16, … (nonstandard coefficients) to weigh by area or integral";
                Err(Error::OutOfRange { what: "block length", got: block as f64, allowed })
            }
            _ => Ok(len),
        }
    }

    fn terms(&self, len: usize) -> Result<usize> {
        self.keep.check()?;
        Ok(self.keep.of(len))
    }

    /// The weight of coefficient i where it is not a power of its level alone.
    fn weight(&self, i: usize, block: usize) -> Result<f64> {
        match self.weighting {
            Weighting::IntegralOver(density) => {
                let (l, x, y) = match Index2d::from_flat(i % block) {
                    Index2d::Scaling => (0, 0, 0),
                    Index2d::Detail { level, x, y, .. } => (level, x, y),
                };
                let mean = check_weight("mean of the measure", i % block, density.at(l, x, y).widen())?;
                Ok(mean / (1u64 << l) as f64)
            }
            Weighting::Transport(weights) => check_weight("transport weight", i, weights[i].widen()),
            Weighting::Magnitude | Weighting::Area | Weighting::Integral => Ok(1.0),
        }
    }
}

/// Multiplies the keys of level l by `factor`^l, block after block of nonstandard coefficients.
fn scale_levels(keys: &mut [f64], block: usize, factor: f64) {
    if block == 0 {
        return;
    }
    for keys in keys.chunks_exact_mut(block) {
        let (mut start, mut weight) = (4, factor);
        while start < keys.len() {
            keys[start..4 * start].iter_mut().for_each(|k| *k *= weight);
            (start, weight) = (4 * start, weight * factor);
        }
    }
}

/// Keys that are looked at together.
const RUN: usize = 32;

/// A key that at least `terms` of the keys reach, if so many are positive, and few more: the lower edge of a bin of
/// keys that share their exponent and four bits of their mantissa.
fn floor_key(keys: &[f64], terms: usize, bins: &mut Vec<u32>) -> f64 {
    const SHIFT: u32 = 48;
    if terms >= keys.len() {
        return 0.0;
    }
    bins.clear();
    bins.resize(1 << (63 - SHIFT), 0);
    // Runs of zeros (a BRDF below the horizon) would wait for each other's count in bin 0.
    for keys in keys.chunks(RUN).filter(|keys| keys.iter().fold(false, |any, &k| any | (k > 0.0))) {
        for key in keys {
            bins[(key.to_bits() >> SHIFT) as usize] += 1;
        }
    }
    let mut above = 0;
    for (bin, &count) in bins.iter().enumerate().rev() {
        above += count as usize;
        if above >= terms {
            return f64::from_bits((bin as u64) << SHIFT);
        }
    }
    0.0
}

fn check_weight(what: &'static str, index: usize, weight: f64) -> Result<f64> {
    if !weight.is_finite() {
        Err(Error::NotFinite { what, index })
    } else if weight < 0.0 {
        Err(Error::OutOfRange { what, got: weight, allowed: "at least 0" })
    } else {
        Ok(weight)
    }
}

/// The kept terms of one vector, ranked by one weighting; scaling functions compete. A convenience for [`Selection`].
///
/// # Errors
/// As [`Selection::indices`].
pub fn select<T: Real>(coefs: &[T], keep: Keep, weighting: Weighting<'_, T>) -> Result<SparseVector<T>> {
    Selection::new(keep).with_weighting(weighting).with_scaling_terms(ScalingTerms::Compete).apply(coefs)
}

/// Weights for [`Weighting::Transport`]: the norms of a transport matrix's columns, from its rows (one a receiver).
/// ```math
/// w_i = √(Σ_v T_vi²), summed in f64; held at the largest number of T where finite elements exceed it
/// ```
///
/// # Errors
/// [`Error::Length`] unless every row is `len` long.
pub fn transport_weights<'a, T: Real>(
    len: usize,
    rows: impl IntoIterator<Item = &'a SparseVector<T>>,
) -> Result<Vec<T>> {
    let mut squares = vec![SquareSum::default(); len];
    for row in rows {
        if row.len() != len {
            return Err(Error::Length { what: "transport row", expected: len, got: row.len() });
        }
        for (i, v) in row.iter() {
            squares[i].add(v.widen());
        }
    }
    let narrow = |norm: f64| if norm.is_finite() { T::of(norm).min(T::max_value()) } else { T::of(norm) };
    Ok(squares.into_iter().map(|squares| narrow(squares.root())).collect())
}
