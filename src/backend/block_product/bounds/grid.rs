//! How tables of errors are cut.

use nalgebra::Vector3;

/// What a BRDF stays the same under.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::backend::block_product) enum Symmetry {
    /// Turning about the normal, and mirroring.
    Turned,
    /// Mirroring the tangent, and the bitangent.
    Mirrored,
    /// Nothing.
    None,
}

/// How a table is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) symmetry: Symmetry,
    /// Cells along the viewer's elevation and azimuth.
    pub(super) elevations: usize,
    pub(super) azimuths: usize,
    /// Cells from the mirror direction to its opposite.
    pub(super) reach: usize,
    pub(super) families: usize,
}

/// Viewers below this cosine to the normal are in no table: lobes become too narrow there.
pub(super) const LEAST: f64 = 0.005;

impl Grid {
    /// `slow`: of a BRDF that is asked value by value, which a table must not do too often.
    pub(super) fn of(symmetry: Symmetry, families: usize, slow: bool) -> Self {
        let (elevations, azimuths, reach) = match (symmetry, slow) {
            (Symmetry::Turned, false) => (32, 1, 20),
            (Symmetry::Turned, true) => (16, 1, 14),
            (Symmetry::Mirrored, _) => (16, 6, 16),
            (Symmetry::None, _) => (8, 12, 10),
        };
        Self { symmetry, elevations, azimuths, reach, families }
    }

    pub(super) fn columns(&self) -> usize {
        2 * self.reach + 1
    }

    pub(super) fn rows(&self) -> usize {
        if self.symmetry == Symmetry::Turned { self.reach + 1 } else { self.columns() }
    }

    /// Entries of a slice, of one family.
    pub(super) fn plane(&self) -> usize {
        self.rows() * self.columns()
    }

    /// Nodes along the viewer's azimuth.
    pub(super) fn turns(&self) -> usize {
        match self.symmetry {
            Symmetry::Turned => 1,
            Symmetry::Mirrored => self.azimuths + 1,
            Symmetry::None => self.azimuths,
        }
    }

    /// The viewer of a node.
    pub(super) fn viewer(&self, node: usize) -> Viewer {
        let (elevation, turn) = (node / self.turns(), node % self.turns());
        let z = (1.0 - (elevation as f64 / self.elevations as f64).powi(2)).max(LEAST);
        let along = match self.symmetry {
            Symmetry::Turned => [1.0, 0.0],
            Symmetry::Mirrored => on_square(turn as f64 / self.azimuths as f64),
            Symmetry::None => on_square(4.0 * turn as f64 / self.azimuths as f64),
        };
        Viewer { along, flat: (1.0 - z * z).sqrt(), z }
    }

    /// The centre of a block at a node of a slice, and sin(θ/2) of its angle to the mirror direction.
    pub(super) fn centre(&self, [x, y, mirror]: &[Vector3<f64>; 3], place: usize) -> Option<(Vector3<f64>, f64)> {
        let (row, column, reach) =
            ((place / self.columns()) as f64, (place % self.columns()) as f64, self.reach as f64);
        let middle = if self.symmetry == Symmetry::Turned { 0.0 } else { reach };
        let (a, b) = ((column - reach) / reach, (row - middle) / reach);
        let square = a * a + b * b;
        let scale = 2.0 * (1.0 - square).max(0.0).sqrt();
        (square <= 1.0).then(|| (x * (scale * a) + y * (scale * b) + mirror * (1.0 - 2.0 * square), square.sqrt()))
    }

    /// The nodes at the corners of a cell.
    pub(super) fn corners(&self, cell: usize) -> [usize; 4] {
        let (elevation, azimuth) = (cell / self.azimuths, cell % self.azimuths);
        let (turns, next) = (self.turns(), (azimuth + 1) % self.turns());
        let [low, high] = [elevation * turns, (elevation + 1) * turns];
        [low + azimuth, low + next, high + azimuth, high + next]
    }
}

/// A viewer's direction: azimuth, sine and cosine of the angle to the normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Viewer {
    pub(super) along: [f64; 2],
    pub(super) flat: f64,
    pub(super) z: f64,
}

impl Viewer {
    pub(super) fn wo(&self) -> Vector3<f64> {
        Vector3::new(self.flat * self.along[0], self.flat * self.along[1], self.z)
    }

    /// x, y and the mirror direction of a slice.
    pub(super) fn axes(&self) -> [Vector3<f64>; 3] {
        let [c, s] = self.along;
        let mirror = Vector3::new(-self.flat * c, -self.flat * s, self.z);
        let across = Vector3::new(-s, c, 0.0);
        [across.cross(&mirror), across, mirror]
    }
}

/// A number in [0, 4) that grows with the azimuth, without trigonometry: the way round a square.
pub(super) fn round_square([x, y]: [f64; 2]) -> f64 {
    let size = x.abs() + y.abs();
    let t = if size > 0.0 { y / size } else { 0.0 };
    match (x >= 0.0, t >= 0.0) {
        (true, true) => t,
        (false, _) => 2.0 - t,
        (true, false) => 4.0 + t,
    }
}

/// The unit vector there.
fn on_square(way: f64) -> [f64; 2] {
    let (quarter, t) = (way as usize % 4, way.fract());
    let (x, y) = match quarter {
        0 => (1.0 - t, t),
        1 => (-t, 1.0 - t),
        2 => (t - 1.0, -t),
        _ => (t, t - 1.0),
    };
    let size = x.hypot(y);
    [x / size, y / size]
}
