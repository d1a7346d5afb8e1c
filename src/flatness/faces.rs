//! Blocks of every face: from samples of its inside, as far as they are needed.

use super::cells::Samples;
use super::edges::CHUNK;
use super::quadtree::{MAX_LOG, Node, Quadtree, Side};
use super::screen::Metric;
use super::tree::Forest;
use super::{Leaf, Move, Tessellation};
use crate::dice::MAX_LEVEL;
use crate::dice::face::{Part as Square, Sides};
use crate::limits::{LimitError, Limits};
use crate::records::Grid3;
use crate::simd::Level;
use crate::surface::{QuadPatch, Surface};
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// What a block costs beside its micro-quads, in micro-quads.
const OVERHEAD: u32 = 8;

/// Depth below a sampled square at which its parts are sampled on their own.
const RESAMPLED: u32 = 3;

/// Need of a square whose samples do not tell.
const DEEPER: u32 = MAX_LOG + 1;

/// What the surface needs inside of the faces of a chunk: quadtrees one after the other.
#[derive(Clone, Debug, Default)]
struct Part {
    /// Where the tree of each face ends.
    ends: Vec<u32>,
    nodes: Vec<Node>,
}

/// Quadtrees of all faces that are drawn or lie beside one, before edges are heard.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    pub(super) drawn: Vec<bool>,
    parts: Vec<Part>,
}

impl Needs {
    /// Nodes of face `q`; none where it is far from what is drawn.
    pub(super) fn nodes(&self, q: u32) -> &[Node] {
        let (part, i) = (&self.parts[q as usize / CHUNK], q as usize % CHUNK);
        let first = if i == 0 { 0 } else { part.ends[i - 1] };
        &part.nodes[first as usize..part.ends[i] as usize]
    }

    pub(super) fn bytes(&self) -> usize {
        let parts = self.parts.iter();
        parts.map(|p| p.nodes.len() * size_of::<Node>()).sum()
    }
}

/// Says which faces `is_drawn` (it gets the quad and points whose hull holds it) and finds what those and their neighbours need.
pub(super) fn needs(
    surface: &Surface,
    metric: &Metric<'_>,
    limits: &Limits,
    is_drawn: impl Fn(u32, &mut Vec<[f32; 3]>) -> bool + Sync,
) -> Result<Needs, LimitError> {
    let quads = surface.whole_quads();
    let faces = quads.face_count();
    let mut drawn = vec![false; faces];
    drawn.par_chunks_mut(CHUNK).enumerate().try_for_each_init(
        || (QuadPatch::for_level(Level::detect()), Vec::new()),
        |(patch, hull), (k, drawn)| {
            limits.check()?;
            for (i, drawn) in drawn.iter_mut().enumerate() {
                let q = (k * CHUNK + i) as u32;
                hull.clear();
                patch.prepare_points(surface, q, MAX_LEVEL, None, Sides::Hull);
                patch.hull(|p| hull.push(p));
                *drawn = is_drawn(q, hull);
            }
            Ok(())
        },
    )?;
    // An edge asks both of its faces, whichever is drawn: what is outside of the picture must not change what is inside.
    let near = |q: usize| {
        drawn[q]
            || (4 * q..4 * q + 4).any(|h| {
                let twin = quads.twin(h as u32);
                twin != NONE && drawn[twin as usize / 4]
            })
    };
    let parts = (0..faces.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || Worker::new(surface, metric),
            |worker, k| {
                limits.check()?;
                let mut out = Part::default();
                for q in k * CHUNK..((k + 1) * CHUNK).min(faces) {
                    if near(q) {
                        worker.face(q as u32);
                        out.nodes.extend_from_slice(&worker.tree.nodes);
                    }
                    out.ends.push(out.nodes.len() as u32);
                }
                limits.memory(
                    "the blocks of the tessellation",
                    out.nodes.len() as u128 * 12,
                )?;
                Ok(out)
            },
        )
        .collect::<Result<_, LimitError>>()?;
    let needs = Needs { drawn, parts };
    limits.memory("the blocks of the tessellation", needs.bytes() as u128)?;
    Ok(needs)
}

/// The blocks of all faces that are drawn.
pub(super) fn blocks(
    surface: &Surface,
    needs: &Needs,
    trees: &Forest,
    limits: &Limits,
) -> Result<Tessellation, LimitError> {
    let faces = surface.whole_quads().face_count();
    let parts: Vec<Tessellation> = (0..faces.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(Quadtree::new, |tree, k| {
            limits.check()?;
            let mut out = Tessellation::default();
            for q in k * CHUNK..((k + 1) * CHUNK).min(faces) {
                if needs.drawn[q] {
                    tree.nodes.clear();
                    tree.nodes.extend_from_slice(needs.nodes(q as u32));
                    face_blocks(surface, tree, trees, q as u32, &mut out);
                }
            }
            limits.memory("the blocks of the tessellation", out.bytes() as u128)?;
            Ok(out)
        })
        .collect::<Result<_, LimitError>>()?;
    let bytes: usize = parts.iter().map(Tessellation::bytes).sum();
    limits.memory("the blocks of the tessellation", 2 * bytes as u128)?;
    let mut out = Tessellation::default();
    for part in &parts {
        out.append(part);
    }
    Ok(out)
}

fn face_blocks(
    surface: &Surface,
    tree: &mut Quadtree,
    trees: &Forest,
    q: u32,
    out: &mut Tessellation,
) {
    let quads = surface.whole_quads();
    let sides = [0, 1, 2, 3].map(|c| Side {
        tree: trees.get(quads.edge(4 * q + c)),
        reversed: runs_back(quads, 4 * q + c),
    });
    tree.balance(&sides);
    let edges = sides.iter().map(|s| s.tree.depth()).max().unwrap_or(0);
    let reach = tree.deepest().max(edges);
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
        });
    }
}

/// Whether half-edge `h` runs against its edge's first one.
pub(super) fn runs_back(quads: &Topology, h: u32) -> bool {
    let first = quads.edge_half(quads.edge(h));
    quads.vertex(first) != quads.vertex(h)
}

/// Buffers of one thread.
struct Worker<'a> {
    surface: &'a Surface,
    metric: &'a Metric<'a>,
    patch: QuadPatch,
    /// Level that the face is prepared for.
    prepared: u32,
    points: Box<Grid3>,
    normals: Box<Grid3>,
    tree: Quadtree,
}

/// Levels below a sampled square that its parts need, depth by depth.
#[derive(Default)]
struct Levels(Vec<u8>);

impl Levels {
    fn index(depth: u32, x: u32, y: u32) -> usize {
        ((4_usize.pow(depth) - 1) / 3) + ((y as usize) << depth) + x as usize
    }
    fn get(&self, depth: u32, x: u32, y: u32) -> u32 {
        u32::from(self.0[Self::index(depth, x, y)])
    }

    /// Finds what a square of the samples needs; `cap` is what it may have.
    fn find(
        &mut self,
        s: &Samples<'_>,
        metric: &Metric<'_>,
        cap: u32,
        [depth, x, y]: [u32; 3],
    ) -> u32 {
        let need = if depth >= cap || s.excess(metric, depth, x, y) <= 1.0 {
            depth
        } else if depth >= s.log {
            DEEPER
        } else {
            let mut need = 0;
            for k in 0..4 {
                need = need.max(self.find(
                    s,
                    metric,
                    cap,
                    [depth + 1, 2 * x + (k & 1), 2 * y + (k >> 1)],
                ));
            }
            need
        };
        let at = Self::index(depth, x, y);
        if self.0.len() <= at {
            self.0.resize(at + 1, 0);
        }
        self.0[at] = need as u8;
        need
    }

    /// Micro-quads of the cheapest way to cut a square into blocks.
    fn cost(&self, depth: u32, x: u32, y: u32) -> u32 {
        let need = self.get(depth, x, y);
        let whole = (1 << (2 * (need - depth))) + OVERHEAD;
        if need < depth + 2 || depth >= RESAMPLED {
            return whole;
        }
        let parts = (0..4).map(|k| self.cost(depth + 1, 2 * x + (k & 1), 2 * y + (k >> 1)));
        whole.min(parts.sum())
    }
}

impl<'a> Worker<'a> {
    fn new(surface: &'a Surface, metric: &'a Metric<'a>) -> Self {
        Self {
            surface,
            metric,
            patch: QuadPatch::for_level(Level::detect()),
            prepared: 0,
            points: Grid3::boxed(),
            normals: Grid3::boxed(),
            tree: Quadtree::new(),
        }
    }

    /// Leaves in `tree` what face `q` needs.
    fn face(&mut self, q: u32) {
        self.tree.clear();
        self.prepared = 0;
        self.grow(q, 0, 2);
    }

    /// Samples leaf `node` by `2^log` segments and cuts it up as far as it needs.
    fn grow(&mut self, q: u32, node: usize, log: u32) {
        let (depth, place) = (self.tree.nodes[node].depth(), self.tree.nodes[node].place());
        let log = log.min(MAX_LEVEL - depth);
        let level = depth + log;
        if self.prepared < level {
            self.patch
                .prepare_points(self.surface, q, level, None, Sides::Normals);
            self.prepared = level;
        }
        let part = Square {
            level,
            start: place.map(|k| k << log),
            segments: 1 << log,
        };
        self.patch
            .dice_part(part, &mut self.points, Some(&mut self.normals));
        let samples = Samples {
            points: &self.points,
            normals: &self.normals,
            log,
            corners: {
                let last = (1 << depth) - 1;
                [[0, 0], [last, 0], [last, last], [0, last]].map(|corner| corner == place)
            },
        };
        let cap = self.metric.max_level.saturating_sub(depth);
        let mut needs = Levels::default();
        let need = needs.find(&samples, self.metric, cap, [0, 0, 0]);
        // A few samples tell enough of what needs next to nothing.
        if log < MAX_LOG && need + 1 > log && depth + log < MAX_LEVEL {
            return self.grow(q, node, MAX_LOG);
        }
        self.cut(q, node, &needs, [0, 0, 0]);
    }

    fn cut(&mut self, q: u32, node: usize, needs: &Levels, [depth, x, y]: [u32; 3]) {
        let need = needs.get(depth, x, y);
        let whole = (1 << (2 * (need - depth))) + OVERHEAD;
        if need < DEEPER && needs.cost(depth, x, y) >= whole {
            let own = self.tree.nodes[node].depth();
            self.tree.set_need(node, own + (need - depth));
            return;
        }
        if depth >= RESAMPLED {
            return self.grow(q, node, MAX_LOG);
        }
        let first = self.tree.split(node);
        for k in 0..4 {
            let child = [depth + 1, 2 * x + (k & 1), 2 * y + (k >> 1)];
            self.cut(q, first + k as usize, needs, child);
        }
    }
}

/// The moves of a leaf's rim.
fn rim(tree: &Quadtree, leaf: &Node, sides: &[Side<'_>; 4], reach: u32, out: &mut Vec<Move>) {
    let log = leaf.level() - leaf.depth();
    let n = 1_u32 << log;
    let start = leaf.place().map(|k| k << log);
    let up = reach - leaf.level();
    for c in 0..4 {
        for k in 0..n {
            let [i, j] = match c {
                0 => [k, 0],
                1 => [n, k],
                2 => [n - k, n],
                _ => [0, n - k],
            };
            let at = [start[0] + i, start[1] + j];
            // The corner at the start of a side may be moved along the side before it as well.
            let mut to = tree.drawn(leaf, sides, c, at);
            if k == 0 && to == at {
                to = tree.drawn(leaf, sides, (c + 3) % 4, at);
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
