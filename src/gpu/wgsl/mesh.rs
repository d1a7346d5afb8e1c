//! Sources of the stages that make levels of whole meshes.

use super::{Source, source};
use crate::scheme::catmull_clark::edge_face_beside_triangles;

/// What faces of a whole mesh are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faces {
    /// Quads, split into quads.
    Quads,
    /// Triangles, split into triangles.
    Triangles,
    /// Any polygons, split into quads.
    Polygons,
}

/// A step of a whole mesh: its faces, and rules that seldom apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshStep {
    /// Its faces.
    pub faces: Faces,
    /// Whether points are linear: middles, and vertices that stay.
    pub linear: bool,
    /// Whether creases fade after Chaikin.
    pub chaikin: bool,
    /// Whether weights beside triangles are those of [`TriangleRule::Smooth`](crate::scheme::TriangleRule::Smooth).
    pub smooth_triangles: bool,
}

impl MeshStep {
    /// Of `faces`, with none of the rest.
    #[must_use]
    pub fn of(faces: Faces) -> Self {
        Self {
            faces,
            linear: false,
            chaikin: false,
            smooth_triangles: false,
        }
    }

    /// That of the level that it makes: polygons are quads then.
    #[must_use]
    pub fn next(self) -> Self {
        let faces = match self.faces {
            Faces::Polygons => Faces::Quads,
            same => same,
        };
        Self { faces, ..self }
    }

    /// With none and with all of the rules that seldom apply.
    #[must_use]
    pub fn ends() -> Vec<Self> {
        let all = [Faces::Quads, Faces::Triangles, Faces::Polygons];
        let full = |faces| Self {
            faces,
            linear: true,
            chaikin: true,
            smooth_triangles: true,
        };
        all.into_iter().map(Self::of).chain(all.map(full)).collect()
    }

    fn source(self, name: &'static str, own: &[&str]) -> Source {
        let flags = [
            ("LINEAR", self.linear),
            ("CHAIKIN", self.chaikin),
            ("SMOOTH_TRIANGLES", self.smooth_triangles),
        ];
        let flags = flags.map(|(name, is)| format!("const {name} = {is};\n"));
        let weight = edge_face_beside_triangles([3; 2]);
        let weight = format!("const FACE_OF_TRIANGLE = {weight:?}f;\n");
        let faces = match self.faces {
            Faces::Quads => include_str!("mesh_quads.wgsl"),
            Faces::Triangles => include_str!("mesh_triangles.wgsl"),
            Faces::Polygons => include_str!("mesh_polygons.wgsl"),
        };
        let parts = [&*flags.concat(), &weight, MESH, faces];
        source(name, &[&parts, own].concat())
    }
}

const MESH: &str = include_str!("mesh.wgsl");
const MESH_CHILD: &str = include_str!("mesh_child.wgsl");

/// Face points of a level.
#[must_use]
pub fn face(step: MeshStep) -> Source {
    step.source("face", &[MESH_CHILD, include_str!("face.wgsl")])
}

/// Edge points of a level.
#[must_use]
pub fn edge(step: MeshStep) -> Source {
    step.source("edge", &[MESH_CHILD, include_str!("edge.wgsl")])
}

/// Vertex points of a level.
#[must_use]
pub fn vertex(step: MeshStep) -> Source {
    step.source("vertex", &[MESH_CHILD, include_str!("vertex.wgsl")])
}

/// Half-edges, edges and vertices of the next level.
#[must_use]
pub fn connectivity(step: MeshStep) -> Source {
    let own = [MESH_CHILD, include_str!("connectivity.wgsl")];
    step.source("connectivity", &own)
}

/// Limit points and normals of a level.
#[must_use]
pub fn limit(step: MeshStep) -> Source {
    step.source("limit", &[include_str!("limit.wgsl")])
}
