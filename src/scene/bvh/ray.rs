//! Single rays, in `f64`.

use super::edge::{edge, norm_squared, volume};
use super::tree::{MAX_DEPTH, Node};

/// The tolerance of [`EDGE_TOLERANCE`](super::edge::EDGE_TOLERANCE) in `f64`.
const TOLERANCE: f64 = 12.0 * 0.5 * f64::EPSILON;

/// Two distances along a ray that differ by less than this share are alike: the rounding of each is 3 units of 2⁻⁵³.
const SLACK: f64 = 4.0 * f64::EPSILON;

/// Coordinates of origins from here on miss: the sums of products of three of them would overflow.
const FARTHEST: f64 = 1e100;

/// A ray in the tree's coordinates.
pub(super) struct Ray {
    origin: [f64; 3],
    /// The largest component is 1.
    direction: [f64; 3],
    inverse: [f64; 3],
}

/// Where a ray meets a triangle.
pub(super) struct Meeting {
    /// In units of [`Ray::direction`].
    pub(super) distance: f64,
    pub(super) weights: [f64; 3],
}

impl Ray {
    /// None unless all is finite, the origin within reach and the direction not zero.
    pub(super) fn new(origin: [f64; 3], direction: [f64; 3]) -> Option<Self> {
        let length = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let usable = origin.iter().all(|c| c.abs() < FARTHEST) && direction.iter().all(|c| c.is_finite());
        if !usable || length == 0.0 {
            return None;
        }
        // Of a denormal the reciprocal may overflow, the quotient does not.
        let direction = direction.map(|c| c / length);
        Some(Self { origin, direction, inverse: direction.map(|c| 1.0 / c) })
    }

    /// Where the ray enters a box, at least 0; None if it misses.
    ///
    /// A component of zero makes ±∞ of a distance to a plane, or NaN in the plane itself: the comparisons pass NaN
    /// over, so that the box is closed.
    #[inline(always)]
    fn enters(&self, node: &Node) -> Option<f64> {
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for k in 0..3 {
            let (low, high) = (f64::from(node.bounds.low[k]), f64::from(node.bounds.high[k]));
            let (first, last) = if self.inverse[k] > 0.0 { (low, high) } else { (high, low) };
            let (enter, leave) =
                ((first - self.origin[k]) * self.inverse[k], (last - self.origin[k]) * self.inverse[k]);
            near = if enter > near { enter } else { near };
            far = if leave < far { leave } else { far };
        }
        (near <= far * (1.0 + SLACK)).then_some(near)
    }

    /// Hands the leaves that the ray may meet to `visit`, about near to far, as ranges of faces; it returns how far the
    /// ray still goes.
    pub(super) fn walk(&self, nodes: &[Node], mut visit: impl FnMut(std::ops::Range<usize>) -> f64) {
        let mut stack = [(0_u32, 0.0_f64); MAX_DEPTH];
        let (mut waiting, mut reach) = (0, f64::INFINITY);
        let Some(mut near) = nodes.first().and_then(|root| self.enters(root)) else { return };
        let mut index = 0_usize;
        loop {
            let node = &nodes[index];
            let mut next = None;
            if near > reach {
                // Something nearer was met since this one was put aside.
            } else if node.is_leaf() {
                let first = node.first as usize;
                reach = visit(first..first + node.count as usize) * (1.0 + SLACK);
            } else {
                let [a, b] = node.children();
                next = match (self.enters(&nodes[a]), self.enters(&nodes[b])) {
                    (Some(s), Some(t)) => {
                        let (here, there) = if s <= t { ((a, s), (b, t)) } else { ((b, t), (a, s)) };
                        // One entry a level at most.
                        stack[waiting] = (there.0 as u32, there.1);
                        waiting += 1;
                        Some(here)
                    }
                    (Some(s), None) => Some((a, s)),
                    (None, t) => t.map(|t| (b, t)),
                };
            }
            (index, near) = match next {
                Some(next) => next,
                None if waiting == 0 => return,
                None => {
                    waiting -= 1;
                    (stack[waiting].0 as usize, stack[waiting].1)
                }
            };
        }
    }

    /// Where the ray meets a triangle.
    ///
    /// Edges are widened by their error bound, so that nothing slips through a shared edge.
    pub(super) fn intersect(&self, triangle: &[[f32; 3]; 3]) -> Option<Meeting> {
        let (o, d) = (self.origin, self.direction);
        let corners = triangle.map(|v| v.map(f64::from));
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let p = corners.map(|v| minus(v, o));
        let e = [0, 1, 2].map(|k: usize| minus(corners[(k + 1) % 3], corners[k]));
        let distances = p.map(norm_squared);
        let mut weights = [0.0; 3];
        // An edge function is tested on both sides at once: which side the origin is on is known from their sum, the
        // slant.
        let (mut inside, mut outside) = (true, true);
        for k in 0..3 {
            let next = (k + 1) % 3;
            let nearer = if distances[next] < distances[k] { p[next] } else { p[k] };
            let (n, q) = edge(nearer, e[k], f64::abs);
            let value = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
            inside &= value >= -TOLERANCE * q;
            outside &= value <= TOLERANCE * q;
            if !inside && !outside {
                return None;
            }
            weights[(k + 2) % 3] = value;
        }
        let nearest = [1, 2].into_iter().fold(0, |n, k| if distances[k] < distances[n] { k } else { n });
        let (six_volume, volume_terms) = volume(p[nearest], e[0], e[1], f64::abs);
        if six_volume.abs() <= TOLERANCE * volume_terms {
            return None;
        }
        let side = six_volume.signum();
        if !(if side > 0.0 { inside } else { outside }) {
            return None;
        }
        let weights = weights.map(|w| (side * w).max(0.0));
        let sum = weights[0] + weights[1] + weights[2];
        // Along a face the weights' sum, which is the slant but for rounding, at least has the right sign.
        let slant = (e[0][1] * e[1][2] - e[0][2] * e[1][1]) * d[0]
            + (e[0][2] * e[1][0] - e[0][0] * e[1][2]) * d[1]
            + (e[0][0] * e[1][1] - e[0][1] * e[1][0]) * d[2];
        let distance = six_volume.abs() / if side * slant > 0.0 { side * slant } else { sum };
        distance.is_finite().then(|| Meeting { distance, weights: weights.map(|w| w / sum) })
    }
}
