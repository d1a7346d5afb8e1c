//! Depth tags: an integer per vertex of the cage says how deep the surface is cut up near it.
//!
//! After Boubekeur and Schlick, *Generic Adaptive Mesh Refinement* (GPU Gems 3, 2007), and their *QAS: Real-time Quadratic Approximation
//! of Subdivision Surfaces* (2007). Tags come from the distance of the eye, from curvature, from both, or from the user
//! ([`DepthTags`]). The depth of an edge is the mean of its two tags, rounded up: nothing else enters, so both of its faces find the same
//! and no crack can open. The inner depth of a face is the largest of its edges'.
//!
//! Depths count steps from the cage. A cage with other polygons than quads is split once: an edge of depth `d` is two halves of depth
//! `d - 1`, and the edges to the middle of a face have its inner depth less one. Depth 0 is drawn as depth 1 there, as the middles of edges
//! are corners of the quads.

mod parse;
mod tags;

pub use parse::{DepthTagsError, parse};

use super::patterns::{Pattern, Pool};
use super::{CHUNK, Leaf, Move, NO_LIST, Reach, Tessellation};
use crate::dice::MAX_LEVEL;
use crate::dice::face::Sides;
use crate::limits::{Budget, LimitError, Limits};
use crate::simd::Level;
use crate::surface::{QuadPatch, Surface};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;

pub(crate) use tags::vertex_tags;

/// Deepest tag.
pub const MAX_DEPTH: u32 = MAX_LEVEL;

/// Micro-quads along the side of a block, as a power of two.
const MAX_LOG: u32 = 5;

/// Where the tags of vertices come from. Of distance and curvature together the lesser counts: what is flat or far away needs few points.
/// Tags given with an object ([`Object::depth_tags`](crate::frame::Object::depth_tags)) are the least that is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthTags {
    /// By the distance of the eye: deep enough for the edges of the cage at the vertex to be cut into pieces of so many pixels.
    pub distance: Option<f32>,
    /// By curvature: deep enough for unit normals to turn by so many degrees along a piece of the edges at the vertex. Curvature is taken
    /// from the limit normals at the ends of edges; infinite creases are none.
    pub curvature: Option<f32>,
    /// How triangles join edges of unequal depths. `None`: faces are grids of their inner depth, and points beside a coarser edge are moved to
    /// the nearest that it has.
    pub pattern: Option<Pattern>,
}

impl DepthTags {
    /// Only the tags that objects bring along.
    pub const GIVEN: Self = Self {
        distance: None,
        curvature: None,
        pattern: None,
    };

    /// By distance: pieces of 5 pixels.
    #[must_use]
    pub const fn by_distance() -> Self {
        Self {
            distance: Some(5.0),
            ..Self::GIVEN
        }
    }

    /// By curvature: pieces of 4 degrees.
    #[must_use]
    pub const fn by_curvature() -> Self {
        Self {
            curvature: Some(4.0),
            ..Self::GIVEN
        }
    }

    /// By both.
    #[must_use]
    pub const fn by_distance_and_curvature() -> Self {
        Self {
            curvature: Self::by_curvature().curvature,
            ..Self::by_distance()
        }
    }
}

/// Depth of an edge between vertices with these tags.
#[must_use]
pub const fn edge_depth(a: u8, b: u8) -> u32 {
    (a as u32 + b as u32).div_ceil(2)
}

/// Depths of the sides of every face of the surface's own faces, and the inner depth, in steps of these faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FaceDepths {
    pub(crate) inner: u32,
    pub(crate) sides: [u32; 4],
}

/// Depths of face `q` of the surface's own faces: quads, or triangles, whose fourth side is 0.
pub(crate) fn face_depths(surface: &Surface, tags: &[u8], q: u32) -> FaceDepths {
    let base = surface.topology();
    let edge = |h: u32| {
        let [a, b] = [h, base.next(h)].map(|h| tags[base.vertex(h) as usize]);
        edge_depth(a, b)
    };
    let face = match surface.is_split() {
        true => base.face_of(q),
        false => q,
    };
    let halves = base.face_halves(face);
    let inner = halves.clone().map(edge).max().unwrap_or(0);
    if surface.is_split() {
        let halved = |d: u32| d.saturating_sub(1);
        let inner = halved(inner);
        let sides = [halved(edge(q)), inner, inner, halved(edge(base.prev(q)))];
        return FaceDepths { inner, sides };
    }
    let mut sides = [0; 4];
    for (side, h) in sides.iter_mut().zip(halves) {
        *side = edge(h);
    }
    FaceDepths { inner, sides }
}

/// Depth of the deepest edge, in steps of the cage: the level that is drawn where there are no blocks.
pub(crate) fn deepest(surface: &Surface, tags: &[u8]) -> u32 {
    let base = surface.topology();
    let halves = 0..base.half_count() as u32;
    let depth = halves
        .filter(|&h| !base.is_hole(base.face_of(h)))
        .map(|h| {
            edge_depth(
                tags[base.vertex(h) as usize],
                tags[base.vertex(base.next(h)) as usize],
            )
        })
        .max()
        .unwrap_or(0);
    depth.max(u32::from(surface.is_split()))
}

/// Blocks of a surface by the tags of its cage's vertices. `is_drawn` says of a face, and points whose hull holds it, whether it is wanted at
/// all.
///
/// # Errors
/// A budget was reached.
pub(crate) fn tessellate(
    surface: &Surface,
    tags: &[u8],
    pattern: Option<(Pattern, &Pool)>,
    limits: &Limits,
    budget: &mut Budget<'_>,
    is_drawn: impl Fn(u32, &mut Vec<[f32; 3]>) -> bool + Sync,
) -> Result<Tessellation, LimitError> {
    let faces = surface.quads().face_count();
    let depths: Vec<FaceDepths> = (0..faces as u32)
        .map(|q| face_depths(surface, tags, q))
        .collect();
    let deepest = depths.iter().map(|d| d.inner).max().unwrap_or(0);
    let level = match surface.has_tables() {
        true => deepest,
        false => MAX_LEVEL,
    };
    surface.try_ensure(level, budget)?;
    let reach = Reach {
        level,
        always: surface.has_tables(),
        squares: MAX_LEVEL,
    };
    let triangular = surface.is_triangular();
    let mut is_wanted = vec![false; faces];
    is_wanted
        .par_chunks_mut(CHUNK)
        .enumerate()
        .try_for_each_init(
            || (QuadPatch::for_level(Level::detect()), Vec::new()),
            |(patch, hull), (k, chunk)| {
                limits.check()?;
                for (i, wanted) in chunk.iter_mut().enumerate() {
                    let q = (k * CHUNK + i) as u32;
                    hull.clear();
                    patch.prepare_points(surface, q, level, None, Sides::Hull);
                    patch.hull(|p| hull.push(p));
                    *wanted = is_drawn(q, hull);
                }
                Ok(())
            },
        )?;
    let faces = Faces {
        depths: &depths,
        is_wanted: &is_wanted,
        triangular,
        reach,
    };
    match pattern {
        Some((pattern, pool)) => faces.patterns(pattern, pool, limits, budget),
        None => faces.grids(limits, budget),
    }
}

/// What is known of the faces of a surface.
struct Faces<'a> {
    depths: &'a [FaceDepths],
    is_wanted: &'a [bool],
    triangular: bool,
    reach: Reach,
}

impl Faces<'_> {
    /// Those that are drawn, with their depths.
    fn wanted(&self) -> impl Iterator<Item = (u32, &FaceDepths)> {
        let all = (0..).zip(self.depths).zip(self.is_wanted);
        all.filter_map(|(face, &wanted)| wanted.then_some(face))
    }

    /// Blocks whose triangles beside coarser sides are drawn out to the points of these.
    fn grids(&self, limits: &Limits, budget: &mut Budget<'_>) -> Result<Tessellation, LimitError> {
        let bytes: u128 = self.wanted().map(|(_, d)| predicted_bytes(d)).sum();
        budget.take("the blocks of the tessellation", bytes, 0)?;
        let mut out = Tessellation {
            triangular: self.triangular,
            ..Tessellation::default()
        };
        for (k, (q, depths)) in self.wanted().enumerate() {
            if k % CHUNK == 0 {
                limits.check()?;
            }
            let prepared = self.reach.prepared(depths.inner);
            face_blocks(q, depths, self.triangular, prepared, &mut out);
        }
        Ok(out)
    }

    /// Blocks of refinement patterns. Faces of one pattern follow each other, so that its lists stay in the cache.
    fn patterns(
        &self,
        pattern: Pattern,
        pool: &Pool,
        limits: &Limits,
        budget: &mut Budget<'_>,
    ) -> Result<Tessellation, LimitError> {
        let begin = Instant::now();
        let mut groups: BTreeMap<[u32; 4], Vec<u32>> = BTreeMap::new();
        for (q, depths) in self.wanted() {
            groups.entry(depths.sides).or_default().push(q);
        }
        let mut out = Tessellation {
            triangular: self.triangular,
            ..Tessellation::default()
        };
        for faces in groups.into_values() {
            let depths = &self.depths[faces[0] as usize];
            // Inside of a pattern nothing is deeper than its sides.
            let inner = depths.sides.iter().max().copied().unwrap_or(0);
            let depths = FaceDepths { inner, ..*depths };
            let blocks = pool.get(pattern, self.triangular, &depths, limits)?;
            let bytes = faces.len() * blocks.len() * size_of::<Leaf>();
            budget.take("the blocks of the tessellation", bytes as u128, 0)?;
            let first = out.lists.len() as u32;
            out.lists
                .extend(blocks.iter().filter_map(|b| b.list.clone()));
            for q in faces {
                let mut list = first;
                for block in &*blocks {
                    out.leaves.push(Leaf {
                        quad: q,
                        reach: self.reach.prepared(inner) as u8,
                        level: inner as u8,
                        log: block.log,
                        start: block.start,
                        moves_end: 0,
                        list: match &block.list {
                            Some(_) => list,
                            None => NO_LIST,
                        },
                    });
                    list += u32::from(block.list.is_some());
                }
            }
        }
        out.pattern_time = begin.elapsed();
        Ok(out)
    }
}

/// Bytes of a face's blocks and of what is moved along its sides.
fn predicted_bytes(depths: &FaceDepths) -> u128 {
    let blocks = 1_u128 << (2 * depths.inner.saturating_sub(MAX_LOG));
    let rim: u128 = depths
        .sides
        .map(|d| rim_moves(depths.inner, d))
        .iter()
        .sum();
    blocks * size_of::<Leaf>() as u128 + rim * size_of::<Move>() as u128
}

/// Points along a side that are drawn elsewhere.
fn rim_moves(inner: u32, side: u32) -> u128 {
    if side < inner {
        (1 << inner) - (1 << side)
    } else {
        0
    }
}

/// Square blocks of one level over all of a face; of a triangle, those on the diagonal are half.
fn face_blocks(q: u32, depths: &FaceDepths, triangular: bool, reach: u32, out: &mut Tessellation) {
    let level = depths.inner;
    let log = level.min(MAX_LOG);
    let (n, count) = (1_u32 << log, 1_u32 << (level - log));
    for by in 0..count {
        for bx in if triangular { by } else { 0 }..count {
            let start = [bx * n, by * n];
            rim(depths, triangular, start, n, reach, &mut out.moves);
            out.leaves.push(Leaf {
                quad: q,
                reach: reach as u8,
                level: level as u8,
                log: log as u8,
                start: start.map(|k| k as u16),
                moves_end: out.moves.len() as u32,
                list: NO_LIST,
            });
        }
    }
}

/// Where a point of a face's grid is drawn: on a coarser side at the nearest point that it has, of two equally near ones the first along the
/// side. Every point of an edge is drawn by both of its faces, whatever moves.
fn drawn(depths: &FaceDepths, triangular: bool, [x, y]: [u32; 2]) -> [u32; 2] {
    let n = 1_u32 << depths.inner;
    let nearest = |c: usize, t: u32| {
        let step = n >> depths.sides[c].min(depths.inner);
        (t + (step - 1) / 2) / step * step
    };
    // Corners of the face lie on two sides, and stay.
    if y == 0 {
        [nearest(0, x), 0]
    } else if x == n {
        [n, nearest(1, y)]
    } else if triangular {
        match x == y {
            true => [n - nearest(2, n - x); 2],
            false => [x, y],
        }
    } else if y == n {
        [n - nearest(2, n - x), n]
    } else if x == 0 {
        [0, n - nearest(3, n - y)]
    } else {
        [x, y]
    }
}

/// The moves of a block's rim.
fn rim(
    depths: &FaceDepths,
    triangular: bool,
    start: [u32; 2],
    n: u32,
    reach: u32,
    out: &mut Vec<Move>,
) {
    let full = 1_u32 << depths.inner;
    let up = reach - depths.inner;
    let half = triangular && start[0] == start[1];
    let inside = start[1] > 0 && start.iter().all(|&s| s + n < full);
    // Blocks of a triangle beside those on the diagonal touch it by a corner.
    if inside && (triangular && start[0] > start[1] + n || !triangular && start[0] > 0) {
        return;
    }
    for c in 0..if half { 3 } else { 4 } {
        for k in 0..n {
            let [i, j] = match c {
                0 => [k, 0],
                1 => [n, k],
                2 if half => [n - k; 2],
                2 => [n - k, n],
                _ => [0, n - k],
            };
            let at = [start[0] + i, start[1] + j];
            let to = drawn(depths, triangular, at);
            if to != at {
                out.push(Move {
                    at: [i as u8, j as u8],
                    to: to.map(|k| (k << up) as u16),
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_of_edges_are_means_rounded_up() {
        assert_eq!(edge_depth(0, 0), 0);
        assert_eq!(edge_depth(0, 1), 1);
        assert_eq!(edge_depth(3, 6), 5);
        assert_eq!(edge_depth(10, 10), 10);
    }

    /// Every point of a side that is drawn is one of the edge's, and all of them are.
    #[test]
    fn sides_are_drawn_with_the_points_of_their_edges() {
        for inner in 0..=7 {
            for sides in [[0, 1, 2, 3], [inner, 0, inner, 2], [0; 4], [4, 7, 1, 0]] {
                let sides = sides.map(|d: u32| d.min(inner));
                let depths = FaceDepths { inner, sides };
                let mut t = Tessellation::default();
                face_blocks(0, &depths, false, inner, &mut t);
                let n = 1_u32 << inner;
                let mut seen = [0, 1, 2, 3].map(|_| std::collections::BTreeSet::new());
                for (k, leaf) in t.leaves.iter().enumerate() {
                    let size = 1_u32 << leaf.log;
                    let start = leaf.start.map(u32::from);
                    let moves = t.moves(k);
                    for j in 0..=size {
                        for i in 0..=size {
                            let own = [start[0] + i, start[1] + j];
                            let moved = moves.iter().find(|m| m.at.map(u32::from) == [i, j]);
                            let [x, y] = moved.map_or(own, |m| m.to.map(u32::from));
                            for (c, on, t) in [
                                (0, own[1] == 0, x),
                                (1, own[0] == n, y),
                                (2, own[1] == n, n - x),
                                (3, own[0] == 0, n - y),
                            ] {
                                if on {
                                    seen[c].insert(t);
                                }
                            }
                        }
                    }
                }
                for c in 0..4 {
                    let step = n >> sides[c];
                    let want: Vec<u32> = (0..=1 << sides[c]).map(|k| k * step).collect();
                    assert!(
                        seen[c].iter().copied().eq(want),
                        "{depths:?} side {c}: {:?}",
                        seen[c]
                    );
                }
            }
        }
    }
}
