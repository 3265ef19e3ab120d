//! A textured rectangle at a place.

use std::sync::Arc;

use nalgebra::{Rotation2, Vector2, Vector3};

use super::texture::Placement;
use crate::affine::AffineMap;
use crate::scene::{LightField, LocalFrame, LocalLight, RectangleLight};
use crate::sphere::TopFace;
use crate::{Error, Result};

/// A rectangle with a texture of radiance, in a plane across the normal of a frame that the caller has chosen for all
/// lights and transports: it shines against that normal, downwards if the normal points up.
///
/// The same radiance leaves a point of it in all directions, unless there is a [`profile`](Self::set_profile). Columns
/// of the texture run along the frame's tangent and rows along its bitangent, both turned by the light's rotation about
/// the normal. Seen from below, with the tangent to the right, the texture stands upright.
///
/// Everything may change in every frame: [`set_centre`](Self::set_centre), [`set_size`](Self::set_size),
/// [`set_rotation`](Self::set_rotation), [`set_texture`](Self::set_texture), [`set_mask`](Self::set_mask).
///
/// # Example
/// ```
/// use haarmonic::backend::near_field::PlanarLight;
/// use haarmonic::nalgebra::Vector3;
/// // Two metres above the origin, red at the left and blue at the right.
/// let texture = vec![Vector3::x(), Vector3::z()];
/// let mut light = PlanarLight::new(Vector3::new(0.0, 2.0, 0.0), [1.0, 0.5], 2, texture)?;
/// light.set_rotation(std::f64::consts::FRAC_PI_2)?;
/// let [width, height] = light.extent();
/// assert!((width - 0.5).abs() < 1e-15 && (height - 1.0).abs() < 1e-15);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarLight {
    centre: Vector3<f64>,
    size: [f64; 2],
    rotation: f64,
    width: usize,
    texture: Vec<Vector3<f32>>,
    /// Empty: all of the texture shines.
    mask: Vec<f32>,
    profile: Option<Profile>,
}

/// How much of the radiance leaves in a direction.
#[derive(Clone)]
struct Profile(Arc<Share>);

/// A function of the unit direction that leaves the light.
type Share = dyn Fn(&Vector3<f64>) -> f64 + Send + Sync;

impl std::fmt::Debug for Profile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Profile").finish_non_exhaustive()
    }
}

impl PartialEq for Profile {
    /// Whether these are the same object.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl PlanarLight {
    /// A light about `centre` in the world, `size` along the tangent and the bitangent, with a texture of `width`
    /// columns, row after row.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a coordinate or texel with NaN or ∞, [`Error::OutOfRange`] unless both sizes are
    /// positive and finite, [`Error::Empty`] without texels, [`Error::Length`] unless they fill their rows.
    pub fn new(centre: Vector3<f64>, size: [f64; 2], width: usize, texture: Vec<Vector3<f32>>) -> Result<Self> {
        if texture.is_empty() || width == 0 {
            return Err(Error::Empty { what: "texture of a light" });
        }
        if !texture.len().is_multiple_of(width) {
            let expected = texture.len().next_multiple_of(width);
            return Err(Error::Length { what: "texels of a light", expected, got: texture.len() });
        }
        check_texture(&texture)?;
        check_centre(&centre)?;
        check_size(size)?;
        Ok(Self { centre, size, rotation: 0.0, width, texture, mask: Vec::new(), profile: None })
    }

    /// A light of one radiance.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn uniform(centre: Vector3<f64>, size: [f64; 2], radiance: Vector3<f32>) -> Result<Self> {
        Self::new(centre, size, 1, vec![radiance])
    }

    /// The same light, turned: see [`set_rotation`](Self::set_rotation).
    ///
    /// # Errors
    /// As [`set_rotation`](Self::set_rotation).
    pub fn with_rotation(mut self, angle: f64) -> Result<Self> {
        self.set_rotation(angle)?;
        Ok(self)
    }

    /// Moves the light.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a coordinate that is NaN or infinite; the light stays where it is then.
    pub fn set_centre(&mut self, centre: Vector3<f64>) -> Result<()> {
        check_centre(&centre)?;
        self.centre = centre;
        Ok(())
    }

    /// Scales the light, each axis by itself. Its radiance stays: twice the area shines twice as much.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless both are positive and finite.
    pub fn set_size(&mut self, size: [f64; 2]) -> Result<()> {
        check_size(size)?;
        self.size = size;
        Ok(())
    }

    /// Turns the light in its plane, by so many radians from the tangent towards the bitangent.
    ///
    /// A rotation is no affine map of each axis by itself: the texture is resampled on an upright rectangle around the
    /// turned one ([`pixels`](Self::pixels)), in which its edges become as soft as that grid's cells are large.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for an angle that is NaN or infinite.
    pub fn set_rotation(&mut self, angle: f64) -> Result<()> {
        if !angle.is_finite() {
            return Err(Error::NotFinite { what: "rotation of a light", index: 0 });
        }
        self.rotation = angle;
        Ok(())
    }

    /// Paints the light anew, with as many texels as before.
    ///
    /// # Errors
    /// [`Error::Length`] for another number of texels, [`Error::NotFinite`] for one with NaN or ∞.
    pub fn set_texture(&mut self, texture: &[Vector3<f32>]) -> Result<()> {
        if texture.len() != self.texture.len() {
            let (expected, got) = (self.texture.len(), texture.len());
            return Err(Error::Length { what: "texels of a light", expected, got });
        }
        check_texture(texture)?;
        self.texture.copy_from_slice(texture);
        Ok(())
    }

    /// Covers the light: each texel shines with its radiance times its value of the mask. An empty mask covers nothing.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is a value a texel or none, [`Error::NotFinite`] for NaN and ∞.
    pub fn set_mask(&mut self, mask: &[f32]) -> Result<()> {
        if !mask.is_empty() && mask.len() != self.texture.len() {
            let (expected, got) = (self.texture.len(), mask.len());
            return Err(Error::Length { what: "mask of a light", expected, got });
        }
        if let Some(index) = mask.iter().position(|m| !m.is_finite()) {
            return Err(Error::NotFinite { what: "mask of a light", index });
        }
        self.mask.clear();
        self.mask.extend_from_slice(mask);
        Ok(())
    }

    /// Makes the light a light field that is a product: the radiance of a texel into a direction is the texel's times
    /// the profile's value for that unit direction of the world, which leaves the light.
    ///
    /// Any light field is a sum of such products, to any accuracy: so many lights at one place. Where the profile is
    /// not finite nothing leaves.
    pub fn set_profile(&mut self, profile: impl Fn(&Vector3<f64>) -> f64 + Send + Sync + 'static) {
        self.profile = Some(Profile(Arc::new(profile)));
    }

    /// The same radiance leaves in all directions again.
    pub fn clear_profile(&mut self) {
        self.profile = None;
    }

    /// Whether radiance depends on the direction.
    pub fn has_profile(&self) -> bool {
        self.profile.is_some()
    }

    /// The share of the radiance that leaves in a unit direction of the world: 1 without a profile.
    pub fn profile(&self, direction: &Vector3<f64>) -> f64 {
        let share = self.profile.as_ref().map_or(1.0, |profile| profile.0(direction));
        if share.is_finite() { share } else { 0.0 }
    }

    /// The middle, in world coordinates.
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// The lengths of its edges.
    pub fn size(&self) -> [f64; 2] {
        self.size
    }

    /// The angle from the frame's tangent to the texture's rows.
    pub fn rotation(&self) -> f64 {
        self.rotation
    }

    /// Columns and rows of the texture.
    pub fn texture_size(&self) -> [usize; 2] {
        [self.width, self.texture.len() / self.width]
    }

    /// The texture, row after row, as it was given.
    pub fn texture(&self) -> &[Vector3<f32>] {
        &self.texture
    }

    /// The mask; empty if there is none.
    pub fn mask(&self) -> &[f32] {
        &self.mask
    }

    /// The radiance of a texel, through the mask.
    ///
    /// # Panics
    /// If there is no such texel.
    #[track_caller]
    #[inline]
    pub fn radiance(&self, texel: usize) -> Vector3<f32> {
        let radiance = self.texture[texel];
        if self.mask.is_empty() { radiance } else { radiance * self.mask[texel] }
    }

    /// The upright rectangle around the light: its lengths along the tangent and the bitangent.
    pub fn extent(&self) -> [f64; 2] {
        self.placement().extent()
    }

    /// The mean radiance in each of `side`² cells of the [`extent`](Self::extent), a plane a channel, row-major: the
    /// signal F whose affine maps are the light at each vertex.
    ///
    /// Areas of overlap are exact, so that energy is kept whatever the sizes of texture and grid, turned or not.
    ///
    /// # Panics
    /// If `side` is 0.
    #[track_caller]
    pub fn pixels(&self, side: usize) -> [Vec<f32>; 3] {
        let mut planes = [(); 3].map(|()| vec![0.0; side * side]);
        self.write_pixels(side, planes.each_mut().map(Vec::as_mut_slice));
        planes
    }

    /// [`pixels`](Self::pixels) into memory that is there.
    ///
    /// # Panics
    /// If `side` is 0 or a plane has another length than `side`².
    #[track_caller]
    pub fn write_pixels(&self, side: usize, out: [&mut [f32]; 3]) {
        assert!(side > 0, "a grid needs cells");
        for plane in &out {
            crate::error::check_length("pixels of a light", side * side, plane.len());
        }
        self.placement().resample(self.texture_size(), |texel| self.radiance(texel), side, out);
    }

    /// How the light lies over a top face at `position` in the frame: coordinate w ∈ [0, 1]² of the face sees the point
    /// s w + o of the light's extent.
    ///
    /// ```math
    /// s = z size/W,  o = ½ − (x + z size/2)/W                                         [Sun 2008, eq. 4.34]
    /// ```
    ///
    /// for each axis, with z the height of the light above the point, x its centre seen from there and W its extent.
    ///
    /// `None` where no light arrives: in the light's plane and behind it (z ≤ 0), and so far off that the numbers leave
    /// the range of [`AffineMap`]. Just below the light s goes to 0, and the face sees one point of it.
    pub fn maps(&self, face: &TopFace, frame: &LocalFrame, position: &Vector3<f64>) -> Option<[AffineMap; 2]> {
        let to = frame.to_local(&(self.centre - position));
        place(face.size(), self.extent(), &to)
    }

    /// The same light for ground truth, as it is: turned rather than resampled.
    ///
    /// # Errors
    /// Those of [`RectangleLight::new`], for a frame whose axes are not orthonormal.
    pub fn to_local_light(&self, frame: &LocalFrame) -> Result<LocalLight> {
        let turn = Rotation2::new(self.rotation);
        let world = |v: Vector2<f64>| frame.to_world(&(turn * v).push(0.0));
        let half = self.size.map(|w| 0.5 * w);
        // Rows run along −bitangent there, so that u × v points down.
        let (half_u, half_v) = (world(Vector2::new(half[0], 0.0)), world(Vector2::new(0.0, -half[1])));
        let [width, height] = self.texture_size();
        if self.has_profile() {
            let light = self.clone();
            let radiance = move |[s, t]: [f64; 2], direction: &Vector3<f64>| {
                let texel = |s: f64, n: usize| ((s * n as f64) as usize).min(n - 1);
                let (x, y) = (texel(s, width), texel(1.0 - t, height));
                light.radiance(y * width + x).cast() * light.profile(direction)
            };
            return Ok(LocalLight::Field(LightField::new(self.centre, half_u, half_v, radiance)?));
        }
        let rows = (0..height).rev().flat_map(|y| (0..width).map(move |x| y * width + x));
        let texture = rows.map(|texel| self.radiance(texel)).collect();
        Ok(LocalLight::Rectangle(RectangleLight::new(self.centre, half_u, half_v, width, texture)?))
    }

    pub(super) fn placement(&self) -> Placement {
        Placement { size: self.size, rotation: self.rotation }
    }
}

/// The maps of a light of an extent whose centre lies at `to` from the point.
pub(super) fn place(face_size: f64, extent: [f64; 2], to: &Vector3<f64>) -> Option<[AffineMap; 2]> {
    if !(to.z > 0.0) {
        return None;
    }
    let map = |axis: usize| {
        let reach = to.z * face_size;
        AffineMap::new(reach / extent[axis], 0.5 - (to[axis] + 0.5 * reach) / extent[axis]).ok()
    };
    Some([map(0)?, map(1)?])
}

fn check_texture(texture: &[Vector3<f32>]) -> Result<()> {
    match texture.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        Some(index) => Err(Error::NotFinite { what: "texel of a light", index }),
        None => Ok(()),
    }
}

fn check_centre(centre: &Vector3<f64>) -> Result<()> {
    match centre.iter().position(|c| !c.is_finite()) {
        Some(index) => Err(Error::NotFinite { what: "centre of a light", index }),
        None => Ok(()),
    }
}

fn check_size(size: [f64; 2]) -> Result<()> {
    match size.into_iter().find(|w| !(*w > 0.0 && w.is_finite())) {
        Some(got) => Err(Error::OutOfRange { what: "size of a light", got, allowed: "positive and finite" }),
        None => Ok(()),
    }
}
