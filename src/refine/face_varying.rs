//! Values per face corner (texture coordinates) through all levels.
//!
//! Where the corners at a vertex agree, and those at the far ends of its edges too, values follow the rules of points. Elsewhere each
//! distinct value at the vertex is a *sibling*; the faces that use it are its *span*. A sibling is a corner (stays), a crease (a curve
//! along the two borders of its span), or semi-sharp (a corner that becomes a crease). Which one is decided at the cage, from the equality
//! of indices alone, and inherited.

use super::connectivity::Split;
use super::interpolating::{Linear, Masks, Sheets};
use super::real::{Real, blend, midpoint};
use super::ring::Spoke;
use super::sharpness::Step;
use super::{Timings, edge, face, fill, timed, vertex};
use crate::scheme::crease::{Transition, is_semi_sharp};
use crate::scheme::{FaceVaryingRule, Scheme};
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

mod classify;
mod part;

/// How a sibling is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SiblingKind {
    /// Copied.
    Corner,
    /// The curve rule along the borders of its span.
    Crease,
    /// Copied until the sharpness within its span is gone, then a crease.
    SemiSharp,
    /// Without sharpness of its own: a corner for as long as the other sibling is semi-sharp, and then blended like it; but where the seam
    /// is semi-sharp still, it stays for one more step and turns into a crease at once.
    Dependent,
}

/// A value at a vertex where values do not agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sibling {
    /// The value.
    pub value: u32,
    /// First corner of its span at the vertex, counter-clockwise.
    pub first: u32,
    /// Last corner of its span.
    pub last: u32,
    /// How it is refined.
    pub kind: SiblingKind,
}

/// Texture coordinates of a level.
#[derive(Clone, Debug)]
pub struct FaceVarying<T> {
    /// The values. No value belongs to two vertices.
    pub values: Vec<[T; 2]>,
    /// Value of every corner.
    pub corners: Vec<u32>,
    /// One corner of every value.
    pub(super) value_corners: Vec<u32>,
    /// Siblings, sorted by value.
    siblings: Vec<Sibling>,
    /// Per face of the cage, whether it has a corner without value; empty when there is none.
    missing: Vec<bool>,
    rule: FaceVaryingRule,
    pub(super) linear: bool,
}

impl<T: Real> FaceVarying<T> {
    /// Texture coordinates of level 0: `corners` names a value for every corner, or [`NONE`].
    #[must_use]
    pub(crate) fn new(
        t: &Topology,
        values: &[[T; 2]],
        corners: &[u32],
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Self {
        let linear = rule == FaceVaryingRule::All || scheme == Scheme::Bilinear;
        let mut missing = Vec::new();
        if corners.contains(&NONE) {
            missing = (0..t.face_count() as u32)
                .map(|f| t.face_halves(f).any(|h| corners[h as usize] == NONE))
                .collect();
        }
        let (corners, value_corners) = classify::number_values(t, corners);
        let values = value_corners
            .iter()
            .map(|&(_, old)| values.get(old as usize).copied().unwrap_or_default())
            .collect();
        let value_corners: Vec<u32> = value_corners.into_iter().map(|(h, _)| h).collect();
        let siblings = if linear {
            Vec::new()
        } else {
            classify::siblings(t, &corners, rule)
        };
        Self {
            values,
            corners,
            value_corners,
            siblings,
            missing,
            rule,
            linear,
        }
    }

    /// Whether the faces that descend from face `base` of the cage have texture coordinates at every corner.
    #[must_use]
    pub fn is_complete(&self, base: u32) -> bool {
        !self.missing.get(base as usize).copied().unwrap_or(false)
    }

    /// One corner of a value.
    #[must_use]
    pub(crate) fn value_corner(&self, value: u32) -> u32 {
        self.value_corners[value as usize]
    }

    /// Whether values are interpolated linearly everywhere.
    #[must_use]
    pub(crate) fn is_linear(&self) -> bool {
        self.linear
    }

    /// Where interpolating schemes are linear.
    pub(crate) fn linear_parts(&self) -> Linear {
        match self.rule {
            _ if self.linear => Linear::Always,
            rule if classify::linear_borders(rule) => Linear::Cuts,
            _ => Linear::Never,
        }
    }

    /// Values where corners disagree.
    #[must_use]
    pub fn siblings(&self) -> &[Sibling] {
        &self.siblings
    }

    /// Texture coordinates of the next level.
    #[must_use]
    pub(crate) fn next(&self, step: &Step<'_>, timings: &mut Timings) -> Self {
        let t = step.topology;
        let starts = timed(&mut timings.connectivity, || self.edge_value_starts(step));
        let edge_values = starts[t.edge_count()] as usize;
        let (old, faces) = (self.values.len(), step.face_points());
        let mut values = vec![[T::default(); 2]; old + faces + edge_values];
        let mut value_corners = vec![0; values.len()];
        let (of_vertices, rest) = values.split_at_mut(old);
        let (of_faces, of_edges) = rest.split_at_mut(faces);

        let mut siblings = if step.options.scheme.is_interpolating() {
            self.interpolated(step, &starts, timings, of_vertices, of_faces, of_edges)
        } else {
            timed(&mut timings.face, || {
                face::points(step, &self.corners, &self.values, of_faces);
            });
            timed(&mut timings.edge, || {
                self.edge_points(step, &starts, of_faces, of_edges);
            });
            timed(&mut timings.vertex, || {
                self.vertex_points(step, of_faces, of_vertices)
            })
        };
        timed(&mut timings.connectivity, || {
            self.edge_siblings(step, &starts, &mut siblings);
            let (vertex_corners, rest) = value_corners.split_at_mut(old);
            let (face_corners, edge_corners) = rest.split_at_mut(faces);
            vertex_corners
                .par_iter_mut()
                .zip(&self.value_corners)
                .with_min_len(1 << 13)
                .for_each(|(c, &h)| *c = step.child_corner(h, 0));
            face_corners
                .par_iter_mut()
                .enumerate()
                .with_min_len(1 << 13)
                .for_each(|(f, c)| *c = step.child_corner(t.face_halves(f as u32).start, 2));
            for e in 0..t.edge_count() as u32 {
                let own = starts[e as usize] as usize..starts[e as usize + 1] as usize;
                for (c, h) in edge_corners[own]
                    .iter_mut()
                    .zip(step.incidence.halves(t, e))
                {
                    *c = step.child_corner(h, 1);
                }
            }
        });
        let corners = timed(&mut timings.connectivity, || {
            let edge_value = |h: u32| (old + faces) as u32 + edge_value(step, &starts, h);
            let mut corners = vec![0; 4 * t.half_count()];
            match step.split() {
                Split::Quads => corners
                    .par_chunks_exact_mut(4)
                    .enumerate()
                    .with_min_len(1 << 12)
                    .for_each(|(h, four)| {
                        let h = h as u32;
                        let at = |k: u32| (step.child_corner(h, k) & 3) as usize;
                        four[at(0)] = self.corners[h as usize];
                        four[at(1)] = edge_value(h);
                        four[at(2)] = old as u32 + t.face_of(h);
                        four[at(3)] = edge_value(t.prev(h));
                    }),
                Split::Triangles => corners
                    .par_chunks_exact_mut(12)
                    .enumerate()
                    .with_min_len(1 << 11)
                    .for_each(|(f, twelve)| {
                        for h in 3 * f as u32..3 * f as u32 + 3 {
                            let at = |k: u32| step.child_corner(h, k) as usize - 12 * f;
                            twelve[at(0)] = self.corners[h as usize];
                            twelve[at(1)] = edge_value(h);
                            twelve[at(2)] = edge_value(h);
                            twelve[at(3)] = edge_value(t.prev(h));
                        }
                    }),
            }
            corners
        });
        Self {
            values,
            corners,
            value_corners,
            siblings,
            missing: self.missing.clone(),
            rule: self.rule,
            linear: self.linear,
        }
    }

    /// Where each edge's values start; an edge has one, or one per face where its faces disagree.
    fn edge_value_starts(&self, step: &Step<'_>) -> Vec<u32> {
        let t = step.topology;
        let mut starts: Vec<u32> = (0..t.edge_count() as u32 + 1)
            .into_par_iter()
            .with_min_len(1 << 12)
            .map(|e| {
                if e as usize == t.edge_count()
                    || !classify::disagrees(t, &step.incidence, &self.corners, e)
                {
                    1
                } else {
                    step.incidence.halves(t, e).count() as u32
                }
            })
            .collect();
        let mut sum = 0;
        for s in &mut starts {
            sum += std::mem::replace(s, sum);
        }
        starts
    }

    /// Values of interpolating schemes: sheets end at seams. Returns the children of siblings.
    fn interpolated(
        &self,
        step: &Step<'_>,
        starts: &[u32],
        timings: &mut Timings,
        of_vertices: &mut [[T; 2]],
        of_faces: &mut [[T; 2]],
        of_edges: &mut [[T; 2]],
    ) -> Vec<Sibling> {
        let t = step.topology;
        let linear = self.linear_parts();
        let masks = Masks::default();
        let sheets = Sheets::<T, T, 2>::of_corners(
            step,
            &masks,
            &self.corners,
            &self.values,
            &self.siblings,
            linear,
        );
        of_vertices.copy_from_slice(&self.values);
        timed(&mut timings.edge, || {
            let one_each = of_edges.len() == t.edge_count();
            fill(of_edges, |i| {
                let e = if one_each {
                    i
                } else {
                    starts.partition_point(|&s| s <= i) as u32 - 1
                };
                let start = starts[e as usize];
                let side = match starts[e as usize + 1] - start {
                    1 => sheets.side(e),
                    _ => {
                        let rank = (i - start) as usize;
                        step.incidence.halves(t, e).nth(rank).unwrap_or(0)
                    }
                };
                sheets.edge_point(side)
            });
        });
        timed(&mut timings.face, || {
            if linear == Linear::Always || step.is_linear() {
                face::points(step, &self.corners, &self.values, of_faces);
            } else {
                let edge_point = |h: u32| of_edges[edge_value(step, starts, h) as usize];
                fill(of_faces, |f| sheets.face_point(4 * f, edge_point));
            }
        });
        let child = |s: &Sibling| Sibling {
            first: step.child_corner(s.first, 0),
            last: step.child_corner(s.last, 0),
            kind: match s.kind {
                SiblingKind::Corner => SiblingKind::Corner,
                _ => SiblingKind::Crease,
            },
            ..*s
        };
        self.siblings.iter().map(child).collect()
    }

    fn edge_points(
        &self,
        step: &Step<'_>,
        starts: &[u32],
        face_points: &[[T; 2]],
        out: &mut [[T; 2]],
    ) {
        let t = step.topology;
        // One value for most edges: go by values, and find the edge of a value by search only where counts differ.
        let one_each = out.len() == t.edge_count();
        out.par_iter_mut()
            .enumerate()
            .with_min_len(1 << 12)
            .for_each(|(i, value)| {
                let e = if one_each {
                    i
                } else {
                    starts.partition_point(|&s| s as usize <= i) - 1
                };
                let own = starts[e + 1] - starts[e];
                *value = if own > 1 || self.linear {
                    let rank = i - starts[e] as usize;
                    let h = step.incidence.halves(t, e as u32).nth(rank).unwrap_or(0);
                    let ends =
                        [h, t.next(h)].map(|h| &self.values[self.corners[h as usize] as usize]);
                    midpoint(ends[0], ends[1])
                } else {
                    edge::value(step, e as u32, &self.corners, &self.values, |f| {
                        face_points[f as usize]
                    })
                };
            });
    }

    /// Fills the children of values; returns the children of siblings.
    fn vertex_points(
        &self,
        step: &Step<'_>,
        face_points: &[[T; 2]],
        out: &mut [[T; 2]],
    ) -> Vec<Sibling> {
        let t = step.topology;
        out.par_iter_mut()
            .enumerate()
            .with_min_len(1 << 12)
            .for_each_init(Vec::new, |spokes, (i, value)| {
                *value = if self.linear {
                    self.values[i]
                } else if let Ok(rank) =
                    self.siblings.binary_search_by_key(&(i as u32), |s| s.value)
                {
                    self.sibling_child(step, rank).0
                } else {
                    let v = t.vertex(self.value_corners[i]);
                    vertex::value(step, v, spokes, &self.corners, &self.values, |f| {
                        face_points[f as usize]
                    })
                };
            });
        (0..self.siblings.len())
            .map(|rank| {
                let s = self.siblings[rank];
                Sibling {
                    first: step.child_corner(s.first, 0),
                    last: step.child_corner(s.last, 0),
                    kind: self.sibling_child(step, rank).1,
                    ..s
                }
            })
            .collect()
    }

    /// Child of the sibling at `rank`: its value and its kind.
    fn sibling_child(&self, step: &Step<'_>, rank: usize) -> ([T; 2], SiblingKind) {
        let t = step.topology;
        let sibling = self.siblings[rank];
        let x = self.values[sibling.value as usize];
        let curve = || {
            let a = self.corners[t.next(sibling.first) as usize];
            let b = self.corners[t.prev(sibling.last) as usize];
            let ends = [a, b].map(|i| self.values[i as usize]);
            vertex::crease(&x, ends.iter())
        };
        let governing = match sibling.kind {
            SiblingKind::Corner => return (x, sibling.kind),
            SiblingKind::Crease => return (curve(), sibling.kind),
            SiblingKind::SemiSharp => sibling,
            SiblingKind::Dependent => self.partner(t, rank),
        };
        let v = t.vertex(sibling.first);
        let (sigma, child_sigma) = (t.vertex_sharpness(v), step.child_vertex(v));
        let mut transition = Transition::default();
        transition.note(sigma, child_sigma);
        let mut still = child_sigma > 0.0;
        let mut h = governing.first;
        while h != governing.last {
            h = t.rotate(h);
            if h == NONE {
                break;
            }
            let e = t.edge(h);
            let child = step.child_edge(e)[super::ring::start_end(t, h) as usize];
            transition.note(t.edge_sharpness(e), child);
            still |= is_semi_sharp(child);
        }
        if still {
            return (x, sibling.kind);
        }
        if sibling.kind == SiblingKind::Dependent {
            // Left to itself while there are semi-sharp edges on the seam it waits one step more.
            let mut spokes = Vec::new();
            step.incidence.spokes(t, v, &mut spokes);
            let waits = |s: &Spoke| is_semi_sharp(step.child_edge(s.edge)[s.end as usize]);
            if spokes.iter().any(waits) {
                return (x, SiblingKind::SemiSharp);
            }
        }
        (
            blend(transition.weight(), &x, &curve()),
            SiblingKind::Crease,
        )
    }

    /// The other sibling of the vertex of a dependent one.
    pub(super) fn partner(&self, t: &Topology, rank: usize) -> Sibling {
        let own = self.siblings[rank];
        let v = t.vertex(own.first);
        [rank.wrapping_sub(1), rank + 1]
            .into_iter()
            .filter_map(|r| self.siblings.get(r))
            .find(|s| t.vertex(s.first) == v)
            .copied()
            .unwrap_or(own)
    }

    /// Adds the siblings born on edges whose faces disagree, and on linear boundaries.
    fn edge_siblings(&self, step: &Step<'_>, starts: &[u32], siblings: &mut Vec<Sibling>) {
        if self.linear {
            return;
        }
        let t = step.topology;
        let linear_borders = classify::linear_borders(self.rule);
        let kind = if linear_borders {
            SiblingKind::Corner
        } else {
            SiblingKind::Crease
        };
        let first_value = (self.values.len() + step.face_points()) as u32;
        for e in 0..t.edge_count() as u32 {
            let start = starts[e as usize];
            let own = starts[e as usize + 1] - start;
            if own > 1 || (linear_borders && t.twin(t.edge_half(e)) == NONE) {
                let values = first_value + start..first_value + start + own;
                for (value, h) in values.zip(step.incidence.halves(t, e)) {
                    siblings.push(Sibling {
                        value,
                        first: step.child_corner(t.next(h), 3),
                        last: step.child_corner(h, 1),
                        kind,
                    });
                }
            }
        }
    }
}

/// The value of the edge point of half-edge `h` in its face, counted from the first value of an edge.
#[inline]
fn edge_value(step: &Step<'_>, starts: &[u32], h: u32) -> u32 {
    let e = step.topology.edge(h);
    let start = starts[e as usize];
    if starts[e as usize + 1] - start == 1 {
        return start;
    }
    let rank = step
        .incidence
        .halves(step.topology, e)
        .position(|g| g == h)
        .unwrap_or(0);
    start + rank as u32
}
