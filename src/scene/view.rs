//! Where the viewer is.

use nalgebra::Vector3;

use super::{Brdf, LocalFrame};
use crate::approx_eq::approx_by_parts;
use crate::store::{Section, SectionReader};
use crate::{Error, Result};

/// Where the viewer is: at a point, or infinitely far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Eye(Vector3<f64>),
    Direction(Vector3<f64>),
}

impl View {
    /// A viewer at `eye` (perspective).
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a component is NaN or infinite.
    pub fn eye(eye: Vector3<f32>) -> Result<Self> {
        check_finite("eye point", &eye)?;
        Ok(Self { kind: Kind::Eye(eye.cast()) })
    }

    /// A viewer infinitely far away towards `direction`, of any length (orthographic).
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a component is NaN or infinite, [`Error::OutOfRange`] if the direction is zero.
    pub fn towards(direction: Vector3<f32>) -> Result<Self> {
        check_finite("view direction", &direction)?;
        match unit(&direction.cast()) {
            Some(direction) => Ok(Self { kind: Kind::Direction(direction) }),
            None => Err(Error::OutOfRange { what: "length of the view direction", got: 0.0, allowed: "positive" }),
        }
    }

    /// The unit direction from a surface point to the viewer, in world coordinates.
    ///
    /// Zero if the point is the eye itself: such a point is seen from nowhere, and every BRDF there is 0.
    #[inline]
    pub fn wo(&self, position: &Vector3<f32>) -> Vector3<f64> {
        match self.kind {
            Kind::Eye(eye) => unit(&(eye - position.cast::<f64>())).unwrap_or_else(Vector3::zeros),
            Kind::Direction(direction) => direction,
        }
    }
}

impl View {
    /// The direction in which the radiance of a vertex is asked for: to the viewer, or along the normal for a BRDF that
    /// does not depend on it, so that a diffuse vertex has its colour wherever it is seen from.
    #[inline]
    pub fn outgoing(&self, brdf: &dyn Brdf, position: &Vector3<f32>, frame: &LocalFrame) -> Vector3<f64> {
        if brdf.is_view_independent() { frame.normal.cast() } else { self.wo(position) }
    }
}

impl View {
    /// As numbers for a file: 1 and the eye point, or 2 and the unit direction.
    fn parts(self) -> (u8, [f64; 3]) {
        match self.kind {
            Kind::Eye(eye) => (1, eye.into()),
            Kind::Direction(direction) => (2, direction.into()),
        }
    }

    /// What [`parts`](Self::parts) gave; none for other numbers.
    fn from_parts(kind: u8, place: [f64; 3]) -> Option<Self> {
        let place = Vector3::from(place);
        let is_unit = (place.norm() - 1.0).abs() < 1e-12;
        match kind {
            1 if place.iter().all(|c| c.is_finite()) => Some(Self { kind: Kind::Eye(place) }),
            2 if is_unit => Some(Self { kind: Kind::Direction(place) }),
            _ => None,
        }
    }

    /// Writes a view, or that there is none, into a file.
    #[allow(dead_code, reason = "for those back ends whose files hold a view")]
    pub(crate) fn write(view: Option<Self>, to: &mut Section) {
        let (kind, place) = view.map_or((0, [0.0; 3]), Self::parts);
        to.field(kind);
        to.array(&place);
    }

    /// Reads what [`write`](Self::write) wrote.
    #[allow(dead_code, reason = "for those back ends whose files hold a view")]
    pub(crate) fn read(from: &mut SectionReader) -> Result<Option<Self>> {
        let (kind, place) = (from.field("a kind of view")?, from.array("a view", 3)?);
        match kind {
            0 if place.iter().all(|x: &f64| x.to_bits() == 0) => Ok(None),
            0 => Err(from.wrong("has the place of a view, but no view")),
            _ => match Self::from_parts(kind, [place[0], place[1], place[2]]) {
                None => Err(from.wrong("is no view")),
                view => Ok(view),
            },
        }
    }
}

/// Scaled by the largest component first, so that nothing overflows or underflows.
fn unit(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let scale = v.amax();
    (scale > 0.0).then(|| (v / scale).normalize())
}

fn check_finite(what: &'static str, v: &Vector3<f32>) -> Result<()> {
    match v.iter().position(|c| !c.is_finite()) {
        Some(index) => Err(Error::NotFinite { what, index }),
        None => Ok(()),
    }
}

approx_by_parts!([] View, f64, |v| close [v.parts().1] same [v.parts().0]);
