//! Where a mesh stands: the transform of its node, and the instances of `EXT_mesh_gpu_instancing`.

use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3, Vector4};
use serde_json::Value;

use super::accessor::{Component, Elements, Shape};
use super::buffers::Buffers;
use super::document::{Object, extension, numbers, whole};

/// The transform of a node relative to its parent.
pub(super) fn local_transform(node: &Object) -> Result<Matrix4<f64>, String> {
    if let Some(m) = numbers::<16>(node, "matrix")? {
        return Ok(Matrix4::from_column_slice(&m));
    }
    let translation = numbers(node, "translation")?.unwrap_or_default();
    let rotation = numbers(node, "rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = numbers(node, "scale")?.unwrap_or([1.0; 3]);
    Ok(compose(translation.into(), rotation.into(), scale.into()))
}

/// Scales first, then turns by the quaternion (x, y, z, w), then moves. NaN if the quaternion is zero.
fn compose(translation: Vector3<f64>, rotation: Vector4<f64>, scale: Vector3<f64>) -> Matrix4<f64> {
    let rotation = UnitQuaternion::from_quaternion(Quaternion::from(rotation)).to_homogeneous();
    Matrix4::new_translation(&translation) * rotation * Matrix4::new_nonuniform_scaling(&scale)
}

/// The transforms of all instances of a node's mesh; `node_transform` alone if it is not instanced.
pub(super) fn transforms(
    buffers: &Buffers<'_>,
    node: &Object,
    node_transform: &Matrix4<f64>,
) -> Result<Vec<Matrix4<f64>>, String> {
    let Some(instancing) = extension(node, "EXT_mesh_gpu_instancing") else { return Ok(vec![*node_transform]) };
    let attributes =
        instancing.get("attributes").and_then(Value::as_object).ok_or("it has no object \"attributes\"")?;
    let elements = |name: &str, shape| {
        let Some(number) = attributes.get(name) else { return Ok(None) };
        let number = whole(number).ok_or_else(|| format!("{name}: is not an index of an accessor"))?;
        let at = |reason| format!("{name}: accessor {number}: {reason}");
        let elements = Elements::new(buffers, number, shape).map_err(at)?;
        match elements.component {
            Component::F32 => {}
            Component::I8 | Component::I16 if shape == Shape::Vec4 => {}
            _ => return Err(at("its component type is not allowed here".into())),
        }
        Ok(Some(elements))
    };
    let translation = elements("TRANSLATION", Shape::Vec3)?;
    let rotation = elements("ROTATION", Shape::Vec4)?;
    let scale = elements("SCALE", Shape::Vec3)?;
    let counts: Vec<usize> = [&translation, &rotation, &scale].into_iter().flatten().map(|e| e.count).collect();
    let count = *counts.first().ok_or("it has none of TRANSLATION, ROTATION, SCALE")?;
    if count == 0 {
        return Err("it has no instances".into());
    }
    // Zeros that take no bytes could stand for any number of copies in one place.
    if ![&translation, &rotation, &scale].into_iter().flatten().any(Elements::has_view) {
        return Err("none of its attributes has a buffer view".into());
    }
    if counts.iter().any(|c| *c != count) {
        return Err(format!("its attributes have different lengths: {counts:?}"));
    }
    (0..count)
        .map(|i| {
            let vector = |elements: &Option<Elements<'_>>, otherwise: f64| {
                elements.as_ref().map_or_else(|| Vector3::repeat(otherwise), |e| e.vector(i))
            };
            // The length of the quaternion is taken out, so integers do as well as the fractions they stand for.
            let rotation = rotation.as_ref().map_or(Vector4::w(), |e| Vector4::from_fn(|c, _| e.get(i, c)));
            let transform = node_transform * compose(vector(&translation, 0.0), rotation, vector(&scale, 1.0));
            let is_finite = transform.iter().all(|c| c.is_finite());
            is_finite.then_some(transform).ok_or_else(|| format!("instance {i}: its transform is NaN or infinite"))
        })
        .collect()
}
