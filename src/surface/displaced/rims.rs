//! What a face's sides and corners take from elsewhere: directions at creases, texture coordinates at seams, and whose normals they have.

use super::{Displaced, DisplacedPatch};
use crate::control::Kind;
use crate::dice::face::{Part, Sides};
use crate::displace::mitre;
use crate::surface::Surface;
use crate::surface::displaced::linear_at;
use crate::topology::{NONE, Topology};

/// A side of a face that takes something from elsewhere.
#[derive(Clone, Debug, Default)]
pub(super) struct Rim {
    /// The half-edge that owns the side, and whether it is the face's own.
    pub(super) owner: u32,
    pub(super) own: bool,
    /// Both directions of its sides differ.
    pub(super) crease: bool,
    /// Texture coordinates of the owner, if they are others, and directions of points at the level that is prepared.
    pub(super) uvs: Vec<[f32; 3]>,
    pub(super) directions: Vec<[f32; 3]>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub(super) uv: [f32; 3],
    pub(super) direction: Option<[f32; 3]>,
    /// The half-edge whose face says the normal, and its texture coordinates.
    pub(super) owner: u32,
    pub(super) owner_uv: [f32; 3],
}

/// Columns and rows of corners in units of the whole face.
const QUAD: [[u32; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
const TRIANGLE: [[u32; 2]; 3] = [[0, 0], [1, 0], [1, 1]];

/// Those of a face.
pub(super) fn corners_of(triangle: bool) -> &'static [[u32; 2]] {
    if triangle { &TRIANGLE } else { &QUAD }
}

/// Grid point `k` of side `c` of a face of `n` segments.
pub(super) fn on_side(corners: &[[u32; 2]], c: usize, k: u32, n: u32) -> [u32; 2] {
    let (a, b) = (corners[c], corners[(c + 1) % corners.len()]);
    [0, 1].map(|i| a[i] * (n - k) + b[i] * k)
}

impl DisplacedPatch {
    /// Texture coordinates along side `c` of a face where they are linear.
    pub(in crate::surface) fn linear_side(&self, of: &[[f32; 3]; 4], c: usize) -> Vec<[f32; 3]> {
        let (corners, n) = (self.corners(), 1_u32 << self.level);
        let scale = 1.0 / n as f32;
        let all = (0..=n).map(|k| on_side(corners, c, k, n).map(|x| x as f32 * scale));
        all.map(|at| linear_at(of, self.triangle, at)).collect()
    }

    pub(super) fn corners(&self) -> &'static [[u32; 2]] {
        corners_of(self.triangle)
    }

    pub(super) fn prepare_rims(&mut self, surface: &Surface, on: &Displaced) {
        let (whole, cut) = (surface.whole_quads(), surface.quads());
        let uv_topology = if self.has_uvs {
            surface.uv_topology()
        } else {
            None
        };
        let n = 1_usize << self.level;
        for (c, h) in surface.halves_of(self.face).enumerate() {
            let edge = whole.edge(h);
            let owner = whole.edge_half(edge);
            let twin = whole.twin(h);
            let held = on.held_edges.contains(&edge);
            let crease = !held && twin != NONE && (surface.linear || cut.twin(h) == NONE);
            // Only twins answer for each other.
            let own = owner == h || owner != twin;
            let rim = &mut self.rims[c];
            (rim.owner, rim.own, rim.crease) = (if own { h } else { owner }, own, crease);
            rim.uvs.clear();
            rim.directions.clear();
            if held {
                rim.directions.resize(n + 1, [0.0; 3]);
            }
            if crease && n > 1 {
                self.crease_directions(surface, whole, c, h);
            }
            let seam =
                !own && uv_topology.is_some_and(|t| surface.tables.is_some() || t.twin(h) == NONE);
            if seam && n > 1 {
                self.seam_uvs(surface, whole, c);
            }
        }
        for (c, h) in surface.halves_of(self.face).enumerate() {
            let v = whole.fan(h);
            let first = |t: &Topology, fan: u32| t.fans()[fan as usize].first;
            let uv = |h: u32| surface.uv_limit(h).unwrap_or_default();
            let held = on.held_vertices.contains(&whole.vertex(h));
            // Faces of the bilinear scheme have their own normals.
            let owner = if surface.linear {
                h
            } else {
                first(cut, cut.fan(h))
            };
            let corner = &mut self.corners[c];
            corner.owner = owner;
            corner.direction = match held {
                true => Some([0.0; 3]),
                false => on.directions.get(&v).copied(),
            };
            if self.has_uvs {
                corner.uv = uv(first(whole, v));
                corner.owner_uv = uv(owner);
            }
        }
    }

    /// Mitres along a crease, from the normals of both of its sides: those of patches where they are drawn, as all points move along.
    fn crease_directions(&mut self, surface: &Surface, whole: &Topology, c: usize, h: u32) {
        let (first, second) = (
            whole.edge_half(whole.edge(h)),
            whole.twin(whole.edge_half(whole.edge(h))),
        );
        let mut normals = [first, second].map(|half| {
            (self.other).prepare_drawn_side(surface, whole.face_of(half), self.level);
            let side = half - whole.face_halves(whole.face_of(half)).start;
            self.other.side_samples(side as usize).1
        });
        let own = usize::from(first != h);
        normals[1 - own].reverse();
        let [a, b] = normals;
        self.rims[c].directions = a.iter().zip(&b).map(|(&a, &b)| mitre(&[a, b])).collect();
    }

    /// Texture coordinates of the owner along a side.
    fn seam_uvs(&mut self, surface: &Surface, whole: &Topology, c: usize) {
        let half = self.rims[c].owner;
        let face = whole.face_of(half);
        let side = (half - whole.face_halves(face).start) as usize;
        let mut uvs = match surface.has_linear_uvs() {
            true => match surface.linear_corners(face) {
                Some(of) => self.linear_side(&of, side),
                None => return,
            },
            false => {
                self.other
                    .prepare_side(surface, Kind::Uvs, face, self.level, Sides::Points);
                self.other.side_samples(side).0
            }
        };
        uvs.reverse();
        self.rims[c].uvs = uvs;
    }

    /// Texture coordinates that corners in a part take from elsewhere; none if more than corners do, or move in other directions than their
    /// normals.
    pub(in crate::surface) fn plain_corners(
        &self,
        surface: &Surface,
        part: Part,
    ) -> Option<Vec<[f32; 3]>> {
        let on = self.on.as_ref()?;
        let (whole, cut) = (surface.whole_quads(), surface.quads());
        let uvs = surface.uv_topology().filter(|_| self.has_uvs);
        let is_plain = |h: u32| {
            let joined = |t: &Topology| t.twin(h) != NONE;
            joined(whole) && joined(cut) && uvs.is_none_or(joined)
        };
        let moves_freely = on.directions.is_empty() && on.held_edges.is_empty();
        if !moves_freely
            || !on.held_vertices.is_empty()
            || surface.linear
            || surface.tables.is_some()
            || !surface.halves_of(self.face).all(is_plain)
        {
            return None;
        }
        let mut out = Vec::new();
        if self.has_uvs {
            let first = surface.halves_of(self.face).start;
            self.on_corners(part, |c, _| {
                let fan = whole.fans()[whole.fan(first + c as u32) as usize].first;
                out.push(surface.uv_limit(fan).unwrap_or_default());
            });
        }
        Some(out)
    }

    /// Calls `put` with every point of a part that lies on a side, corners left out: the side, its number there at the level that is
    /// prepared, and its column and row in the part.
    pub(super) fn on_rims(&self, part: Part, mut put: impl FnMut(usize, u32, [usize; 2])) {
        let corners = self.corners();
        let n = 1_u32 << part.level;
        let shift = self.level - part.level;
        for c in 0..corners.len() {
            let (a, b) = (corners[c], corners[(c + 1) % corners.len()]);
            // What runs along the side is beyond all points but those of the part.
            let axis = usize::from(a[0] == b[0]);
            let (low, high) = (part.start[axis], part.start[axis] + part.segments);
            let (low, high) = match a[axis] < b[axis] {
                true => (low, high),
                false => (n - high, n - low),
            };
            for k in low.max(1)..=high.min(n - 1) {
                let at = on_side(corners, c, k, n);
                let inside = |i: usize| {
                    at[i]
                        .checked_sub(part.start[i])
                        .filter(|&x| x <= part.segments)
                };
                if let (Some(i), Some(j)) = (inside(0), inside(1)) {
                    put(c, k << shift, [i as usize, j as usize]);
                }
            }
        }
    }

    /// The same of corners.
    pub(super) fn on_corners(&self, part: Part, mut put: impl FnMut(usize, [usize; 2])) {
        let n = 1_u32 << part.level;
        for (c, at) in self.corners().iter().enumerate() {
            let inside = |i: usize| {
                (at[i] * n)
                    .checked_sub(part.start[i])
                    .filter(|&x| x <= part.segments)
            };
            if let (Some(i), Some(j)) = (inside(0), inside(1)) {
                put(c, [i as usize, j as usize]);
            }
        }
    }

    /// Face and place of point `k` of the side that half-edge `half` is, at the level that is prepared.
    pub(super) fn place_of(&self, surface: &Surface, half: u32, k: u32) -> (u32, [f32; 2]) {
        let whole = surface.whole_quads();
        let face = whole.face_of(half);
        let side = (half - whole.face_halves(face).start) as usize;
        let n = 1_u32 << self.level;
        (
            face,
            on_side(self.corners(), side, k, n).map(|x| x as f32 / n as f32),
        )
    }
}
