//! Flat index ↔ (level, offset, kind) of a basis function.

/// A function of the 1D Haar basis on [0, 1].
///
/// Flat index: 0 is the scaling function φ; 2^l + t is the detail ψ_{l,t}(v) = 2^{l/2} ψ(2^l v − t), with ψ = +1 on
/// [0, ½) and −1 on [½, 1). Level 0 is the coarsest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Index1d {
    /// φ = 1.
    Scaling,
    /// ψ of a level and offset, offset < 2^level.
    Detail {
        /// The level l.
        level: u32,
        /// The offset t.
        offset: usize,
    },
}

impl Index1d {
    /// The function of a flat index.
    #[inline]
    pub fn from_flat(flat: usize) -> Self {
        match flat.checked_ilog2() {
            None => Self::Scaling,
            Some(level) => Self::Detail { level, offset: flat - (1 << level) },
        }
    }

    /// The flat index.
    #[inline]
    pub fn flat(self) -> usize {
        match self {
            Self::Scaling => 0,
            Self::Detail { level, offset } => (1 << level) + offset,
        }
    }
}

/// The three details of the 2D nonstandard basis, named by the direction in which they change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WaveletKind {
    /// ψ(x) φ(y): changes along x (kind 1).
    Horizontal = 1,
    /// φ(x) ψ(y): changes along y (kind 2).
    Vertical = 2,
    /// ψ(x) ψ(y): changes along both (kind 3).
    Diagonal = 3,
}

impl WaveletKind {
    /// The three kinds in storage order.
    pub const ALL: [Self; 3] = [Self::Horizontal, Self::Vertical, Self::Diagonal];
}

/// A function of the 2D nonstandard Haar basis on [0, 1]².
///
/// Flat index: 0 is φ(x)φ(y); 4^l·kind + y·2^l + x is the detail 2^l·(…)(2^l x − t_x)(2^l y − t_y).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Index2d {
    /// φ(x) φ(y) = 1.
    Scaling,
    /// A detail of a level, kind and offset.
    Detail {
        /// The level l.
        level: u32,
        /// Which of the three.
        kind: WaveletKind,
        /// The offset t_x < 2^l.
        x: usize,
        /// The offset t_y < 2^l.
        y: usize,
    },
}

impl Index2d {
    /// The function of a flat index.
    #[inline]
    pub fn from_flat(flat: usize) -> Self {
        let Some(log) = flat.checked_ilog2() else { return Self::Scaling };
        let level = log / 2;
        let within = flat & ((1 << (2 * level)) - 1);
        Self::Detail {
            level,
            kind: WaveletKind::ALL[(flat >> (2 * level)) - 1],
            x: within & ((1 << level) - 1),
            y: within >> level,
        }
    }

    /// The flat index.
    #[inline]
    pub fn flat(self) -> usize {
        match self {
            Self::Scaling => 0,
            Self::Detail { level, kind, x, y } => ((kind as usize) << (2 * level)) + (y << level) + x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_and_structured_indices_are_inverse() {
        for flat in 0..1 << 12 {
            assert_eq!(Index1d::from_flat(flat).flat(), flat);
            assert_eq!(Index2d::from_flat(flat).flat(), flat);
        }
        let diagonal = Index2d::Detail { level: 2, kind: WaveletKind::Diagonal, x: 1, y: 3 };
        assert_eq!(diagonal.flat(), 3 * 16 + 3 * 4 + 1);
        assert_eq!(Index1d::from_flat(11), Index1d::Detail { level: 3, offset: 3 });
    }
}
