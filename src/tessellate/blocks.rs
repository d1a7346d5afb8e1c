//! From what faces need and how edges are split to the blocks that are drawn, whoever decided it.

use super::quadtree::{Node, Quadtree, Shape, Side};
use super::tree::Forest;
use super::{CHUNK, Leaf, Move, NO_LIST, Reach, Tessellation};
use crate::limits::{LimitError, Limits};
use crate::surface::Surface;
use crate::topology::Topology;
use rayon::prelude::*;

/// What the surface needs inside of the faces of a chunk: quadtrees one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Where the tree of each face ends.
    pub(super) ends: Vec<u32>,
    pub(super) nodes: Vec<Node>,
}

/// Quadtrees of all faces that are drawn or lie beside one, before edges are heard.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    pub(super) drawn: Vec<bool>,
    pub(super) parts: Vec<Part>,
}

impl Needs {
    /// Nodes of face `q`; none where it is far from what is drawn.
    pub(super) fn nodes(&self, q: u32) -> &[Node] {
        let (part, i) = (&self.parts[q as usize / CHUNK], q as usize % CHUNK);
        let first = if i == 0 { 0 } else { part.ends[i - 1] };
        &part.nodes[first as usize..part.ends[i] as usize]
    }

    /// Deepest level that anything needs.
    pub(super) fn deepest(&self) -> u32 {
        let nodes = self.parts.iter().flat_map(|p| &p.nodes);
        let leaves = nodes.filter(|n| n.is_leaf());
        leaves.map(Node::level).max().unwrap_or(0)
    }

    pub(super) fn bytes(&self) -> usize {
        let parts = self.parts.iter();
        parts.map(|p| p.nodes.len() * size_of::<Node>()).sum()
    }
}

/// The blocks of all faces that are drawn.
pub(super) fn blocks(
    surface: &Surface,
    needs: &Needs,
    trees: &Forest,
    reach: Reach,
    limits: &Limits,
) -> Result<Tessellation, LimitError> {
    let faces = surface.whole_quads().face_count();
    let shape = Shape::of(surface);
    let parts: Vec<Tessellation> = (0..faces.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || Quadtree::new(shape, reach.squares),
            |tree, k| {
                limits.check()?;
                let mut out = Tessellation::default();
                for q in k * CHUNK..((k + 1) * CHUNK).min(faces) {
                    if needs.drawn[q] {
                        tree.nodes.clear();
                        tree.nodes.extend_from_slice(needs.nodes(q as u32));
                        face_blocks(surface, tree, trees, reach, q as u32, &mut out);
                    }
                }
                limits.memory("the blocks of the tessellation", out.bytes() as u128)?;
                Ok(out)
            },
        )
        .collect::<Result<_, LimitError>>()?;
    let bytes: usize = parts.iter().map(Tessellation::bytes).sum();
    limits.memory("the blocks of the tessellation", 2 * bytes as u128)?;
    let mut out = Tessellation {
        triangular: shape == Shape::Triangle,
        ..Tessellation::default()
    };
    for part in &parts {
        out.append(part);
    }
    Ok(out)
}

fn face_blocks(
    surface: &Surface,
    tree: &mut Quadtree,
    trees: &Forest,
    reach: Reach,
    q: u32,
    out: &mut Tessellation,
) {
    let quads = surface.whole_quads();
    let mut sides = [Side::default(); 4];
    for (side, h) in sides.iter_mut().zip(quads.face_halves(q)) {
        *side = Side {
            tree: trees.get(quads.edge(h)),
            reversed: runs_back(quads, h),
        };
    }
    let edges = sides.iter().map(|s| s.tree.depth()).max().unwrap_or(0);
    if edges == 0 && tree.is_flat() {
        out.leaves.push(Leaf {
            quad: q,
            reach: reach.prepared(0) as u8,
            level: 0,
            log: 0,
            start: [0; 2],
            moves_end: out.moves.len() as u32,
            list: NO_LIST,
        });
        return;
    }
    tree.balance(&sides);
    let reach = reach.prepared(tree.deepest().max(edges));
    let moves = &mut out.moves;
    for node in tree.nodes.iter().filter(|n| n.is_leaf()) {
        rim(tree, node, &sides, reach, moves);
        let log = node.level() - node.depth();
        out.leaves.push(Leaf {
            quad: q,
            reach: reach as u8,
            level: node.level() as u8,
            log: log as u8,
            start: node.place().map(|k| (k << log) as u16),
            moves_end: moves.len() as u32,
            list: NO_LIST,
        });
    }
}

/// Whether half-edge `h` runs against its edge's first one.
pub(crate) fn runs_back(quads: &Topology, h: u32) -> bool {
    let first = quads.edge_half(quads.edge(h));
    quads.vertex(first) != quads.vertex(h)
}

/// The moves of a leaf's rim.
fn rim(tree: &Quadtree, leaf: &Node, sides: &[Side<'_>; 4], reach: u32, out: &mut Vec<Move>) {
    let log = leaf.level() - leaf.depth();
    let n = 1_u32 << log;
    let start = leaf.place().map(|k| k << log);
    let up = reach - leaf.level();
    let shape = leaf.shape(tree.face);
    let own = shape.sides();
    for c in 0..own {
        for k in 0..n {
            let [i, j] = match (shape, c) {
                (_, 0) => [k, 0],
                (_, 1) => [n, k],
                (Shape::Square, 2) => [n - k, n],
                (Shape::Square, _) => [0, n - k],
                (Shape::Triangle, _) => [n - k; 2],
            };
            let at = [start[0] + i, start[1] + j];
            // The corner at the start of a side may be moved along the side before it as well.
            let mut to = tree.drawn(leaf, sides, c, at);
            if k == 0 && to == at {
                to = tree.drawn(leaf, sides, (c + own - 1) % own, at);
            }
            if to != at {
                out.push(Move {
                    at: [i as u8, j as u8],
                    to: to.map(|k| (k << up) as u16),
                });
            }
        }
    }
}
