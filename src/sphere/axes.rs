//! The axes of other programs' worlds.

use nalgebra::Vector3;

use crate::{Error, Result};

/// A direction along a coordinate axis.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SignedAxis {
    /// +x.
    PosX,
    /// −x.
    NegX,
    /// +y.
    PosY,
    /// −y.
    NegY,
    /// +z.
    PosZ,
    /// −z.
    NegZ,
}

impl SignedAxis {
    /// The coordinate (0, 1, 2 for x, y, z) and whether the direction is its negative one.
    const fn parts(self) -> (usize, bool) {
        match self {
            Self::PosX => (0, false),
            Self::NegX => (0, true),
            Self::PosY => (1, false),
            Self::NegY => (1, true),
            Self::PosZ => (2, false),
            Self::NegZ => (2, true),
        }
    }

    const fn of(coordinate: usize, negative: bool) -> Self {
        match (coordinate, negative) {
            (0, false) => Self::PosX,
            (0, true) => Self::NegX,
            (1, false) => Self::PosY,
            (1, true) => Self::NegY,
            (_, false) => Self::PosZ,
            (_, true) => Self::NegZ,
        }
    }
}

/// Another program's coordinate axes, seen from this crate's world (right-handed, y up).
///
/// Each of their axes lies along one of ours, forwards or backwards. Such a change of coordinates is exact: numbers
/// change places and signs. Between worlds of the same handedness it is a rotation, otherwise a rotation and a mirror;
/// what is on the left of a viewer stays there in both cases, because the viewer's coordinates change too.
///
/// Which of a program's horizontal axes is ours is a choice that importers and exporters make. The constants make the
/// one of glTF exporters where there is one, and say so.
///
/// # Example
/// ```
/// use haarmonic::{nalgebra::Vector3, sphere::Axes};
/// let blender = Axes::RIGHT_HANDED_Z_UP;
/// assert_eq!(blender.to_theirs(&Vector3::y()), Vector3::z());
/// assert_eq!(blender.to_ours(&Vector3::new(1.0, 2.0, 3.0)), Vector3::new(1.0, 3.0, -2.0));
/// ```
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "[SignedAxis; 3]", into = "[SignedAxis; 3]")
)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Axes([SignedAxis; 3]);

impl Default for Axes {
    fn default() -> Self {
        Self::RIGHT_HANDED_Y_UP
    }
}

impl Axes {
    /// This crate; glTF, three.js, Godot, Filament, Bevy. (x, y, z) stays as it is.
    pub const RIGHT_HANDED_Y_UP: Self = Self([SignedAxis::PosX, SignedAxis::PosY, SignedAxis::PosZ]);
    /// Blender. Our (x, y, z) is their (x, −z, y), as its glTF exporter has it.
    pub const RIGHT_HANDED_Z_UP: Self = Self([SignedAxis::PosX, SignedAxis::NegZ, SignedAxis::PosY]);
    /// Unity. Our (x, y, z) is their (x, y, −z): our cameras look along −z, theirs along +z.
    /// Importers that mirror x instead differ from this by a half turn about y.
    pub const LEFT_HANDED_Y_UP: Self = Self([SignedAxis::PosX, SignedAxis::PosY, SignedAxis::NegZ]);
    /// Unreal. Our (x, y, z) is their (x, z, y).
    pub const LEFT_HANDED_Z_UP: Self = Self([SignedAxis::PosX, SignedAxis::PosZ, SignedAxis::PosY]);
    /// Ambisonics: x forwards, y to the left, z up; ours look along −z. Our (x, y, z) is their (−z, −x, y).
    pub const AMBISONIC: Self = Self([SignedAxis::NegZ, SignedAxis::NegX, SignedAxis::PosY]);
    /// The world is ours, but the pole of the spherical harmonics is y: (x, y, z) becomes (z, x, y). e3nn.
    pub const POLE_Y: Self = Self([SignedAxis::PosZ, SignedAxis::PosX, SignedAxis::PosY]);

    /// Axes of your own: `theirs[i]` says along which of ours their axis i (0, 1, 2 for x, y, z) lies.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if two of them lie along the same line.
    pub fn new(theirs: [SignedAxis; 3]) -> Result<Self> {
        let mut seen = [false; 3];
        for (i, axis) in theirs.into_iter().enumerate() {
            let (coordinate, _) = axis.parts();
            if std::mem::replace(&mut seen[coordinate], true) {
                return Err(Error::OutOfRange {
                    what: "axis",
                    got: i as f64,
                    allowed: "at right angles to the others",
                });
            }
        }
        Ok(Self(theirs))
    }

    /// Along which of our axes theirs lie.
    #[inline]
    pub const fn theirs(self) -> [SignedAxis; 3] {
        self.0
    }

    /// The same vector in their coordinates.
    #[inline]
    pub fn to_theirs(self, ours: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|i, _| {
            let (coordinate, negative) = self.0[i].parts();
            if negative { -ours[coordinate] } else { ours[coordinate] }
        })
    }

    /// The same vector in our coordinates.
    #[inline]
    pub fn to_ours(self, theirs: &Vector3<f64>) -> Vector3<f64> {
        self.inverse().to_theirs(theirs)
    }

    /// The axes that undo these: what is ours there is theirs here.
    pub const fn inverse(self) -> Self {
        let mut inverse = self.0;
        let mut i = 0;
        while i < 3 {
            let (coordinate, negative) = self.0[i].parts();
            inverse[coordinate] = SignedAxis::of(i, negative);
            i += 1;
        }
        Self(inverse)
    }

    /// Whether their world has the other handedness than ours, so that a mirror is part of the change.
    pub const fn is_left_handed(self) -> bool {
        let [(x, a), (y, b), (z, c)] = [self.0[0].parts(), self.0[1].parts(), self.0[2].parts()];
        let odd = (x > y) as u8 + (x > z) as u8 + (y > z) as u8 + a as u8 + b as u8 + c as u8;
        odd % 2 == 1
    }

    /// For each of their axes, our coordinate and whether it is negated.
    pub(crate) fn parts(self) -> [(usize, bool); 3] {
        self.0.map(SignedAxis::parts)
    }
}

impl TryFrom<[SignedAxis; 3]> for Axes {
    type Error = Error;

    /// As [`new`](Axes::new).
    fn try_from(theirs: [SignedAxis; 3]) -> Result<Self> {
        Self::new(theirs)
    }
}

impl From<Axes> for [SignedAxis; 3] {
    fn from(axes: Axes) -> Self {
        axes.theirs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [SignedAxis; 6] =
        [SignedAxis::PosX, SignedAxis::NegX, SignedAxis::PosY, SignedAxis::NegY, SignedAxis::PosZ, SignedAxis::NegZ];

    #[test]
    fn all_48_are_orthogonal_and_know_their_inverse_and_hand() {
        let mut count = 0;
        for x in ALL {
            for y in ALL {
                for z in ALL {
                    let Ok(axes) = Axes::new([x, y, z]) else { continue };
                    count += 1;
                    let columns = [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| axes.to_theirs(&e));
                    let determinant = nalgebra::Matrix3::from_columns(&columns).determinant();
                    assert_eq!(determinant, if axes.is_left_handed() { -1.0 } else { 1.0 }, "{axes:?}");
                    let v = Vector3::new(1.0, -2.0, 3.5);
                    assert_eq!(axes.to_ours(&axes.to_theirs(&v)), v);
                    assert_eq!(axes.inverse().inverse(), axes);
                }
            }
        }
        assert_eq!(count, 48);
    }

    #[test]
    fn hands_of_the_named_axes() {
        for axes in [Axes::RIGHT_HANDED_Y_UP, Axes::RIGHT_HANDED_Z_UP, Axes::AMBISONIC, Axes::POLE_Y] {
            assert!(!axes.is_left_handed(), "{axes:?}");
        }
        for axes in [Axes::LEFT_HANDED_Y_UP, Axes::LEFT_HANDED_Z_UP] {
            assert!(axes.is_left_handed(), "{axes:?}");
        }
        for axes in [Axes::RIGHT_HANDED_Z_UP, Axes::LEFT_HANDED_Z_UP, Axes::AMBISONIC] {
            assert_eq!(axes.to_theirs(&Vector3::y()), Vector3::z(), "{axes:?}");
        }
        // Forwards of ours is +x of ambisonics, left of ours +y.
        assert_eq!(Axes::AMBISONIC.to_theirs(&-Vector3::z()), Vector3::x());
        assert_eq!(Axes::AMBISONIC.to_theirs(&-Vector3::x()), Vector3::y());
        assert_eq!(Axes::LEFT_HANDED_Y_UP.to_theirs(&-Vector3::z()), Vector3::z());
    }
}
