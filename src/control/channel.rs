//! One channel of all levels, as dicing and evaluation go down in it.

use super::ControlTree;
use super::fans::Fans;
use super::level::{ChannelMesh, ControlLevel, Kind};
use crate::dice::control::{Descend, View};
use crate::dice::triangle::{DescendTriangles, TriangleView};
use std::sync::Arc;

/// One channel of a tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeChannel<'a> {
    pub(super) tree: &'a ControlTree,
    pub(super) kind: Kind,
    pub(super) level: u32,
    pub(super) refined: Option<&'a [Fans]>,
}

impl<'a> TreeChannel<'a> {
    /// The tree that goes on below a face where this one ends; see [`ControlTree::continued`].
    pub(crate) fn continued(
        &self,
        depth: u32,
        face: u32,
        levels: u32,
    ) -> Option<(Arc<ControlTree>, u32)> {
        self.tree.continued(depth, face, levels)
    }

    /// What both kinds of views hold.
    fn parts(&self, depth: u32) -> Option<(&'a ControlLevel, &'a ChannelMesh, &'a Fans)> {
        let level = self.tree.level(depth)?;
        let mesh = level.channel(self.kind)?;
        let fans = (self.refined).map_or(&mesh.fans, |r| &r[depth as usize]);
        Some((level, mesh, fans))
    }

    fn tips(&self, level: &'a ControlLevel, depth: u32) -> Option<&'a [(u32, [f32; 3])]> {
        let tips = (depth == self.level).then(|| level.tips.get()).flatten()?;
        let own = match self.kind {
            Kind::Points => return None,
            Kind::Uvs => &tips.uvs,
            Kind::Colors => &tips.colors,
        };
        (!own.is_empty()).then_some(own.as_slice())
    }
}

impl Descend for TreeChannel<'_> {
    fn at(&self, depth: u32) -> Option<View<'_>> {
        let (level, mesh, fans) = self.parts(depth)?;
        let Fans::Quads(_, fans) = fans else {
            return None;
        };
        Some(View {
            topology: &mesh.topology,
            points: &mesh.points,
            fans,
            children: &level.children,
            features: &level.rules.features,
            whole: &level.level.topology,
            tips: self.tips(level, depth),
        })
    }
}

impl DescendTriangles for TreeChannel<'_> {
    fn at(&self, depth: u32) -> Option<TriangleView<'_>> {
        let (level, mesh, fans) = self.parts(depth)?;
        let Fans::Triangles(_, fans) = fans else {
            return None;
        };
        Some(TriangleView {
            topology: &mesh.topology,
            points: &mesh.points,
            fans,
            children: &level.children,
            features: &level.rules.features,
            whole: &level.level.topology,
            tips: self.tips(level, depth),
        })
    }
}
