//! What the greedy search did, for those who study it.

/// One way to change a submatrix; in the order in which equals are preferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BiclusterMove {
    /// A row is added.
    AddRow,
    /// A column is added.
    AddColumn,
    /// A row is taken out.
    DeleteRow,
    /// A column is taken out.
    DeleteColumn,
}

/// A move that was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BiclusterStep {
    /// What was done.
    pub kind: BiclusterMove,
    /// To which row or column.
    pub index: usize,
    /// ΔW of the submatrix afterwards: the floating-point operations that its bicluster saves.
    pub saving: i64,
}

/// How one bicluster grew.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BiclusterTrace {
    /// Row and column of the non-zero element it began with.
    pub seed: (usize, usize),
    /// Every move in turn; empty where the bicluster is the element alone.
    pub steps: Vec<BiclusterStep>,
    /// ΔW of the bicluster.
    pub saving: i64,
}
