//! What a surface hands to those that dice and evaluate it: its channels, and what has to be made before.

use super::mesh::QuadMesh;
use super::{PatchCage, RefinedFans, Surface};
use crate::control::tables::Walk;
use crate::control::{Fans, Kind, TreeChannel};
use crate::dice::control::Descend;
use crate::dice::face::Channel;
use crate::dice::triangle::TriangleChannel;
use crate::limits::{Budget, LimitError};
use crate::topology::Topology;

impl Surface {
    /// Makes what dicing at `level` of the quads needs. To be called once, before threads dice.
    pub(crate) fn ensure(&self, level: u32) {
        for level in self.levels_of(level) {
            if let Some(control) = &self.control {
                control.ensure(level, self.beyond());
            }
            if let Some(tables) = &self.tables {
                tables.ensure(level);
            }
        }
    }

    /// Control levels beyond those of points: derivatives at points of a grid take one more, but right at features.
    fn beyond(&self) -> u32 {
        u32::from(self.displaced.is_some())
    }

    /// The levels that dicing at one asks for: patches are fitted to points of level 1.
    pub(super) fn levels_of(&self, level: u32) -> impl Iterator<Item = u32> {
        let fitted = matches!(self.patches, Some(PatchCage::Qas)) && level != 1;
        std::iter::once(level).chain(fitted.then_some(1))
    }

    /// Makes the control levels that evaluation has for all faces at once, in about so many bytes.
    pub(crate) fn ensure_evaluation(&self, bytes: u128) {
        if let Some(control) = &self.control {
            control.ensure_evaluation(bytes);
        }
    }

    /// As [`Surface::ensure`], within a budget.
    ///
    /// # Errors
    /// What is to be made would not fit; nothing is allocated for it then.
    pub(crate) fn try_ensure(&self, level: u32, budget: &mut Budget<'_>) -> Result<(), LimitError> {
        for level in self.levels_of(level) {
            if let Some(control) = &self.control {
                control.try_ensure(level, self.beyond(), budget)?;
            }
            if let Some(tables) = &self.tables {
                tables.try_ensure(level, budget)?;
            }
        }
        Ok(())
    }

    /// Whether the surface has a channel.
    pub(crate) fn has(&self, kind: Kind) -> bool {
        match kind {
            Kind::Points => true,
            Kind::Uvs => self.has_uvs(),
            Kind::Colors => !self.cage.colors.is_empty(),
        }
    }

    /// Texture coordinates at the corners of face `q`, for linear interpolation; a triangle repeats its last.
    pub(super) fn linear_corners(&self, q: u32) -> Option<[[f32; 3]; 4]> {
        let (t, points) = if let Some(tables) = &self.tables {
            let mesh = tables.root(Kind::Uvs)?;
            (&mesh.topology, &mesh.points)
        } else if let Some(control) = &self.control {
            let mesh = control.root(Kind::Uvs)?;
            (&mesh.topology, &mesh.points)
        } else {
            let uv = self.uv.as_ref()?;
            (uv.quads(), &uv.points)
        };
        let halves = t.face_halves(q);
        let corner = |c: u32| points[t.vertex((halves.start + c).min(halves.end - 1)) as usize];
        Some([corner(0), corner(1), corner(2), corner(3)])
    }

    /// Topology of the texture coordinates of the quads, cut at seams.
    pub(super) fn uv_topology(&self) -> Option<&Topology> {
        if let Some(tables) = &self.tables {
            return tables.root(Kind::Uvs).map(|mesh| &mesh.topology);
        }
        if let Some(control) = &self.control {
            return control.root(Kind::Uvs).map(|mesh| &mesh.topology);
        }
        self.uv.as_ref().map(QuadMesh::quads)
    }

    /// A walk to single points of an interpolating surface, or to texture coordinates.
    pub(crate) fn walk(&self, kind: Kind) -> Option<Walk<'_>> {
        self.tables.as_ref()?.walk(kind)
    }

    /// Whether faces are patches without control levels: nothing has to be made before they are evaluated.
    pub(crate) fn is_plain(&self) -> bool {
        self.control.is_none() && self.tables.is_none()
    }

    /// The control levels below a channel.
    pub(crate) fn below<'a>(
        &'a self,
        kind: Kind,
        level: u32,
        refined: Option<&'a RefinedFans>,
    ) -> Option<TreeChannel<'a>> {
        let control = self.control.as_deref()?;
        Some(control.channel(kind, level, refined.map(|r| r.0.as_slice())))
    }

    /// A channel of the quads, if the surface has it.
    pub(crate) fn channel<'a>(
        &'a self,
        kind: Kind,
        below: Option<&'a TreeChannel<'a>>,
    ) -> Option<Channel<'a>> {
        let below = below.map(|b| b as &dyn Descend);
        // Interpolating surfaces are no patches.
        if self.tables.is_some() {
            return None;
        }
        if let Some(control) = &self.control {
            let mesh = control.root(kind)?;
            let Fans::Quads(_, fans) = &mesh.fans else {
                return None;
            };
            return Some(Channel {
                topology: &mesh.topology,
                points: &mesh.points,
                fans,
                below,
                linear: false,
            });
        }
        let (mesh, points, fans) = match kind {
            Kind::Points => (&self.mesh, &self.mesh.points, &self.mesh.fans),
            Kind::Uvs => {
                let uv = self.uv.as_ref()?;
                (uv, &uv.points, &uv.fans)
            }
            Kind::Colors => {
                let colors = self.colors.as_ref()?;
                (&self.mesh, &colors.points, &colors.fans)
            }
        };
        Some(Channel {
            topology: mesh.quads(),
            points,
            fans,
            below: None,
            linear: self.linear,
        })
    }

    /// A channel of the triangles of Loop's scheme, if the surface has it.
    pub(crate) fn triangle_channel(&self, kind: Kind) -> Option<TriangleChannel<'_>> {
        let mesh = self.control.as_ref()?.root(kind)?;
        let Fans::Triangles(_, fans) = &mesh.fans else {
            return None;
        };
        Some(TriangleChannel {
            topology: &mesh.topology,
            points: &mesh.points,
            fans,
        })
    }
}
