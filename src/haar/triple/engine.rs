//! The engine that picks the cheaper route.

use pulp::Arch;

use super::super::SparseVector;
use super::bits::{BitPyramid, BitPyramidRef};
use super::masked::MaskedSum;
use super::mean_tree::MeanTree;
use super::merge::Pair;
use super::nodes::SparseNodes;
use crate::error::check_length;
use crate::{Real, Result};

/// A light (C channels) or BRDF (one channel) in every form that the routes of [`TripleProduct`] read.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor<T, const C: usize = 1> {
    nodes: SparseNodes<T, C>,
    means: MeanTree<T, C>,
    /// Texels in Morton order, channel after channel; empty for one channel, whose texels are the last level of
    /// `means`.
    planes: Vec<T>,
}

impl<T: Real, const C: usize> Factor<T, C> {
    /// The factor of sparse nonstandard coefficients, one vector a channel.
    ///
    /// Cost: O(side²), about 1 ns a texel: once a frame for a light, once for a table of BRDFs.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`](crate::Error::NotPowerOfTwo) unless the dense length is the square of one;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) above a side of 2¹⁴; [`Error::Length`](crate::Error::Length)
    /// unless the channels agree; [`Error::Empty`](crate::Error::Empty) if there is no channel.
    pub fn new(coefficients: [&SparseVector<T>; C]) -> Result<Self> {
        let nodes = SparseNodes::new(coefficients)?;
        let mut means = MeanTree::zeros(nodes.side())?;
        means.fill(&nodes);
        let planes =
            if C == 1 { Vec::new() } else { (0..C).flat_map(|c| means.texels(c).collect::<Vec<_>>()).collect() };
        Ok(Self { nodes, means, planes })
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.nodes())
            + size_of_val(self.nodes.weights())
            + size_of_val(self.means.blocks())
            + size_of_val(self.planes.as_slice())
    }

    /// The mean pyramid.
    #[inline]
    pub fn means(&self) -> &MeanTree<T, C> {
        &self.means
    }

    /// The texels of each channel in Morton order.
    #[inline]
    pub fn morton_pixels(&self) -> [&[T]; C] {
        let n = self.means.side() * self.means.side();
        std::array::from_fn(|c| {
            if C == 1 {
                let flat = self.means.blocks().as_flattened().as_flattened();
                &flat[flat.len() - n..]
            } else {
                &self.planes[c * n..][..n]
            }
        })
    }
}

/// The third factor, kept whole.
#[derive(Debug, Clone, Copy)]
pub enum Visibility<'a, T> {
    /// A visibility of any values, as a mean pyramid.
    Means(&'a MeanTree<T>),
    /// A visibility of 0 or 1 a texel, as bits.
    Bits(BitPyramidRef<'a>),
}

impl<'a, T> From<&'a BitPyramid> for Visibility<'a, T> {
    fn from(bits: &'a BitPyramid) -> Self {
        Self::Bits(bits.view())
    }
}

impl<'a, T> From<&'a MeanTree<T>> for Visibility<'a, T> {
    fn from(means: &'a MeanTree<T>) -> Self {
        Self::Means(means)
    }
}

/// How an integral is computed; both give the same number to rounding.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Route {
    /// Node by node over the details of light and BRDF.
    FlatMerge,
    /// Texel by texel under the mask.
    Pixels,
}

/// Plan of ∫ L B V over squares of one side.
///
/// ```math
/// ∫∫ L B V dx dy = Σ_ijk L_i B_j V_k C_ijk                                    [Ng et al. 2004, eq. 4]
/// ```
///
/// Accuracy: sums in T over at most 256 nodes a list or 1024 texels, then f64. Measured against f64 texels, relative to
/// max|L| max|B| max|V|: below 4e-7 in f32 (the rounding of the inputs to f32 included) and 1e-15 in f64, by either
/// route.
/// Cost: see [`Route`]; [`Self::route`] picks by a fixed model of counts, never by timing.
///
/// # Example
/// ```
/// use haarmonic::haar::{BitPyramid, Factor, SparseVector, TripleProduct};
/// // L = 2 + h, B = 1 + 3h over a square of 2 × 2 texels (h = +1 left, −1 right), and only the left column is seen.
/// let light = Factor::new([&SparseVector::from_dense(&[2.0f32, 1.0, 0.0, 0.0])])?;
/// let brdf = Factor::new([&SparseVector::from_dense(&[1.0f32, 3.0, 0.0, 0.0])])?;
/// let visibility = BitPyramid::from_rows(2, &[0b0101])?;
/// let plan = TripleProduct::new(2)?;
/// assert_eq!(plan.integral(&light, &brdf, (&visibility).into()), [0.5 * 3.0 * 4.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct TripleProduct {
    levels: u32,
    arch: Arch,
    masked: MaskedSum,
}

impl TripleProduct {
    /// A plan for squares of `side`² texels.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`](crate::Error::NotPowerOfTwo) unless `side` is one;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) above 2¹⁴.
    pub fn new(side: usize) -> Result<Self> {
        Ok(Self { levels: super::levels_of(side)?, arch: Arch::new(), masked: MaskedSum::new() })
    }

    /// The side of the squares, in texels.
    pub fn side(&self) -> usize {
        1 << self.levels
    }

    /// The route that the cost model prefers.
    ///
    /// A function of the side, the numbers of stored nodes, the form of V and, where the two routes are close, the
    /// number of words of bits that are not all zero; the same on every machine and at every time.
    ///
    /// # Panics
    /// If the visibility's side is not the plan's.
    #[track_caller]
    #[inline]
    pub fn route<T: Real, const C: usize>(
        &self,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> Route {
        self.check_side(visibility);
        self.choose(light, brdf, visibility)
    }

    #[inline(always)]
    fn choose<T: Real, const C: usize>(
        &self,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> Route {
        let cost = Cost::of::<T, C>(matches!(visibility, Visibility::Bits(_)));
        let merge = cost.merge_call + cost.node * (light.nodes.len() + brdf.nodes.len()) as u64;
        let words = (1u64 << (2 * self.levels)).div_ceil(64);
        let pixels = cost.pixels_call + cost.word * words;
        if merge >= pixels {
            return Route::Pixels;
        }
        // Words that are all zero are nearly free, so with an occluded V the texels may win after all. At least the
        // fraction `mean` of the words is not zero: no need to count unless that would leave the texels a chance.
        if let Visibility::Bits(bits) = visibility
            && words > 4
            && merge > cost.pixels_call + 10 * words
            && merge > cost.pixels_call + (cost.word as f32 * words as f32 * bits.mean()) as u64
            && merge >= cost.pixels_call + 10 * words + cost.word * bits.seen_words()
        {
            return Route::Pixels;
        }
        Route::FlatMerge
    }

    #[inline]
    fn check_side<T: Real>(&self, visibility: Visibility<'_, T>) {
        let got = match visibility {
            Visibility::Means(means) => means.levels(),
            Visibility::Bits(bits) => bits.levels(),
        };
        check_length("log₂ of the visibility's side", self.levels as usize, got as usize);
    }

    /// ∫ L B V for each channel of the light, by the cheaper route.
    ///
    /// # Panics
    /// If a factor's side is not the plan's.
    #[track_caller]
    #[inline]
    pub fn integral<T: Real, const C: usize>(
        &self,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> [f64; C] {
        self.check(light, brdf, visibility);
        self.run(self.choose(light, brdf, visibility), light, brdf, visibility)
    }

    /// ∫ L B V by a given route.
    ///
    /// # Panics
    /// If a factor's side is not the plan's.
    #[track_caller]
    pub fn integral_by<T: Real, const C: usize>(
        &self,
        route: Route,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> [f64; C] {
        self.check(light, brdf, visibility);
        self.run(route, light, brdf, visibility)
    }

    #[inline]
    fn check<T: Real, const C: usize>(&self, light: &Factor<T, C>, brdf: &Factor<T>, visibility: Visibility<'_, T>) {
        let levels = self.levels as usize;
        check_length("log₂ of the light's side", levels, light.nodes.levels() as usize);
        check_length("log₂ of the BRDF's side", levels, brdf.nodes.levels() as usize);
        self.check_side(visibility);
    }

    #[inline(always)]
    fn run<T: Real, const C: usize>(
        &self,
        route: Route,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> [f64; C] {
        match route {
            Route::FlatMerge => {
                let (light, light_means) = (&light.nodes, &light.means);
                let pair = Pair { light, light_means, brdf: &brdf.nodes, brdf_means: &brdf.means };
                match visibility {
                    Visibility::Means(means) => pair.with_means(self.arch, means),
                    Visibility::Bits(bits) => pair.with_bits(self.arch, bits),
                }
            }
            Route::Pixels => self.pixels(light, brdf, visibility),
        }
    }

    fn pixels<T: Real, const C: usize>(
        &self,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> [f64; C] {
        let (l, [b]) = (light.morton_pixels(), brdf.morton_pixels());
        let sums = match visibility {
            Visibility::Bits(bits) => self.masked.dots(l, b, bits.words()),
            Visibility::Means(means) => l.map(|l| self.masked.dot_three(l, b, means.morton_pixels())),
        };
        let texel = 0.25f64.powi(self.levels as i32);
        sums.map(|sum| sum * texel)
    }
}

/// Tenths of a cycle: what a call costs and what one more node (merge) or word of 64 texels (pixels) adds.
///
/// Fitted to the sweep of the bench `triple_product` on one core with AVX2, 32 vertices in turn, side 16 to 128. A core
/// with wider vectors has cheaper words, which moves the crossover towards texels by less than the same factor.
struct Cost {
    merge_call: u64,
    node: u64,
    pixels_call: u64,
    word: u64,
}

impl Cost {
    #[inline(always)]
    const fn of<T: Real, const C: usize>(bits: bool) -> Self {
        let c = C as u64;
        match (bits, size_of::<T>() == 4) {
            (true, true) => {
                Self { merge_call: 1050 + 100 * c, node: 74 + 4 * c, pixels_call: 500 + 450 * c, word: 150 * c }
            }
            (true, false) => {
                Self { merge_call: 1050 + 100 * c, node: 74 + 6 * c, pixels_call: 700 + 800 * c, word: 320 * c }
            }
            (false, true) => {
                Self { merge_call: 550 + 100 * c, node: 27 + 6 * c, pixels_call: 250 + 1000 * c, word: 260 * c }
            }
            (false, false) => {
                Self { merge_call: 600 + 150 * c, node: 36 + 10 * c, pixels_call: 250 + 1050 * c, word: 560 * c }
            }
        }
    }
}
