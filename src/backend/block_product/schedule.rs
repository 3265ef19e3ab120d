//! The maps once more, in the order in which frames sum them up.

use super::paths::Paths;
use super::visible::Visible;
use crate::parallel;

/// Vertices whose cosine sums are taken together: their number in a group is a byte.
pub(super) const GROUP: usize = 256;

/// Maps of as many changes each, one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Batch {
    /// Changes of each map.
    pub(super) changes: u16,
    pub(super) maps: u16,
}

/// The changes of all maps that are not hidden, in the order in which a frame reads them:
/// [group of vertices][course][number of changes][map].
///
/// All of a group's vertices look up a course before the next one comes, so that its table is read from the first
/// cache; and maps of as many changes follow each other, because a processor guesses when a loop ends by when it ended
/// before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Schedule<C> {
    courses: usize,
    /// [group]: where its batches, maps and changes begin; one more at the end.
    starts: Vec<[usize; 3]>,
    /// [group][course]: the number of batches.
    counts: Vec<u16>,
    batches: Vec<Batch>,
    /// [map]: the vertex in its group.
    vertices: Vec<u8>,
    changes: Vec<C>,
}

impl<C: Copy + Send + Sync> Schedule<C> {
    /// Of maps [vertex][block].
    pub(super) fn new<V: Visible<Change = C>>(maps: &V, paths: &Paths, vertices: usize, blocks: usize) -> Self {
        let groups = vertices.div_ceil(GROUP);
        let group = |group: usize| {
            let mut part = Self::empty(2 * blocks);
            let first = group * GROUP;
            for course in 0..2 * blocks {
                let (path, block) = (course / blocks, course % blocks);
                let here = (first..vertices.min(first + GROUP)).filter(|&v| paths.of(v, block, blocks) == path);
                part.push(maps, here.map(|vertex| ((vertex - first) as u8, vertex * blocks + block)));
            }
            part
        };
        let mut all = Self::empty(2 * blocks);
        for part in parallel::map(groups, group) {
            all.counts.extend(part.counts);
            all.batches.extend(part.batches);
            all.vertices.extend(part.vertices);
            all.changes.extend(part.changes);
            all.starts.push([all.batches.len(), all.vertices.len(), all.changes.len()]);
        }
        all
    }

    fn empty(courses: usize) -> Self {
        Self {
            courses,
            starts: vec![[0; 3]],
            counts: Vec::new(),
            batches: Vec::new(),
            vertices: Vec::new(),
            changes: Vec::new(),
        }
    }

    /// Appends one course of a group: vertices and their maps.
    fn push<V: Visible<Change = C>>(&mut self, maps: &V, course: impl Iterator<Item = (u8, usize)>) {
        let sized = course.map(|(vertex, map)| (maps.count(map), vertex, map));
        let mut seen: Vec<_> = sized.filter(|&(changes, ..)| changes > 0).collect();
        seen.sort_unstable();
        let before = self.batches.len();
        for batch in seen.chunk_by(|a, b| a.0 == b.0) {
            self.batches.push(Batch { changes: batch[0].0 as u16, maps: batch.len() as u16 });
            for &(_, vertex, map) in batch {
                self.vertices.push(vertex);
                maps.append_changes(map, &mut self.changes);
            }
        }
        self.counts.push((self.batches.len() - before) as u16);
    }

    /// The maps of one group.
    pub(super) fn group(&self, group: usize) -> Group<'_, C> {
        let ([b, v, c], [b_end, v_end, c_end]) = (self.starts[group], self.starts[group + 1]);
        Group {
            counts: &self.counts[group * self.courses..][..self.courses],
            batches: &self.batches[b..b_end],
            vertices: &self.vertices[v..v_end],
            changes: &self.changes[c..c_end],
        }
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.starts[..])
            + size_of_val(&self.counts[..])
            + size_of_val(&self.batches[..])
            + size_of_val(&self.vertices[..])
            + size_of_val(&self.changes[..])
    }
}

/// The maps of a group of vertices that are not taken yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Group<'a, C> {
    counts: &'a [u16],
    batches: &'a [Batch],
    vertices: &'a [u8],
    changes: &'a [C],
}

impl<'a, C> Group<'a, C> {
    /// Takes the next course's batches.
    #[inline(always)]
    pub(super) fn next_course(&mut self) -> &'a [Batch] {
        let (&count, rest) = self.counts.split_first().expect("a group has all courses");
        self.counts = rest;
        take(&mut self.batches, usize::from(count))
    }

    /// Takes the vertices of a batch and the changes of their maps on end.
    #[inline(always)]
    pub(super) fn next_maps(&mut self, batch: Batch) -> (&'a [u8], &'a [C]) {
        let (maps, changes) = (usize::from(batch.maps), usize::from(batch.changes));
        (take(&mut self.vertices, maps), take(&mut self.changes, maps * changes))
    }
}

#[inline(always)]
fn take<'a, T>(from: &mut &'a [T], count: usize) -> &'a [T] {
    let (first, rest) = from.split_at(count);
    *from = rest;
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compress::CodedBinaryMaps;

    /// Maps of two blocks: vertex v sees v mod 5 single pixels of the first; the second is hidden, free, or ends with
    /// its first half.
    fn maps(vertices: usize) -> (CodedBinaryMaps<u8>, Paths) {
        let (mut maps, mut paths) = (CodedBinaryMaps::new(64).unwrap(), Paths::default());
        for v in 0..vertices {
            paths.push_vertex(2);
            if v % 3 == 0 {
                paths.turn_last(1, 2);
            }
            maps.push_bits(&[(0..v % 5).fold(0, |bits, k| bits | 1 << (4 * k + 1))]);
            maps.push_bits(&[[0, !0, !0 >> 32][v % 3]]);
        }
        (maps, paths)
    }

    #[test]
    fn every_map_that_is_not_hidden_comes_once_and_those_of_a_batch_are_alike() {
        for vertices in [0, 1, 255, 256, 257, 700] {
            let (maps, paths) = maps(vertices);
            let schedule = Schedule::new(&maps, &paths, vertices, 2);
            let mut seen = vec![[0; 2]; vertices];
            for number in 0..vertices.div_ceil(GROUP) {
                let mut group = schedule.group(number);
                for course in 0..4 {
                    let (path, block) = (course / 2, course % 2);
                    let mut before = 0;
                    for &batch in group.next_course() {
                        let count = usize::from(batch.changes);
                        assert!(count > before, "batches of a course rise");
                        before = count;
                        let (members, changes) = group.next_maps(batch);
                        assert_eq!(changes.len(), members.len() * count);
                        for (&member, changes) in members.iter().zip(changes.chunks_exact(count)) {
                            let vertex = number * GROUP + usize::from(member);
                            assert_eq!(changes, maps.map(vertex * 2 + block).changes());
                            assert_eq!(path, paths.of(vertex, block, 2));
                            seen[vertex][block] += 1;
                        }
                    }
                }
            }
            for (v, seen) in seen.into_iter().enumerate() {
                assert_eq!(seen, [usize::from(v % 5 != 0), usize::from(v % 3 != 0)], "vertex {v} of {vertices}");
            }
        }
    }
}
