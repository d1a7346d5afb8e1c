//! How far the surfaces of a scene are refined: their levels, and the blocks of those that are cut adaptively.

use super::scene::{Object, Scene};
use super::source::Drawing;
use super::{RenderError, Renderer, level};
use crate::camera::View;
use crate::limits::{Budget, LimitError};
use crate::patch::PatchKind;
use crate::raster::bounds;
use crate::records::ScreenSize;
#[cfg(feature = "gpu")]
use crate::scheme::Scheme;
use crate::surface::Surface;
use crate::tessellate::{DepthTags, Flatness, Tessellation, depth_tags, flatness};

/// How far surfaces are refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refinement {
    /// The same level everywhere, 0 to 10.
    Uniform(u32),
    /// As fine as the picture asks for, edge by edge and block by block; the limit surface alone. Other drawings get a level from the
    /// length of their edges.
    Adaptive(Flatness),
    /// What the command line draws by default: [`Adaptive`](Self::Adaptive) within half a pixel, and
    /// [`ByEdgeLength`](Self::ByEdgeLength) for interpolating schemes, which are refined as a whole so that looking for what is flat takes
    /// longer than drawing it all.
    Default {
        /// Highest level.
        max_level: u32,
    },
    /// By integers at the vertices of the cage, 0 to 10; the limit surface alone. Other drawings get the level of their deepest edge.
    DepthTags(DepthTags),
    /// Per model, from the length of its edges on the screen, up to a limit.
    ByEdgeLength {
        /// Highest level.
        max_level: u32,
    },
}

impl Refinement {
    /// The same without adaptive tessellation, for pictures of `size` that are seen for a moment: levels by the length of edges, or where a
    /// scene has more faces than are told apart, level 1 without looking at them.
    #[must_use]
    pub fn without_flatness(self, scene: &Scene, size: ScreenSize) -> Self {
        /// Pixels per face below which its edges are not looked at: most are short enough, and there are many.
        const SMALL: u64 = 16;
        let pixels = u64::from(size.width) * u64::from(size.height);
        match self {
            Self::Adaptive(Flatness { max_level, .. }) | Self::Default { max_level } => {
                match scene.face_count() as u64 * SMALL > pixels {
                    true => Self::Uniform(max_level.min(1)),
                    false => Self::ByEdgeLength { max_level },
                }
            }
            other => other,
        }
    }

    /// What it is for a surface.
    pub(super) fn of(self, surface: &Surface) -> Self {
        match self {
            Self::Default { max_level } if surface.has_tables() => Self::ByEdgeLength { max_level },
            Self::Default { max_level } => Self::Adaptive(Flatness {
                max_level,
                ..Flatness::default()
            }),
            other => other,
        }
    }
}

impl Renderer {
    /// Levels of the objects, and the blocks of those that are tessellated: what other backends draw by, too. Blocks are taken from `budget`.
    #[cfg(feature = "gpu")]
    pub(crate) fn decide(
        &self,
        scene: &Scene,
        view: &View,
        budget: &mut Budget<'_>,
    ) -> Result<(Vec<u32>, Vec<Option<Tessellation>>), RenderError> {
        self.check_size()?;
        let mut levels = self.levels(scene, view)?;
        let decided_by = self.decided_by.as_ref().unwrap_or(view);
        let found = self.tessellations(scene, decided_by, &mut levels, budget)?;
        Ok((levels, found))
    }

    /// The flatness of every object, by levels of its quads, if each has any faces, is cut adaptively and is a smooth Catmull-Clark surface as it is: what
    /// other backends decide on their own.
    #[cfg(feature = "gpu")]
    pub(crate) fn flatness(&self, scene: &Scene) -> Option<Vec<Flatness>> {
        if self.drawing != Drawing::Limit {
            return None;
        }
        let of = |object: &Object| {
            let surface = &object.surface;
            let is_plain = surface.cage().face_count() > 0
                && surface.scheme() == Scheme::CatmullClark
                && surface.patch_kind() == PatchKind::None
                && surface.displacement().is_none();
            match self.refinement.of(surface) {
                Refinement::Adaptive(wanted) if is_plain => Some(Flatness {
                    max_level: (wanted.max_level).saturating_sub(u32::from(surface.is_split())),
                    ..wanted
                }),
                _ => None,
            }
        };
        scene.objects.iter().map(of).collect()
    }

    /// Whether all triangles are within a few degrees of their normals.
    pub(crate) fn is_flat(&self, scene: &Scene) -> bool {
        let is_flat = |surface: &Surface| {
            let is_limit =
                surface.patch_kind() == PatchKind::None && surface.displacement().is_none();
            is_limit && matches!(self.refinement.of(surface), Refinement::Adaptive(_))
        };
        self.drawing == Drawing::Limit && scene.objects.iter().all(|o| is_flat(&o.surface))
    }

    pub(crate) fn levels(&self, scene: &Scene, view: &View) -> Result<Vec<u32>, RenderError> {
        if let Refinement::Uniform(level) = self.refinement
            && level > crate::dice::MAX_LEVEL
        {
            return Err(RenderError::Level { level });
        }
        let level = |object: &Object| {
            let surface = &object.surface;
            match (self.drawing, self.refinement.of(surface)) {
                (_, Refinement::Uniform(level)) => level,
                // Polygons have none, and those of blocks are found with them.
                (Drawing::Cage, _) | (Drawing::Limit, Refinement::DepthTags(_)) => 0,
                (Drawing::Limit, Refinement::Adaptive(_)) if !surface.has_tables() => 0,
                (_, Refinement::DepthTags(wanted)) => {
                    depth_tags::deepest(surface, &object.tags(view, &wanted))
                }
                (
                    _,
                    Refinement::Adaptive(Flatness { max_level, .. })
                    | Refinement::Default { max_level }
                    | Refinement::ByEdgeLength { max_level },
                ) => level::by_edge_length(surface, view, max_level.min(crate::dice::MAX_LEVEL)),
            }
        };
        Ok(scene.objects.iter().map(level).collect())
    }

    /// Adaptive tessellations of the objects that have them, and their deepest levels.
    pub(super) fn tessellations(
        &self,
        scene: &Scene,
        view: &View,
        levels: &mut [u32],
        budget: &mut Budget<'_>,
    ) -> Result<Vec<Option<Tessellation>>, LimitError> {
        let mut out = Vec::new();
        for (object, level) in scene.objects.iter().zip(levels) {
            let surface = &object.surface;
            if self.drawing != Drawing::Limit {
                out.push(None);
                continue;
            }
            let is_drawn = |quad: u32, hull: &mut Vec<[f32; 3]>| {
                scene.is_drawn(object, surface.cage_face(quad))
                    && bounds(hull, &view.projection, self.size).is_some()
            };
            let split = u32::from(surface.is_split());
            let limits = &self.limits;
            let found = match self.refinement.of(surface) {
                Refinement::Adaptive(flatness) => {
                    // Interpolating surfaces are refined as a whole for deep levels: no deeper than edges within a
                    // pixel, at which no corner shows.
                    let most = match surface.has_tables() {
                        true => flatness.max_level.min(*level + 3),
                        false => flatness.max_level,
                    };
                    let wanted = Flatness {
                        max_level: most.saturating_sub(split),
                        ..flatness
                    };
                    let (simd, seen) = (self.simd, (view, &wanted));
                    flatness::tessellate(surface, seen, simd, limits, budget, is_drawn)?
                }
                Refinement::DepthTags(wanted) => {
                    let tags = object.tags(view, &wanted);
                    let pattern = wanted.pattern.map(|p| (p, &self.patterns));
                    depth_tags::tessellate(surface, &tags, pattern, limits, budget, is_drawn)?
                }
                Refinement::Uniform(_)
                | Refinement::ByEdgeLength { .. }
                | Refinement::Default { .. } => {
                    out.push(None);
                    continue;
                }
            };
            let deepest = found.leaves.iter().map(|l| u32::from(l.level)).max();
            *level = deepest.unwrap_or(0) + split;
            out.push(Some(found));
        }
        Ok(out)
    }
}
