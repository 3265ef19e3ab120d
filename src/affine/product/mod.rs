//! Integrals of a product of which one factor is scaled and moved: ∫ F(s v + o) G(v) W(v) dv, of sparse signals in the
//! wavelet domain.
//!
//! By affine triplings this is Σ F_i G_j W_k D_ijk. No triple is ever formed: the product G W is walked down the trees
//! of its factors as in [`NFoldProduct`](crate::haar::NFoldProduct), to cells on which all of them are constant, and F
//! is pulled back to those cells. A cell's mean of G W times the integral of F over its image is what the sum over all
//! D_ijk of that cell comes to. F is pulled back either term by term (three breakpoints an axis: nothing but the closed
//! form of D) or by its primitive, of which D holds second differences:
//!
//! | route | reads | cost | when |
//! |---|---|---|---|
//! | [`ProductRoute::Terms`] | each term of F | terms × the nodes of G and W that its breakpoints cross | very few terms; extreme scales |
//! | [`ProductRoute::Primitive`] | a table of F, made once | nodes of G and W, whatever F holds | otherwise |

mod table;
mod terms;
mod walk;

use self::table::{Slopes, Table1d, Table2d, Values};
use self::terms::{Slopes1d, Slopes2d, Terms, Value1d, Value2d};
use self::walk::integrate;
use super::{AffineMap, Atom};
use crate::approx_eq::approx_by_parts;
use crate::haar::{BinaryTree, Decomposition, Quadtree, SparseVector, inverse_1d, inverse_2d};
use crate::{Error, Real, Result};

/// How the transformed factor of an affine product is integrated.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ProductRoute {
    /// Term by term, from the breakpoints of each.
    Terms,
    /// All at once, by differences of its primitive.
    Primitive,
}

/// An integral and its derivatives with respect to the maps of the axes, right-hand where they jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProductGradient<const AXES: usize, const C: usize = 1> {
    /// The integral, of each channel.
    pub value: [f64; C],
    /// ∂/∂s of each axis and channel.
    pub scale: [[f64; C]; AXES],
    /// ∂/∂o of each axis and channel.
    pub offset: [[f64; C]; AXES],
}

/// Differences of the primitive lose as many digits as 1/|s| has: from here on term by term.
const SMALLEST_AREA: f64 = 1.0 / (1u64 << 20) as f64;

/// Terms up to which they are cheaper than differences of the primitive (measured: 0.2 to 0.7 µs a term against 1 to 7
/// µs for all; bench `affine_product`).
const FEW_TERMS: usize = 4;

fn route(terms: usize, area: f64) -> ProductRoute {
    if terms <= FEW_TERMS || area.abs() < SMALLEST_AREA { ProductRoute::Terms } else { ProductRoute::Primitive }
}

/// Plan of ∫ F(s v + o) Π_k G_k(v) dv over [0, 1) for one 1D signal F, many maps and factors.
///
/// ```math
/// no factor: ∫ F;   one: Σ_ij F_i G_j D_ij;   two: Σ_ijk F_i G_j W_k D_ijk          [Sun 2008, eqs. 4.7, 4.10]
/// ```
///
/// F is 0 outside [0, 1). The sizes of F and of the factors may differ. Nothing is allocated after construction.
/// Accuracy: by terms, a few ε of max|F| Π max|G_k|; by the primitive, that over |s| where |s| < 1. Measured against
/// the twin for n ≤ 16 samples: below ¼ n ε (2 + (2 + |o|)/|s|) of it. Cost: see [`ProductRoute`].
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, AffineProduct1d};
/// use haarmonic::haar::{BinaryTree, SparseVector, forward_1d};
/// let sparse = |samples: &[f64]| Ok::<_, haarmonic::Error>(SparseVector::from_dense(&forward_1d(samples)?));
/// let plan = AffineProduct1d::new(&sparse(&[1.0, 2.0, 3.0, 4.0])?)?;
/// let [g, w] = [[1.0, 2.0], [3.0, 0.0]].map(|samples| BinaryTree::new(&sparse(&samples)?));
/// // The left half of F, drawn twice as large, on the left half of the target: the mean of 1 and 1 is seen with 1·3.
/// let map = AffineMap::new(0.5, 0.0)?;
/// assert_eq!(plan.integral([&g?, &w?], map), 0.5 * 1.0 * 3.0);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct AffineProduct1d {
    terms: Terms<1, 1>,
    table: Table1d,
}

impl AffineProduct1d {
    /// The plan of a signal's coefficients (flat 1D index).
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless its length is one; [`Error::OutOfRange`] above 2²⁶.
    pub fn new<T: Real>(source: &SparseVector<T>) -> Result<Self> {
        if super::coupling::levels_of("size of a signal", source.len())? > 26 {
            let got = source.len() as f64;
            return Err(Error::OutOfRange { what: "size of a signal", got, allowed: "at most 2^26" });
        }
        let dense: Vec<f64> = source.to_dense().iter().map(|c| c.widen()).collect();
        let table = Table1d::new(&inverse_1d(&dense)?);
        Ok(Self { terms: Terms::new([source], |i| [Atom::from_flat(i)]), table })
    }

    /// The route that [`integral`](Self::integral) takes.
    pub fn route(&self, map: AffineMap) -> ProductRoute {
        route(self.terms.len(), map.scale())
    }

    /// ∫ F(s v + o) Π_k G_k(v) dv.
    pub fn integral<T: Real, const K: usize>(&self, factors: [&BinaryTree<T>; K], map: AffineMap) -> f64 {
        self.integral_by(self.route(map), factors, map)
    }

    /// As [`integral`](Self::integral), by a given route.
    pub fn integral_by<T: Real, const K: usize>(
        &self,
        route: ProductRoute,
        factors: [&BinaryTree<T>; K],
        map: AffineMap,
    ) -> f64 {
        let [[value]] = match route {
            ProductRoute::Terms => self.terms.sum([map], |axes| integrate(&Value1d(axes), factors)),
            ProductRoute::Primitive => integrate(&Values { table: &self.table, maps: [map] }, factors),
        };
        value
    }

    /// The integral and its derivatives with respect to s and o.
    pub fn gradient<T: Real, const K: usize>(
        &self,
        factors: [&BinaryTree<T>; K],
        map: AffineMap,
    ) -> ProductGradient<1> {
        self.gradient_by(self.route(map), factors, map)
    }

    /// As [`gradient`](Self::gradient), by a given route.
    pub fn gradient_by<T: Real, const K: usize>(
        &self,
        route: ProductRoute,
        factors: [&BinaryTree<T>; K],
        map: AffineMap,
    ) -> ProductGradient<1> {
        let [value, scale, offset] = match route {
            ProductRoute::Terms => self.terms.sum([map], |axes| integrate(&Slopes1d(axes), factors)),
            ProductRoute::Primitive => integrate(&Slopes { table: &self.table, maps: [map] }, factors),
        };
        ProductGradient { value, scale: [scale], offset: [offset] }
    }
}

/// Plan of ∫∫ F(s_x x + o_x, s_y y + o_y) Π_k G_k(x, y) dx dy over [0, 1)² for one 2D signal F of C channels, many maps
/// and factors.
///
/// As [`AffineProduct1d`]; F and the factors by coefficients of the nonstandard basis. For a light F seen from a point
/// at (x, z), with visibility and BRDF as factors, this is the light that the point reflects [Sun 2008, eq. 4.33].
/// Accuracy: by terms, a few ε of max|F| Π max|G_k|; by the primitive, that over |s_x s_y|. Memory: 32 bytes a pixel
/// and channel of F.
///
/// # Example
/// ```
/// use haarmonic::affine::{AffineMap, AffineProduct2d};
/// use haarmonic::haar::{Quadtree, SparseVector};
/// // F = 1 + ψ(x) is 2 on the left half. Moved by a quarter it covers [−¼, ¼); G = 1 + ψ(y) is 2 on the upper half.
/// let light = SparseVector::from_dense(&[1.0, 1.0, 0.0, 0.0]);
/// let visibility = Quadtree::new(&SparseVector::from_dense(&[1.0, 0.0, 1.0, 0.0]))?;
/// let plan = AffineProduct2d::new([&light])?;
/// let maps = [AffineMap::new(1.0, 0.25)?, AffineMap::IDENTITY];
/// assert_eq!(plan.integral([&visibility], maps), [0.25 * 2.0]);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct AffineProduct2d<const C: usize = 1> {
    terms: Terms<2, C>,
    table: Table2d<C>,
}

impl<const C: usize> AffineProduct2d<C> {
    /// The plan of a signal's coefficients (flat nonstandard index) in each channel.
    ///
    /// # Errors
    /// [`Error::Empty`] without channels; [`Error::Length`] unless they have one length; [`Error::NotPowerOfTwo`]
    /// unless that is the square of a power of two; [`Error::OutOfRange`] above a side of 4096.
    pub fn new<T: Real>(channels: [&SparseVector<T>; C]) -> Result<Self> {
        let first = channels.first().ok_or(Error::Empty { what: "list of channels" })?;
        let side = side_of(first.len())?;
        let mut pixels: [Vec<f64>; C] = std::array::from_fn(|_| Vec::new());
        for (pixels, channel) in pixels.iter_mut().zip(channels) {
            let dense: Vec<f64> = channel.to_dense().iter().map(|c| c.widen()).collect();
            *pixels = inverse_2d(&dense, side, side, Decomposition::Nonstandard)?;
        }
        Ok(Self { terms: Terms::new(channels, Atom::from_nonstandard), table: Table2d::new(side, &pixels) })
    }

    /// The route that [`integral`](Self::integral) takes.
    pub fn route(&self, maps: [AffineMap; 2]) -> ProductRoute {
        route(self.terms.len(), maps[0].scale() * maps[1].scale())
    }

    /// ∫∫ F(s_x x + o_x, s_y y + o_y) Π_k G_k(x, y) dx dy of each channel.
    pub fn integral<T: Real, const K: usize>(&self, factors: [&Quadtree<T>; K], maps: [AffineMap; 2]) -> [f64; C] {
        self.integral_by(self.route(maps), factors, maps)
    }

    /// As [`integral`](Self::integral), by a given route.
    pub fn integral_by<T: Real, const K: usize>(
        &self,
        route: ProductRoute,
        factors: [&Quadtree<T>; K],
        maps: [AffineMap; 2],
    ) -> [f64; C] {
        let [value] = match route {
            ProductRoute::Terms => self.terms.sum(maps, |axes| integrate(&Value2d(axes), factors)),
            ProductRoute::Primitive => integrate(&Values { table: &self.table, maps }, factors),
        };
        value
    }

    /// The integral and its derivatives with respect to s and o of both axes.
    pub fn gradient<T: Real, const K: usize>(
        &self,
        factors: [&Quadtree<T>; K],
        maps: [AffineMap; 2],
    ) -> ProductGradient<2, C> {
        self.gradient_by(self.route(maps), factors, maps)
    }

    /// As [`gradient`](Self::gradient), by a given route.
    pub fn gradient_by<T: Real, const K: usize>(
        &self,
        route: ProductRoute,
        factors: [&Quadtree<T>; K],
        maps: [AffineMap; 2],
    ) -> ProductGradient<2, C> {
        let [value, scale_x, offset_x, scale_y, offset_y] = match route {
            ProductRoute::Terms => self.terms.sum(maps, |axes| integrate(&Slopes2d(axes), factors)),
            ProductRoute::Primitive => integrate(&Slopes { table: &self.table, maps }, factors),
        };
        ProductGradient { value, scale: [scale_x, scale_y], offset: [offset_x, offset_y] }
    }
}

fn side_of(len: usize) -> Result<usize> {
    if !len.is_power_of_two() || !len.ilog2().is_multiple_of(2) {
        return Err(Error::NotPowerOfTwo { what: "the side of a 2D signal", got: len });
    }
    let side = 1 << (len.ilog2() / 2);
    if side > 4096 {
        return Err(Error::OutOfRange { what: "side of a 2D signal", got: side as f64, allowed: "at most 4096" });
    }
    Ok(side)
}

/// ∫ F(s v + o) G(v) dv of sparse 1D signals = Σ_ij F_i G_j D_ij: plans an [`AffineProduct1d`] and discards it.
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless the lengths are powers of two; [`Error::OutOfRange`] above 2²⁶, of g or w above 2³⁰.
pub fn affine_double_product_1d<T: Real>(f: &SparseVector<T>, g: &SparseVector<T>, map: AffineMap) -> Result<f64> {
    Ok(AffineProduct1d::new(f)?.integral([&BinaryTree::new(g)?], map))
}

/// ∫ F(s v + o) G(v) W(v) dv of sparse 1D signals = Σ_ijk F_i G_j W_k D_ijk: plans an [`AffineProduct1d`] and discards
/// it.
///
/// # Errors
/// [`Error::NotPowerOfTwo`] unless the lengths are powers of two; [`Error::OutOfRange`] above 2²⁶, of g or w above 2³⁰.
pub fn affine_triple_product_1d<T: Real>(
    f: &SparseVector<T>,
    g: &SparseVector<T>,
    w: &SparseVector<T>,
    map: AffineMap,
) -> Result<f64> {
    Ok(AffineProduct1d::new(f)?.integral([&BinaryTree::new(g)?, &BinaryTree::new(w)?], map))
}

/// ∫∫ F(s_x x + o_x, s_y y + o_y) G(x, y) dx dy of sparse 2D signals (nonstandard basis): plans an [`AffineProduct2d`]
/// and discards it.
///
/// # Errors
/// As [`AffineProduct2d::new`], of any factor.
pub fn affine_double_product_2d<T: Real>(
    f: &SparseVector<T>,
    g: &SparseVector<T>,
    maps: [AffineMap; 2],
) -> Result<f64> {
    let [value] = AffineProduct2d::new([f])?.integral([&Quadtree::new(g)?], maps);
    Ok(value)
}

/// ∫∫ F(s_x x + o_x, s_y y + o_y) G(x, y) W(x, y) dx dy of sparse 2D signals (nonstandard basis): plans an
/// [`AffineProduct2d`] and discards it.
///
/// # Errors
/// As [`AffineProduct2d::new`], of any factor.
pub fn affine_triple_product_2d<T: Real>(
    f: &SparseVector<T>,
    g: &SparseVector<T>,
    w: &SparseVector<T>,
    maps: [AffineMap; 2],
) -> Result<f64> {
    let [value] = AffineProduct2d::new([f])?.integral([&Quadtree::new(g)?, &Quadtree::new(w)?], maps);
    Ok(value)
}

approx_by_parts!(
    [const AXES: usize, const C: usize] ProductGradient<AXES, C>, f64,
    |g| close [&g.value, g.scale.as_flattened(), g.offset.as_flattened()] same []
);
