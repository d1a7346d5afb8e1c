//! Named values beside points and texture coordinates: per vertex, per face, per face corner.

use crate::scheme::FaceVaryingRule;

/// Values per vertex, refined like points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexChannel {
    /// Its name, unique among those of vertices.
    pub name: String,
    /// Numbers per value, 1 to 4.
    pub width: usize,
    /// One value after the other.
    pub values: Vec<f32>,
}

/// Values per face corner, refined like texture coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceVaryingChannel {
    /// Its name, unique among those of corners.
    pub name: String,
    /// Numbers per value, 1 to 4.
    pub width: usize,
    /// One value after the other.
    pub values: Vec<f32>,
    /// Value of every corner, or [`NONE`](super::NONE).
    pub corners: Vec<u32>,
    /// Rule of its own; none, that of the texture coordinates.
    pub rule: Option<FaceVaryingRule>,
}

/// What a face can have.
#[derive(Clone, Debug, PartialEq)]
pub enum UniformValues {
    /// One number that names something.
    Ids(Vec<u32>),
    /// Numbers, `width` per face.
    Numbers {
        /// Numbers per face, 1 to 4.
        width: usize,
        /// One value after the other.
        values: Vec<f32>,
    },
}

/// Values per face, inherited by all faces that descend from it.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformChannel {
    /// Its name, unique among those of faces.
    pub name: String,
    /// One value per face of the cage.
    pub values: UniformValues,
}

/// All channels of a cage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CageChannels {
    /// Per vertex; colours that came with the file are not among them.
    pub vertex: Vec<VertexChannel>,
    /// Per face.
    pub uniform: Vec<UniformChannel>,
    /// Per face corner; texture coordinates are not among them.
    pub face_varying: Vec<FaceVaryingChannel>,
}
