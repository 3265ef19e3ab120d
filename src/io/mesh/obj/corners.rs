//! What corners of faces name beside their positions.

use std::ops::Range;

use crate::io::count::Count;

/// Index of an entry that a corner does not name.
pub(super) const NONE: u32 = u32::MAX;

/// Index that stands for an entry that the file does not have, whatever follows.
const ABSENT: u32 = u32::MAX - 1;

/// The entries of one list of the file, its normals or its texture coordinates, that the corners name.
#[derive(Debug, Default)]
pub(super) struct Named {
    /// Indices of the corners of each triangle; empty until a face names one.
    triangles: Vec<[u32; 3]>,
    polygon: Vec<u32>,
    /// The entries that faces name before they are there, and the lines.
    early: Vec<(u32, usize)>,
    absent: Count,
}

impl Named {
    pub(super) fn begin_polygon(&mut self) {
        self.polygon.clear();
    }

    /// The next corner of the polygon names nothing.
    pub(super) fn push_none(&mut self) {
        self.polygon.push(NONE);
    }

    /// The next corner of the polygon names the entry of this index, none if that cannot be one; there are `so_far`.
    pub(super) fn push(&mut self, index: Option<u32>, so_far: usize, line: usize, given: impl FnOnce() -> String) {
        match index {
            Some(index) if index as usize >= so_far => self.early.push((index, line)),
            Some(_) => {}
            None => self.absent.add(|| format!("line {line}: {}", given())),
        }
        self.polygon.push(index.unwrap_or(ABSENT));
    }

    /// The polygon has become the fan of these triangles.
    pub(super) fn end_polygon(&mut self, triangles: Range<usize>) {
        let n = &self.polygon;
        if !self.triangles.is_empty() || n.iter().any(|&n| n != NONE) {
            self.triangles.resize(triangles.start, [NONE; 3]);
            self.triangles.extend((0..triangles.len()).map(|f| [n[0], n[f + 1], n[f + 2]]));
        }
    }

    /// How many corners name an entry that a list of `count` does not have; `what` is what an index is called.
    pub(super) fn take_absent(&mut self, count: usize, what: &str) -> Count {
        let mut absent = std::mem::take(&mut self.absent);
        for (index, line) in std::mem::take(&mut self.early) {
            if index as usize >= count {
                absent.add(|| format!("line {line}: {what} index {}", u64::from(index) + 1));
            }
        }
        absent
    }

    /// Whether a corner names one of the `count` entries of the list.
    pub(super) fn names_any(&self, count: usize) -> bool {
        self.triangles.as_flattened().iter().any(|&n| (n as usize) < count)
    }

    /// The indices of the corners of all triangles. Those that are not below the length of the list are [`NONE`] or
    /// name what is not there.
    pub(super) fn into_triangles(mut self, count: usize) -> Vec<[u32; 3]> {
        self.triangles.resize(count, [NONE; 3]);
        self.triangles
    }
}
