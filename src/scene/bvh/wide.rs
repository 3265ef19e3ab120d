//! The tree with eight children a node and eight triangles a leaf, as structures of arrays.

use std::collections::HashMap;

use super::tree::Node;
use super::{LEAF, WIDTH};

/// Eight child boxes: smallest x, y, z, then largest x, y, z; lanes without a child are inside out.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(in crate::scene) struct WideNode {
    pub(in crate::scene) bounds: [[f32; WIDTH]; 6],
    /// Index of the child node, or of the leaf with [`LEAF`] set.
    pub(in crate::scene) children: [u32; WIDTH],
}

impl WideNode {
    fn empty() -> Self {
        let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { bounds: [low, low, low, high, high, high], children: [0; WIDTH] }
    }
}

/// Up to eight triangles: `corners[corner][axis][lane]`; spare lanes repeat the first one.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(in crate::scene) struct Leaf {
    pub(in crate::scene) corners: [[[f32; WIDTH]; 3]; 3],
    pub(in crate::scene) len: usize,
}

/// Nodes, root first, and leaves; no node if one leaf holds everything.
#[derive(Debug, Clone, Default)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<WideNode>,
    pub(super) leaves: Vec<Leaf>,
    pub(super) depth: usize,
}

impl WideTree {
    /// The wide copy of a binary tree, of triangles in its order.
    ///
    /// From the leaves up: the largest subtrees of at most eight triangles become leaves, the largest of at most eight
    /// leaves nodes above them, and so on. That fills nodes better than opening boxes from the root down.
    pub(super) fn new(nodes: &[Node], triangles: &[[[f32; 3]; 3]]) -> Self {
        let mut out = Self::default();
        if nodes.is_empty() {
            return out;
        }
        // The triangles, later the units, below every node; parents come before their children.
        let mut count = vec![0_usize; nodes.len()];
        for (i, node) in nodes.iter().enumerate().rev() {
            count[i] = if node.is_leaf() { node.count as usize } else { sum(node, &count) };
        }
        // The units that a wide node's subtree was made of, by the subtree's root.
        let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
        let mut is_unit = vec![false; nodes.len()];
        // A leaf of the binary tree has at most eight triangles, so that every one is in a unit.
        mark_units(nodes, &count, &mut is_unit);
        while !is_unit[0] {
            for (i, node) in nodes.iter().enumerate().rev() {
                count[i] = match (is_unit[i], node.is_leaf()) {
                    (true, _) => 1,
                    (false, true) => 0,
                    (false, false) => sum(node, &count),
                };
            }
            let below = is_unit.clone();
            mark_units(nodes, &count, &mut is_unit);
            for i in (0..nodes.len()).filter(|&i| is_unit[i] && count[i] > 1) {
                members.insert(i, units_below(nodes, i, &below));
            }
        }
        if !members.contains_key(&0) {
            out.push_leaf(nodes, triangles, 0);
            return out;
        }
        // (binary node, wide node that it becomes, depth)
        let mut todo = vec![(0_usize, 0_usize, 1_usize)];
        out.nodes.push(WideNode::empty());
        while let Some((binary, wide, level)) = todo.pop() {
            out.depth = out.depth.max(level);
            for (lane, &member) in members[&binary].iter().enumerate() {
                let bounds = nodes[member].bounds;
                let child = if members.contains_key(&member) {
                    out.nodes.push(WideNode::empty());
                    todo.push((member, out.nodes.len() - 1, level + 1));
                    out.nodes.len() as u32 - 1
                } else {
                    out.push_leaf(nodes, triangles, member) | LEAF
                };
                let slot = &mut out.nodes[wide];
                for axis in 0..3 {
                    slot.bounds[axis][lane] = bounds.low[axis];
                    slot.bounds[axis + 3][lane] = bounds.high[axis];
                }
                slot.children[lane] = child;
            }
        }
        out
    }

    /// Adds the triangles of a subtree, at most eight, as a leaf.
    fn push_leaf(&mut self, nodes: &[Node], triangles: &[[[f32; 3]; 3]], root: usize) -> u32 {
        let mut leaf = Leaf { corners: [[[0.0; WIDTH]; 3]; 3], len: 0 };
        let mut todo = vec![root];
        while let Some(index) = todo.pop() {
            let node = &nodes[index];
            if !node.is_leaf() {
                let [a, b] = node.children();
                todo.extend([b, a]);
                continue;
            }
            for triangle in &triangles[node.first as usize..][..node.count as usize] {
                for (corner, point) in triangle.iter().enumerate() {
                    for (axis, &value) in point.iter().enumerate() {
                        if leaf.len == 0 {
                            leaf.corners[corner][axis] = [value; WIDTH];
                        } else {
                            leaf.corners[corner][axis][leaf.len] = value;
                        }
                    }
                }
                leaf.len += 1;
            }
        }
        self.leaves.push(leaf);
        self.leaves.len() as u32 - 1
    }
}

fn sum(node: &Node, count: &[usize]) -> usize {
    node.children().into_iter().map(|c| count[c]).sum()
}

/// Makes the roots of the largest subtrees of at most eight units the new units.
fn mark_units(nodes: &[Node], count: &[usize], is_unit: &mut [bool]) {
    let mut todo = vec![0_usize];
    while let Some(index) = todo.pop() {
        let node = &nodes[index];
        // A subtree of one unit is that unit: its root stays where it is, further down.
        if is_unit[index] || (count[index] <= WIDTH && (count[index] > 1 || node.is_leaf())) {
            is_unit[index] = true;
        } else {
            todo.extend(node.children());
        }
    }
}

/// The units of a subtree, in the order of the tree.
fn units_below(nodes: &[Node], root: usize, is_unit: &[bool]) -> Vec<usize> {
    let mut units = vec![];
    let mut todo = vec![root];
    while let Some(index) = todo.pop() {
        if is_unit[index] {
            units.push(index);
        } else {
            let [a, b] = nodes[index].children();
            todo.extend([b, a]);
        }
    }
    units
}
