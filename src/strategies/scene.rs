//! Strategies for [`scene`](crate::scene).

use nalgebra::Vector3;
use proptest::prelude::*;

use crate::scene::{Mesh, Procedural};

/// A mesh of up to `faces` faces between random points: crossing, double and degenerate ones included.
///
/// Sizes of 1e-4, 1 and 1e4, off the origin by up to three times the size; shrinks towards few faces.
pub fn triangle_soup(faces: usize) -> impl Strategy<Value = Mesh> {
    let corners = prop::collection::vec(prop::array::uniform3(-1.0_f32..1.0), 3..faces.max(2) * 2);
    let picks = prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 1..=faces.max(1));
    let size = prop::sample::select(vec![1.0_f32, 1e-4, 1e4]);
    let shift = prop::array::uniform3(-3.0_f32..3.0);
    (corners, picks, size, shift).prop_map(|(corners, picks, size, shift)| {
        let n = corners.len();
        let positions = corners.into_iter().map(|c| (Vector3::from(c) + Vector3::from(shift)) * size).collect();
        let faces = picks.into_iter().map(|face| face.map(|i| i.index(n) as u32)).collect();
        Mesh::new(positions, faces).expect("finite positions and indices in range")
    })
}

/// Any of the built-in scenes.
pub fn procedural() -> impl Strategy<Value = Procedural> {
    prop::sample::select(Procedural::ALL.to_vec())
}
