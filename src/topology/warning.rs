//! What was odd about the faces of a mesh.

use super::Topology;

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
