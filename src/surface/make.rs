//! Making a surface of a cage: what is read from tags, and the meshes, trees and tables of its channels.

use super::mesh::QuadMesh;
use super::{Surface, SurfaceOptions, VertexChannel};
use crate::control::ControlTree;
use crate::control::tables::{Plans, TableTree};
use crate::dice::presplit::presplit;
use crate::math;
use crate::mesh::{Cage, NONE};
use crate::refine;
use crate::scheme::{Boundary, FaceVaryingRule, INFINITE_SHARPNESS, Scheme, TriangleRule};
use crate::topology::TopologyWarning;
use crate::topology::channel::connect_channel;
use std::sync::Arc;

/// The mesh of the faces that are diced, with points and texture coordinates.
struct FirstLevel {
    level: refine::Level<f64>,
    /// Of a cage that is split first: the vertex of the split mesh that each vertex is.
    split_vertices: Vec<u32>,
    /// One per vertex, or none.
    colors: Vec<[f64; 3]>,
}

impl Surface {
    /// Channels of a cage without creases.
    pub(super) fn make_channels(&mut self, rule: FaceVaryingRule, boundary: Boundary) {
        let (cage, linear) = (&self.cage, self.linear);
        let base = std::mem::take(&mut self.mesh.base);
        self.uv = (!cage.corner_uvs.is_empty()).then(|| {
            // Corners without a value share one more, at the origin.
            let missing = cage.uvs.len() as u32;
            let values: Vec<u32> = cage
                .corner_uvs
                .iter()
                .map(|&i| if i == NONE { missing } else { i })
                .collect();
            let topology = connect_channel(&base, values, cage.uvs.len() + 1, rule, boundary);
            QuadMesh::new(topology, &uv_points(cage), false, linear)
        });
        let mesh = QuadMesh::new(base, &cage.points, true, linear);
        self.colors = (!cage.colors.is_empty()).then(|| {
            let points = match &mesh.split {
                Some(split) => presplit(&mesh.base, split, &cage.colors, linear),
                None => cage.colors.clone(),
            };
            let fans = mesh.fans_of(&points, None, false);
            VertexChannel { points, fans }
        });
        self.mesh = mesh;
    }

    /// The tables of a cage under an interpolating scheme; `plans` are those of the same cage with other points.
    pub(super) fn table_tree(
        &self,
        rule: FaceVaryingRule,
        plans: Option<Arc<Plans>>,
    ) -> Option<TableTree> {
        if !self.scheme.is_interpolating() {
            return None;
        }
        let first = self.first_level(rule)?;
        let options = self.refine_options();
        Some(TableTree::new(first.level, first.colors, options, plans))
    }

    /// The control tree of a cage whose sharpness or triangle rule asks for one.
    pub(super) fn control_tree(&mut self, rule: FaceVaryingRule) -> Option<ControlTree> {
        let (cage, base) = (&self.cage, &self.mesh.base);
        let options = self.refine_options();
        let tagged = !base.edge_sharpness.is_empty()
            || cage.tags.corners.iter().any(|c| c.sharpness > 0.0)
            || (options.triangles == TriangleRule::Smooth && !base.all_quads());
        if self.linear || !(tagged || self.triangles) {
            return None;
        }
        let first = self.first_level(rule)?;
        self.split_vertices = first.split_vertices;
        Some(ControlTree::new(first.level, first.colors, options))
    }

    /// The mesh of the faces that are diced.
    fn first_level(&self, rule: FaceVaryingRule) -> Option<FirstLevel> {
        let (cage, base) = (&self.cage, &self.mesh.base);
        let options = self.refine_options();
        let level = refine::Level::<f64>::of_cage(cage, base.clone(), self.scheme, rule).ok()?;
        let wide = |c: &[f32; 3]| c.map(f64::from);
        let colors: Vec<[f64; 3]> = cage.colors.iter().map(wide).collect();
        if base.all_quads() || self.triangles {
            return Some(FirstLevel {
                level,
                split_vertices: Vec::new(),
                colors,
            });
        }
        let mut timings = refine::Timings::default();
        let quads = level.next(&options, &mut timings).ok()?;
        let colors = match colors.is_empty() {
            true => colors,
            false => {
                let colors = refine::Level::new(base.clone(), colors).ok()?;
                colors.next(&options, &mut timings).ok()?.points
            }
        };
        // Children keep the directions of a quad they come from; here their first corner is their parent's corner.
        let into = refine::connectivity::Split::Quads;
        let first = |h: u32| refine::connectivity::child_corner(into, base, h, 0) & 3;
        let turned: Vec<(u32, u32)> = (0..base.half_count() as u32)
            .map(|h| (h, first(h)))
            .collect();
        let part = quads.part(&turned);
        let colors = match colors.is_empty() {
            true => colors,
            false => part.vertices.iter().map(|&v| colors[v as usize]).collect(),
        };
        Some(FirstLevel {
            level: part.level,
            split_vertices: part.vertices,
            colors,
        })
    }
}

/// The scheme that a cage is drawn by. Schemes for triangles cannot take other faces; then it is Catmull-Clark, with a warning.
pub(super) fn scheme_of(
    cage: &Cage,
    options: &SurfaceOptions,
    warnings: &mut Vec<TopologyWarning>,
) -> Scheme {
    let polygon = cage.first_polygon();
    let wanted = options.scheme.or(cage.tags.scheme);
    match (wanted, polygon) {
        (Some(scheme), Some(face)) if scheme.is_triangular() => {
            warnings.push(TopologyWarning::NotTriangles {
                first: face,
                corners: cage.face(face as usize).len() as u32,
            });
            Scheme::CatmullClark
        }
        (Some(scheme), _) => scheme,
        (None, None) if cage.face_count() > 0 => Scheme::Loop,
        (None, _) => Scheme::CatmullClark,
    }
}

/// Unit normals of the file at every corner, where it has any; not numbers at corners without.
pub(super) fn given_normals(cage: &Cage) -> Vec<[f32; 3]> {
    let of = |&n: &u32| {
        let normal = cage.normals.get(n as usize);
        let unit = normal.and_then(|&n| math::normalize(n));
        unit.unwrap_or([f32::NAN; 3])
    };
    cage.corner_normals.iter().map(of).collect()
}

/// Tension by the sharpness of corners: 0 where it is infinite. Empty where all are 1.
pub(super) fn tagged_tension(cage: &Cage) -> Vec<f32> {
    if cage.tags.corners.is_empty() {
        return Vec::new();
    }
    let mut out = vec![1.0; cage.points.len()];
    for corner in &cage.tags.corners {
        if let Some(tension) = out.get_mut(corner.vertex as usize) {
            *tension = math::saturate(1.0 - corner.sharpness / INFINITE_SHARPNESS);
        }
    }
    out
}

fn uv_points(cage: &Cage) -> Vec<[f32; 3]> {
    cage.uvs
        .iter()
        .map(|&[u, v]| [u, v, 0.0])
        .chain([[0.0; 3]])
        .collect()
}
