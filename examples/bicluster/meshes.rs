//! One surface at several numbers of vertices.

use std::collections::{BTreeSet, HashMap};

use haarmonic::io;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Mesh, Procedural};

use crate::args::Args;
use crate::support::Failure;

/// The meshes to try, from small to large, and their name.
pub fn meshes(args: &Args) -> Result<(String, Vec<Mesh>), Failure> {
    let sizes = (0..args.sizes).rev().map(|k| args.vertices >> k);
    let Some(path) = &args.mesh else {
        let meshes: Result<Vec<Mesh>, _> =
            sizes.map(|n| Ok::<_, Failure>(Procedural::TorusKnotOnFloor.build(n)?.mesh)).collect();
        return Ok((Procedural::TorusKnotOnFloor.name().to_owned(), meshes?));
    };
    let mut mesh = io::load_mesh(path)?.value;
    let mut all: Vec<Mesh> = Vec::new();
    for size in sizes {
        mesh = refined(&mesh, size)?;
        if all.last().is_none_or(|last| last.positions().len() < mesh.positions().len()) {
            all.push(mesh.clone());
        }
    }
    Ok((path.file_name().unwrap_or_default().to_string_lossy().into_owned(), all))
}

/// Halves the longest edges until there are `vertices`; normals are made anew. Vertices are then numbered along a curve
/// through space, so that consecutive ones are near.
fn refined(mesh: &Mesh, vertices: usize) -> Result<Mesh, Failure> {
    let mut positions = mesh.positions().to_vec();
    let mut faces = mesh.faces().to_vec();
    let mut edges: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    let length = |p: &[Vector3<f32>], [a, b]: [u32; 2]| (p[a as usize] - p[b as usize]).norm().to_bits(); // ordered as numbers ≥ 0
    for (index, face) in faces.iter().enumerate() {
        sides(face).for_each(|edge| edges.entry(edge).or_default().push(index));
    }
    let mut longest: BTreeSet<(u32, [u32; 2])> = edges.keys().map(|&e| (length(&positions, e), e)).collect();
    while positions.len() < vertices {
        let Some((_, edge)) = longest.pop_last() else { break };
        let [a, b] = edge;
        let middle = positions.len() as u32;
        positions.push((positions[a as usize] + positions[b as usize]) / 2.0);
        for old in edges.remove(&edge).unwrap_or_default() {
            let new = faces.len();
            let mut half = faces[old];
            let tip = *half.iter().find(|v| !edge.contains(v)).expect("a face has three corners");
            half.iter_mut().filter(|v| **v == a).for_each(|v| *v = middle);
            faces[old].iter_mut().filter(|v| **v == b).for_each(|v| *v = middle);
            faces.push(half);
            // The old face keeps a, the new one b.
            let moved = [b.min(tip), b.max(tip)];
            edges.entry(moved).or_default().iter_mut().filter(|f| **f == old).for_each(|f| *f = new);
            edges.entry([tip, middle]).or_default().extend([old, new]);
            edges.entry([a, middle]).or_default().push(old);
            edges.entry([b, middle]).or_default().push(new);
            for edge in [[tip, middle], [a, middle], [b, middle]] {
                longest.insert((length(&positions, edge), edge));
            }
        }
    }
    Ok(Mesh::new(positions, faces).map(|mesh| in_space_order(&mesh))??)
}

fn sides(face: &[u32; 3]) -> impl Iterator<Item = [u32; 2]> {
    let face = *face;
    (0..3).map(move |i| [face[i].min(face[(i + 1) % 3]), face[i].max(face[(i + 1) % 3])])
}

/// Vertices in Morton order of their positions.
fn in_space_order(mesh: &Mesh) -> haarmonic::Result<Mesh> {
    let bounds = mesh.bounds();
    let longest = bounds.size().max();
    let code = |v: u32| {
        let at = (mesh.positions()[v as usize] - bounds.min).cast::<f64>() / longest.max(f64::MIN_POSITIVE);
        let cell = at.map(|c| (c * 1023.0) as u32);
        (0..10).fold(0u32, |code, bit| {
            (0..3).fold(code, |code, axis| code | ((cell[axis] >> bit & 1) << (3 * bit + axis as u32)))
        })
    };
    let mut order: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    order.sort_by_key(|&v| code(v));
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, &old)| place[old as usize] = new as u32);
    let positions = order.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let normals = order.iter().map(|&v| mesh.normals()[v as usize]).collect();
    let faces = mesh.faces().iter().map(|face| face.map(|v| place[v as usize])).collect();
    Mesh::with_normals(positions, normals, faces)
}
