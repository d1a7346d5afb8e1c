//! Limits at the fans of a channel, of quads or of triangles.

use crate::dice::fan_points::FanPoints;
use crate::dice::tangent_masks::TangentMasks;
use crate::dice::triangle::{TriangleFans, TriangleMasks};
use crate::topology::Topology;

/// Limit data of the fans of a channel, with the masks they came by.
#[derive(Clone, Debug)]
pub(crate) enum Fans {
    Quads(TangentMasks, FanPoints),
    Triangles(TriangleMasks, TriangleFans),
}

impl Fans {
    /// Evaluates anew at other points; masks stay.
    pub(super) fn update(&mut self, t: &Topology, points: &[[f32; 3]]) {
        match self {
            Self::Quads(masks, fans) => *fans = FanPoints::new(t, masks, points, None, true),
            Self::Triangles(masks, fans) => {
                *fans = TriangleFans::new(t, masks, points, None, true);
            }
        }
    }

    pub(super) fn new(t: &Topology, points: &[[f32; 3]], normals: bool) -> Self {
        if is_triangular(t) {
            let masks = TriangleMasks::new(t);
            let fans = TriangleFans::new(t, &masks, points, None, normals);
            return Self::Triangles(masks, fans);
        }
        let masks = TangentMasks::new(t);
        let fans = FanPoints::new(t, &masks, points, None, normals);
        Self::Quads(masks, fans)
    }

    /// The same with control points after `steps` steps in place of limits.
    pub(super) fn refined(&self, t: &Topology, points: &[[f32; 3]], steps: u32) -> Self {
        match self {
            Self::Quads(masks, limits) => {
                let mut fans = FanPoints::new(t, masks, points, Some(steps), false);
                fans.normals.clone_from(&limits.normals);
                Self::Quads(TangentMasks::default(), fans)
            }
            Self::Triangles(masks, limits) => {
                let mut fans = TriangleFans::new(t, masks, points, Some(steps), false);
                fans.normals.clone_from(&limits.normals);
                Self::Triangles(TriangleMasks::default(), fans)
            }
        }
    }

    pub(crate) fn limits(&self) -> &[[f32; 3]] {
        match self {
            Self::Quads(_, fans) => &fans.limits,
            Self::Triangles(_, fans) => &fans.limits,
        }
    }
    pub(crate) fn normals(&self) -> &[[f32; 3]] {
        match self {
            Self::Quads(_, fans) => &fans.normals,
            Self::Triangles(_, fans) => &fans.normals,
        }
    }
    pub(super) fn limits_mut(&mut self) -> &mut [[f32; 3]] {
        match self {
            Self::Quads(_, fans) => &mut fans.limits,
            Self::Triangles(_, fans) => &mut fans.limits,
        }
    }
    pub(super) fn normals_mut(&mut self) -> &mut [[f32; 3]] {
        match self {
            Self::Quads(_, fans) => &mut fans.normals,
            Self::Triangles(_, fans) => &mut fans.normals,
        }
    }
}

/// Whether the faces are triangles; else they are quads.
fn is_triangular(t: &Topology) -> bool {
    !t.all_quads()
}
