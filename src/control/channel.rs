//! One channel of all levels, as dicing and evaluation go down in it.

use super::ControlTree;
use super::fans::Fans;
use super::level::{ControlLevel, Kind};
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

    /// A level, by its fans of one kind: none where they are of the other.
    fn view<F>(
        &self,
        depth: u32,
        of_kind: impl Fn(&'a Fans) -> Option<&'a F>,
    ) -> Option<View<'a, F>> {
        let level = self.tree.level(depth)?;
        let mesh = level.channel(self.kind)?;
        let fans = (self.refined).map_or(&mesh.fans, |r| &r[depth as usize]);
        Some(View {
            topology: &mesh.topology,
            points: &mesh.points,
            fans: of_kind(fans)?,
            children: &level.children,
            features: &level.rules.features,
            whole: &level.level.topology,
            tips: self.tips(level, depth),
        })
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
        self.view(depth, |fans| match fans {
            Fans::Quads(_, fans) => Some(fans),
            Fans::Triangles(..) => None,
        })
    }
}

impl DescendTriangles for TreeChannel<'_> {
    fn at(&self, depth: u32) -> Option<TriangleView<'_>> {
        self.view(depth, |fans| match fans {
            Fans::Triangles(_, fans) => Some(fans),
            Fans::Quads(..) => None,
        })
    }
}
