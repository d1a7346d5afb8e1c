//! What of a displaced surface belongs to whom, and what does not move: once per topology, directions once per points.

use super::rims::corners_of;
use crate::displace::normal::unit;
use crate::displace::{Displacement, mitre};
use crate::math;
use crate::patch::FacePatches;
use crate::surface::{PatchCage, Surface};
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
        let mut patches = FacePatches::default();
        for (v, fan) in (0..).zip(whole.fans()) {
            let cuts = |h: u32| cut.fans()[cut.fan(h) as usize].faces != fan.faces;
            if fan.first != NONE && (surface.linear || cuts(fan.first)) {
                let all = surface.mitred_at(v).into_iter();
                let normals = all.filter_map(|h| surface.drawn_corner(h, &mut patches));
                directions.insert(v, mitre(&normals.collect::<Vec<_>>()));
            }
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

    /// The half-edges of fan `v` of the whole mesh whose corners have the normals that its direction is the mitre of, if it is one of several: one of
    /// each side of creases, or of every face where all edges are creases.
    fn mitred_at(&self, v: u32) -> Vec<u32> {
        let (whole, cut) = (self.whole_quads(), self.quads());
        if !self.linear {
            let first = |fan: u32| cut.fans()[fan as usize].first;
            return sectors(whole, cut, v).into_iter().map(first).collect();
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
        out
    }

    /// Unit normal at the corner that half-edge `h` of the quads begins with, on its side of creases, of what is drawn; nothing where a bilinear face
    /// has none.
    fn drawn_corner(&self, h: u32, patches: &mut FacePatches) -> Option<[f32; 3]> {
        let t = self.quads();
        if let Some(PatchCage::Pn(cage)) = &self.patches {
            let (base, points) = (&self.mesh.base, &self.cage.points);
            let q = t.face_of(h);
            patches.take(cage, base, points, q, self.is_split(), 0);
            let c = (h - t.face_halves(q).start) as usize;
            let [u, v] = corners_of(self.triangles)[c].map(|x| x as f32);
            return Some(patches.at(u, v).1);
        }
        if !self.linear {
            return Some(self.fan_limit(t.fan(h)).1);
        }
        let [own, next, before] =
            [h, t.next(h), t.prev(h)].map(|h| self.control_points()[t.vertex(h) as usize]);
        unit(math::sub(next, own), math::sub(before, own))
    }

    /// The half-edges whose corners have the normals that the direction of corner `h` is the mitre of: where that is not its own normal.
    /// None where nothing moves.
    #[cfg(feature = "gpu")]
    pub(crate) fn mitred_corner(&self, h: u32) -> Option<Vec<u32>> {
        let on = self.displaced.as_ref()?;
        let whole = self.whole_quads();
        let v = whole.fan(h);
        if on.held_vertices.contains(&whole.vertex(h)) {
            return None;
        }
        if !on.directions.contains_key(&v) {
            return Some(Vec::new());
        }
        Some(self.mitred_at(v))
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

    /// Whether both derivatives at the corner that half-edge `h` begins with have one direction.
    pub(in crate::surface) fn is_flat_corner(&self, h: u32) -> bool {
        let t = self.quads();
        t.fans()[t.fan(h) as usize].is_flat()
    }

    pub(super) fn halves_of(&self, face: u32) -> std::ops::Range<u32> {
        self.quads().face_halves(face)
    }
}
