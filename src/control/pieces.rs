//! Down the control levels below a face, for who evaluates at single places.

use super::TreeChannel;
use crate::dice::MAX_LEVEL;
use crate::dice::control::Descend;
use crate::dice::evaluate::{self, Leaf, Place, QuadEvaluator};
use crate::dice::face::Channel;
use crate::dice::tangent_masks::flat_tangents;
use crate::dice::triangle::{DescendTriangles, TriangleChannel, TriangleEvaluator, leaf};

/// The evaluator of one kind of faces, and how it finds the patch at a place.
#[allow(private_interfaces, reason = "nobody outside can name it")]
pub trait Pieces {
    /// Control data that faces are prepared from.
    type Channel<'a>: Copy + std::fmt::Debug;

    /// Control data of the first level of a tree.
    fn root<'a>(below: &'a TreeChannel<'_>) -> Option<Self::Channel<'a>>;
    /// Whether a face has deeper control levels.
    fn is_refined(below: &TreeChannel<'_>, face: u32) -> bool;
    /// The patch at a place of a face; `None` where the face itself is the patch. `whole` where the face is one of the surface, and not a part
    /// of one that a tree begins with.
    fn leaf<'a>(
        below: &'a TreeChannel<'_>,
        face: u32,
        at: [f32; 2],
        whole: bool,
    ) -> Option<Leaf<Self::Channel<'a>>>;

    fn prepare(&mut self, channel: Self::Channel<'_>, face: u32);
    fn at<const ORDER: u32>(&mut self, channel: Self::Channel<'_>, u: f32, v: f32) -> Place;

    /// Tangents at corner `c` of a face where both derivatives have one direction; nothing at others. Parameters run `scale` times as fast.
    fn flat_tangents(
        channel: Self::Channel<'_>,
        face: u32,
        c: usize,
        scale: f32,
    ) -> Option<[[f32; 3]; 2]>;
}

/// How many levels a tree has that goes on below a face at a feature at `depth`, where another ends. Beyond the last level darts alone go on,
/// to which every step comes half as near.
pub(crate) fn levels_beyond(depth: u32) -> u32 {
    match MAX_LEVEL.saturating_sub(depth) {
        0 => MAX_LEVEL,
        left => left,
    }
}

impl Pieces for QuadEvaluator {
    type Channel<'a> = Channel<'a>;

    fn root<'a>(below: &'a TreeChannel<'_>) -> Option<Channel<'a>> {
        Descend::at(below, 0).map(|view| Channel {
            topology: view.topology,
            points: view.points,
            fans: view.fans,
            below: None,
            linear: false,
        })
    }
    fn is_refined(below: &TreeChannel<'_>, face: u32) -> bool {
        Descend::at(below, 0).is_some_and(|root| root.first_child(face).is_some())
    }
    #[inline(always)]
    fn leaf<'a>(
        below: &'a TreeChannel<'_>,
        face: u32,
        [u, v]: [f32; 2],
        whole: bool,
    ) -> Option<Leaf<Channel<'a>>> {
        evaluate::leaf(below as &dyn Descend, face, u, v, whole)
    }

    #[inline(always)]
    fn prepare(&mut self, channel: Channel<'_>, face: u32) {
        self.prepare(channel, face);
    }
    #[inline(always)]
    fn at<const ORDER: u32>(&mut self, channel: Channel<'_>, u: f32, v: f32) -> Place {
        self.at::<ORDER>(channel, u, v)
    }
    fn flat_tangents(
        channel: Channel<'_>,
        face: u32,
        c: usize,
        scale: f32,
    ) -> Option<[[f32; 3]; 2]> {
        flat_tangents(channel.topology, channel.points, 4 * face + c as u32, scale)
    }
}

impl Pieces for TriangleEvaluator {
    type Channel<'a> = TriangleChannel<'a>;

    fn root<'a>(below: &'a TreeChannel<'_>) -> Option<TriangleChannel<'a>> {
        DescendTriangles::at(below, 0).map(|view| view.channel())
    }
    fn is_refined(below: &TreeChannel<'_>, face: u32) -> bool {
        DescendTriangles::at(below, 0).is_some_and(|root| root.first_child(face).is_some())
    }
    #[inline(always)]
    fn leaf<'a>(
        below: &'a TreeChannel<'_>,
        face: u32,
        [u, v]: [f32; 2],
        whole: bool,
    ) -> Option<Leaf<TriangleChannel<'a>>> {
        leaf(below, face, u, v, whole)
    }

    #[inline(always)]
    fn prepare(&mut self, channel: TriangleChannel<'_>, face: u32) {
        self.prepare(channel, face);
    }
    #[inline(always)]
    fn at<const ORDER: u32>(&mut self, channel: TriangleChannel<'_>, u: f32, v: f32) -> Place {
        self.at::<ORDER>(channel, u, v)
    }
    fn flat_tangents(
        channel: TriangleChannel<'_>,
        face: u32,
        c: usize,
        scale: f32,
    ) -> Option<[[f32; 3]; 2]> {
        flat_tangents(channel.topology, channel.points, 3 * face + c as u32, scale)
    }
}
