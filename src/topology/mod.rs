//! Adjacency of a polygon mesh: half-edges, edges, fans around vertices, boundary, valence.
//!
//! A *half-edge* is a corner of a face seen as the edge that leaves it: half-edge `h` runs from its own vertex to the vertex of the
//! next corner. Numbers of half-edges and corners are the same, so no connectivity beyond `twin` and `edge` is stored.
//!
//! Every vertex is split into *fans*: maximal runs of faces joined by twin edges. A manifold vertex has one fan, which bears the
//! vertex' own number; further fans of a bow-tie or non-manifold vertex are numbered from the vertex count on. All rules work on
//! fans, so they never meet anything but a disc (closed fan) or a half-disc (open fan).

pub mod channel;
pub mod connect;
pub mod ears;
pub mod one_ring;
mod pairing;
pub mod split;
mod warning;

use crate::scheme::INFINITE_SHARPNESS;

pub use connect::{ConnectOptions, connect};
pub use one_ring::Ring;
pub use warning::TopologyWarning;

/// No half-edge, no fan.
pub const NONE: u32 = u32::MAX;

/// Rule of a fan while no semi-sharp crease takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FanRule {
    /// Closed fan: the smooth rule.
    Smooth,
    /// Open fan: the cubic curve through its two boundary edges.
    Crease,
    /// The point stays where it is.
    Corner,
}

/// One fan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fan {
    /// First outgoing half-edge in counter-clockwise order. In an open fan it is the boundary half-edge; in a closed one the
    /// smallest number. [`NONE`] for a vertex of no face.
    pub first: u32,
    /// Number of faces.
    pub faces: u32,
    /// Whether the faces close around the vertex.
    pub closed: bool,
    /// Rule without semi-sharp creases.
    pub rule: FanRule,
}

impl Fan {
    /// Number of edges of the fan: as many as faces if closed, one more if open.
    #[must_use]
    pub fn edges(&self) -> u32 {
        if self.closed || self.first == NONE {
            self.faces
        } else {
            self.faces + 1
        }
    }

    /// Whether the surface around is an ordinary bicubic B-spline: valence 4, or 2 faces on a boundary, or a corner of 1 face.
    #[must_use]
    pub fn is_regular(&self) -> bool {
        match self.rule {
            FanRule::Smooth => self.faces == 4,
            FanRule::Crease => self.faces == 2,
            FanRule::Corner => self.faces == 1 && !self.closed,
        }
    }

    /// Whether both derivatives of a face have one direction there: of one face between two sides of one smooth crease, which both run along
    /// that, and of two faces around a vertex, whose two sides run on into each other.
    pub(crate) fn is_flat(&self) -> bool {
        match self.rule {
            FanRule::Smooth => self.faces == 2 && self.closed,
            FanRule::Crease => self.faces == 1 && !self.closed,
            FanRule::Corner => false,
        }
    }
}

/// Connectivity of a polygon mesh.
#[derive(Clone, Debug, Default)]
pub struct Topology {
    /// Number of vertices of the mesh (fans beyond are copies of one of them).
    pub(crate) vertex_count: usize,
    /// Empty when all faces are quads.
    pub(crate) face_offsets: Vec<u32>,
    /// Face of each corner; empty when all faces are quads.
    pub(crate) corner_faces: Vec<u32>,
    /// Vertex of each corner.
    pub(crate) corner_vertices: Vec<u32>,
    /// Fan of each corner; empty when every vertex has one fan.
    pub(crate) corner_fans: Vec<u32>,
    pub(crate) twins: Vec<u32>,
    /// Edge of each half-edge.
    pub(crate) edges: Vec<u32>,
    /// One half-edge of each edge, the smallest number.
    pub(crate) edge_halves: Vec<u32>,
    pub(crate) fans: Vec<Fan>,
    /// Vertex of each fan beyond the vertex count.
    pub(crate) extra_fan_vertices: Vec<u32>,
    /// Sharpness per edge; empty when no edge is sharp but the boundary.
    pub(crate) edge_sharpness: Vec<f32>,
    /// Sharpness per vertex as tagged, and infinite where the mesh is not manifold; empty when all are 0.
    pub(crate) vertex_sharpness: Vec<f32>,
    /// Faces that are refined but not drawn; empty without holes.
    pub(crate) holes: Vec<bool>,
}

impl Topology {
    /// Whether all faces are quads.
    #[must_use]
    #[inline]
    pub fn all_quads(&self) -> bool {
        self.face_offsets.is_empty()
    }
    /// Number of faces.
    #[must_use]
    #[inline]
    pub fn face_count(&self) -> usize {
        if self.all_quads() {
            self.corner_vertices.len() / 4
        } else {
            self.face_offsets.len() - 1
        }
    }
    /// Number of vertices, with those of no face.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }
    /// Number of edges; half-edges between the same two vertices are one edge, whatever their number.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.edge_halves.len()
    }
    /// Number of half-edges, which is the number of corners.
    #[must_use]
    pub fn half_count(&self) -> usize {
        self.corner_vertices.len()
    }
    /// Half-edges of face `f`, in order.
    #[must_use]
    #[inline]
    pub fn face_halves(&self, f: u32) -> std::ops::Range<u32> {
        if self.all_quads() {
            4 * f..4 * f + 4
        } else {
            self.face_offsets[f as usize]..self.face_offsets[f as usize + 1]
        }
    }
    /// Face of half-edge `h`.
    #[must_use]
    #[inline]
    pub fn face_of(&self, h: u32) -> u32 {
        if self.all_quads() {
            h / 4
        } else {
            self.corner_faces[h as usize]
        }
    }
    /// The half-edge after `h` in its face.
    #[must_use]
    #[inline]
    pub fn next(&self, h: u32) -> u32 {
        if self.all_quads() {
            (h & !3) | ((h + 1) & 3)
        } else {
            let r = self.face_halves(self.corner_faces[h as usize]);
            if h + 1 == r.end { r.start } else { h + 1 }
        }
    }
    /// The half-edge before `h` in its face.
    #[must_use]
    #[inline]
    pub fn prev(&self, h: u32) -> u32 {
        if self.all_quads() {
            (h & !3) | ((h + 3) & 3)
        } else {
            let r = self.face_halves(self.corner_faces[h as usize]);
            if h == r.start { r.end - 1 } else { h - 1 }
        }
    }
    /// The opposite half-edge, or [`NONE`] on a boundary, a non-manifold edge, or between faces of opposite winding.
    #[must_use]
    #[inline]
    pub fn twin(&self, h: u32) -> u32 {
        self.twins[h as usize]
    }
    /// The vertex that `h` leaves.
    #[must_use]
    #[inline]
    pub fn vertex(&self, h: u32) -> u32 {
        self.corner_vertices[h as usize]
    }
    /// The fan that `h` leaves.
    #[must_use]
    #[inline]
    pub fn fan(&self, h: u32) -> u32 {
        if self.corner_fans.is_empty() {
            self.corner_vertices[h as usize]
        } else {
            self.corner_fans[h as usize]
        }
    }
    /// All fans; the first [`Topology::vertex_count`] bear the numbers of the vertices.
    #[must_use]
    pub fn fans(&self) -> &[Fan] {
        &self.fans
    }
    /// The vertex of a fan.
    #[must_use]
    #[inline]
    pub fn fan_vertex(&self, fan: u32) -> u32 {
        if (fan as usize) < self.vertex_count {
            fan
        } else {
            self.extra_fan_vertices[fan as usize - self.vertex_count]
        }
    }
    /// Edge of half-edge `h`.
    #[must_use]
    #[inline]
    pub fn edge(&self, h: u32) -> u32 {
        self.edges[h as usize]
    }
    /// One half-edge of edge `e`.
    #[must_use]
    #[inline]
    pub fn edge_half(&self, e: u32) -> u32 {
        self.edge_halves[e as usize]
    }
    /// Sharpness of edge `e`: as tagged, infinite on boundaries and non-manifold edges.
    #[must_use]
    #[inline]
    pub fn edge_sharpness(&self, e: u32) -> f32 {
        match self.edge_sharpness.get(e as usize) {
            Some(&s) => s,
            None if self.twins[self.edge_halves[e as usize] as usize] == NONE => INFINITE_SHARPNESS,
            None => 0.0,
        }
    }
    /// Sharpness of vertex `v`.
    #[must_use]
    #[inline]
    pub fn vertex_sharpness(&self, v: u32) -> f32 {
        self.vertex_sharpness
            .get(v as usize)
            .copied()
            .unwrap_or(0.0)
    }
    /// Whether face `f` is refined but not drawn.
    #[must_use]
    #[inline]
    pub fn is_hole(&self, f: u32) -> bool {
        self.holes.get(f as usize).copied().unwrap_or(false)
    }
    /// The next outgoing half-edge counter-clockwise around the vertex of `h`, or [`NONE`] past the last face of an open fan.
    #[must_use]
    #[inline]
    pub fn rotate(&self, h: u32) -> u32 {
        self.twins[self.prev(h) as usize]
    }
    /// The next outgoing half-edge clockwise, or [`NONE`] when `h` is the first of an open fan.
    #[must_use]
    #[inline]
    pub fn rotate_back(&self, h: u32) -> u32 {
        let t = self.twins[h as usize];
        if t == NONE { NONE } else { self.next(t) }
    }
    /// Whether every fan is regular and every face a quad.
    #[must_use]
    pub fn count_irregular(&self) -> usize {
        self.fans
            .iter()
            .filter(|f| f.first != NONE && !f.is_regular())
            .count()
    }
}
