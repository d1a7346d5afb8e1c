//! Limits at the corners of the quads: of points and normals, and of what else is refined with them.

use super::{PatchCage, Surface};
use crate::control::{Fans, Kind};
use crate::mesh::NONE;
use crate::patch::FacePatches;

/// Fans of control points after some steps, for every control level.
#[derive(Clone, Debug)]
pub(crate) struct RefinedFans(pub(super) Vec<Fans>);

impl RefinedFans {
    /// The point of a fan of the quads; none where it is that of the limit.
    pub(crate) fn point(&self, fan: u32) -> Option<[f32; 3]> {
        self.0.first().map(|fans| fans.limits()[fan as usize])
    }
}

impl Surface {
    /// Point and unit normal at corner `h` of the faces that are diced.
    pub(crate) fn corner_point(&self, h: u32) -> ([f32; 3], [f32; 3]) {
        if let Some(PatchCage::Pn(cage)) = &self.patches {
            let corners = if self.triangles { 3 } else { 4 };
            let [u, v] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][(h % corners) as usize];
            let mut patches = FacePatches::default();
            let (t, points) = (&self.mesh.base, &self.cage.points);
            patches.take(cage, t, points, h / corners, self.is_split(), 0);
            return patches.at(u, v);
        }
        self.fan_limit(self.quads().fan(h))
    }

    /// Limit points and unit normals at the vertices of fan `fan` of the quad mesh.
    #[must_use]
    pub fn fan_limit(&self, fan: u32) -> ([f32; 3], [f32; 3]) {
        if let Some(mesh) = self.table_root() {
            let t = &mesh.topology;
            let normal = match t.fans()[fan as usize].first {
                NONE => [0.0, 0.0, 1.0],
                first => mesh.normal(first),
            };
            return (mesh.points[t.fan_vertex(fan) as usize], normal);
        }
        let (limits, normals) = match self.control.as_ref().and_then(|c| c.root(Kind::Points)) {
            Some(root) => (root.fans.limits(), root.fans.normals()),
            None => (&*self.mesh.fans.limits, &*self.mesh.fans.normals),
        };
        (limits[fan as usize], normals[fan as usize])
    }

    /// Limit of the texture coordinates at corner `h` of the quad mesh.
    pub(crate) fn uv_limit(&self, h: u32) -> Option<[f32; 3]> {
        self.corner_limit(Kind::Uvs, h)
    }

    /// Limit of the vertex colours at corner `h` of the quad mesh.
    pub(crate) fn color_limit(&self, h: u32) -> Option<[f32; 3]> {
        self.corner_limit(Kind::Colors, h)
    }

    fn corner_limit(&self, kind: Kind, h: u32) -> Option<[f32; 3]> {
        if let Some(tables) = &self.tables {
            let mesh = tables.root(kind)?;
            return Some(mesh.points[mesh.topology.vertex(h) as usize]);
        }
        if let Some(control) = &self.control {
            let mesh = control.root(kind)?;
            return Some(mesh.fans.limits()[mesh.topology.fan(h) as usize]);
        }
        let channel = self.channel(kind, None)?;
        Some(channel.fans.limits[channel.topology.fan(h) as usize])
    }

    /// Fans for another target than the limit: control points after `level` steps of the quad mesh.
    pub(crate) fn refined_fans(&self, level: u32) -> RefinedFans {
        if self.tables.is_some() {
            // Refined points are limit points.
            return RefinedFans(Vec::new());
        }
        RefinedFans(match &self.control {
            Some(control) => control.refined(level),
            None => {
                let mut fans = self.mesh.fans_of(&self.mesh.points, Some(level), false);
                fans.normals.clone_from(&self.mesh.fans.normals);
                vec![Fans::Quads(Default::default(), fans)]
            }
        })
    }
}
