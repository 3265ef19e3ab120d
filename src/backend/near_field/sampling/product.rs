//! Sampling by the product of light and BRDF.

use nalgebra::Vector3;

use super::super::PlanarLight;
use super::brdf_table::{BrdfTable, Slice};
use super::light::{LightDensity, LightSampler, LightWeight, importance};
use super::mixture::{Mixture, check_share};
use super::window::{Rectangle, Window};
use super::{DirectionSample, DirectionSampler, ShadingPoint};
use crate::affine::{AffineMap, Propagation, PropagationScratch, PropagationSource, Targets};
use crate::haar::{Decomposition, Keep, SampleWarp2d, Selection, Transform2d, Weighting, forward_2d, inverse_2d};
use crate::scene::{Axes, LocalFrame};
use crate::sphere::TopFace;
use crate::{Error, Result};

/// From where a light is seen when its radiance at a point is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Incidence {
    /// From the point.
    #[default]
    Near,
    /// From this place, whatever the point: the light is taken to be far away.
    Distant(Vector3<f64>),
}

/// What a [`ProductSampler`] is made with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProductSettings {
    /// Cells along an edge of the window, and of the light: 64, the "order" of [Sun 2008].
    pub side: usize,
    /// The coefficients of the light that are kept. Default: all.
    pub keep: Keep,
    /// The length of an edge of the face, as [`TopFace`] has it. Default: 10.
    pub face: f64,
    /// What of it is cut into cells.
    pub window: Window,
    /// The share of samples that are light sampling, by radiance. Default: 1/16.
    pub light_share: f64,
    /// From where the light is seen.
    pub incidence: Incidence,
}

impl Default for ProductSettings {
    fn default() -> Self {
        Self {
            side: 64,
            keep: Keep::Fraction(1.0),
            face: 10.0,
            window: Window::default(),
            light_share: 1.0 / 16.0,
            incidence: Incidence::default(),
        }
    }
}

/// Product importance sampling with a light near by: directions as likely as light × BRDF × cosine is large
/// [Sun 2008, §4.6.1].
///
/// Made once for a light. At each point the light's wavelet coefficients are carried there by the affine transform (eq.
/// 4.35), multiplied in the standard basis with the tabulated BRDF times cosine and solid angle, and warped
/// ([`SampleWarp2d`]). In place of RGB the lengths of RGB vectors are multiplied: of one BRDF colour, and of grey light
/// or a grey BRDF, that is what leaves the least error over the three channels, and a blue texel has its part.
///
/// Cells are all that the product knows: it is 0 in a cell whose middle is below the surface, truncated coefficients
/// make it 0 or less where light is, and the window may leave out a part of the light. Therefore a share of the samples
/// is light sampling: estimates are unbiased whatever the settings.
///
/// Unlike the thesis, which cuts the whole face into cells, the window follows the light by default ([`Window`]).
#[derive(Debug, Clone)]
pub struct ProductSampler {
    light: LightSampler,
    extent: [f64; 2],
    settings: ProductSettings,
    source: PropagationSource<f32, 1>,
    /// The source's pixels: what it is seen as through the identity.
    pixels: Vec<f32>,
    propagation: Propagation<f32>,
    targets: Targets,
    transform: Transform2d<f32>,
}

/// Working memory of [`ProductSampler::density`], one for each thread: nothing is allocated after the first point of a
/// table.
#[derive(Debug, Clone)]
pub struct ProductScratch {
    propagation: PropagationScratch<f32>,
    slice: Vec<f32>,
    product: Vec<f32>,
    transform: Vec<f32>,
    warp: SampleWarp2d,
}

impl ProductSampler {
    /// The sampler of a light as it is now, in the frame that its plane lies across.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the axes of the frame are orthonormal to 10⁻³, the side at most 1024, the face in
    /// [1e-6, 1e6], the share in [0, 1] and the fraction of coefficients to keep, if it is one, in [0, 1];
    /// [`Error::NotPowerOfTwo`] for a side that is none; [`Error::NotFinite`] for a place with NaN or ∞ that the light
    /// is to be seen from.
    pub fn new(light: &PlanarLight, frame: &LocalFrame, settings: ProductSettings) -> Result<Self> {
        let side = settings.side;
        check_share(settings.light_share)?;
        TopFace::new(settings.face, 1)?;
        if side > 1024 {
            return Err(Error::OutOfRange { what: "side of a sampler", got: side as f64, allowed: "at most 1024" });
        }
        if let Incidence::Distant(from) = settings.incidence
            && let Some(index) = from.iter().position(|c| !c.is_finite())
        {
            return Err(Error::NotFinite { what: "coordinate of where a light is seen from", index });
        }
        let (sampler, basis) = (LightSampler::new(light, frame, LightWeight::Radiance)?, Decomposition::Standard);
        let transform = Transform2d::new(side, side, basis)?;
        let coefs = forward_2d(&importances(light, side), side, side, basis)?;
        let kept = Selection::new(settings.keep).with_weighting(Weighting::Magnitude).apply(&coefs)?;
        Ok(Self {
            light: sampler,
            extent: light.extent(),
            settings,
            source: PropagationSource::new(side, basis, [&kept])?,
            pixels: inverse_2d(&kept.to_dense(), side, side, basis)?,
            propagation: Propagation::new(side, basis)?,
            targets: Targets::all(side, basis)?,
            transform,
        })
    }

    /// Working memory.
    pub fn scratch(&self) -> ProductScratch {
        let side = self.settings.side;
        let zeros = vec![0.0_f32; side * side];
        ProductScratch {
            propagation: PropagationScratch::new(),
            slice: Vec::new(),
            warp: SampleWarp2d::new(&zeros, side, side, Decomposition::Standard).expect("2^k zeros a side"),
            product: zeros,
            transform: vec![0.0; self.transform.scratch_len()],
        }
    }

    /// The light.
    pub fn light(&self) -> &LightSampler {
        &self.light
    }

    /// What the sampler was made with.
    pub fn settings(&self) -> &ProductSettings {
        &self.settings
    }

    /// The terms of the light that are kept.
    pub fn terms(&self) -> usize {
        self.source.terms()
    }

    /// The density about a point, mixed with light sampling.
    ///
    /// Where the product is 0 everywhere (a viewer below the surface or with NaN, a black BRDF, a light that the
    /// surface turns its back to), it is light sampling alone; behind the light's plane and under a black light there
    /// are no samples.
    ///
    /// Cost: with 64² cells 50 to 70 µs, mostly look-ups of the BRDF. Nothing is allocated but at the first
    /// point of a table.
    ///
    /// # Panics
    /// If the scratch is that of a sampler of another side.
    #[track_caller]
    pub fn density<'a>(
        &'a self,
        point: &ShadingPoint,
        table: &BrdfTable,
        scratch: &'a mut ProductScratch,
    ) -> Mixture<ProductDensity<'a>, LightDensity<'a>> {
        crate::error::check_length("scratch of a sampler", self.pixels.len(), scratch.product.len());
        let light = self.light.density(&point.position);
        let product = self.product(point, table, scratch);
        let share = if product.is_empty() { 1.0 } else { self.settings.light_share };
        Mixture::unchecked(product, light, share)
    }

    fn product<'a>(
        &'a self,
        point: &ShadingPoint,
        table: &BrdfTable,
        scratch: &'a mut ProductScratch,
    ) -> ProductDensity<'a> {
        let ProductScratch { propagation, slice, product, transform, warp } = scratch;
        let axes = self.light.axes();
        let nothing = |warp| ProductDensity { axes, window: None, warp };
        if self.light.density(&point.position).is_empty() {
            return nothing(warp);
        }
        let from = match self.settings.incidence {
            Incidence::Near => point.position,
            Incidence::Distant(from) => from,
        };
        let to = self.light.to_centre(&from);
        let Some((window, maps)) = Rectangle::new(self.settings.window, self.settings.face, self.extent, &to) else {
            return nothing(warp);
        };
        let Some(slice) = table.slice(&point.frame, &point.wo, slice) else { return nothing(warp) };
        if maps == [AffineMap::IDENTITY; 2] {
            product.copy_from_slice(&self.pixels);
        } else {
            self.propagation.apply(&self.source, maps, &self.targets, [product], propagation);
            self.transform.inverse_in_place(product, transform);
        }
        let sum = self.multiply(&window, &slice, product);
        if !(sum > 0.0) {
            return nothing(warp);
        }
        self.transform.forward_in_place(product, transform);
        match warp.set(product) {
            Ok(()) => ProductDensity { axes, window: Some(window), warp },
            Err(_) => nothing(warp),
        }
    }

    /// Multiplies what arrives with BRDF, cosine and solid angle of each cell, at its middle; and the sum.
    ///
    /// What truncation has made negative is 0 first.
    fn multiply(&self, window: &Rectangle, slice: &Slice<'_>, cells: &mut [f32]) -> f32 {
        let side = self.settings.side;
        // Columns: the light's axes in those of the surface.
        let light = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| self.light.axes().to_world(&axis));
        let [x, y, z] = light.map(|world| Vector3::from(slice.axes.map(|axis| axis.dot(&world))));
        let centre = |i: usize| (i as f64 + 0.5) / side as f64;
        let step = (x * (window.point([centre(1), 0.0]).x - window.point([centre(0), 0.0]).x)).cast::<f32>();
        let mut sum = 0.0;
        for (row, cells) in cells.chunks_exact_mut(side).enumerate() {
            let v = window.point([centre(0), centre(row)]);
            let first = (z + x * v.x + y * v.y).cast::<f32>();
            for (column, cell) in cells.iter_mut().enumerate() {
                // Negated, so that NaN is dark.
                if !(*cell > 0.0) {
                    *cell = 0.0;
                    continue;
                }
                let d = first + step * column as f32;
                let falloff = 1.0 / d.norm_squared();
                *cell *= slice.value_times_height(d.x, d.y, d.z) * falloff * falloff;
                sum += *cell;
            }
        }
        sum
    }
}

/// The lengths of RGB vectors, relative to the largest channel, as means over the cells of the light's extent.
fn importances(light: &PlanarLight, side: usize) -> Vec<f32> {
    let [width, height] = light.texture_size();
    let largest = (0..width * height).map(|texel| light.radiance(texel).amax()).fold(0.0, f32::max);
    let mut planes = [(); 3].map(|()| vec![0.0; side * side]);
    let value = |texel| Vector3::new(importance(&light.radiance(texel), largest) as f32, 0.0, 0.0);
    light.placement().resample([width, height], value, side, planes.each_mut().map(Vec::as_mut_slice));
    let [first, ..] = planes;
    first
}

/// The product of light and BRDF about one point, without light sampling: see [`ProductSampler`].
///
/// Constant over each cell of the window, but for the solid angle of a part of it.
#[derive(Debug, Clone)]
pub struct ProductDensity<'a> {
    axes: &'a Axes,
    /// `None` if there is nothing to draw from.
    window: Option<Rectangle>,
    warp: &'a SampleWarp2d,
}

impl ProductDensity<'_> {
    /// Whether there is nothing to draw from.
    pub fn is_empty(&self) -> bool {
        self.window.is_none()
    }
}

impl DirectionSampler for ProductDensity<'_> {
    fn sample(&self, uniform: [f64; 2]) -> Option<DirectionSample> {
        let window = self.window?;
        let (w, density) = self.warp.sample(uniform);
        let v = window.point(w);
        let direction = self.axes.to_world(&v.push(1.0).normalize());
        Some(DirectionSample { direction, pdf: density / window.solid_angle(&v) })
    }

    fn pdf(&self, direction: &Vector3<f64>) -> f64 {
        let (Some(window), d) = (self.window, self.axes.to_local(direction)) else { return 0.0 };
        if !(d.z > 0.0) {
            return 0.0;
        }
        let v = d.xy() / d.z;
        self.warp.density(window.coordinate(&v)) / window.solid_angle(&v)
    }
}
