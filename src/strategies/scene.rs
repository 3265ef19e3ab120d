//! Strategies for [`scene`](crate::scene).

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

use crate::scene::{
    AshikhminShirley, BlinnPhong, Brdf, CookTorrance, Directions, Lambert, LocalFrame, Mesh, Phong, Procedural, Sum,
    Viewpoint, Ward,
};
use crate::sphere::{CubeGrid, TopFace};

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

/// A frame in any orientation.
pub fn local_frame() -> impl Strategy<Value = LocalFrame> {
    (super::sphere::direction(), 0.0..std::f64::consts::TAU).prop_map(|(normal, angle)| {
        let frame = LocalFrame::around(&normal);
        let (s, c) = (angle.sin() as f32, angle.cos() as f32);
        let tangent = frame.tangent * c + frame.bitangent * s;
        LocalFrame { tangent, bitangent: frame.normal.cross(&tangent), normal: frame.normal }
    })
}

/// A viewpoint within [−2, 2]³, with and without a frame, with and without a horizon: a normal of its own or that of
/// its frame.
pub fn viewpoint() -> impl Strategy<Value = Viewpoint> {
    let position = prop::array::uniform3(-2.0..2.0_f64).prop_map(Vector3::from);
    let horizon = prop_oneof![Just(None), super::sphere::direction().prop_map(Some)];
    (position, prop::option::of(local_frame()), horizon, any::<bool>()).prop_map(|(position, frame, horizon, own)| {
        let at = Viewpoint::new(position).expect("finite");
        let at = frame.map_or(at, |frame| at.with_frame(frame).expect("orthonormal"));
        let horizon = frame.filter(|_| own).map(|frame| frame.normal.cast()).or(horizon.map(|n| n.into_inner()));
        horizon.map_or(at, |normal| at.with_horizon(normal).expect("finite"))
    })
}

/// Directions of any kind: cubes, disks, squares, top faces, lists; 1 to 300 elements.
pub fn directions() -> impl Strategy<Value = Directions> {
    let list = prop::collection::vec(super::sphere::direction(), 1..100);
    prop_oneof![
        (1..8_usize).prop_map(|side| Directions::cube(CubeGrid::new(side).expect("in range"))),
        (1..17_usize).prop_map(|cells| Directions::disk(cells).expect("in range")),
        (1..17_usize).prop_map(|cells| Directions::square(cells).expect("in range")),
        (0.1..12.0_f64, 1..17_usize)
            .prop_map(|(size, cells)| Directions::top_face(TopFace::new(size, cells).expect("in range"))),
        list.prop_map(|list| Directions::list(list).expect("finite and not empty")),
    ]
}

/// A [`triangle_soup`] with texture coordinates between −1 and 2, or all the same, or on a line.
pub fn textured_soup(faces: usize) -> impl Strategy<Value = Mesh> {
    let shape = prop_oneof![4 => Just([1.0_f32, 1.0]), 1 => Just([1.0, 0.0]), 1 => Just([0.0, 0.0])];
    let pairs = prop::collection::vec(prop::array::uniform2(-1.0_f32..2.0), faces.max(2) * 2);
    (triangle_soup(faces), pairs, shape).prop_map(|(mesh, pairs, shape)| {
        let pair = |[u, v]: [f32; 2]| Vector2::new(u * shape[0], v * shape[1]);
        let uv = pairs.into_iter().take(mesh.positions().len()).map(pair).collect();
        mesh.with_uv(uv).expect("as many finite pairs as vertices")
    })
}

/// Any of the built-in scenes.
pub fn procedural() -> impl Strategy<Value = Procedural> {
    prop::sample::select(Procedural::ALL.to_vec())
}

/// A reflectance in RGB: any, grey, white, black, or of one channel.
fn albedo() -> impl Strategy<Value = Vector3<f64>> {
    prop_oneof![
        3 => prop::array::uniform3(0.0..=1.0_f64).prop_map(Vector3::from),
        1 => (0.0..=1.0_f64).prop_map(Vector3::repeat),
        1 => Just(Vector3::repeat(1.0)),
        1 => Just(Vector3::zeros()),
        1 => (0..3_usize).prop_map(|channel| Vector3::ith(channel, 1.0)),
    ]
}

fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => (0.0..14.0_f64).prop_map(f64::exp2),
        1 => 0.0..1.0_f64,
        1 => prop::sample::select(vec![0.0, 1.0, 1e7]),
    ]
}

fn roughness() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => (-7.0..0.0_f64).prop_map(f64::exp2),
        1 => 0.99..=1.0_f64,
        1 => prop::sample::select(vec![1e-4, 1.0]),
    ]
}

/// α along the tangent and the bitangent, equal half of the time.
fn roughnesses() -> impl Strategy<Value = (f64, f64)> {
    (roughness(), roughness(), any::<bool>()).prop_map(|(x, y, is_equal)| (x, if is_equal { x } else { y }))
}

/// Any model of [`scene`](crate::scene) that is given by numbers, or a weighted sum of one to three of them, sums among
/// them. All are reciprocal.
///
/// Exponents of 0, below 1, 1, up to 2^14 and the largest, 1e7; roughness of 1e-4, the smallest, near 1 and 1, the same
/// in both directions or not; colours that are any, grey, white, black or of one channel; weights of a sum from 0 to 2.
pub fn brdf() -> BoxedStrategy<Arc<dyn Brdf>> {
    fn shared(brdf: crate::Result<impl Brdf + 'static>) -> Arc<dyn Brdf> {
        Arc::new(brdf.expect("the strategy stays in range"))
    }
    let ashikhmin = (albedo(), albedo(), exponent(), exponent());
    let model = prop_oneof![
        1 => albedo().prop_map(|c| shared(Lambert::new(c))),
        2 => (albedo(), exponent()).prop_map(|(c, n)| shared(Phong::new(c, n))),
        2 => (albedo(), exponent()).prop_map(|(c, n)| shared(BlinnPhong::new(c, n))),
        2 => (albedo(), roughnesses()).prop_map(|(c, (x, y))| shared(Ward::new(c, x, y))),
        2 => (albedo(), roughnesses()).prop_map(|(c, (x, y))| shared(CookTorrance::new(c, x, y))),
        2 => ashikhmin.prop_map(|(d, s, u, v)| shared(AshikhminShirley::new(d, s, u, v))),
    ];
    let weight = prop_oneof![3 => 0.0..=2.0_f64, 1 => Just(0.0), 1 => Just(1.0)];
    model
        .prop_recursive(2, 9, 3, move |term| {
            prop::collection::vec((weight.clone(), term), 1..=3).prop_map(|terms| shared(Sum::new(terms)))
        })
        .boxed()
}
