//! What stands behind the control points of a scene on the device: normals that cages bring along, or control points of PN triangles.

use super::error::GpuError;
use crate::frame::Scene;
use crate::patch::PatchKind;
use crate::surface::Surface;

/// Vectors behind the control points.
#[derive(Debug)]
pub(super) enum Further {
    /// Of cages. They stay as they are when points move.
    Normals(Vec<[f32; 3]>),
    /// Of PN triangles, made by the surfaces that have them. They follow the points.
    Nets {
        vectors: Vec<[f32; 3]>,
        /// With where the points of each begin among all.
        surfaces: Vec<(usize, Surface)>,
    },
}

impl Default for Further {
    fn default() -> Self {
        Self::Normals(Vec::new())
    }
}

impl Further {
    /// Those of all PN triangles of a scene.
    pub(super) fn nets(scene: &Scene) -> Self {
        let (mut vectors, mut surfaces, mut first) = (Vec::new(), Vec::new(), 0);
        for object in &scene.objects {
            let surface = &object.surface;
            if surface.patch_kind() == PatchKind::Pn {
                surface.list_pn_nets(&mut vectors);
                surfaces.push((first, surface.clone()));
            }
            first += surface.control_base().len();
        }
        Self::Nets { vectors, surfaces }
    }

    pub(super) fn vectors(&self) -> &[[f32; 3]] {
        match self {
            Self::Normals(vectors) | Self::Nets { vectors, .. } => vectors,
        }
    }

    /// Whether there are any that follow the points.
    pub(super) fn follows(&self) -> bool {
        matches!(self, Self::Nets { surfaces, .. } if !surfaces.is_empty())
    }

    /// Takes the points of all objects that moved.
    pub(super) fn follow(&mut self, points: &[[f32; 3]]) -> Result<(), GpuError> {
        let Self::Nets { vectors, surfaces } = self else {
            return Ok(());
        };
        // Before anything changes: a list of which some objects moved would be torn.
        if !points.iter().flatten().all(|c| c.is_finite()) {
            return Err(GpuError::Unsupported {
                what: "points that are not finite",
            });
        }
        vectors.clear();
        for (first, surface) in surfaces {
            let own = *first..*first + surface.control_base().len();
            let moved = surface.update_points(&points[own]);
            moved.map_err(|_| GpuError::Unsupported {
                what: "points that are not finite",
            })?;
            surface.list_pn_nets(vectors);
        }
        Ok(())
    }
}
