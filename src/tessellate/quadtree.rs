//! The quadtree of a face: squares, the level of each, and which points they have where they meet. Of a triangle, squares on the diagonal
//! are half of one; those above it are void.
//!
//! Squares at a line inside of the face show the points of the coarser of the two. So that what moves stays within its square and triangles
//! beside the line are not drawn out, levels of neighbours differ by one at most, and the corners of a square are points of its neighbours
//! ([`Quadtree::balance`]). Squares out of the picture need nothing, and have all points of neighbours that are in it. Along sides of the face the points are those of the edge's tree.

use super::tree::{Splits, Tree};
use crate::dice::MAX_LEVEL;
use crate::surface::Surface;

/// Micro-quads along the side of a leaf, as a power of two.
pub(super) const MAX_LOG: u32 = 5;

/// Length of the face's side in the units of boxes.
const FULL: u32 = 1 << MAX_LEVEL;

/// Children of a square above the diagonal of a triangle.
const VOID: u32 = u32::MAX;

/// What the parameters of a face fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Square,
    /// The half where the row is at most the column.
    Triangle,
}

impl Shape {
    pub(super) fn of(surface: &Surface) -> Self {
        match surface.is_triangular() {
            true => Self::Triangle,
            false => Self::Square,
        }
    }

    /// Of its square at a place.
    pub(super) fn part(self, [x, y]: [u32; 2]) -> Self {
        match self {
            Self::Triangle if x == y => Self::Triangle,
            _ => Self::Square,
        }
    }

    /// Number of sides.
    pub(super) fn sides(self) -> usize {
        match self {
            Self::Square => 4,
            Self::Triangle => 3,
        }
    }
}

/// A square of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    depth: u8,
    /// Level that the surface in it needs, and that of its micro-quads; of leaves.
    need: u8,
    level: u8,
    /// Column and row among the `2^depth` by `2^depth` squares.
    place: [u16; 2],
    /// Whether nothing of it can be in the picture.
    hidden: bool,
    /// First of four children, 0 for a leaf, or [`VOID`].
    children: u32,
}

/// A side of a face: the tree of its edge, and whether the edge runs against the side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side<'a> {
    pub(super) tree: Tree<'a>,
    pub(super) reversed: bool,
}

/// The root is the first node.
#[derive(Clone, Debug)]
pub(super) struct Quadtree {
    pub(super) nodes: Vec<Node>,
    pub(super) face: Shape,
    /// Depth of the smallest squares.
    pub(super) deepest: u32,
}

impl Node {
    const ROOT: Self = Self {
        depth: 0,
        need: 0,
        level: 0,
        place: [0, 0],
        hidden: false,
        children: 0,
    };

    /// Whether it is drawn, and not its children.
    pub(super) fn is_leaf(&self) -> bool {
        self.children == 0
    }
    /// Its own shape in a face.
    pub(super) fn shape(&self, face: Shape) -> Shape {
        face.part(self.place())
    }
    pub(super) fn depth(&self) -> u32 {
        u32::from(self.depth)
    }
    pub(super) fn level(&self) -> u32 {
        u32::from(self.level)
    }
    pub(super) fn place(&self) -> [u32; 2] {
        self.place.map(u32::from)
    }
    /// Its box: low and high corner.
    fn bounds(&self) -> [[u32; 2]; 2] {
        let size = FULL >> self.depth;
        let low = self.place().map(|k| k * size);
        [low, low.map(|k| k + size)]
    }
    /// Number of the segment along side `c` of the face among the `2^depth` of it, if the square lies there.
    fn segment(&self, face: Shape, c: usize) -> Option<u32> {
        let last = (1 << self.depth) - 1;
        let [x, y] = self.place();
        match (face, c) {
            (_, 0) => (y == 0).then_some(x),
            (_, 1) => (x == last).then_some(y),
            (Shape::Square, 2) => (y == last).then(|| last - x),
            (Shape::Square, _) => (x == 0).then(|| last - y),
            (Shape::Triangle, _) => (x == y).then(|| last - x),
        }
    }
}

fn turned(reversed: bool, depth: u32, segment: u32) -> u32 {
    if reversed {
        (1 << depth) - 1 - segment
    } else {
        segment
    }
}

impl Side<'_> {
    fn deepest(&self, depth: u32, segment: u32) -> u32 {
        self.tree
            .deepest(depth, turned(self.reversed, depth, segment))
    }
    fn nearest(&self, level: u32, t: u32) -> u32 {
        let n = 1 << level;
        let turn = |t: u32| if self.reversed { n - t } else { t };
        turn(self.tree.nearest(level, turn(t)))
    }
}

/// Adds to the splits of an edge the points that the leaves of a face at its side `c` ask for: all of their own, so that triangles beside
/// the edge are not drawn out (measured: every second point of theirs costs half more distance and saves a quarter of the triangles).
pub(super) fn ask(nodes: &[Node], face: Shape, c: usize, reversed: bool, splits: &mut Splits) {
    for leaf in nodes.iter().filter(|n| n.is_leaf()) {
        if let Some(segment) = leaf.segment(face, c) {
            let (depth, level) = (leaf.depth(), u32::from(leaf.need));
            let place = turned(reversed, depth, segment);
            for d in 0..level {
                if d <= depth {
                    splits.split((1 << d) + (place >> (depth - d)) as usize);
                } else {
                    let first = (1_usize << d) + ((place as usize) << (d - depth));
                    (first..first + (1 << (d - depth))).for_each(|node| splits.split(node));
                }
            }
        }
    }
}

impl Quadtree {
    pub(super) fn new(face: Shape, deepest: u32) -> Self {
        Self {
            nodes: vec![Node::ROOT],
            face,
            deepest,
        }
    }

    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.nodes.push(Node::ROOT);
    }

    /// Whether it is one block of level 0.
    pub(super) fn is_flat(&self) -> bool {
        matches!(&self.nodes[..], [root] if root.is_leaf() && root.level == 0)
    }

    /// Says what a leaf needs.
    pub(super) fn set_need(&mut self, node: usize, level: u32) {
        self.nodes[node].need = level as u8;
        self.nodes[node].level = level as u8;
    }

    /// Says that nothing of a leaf can be in the picture: it needs nothing.
    pub(super) fn hide(&mut self, node: usize) {
        let depth = self.nodes[node].depth();
        self.set_need(node, depth);
        self.nodes[node].hidden = true;
    }

    /// Splits a leaf into four that need the same.
    pub(super) fn split(&mut self, node: usize) -> usize {
        let parent = self.nodes[node];
        let first = self.nodes.len();
        let depth = parent.depth + 1;
        for k in 0..4_u16 {
            let [x, y] = parent.place;
            let void = k == 2 && parent.shape(self.face) == Shape::Triangle;
            self.nodes.push(Node {
                depth,
                need: parent.need.max(depth),
                level: parent.need.max(depth),
                place: [2 * x + (k & 1), 2 * y + (k >> 1)],
                hidden: parent.hidden,
                children: if void { VOID } else { 0 },
            });
        }
        self.nodes[node].children = first as u32;
        first
    }

    /// Calls `each` for the leaves that share area with a box.
    fn overlapping(&self, node: usize, [low, high]: [[u32; 2]; 2], each: &mut impl FnMut(&Node)) {
        let n = &self.nodes[node];
        let [from, to] = n.bounds();
        if n.children == VOID || (0..2).any(|k| to[k] <= low[k] || from[k] >= high[k]) {
            return;
        }
        if n.is_leaf() {
            return each(n);
        }
        for k in 0..4 {
            self.overlapping(n.children as usize + k, [low, high], each);
        }
    }

    /// The box of unit thickness beyond side `c` of a node; `None` outside of the face.
    fn beyond(node: &Node, c: usize) -> Option<[[u32; 2]; 2]> {
        let [low, high] = node.bounds();
        let axis = usize::from(c.is_multiple_of(2));
        let (mut from, mut to) = (low, high);
        if c == 1 || c == 2 {
            (from[axis], to[axis]) = (high[axis], high[axis] + 1);
            (high[axis] < FULL).then_some([from, to])
        } else {
            if low[axis] == 0 {
                return None;
            }
            (from[axis], to[axis]) = (low[axis] - 1, low[axis]);
            Some([from, to])
        }
    }

    /// Raises levels and splits leaves until every leaf has the points of the edges at its sides, levels of neighbours differ by one at most,
    /// and corners of neighbours are among a leaf's points.
    pub(super) fn balance(&mut self, sides: &[Side<'_>; 4]) {
        let mut changed = true;
        while changed {
            changed = false;
            let mut i = 0;
            while i < self.nodes.len() {
                let node = self.nodes[i];
                if node.is_leaf() {
                    let level = self.wanted(&node, sides);
                    // Far more than it needs is wanted along a side only: better of the part that lies there.
                    let much = level > u32::from(node.need) + 1 && level > node.depth() + 2;
                    let large = level > node.depth() + MAX_LOG;
                    if (large || much) && node.depth() < self.deepest {
                        self.split(i);
                        changed = true;
                    } else if level > node.level() {
                        self.nodes[i].level = level as u8;
                        changed = true;
                    }
                }
                i += 1;
            }
        }
    }

    fn wanted(&self, node: &Node, sides: &[Side<'_>; 4]) -> u32 {
        let mut level = node.level();
        let own = node.shape(self.face).sides();
        for (c, side) in sides.iter().enumerate().take(own) {
            if let Some(segment) = node.segment(self.face, c) {
                level = level.max(side.deepest(node.depth(), segment));
            } else if let Some(beyond) = Self::beyond(node, c) {
                self.overlapping(0, beyond, &mut |other| {
                    // What is hidden must not take points from what is not: that is measured with all of its own.
                    let less = u32::from(other.hidden || !node.hidden);
                    level = level
                        .max(other.depth())
                        .max(other.level().saturating_sub(less));
                });
            }
        }
        level
    }

    /// Level of the deepest leaf.
    pub(super) fn deepest(&self) -> u32 {
        let leaves = self.nodes.iter().filter(|n| n.is_leaf());
        leaves.map(Node::level).max().unwrap_or(0)
    }

    /// Where the point (`x`, `y`) of a leaf's grid of its level is drawn: itself, or the nearest that both sides of its line have. The point
    /// lies on side `c` of the leaf.
    pub(super) fn drawn(
        &self,
        leaf: &Node,
        sides: &[Side<'_>; 4],
        c: usize,
        at: [u32; 2],
    ) -> [u32; 2] {
        let level = leaf.level();
        if leaf.segment(self.face, c).is_some() {
            return on_side(self.face, sides, c, level, at);
        }
        // Along a line inside of the face. Ends of the leaf's side are points of both.
        let along = usize::from(c % 2 == 1);
        let size = 1 << (level - leaf.depth());
        let mut at = at;
        if !at[along].is_multiple_of(size) {
            let unit = FULL >> level;
            if let Some([mut low, mut high]) = Self::beyond(leaf, c) {
                // What lies beyond the point, on both sides of it.
                (low[along], high[along]) = (at[along] * unit - 1, at[along] * unit + 1);
                let (mut coarse, mut corner) = (level, false);
                self.overlapping(0, [low, high], &mut |other| {
                    coarse = coarse.min(other.level());
                    let [from, to] = other.bounds();
                    corner |= [from, to].iter().any(|b| b[along] == at[along] * unit);
                });
                let step = 1 << (level - coarse);
                if !corner && !at[along].is_multiple_of(step) {
                    at[along] = (at[along] + (step - 1) / 2) / step * step;
                }
            }
        }
        // It may have come to a side of the face.
        let n = 1_u32 << level;
        let ends = match self.face {
            Shape::Square => [at[1] == 0, at[0] == n, at[1] == n, at[0] == 0],
            Shape::Triangle => [at[1] == 0, at[0] == n, at[0] == at[1], false],
        };
        match ends.iter().position(|&on| on) {
            Some(side) => on_side(self.face, sides, side, level, at),
            None => at,
        }
    }
}

/// Where a point on side `c` of the face is drawn.
fn on_side(face: Shape, sides: &[Side<'_>; 4], c: usize, level: u32, [x, y]: [u32; 2]) -> [u32; 2] {
    let n = 1_u32 << level;
    let nearest = |t: u32| sides[c].nearest(level, t);
    match (face, c) {
        (_, 0) => [nearest(x), 0],
        (_, 1) => [n, nearest(y)],
        (Shape::Square, 2) => [n - nearest(n - x), n],
        (Shape::Square, _) => [0, n - nearest(n - y)],
        (Shape::Triangle, _) => [n - nearest(n - x); 2],
    }
}
