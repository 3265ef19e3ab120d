//! A mesh of exactly so many vertices: the longest edges are halved, one vertex at a time.

use std::collections::{BinaryHeap, HashMap};

use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Mesh, Model};

use crate::support::Failure;

/// An edge by its length, then by its ends, so that the order is the same in every run.
type Long = (u64, [u32; 2]);

/// The model with `count` vertices, at least as many as it has.
pub fn refine(model: &Model, count: usize) -> Result<Model, Failure> {
    let mut positions = model.mesh.positions().to_vec();
    let mut normals = model.mesh.normals().to_vec();
    let mut parts = model.parts.clone();
    let mut faces = model.mesh.faces().to_vec();
    let key = |a: u32, b: u32| if a < b { [a, b] } else { [b, a] };
    let length = |p: &[Vector3<f32>], [a, b]: [u32; 2]| f64::from((p[a as usize] - p[b as usize]).norm()).to_bits();
    let mut around: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
    for (f, &[a, b, c]) in faces.iter().enumerate() {
        for edge in [key(a, b), key(b, c), key(c, a)] {
            around.entry(edge).or_default().push(f as u32);
        }
    }
    let mut heap: BinaryHeap<Long> = around.keys().map(|&edge| (length(&positions, edge), edge)).collect();
    while positions.len() < count {
        let Some((_, edge)) = heap.pop() else { return Err("a mesh without edges cannot be refined".into()) };
        let Some(sides) = around.remove(&edge) else { continue };
        let [a, b] = edge.map(|v| v as usize);
        let middle = positions.len() as u32;
        positions.push((positions[a] + positions[b]) * 0.5);
        normals.push((normals[a] + normals[b]).normalize());
        parts.push(parts[a]);
        for face in sides {
            let corners = faces[face as usize];
            let other = faces.len() as u32;
            let replaced = |from: u32| corners.map(|v| if v == from { middle } else { v });
            let (kept, added) = (replaced(edge[1]), replaced(edge[0]));
            faces[face as usize] = kept;
            faces.push(added);
            let apex = *corners.iter().find(|v| !edge.contains(v)).ok_or("a face without area")?;
            // What lay beside the face that was cut lies beside one of its halves.
            if let Some(beside) = around.get_mut(&key(edge[1], apex)) {
                beside.iter_mut().filter(|f| **f == face).for_each(|f| *f = other);
            }
            for (end, f) in [(edge[0], face), (edge[1], other)] {
                around.entry(key(end, middle)).or_default().push(f);
            }
            around.entry(key(apex, middle)).or_default().extend([face, other]);
            heap.push((length(&positions, key(apex, middle)), key(apex, middle)));
        }
        for end in edge {
            heap.push((length(&positions, key(end, middle)), key(end, middle)));
        }
    }
    let mesh = Mesh::with_normals(positions, normals, faces)?;
    Ok(Model { mesh, parts, ..model.clone() })
}
