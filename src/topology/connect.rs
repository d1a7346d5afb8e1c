//! From polygons to [`Topology`], in linear time and parallel: half-edges are bucketed by the smaller vertex of their edge, each
//! bucket is sorted by the larger one, and runs of equal edges are paired.
//!
//! Rules for input that is no manifold (those of OpenSubdiv where it has one):
//! * an edge used by three or more faces, by two faces in the same direction, or from a vertex to itself has no twins; it is an
//!   infinitely sharp edge of every face that uses it;
//! * a vertex at such an edge, or with several fans of faces, is an infinitely sharp corner in each of its fans, unless it has just
//!   two such edges, no other boundary, and every fan runs from the one edge to the other: then the two make a crease through it;
//! * a vertex with one face is a corner under [`Boundary::EdgeAndCorner`].

use super::pairing::{GROUP_BOUNDARY, GROUP_FLIPPED, GROUP_PAIR, Pairing};
use super::warning::TopologyWarning;
use super::{Fan, FanRule, NONE, Topology};
use crate::scheme::{Boundary, INFINITE_SHARPNESS};
use rayon::prelude::*;

/// What `connect` is to do with boundaries and tags.
#[derive(Clone, Debug, Default)]
pub struct ConnectOptions<'a> {
    /// Boundary rule.
    pub boundary: Boundary,
    /// Edges with sharpness, by their two vertices.
    pub creases: &'a [crate::mesh::Crease],
    /// Vertices with sharpness.
    pub corners: &'a [crate::mesh::Corner],
    /// Faces that are refined but not drawn.
    pub holes: &'a [u32],
}

/// Connects the faces of a mesh.
///
/// `face_offsets[f]..face_offsets[f + 1]` are the corners of face `f`; every index must be below `vertex_count` and every face
/// must have at least 3 corners ([`Cage`](crate::Cage) makes sure of both).
///
/// # Panics
/// When an index is out of range.
#[must_use]
pub fn connect(
    vertex_count: usize,
    face_offsets: &[u32],
    corner_vertices: Vec<u32>,
    options: &ConnectOptions<'_>,
) -> (Topology, Vec<TopologyWarning>) {
    let face_count = face_offsets.len().saturating_sub(1);
    let half_count = corner_vertices.len();
    let all_quads = face_offsets.par_windows(2).all(|w| w[1] - w[0] == 4);
    let mut t = Topology {
        vertex_count,
        corner_vertices,
        ..Topology::default()
    };
    if !all_quads {
        t.face_offsets = face_offsets.to_vec();
        t.corner_faces = vec![0; half_count];
        for f in 0..face_count {
            t.corner_faces[face_offsets[f] as usize..face_offsets[f + 1] as usize].fill(f as u32);
        }
    }
    let mut warnings = Vec::new();
    let pairing = Pairing::new(&t);
    let groups = pairing.number_edges(&mut t);
    pairing.pair(&mut t, &groups, &mut warnings);
    drop(pairing);
    let irregular_edges = groups.kinds;
    make_fans(&mut t, options.boundary, &irregular_edges, &mut warnings);
    apply_tags(&mut t, options, &irregular_edges, &mut warnings);
    (t, warnings)
}

/// Finds the first half-edge and the length of the fan of `h`: clockwise to the boundary or once around, then counted.
pub(super) fn fan_around(t: &Topology, h: u32) -> Fan {
    let mut first = h;
    let mut smallest = h;
    let closed = loop {
        let back = t.rotate_back(first);
        if back == NONE {
            break false;
        }
        if back == h {
            first = smallest;
            break true;
        }
        first = back;
        smallest = smallest.min(back);
    };
    let mut faces = 1;
    let mut at = t.rotate(first);
    while at != NONE && at != first {
        faces += 1;
        at = t.rotate(at);
    }
    Fan {
        first,
        faces,
        closed,
        rule: if closed {
            FanRule::Smooth
        } else {
            FanRule::Crease
        },
    }
}

fn make_fans(
    t: &mut Topology,
    boundary: Boundary,
    kinds: &[u8],
    warnings: &mut Vec<TopologyWarning>,
) {
    let n = t.vertex_count;
    let mut lowest = vec![NONE; n];
    let mut corners = vec![0_u32; n];
    for (h, &v) in t.corner_vertices.iter().enumerate() {
        lowest[v as usize] = lowest[v as usize].min(h as u32);
        corners[v as usize] += 1;
    }
    let none = Fan {
        first: NONE,
        faces: 0,
        closed: false,
        rule: FanRule::Corner,
    };
    t.fans = lowest
        .par_iter()
        .map(|&h| if h == NONE { none } else { fan_around(t, h) })
        .collect();
    let split: Vec<u32> = (0..n as u32)
        .filter(|&v| t.fans[v as usize].faces != corners[v as usize])
        .collect();
    if let Some(&first) = split.first() {
        warnings.push(TopologyWarning::SplitVertices {
            count: split.len(),
            first,
        });
        add_fans(t, &split);
    }
    // Irregular edges at each vertex decide whether it is a corner or carries a crease.
    let odd: Vec<u32> = (0..kinds.len() as u32)
        .filter(|&e| kinds[e as usize] >= GROUP_FLIPPED)
        .collect();
    let mut odd_edges = vec![0_u8; if odd.is_empty() { 0 } else { n }];
    let mut plain_boundary = vec![false; odd_edges.len()];
    for &e in &odd {
        let h = t.edge_halves[e as usize];
        for v in [t.vertex(h), t.vertex(t.next(h))] {
            odd_edges[v as usize] = odd_edges[v as usize].saturating_add(1);
        }
    }
    if !odd.is_empty() {
        for (e, &kind) in kinds.iter().enumerate() {
            if kind == GROUP_BOUNDARY {
                let h = t.edge_halves[e];
                for v in [t.vertex(h), t.vertex(t.next(h))] {
                    plain_boundary[v as usize] = true;
                }
            }
        }
    }
    let mut several = vec![false; if split.is_empty() { 0 } else { n }];
    for &v in &split {
        several[v as usize] = true;
    }
    let vertex_of: Vec<u32> = (0..t.fans.len() as u32).map(|f| t.fan_vertex(f)).collect();
    // Two odd edges carry a crease through the vertex only if every fan runs from the one to the other.
    let mut through: Vec<bool> = (0..odd_edges.len())
        .map(|v| odd_edges[v] == 2 && !plain_boundary[v])
        .collect();
    for (fan, &v) in t.fans.iter().zip(&vertex_of) {
        if fan.first == NONE || !through.get(v as usize).copied().unwrap_or(false) {
            continue;
        }
        let last = super::Ring::from_half(t, fan.first)
            .last()
            .unwrap_or(fan.first);
        if fan.closed || t.edge(fan.first) == t.edge(t.prev(last)) {
            through[v as usize] = false;
        }
    }
    let mut sharp = Vec::new();
    for (fan, &v) in t.fans.iter_mut().zip(&vertex_of) {
        if fan.first == NONE {
            continue;
        }
        let v = v as usize;
        let odd = odd_edges.get(v).copied().unwrap_or(0);
        let through = through.get(v).copied().unwrap_or(false);
        let bow_tie = several.get(v).copied().unwrap_or(false);
        let torn = (odd > 0 && !through) || (bow_tie && odd == 0);
        let tip = corners[v] == 1 && !fan.closed && boundary == Boundary::EdgeAndCorner;
        if torn || tip {
            fan.rule = FanRule::Corner;
            sharp.push(v);
        }
    }
    if !sharp.is_empty() {
        t.vertex_sharpness = vec![0.0; n];
        for v in sharp {
            t.vertex_sharpness[v] = INFINITE_SHARPNESS;
        }
    }
}

/// Gives the corners of `vertices` their fans; the first fan, that of the lowest corner, keeps the number of the vertex.
fn add_fans(t: &mut Topology, vertices: &[u32]) {
    let mut is_split = vec![false; t.vertex_count];
    for &v in vertices {
        is_split[v as usize] = true;
    }
    let mut fans = vec![NONE; t.corner_vertices.len()];
    let mut extra = Vec::new();
    let mut first_done = vec![false; t.vertex_count];
    for h in 0..t.corner_vertices.len() as u32 {
        let v = t.vertex(h);
        if !is_split[v as usize] {
            fans[h as usize] = v;
        } else if fans[h as usize] == NONE {
            let fan = fan_around(t, h);
            let id = if first_done[v as usize] {
                extra.push(v);
                t.fans.push(fan);
                t.fans.len() as u32 - 1
            } else {
                first_done[v as usize] = true;
                v
            };
            let mut at = fan.first;
            for _ in 0..fan.faces {
                fans[at as usize] = id;
                at = t.rotate(at);
            }
        }
    }
    t.corner_fans = fans;
    t.extra_fan_vertices = extra;
}

fn apply_tags(
    t: &mut Topology,
    options: &ConnectOptions<'_>,
    kinds: &[u8],
    warnings: &mut Vec<TopologyWarning>,
) {
    if !options.creases.is_empty() {
        t.edge_sharpness = vec![0.0; kinds.len()];
        let mut missing = (0, [0; 2]);
        for c in options.creases {
            match find_edge(t, c.vertices) {
                Some(e) => t.edge_sharpness[e as usize] = c.sharpness.max(0.0),
                None => {
                    if missing.0 == 0 {
                        missing.1 = c.vertices;
                    }
                    missing.0 += 1;
                }
            }
        }
        if missing.0 > 0 {
            warnings.push(TopologyWarning::NoSuchEdge {
                count: missing.0,
                first: missing.1,
            });
        }
    }
    if !options.holes.is_empty() || options.boundary == Boundary::None {
        t.holes = vec![false; t.face_count()];
        for &f in options.holes {
            if let Some(hole) = t.holes.get_mut(f as usize) {
                *hole = true;
            }
        }
    }
    // Boundary rule none: every face at a vertex with a boundary edge of less than infinite user sharpness becomes a hole.
    if options.boundary == Boundary::None {
        let mut cut = vec![false; t.vertex_count];
        for (e, &kind) in kinds.iter().enumerate() {
            let tagged = t.edge_sharpness.get(e).copied().unwrap_or(0.0);
            if kind != GROUP_PAIR && tagged < INFINITE_SHARPNESS {
                let h = t.edge_halves[e];
                cut[t.vertex(h) as usize] = true;
                cut[t.vertex(t.next(h)) as usize] = true;
            }
        }
        for h in 0..t.corner_vertices.len() as u32 {
            if cut[t.vertex(h) as usize] {
                let f = t.face_of(h) as usize;
                t.holes[f] = true;
            }
        }
    }
    if !t.edge_sharpness.is_empty() {
        for (e, &kind) in kinds.iter().enumerate() {
            if kind != GROUP_PAIR {
                t.edge_sharpness[e] = INFINITE_SHARPNESS;
            }
        }
    }
    for c in options.corners {
        if (c.vertex as usize) < t.vertex_count && c.sharpness > 0.0 {
            if t.vertex_sharpness.is_empty() {
                t.vertex_sharpness = vec![0.0; t.vertex_count];
            }
            let s = &mut t.vertex_sharpness[c.vertex as usize];
            *s = s.max(c.sharpness);
        }
    }
}

/// Finds the fans of all vertices anew; the fan of a vertex' lowest corner bears its number. Rules are those of the fan's shape.
pub(crate) fn rebuild_fans(t: &mut Topology) {
    let none = Fan {
        first: NONE,
        faces: 0,
        closed: false,
        rule: FanRule::Corner,
    };
    t.corner_fans.clear();
    t.extra_fan_vertices.clear();
    t.fans = vec![none; t.vertex_count];
    let mut fans = vec![NONE; t.half_count()];
    for h in 0..t.half_count() as u32 {
        if fans[h as usize] != NONE {
            continue;
        }
        let v = t.vertex(h);
        let fan = fan_around(t, h);
        let id = if t.fans[v as usize].first == NONE {
            t.fans[v as usize] = fan;
            v
        } else {
            t.fans.push(fan);
            t.extra_fan_vertices.push(v);
            t.fans.len() as u32 - 1
        };
        let mut at = fan.first;
        for _ in 0..fan.faces {
            fans[at as usize] = id;
            at = t.rotate(at);
        }
    }
    if !t.extra_fan_vertices.is_empty() {
        t.corner_fans = fans;
    }
}

/// The edge between two vertices, by binary search: edges are numbered in (smaller, larger) order of their vertices.
#[must_use]
pub fn find_edge(t: &Topology, ends: [u32; 2]) -> Option<u32> {
    let wanted = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let key = |&h: &u32| {
        let (a, b) = (t.vertex(h), t.vertex(t.next(h)));
        (a.min(b), a.max(b))
    };
    t.edge_halves
        .binary_search_by_key(&wanted, key)
        .ok()
        .map(|e| e as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(faces: &[&[u32]], vertex: u32) -> Vec<FanRule> {
        let mut offsets = vec![0];
        for f in faces {
            offsets.push(offsets.last().unwrap() + f.len() as u32);
        }
        let (t, _) = connect(8, &offsets, faces.concat(), &ConnectOptions::default());
        let of = (0..t.fans().len() as u32)
            .filter(|&f| t.fan_vertex(f) == vertex && t.fans()[f as usize].first != NONE);
        of.map(|f| t.fans()[f as usize].rule).collect()
    }

    #[test]
    fn all_fans_of_a_vertex_on_a_crease_between_flipped_faces_share_its_rule() {
        // A single face and a pair of faces meet at vertex 0 along the flipped edges 0-1 and 0-2.
        let rules = rules(&[&[0, 1, 3, 2], &[0, 1, 4, 5], &[0, 5, 6, 2]], 0);
        assert_eq!(rules, [FanRule::Crease; 2]);
    }

    #[test]
    fn a_fan_that_begins_and_ends_at_the_same_odd_edge_makes_its_vertex_a_corner() {
        // Two sheets and a cone all use edge 0-1; the cone's fan runs from that edge back to it.
        let rules = rules(
            &[
                &[0, 1, 5, 2],
                &[0, 1, 6, 2],
                &[0, 1, 3],
                &[0, 3, 4],
                &[0, 4, 1],
            ],
            0,
        );
        assert!(rules.iter().all(|r| *r == FanRule::Corner), "{rules:?}");
    }
}
