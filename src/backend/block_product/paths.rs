//! Which path the map of a block takes.

/// A bit for each map: whether its path is turned. Maps that are constant take the first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Paths {
    /// [vertex][word of 64 blocks]
    turned: Vec<u64>,
}

impl Paths {
    /// Words a vertex.
    pub(super) fn words(blocks: usize) -> usize {
        blocks.div_ceil(64)
    }

    /// Of words, [vertex][word].
    pub(super) fn new(turned: Vec<u64>) -> Self {
        Self { turned }
    }

    /// The words, [vertex][word].
    pub(super) fn turned(&self) -> &[u64] {
        &self.turned
    }

    /// Appends a vertex whose maps take the first path.
    pub(super) fn push_vertex(&mut self, blocks: usize) {
        self.turned.resize(self.turned.len() + Self::words(blocks), 0);
    }

    /// Turns a block of the last vertex.
    pub(super) fn turn_last(&mut self, block: usize, blocks: usize) {
        let first = self.turned.len() - Self::words(blocks);
        self.turned[first + block / 64] |= 1 << (block % 64);
    }

    /// Appends the vertices of another.
    pub(super) fn append(&mut self, other: &Self) {
        self.turned.extend_from_slice(&other.turned);
    }

    /// Whether the path of a block is turned, as a number.
    pub(super) fn of(&self, vertex: usize, block: usize, blocks: usize) -> usize {
        (self.turned[vertex * Self::words(blocks) + block / 64] >> (block % 64) & 1) as usize
    }

    /// Whether no bit of a vertex is set beyond its blocks.
    pub(super) fn is_of_vertex(&self, vertex: usize, blocks: usize) -> bool {
        let last = self.turned[(vertex + 1) * Self::words(blocks) - 1];
        blocks % 64 == 0 || last >> (blocks % 64) == 0
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.turned[..])
    }
}
