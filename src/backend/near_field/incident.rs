//! A light as every vertex sees it.

use nalgebra::Vector3;

use super::light::{PlanarLight, place};
use super::settings::{Ranking, Settings};
use crate::affine::{AffineMap, Propagation, PropagationScratch, PropagationSource, Targets};
use crate::backend::distant::range::factors;
use crate::haar::{Decomposition, Selection, SelectionScratch, Transform2d, Weighting};
use crate::scene::LocalFrame;
use crate::sphere::TopFace;
use crate::{Error, Result};

/// The light that arrives at any point from a [`PlanarLight`], as wavelets on the point's top face.
///
/// ```math
/// L_k(z, x) = Σ_i F_i D_ik(z, x)                                                        [Sun 2008, eq. 4.35]
/// ```
///
/// F are the wavelets of the light that were kept, L those of the radiance over the face. Any transport that is known
/// on a top face can be fed with it: L is radiance, and the measure belongs to the transport.
///
/// # Example
/// ```
/// use haarmonic::affine::{PropagationScratch, Targets};
/// use haarmonic::backend::near_field::{BakeSettings, IncidentLight, PlanarLight, Settings};
/// use haarmonic::haar::Decomposition::Standard;
/// use haarmonic::nalgebra::Vector3;
/// use haarmonic::sphere::TopFace;
///
/// // A lamp two above the point, four wide: the face of size 2 sees all its middle.
/// let face = TopFace::new(2.0, 16)?;
/// let mut incident = IncidentLight::new(face, BakeSettings::default().frame, Settings::default())?;
/// incident.set(&PlanarLight::uniform(Vector3::new(0.0, 2.0, 0.0), [4.0, 4.0], Vector3::new(1.0, 2.0, 3.0))?)?;
/// let (mut r, mut g, mut b) = (vec![0.0; 256], vec![0.0; 256], vec![0.0; 256]);
/// let all = Targets::all(16, Standard)?;
/// incident.coefficients(&Vector3::zeros(), &all, [&mut r, &mut g, &mut b], &mut PropagationScratch::new());
/// assert_eq!((r[0], g[0], b[0]), (1.0, 2.0, 3.0)); // the means; there are no details
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct IncidentLight {
    face: TopFace,
    frame: LocalFrame,
    settings: Kept,
    transform: Transform2d<f32>,
    plan: Propagation<f32>,
    source: PropagationSource<f32, 3>,
    /// The pixels of what is kept, row by row; and coefficients.
    pixels: [Vec<f32>; 3],
    coefs: [Vec<f32>; 3],
    /// What the magnitudes of coefficients are multiplied by, to rank them by the integral.
    weights: Vec<f32>,
    selection: SelectionScratch,
    scratch: PropagationScratch<f32>,
    work: Vec<f32>,
    centre: Vector3<f64>,
    extent: [f64; 2],
    /// What sums are multiplied by: 1, but for lights beyond the range of sums in `f32`.
    factor: f64,
    /// Of each cell of the face, column by column; empty for lights that shine alike in all directions.
    profile: Vec<f32>,
}

/// What is kept of a light.
#[derive(Debug, Clone, Copy)]
struct Kept {
    side: usize,
    terms: crate::haar::Keep,
    ranking: Ranking,
}

impl IncidentLight {
    /// No light yet, on a top face along a frame. Of the settings, those of the source count.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless the cells of the face and the side of the source are; [`Error::OutOfRange`] for
    /// either above 256, and for a fraction of terms outside [0, 1].
    pub fn new(face: TopFace, frame: LocalFrame, settings: Settings<'_>) -> Result<Self> {
        let Settings { source_side: side, source_terms, ranking, .. } = settings;
        for (what, got) in [("cells along a top face", face.cells()), ("wavelets of a light along an axis", side)] {
            if got > 256 {
                return Err(Error::OutOfRange { what, got: got as f64, allowed: "at most 256" });
            }
        }
        source_terms.check()?;
        let plan = Propagation::between(side, face.cells(), Decomposition::Standard)?;
        let planes = || [(); 3].map(|()| vec![0.0; side * side]);
        let black = planes();
        let source = PropagationSource::from_dense(side, Decomposition::Standard, black.each_ref().map(Vec::as_slice))?;
        let octave = |k: usize| k.checked_ilog2().unwrap_or(0) as i32;
        let weights =
            (0..side * side).map(|i| 2f32.powf(-0.5 * (octave(i % side) + octave(i / side)) as f32)).collect();
        let transform = Transform2d::new(side, side, Decomposition::Standard)?;
        Ok(Self {
            face,
            frame,
            work: vec![0.0; transform.scratch_len()],
            settings: Kept { side, terms: source_terms, ranking },
            transform,
            plan,
            source,
            pixels: planes(),
            coefs: black,
            weights,
            selection: SelectionScratch::default(),
            scratch: PropagationScratch::new(),
            centre: Vector3::zeros(),
            extent: [1.0; 2],
            factor: 1.0,
            profile: Vec::new(),
        })
    }

    /// Becomes the light that arrives from another one, or from the same after it has moved or been painted.
    ///
    /// Nothing is allocated once as many wavelets have been kept. Cost: the texture resampled on `source_side`² cells,
    /// a transform and a choice; two more transforms and a summed-area table where wavelets are dropped.
    ///
    /// # Errors
    /// None that a [`PlanarLight`] can be the reason of.
    pub fn set(&mut self, light: &PlanarLight) -> Result<()> {
        let side = self.settings.side;
        self.centre = self.frame.to_local(&light.centre());
        self.extent = light.extent();
        light.write_pixels(side, self.pixels.each_mut().map(Vec::as_mut_slice));
        self.factor = bring_in_range(&mut self.pixels);
        self.select()?;
        self.profile.clear();
        if light.has_profile() {
            let cells = self.face.cells();
            for i in 0..cells * cells {
                let (x, y) = (i / cells, i % cells);
                let direction = self.frame.to_world(&self.face.cell_direction(y * cells + x));
                self.profile.push(light.profile(&-direction) as f32);
            }
        }
        Ok(())
    }

    /// Keeps the wavelets of the pixels that the settings say.
    fn select(&mut self) -> Result<()> {
        let Self {
            settings: Kept { side, terms, ranking }, transform, pixels, coefs, weights, selection, work, ..
        } = self;
        for (pixels, coefs) in pixels.iter().zip(&mut *coefs) {
            transform.forward(pixels, coefs, work);
        }
        let len = *side * *side;
        if terms.of(len) < len {
            let weighting = match ranking {
                Ranking::Magnitude => Weighting::Magnitude,
                Ranking::Integral => Weighting::Transport(weights),
            };
            let rule = Selection::new(*terms).with_weighting(weighting);
            let kept = rule.indices(&coefs.each_ref().map(Vec::as_slice), selection)?;
            for (coefs, pixels) in coefs.iter_mut().zip(pixels) {
                let mut next = 0;
                for (i, coef) in coefs.iter_mut().enumerate() {
                    if kept.get(next).is_some_and(|&k| k as usize == i) {
                        next += 1;
                    } else {
                        *coef = 0.0;
                    }
                }
                transform.inverse(coefs, pixels, work);
            }
            self.source.set_dense(coefs.each_ref().map(Vec::as_slice), &mut self.scratch);
        } else {
            self.source.set_pixels(pixels.each_ref().map(Vec::as_slice), &mut self.scratch);
        }
        Ok(())
    }

    /// Where the light lies over the face of a point of the world: [`PlanarLight::maps`].
    #[inline]
    pub fn maps(&self, position: &Vector3<f64>) -> Option<[AffineMap; 2]> {
        let to = self.centre - self.frame.to_local(position);
        place(self.face.size(), self.extent, &to)
    }

    /// The wavelets L_k of the radiance over the face of a point of the world: one value a target in each of R, G and
    /// B. All are 0 in the light's plane and behind it.
    ///
    /// A [profile](PlanarLight::set_profile) is not part of it: it multiplies the radiance cell by cell.
    ///
    /// # Panics
    /// If the targets are not of the face's side in the standard basis, or a plane has not one value a target.
    #[track_caller]
    pub fn coefficients(
        &self,
        position: &Vector3<f64>,
        targets: &Targets,
        mut out: [&mut [f32]; 3],
        scratch: &mut PropagationScratch<f32>,
    ) {
        match self.maps(position) {
            Some(maps) => {
                self.plan.apply(&self.source, maps, targets, out.each_mut().map(|plane| &mut **plane), scratch);
                if self.factor != 1.0 {
                    out.into_iter().flatten().for_each(|l| *l = clamp(f64::from(*l) * self.factor));
                }
            }
            None => out.into_iter().for_each(|plane| plane.fill(0.0)),
        }
    }

    /// How many wavelets were kept.
    pub fn terms(&self) -> usize {
        self.source.terms()
    }

    pub(super) fn plan(&self) -> &Propagation<f32> {
        &self.plan
    }

    pub(super) fn source(&self) -> &PropagationSource<f32, 3> {
        &self.source
    }

    pub(super) fn pixels(&self) -> [&[f32]; 3] {
        self.pixels.each_ref().map(Vec::as_slice)
    }

    pub(super) fn extent(&self) -> [f64; 2] {
        self.extent
    }

    pub(super) fn factor(&self) -> f64 {
        self.factor
    }

    pub(super) fn profile(&self) -> &[f32] {
        &self.profile
    }

    /// Projects a derivative in the pixels on the wavelets that were kept.
    pub(super) fn project(&mut self, planes: &mut [Vec<f32>; 3]) {
        let side = self.settings.side;
        if self.settings.terms.of(side * side) == side * side {
            return;
        }
        for plane in planes {
            let Self { transform, work, coefs, .. } = self;
            transform.forward_in_place(plane, work);
            for (i, g) in plane.iter_mut().enumerate() {
                if coefs.iter().all(|coefs| coefs[i] == 0.0) {
                    *g = 0.0;
                }
            }
            transform.inverse_in_place(plane, work);
        }
    }
}

/// To the range of `f32`.
#[inline]
pub(super) fn clamp(x: f64) -> f32 {
    let limit = f64::from(f32::MAX);
    x.clamp(-limit, limit) as f32
}

/// Scales pixels by a power of two into the range of sums in `f32`, and says what undoes it.
fn bring_in_range(planes: &mut [Vec<f32>; 3]) -> f64 {
    let largest = planes.iter().flatten().fold(0.0_f32, |m, x| m.max(x.abs())).min(f32::MAX);
    let Some([down, up]) = factors(largest) else { return 1.0 };
    let scaled = |x: f32| (f64::from(x.clamp(-f32::MAX, f32::MAX)) * down) as f32;
    planes.iter_mut().flatten().for_each(|x| *x = scaled(*x));
    up
}
