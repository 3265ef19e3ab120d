//! Where the cells of a table lie: where what is tabulated bends.

/// A part of the table whose cells are equally wide.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub start: f64,
    pub length: f64,
    pub cells: usize,
    /// Length times the root of the largest curvature: what the number of cells is proportional to, if all cells are
    /// to err alike.
    bend: f64,
}

impl Piece {
    fn new(start: f64, end: f64, f: &mut impl FnMut(f64) -> Vec<f64>) -> Self {
        const SAMPLES: usize = 12;
        let length = end - start;
        let at = |i: usize| start + length * (i as f64 + 0.5) / SAMPLES as f64;
        let samples: Vec<Vec<f64>> = (0..SAMPLES).map(|i| f(at(i))).collect();
        let mut largest = 0.0f64;
        for three in samples.windows(3) {
            for l in 0..three[0].len() {
                largest = largest.max((three[0][l] - 2.0 * three[1][l] + three[2][l]).abs());
            }
        }
        // What is not finite is refused later.
        let bend = SAMPLES as f64 * largest.sqrt();
        Self { start, length, cells: 0, bend: if bend.is_finite() { bend } else { 0.0 } }
    }

    fn halves(&self, f: &mut impl FnMut(f64) -> Vec<f64>) -> [Self; 2] {
        let (middle, end) = (self.start + 0.5 * self.length, self.start + self.length);
        [Self::new(self.start, middle, f), Self::new(middle, end, f)]
    }

    /// The place that lies so many cells from the start.
    pub fn at(&self, cells: f64) -> f64 {
        self.start + self.length * (cells / self.cells as f64)
    }
}

/// The pieces between `ends`, halved up to ten times where that lets cells be spared, and their shares of the cells.
pub(super) fn pieces(ends: &[f64], cells: usize, f: &mut impl FnMut(f64) -> Vec<f64>) -> Vec<Piece> {
    /// Each piece costs a look-up some operations.
    const SPLITS: usize = 10;
    /// Cells of a piece on average, at least, after a split.
    const FEW: usize = 8;
    let mut pieces: Vec<(Piece, [Piece; 2])> = Vec::new();
    let with_halves = |piece: Piece, f: &mut _| (piece, piece.halves(f));
    for ends in ends.windows(2) {
        let piece = Piece::new(ends[0], ends[1], f);
        pieces.push(with_halves(piece, f));
    }
    for _ in 0..SPLITS {
        let gain = |(piece, [a, b]): &(Piece, [Piece; 2])| piece.bend - a.bend - b.bend;
        let total: f64 = pieces.iter().map(|(piece, _)| piece.bend).sum();
        let best = (0..pieces.len()).max_by(|&a, &b| gain(&pieces[a]).total_cmp(&gain(&pieces[b])));
        match best {
            Some(best) if gain(&pieces[best]) > 0.02 * total && (pieces.len() + 1) * FEW <= cells => {
                let halves = pieces[best].1.map(|half| with_halves(half, f));
                pieces.splice(best..=best, halves);
            }
            _ => break,
        }
    }
    share_out(pieces.into_iter().map(|(piece, _)| piece).collect(), cells)
}

/// Gives each piece as many of the cells as it bends, and at least one.
fn share_out(mut pieces: Vec<Piece>, cells: usize) -> Vec<Piece> {
    let bend: f64 = pieces.iter().map(|piece| piece.bend).sum();
    let length: f64 = pieces.iter().map(|piece| piece.length).sum();
    // A small part by length, which is all where nothing bends.
    let weight = |piece: &Piece| piece.bend + (0.02 * bend + f64::MIN_POSITIVE) * piece.length / length;
    let (mut weights, mut left) = (pieces.iter().map(weight).sum::<f64>(), cells);
    let count = pieces.len();
    for (k, piece) in pieces.iter_mut().enumerate() {
        let after = count - 1 - k;
        let share = if after == 0 { 1.0 } else { weight(piece) / weights };
        piece.cells = ((share * left as f64).round() as usize).clamp(1, left - after);
        weights -= weight(piece);
        left -= piece.cells;
    }
    pieces
}
