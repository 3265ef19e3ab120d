//! The binary tree under the hierarchy.
//!
//! Built from the root down. Faces are binned by their centres along each axis, and the cut with the least estimate
//!
//! ```math
//! A(left) ⌈n(left)/8⌉ + A(right) ⌈n(right)/8⌉,   A the area of a box, n its faces,
//! ```
//!
//! is taken: the surface area heuristic for leaves of eight triangles that are tested at once. Bins follow the faces
//! that are left, so a face far away costs one level and changes nothing among the others.
//!
//! Where centres do not tell faces apart, or where cuts have been so uneven that the depth would grow beyond
//! [`MAX_DEPTH`], a node is halved by order. So depth is bounded, and with it the cost: at most [`MAX_DEPTH`] passes
//! over the faces, whatever they are.

use super::WIDTH;

/// Levels of a tree at most: enough for 2³² faces halved after 31 cuts that took off one face each.
pub(super) const MAX_DEPTH: usize = 64;

/// Faces of a leaf at most. Small, for single rays; the wide copy joins leaves up to its own width.
const LEAF_FACES: usize = 4;

/// Bins along an axis at most: more changes the estimate by less than a per cent.
const BINS: usize = 32;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Box3 {
    pub(super) low: [f32; 3],
    pub(super) high: [f32; 3],
}

impl Box3 {
    /// Nothing: inside out.
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The smallest box around three points.
    pub(super) fn around(triangle: &[[f32; 3]; 3]) -> Self {
        triangle.iter().fold(Self::EMPTY, |b, p| b.union(&Self { low: *p, high: *p }))
    }

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        let mut out = *self;
        for k in 0..3 {
            out.low[k] = if other.low[k] < out.low[k] { other.low[k] } else { out.low[k] };
            out.high[k] = if other.high[k] > out.high[k] { other.high[k] } else { out.high[k] };
        }
        out
    }

    /// Half of the surface; meaningless for an empty box.
    #[inline(always)]
    fn half_area(&self) -> f32 {
        let d = [0, 1, 2].map(|k: usize| self.high[k] - self.low[k]);
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    }
}

/// A node: two children side by side, or the faces of a leaf.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) bounds: Box3,
    /// Index of the first child, or of the leaf's first face in the tree's order.
    pub(super) first: u32,
    /// Faces of a leaf; 0 for an inner node.
    pub(super) count: u32,
}

impl Node {
    pub(super) fn is_leaf(&self) -> bool {
        self.count > 0
    }

    pub(super) fn children(&self) -> [usize; 2] {
        [self.first as usize, self.first as usize + 1]
    }
}

/// A face on its way to a leaf.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    bounds: Box3,
    pub(super) index: u32,
}

impl Item {
    pub(super) fn new(bounds: Box3, index: u32) -> Self {
        Self { bounds, index }
    }

    /// Twice the centre.
    #[inline(always)]
    fn centre(&self, axis: usize) -> f32 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

/// The tree over `items`, which it brings into its order; root first, parents before children. None of no items.
pub(super) fn build(items: &mut [Item]) -> Vec<Node> {
    if items.is_empty() {
        return vec![];
    }
    let bounds = |items: &[Item]| items.iter().fold(Box3::EMPTY, |b, item| b.union(&item.bounds));
    let mut nodes = Vec::with_capacity(items.len());
    nodes.push(Node { bounds: bounds(items), first: 0, count: items.len() as u32 });
    let mut todo = vec![(0_usize, MAX_DEPTH - 1)];
    while let Some((index, levels)) = todo.pop() {
        let (first, count) = (nodes[index].first as usize, nodes[index].count as usize);
        if count <= LEAF_FACES {
            continue;
        }
        let part = &mut items[first..first + count];
        let left = split(part, levels);
        let (a, b) = part.split_at(left);
        let children = nodes.len() as u32;
        nodes.push(Node { bounds: bounds(a), first: first as u32, count: left as u32 });
        nodes.push(Node { bounds: bounds(b), first: (first + left) as u32, count: (count - left) as u32 });
        (nodes[index].first, nodes[index].count) = (children, 0);
        todo.extend([(children as usize + 1, levels - 1), (children as usize, levels - 1)]);
    }
    nodes
}

/// Parts the items in two, neither empty, and returns how many are in the first part; `levels` may still follow.
fn split(items: &mut [Item], levels: usize) -> usize {
    let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in &*items {
        for k in 0..3 {
            let c = item.centre(k);
            least[k] = least[k].min(c);
            most[k] = most[k].max(c);
        }
    }
    // Halving needs ⌈log₂ n⌉ levels, and one more since it keeps to whole leaves.
    let halving = items.len().next_power_of_two().ilog2() as usize + 1;
    let cut = if halving < levels { best_cut(items, &least, &most) } else { None };
    match cut {
        Some(cut) => partition(items, |item| cut.bins.of(item) < cut.bin),
        None => halve(items, &least, &most),
    }
}

/// Equal bins between the least and the largest centre along an axis.
#[derive(Clone, Copy)]
struct Bins {
    axis: usize,
    least: f32,
    /// Bins in a unit of length.
    density: f32,
    count: usize,
}

impl Bins {
    /// The bin of an item. The least centre is in the first and the largest in the last, even where the density
    /// overflows: 0 · ∞ is NaN, which becomes 0, and ∞ is cut off.
    #[inline(always)]
    fn of(&self, item: &Item) -> usize {
        (((item.centre(self.axis) - self.least) * self.density) as usize).min(self.count - 1)
    }
}

/// A cut before a bin.
struct Cut {
    bins: Bins,
    bin: usize,
}

/// The cut with the least estimate; None if all centres are the same.
fn best_cut(items: &[Item], least: &[f32; 3], most: &[f32; 3]) -> Option<Cut> {
    let count = BINS.min(items.len());
    let bins = [0, 1, 2].map(|axis: usize| {
        let density = count as f32 / (most[axis] - least[axis]);
        Bins { axis, least: least[axis], density, count }
    });
    let mut filled = [[(Box3::EMPTY, 0_usize); BINS]; 3];
    for item in items {
        for axis in 0..3 {
            let (bounds, n) = &mut filled[axis][bins[axis].of(item)];
            *bounds = bounds.union(&item.bounds);
            *n += 1;
        }
    }
    let mut best: Option<(f32, Cut)> = None;
    for axis in (0..3).filter(|&axis| least[axis] < most[axis]) {
        let filled = &filled[axis][..count];
        // What lies from a bin on.
        let mut above = [0.0_f32; BINS];
        let (mut bounds, mut n) = (Box3::EMPTY, 0);
        for bin in (1..count).rev() {
            bounds = bounds.union(&filled[bin].0);
            n += filled[bin].1;
            above[bin] = bounds.half_area() * n.div_ceil(WIDTH) as f32;
        }
        let (mut bounds, mut n) = (Box3::EMPTY, 0);
        for bin in 1..count {
            let (before, there) = &filled[bin - 1];
            if *there == 0 && bin > 1 {
                continue;
            }
            bounds = bounds.union(before);
            n += there;
            let estimate = bounds.half_area() * n.div_ceil(WIDTH) as f32 + above[bin];
            if best.as_ref().is_none_or(|(least, _)| estimate < *least) {
                best = Some((estimate, Cut { bins: bins[axis], bin }));
            }
        }
    }
    best.map(|(_, cut)| cut)
}

/// Brings the items that are `before` to the front and returns how many there are.
fn partition(items: &mut [Item], before: impl Fn(&Item) -> bool) -> usize {
    let (mut i, mut j) = (0, items.len());
    while i < j {
        if before(&items[i]) {
            i += 1;
        } else {
            j -= 1;
            items.swap(i, j);
        }
    }
    i
}

/// Halves the items, up to whole leaves: along the axis of the widest spread of centres or, if they are all the same,
/// by size.
fn halve(items: &mut [Item], least: &[f32; 3], most: &[f32; 3]) -> usize {
    let spread = [0, 1, 2].map(|k: usize| most[k] - least[k]);
    let axis = if spread[1] > spread[0] { 1 } else { 0 };
    let axis = if spread[2] > spread[axis] { 2 } else { axis };
    let apart = spread[axis] > 0.0;
    let key = |item: &Item| if apart { item.centre(axis) } else { item.bounds.half_area() };
    let half = items.len().div_ceil(2);
    let half = if items.len() > 2 * WIDTH { half.next_multiple_of(WIDTH) } else { half };
    items.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.index.cmp(&b.index)));
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxed(low: [f32; 3], size: [f32; 3]) -> Box3 {
        Box3 { low, high: [0, 1, 2].map(|k: usize| low[k] + size[k]) }
    }

    /// Depth, and the passes over faces that building took: the sum of the sizes of all inner nodes over the faces.
    fn work(nodes: &[Node]) -> (usize, f64) {
        let (mut levels, mut sizes) = (vec![1_usize; nodes.len()], vec![0_usize; nodes.len()]);
        for i in 0..nodes.len() {
            if !nodes[i].is_leaf() {
                nodes[i].children().into_iter().for_each(|c| levels[c] = levels[i] + 1);
            }
        }
        let mut passes = 0;
        for i in (0..nodes.len()).rev() {
            sizes[i] = nodes[i].count as usize;
            if !nodes[i].is_leaf() {
                sizes[i] = nodes[i].children().into_iter().map(|c| sizes[c]).sum();
                passes += sizes[i];
            }
        }
        (levels.into_iter().max().unwrap_or(0), passes as f64 / sizes[0] as f64)
    }

    /// Whatever the faces are: few passes over them, bounded depth, each of them in one leaf and in all boxes above it.
    #[test]
    fn any_input_takes_few_passes() {
        let n = 20_000_usize;
        let unit = [1.0; 3];
        let random = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
        type Faces = Box<dyn Fn(usize) -> Box3>;
        let inputs: [(&str, Faces); 12] = [
            ("equal", Box::new(move |_| boxed([0.0; 3], unit))),
            ("points", Box::new(|_| boxed([0.5; 3], [0.0; 3]))),
            ("two in turn", Box::new(move |i| boxed([0.0, 0.0, (i % 2) as f32], unit))),
            ("concentric", Box::new(|i| boxed([-(i as f32); 3], [2.0 * i as f32; 3]))),
            ("one plane of nested squares", Box::new(|i| boxed([-(i as f32), 0.0, -1.0], [2.0 * i as f32, 0.0, 2.0]))),
            ("a common corner", Box::new(|i| boxed([0.0; 3], [i as f32; 3]))),
            ("geometric", Box::new(|i| boxed([0.0; 3], [(i as f32 * -0.005).exp2(); 3]))),
            ("geometric places", Box::new(|i| boxed([((i % 2000) as f32 * 0.03).exp2(), 0.0, 0.0], [1e-3; 3]))),
            ("a row", Box::new(move |i| boxed([i as f32, 0.0, 0.0], unit))),
            ("hay", Box::new(move |i| boxed([random(i), random(i + n), random(i + 2 * n)].map(|x| x * 1e-3), unit))),
            ("last bits", Box::new(move |i| boxed([f32::from_bits(0x3f80_0000 + i as u32 % 7), 0.0, 0.0], unit))),
            ("denormal places", Box::new(|i| boxed([f32::from_bits(i as u32 % 9), 0.0, 0.0], [0.0; 3]))),
        ];
        for (name, face) in inputs {
            for n in [1, 2, 5, 8, 9, 17, n] {
                let mut items: Vec<_> = (0..n).map(|i| Item::new(face(i), i as u32)).collect();
                let nodes = build(&mut items);
                let (depth, passes) = work(&nodes);
                let halvings = (n as f64).log2();
                assert!(
                    depth <= MAX_DEPTH && passes <= 3.0 * halvings + 1.0,
                    "{name}, {n}: {depth} deep, {passes} passes"
                );
                let mut seen = vec![false; n];
                for node in &nodes {
                    if node.is_leaf() {
                        for item in &items[node.first as usize..][..node.count as usize] {
                            assert!(!std::mem::replace(&mut seen[item.index as usize], true));
                            assert_eq!(node.bounds, node.bounds.union(&item.bounds));
                        }
                    } else {
                        let [a, b] = node.children().map(|c| nodes[c].bounds);
                        assert_eq!(node.bounds, a.union(&b));
                    }
                }
                assert!(seen.into_iter().all(|seen| seen));
            }
        }
    }

    /// Cuts that take off one face at a time end in halves, within the depth that the walks rely on.
    #[test]
    fn depth_is_bounded() {
        // Each face as large as all before it together, spaced so that one bin holds all but the last.
        let mut items: Vec<_> =
            (0..4_000).map(|i| Item::new(boxed([(i as f32 * 0.03).exp2(); 3], [0.0; 3]), i)).collect();
        let mut worst = 0;
        for base in [1.2_f32, 2.0, 40.0] {
            for (i, item) in items.iter_mut().enumerate() {
                let place = base.powf((i % 60) as f32 * 60.0_f32.min(120.0 / base.log2()) / 60.0 - 60.0);
                *item = Item::new(boxed([place, place, 0.0], [place * 0.01; 3]), i as u32);
            }
            worst = worst.max(work(&build(&mut items)).0);
        }
        assert!((12..=MAX_DEPTH).contains(&worst), "{worst}");
        let halved = split(&mut items, 13);
        assert_eq!(halved, 2_000);
    }
}
