//! Functions of two variables as tables.

use crate::{Error, Result};

/// An axis of a table: where its nodes lie.
///
/// Nodes are equidistant in t = w(x), from the first at `from` to the last at `to`.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableAxis {
    from: f64,
    to: f64,
    nodes: usize,
    spacing: Spacing,
}

/// How the nodes of a [`TableAxis`] are spaced: equidistant in which function of the variable.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Spacing {
    /// x itself.
    #[default]
    Linear,
    /// √x: dense at 0.
    SquareRoot,
    /// ln x: the same ratio from each to the next.
    Logarithmic,
}

impl Spacing {
    fn warp(self, x: f64) -> f64 {
        match self {
            Self::Linear => x,
            Self::SquareRoot => x.max(0.0).sqrt(),
            Self::Logarithmic => x.max(0.0).ln(),
        }
    }

    fn unwarp(self, t: f64) -> f64 {
        match self {
            Self::Linear => t,
            Self::SquareRoot => t * t,
            Self::Logarithmic => t.exp(),
        }
    }
}

impl TableAxis {
    /// The most nodes of an axis.
    pub const MAX_NODES: usize = 1 << 14;

    /// An axis from one end to the other.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for an end that is NaN or infinite; [`Error::OutOfRange`] unless `from` < `to`, both not
    /// negative for [`Spacing::SquareRoot`] and positive for [`Spacing::Logarithmic`], and 2 ≤ `nodes` ≤
    /// [`MAX_NODES`](Self::MAX_NODES).
    pub fn new(from: f64, to: f64, nodes: usize, spacing: Spacing) -> Result<Self> {
        if let Some(index) = [from, to].iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite { what: "end of a table's axis", index });
        }
        let (least, allowed) = match spacing {
            Spacing::Linear => (f64::MIN, "finite"),
            Spacing::SquareRoot => (0.0, "not negative"),
            Spacing::Logarithmic => (f64::MIN_POSITIVE, "positive"),
        };
        if from < least {
            return Err(Error::OutOfRange { what: "first end of a table's axis", got: from, allowed });
        }
        if !(from < to && (to - from).is_finite()) {
            let what = "length of a table's axis";
            return Err(Error::OutOfRange { what, got: to - from, allowed: "positive and finite" });
        }
        if !(2..=Self::MAX_NODES).contains(&nodes) {
            return Err(Error::OutOfRange {
                what: "nodes of a table's axis",
                got: nodes as f64,
                allowed: "in 2…16384",
            });
        }
        Ok(Self { from, to, nodes, spacing })
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// The first and the last node.
    pub fn ends(&self) -> [f64; 2] {
        [self.from, self.to]
    }

    /// How nodes are spaced.
    pub fn spacing(&self) -> Spacing {
        self.spacing
    }

    /// The place of a node; of fractions, places between them. The ends are exact.
    pub fn node(&self, i: f64) -> f64 {
        let last = (self.nodes - 1) as f64;
        if i <= 0.0 {
            return self.from;
        }
        if i >= last {
            return self.to;
        }
        let [a, b] = self.ends().map(|x| self.spacing.warp(x));
        self.spacing.unwarp(a + (b - a) * (i / last)).clamp(self.from, self.to)
    }

    /// The inverse: the number of the node at x, fractions between nodes, in [0, nodes − 1]. Places beyond the ends,
    /// and NaN, are those of the nearer (the first) end.
    pub fn position(&self, x: f64) -> f64 {
        let [a, b] = self.ends().map(|x| self.spacing.warp(x));
        let i = (self.spacing.warp(x) - a) * ((self.nodes - 1) as f64 / (b - a));
        // In this order NaN becomes 0.
        i.max(0.0).min((self.nodes - 1) as f64)
    }
}

/// Values of a function of two variables at the nodes of two axes, looked up between them.
///
/// [`bilinear`](Self::bilinear) is exact for functions that are linear in each warped variable, error O(h²);
/// [`bicubic`](Self::bicubic) (Catmull–Rom, one-sided at the borders) for quadratic ones, error O(h³). How large the
/// error is for the function at hand, [`error`](Self::error) measures. Look-ups beyond the axes have the value of the
/// nearest border.
///
/// As a texture, node (i, j) is texel (i, j): a look-up at x is one at u = (position(x) + ½)/nodes, so that a GPU's
/// bilinear filter gives the same number. [`to_bytes`](Self::to_bytes) has the texels.
///
/// # Example
/// ```
/// use haarmonic::numeric::{Spacing, Table2d, TableAxis};
/// let x = TableAxis::new(0.0, 10.0, 33, Spacing::SquareRoot)?;
/// let y = TableAxis::new(0.0, 1.0, 17, Spacing::Linear)?;
/// let table = Table2d::from_fn(x, y, |x, y| (-x).exp() * y)?;
/// assert!((table.bilinear(2.0, 0.5) - (-2.0_f64).exp() * 0.5).abs() < 1e-3);
/// assert!(table.error(|x, y| (-x).exp() * y, 4).worst_bicubic < 1e-3);
/// # Ok::<(), haarmonic::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Table2d {
    x: TableAxis,
    y: TableAxis,
    /// Row after row: y · nodes + x.
    values: Vec<f64>,
}

/// How far a table is from its function, between its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableError {
    /// The largest difference of bilinear look-ups.
    pub worst_bilinear: f64,
    /// Where that is.
    pub worst_bilinear_at: [f64; 2],
    /// The median difference of bilinear look-ups.
    pub median_bilinear: f64,
    /// The largest difference of bicubic look-ups.
    pub worst_bicubic: f64,
    /// Where that is.
    pub worst_bicubic_at: [f64; 2],
    /// The median difference of bicubic look-ups.
    pub median_bicubic: f64,
}

impl Table2d {
    /// A table of values, row after row: entry j · x.nodes() + i is that at node i of x and node j of y.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one value a pair of nodes, [`Error::NotFinite`] for NaN and infinity.
    pub fn new(x: TableAxis, y: TableAxis, values: Vec<f64>) -> Result<Self> {
        let expected = x.nodes * y.nodes;
        if values.len() != expected {
            return Err(Error::Length { what: "values of a table", expected, got: values.len() });
        }
        if let Some(index) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite { what: "value of a table", index });
        }
        Ok(Self { x, y, values })
    }

    /// The table of a function.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if it is NaN or infinite at a node.
    pub fn from_fn(x: TableAxis, y: TableAxis, f: impl Fn(f64, f64) -> f64) -> Result<Self> {
        let row = |j: usize| (0..x.nodes).map(move |i| [x.node(i as f64), y.node(j as f64)]);
        Self::new(x, y, (0..y.nodes).flat_map(row).map(|[x, y]| f(x, y)).collect())
    }

    /// The axes.
    pub fn axes(&self) -> [TableAxis; 2] {
        [self.x, self.y]
    }

    /// All values, row after row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at node (i, j), the borders' beyond them.
    fn at(&self, i: isize, j: isize) -> f64 {
        let [i, j] = [(i, self.x.nodes), (j, self.y.nodes)].map(|(i, n)| i.clamp(0, n as isize - 1) as usize);
        self.values[j * self.x.nodes + i]
    }

    /// The value at (x, y), linear between the four nodes around it.
    pub fn bilinear(&self, x: f64, y: f64) -> f64 {
        let ((i, s), (j, t)) = (cell(&self.x, x), cell(&self.y, y));
        let row = |j: isize| lerp(self.at(i, j), self.at(i + 1, j), s);
        lerp(row(j), row(j + 1), t)
    }

    /// The value at (x, y), cubic between the sixteen nodes around it. It may leave the range of the values.
    pub fn bicubic(&self, x: f64, y: f64) -> f64 {
        let ((i, s), (j, t)) = (cell(&self.x, x), cell(&self.y, y));
        let (weights_x, weights_y) = (cubic(s, i, self.x.nodes), cubic(t, j, self.y.nodes));
        let row = |j: isize| (0..4).map(|k| weights_x[k] * self.at(i - 1 + k as isize, j)).sum::<f64>();
        (0..4).map(|k| weights_y[k] * row(j - 1 + k as isize)).sum()
    }

    /// The difference between the table and a function at the middles of `parts`² parts of every cell.
    ///
    /// # Panics
    /// If `parts` is 0.
    #[track_caller]
    pub fn error(&self, f: impl Fn(f64, f64) -> f64, parts: usize) -> TableError {
        assert!(parts > 0, "a cell has at least one part");
        let middles =
            |axis: TableAxis| (0..(axis.nodes - 1) * parts).map(move |i| axis.node((i as f64 + 0.5) / parts as f64));
        let (mut linear, mut cubic) = (Vec::new(), Vec::new());
        for y in middles(self.y) {
            for x in middles(self.x) {
                let exact = f(x, y);
                linear.push(((self.bilinear(x, y) - exact).abs(), [x, y]));
                cubic.push(((self.bicubic(x, y) - exact).abs(), [x, y]));
            }
        }
        let summary = |list: &mut Vec<(f64, [f64; 2])>| {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
            let last = list.len() - 1;
            (list[last].0, list[last].1, list[last / 2].0)
        };
        let (worst_bilinear, worst_bilinear_at, median_bilinear) = summary(&mut linear);
        let (worst_bicubic, worst_bicubic_at, median_bicubic) = summary(&mut cubic);
        TableError {
            worst_bilinear,
            worst_bilinear_at,
            median_bilinear,
            worst_bicubic,
            worst_bicubic_at,
            median_bicubic,
        }
    }

    /// The texels of a texture with one 32-bit float channel, row after row, little-endian.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.values.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect()
    }
}

/// The cell of a place: its first node, and how far on it is, in [0, 1].
fn cell(axis: &TableAxis, x: f64) -> (isize, f64) {
    let position = axis.position(x);
    let first = (position as usize).min(axis.nodes - 2);
    (first as isize, position - first as f64)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// The weights of the nodes before, at, after and behind a cell for the cubic of Catmull and Rom; at a border, where
/// the outer node is missing, those of the parabola through the three that are there (of the line with two nodes).
fn cubic(t: f64, cell: isize, nodes: usize) -> [f64; 4] {
    let (has_before, has_behind) = (cell > 0, cell + 2 < nodes as isize);
    match (has_before, has_behind) {
        (true, true) => [
            0.5 * t * ((2.0 - t) * t - 1.0),
            0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
            0.5 * t * ((4.0 - 3.0 * t) * t + 1.0),
            0.5 * t * t * (t - 1.0),
        ],
        (false, true) => [0.0, 0.5 * (t - 1.0) * (t - 2.0), t * (2.0 - t), 0.5 * t * (t - 1.0)],
        (true, false) => [0.5 * t * (t - 1.0), (1.0 - t) * (1.0 + t), 0.5 * t * (t + 1.0), 0.0],
        (false, false) => [0.0, 1.0 - t, t, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(from: f64, to: f64, nodes: usize, spacing: Spacing) -> TableAxis {
        TableAxis::new(from, to, nodes, spacing).unwrap()
    }

    #[test]
    fn nodes_and_positions_are_inverse() {
        for axis in [
            axis(-3.0, 5.0, 17, Spacing::Linear),
            axis(0.0, 25.0, 64, Spacing::SquareRoot),
            axis(1e-3, 100.0, 33, Spacing::Logarithmic),
            axis(0.0, 1e-300, 2, Spacing::Linear),
        ] {
            for i in 0..axis.nodes() {
                assert!((axis.position(axis.node(i as f64)) - i as f64).abs() < 1e-12, "{axis:?} {i}");
            }
            let last = (axis.nodes() - 1) as f64;
            assert_eq!([axis.node(0.0), axis.node(last)], axis.ends());
            for (x, want) in [(f64::NEG_INFINITY, 0.0), (f64::INFINITY, last), (f64::NAN, 0.0)] {
                assert_eq!(axis.position(x), want, "{axis:?} {x}");
            }
        }
    }

    #[test]
    fn look_ups_are_exact_for_what_they_are_made_for() {
        for (nx, ny) in [(2, 2), (3, 5), (9, 4), (17, 33)] {
            let (x, y) = (axis(-1.0, 2.0, nx, Spacing::Linear), axis(0.5, 1.5, ny, Spacing::Linear));
            let bilinear = |x: f64, y: f64| 2.0 + x - 3.0 * y + 0.5 * x * y;
            let table = Table2d::from_fn(x, y, bilinear).unwrap();
            let error = table.error(bilinear, 3);
            assert!(error.worst_bilinear < 1e-14 && error.worst_bicubic < 1e-14, "{nx} × {ny}: {error:?}");
            let quadratic = |x: f64, y: f64| (1.0 + x - x * x) * (2.0 - y * y);
            let error = Table2d::from_fn(x, y, quadratic).unwrap().error(quadratic, 3);
            assert_eq!(error.worst_bicubic < 1e-13, nx > 2 && ny > 2, "{nx} × {ny}: {error:?}");
        }
        // Quadratic in the root.
        let x = axis(0.0, 9.0, 6, Spacing::SquareRoot);
        let table = Table2d::from_fn(x, axis(0.0, 1.0, 3, Spacing::Linear), |x, y| x + y).unwrap();
        assert!(table.error(|x, y| x + y, 5).worst_bicubic < 1e-14);
    }

    #[test]
    fn errors_fall_with_the_square_and_the_cube() {
        let f = |x: f64, y: f64| (3.0 * x).sin() * (2.0 * y).exp();
        let at = |nodes: usize| {
            let axis = axis(0.0, 1.0, nodes, Spacing::Linear);
            Table2d::from_fn(axis, axis, f).unwrap().error(f, 4)
        };
        let (coarse, fine) = (at(17), at(33));
        let (linear, cubic) = (coarse.worst_bilinear / fine.worst_bilinear, coarse.worst_bicubic / fine.worst_bicubic);
        assert!((3.7..4.3).contains(&linear) && (7.0..9.0).contains(&cubic), "{linear} {cubic}");
        assert!(fine.median_bicubic < fine.worst_bicubic && fine.worst_bilinear_at != [0.0; 2]);
    }

    #[test]
    fn beyond_the_border_there_is_the_border() {
        let (x, y) = (axis(1.0, 2.0, 5, Spacing::Logarithmic), axis(-1.0, 1.0, 4, Spacing::Linear));
        let table = Table2d::from_fn(x, y, |x, y| x * y).unwrap();
        for (out, on) in [([9.0, 0.3], [2.0, 0.3]), ([-1.0, 7.0], [1.0, 1.0]), ([f64::NAN, -2.0], [1.0, -1.0])] {
            assert_eq!(table.bilinear(out[0], out[1]), table.bilinear(on[0], on[1]));
            assert_eq!(table.bicubic(out[0], out[1]), table.bicubic(on[0], on[1]));
        }
        assert_eq!(table.to_bytes()[..4], (-1.0_f32).to_le_bytes());
        assert_eq!(table.to_bytes().len(), 4 * 20);
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let bad =
            |from: f64, to: f64, nodes: usize, spacing: Spacing| TableAxis::new(from, to, nodes, spacing).is_err();
        assert!(bad(0.0, 0.0, 4, Spacing::Linear) && bad(1.0, 0.0, 4, Spacing::Linear));
        assert!(bad(f64::NAN, 1.0, 4, Spacing::Linear) && bad(0.0, f64::INFINITY, 4, Spacing::Linear));
        assert!(bad(f64::MIN, f64::MAX, 4, Spacing::Linear));
        assert!(bad(-1e-300, 1.0, 4, Spacing::SquareRoot) && bad(0.0, 1.0, 4, Spacing::Logarithmic));
        for nodes in [0, 1, TableAxis::MAX_NODES + 1, usize::MAX] {
            assert!(bad(0.0, 1.0, nodes, Spacing::Linear));
        }
        let axis = axis(0.0, 1.0, 2, Spacing::Linear);
        assert!(matches!(Table2d::new(axis, axis, vec![0.0; 3]), Err(Error::Length { expected: 4, got: 3, .. })));
        let nan = Table2d::from_fn(axis, axis, |x, y| if x + y > 1.5 { f64::NAN } else { 0.0 });
        assert!(matches!(nan, Err(Error::NotFinite { index: 3, .. })));
    }
}
