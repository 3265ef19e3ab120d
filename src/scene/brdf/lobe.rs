//! Models of a single lobe: a constant colour times a kernel.
//!
//! A model says here, once, what everything that treats lobes apart wants to know of it; who integrates a lobe visits
//! its kernel and need not know which model it is of.

use nalgebra::Vector3;

use super::kernel::{self, Kernel};
use super::{Axes, BlinnPhong, Brdf, CookTorrance, DirectionTable, Lambert, Phong, Ward, is_poisoned, plane_count};
use crate::Result;
use crate::scene::LocalFrame;

/// A model that is one lobe with a kernel in `f32` of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Lobe {
    /// [`Lambert`].
    Lambert(Lambert),
    /// [`Phong`].
    Phong(Phong),
    /// [`BlinnPhong`].
    BlinnPhong(BlinnPhong),
    /// [`Ward`].
    Ward(Ward),
    /// [`CookTorrance`].
    CookTorrance(CookTorrance),
}

/// The same expression for whichever model a lobe is of.
macro_rules! of_any {
    ($lobe:expr, $model:ident => $value:expr) => {
        match $lobe {
            Lobe::Lambert($model) => $value,
            Lobe::Phong($model) => $value,
            Lobe::BlinnPhong($model) => $value,
            Lobe::Ward($model) => $value,
            Lobe::CookTorrance($model) => $value,
        }
    };
}

#[allow(dead_code, reason = "for those back ends that treat lobes apart")]
impl Lobe {
    /// What the kernel is multiplied with, a factor a channel.
    pub(crate) fn factor(&self) -> Vector3<f64> {
        of_any!(self, model => model.tint() * model.constant())
    }

    /// What the form of the kernel depends on.
    pub(crate) fn shape(&self) -> Shape {
        of_any!(self, model => model.shape())
    }

    /// A lobe of the same model with another shape.
    ///
    /// # Errors
    /// Those of the model's constructor.
    ///
    /// # Panics
    /// If the shape is of another kind than the model's.
    #[track_caller]
    pub(crate) fn reshaped(&self, shape: Shape) -> Result<Self> {
        of_any!(self, model => Ok(model.reshaped(shape)?.lobe()))
    }

    /// Hands the kernel for a viewer to `visitor`; `None` if the viewer is below the horizon.
    #[inline(always)]
    pub(crate) fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output> {
        of_any!(self, model => model.visit(axes, wo, visitor))
    }
}

/// What the form of a lobe's kernel depends on.
#[allow(dead_code, reason = "for those back ends that treat lobes apart")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// On nothing: it is the cosine.
    Cosine,
    /// On the exponent of the cosine to the mirror direction.
    Mirror { exponent: f64 },
    /// On the exponent of the cosine between half vector and normal.
    Half { exponent: f64 },
    /// On the roughness along tangent and bitangent and, linearly, on the reflectance at normal incidence.
    Microfacets { alpha: [f64; 2], f0: Vector3<f64> },
}

/// What is done with a kernel of any model.
pub(crate) trait KernelVisitor {
    type Output;
    fn visit<const N: usize, K: Kernel<N>>(self, kernel: K) -> Self::Output;
}

/// A model of one lobe: f · cos θ_i = tint · constant · kernel.
pub(super) trait LobeModel: Brdf + Copy {
    /// Which lobe it is.
    fn lobe(self) -> Lobe;
    fn tint(&self) -> Vector3<f64>;
    fn constant(&self) -> f64;
    fn shape(&self) -> Shape;
    /// The same model with a shape that is of its kind.
    fn reshaped(&self, shape: Shape) -> Result<Self>;
    /// Hands its kernel to `visitor`; `None` if the viewer is below the horizon.
    fn visit<V: KernelVisitor>(&self, axes: &Axes, wo: &Vector3<f64>, visitor: V) -> Option<V::Output>;
}

/// [`Brdf::add_cos`] by the kernel of a model.
#[track_caller]
pub(super) fn add_cos(
    model: &impl LobeModel,
    frame: &LocalFrame,
    wo: &Vector3<f64>,
    directions: &DirectionTable,
    scale: f64,
    out: &mut [f32],
) {
    if is_poisoned(frame, wo, out) {
        return;
    }
    plane_count(model.colour().is_some(), directions.len(), out.len());
    let axes = Axes::new(frame);
    let factor = kernel::scaled(&model.tint(), scale, model.constant());
    model.visit(&axes, wo, Add { axes: &axes, directions, factor, out });
}

struct Add<'a> {
    axes: &'a Axes,
    directions: &'a DirectionTable,
    /// A colour whose largest component is 1, and its strength.
    factor: (Vector3<f64>, f64),
    out: &'a mut [f32],
}

impl KernelVisitor for Add<'_> {
    type Output = ();

    fn visit<const N: usize, K: Kernel<N>>(self, kernel: K) {
        kernel::add(kernel, self.axes, self.directions, self.factor, self.out);
    }
}

/// The panic of a model that is given another model's shape.
#[cold]
#[track_caller]
pub(super) fn foreign(model: &str, shape: Shape) -> ! {
    panic!("{shape:?} is no shape of {model}")
}
