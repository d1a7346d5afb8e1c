//! A part of a level as a level of its own, for refinement around features alone.
//!
//! The rim of the part looks like a boundary, and what refinement makes of its vertices is not what it makes of them in the whole. Vertices
//! whose faces are all in the part refine as in the whole; so whoever needs the ring of a vertex one level on must take in all faces
//! around the corners of its faces. Vertices, edges and values keep their order.

use super::face_varying::FaceVarying;
use super::real::Real;
use super::{Channels, Level};
use crate::scheme::INFINITE_SHARPNESS;
use crate::topology::connect::rebuild_fans;
use crate::topology::{NONE, Topology};

/// A part of a level.
#[derive(Clone, Debug)]
pub(crate) struct Part<T> {
    /// The level; its faces stand in the order in which they were asked for. [`Level::base_face`] means nothing here.
    pub(crate) level: Level<T>,
    /// Vertex of the whole of every vertex.
    pub(crate) vertices: Vec<u32>,
    /// Face-varying value of the whole of every value.
    pub(crate) values: Vec<u32>,
}

/// New numbers by old ones: a list of all, or where few of many are taken, pairs in order.
pub(super) struct Renumbered {
    dense: Vec<u32>,
    sparse: Vec<(u32, u32)>,
}

impl Renumbered {
    /// `old` is the old number of each new one, of `size` old ones.
    fn new(size: usize, old: &[u32]) -> Self {
        let pairs = (0..).zip(old).map(|(new, &old)| (old, new));
        // A search costs about as much as filling this many places.
        if 16 * old.len() < size {
            let mut sparse: Vec<(u32, u32)> = pairs.collect();
            sparse.sort_unstable();
            return Self {
                dense: Vec::new(),
                sparse,
            };
        }
        let mut dense = vec![NONE; size];
        pairs.for_each(|(old, new)| dense[old as usize] = new);
        Self {
            dense,
            sparse: Vec::new(),
        }
    }

    /// The new number of `old`, or [`NONE`].
    pub(super) fn get(&self, old: u32) -> u32 {
        if let Some(&new) = self.dense.get(old as usize) {
            return new;
        }
        let found = self.sparse.binary_search_by_key(&old, |pair| pair.0);
        found.map_or(NONE, |i| self.sparse[i].1)
    }
}

/// Numbers the marked elements in order: the old number of each new one, and the new number of each old one.
pub(super) fn compact(
    size: usize,
    marked: impl ExactSizeIterator<Item = u32>,
) -> (Vec<u32>, Renumbered) {
    if 16 * marked.len() < size {
        let mut old: Vec<u32> = marked.collect();
        old.sort_unstable();
        old.dedup();
        let new = Renumbered::new(size, &old);
        return (old, new);
    }
    let mut dense = vec![NONE; size];
    marked.for_each(|i| dense[i as usize] = 0);
    let mut old_of_new = Vec::new();
    for (old, new) in dense.iter_mut().enumerate() {
        if *new != NONE {
            *new = old_of_new.len() as u32;
            old_of_new.push(old as u32);
        }
    }
    let new = Renumbered {
        dense,
        sparse: Vec::new(),
    };
    (old_of_new, new)
}

impl<T: Real> Level<T> {
    /// The part that consists of `faces`: each with the corner that becomes its first.
    pub(crate) fn part(&self, faces: &[(u32, u32)]) -> Part<T> {
        self.restricted(faces, self.uvs.as_ref())
    }

    /// The same without texture coordinates.
    pub(crate) fn part_of_points(&self, faces: &[(u32, u32)]) -> Part<T> {
        self.restricted(faces, None)
    }

    fn restricted(&self, faces: &[(u32, u32)], uvs: Option<&FaceVarying<T>>) -> Part<T> {
        let t = &self.topology;
        let mut corners = Vec::with_capacity(4 * faces.len());
        let mut offsets = vec![0_u32];
        for &(f, turn) in faces {
            let halves = t.face_halves(f);
            let n = halves.len() as u32;
            corners.extend((0..n).map(|k| halves.start + (k + turn) % n));
            offsets.push(corners.len() as u32);
        }
        let new_corner = Renumbered::new(t.half_count(), &corners);
        let (vertices, new_vertex) =
            compact(t.vertex_count(), corners.iter().map(|&h| t.vertex(h)));
        let topology = part_topology(t, &corners, offsets, &new_corner, &vertices, &new_vertex);
        let (uvs, values) = match uvs {
            Some(uv) => {
                let (uv, values) = uv.part(&corners, &new_corner);
                (Some(uv), values)
            }
            None => (None, Vec::new()),
        };
        let points = vertices.iter().map(|&v| self.points[v as usize]).collect();
        let level = Self {
            topology,
            points,
            uvs,
            channels: Channels::default(),
            depth: self.depth,
            triangle_steps: 0,
            base_corner_faces: Vec::new(),
            base_face_count: 0,
        };
        Part {
            level,
            vertices,
            values,
        }
    }
}

fn part_topology(
    t: &Topology,
    corners: &[u32],
    offsets: Vec<u32>,
    new_corner: &Renumbered,
    vertices: &[u32],
    new_vertex: &Renumbered,
) -> Topology {
    let twins: Vec<u32> = corners
        .iter()
        .map(|&h| match t.twin(h) {
            NONE => NONE,
            twin => new_corner.get(twin),
        })
        .collect();
    let (old_edges, new_edge) = compact(t.edge_count(), corners.iter().map(|&h| t.edge(h)));
    let edges: Vec<u32> = corners.iter().map(|&h| new_edge.get(t.edge(h))).collect();
    let mut edge_halves = vec![NONE; old_edges.len()];
    for (h, &e) in edges.iter().enumerate() {
        let half = &mut edge_halves[e as usize];
        *half = (*half).min(h as u32);
    }
    let mut edge_sharpness = Vec::new();
    if !t.edge_sharpness.is_empty() {
        edge_sharpness = old_edges.iter().map(|&e| t.edge_sharpness(e)).collect();
        for (s, &h) in edge_sharpness.iter_mut().zip(&edge_halves) {
            if twins[h as usize] == NONE {
                *s = INFINITE_SHARPNESS;
            }
        }
    }
    let mut vertex_sharpness = Vec::new();
    if !t.vertex_sharpness.is_empty() {
        vertex_sharpness = vertices.iter().map(|&v| t.vertex_sharpness(v)).collect();
    }
    let mut corner_faces = Vec::new();
    let mut face_offsets = Vec::new();
    if offsets.windows(2).any(|w| w[1] - w[0] != 4) {
        for (f, w) in offsets.windows(2).enumerate() {
            corner_faces.resize(w[1] as usize, f as u32);
        }
        face_offsets = offsets;
    }
    let mut part = Topology {
        vertex_count: vertices.len(),
        face_offsets,
        corner_faces,
        corner_vertices: corners
            .iter()
            .map(|&h| new_vertex.get(t.vertex(h)))
            .collect(),
        twins,
        edges,
        edge_halves,
        edge_sharpness,
        vertex_sharpness,
        ..Topology::default()
    };
    if !t.holes.is_empty() {
        part.holes = (0..part.face_count() as u32)
            .map(|f| t.is_hole(t.face_of(corners[part.face_halves(f).start as usize])))
            .collect();
    }
    rebuild_fans(&mut part);
    part
}
