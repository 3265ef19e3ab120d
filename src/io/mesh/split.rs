//! Vertices that stand for several: one for each normal, smoothing group or side of a surface.

use std::collections::HashMap;
use std::hash::Hash;

use nalgebra::Vector3;

/// Gives each pair of a vertex and a key a vertex of its own. The first key of a vertex keeps it.
#[derive(Debug)]
pub(super) struct Splitter<K> {
    first: Vec<Option<K>>,
    /// The newest copy of each vertex.
    newest: Vec<u32>,
    copies: HashMap<(u32, K), u32>,
    /// The vertices that the new ones, from the end of the old ones on, are copies of, and the keys.
    sources: Vec<u32>,
    keys: Vec<K>,
}

impl<K: Copy + Eq + Hash> Splitter<K> {
    pub(super) fn new(vertices: usize) -> Self {
        let newest = (0..vertices as u32).collect();
        Self { first: vec![None; vertices], newest, copies: HashMap::new(), sources: Vec::new(), keys: Vec::new() }
    }

    /// The vertex that stands for `vertex` with this key.
    pub(super) fn vertex(&mut self, vertex: u32, key: K) -> u32 {
        if let Some(known) = self.known(vertex, key) {
            return known;
        }
        if let Some(&copy) = self.copies.get(&(vertex, key)) {
            return copy;
        }
        let copy = self.push(vertex, key);
        self.copies.insert((vertex, key), copy);
        copy
    }

    /// The same for a key that does not come again at a vertex once another one has.
    pub(super) fn vertex_in_order(&mut self, vertex: u32, key: K) -> u32 {
        self.known(vertex, key).unwrap_or_else(|| self.push(vertex, key))
    }

    /// The vertex, if the key is its first or its newest.
    fn known(&mut self, vertex: u32, key: K) -> Option<u32> {
        let first = *self.first[vertex as usize].get_or_insert(key);
        let newest = self.newest[vertex as usize];
        if first == key {
            return Some(vertex);
        }
        (newest != vertex && self.keys[newest as usize - self.first.len()] == key).then_some(newest)
    }

    fn push(&mut self, vertex: u32, key: K) -> u32 {
        let copy = (self.first.len() + self.sources.len()) as u32;
        self.sources.push(vertex);
        self.keys.push(key);
        self.newest[vertex as usize] = copy;
        copy
    }

    /// The vertices to copy, in order.
    pub(super) fn sources(&self) -> &[u32] {
        &self.sources
    }
}

/// Which faces share their normals at a vertex that the file gives none for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Smoothing {
    /// A face shares with no other: every corner has the face's own normal.
    Flat,
    /// Faces of the same group do.
    Group(i64),
}

/// The smoothing of faces, as ranges.
#[derive(Debug, Default)]
pub(super) struct SmoothingRuns(Vec<(usize, Smoothing)>);

impl SmoothingRuns {
    /// What the faces from `face` on have.
    pub(super) fn set(&mut self, face: usize, smoothing: Smoothing) {
        let before = self.0.pop_if(|(first, _)| *first == face).is_some();
        if before || self.0.last().is_none_or(|(_, last)| *last != smoothing) {
            self.0.push((face, smoothing));
        }
    }

    /// Whether all faces share normals.
    pub(super) fn is_uniform(&self) -> bool {
        self.0.is_empty()
    }

    /// The smoothing of faces that are asked for in ascending order.
    pub(super) fn in_order(&self) -> impl FnMut(usize) -> Option<Smoothing> {
        let mut next = 0;
        move |face| {
            while self.0.get(next).is_some_and(|(first, _)| *first <= face) {
                next += 1;
            }
            next.checked_sub(1).map(|i| self.0[i].1)
        }
    }
}

/// Whether a normal gives a direction.
pub(super) fn is_given(normal: &Vector3<f32>) -> bool {
    normal.iter().all(|c| c.is_finite()) && *normal != Vector3::zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs() {
        let mut runs = SmoothingRuns::default();
        runs.set(3, Smoothing::Group(1));
        runs.set(3, Smoothing::Flat);
        runs.set(5, Smoothing::Flat);
        runs.set(9, Smoothing::Group(2));
        let mut at = runs.in_order();
        let found: Vec<_> = [0, 2, 3, 8, 9, 10].map(&mut at).into();
        let (flat, two) = (Some(Smoothing::Flat), Some(Smoothing::Group(2)));
        assert_eq!(found, [None, None, flat, flat, two, two]);
    }

    #[test]
    fn the_first_key_keeps_the_vertex() {
        let mut splitter = Splitter::new(2);
        let keys = [(0, 'a'), (1, 'b'), (0, 'b'), (0, 'a'), (1, 'a'), (0, 'b')];
        assert_eq!(keys.map(|(v, k)| splitter.vertex(v, k)), [0, 1, 2, 0, 3, 2]);
        assert_eq!(splitter.sources(), [0, 1]);
        let mut splitter = Splitter::new(2);
        let keys = [(0, 'a'), (1, 'a'), (0, 'a'), (0, 'b'), (1, 'b'), (0, 'b'), (0, 'c')];
        assert_eq!(keys.map(|(v, k)| splitter.vertex_in_order(v, k)), [0, 1, 0, 2, 3, 2, 4]);
    }
}
