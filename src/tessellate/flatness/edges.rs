//! Which segments of each cage edge are split: from the edge's own samples, and from what its faces need beside it, once.

use super::screen::Metric;
use super::surplus::Surplus;
use crate::dice::face::Sides;
use crate::limits::{LimitError, Limits};
use crate::surface::{QuadPatch, Surface};
use crate::tessellate::blocks::{Needs, runs_back};
use crate::tessellate::quadtree::{Shape, ask};
use crate::tessellate::tree::{Forest, Splits};
use crate::topology::{NONE, Topology};

/// Levels that edges are sampled at, one after the other while they last; the last is the deepest that there is.
const LEVELS: [u32; 4] = [3, 5, 8, 10];

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct Lines {
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    nodes: Vec<usize>,
    next: Vec<usize>,
}

/// What edges' own curves ask for, where they are sampled: their number and splits, in the order of edges' first faces.
pub(super) type Own = Vec<(u32, Splits)>;

/// Half-edges of an edge: `h` and its twin.
pub(super) fn halves(quads: &Topology, h: u32) -> impl Iterator<Item = u32> {
    let twin = Some(quads.twin(h)).filter(|&t| t != NONE);
    std::iter::once(h).chain(twin)
}

/// A face whose edges are asked.
pub(super) struct Face<'a> {
    pub(super) surface: &'a Surface,
    pub(super) drawn: &'a [bool],
    pub(super) q: u32,
}

impl Face<'_> {
    /// Adds the splits of the edges that the face is the first of, by samples of their own. `patch` is prepared as `prepared` says.
    pub(super) fn split(
        &self,
        metric: &Metric<'_>,
        lines: &mut Lines,
        surplus: &mut Surplus,
        (patch, prepared): (&mut QuadPatch, &mut Option<(u32, Sides)>),
        out: &mut Own,
    ) {
        let quads = self.surface.whole_quads();
        let own = quads.face_halves(self.q);
        // Edges that are not drawn need no tree.
        let mut open = [false; 4];
        for (open, h) in open.iter_mut().zip(own.clone()) {
            let mut faces = halves(quads, h).map(|h| quads.face_of(h));
            *open = quads.edge_half(quads.edge(h)) == h && faces.any(|q| self.drawn[q as usize]);
        }
        let first = out.len();
        out.extend(
            own.clone()
                .filter(|h| open[(h - own.start) as usize])
                .map(|h| (quads.edge(h), Splits::default())),
        );
        for level in LEVELS {
            if open == [false; 4] {
                break;
            }
            let level = metric.reach.prepared(level);
            let level = match *prepared {
                Some((have, Sides::Normals)) if have >= level => have,
                _ => {
                    patch.prepare_points(self.surface, self.q, level, None, Sides::Normals);
                    *prepared = Some((level, Sides::Normals));
                    level
                }
            };
            let mut at = first;
            for (c, h) in own.clone().enumerate() {
                let edge = quads.edge(h);
                if out.get(at).is_none_or(|o| o.0 != edge) {
                    continue;
                }
                if open[c] {
                    patch.side(self.surface, c, &mut lines.points, &mut lines.normals);
                    open[c] = lines.split(metric, surplus, level, &mut out[at].1);
                }
                at += 1;
            }
        }
    }
}

impl Lines {
    /// Splits what has to be, of an edge sampled at `level`; says whether more samples would show more.
    fn split(
        &mut self,
        metric: &Metric<'_>,
        surplus: &mut Surplus,
        level: u32,
        splits: &mut Splits,
    ) -> bool {
        splits.clear();
        surplus.line(metric, level, &self.points, &self.normals);
        // Nodes that may be split, depth by depth.
        self.nodes.clear();
        self.nodes.push(1);
        for depth in 0..metric.max_level {
            self.next.clear();
            for &node in &self.nodes {
                match surplus.is_bent(depth, node - (1 << depth)) {
                    Some(true) => {
                        splits.split(node);
                        self.next.extend([2 * node, 2 * node + 1]);
                    }
                    Some(false) => {}
                    None => return level < metric.reach.level,
                }
            }
            std::mem::swap(&mut self.nodes, &mut self.next);
        }
        false
    }
}

/// Trees of all edges at faces that are drawn, by number.
pub(super) fn trees(
    surface: &Surface,
    needs: &Needs,
    own: Vec<Own>,
    limits: &Limits,
) -> Result<Forest, LimitError> {
    let quads = surface.whole_quads();
    let shape = Shape::of(surface);
    let mut forest = Forest::new(quads.edge_count());
    let mut own: Vec<(u32, Splits)> = own.into_iter().flatten().collect();
    own.sort_unstable_by_key(|o| o.0);
    // Flat faces ask for nothing.
    let wants = |q: u32| needs.nodes(q).iter().any(|n| n.is_leaf() && n.level() > 0);
    let asks: Vec<bool> = (0..quads.face_count() as u32).map(wants).collect();
    let mut set = |edge: u32, mut splits: Splits| {
        for h in halves(quads, quads.edge_half(edge)) {
            let face = quads.face_of(h);
            let c = (h - quads.face_halves(face).start) as usize;
            let back = runs_back(quads, h);
            ask(needs.nodes(face), shape, c, back, &mut splits);
        }
        if splits.depth > 0 {
            let (depth, words) = splits.words();
            forest.set(edge, depth, words);
        }
    };
    for q in 0..quads.face_count() as u32 {
        if q.is_multiple_of(4096) {
            limits.check()?;
        }
        if !asks[q as usize] {
            continue;
        }
        for h in quads.face_halves(q) {
            let edge = quads.edge(h);
            let faces = || halves(quads, quads.edge_half(edge)).map(|h| quads.face_of(h));
            // Once, and not where own splits wait.
            let first = faces().find(|&q| asks[q as usize]) == Some(q);
            let waits = own.binary_search_by_key(&edge, |o| o.0).is_ok();
            if first && !waits && faces().any(|q| needs.drawn[q as usize]) {
                set(edge, Splits::default());
            }
        }
    }
    for (edge, splits) in own {
        set(edge, splits);
    }
    Ok(forest)
}
