//! What the tests of block products share: scenes, lights, visibility, lobes.

use std::sync::Arc;

use crate::support::{grid, noise};
use haarmonic::backend::block_product::{BlockLayout, Relighter, Settings, Transport};
use haarmonic::compress::ScanOrder;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    BinaryVisibility, Brdf, EnvironmentLight, Lobe, LocalFrame, Materials, Mesh, Sky, Structure, View,
};
use haarmonic::sphere::CubeMap;

pub const ORDERS: [ScanOrder; 3] = [ScanOrder::RowMajor, ScanOrder::Serpentine, ScanOrder::Hilbert];

pub fn layout(side: usize, block: usize, order: ScanOrder) -> BlockLayout {
    BlockLayout::new(grid(side), block, order).unwrap()
}

/// An eye that no vertex of a [`soup`] has at its horizon.
pub fn view() -> View {
    View::eye(Vector3::new(3.1, 4.3, -5.2)).unwrap()
}

/// Maps of every vertex from a predicate of vertex and flat texel.
pub fn visibility(side: usize, vertices: usize, sees: impl Fn(usize, usize) -> bool) -> BinaryVisibility {
    let (face, words) = (side * side, BinaryVisibility::words_per_face(grid(side)));
    BinaryVisibility::from_fn(grid(side), vertices, |vertex, bits| {
        for texel in (0..6 * face).filter(|&texel| sees(vertex, texel)) {
            bits[texel / face * words + texel % face / 64] |= 1 << (texel % face % 64);
        }
    })
}

/// Blocks of `block`² that are free, hidden, noise, or behind an edge, as a seed says.
pub fn patchwork(side: usize, block: usize, seed: usize) -> impl Fn(usize, usize) -> bool {
    move |vertex, texel| {
        let (face, y, x) = (texel / side / side, texel / side % side, texel % side);
        let along = side / block;
        let number = (face * along + y / block) * along + x / block;
        let state = noise(seed + 1000 * vertex + number);
        match state {
            s if s < 0.4 => true,
            s if s < 0.55 => false,
            s if s < 0.7 => noise(seed + vertex * 6 * side * side + texel) < 0.5,
            s => (x % block) as f64 * (s - 0.85) > ((y % block) as f64 - 0.4 * block as f64) * 0.1,
        }
    }
}

/// The same above the horizon of each vertex, and nothing below: as a baker leaves it.
pub fn above<'a>(mesh: &'a Mesh, side: usize, sees: impl Fn(usize, usize) -> bool + 'a) -> BinaryVisibility {
    let directions = grid(side).directions();
    let axes: Vec<Axes> = (0..mesh.positions().len()).map(|v| Axes::new(&mesh.local_frame(v))).collect();
    visibility(side, axes.len(), |v, texel| axes[v].normal().dot(&directions[texel]) > 0.0 && sees(v, texel))
}

/// An orthonormal frame in `f64` about a vertex's normal.
pub struct Axes([Vector3<f64>; 3]);

impl Axes {
    pub fn new(frame: &LocalFrame) -> Self {
        let (normal, tangent) = (frame.normal.cast::<f64>().normalize(), frame.tangent.cast::<f64>());
        let tangent = (tangent - normal * normal.dot(&tangent)).normalize();
        Self([tangent, normal.cross(&tangent), normal])
    }

    pub fn normal(&self) -> Vector3<f64> {
        self.0[2]
    }

    pub fn local(&self, world: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from(self.0.map(|axis| axis.dot(world)))
    }
}

/// ρ cos of one lobe, in local coordinates: f cos above the horizon and 0 below, but for Lambert and Phong, which go on
/// smoothly.
pub fn reflectance(brdf: &dyn Brdf, wi: &Vector3<f64>, wo: &Vector3<f64>) -> Vector3<f64> {
    match brdf.structure() {
        Structure::Lobe(Lobe::Lambert(_)) => brdf.eval(&Vector3::z(), wo) * wi.z,
        Structure::Lobe(Lobe::Phong(phong)) => {
            let cosine = wi.z * wo.z - wi.x * wo.x - wi.y * wo.y;
            let lobe = if cosine > 0.0 { cosine.min(1.0).powf(phong.exponent()) } else { 0.0 };
            phong.albedo() * ((phong.exponent() + 2.0) / std::f64::consts::TAU * lobe * wi.z)
        }
        _ if wi.z > 0.0 => brdf.eval(wi, wo) * wi.z,
        _ => Vector3::zeros(),
    }
}

pub fn sky(side: usize) -> CubeMap<Vector3<f32>> {
    of_sky(Sky::default(), side)
}

pub fn of_sky(sky: Sky, side: usize) -> CubeMap<Vector3<f32>> {
    EnvironmentLight::from_sky(sky).unwrap().to_cube(grid(side))
}

/// Darkness but for one texel.
pub fn one_texel(side: usize, texel: usize) -> CubeMap<Vector3<f32>> {
    let mut light = CubeMap::new(grid(side), vec![Vector3::zeros(); grid(side).len()]).unwrap();
    light.texels_mut()[texel] = Vector3::new(900.0, 700.0, 400.0);
    light
}

pub fn constant(side: usize, radiance: f32) -> CubeMap<Vector3<f32>> {
    CubeMap::new(grid(side), vec![Vector3::repeat(radiance); grid(side).len()]).unwrap()
}

/// The mean radiance of the brightest channel.
pub fn mean(light: &CubeMap<Vector3<f32>>) -> f64 {
    light.map(|l| l.abs()).integral().max() / (4.0 * std::f64::consts::PI)
}

/// One material after the other, vertex by vertex.
pub fn in_turn(brdfs: &[Arc<dyn Brdf>], vertices: usize) -> Materials {
    Materials::new(brdfs.to_vec(), (0..vertices as u32).map(|v| v % brdfs.len() as u32).collect()).unwrap()
}

/// A frame of a relighter made for it.
pub fn frame(
    (mesh, transport): (&Mesh, &Transport),
    settings: Settings,
    light: &CubeMap<Vector3<f32>>,
    view: &View,
    materials: &Materials,
) -> Vec<Vector3<f32>> {
    let mut relighter = Relighter::new(mesh, transport, settings).unwrap();
    relighter.set_light(light).unwrap();
    // What must be overwritten.
    let mut out = vec![Vector3::repeat(f32::NAN); mesh.positions().len()];
    relighter.relight(view, materials, &mut out).unwrap();
    out
}

/// A shared BRDF.
pub fn lobe(brdf: impl Brdf + 'static) -> Arc<dyn Brdf> {
    Arc::new(brdf)
}

/// What a BRDF is the weighted sum of, sums of sums included.
pub fn terms(brdf: &dyn Brdf) -> Vec<(f64, &dyn Brdf)> {
    match brdf.structure() {
        Structure::Sum(terms) => terms
            .iter()
            .flat_map(|(weight, term)| self::terms(term.as_ref()).into_iter().map(move |(w, b)| (weight * w, b)))
            .collect(),
        _ => vec![(1.0, brdf)],
    }
}
