//! What stops rays.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::scene::bvh::FARTHEST_ORIGIN;
use crate::scene::{BackFaces, Bvh, Hit, Mesh};
use crate::{Error, Result};

/// The geometry that rays are traced against: one mesh, or objects that stand anywhere in a world.
///
/// Single rays try the objects one after the other, those whose ball they miss excepted: hundreds of objects, not
/// thousands. An object is a hierarchy and a rigid pose, so that it moves without being built again and one mesh can
/// stand in many places. A mesh's [`origin`](Mesh::origin) is not looked at: poses move positions as they are.
///
/// # Example
/// ```
/// use std::sync::Arc;
/// use haarmonic::{nalgebra::{Isometry3, Vector3}, scene::{Bvh, Occluders, Procedural}};
/// let ball = Arc::new(Bvh::new(&Procedural::StackedSpheres.build(1000)?.mesh));
/// let poses = [0.0, 10.0].map(|x| Isometry3::translation(x, 0.0, 0.0));
/// let pair = Occluders::new(poses.map(|pose| (Arc::clone(&ball), pose)))?;
/// let down = pair.closest_hit(&Vector3::new(10.0, 50.0, 0.0), &-Vector3::y()).unwrap();
/// assert_eq!(down.0, 1); // the second object
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Occluders {
    objects: Vec<Object>,
    back_faces: BackFaces,
}

#[derive(Debug, Clone)]
struct Object {
    bvh: Arc<Bvh>,
    pose: Isometry3<f64>,
    /// World to object; `None` if the object is not turned.
    turn: Option<Matrix3<f64>>,
    /// Centre, in the world, and radius of a ball around it.
    ball: (Vector3<f64>, f64),
}

/// An object as one origin sees it.
pub(super) struct Sight<'a> {
    pub(super) bvh: &'a Bvh,
    /// In the object's world and scale.
    pub(super) origin: [f32; 3],
    /// World to object; `None` if the object is not turned.
    pub(super) turn: Option<&'a Matrix3<f64>>,
}

impl Occluders {
    /// Objects and where they stand: world = pose · position.
    ///
    /// # Errors
    /// [`Error::Empty`] without one, [`Error::NotFinite`] for a pose with NaN or ∞ (the index is the object's).
    pub fn new(objects: impl IntoIterator<Item = (Arc<Bvh>, Isometry3<f64>)>) -> Result<Self> {
        let mut all = Self { objects: vec![], back_faces: BackFaces::default() };
        for (index, (bvh, pose)) in objects.into_iter().enumerate() {
            all.objects.push(Object::new(bvh, pose, index)?);
        }
        if all.objects.is_empty() { Err(Error::Empty { what: "list of occluders" }) } else { Ok(all) }
    }

    /// One mesh where it is.
    ///
    /// Cost: that of [`Bvh::new`].
    pub fn of_mesh(mesh: &Mesh) -> Self {
        Self::of_bvh(Arc::new(Bvh::new(mesh)))
    }

    pub(super) fn of_bvh(bvh: Arc<Bvh>) -> Self {
        let ball = bvh.ball();
        let object = Object { bvh, pose: Isometry3::identity(), turn: None, ball };
        Self { objects: vec![object], back_faces: BackFaces::default() }
    }

    /// The same with another treatment of back faces.
    #[must_use]
    pub fn with_back_faces(self, back_faces: BackFaces) -> Self {
        Self { back_faces, ..self }
    }

    /// One of the objects alone, where it stands.
    ///
    /// # Panics
    /// If there is no such object.
    #[must_use]
    #[track_caller]
    pub fn only(&self, object: usize) -> Self {
        Self { objects: vec![self.objects[object].clone()], back_faces: self.back_faces }
    }

    /// Moves an object.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for NaN or ∞; the object then stays.
    ///
    /// # Panics
    /// If there is no such object.
    #[track_caller]
    pub fn set_pose(&mut self, object: usize, pose: Isometry3<f64>) -> Result<()> {
        self.objects[object] = Object::new(Arc::clone(&self.objects[object].bvh), pose, object)?;
        Ok(())
    }

    /// How many objects there are.
    #[expect(clippy::len_without_is_empty, reason = "there is an object")]
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Where an object stands.
    ///
    /// # Panics
    /// If there is no such object.
    #[track_caller]
    pub fn pose(&self, object: usize) -> Isometry3<f64> {
        self.objects[object].pose
    }

    /// An object's hierarchy.
    ///
    /// # Panics
    /// If there is no such object.
    #[track_caller]
    pub fn bvh(&self, object: usize) -> &Arc<Bvh> {
        &self.objects[object].bvh
    }

    /// How back faces are treated by maps of visibility. Single rays meet both sides.
    pub fn back_faces(&self) -> BackFaces {
        self.back_faces
    }

    /// The object that a ray meets first, and where: as [`Bvh::closest_hit`], with distances in the world.
    pub fn closest_hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<(usize, Hit)> {
        let mut best: Option<(usize, Hit)> = None;
        for (index, bvh, origin, direction) in self.near(origin, direction) {
            if let Some(hit) = bvh.closest_hit(&origin, &direction)
                && best.is_none_or(|(_, nearest)| hit.distance < nearest.distance)
            {
                best = Some((index, hit));
            }
        }
        best
    }

    /// Whether a ray meets any object.
    pub fn any_hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> bool {
        self.any_hit_within(origin, direction, f64::INFINITY)
    }

    /// Whether a ray meets any object before a distance, in units of the direction's length.
    pub fn any_hit_within(&self, origin: &Vector3<f64>, direction: &Vector3<f64>, distance: f64) -> bool {
        self.near(origin, direction)
            .any(|(_, bvh, origin, direction)| bvh.any_hit_within(&origin, &direction, distance))
    }

    /// The objects whose ball a ray comes near: number, hierarchy, and the ray in the object's world.
    fn near(
        &self,
        origin: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> impl Iterator<Item = (usize, &Bvh, Vector3<f64>, Vector3<f64>)> {
        let near = |object: &Object| object.may_meet(origin, direction);
        self.objects.iter().enumerate().filter(move |(_, object)| near(object)).map(|(index, object)| {
            let (origin, direction) = object.ray(origin, direction);
            (index, &*object.bvh, origin, direction)
        })
    }

    /// The objects as seen from a point of the world, without those too far away to be seen.
    pub(super) fn sights(&self, position: Vector3<f64>) -> impl Iterator<Item = Sight<'_>> {
        self.objects.iter().filter_map(move |object| {
            let local = if object.turn.is_none() {
                position - object.pose.translation.vector
            } else {
                object.pose.inverse_transform_point(&position.into()).coords
            };
            let origin = <[f64; 3]>::from(local * object.bvh.scale()).map(|c| c as f32);
            // Seen from so far away the object is smaller than any cell.
            let is_near = origin.iter().all(|c| c.abs() < FARTHEST_ORIGIN);
            is_near.then_some(Sight { bvh: &object.bvh, origin, turn: object.turn.as_ref() })
        })
    }

    /// How many entries a walk's stack can hold at most.
    pub(super) fn stack_len(&self) -> usize {
        self.objects.iter().map(|object| object.bvh.stack_len()).max().unwrap_or(0)
    }
}

impl Object {
    fn new(bvh: Arc<Bvh>, pose: Isometry3<f64>, index: usize) -> Result<Self> {
        if !pose.to_homogeneous().iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "pose of an occluder", index });
        }
        let turn = pose.rotation.to_rotation_matrix().inverse().into_inner();
        let turn = (turn != Matrix3::identity()).then_some(turn);
        let (centre, radius) = bvh.ball();
        let centre = (pose * nalgebra::Point3::from(centre)).coords;
        // Poses round: by a few roundings of where the object is.
        let ball = (centre, radius + 1e-12 * (centre.norm() + radius.abs()));
        Ok(Self { bvh, pose, turn, ball })
    }

    /// Whether a ray comes near enough; true where rounding hides it.
    fn may_meet(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> bool {
        let (centre, radius) = self.ball;
        let to = centre - origin;
        let (along, length, away) = (to.dot(direction), direction.norm_squared(), to.norm_squared());
        // Distance² of the ray's line from the centre times the direction's; the differences of large numbers.
        let across = away * length - along * along;
        let near = across <= radius * radius * length + 1e-12 * away * length;
        let is_ahead = along > 0.0 || away <= radius * radius * (1.0 + 1e-12);
        // NaN and overflow are the hierarchy's to judge.
        radius >= 0.0 && (near && is_ahead || !across.is_finite() || length < 1e-280)
    }

    /// A ray in the object's world.
    fn ray(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let inverse = self.pose.inverse();
        ((inverse * nalgebra::Point3::from(*origin)).coords, inverse.rotation * direction)
    }
}
