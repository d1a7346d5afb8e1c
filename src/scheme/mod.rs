//! Rules of the subdivision schemes: options and masks. Rules know no meshes; weights depend on valence and sharpness alone.
//!
//! Sources: Catmull, Clark, *Recursively generated B-spline surfaces on arbitrary topological meshes*, 1978; Loop, *Smooth
//! subdivision surfaces based on triangles*, 1987; DeRose, Kass, Truong, *Subdivision surfaces in character animation*, 1998.

pub mod butterfly;
pub mod by_valence;
pub mod catmull_clark;
pub mod crease;
pub mod dart;
pub mod kobbelt;
pub mod limit;
pub mod loop_scheme;

/// Sharpness from which on an edge or vertex is infinitely sharp and never decays.
pub const INFINITE_SHARPNESS: f32 = 10.0;

/// What happens at the boundary of an open cage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Faces at boundary vertices are holes unless the boundary edges are sharp.
    None,
    /// The boundary is a smooth curve, also at vertices with one face.
    EdgeOnly,
    /// The boundary is a smooth curve; a vertex with one face is a sharp corner.
    #[default]
    EdgeAndCorner,
}

/// How semi-sharp edges lose their sharpness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CreaseMethod {
    /// By one per level.
    #[default]
    Uniform,
    /// By Chaikin's corner-cutting average along the crease, less one.
    Chaikin,
}

/// Where face-varying values are interpolated linearly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceVaryingRule {
    /// Nowhere.
    None,
    /// At corners of charts.
    CornersOnly,
    /// At corners, and where more than two charts meet.
    #[default]
    CornersPlus1,
    /// Also at darts and concave corners.
    CornersPlus2,
    /// Along all boundaries of charts.
    Boundaries,
    /// Everywhere.
    All,
}

/// Weights of Catmull-Clark edges next to triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleRule {
    /// The ordinary weights.
    #[default]
    Catmark,
    /// Smoother weights beside triangles.
    Smooth,
}

/// Subdivision schemes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scheme {
    /// Catmull and Clark: cubic B-splines on any polygons.
    #[default]
    CatmullClark,
    /// Loop: quartic box splines on triangles.
    Loop,
    /// Modified Butterfly, after Zorin, Schröder and Sweldens: interpolates triangles.
    Butterfly,
    /// Kobbelt's scheme: interpolates quads. Cages with other polygons are split linearly once.
    Kobbelt,
    /// Face centres and edge midpoints; old vertices stay.
    Bilinear,
}

impl Scheme {
    /// Whether faces are triangles that split into four triangles; else any face becomes quads around its centre.
    #[must_use]
    #[inline]
    pub const fn is_triangular(self) -> bool {
        matches!(self, Self::Loop | Self::Butterfly)
    }

    /// Whether old vertices stay, and new points have smooth rules: Butterfly and Kobbelt's. Semi-sharp creases mean nothing to them.
    #[must_use]
    #[inline]
    pub const fn is_interpolating(self) -> bool {
        matches!(self, Self::Butterfly | Self::Kobbelt)
    }
}
