//! Polygons that are there twice, once each way round: a surface with two sides that share their vertices.
//!
//! The normals of its faces cancel at every vertex, and what is left of their sum is rounding. Each side gets vertices
//! of its own. Which of two opposite faces is on which side is decided around each vertex: faces that share an edge
//! there and run along it in opposite directions are on the same side.

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::Vector3;

/// For each vertex, the first one at the same place (+0 and −0 are one).
pub(super) fn weld(positions: &[Vector3<f32>]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    let bits = |p: &Vector3<f32>| [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
    positions.iter().zip(0..).map(|(p, i)| *first.entry(bits(p)).or_insert(i)).collect()
}

/// The items in the order of their keys, which are below `keys`, those of the same key in their own order; and where
/// each key begins.
pub(super) fn buckets(keys: usize, items: usize, key: impl Fn(u32) -> u32) -> (Vec<u32>, Vec<usize>) {
    let mut starts = vec![0; keys + 1];
    (0..items as u32).for_each(|i| starts[key(i) as usize + 1] += 1);
    (0..keys).for_each(|k| starts[k + 1] += starts[k]);
    let mut next = starts.clone();
    let mut order = vec![0; items];
    for i in 0..items as u32 {
        let at = &mut next[key(i) as usize];
        order[*at] = i;
        *at += 1;
    }
    (order, starts)
}

/// The corners of a polygon that was cut as the fan of triangles `faces[range]`, or what is stored for them.
pub(super) fn corners<'a, T: Copy>(faces: &'a [[T; 3]], range: &Range<usize>) -> impl Iterator<Item = T> + 'a {
    let fan = &faces[range.clone()];
    fan.first().into_iter().flat_map(|f| [f[0], f[1]]).chain(fan.iter().map(|f| f[2]))
}

/// A polygon among those that have the same corners in the same order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Twin {
    /// The first polygon with these corners, either way round.
    pub(super) first: u32,
    /// Whether this one runs the other way than the first.
    pub(super) reversed: bool,
    /// Whether they are there both ways round.
    pub(super) both_ways: bool,
}

/// Finds the polygons that are there more than once, by their welded corners.
pub(super) fn twins(polygons: &[Range<usize>], faces: &[[u32; 3]], welded: &[u32]) -> Vec<Twin> {
    let mut ids: Vec<u32> = Vec::with_capacity(faces.len() + 2 * polygons.len());
    // Where a polygon's corners are, and whether they were turned round to begin at the smallest and go on to the
    // smaller of its neighbours.
    let keys: Vec<(Range<usize>, bool)> = (polygons.iter())
        .map(|range| {
            let start = ids.len();
            ids.extend(corners(faces, range).map(|i| welded[i as usize]));
            let key = &mut ids[start..];
            let least = (0..key.len()).min_by_key(|&i| key[i]).unwrap_or(0);
            key.rotate_left(least);
            let reversed = key.last() < key.get(1);
            if reversed {
                key[1..].reverse();
            }
            (start..ids.len(), reversed)
        })
        .collect();
    let key = |p: u32| &ids[keys[p as usize].0.clone()];
    let mut twins = vec![Twin { first: 0, reversed: false, both_ways: false }; polygons.len()];
    let (mut order, starts) = buckets(welded.len(), polygons.len(), |p| key(p)[0]);
    for bucket in starts.windows(2) {
        let bucket = &mut order[bucket[0]..bucket[1]];
        bucket.sort_unstable_by(|&a, &b| key(a).cmp(key(b)).then(a.cmp(&b)));
        for group in bucket.chunk_by(|&a, &b| key(a) == key(b)) {
            let way = |p: u32| keys[p as usize].1;
            let both_ways = group.iter().any(|&p| way(p) != way(group[0]));
            for &p in group {
                twins[p as usize] = Twin { first: group[0], reversed: way(p) != way(group[0]), both_ways };
            }
        }
    }
    twins
}

/// One corner of a polygon, as seen from its vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub(super) polygon: u32,
    /// The welded corners before and after.
    pub(super) before: u32,
    pub(super) after: u32,
}

/// The sides of the corners around one vertex: a key each, equal for those that share a side.
pub(super) fn sides(around: &[Corner], twins: &[Twin]) -> Vec<(u32, bool)> {
    // One node for each set of twins, directed as its first polygon.
    let twin = |c: &Corner| twins[c.polygon as usize];
    let mut nodes: Vec<(u32, u32, u32)> = (around.iter())
        .map(|c| match twin(c).reversed {
            false => (twin(c).first, c.before, c.after),
            true => (twin(c).first, c.after, c.before),
        })
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    // The edges at the vertex: the corner at their other end, the node, whether the edge leads away.
    let mut edges: Vec<(u32, u32, bool)> =
        nodes.iter().zip(0..).flat_map(|(&(_, before, after), n)| [(before, n, false), (after, n, true)]).collect();
    edges.sort_unstable();
    let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::new(); nodes.len()];
    for pair in edges.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() == 2) {
        let (a, b) = (pair[0], pair[1]);
        neighbours[a.1 as usize].push((b.1, a.2 == b.2));
        neighbours[b.1 as usize].push((a.1, a.2 == b.2));
    }
    let mut found: Vec<Option<(u32, bool)>> = vec![None; nodes.len()];
    for start in 0..nodes.len() {
        if found[start].is_some() {
            continue;
        }
        found[start] = Some((start as u32, false));
        let mut stack = vec![start];
        while let Some(n) = stack.pop() {
            let Some((sheet, turned)) = found[n] else { continue };
            for &(m, against) in &neighbours[n] {
                if found[m as usize].is_none() {
                    found[m as usize] = Some((sheet, turned != against));
                    stack.push(m as usize);
                }
            }
        }
    }
    (around.iter())
        .map(|c| {
            let node = nodes.partition_point(|n| n.0 < twin(c).first);
            let (sheet, turned) = found[node].unwrap_or_default();
            (sheet, turned != twin(c).reversed)
        })
        .collect()
}
