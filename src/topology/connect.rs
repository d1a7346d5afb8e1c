//! From polygons to [`Topology`], in linear time and parallel: half-edges are bucketed by the smaller vertex of their edge, each
//! bucket is sorted by the larger one, and runs of equal edges are paired.
//!
//! Rules for input that is no manifold (those of OpenSubdiv where it has one):
//! * an edge used by three or more faces, by two faces in the same direction, or from a vertex to itself has no twins; it is an
//!   infinitely sharp edge of every face that uses it;
//! * a vertex at such an edge, or with several fans of faces, is an infinitely sharp corner in each of its fans, unless it has just
//!   two such edges, no other boundary, and every fan runs from the one edge to the other: then the two make a crease through it;
//! * a vertex with one face is a corner under [`Boundary::EdgeAndCorner`].

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

/// What was odd, with a count and the first place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TopologyWarning {
    /// Edges of three or more faces.
    NonManifoldEdges {
        /// How many.
        count: usize,
        /// Ends of the first one.
        first: [u32; 2],
    },
    /// Edges whose two faces have opposite winding.
    FlippedEdges {
        /// How many.
        count: usize,
        /// Ends of the first one.
        first: [u32; 2],
    },
    /// Vertices at which several fans of faces meet.
    SplitVertices {
        /// How many.
        count: usize,
        /// The first one.
        first: u32,
    },
    /// Faces with more corners than a scheme for triangles can take; the surface is Catmull-Clark's instead.
    NotTriangles {
        /// The first face.
        first: u32,
        /// Its corners.
        corners: u32,
    },
    /// Creases between vertices that no edge joins.
    NoSuchEdge {
        /// How many.
        count: usize,
        /// The first one.
        first: [u32; 2],
    },
}

impl std::fmt::Display for TopologyWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NonManifoldEdges {
                count,
                first: [a, b],
            } => {
                write!(
                    f,
                    "{count} edges with three or more faces, taken as infinitely sharp (first: vertices {a} and {b}, 0-based)"
                )
            }
            Self::FlippedEdges {
                count,
                first: [a, b],
            } => {
                write!(
                    f,
                    "{count} edges between faces of opposite winding, taken as infinitely sharp (first: vertices {a} and {b}, 0-based)"
                )
            }
            Self::SplitVertices { count, first } => {
                write!(
                    f,
                    "{count} vertices where separate fans of faces meet, taken as sharp corners (first: vertex {first}, 0-based)"
                )
            }
            Self::NotTriangles { first, corners } => {
                write!(
                    f,
                    "face {first} (0-based) has {corners} corners, and the scheme takes triangles only; drawn by Catmull-Clark"
                )
            }
            Self::NoSuchEdge {
                count,
                first: [a, b],
            } => {
                write!(
                    f,
                    "{count} creases name vertices that no edge joins, ignored (first: {a} and {b}, 0-based)"
                )
            }
        }
    }
}

impl TopologyWarning {
    /// A face of `t`, which was connected with this warning, to look at: the third face of an edge of too many, the second of an edge between
    /// windings, the first at a vertex. `None` for what is about no face.
    #[must_use]
    pub fn face(&self, t: &Topology) -> Option<u32> {
        let halves = 0..t.half_count() as u32;
        let on_edge = |[a, b]: [u32; 2], nth: usize| {
            let runs = |h: &u32| {
                let ends = [t.vertex(*h), t.vertex(t.next(*h))];
                ends == [a, b] || ends == [b, a]
            };
            let found = halves.clone().filter(runs).take(nth + 1);
            found.last().map(|h| t.face_of(h))
        };
        match *self {
            Self::NonManifoldEdges { first, .. } => on_edge(first, 2),
            Self::FlippedEdges { first, .. } => on_edge(first, 1),
            Self::SplitVertices { first, .. } => {
                let mut halves = halves.clone();
                halves.find(|&h| t.vertex(h) == first).map(|h| t.face_of(h))
            }
            Self::NotTriangles { first, .. } => Some(first),
            Self::NoSuchEdge { .. } => None,
        }
    }
}

const GROUP_BOUNDARY: u8 = 0;
const GROUP_PAIR: u8 = 1;
const GROUP_FLIPPED: u8 = 2;
const GROUP_NON_MANIFOLD: u8 = 3;

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

/// Half-edges sorted by edge.
struct Pairing {
    /// First entry of each smaller vertex.
    starts: Vec<u32>,
    /// (larger vertex, half-edge), sorted within each bucket.
    entries: Vec<(u32, u32)>,
}

/// Per edge: how its half-edges go together.
struct Groups {
    kinds: Vec<u8>,
}

impl Pairing {
    fn new(t: &Topology) -> Self {
        let n = t.corner_vertices.len();
        let mut starts = vec![0_u32; t.vertex_count + 1];
        let ends = |h: u32| {
            let (a, b) = (t.vertex(h), t.vertex(t.next(h)));
            (a.min(b), a.max(b))
        };
        for h in 0..n as u32 {
            starts[ends(h).0 as usize + 1] += 1;
        }
        for v in 0..t.vertex_count {
            starts[v + 1] += starts[v];
        }
        let mut cursor = starts.clone();
        let mut entries = vec![(0_u32, 0_u32); n];
        for h in 0..n as u32 {
            let (a, b) = ends(h);
            entries[cursor[a as usize] as usize] = (b, h);
            cursor[a as usize] += 1;
        }
        drop(cursor);
        // Buckets are disjoint slices; hand them to threads in runs of vertices.
        let mut rest = entries.as_mut_slice();
        let mut runs = Vec::new();
        let mut v = 0;
        while v < t.vertex_count {
            let end = (v + 16384).min(t.vertex_count);
            let (run, tail) = rest.split_at_mut((starts[end] - starts[v]) as usize);
            runs.push((v, end, run));
            rest = tail;
            v = end;
        }
        runs.into_par_iter().for_each(|(v0, v1, run)| {
            let base = starts[v0];
            for v in v0..v1 {
                run[(starts[v] - base) as usize..(starts[v + 1] - base) as usize].sort_unstable();
            }
        });
        Self { starts, entries }
    }

    /// Runs of entries with the same edge, in (smaller, larger) order.
    fn runs(&self, v: usize) -> impl Iterator<Item = &[(u32, u32)]> {
        self.entries[self.starts[v] as usize..self.starts[v + 1] as usize]
            .chunk_by(|a, b| a.0 == b.0)
    }

    fn number_edges(&self, t: &mut Topology) -> Groups {
        let mut edges = vec![0_u32; self.entries.len()];
        let mut halves = Vec::with_capacity(self.entries.len() / 2 + 1);
        let mut kinds = Vec::with_capacity(self.entries.len() / 2 + 1);
        for v in 0..t.vertex_count {
            for run in self.runs(v) {
                let e = halves.len() as u32;
                halves.push(run[0].1);
                for &(_, h) in run {
                    edges[h as usize] = e;
                }
                kinds.push(match run {
                    [(b, _), ..] if *b == v as u32 => GROUP_NON_MANIFOLD,
                    [_] => GROUP_BOUNDARY,
                    [(_, g), (_, h)] if t.vertex(*g) != t.vertex(*h) => GROUP_PAIR,
                    [_, _] => GROUP_FLIPPED,
                    _ => GROUP_NON_MANIFOLD,
                });
            }
        }
        t.edges = edges;
        t.edge_halves = halves;
        Groups { kinds }
    }

    fn pair(&self, t: &mut Topology, groups: &Groups, warnings: &mut Vec<TopologyWarning>) {
        let mut twins = vec![NONE; self.entries.len()];
        let mut odd: [(usize, [u32; 2]); 2] = [(0, [0; 2]); 2];
        let mut e = 0;
        for v in 0..t.vertex_count {
            for run in self.runs(v) {
                match groups.kinds[e] {
                    GROUP_PAIR => {
                        twins[run[0].1 as usize] = run[1].1;
                        twins[run[1].1 as usize] = run[0].1;
                    }
                    GROUP_BOUNDARY => {}
                    kind => {
                        let (count, first) = &mut odd[usize::from(kind == GROUP_FLIPPED)];
                        if *count == 0 {
                            *first = [v as u32, run[0].0];
                        }
                        *count += 1;
                    }
                }
                e += 1;
            }
        }
        t.twins = twins;
        let [(count, first), (flipped, first_flipped)] = odd;
        if count > 0 {
            warnings.push(TopologyWarning::NonManifoldEdges { count, first });
        }
        if flipped > 0 {
            warnings.push(TopologyWarning::FlippedEdges {
                count: flipped,
                first: first_flipped,
            });
        }
    }
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
