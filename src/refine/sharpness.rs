//! Sharpness of the next level, computed ahead of the passes: what edges and vertices do depends on their children's sharpness.

use super::Options;
use super::connectivity::{Split, child_corner};
use super::ring::{Incidence, Spoke};
use crate::scheme::crease::{self, is_semi_sharp};
use crate::scheme::{CreaseMethod, INFINITE_SHARPNESS, Scheme};
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// One step of refinement: the parent level and what all passes need of it.
#[derive(Debug)]
pub struct Step<'a> {
    /// The parent level.
    pub topology: &'a Topology,
    /// Rules.
    pub options: Options,
    /// Irregular incidences.
    pub incidence: Incidence,
    /// Per edge the sharpness of its children at both ends; empty when no edge is sharp but the boundary.
    child_edges: Vec<[f32; 2]>,
}

impl<'a> Step<'a> {
    /// Prepares a step from `topology`.
    #[must_use]
    pub fn new(topology: &'a Topology, options: &Options) -> Self {
        let mut step = Self {
            topology,
            options: *options,
            incidence: Incidence::new(topology),
            child_edges: Vec::new(),
        };
        if !topology.edge_sharpness.is_empty() {
            step.child_edges = match options.creases {
                CreaseMethod::Uniform => uniform(topology),
                CreaseMethod::Chaikin => chaikin(topology, &step.incidence),
            };
        }
        step
    }

    /// Whether points are linear: midpoints, and vertices that stay. In Kobbelt's scheme that is the step that makes quads of polygons.
    #[must_use]
    #[inline]
    pub fn is_linear(&self) -> bool {
        match self.options.scheme {
            Scheme::Bilinear => true,
            Scheme::Kobbelt => !self.topology.all_quads(),
            _ => false,
        }
    }

    /// What faces split into.
    #[must_use]
    #[inline]
    pub fn split(&self) -> Split {
        if self.options.scheme.is_triangular() {
            Split::Triangles
        } else {
            Split::Quads
        }
    }

    /// [`child_corner`] of this step.
    #[must_use]
    #[inline]
    pub fn child_corner(&self, h: u32, k: u32) -> u32 {
        child_corner(self.split(), self.topology, h, k)
    }

    /// Number of face points: one per face, none in triangles.
    #[must_use]
    #[inline]
    pub fn face_points(&self) -> usize {
        match self.split() {
            Split::Quads => self.topology.face_count(),
            Split::Triangles => 0,
        }
    }

    /// Child vertex of edge 0; those of vertices and faces come before.
    #[must_use]
    #[inline]
    pub fn first_edge_point(&self) -> usize {
        self.topology.vertex_count() + self.face_points()
    }

    /// Whether no vertex or edge is sharp but the boundary, and the mesh is manifold.
    #[must_use]
    #[inline]
    pub fn is_plain(&self) -> bool {
        self.child_edges.is_empty()
            && self.topology.vertex_sharpness.is_empty()
            && self.incidence.single_fans()
    }

    /// Sharpness of the children of edge `e`, at its end 0 and its end 1.
    #[must_use]
    #[inline]
    pub fn child_edge(&self, e: u32) -> [f32; 2] {
        match self.child_edges.get(e as usize) {
            Some(&c) => c,
            None if self.topology.twin(self.topology.edge_half(e)) == NONE => {
                [INFINITE_SHARPNESS; 2]
            }
            None => [0.0; 2],
        }
    }

    /// Sharpness of the child of vertex `v`.
    #[must_use]
    #[inline]
    pub fn child_vertex(&self, v: u32) -> f32 {
        crease::decay(self.topology.vertex_sharpness(v))
    }

    /// Sharpness of both children of every edge; empty when no edge is sharp but the boundary.
    #[must_use]
    pub fn child_edges(&self) -> &[[f32; 2]] {
        &self.child_edges
    }
}

fn uniform(t: &Topology) -> Vec<[f32; 2]> {
    t.edge_sharpness
        .par_iter()
        .with_min_len(1 << 14)
        .map(|&s| [crease::decay(s); 2])
        .collect()
}

/// Chaikin children need the semi-sharp edges at either end: gathered per vertex first.
fn chaikin(t: &Topology, incidence: &Incidence) -> Vec<[f32; 2]> {
    let at_vertex: Vec<(f32, usize)> = (0..t.vertex_count() as u32)
        .into_par_iter()
        .with_min_len(1 << 12)
        .map_init(Vec::new, |spokes, v| {
            incidence.spokes(t, v, spokes);
            semi_sharp_sum(spokes.iter().map(|s: &Spoke| t.edge_sharpness(s.edge)))
        })
        .collect();
    t.edge_sharpness
        .par_iter()
        .enumerate()
        .with_min_len(1 << 12)
        .map(|(e, &s)| {
            let h = t.edge_half(e as u32);
            [t.vertex(h), t.vertex(t.next(h))].map(|v| {
                let (sum, count) = at_vertex[v as usize];
                crease::decay_edge(CreaseMethod::Chaikin, s, sum, count)
            })
        })
        .collect()
}

/// Sum and number of the semi-sharp ones.
#[must_use]
pub fn semi_sharp_sum(sharpness: impl Iterator<Item = f32>) -> (f32, usize) {
    sharpness
        .filter(|&s| is_semi_sharp(s))
        .fold((0.0, 0), |(sum, count), s| (sum + s, count + 1))
}
