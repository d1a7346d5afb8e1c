//! What of a displaced surface belongs to whom, and what does not move: once per topology, directions once per points.

use crate::displace::normal::unit;
use crate::displace::{Displacement, mitre};
use crate::math;
use crate::surface::Surface;
use crate::topology::{NONE, Topology};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The displacement of a surface, with what of its topology goes its own ways.
#[derive(Clone, Debug)]
pub(crate) struct Displaced {
    pub(crate) displacement: Displacement,
    /// Edges of more than two faces, and fans of vertices that do not hang together: these stay.
    pub(super) held_edges: BTreeSet<u32>,
    pub(super) held_vertices: BTreeSet<u32>,
    /// Directions of vertices at infinite creases.
    pub(super) directions: BTreeMap<u32, [f32; 3]>,
    /// Bound of how far points move.
    pub(super) reach: f32,
}

impl Displaced {
    fn new(surface: &Surface, displacement: Displacement) -> Self {
        let (whole, cut) = (surface.whole_quads(), surface.quads());
        let mut faces = vec![0_u32; whole.edge_count()];
        for h in 0..whole.half_count() as u32 {
            faces[whole.edge(h) as usize] += 1;
        }
        let paired = |e: u32| whole.twin(whole.edge_half(e)) != NONE;
        let held = (0..whole.edge_count() as u32)
            .filter(|&e| faces[e as usize] > 1 + u32::from(paired(e)));
        let held_edges = held.collect();
        let first = whole.vertex_count() as u32;
        let extra = first..whole.fans().len() as u32;
        let held_vertices = extra.map(|fan| whole.fan_vertex(fan)).collect();
        let mut directions = BTreeMap::new();
        if surface.linear {
            directions = linear_directions(surface);
        }
        for (v, fan) in (0..).zip(whole.fans()) {
            let cuts = |h: u32| cut.fans()[cut.fan(h) as usize].faces != fan.faces;
            if fan.first == NONE || surface.linear || !cuts(fan.first) {
                continue;
            }
            let fans = sectors(whole, cut, v);
            let normals = fans.iter().map(|&fan| surface.fan_limit(fan).1);
            directions.insert(v, mitre(&normals.collect::<Vec<_>>()));
        }
        let most = displacement.most();
        // Mitres.
        let reach = if directions.is_empty() {
            most
        } else {
            2.0 * most
        };
        Self {
            reach,
            displacement,
            held_edges,
            held_vertices,
            directions,
        }
    }
}

/// The fans between creases around fan `v` of the whole mesh, in order.
fn sectors(whole: &Topology, cut: &Topology, v: u32) -> Vec<u32> {
    let fan = &whole.fans()[v as usize];
    let mut out: Vec<u32> = Vec::new();
    let (mut h, mut last) = (fan.first, NONE);
    for _ in 0..fan.faces {
        let own = cut.fan(h);
        if own != last && !(fan.closed && Some(&own) == out.first()) {
            out.push(own);
        }
        last = own;
        h = whole.rotate(h);
        if h == NONE {
            break;
        }
    }
    out
}

/// Directions of the vertices of a bilinear surface, where every edge is a crease: mitres of their faces' normals.
fn linear_directions(surface: &Surface) -> BTreeMap<u32, [f32; 3]> {
    let (t, points) = (surface.quads(), surface.control_points());
    let at = |h: u32| points[t.vertex(h) as usize];
    let mut out = BTreeMap::new();
    for (v, fan) in (0..).zip(t.fans()).filter(|(_, fan)| fan.first != NONE) {
        let mut h = fan.first;
        let mut normals = Vec::new();
        for _ in 0..fan.faces {
            let (next, before) = (
                math::sub(at(t.next(h)), at(h)),
                math::sub(at(t.prev(h)), at(h)),
            );
            normals.extend(unit(next, before));
            h = t.rotate(h);
            if h == NONE {
                break;
            }
        }
        out.insert(v, mitre(&normals));
    }
    out
}

impl Surface {
    /// Displaces the surface from now on, in [`Surface::dice`] and pictures; `None` takes the displacement away. A map needs texture
    /// coordinates: without, it is read at (0, 0). PN triangles then stand on the cage's own normals, not those of the file. Evaluation at places ([`evaluate`](crate::evaluate)) goes on answering for the limit
    /// surface. The rules at seams and creases: [`displace`](crate::displace).
    pub fn set_displacement(&mut self, displacement: Option<Displacement>) {
        if displacement.is_some() {
            self.forget_given_normals();
        }
        self.displaced = displacement.map(|d| Arc::new(Displaced::new(self, d)));
    }

    /// How the surface is displaced.
    #[must_use]
    pub fn displacement(&self) -> Option<&Displacement> {
        self.displaced.as_ref().map(|d| &d.displacement)
    }

    /// Bound of how far displacement moves a point; 0 without.
    #[must_use]
    pub fn displacement_reach(&self) -> f32 {
        self.displaced.as_ref().map_or(0.0, |d| d.reach)
    }

    /// The half-edges whose corners have the normals that the direction of corner `h` is the mitre of: where that is not its own normal.
    /// None where nothing moves.
    #[cfg(feature = "gpu")]
    pub(crate) fn mitred_corner(&self, h: u32) -> Option<Vec<u32>> {
        let on = self.displaced.as_ref()?;
        let (whole, cut) = (self.whole_quads(), self.quads());
        let v = whole.fan(h);
        if on.held_vertices.contains(&whole.vertex(h)) {
            return None;
        }
        if !on.directions.contains_key(&v) {
            return Some(Vec::new());
        }
        if !self.linear {
            let first = |fan: u32| cut.fans()[fan as usize].first;
            return Some(sectors(whole, cut, v).into_iter().map(first).collect());
        }
        let fan = &whole.fans()[v as usize];
        let mut out = Vec::new();
        let mut h = fan.first;
        for _ in 0..fan.faces {
            out.push(h);
            h = whole.rotate(h);
            if h == NONE {
                break;
            }
        }
        Some(out)
    }

    /// The same of the side that is half-edge `h`: both half-edges of its edge at creases.
    #[cfg(feature = "gpu")]
    pub(crate) fn mitred_side(&self, h: u32) -> Option<Vec<u32>> {
        let on = self.displaced.as_ref()?;
        let (whole, cut) = (self.whole_quads(), self.quads());
        let edge = whole.edge(h);
        if on.held_edges.contains(&edge) {
            return None;
        }
        let is_crease = whole.twin(h) != NONE && (self.linear || cut.twin(h) == NONE);
        let first = whole.edge_half(edge);
        Some(match is_crease {
            true => vec![first, whole.twin(first)],
            false => Vec::new(),
        })
    }

    /// Makes what depends on the points again.
    pub(in crate::surface) fn update_displacement(&mut self) {
        let displacement = self.displacement().cloned();
        self.set_displacement(displacement);
    }

    pub(super) fn halves_of(&self, face: u32) -> std::ops::Range<u32> {
        self.quads().face_halves(face)
    }
}
