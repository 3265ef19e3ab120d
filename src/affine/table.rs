//! M_ψψ as a texture: what a shader without arithmetic to spare looks up.

use super::{Mother, canonical};
use crate::{Error, Result};

/// How the texels of a [`CanonicalTable`] are stored. All use that −½ ≤ M ≤ 1 on the stored quarter.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantisation {
    /// M = 1.5 x/255 − ½. Zero is exact (x = 85).
    Unorm8,
    /// M = x/127.
    Snorm8,
    /// M = 1.5 x/65535 − ½. Zero is exact (x = 21845).
    Unorm16,
    /// M = x/32767.
    Snorm16,
    /// M itself.
    F32,
}

impl Quantisation {
    /// All quantisations.
    pub const ALL: [Self; 5] = [Self::Unorm8, Self::Snorm8, Self::Unorm16, Self::Snorm16, Self::F32];

    /// Bytes a texel.
    pub fn bytes(self) -> usize {
        match self {
            Self::Unorm8 | Self::Snorm8 => 1,
            Self::Unorm16 | Self::Snorm16 => 2,
            Self::F32 => 4,
        }
    }

    /// [scale, bias]: M = scale·t + bias of the number t that a sampler returns (unorm: 0…1, snorm: −1…1, float: M).
    pub fn decoding(self) -> [f64; 2] {
        match self {
            Self::Unorm8 | Self::Unorm16 => [1.5, -0.5],
            Self::Snorm8 | Self::Snorm16 | Self::F32 => [1.0, 0.0],
        }
    }
}

/// How a [`CanonicalTable`] is read between its texels.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Filter {
    /// The texel whose centre is nearest.
    Nearest,
    /// Bilinear with exact weights.
    #[default]
    Linear,
    /// Bilinear with weights rounded to so many bits after the point, as most texture units do: 8 is usual, 4 the least
    /// that the graphics interfaces demand.
    LinearFixed(u32),
}

/// The texels of a [`CanonicalTable`], row after row.
#[derive(Debug, Clone, PartialEq)]
enum Texels {
    Unorm8(Vec<u8>),
    Snorm8(Vec<i8>),
    Unorm16(Vec<u16>),
    Snorm16(Vec<i16>),
    F32(Vec<f32>),
}

/// M(r, c) = M_ψψ of [`canonical`] in a table, for hardware textures                       [Sun 2008, §4.4.2 and
/// §4.5.5].
///
/// On a processor, and on any GPU whose arithmetic is not the bottleneck, use [`canonical`]: it is exact and cheaper
/// than folding the arguments of a look-up. The table is for what can only look up, and for reproducing the thesis.
///
/// # Layout
/// Only the quarter 0 ≤ r ≤ ½, −½ ≤ c ≤ ½ is stored, of which −r ≤ c ≤ ½ is not zero; the rest follows from
///
/// ```math
/// M(−r, c) = −M(r, c),   M(r, ½ + c) = M(r, ½ − c),   M(r, c) = 2r M(1/4r, ½ + 1/4r − c/2r)
/// ```
///
/// (the thesis' eq. 4.28 is right, the last line of its derivation is not; see docs/errata.md). With n = `resolution`,
/// texel (x, y), x < n + 1, y < n/2 + 1, row after row, is M(y/n, x/n − ½): values sit on the quarter's edges. After
/// folding sample with clamp to edge at
///
/// ```math
/// u = ((c + ½) n + ½)/(n + 1),   v = (r n + ½)/(n/2 + 1),   M = scale·t + bias, see Quantisation::decoding.
/// ```
///
/// # Why this grid
/// M is piecewise linear with kinks at c = 0, c = ±r and c = ½ − r. With equal steps 1/n in r and c, n a multiple of 4,
/// they are grid lines and diagonals of cells, and bilinear interpolation errs only in cells that a diagonal crosses,
/// by at most a quarter of the jump in slope (1 or 2) a step: 1/(2n). At equal numbers of texels a square table of the
/// same quarter has 1.4 times the error (RMS 1.7 times), one over (r, (½ − c)/(½ + r)) the same maximum and 1.4 times
/// the RMS, one over (c, c + r) the same maximum and 1.2 times the RMS.
///
/// # Accuracy
/// Error of [`lookup`](Self::lookup) over uniform samples of 0 < r ≤ ½, −r ≤ c ≤ ½ in units of 10⁻³, maximum / RMS:
///
/// | n | texels | F32 | Unorm16 | Snorm16 | Unorm8 | Snorm8 |
/// |---|---|---|---|---|---|---|
/// | 64 | 65 × 33 | 7.80 / .558 | 7.80 / .558 | 7.80 / .557 | 8.66 / 1.10 | 7.86 / 1.71 |
/// | 128 | 129 × 65 | 3.83 / .197 | 3.83 / .197 | 3.83 / .197 | 5.04 / .971 | 5.41 / 1.68 |
/// | 256 | 257 × 129 | 1.92 / .070 | 1.91 / .070 | 1.92 / .070 | 3.17 / .952 | 3.93 / 1.41 |
/// | 512 | 513 × 257 | .965 / .025 | .967 / .025 | .965 / .025 | 2.94 / .952 | 3.84 / 1.31 |
///
/// 16 bits lose nothing; with 8, steps of 1.5/255 are all that is left from n = 256 on. Weights of 8 bits
/// ([`Filter::LinearFixed`]) change the maximum by less than 1 %; the nearest texel errs by 2/n (RMS .58/n). For r > ½
/// the error of the folded point is multiplied by 2r: M(r, c) is worth ±1 there and the table's value 1/2r, so a
/// wavelet wider than the other by more than n/2 is read from the first two rows alone. D carries a factor of 2^{(l_i −
/// l_j)/2}, about (2r)^{−1/2}, which halves the digits lost.
///
/// # Example
/// ```
/// use haarmonic::affine::{CanonicalTable, Mother, Quantisation, canonical};
/// let table = CanonicalTable::new(256, Quantisation::Unorm8)?;
/// assert_eq!((table.width(), table.height(), table.bytes()), (257, 129, 33153));
/// let exact: f64 = canonical(Mother::Wavelet, Mother::Wavelet, 0.8, 0.3);
/// assert!((table.lookup(0.8, 0.3) - exact).abs() < 0.005);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CanonicalTable {
    resolution: usize,
    filter: Filter,
    texels: Texels,
}

impl CanonicalTable {
    /// Tabulates M with steps of 1/`resolution`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `resolution` is a multiple of 4 in 4…8192.
    pub fn new(resolution: usize, quantisation: Quantisation) -> Result<Self> {
        if resolution == 0 || resolution % 4 != 0 || resolution > 8192 {
            let allowed = "a multiple of 4 in 4…8192";
            return Err(Error::OutOfRange { what: "resolution of a table", got: resolution as f64, allowed });
        }
        let n = resolution as f64;
        let cells =
            (0..=resolution / 2).flat_map(|y| (0..=resolution).map(move |x| [y as f64 / n, x as f64 / n - 0.5]));
        let values = cells.map(|[r, c]| canonical(Mother::Wavelet, Mother::Wavelet, r, c));
        let unorm = |m: f64, top: f64| ((m + 0.5) / 1.5 * top).round();
        let texels = match quantisation {
            Quantisation::Unorm8 => Texels::Unorm8(values.map(|m| unorm(m, 255.0) as u8).collect()),
            Quantisation::Snorm8 => Texels::Snorm8(values.map(|m| (m * 127.0).round() as i8).collect()),
            Quantisation::Unorm16 => Texels::Unorm16(values.map(|m| unorm(m, 65535.0) as u16).collect()),
            Quantisation::Snorm16 => Texels::Snorm16(values.map(|m| (m * 32767.0).round() as i16).collect()),
            Quantisation::F32 => Texels::F32(values.map(|m| m as f32).collect()),
        };
        Ok(Self { resolution, filter: Filter::default(), texels })
    }

    /// The same table with another way to read between texels.
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// How many texels there are to a unit of r or c.
    #[inline]
    pub fn resolution(&self) -> usize {
        self.resolution
    }

    /// Texels along c.
    #[inline]
    pub fn width(&self) -> usize {
        self.resolution + 1
    }

    /// Texels along r.
    #[inline]
    pub fn height(&self) -> usize {
        self.resolution / 2 + 1
    }

    /// How the texels are stored.
    #[inline]
    pub fn quantisation(&self) -> Quantisation {
        match self.texels {
            Texels::Unorm8(_) => Quantisation::Unorm8,
            Texels::Snorm8(_) => Quantisation::Snorm8,
            Texels::Unorm16(_) => Quantisation::Unorm16,
            Texels::Snorm16(_) => Quantisation::Snorm16,
            Texels::F32(_) => Quantisation::F32,
        }
    }

    /// Bytes of the texture.
    pub fn bytes(&self) -> usize {
        self.width() * self.height() * self.quantisation().bytes()
    }

    /// The texture for upload: little-endian texels, row after row, without padding.
    pub fn texels(&self) -> Vec<u8> {
        match &self.texels {
            Texels::Unorm8(t) => t.clone(),
            Texels::Snorm8(t) => t.iter().map(|&t| t as u8).collect(),
            Texels::Unorm16(t) => t.iter().flat_map(|t| t.to_le_bytes()).collect(),
            Texels::Snorm16(t) => t.iter().flat_map(|t| t.to_le_bytes()).collect(),
            Texels::F32(t) => t.iter().flat_map(|t| t.to_le_bytes()).collect(),
        }
    }

    /// M(r, c) for any finite r and c, as a texture unit reads it; held in [−1, 1], beyond which the multiplied error
    /// of a large r might take it.
    ///
    /// M is zero at r = 0; NaN gives NaN, and so does an infinite r.
    pub fn lookup(&self, r: f64, c: f64) -> f64 {
        let radius = r.abs();
        // Half of the factor: twice the largest numbers is infinite, and the texel may be 0.
        let (factor, radius, centre) = if radius > 0.5 {
            let inverse = 0.5 / radius;
            (r, 0.5 * inverse, 0.5 + 0.5 * inverse - c * inverse)
        } else {
            (0.5 * r.signum(), radius, c)
        };
        let centre = if centre > 0.5 { 1.0 - centre } else { centre };
        (factor * (2.0 * self.sample(radius, centre))).clamp(-1.0, 1.0)
    }

    /// One filtered read, clamped to the edge.
    fn sample(&self, r: f64, c: f64) -> f64 {
        let n = self.resolution as f64;
        let clamp = |t: f64, top: usize| {
            if t < 0.0 {
                0.0
            } else if t > top as f64 {
                top as f64
            } else {
                t
            }
        };
        let (x, y) = (clamp((c + 0.5) * n, self.width() - 1), clamp(r * n, self.height() - 1));
        if (x + y).is_nan() {
            return f64::NAN;
        }
        let round = |t: f64| match self.filter {
            Filter::Nearest => (t + 0.5).floor(),
            Filter::Linear => t,
            Filter::LinearFixed(bits) => {
                let steps = f64::from(bits.min(30)).exp2();
                (t * steps).round() / steps
            }
        };
        let (x, y) = (round(x), round(y));
        let (left, top) = (x as usize, y as usize);
        let (a, b) = (x - left as f64, y - top as f64);
        let right = (left + 1).min(self.width() - 1);
        let row = |y: usize| {
            let at = |x: usize| self.texel(y * self.width() + x);
            at(left) + a * (at(right) - at(left))
        };
        let (above, below) = (row(top), row((top + 1).min(self.height() - 1)));
        above + b * (below - above)
    }

    fn texel(&self, i: usize) -> f64 {
        match &self.texels {
            // (3x − 255)/510: exact at M = 0.
            Texels::Unorm8(t) => (3.0 * f64::from(t[i]) - 255.0) / 510.0,
            Texels::Snorm8(t) => f64::from(t[i]) / 127.0,
            Texels::Unorm16(t) => (3.0 * f64::from(t[i]) - 65535.0) / 131_070.0,
            Texels::Snorm16(t) => f64::from(t[i]) / 32767.0,
            Texels::F32(t) => f64::from(t[i]),
        }
    }
}
