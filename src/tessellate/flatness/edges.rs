//! Which segments of each cage edge are split: from the edge's own samples, and from what its faces need beside it, once.
//!
//! A chord is held against samples a quarter of it apart (a half, at the last levels). Those of a cubic curve tell its distance exactly
//! but for the place of its extremes; c-shaped and s-shaped curves are seen alike.

use super::screen::{Excess, Metric};
use crate::dice::face::Sides;
use crate::limits::{LimitError, Limits};
use crate::math;
use crate::simd::Level;
use crate::surface::{QuadPatch, Surface};
use crate::tessellate::CHUNK;
use crate::tessellate::blocks::{Needs, runs_back};
use crate::tessellate::quadtree::{Shape, ask};
use crate::tessellate::tree::{Forest, Splits};
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// Levels that edges are sampled at, one after the other while they last; the last is the deepest that there is.
const LEVELS: [u32; 3] = [4, 7, 10];

/// Samples of an edge, in its own direction.
#[derive(Default)]
struct Line {
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

/// Trees of all edges of the surface's quads, by number.
pub(super) fn trees(
    surface: &Surface,
    metric: &Metric<'_>,
    needs: &Needs,
    limits: &Limits,
) -> Result<Forest, LimitError> {
    let quads = surface.whole_quads();
    let faces = quads.face_count();
    let parts: Vec<Vec<(u32, Splits)>> = (0..faces.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || (QuadPatch::for_level(Level::detect()), Line::default()),
            |(patch, line), k| {
                limits.check()?;
                let mut out = Vec::new();
                for q in k * CHUNK..((k + 1) * CHUNK).min(faces) {
                    face(surface, metric, needs, patch, line, q as u32, &mut out);
                }
                Ok(out)
            },
        )
        .collect::<Result<_, LimitError>>()?;
    let mut forest = Forest::new(quads.edge_count());
    for (edge, mut splits) in parts.into_iter().flatten() {
        let (depth, words) = splits.words();
        forest.set(edge, depth, words);
    }
    Ok(forest)
}

/// Trees of the edges that quad `q` is the first face of, those without splits left out.
fn face(
    surface: &Surface,
    metric: &Metric<'_>,
    needs: &Needs,
    patch: &mut QuadPatch,
    line: &mut Line,
    q: u32,
    out: &mut Vec<(u32, Splits)>,
) {
    let quads = surface.whole_quads();
    let own = quads.face_halves(q);
    // Edges that are not drawn need no tree.
    let mut open = [false; 4];
    for (open, h) in open.iter_mut().zip(own.clone()) {
        let mut faces = halves(quads, h).map(|h| quads.face_of(h));
        *open = quads.edge_half(quads.edge(h)) == h && faces.any(|q| needs.drawn[q as usize]);
    }
    let mut splits = [const { None::<Splits> }; 4];
    for level in LEVELS {
        if open == [false; 4] {
            break;
        }
        let level = metric.reach.prepared(level);
        patch.prepare_points(surface, q, level, None, Sides::Normals);
        for c in 0..4 {
            if open[c] {
                patch.side(surface, c, &mut line.points, &mut line.normals);
                let mut found = Splits::default();
                open[c] = line.split(metric, level, &mut found);
                splits[c] = Some(found);
            }
        }
    }
    let shape = Shape::of(surface);
    for (h, splits) in own.zip(splits) {
        let Some(mut splits) = splits else { continue };
        for h in halves(quads, h) {
            let face = quads.face_of(h);
            let c = (h - quads.face_halves(face).start) as usize;
            ask(
                needs.nodes(face),
                shape,
                c,
                runs_back(quads, h),
                &mut splits,
            );
        }
        if splits.depth > 0 {
            out.push((quads.edge(h), splits));
        }
    }
}

/// Half-edges of an edge: `h` and its twin.
fn halves(quads: &Topology, h: u32) -> impl Iterator<Item = u32> {
    let twin = Some(quads.twin(h)).filter(|&t| t != NONE);
    std::iter::once(h).chain(twin)
}

impl Line {
    /// Splits what has to be, of an edge sampled at `level`; says whether more samples would show more.
    fn split(&self, metric: &Metric<'_>, level: u32, splits: &mut Splits) -> bool {
        splits.clear();
        let mut more = false;
        // Nodes that may be split, depth by depth.
        let mut nodes = vec![1_usize];
        for depth in 0..metric.max_level {
            let step = 1_usize << (level - depth);
            // Half a segment's samples tell enough only where there are no others to come.
            if step < 4 && level < metric.reach.level {
                more = !nodes.is_empty();
                break;
            }
            if step < 2 {
                break;
            }
            let mut next = Vec::new();
            for node in nodes {
                let from = (node - (1 << depth)) * step;
                if self.excess(metric, from, step) > 1.0 {
                    splits.split(node);
                    next.extend([2 * node, 2 * node + 1]);
                }
            }
            nodes = next;
        }
        more
    }

    /// How far the curve and its normals are from the chord of `step` samples from `from` on.
    fn excess(&self, metric: &Metric<'_>, from: usize, step: usize) -> Excess {
        let (a, b) = (self.points[from], self.points[from + step]);
        let (na, nb) = (self.normals[from], self.normals[from + step]);
        let middle = self.points[from + step / 2];
        let bent = !metric.is_dot(&[a, b, middle]);
        let quarter = (step / 4).max(1);
        let depths = (from..=from + step).step_by(quarter);
        let nearest = depths
            .map(|k| metric.depth(self.points[k]))
            .fold(f32::INFINITY, f32::min);
        let mut worst = 0.0_f32;
        for k in (quarter..step).step_by(quarter) {
            let t = k as f32 / step as f32;
            let mix =
                |a: [f32; 3], b: [f32; 3]| math::add(math::scale(a, 1.0 - t), math::scale(b, t));
            let at = from + k;
            worst = worst.max(metric.point(self.points[at], mix(a, b), nearest));
            if bent {
                worst = worst.max(metric.normal(self.normals[at], mix(na, nb)));
            }
        }
        worst
    }
}
