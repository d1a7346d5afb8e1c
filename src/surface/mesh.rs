//! The mesh that is diced, of points or of face-varying values.

use crate::dice::fan_points::FanPoints;
use crate::dice::presplit::presplit;
use crate::dice::tangent_masks::TangentMasks;
use crate::topology::Topology;
use crate::topology::split::{Split, split};

/// One polygon mesh as quads: itself, or its first Catmull-Clark step.
#[derive(Clone, Debug)]
pub(super) struct QuadMesh {
    pub(super) base: Topology,
    pub(super) split: Option<Split>,
    pub(super) masks: TangentMasks,
    /// Points of the quads, by vertex.
    pub(super) points: Vec<[f32; 3]>,
    pub(super) fans: FanPoints,
    linear: bool,
}

impl QuadMesh {
    pub(super) fn new(base: Topology, points: &[[f32; 3]], normals: bool, linear: bool) -> Self {
        let split = (!base.all_quads()).then(|| split(&base));
        let masks = TangentMasks::new(split.as_ref().map_or(&base, |s| &s.topology));
        let mut mesh = Self {
            base,
            split,
            masks,
            points: Vec::new(),
            fans: FanPoints::default(),
            linear,
        };
        mesh.update(points, normals);
        mesh
    }

    pub(super) fn quads(&self) -> &Topology {
        self.split.as_ref().map_or(&self.base, |s| &s.topology)
    }

    pub(super) fn update(&mut self, points: &[[f32; 3]], normals: bool) {
        self.points = match &self.split {
            Some(split) => presplit(&self.base, split, points, self.linear),
            None => points.to_vec(),
        };
        self.fans = self.fans_of(&self.points, None, normals);
    }

    /// Fans of any values at the vertices of the quads.
    pub(super) fn fans_of(
        &self,
        points: &[[f32; 3]],
        steps: Option<u32>,
        normals: bool,
    ) -> FanPoints {
        // Linear surfaces stay where their control points are.
        let steps = if self.linear { Some(0) } else { steps };
        FanPoints::new(self.quads(), &self.masks, points, steps, normals)
    }

    /// Connectivity alone, of a mesh whose channels are elsewhere.
    pub(super) fn bare(base: Topology) -> Self {
        Self {
            base,
            split: None,
            masks: TangentMasks::default(),
            points: Vec::new(),
            fans: FanPoints::default(),
            linear: false,
        }
    }
}
