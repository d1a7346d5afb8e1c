//! Triangles that are no patches: dicing through the control levels below them, twin of [`control`](crate::dice::control) for quads.
//!
//! A triangle at a feature is a tree of deeper triangles. What is sampled along its sides must not depend on the tree: an edge of any
//! level is a curve by its own rule as soon as neither end is a feature, and is halved where one is. Both faces at the edge halve it alike,
//! for the tree of an edge is decided by its ends alone. Points where halves meet, and the corners, come from the fans of the level on
//! which they first appear.

use super::super::basis::Target;
use super::super::control::View;
use super::super::face::Sides;
use super::fans::TriangleFans;
use super::patch::{Dot, SidePlace, TriangleChannel, TrianglePatch};
use super::place::Place;

/// One control level of a channel.
pub(crate) type TriangleView<'a> = View<'a, TriangleFans>;

/// Control levels by depth; 0 is the channel that is diced.
pub(crate) trait DescendTriangles: std::fmt::Debug + Sync {
    /// The level at `depth`, if there is one.
    fn at(&self, depth: u32) -> Option<TriangleView<'_>>;
}

impl<'a> TriangleView<'a> {
    pub(crate) fn channel(&self) -> TriangleChannel<'a> {
        TriangleChannel {
            topology: self.topology,
            points: self.points,
            fans: self.fans,
        }
    }

    /// Whether either end of side `c` is a feature.
    fn is_feature_side(&self, face: u32, c: u32) -> bool {
        let feature = |c: u32| self.features[self.whole.vertex(3 * face + c % 3) as usize];
        feature(c) || feature(c + 1)
    }

    /// Limit point and normal of corner `h`.
    fn corner(&self, h: u32) -> ([f32; 3], [f32; 3]) {
        let fan = self.topology.fan(h) as usize;
        let tip = self.tip(h);
        let normal = self.fans.normals.get(fan).copied();
        (
            tip.unwrap_or(self.fans.limits[fan]),
            normal.unwrap_or_default(),
        )
    }
}

impl TrianglePatch {
    /// Prepares triangle `face` of the first level at `level`.
    pub(crate) fn prepare_below(
        &mut self,
        below: &dyn DescendTriangles,
        face: u32,
        target: Target,
        level: u32,
        sides: Sides,
    ) {
        self.begin(target, level, sides);
        let Some(root) = below.at(0) else { return };
        self.is_plain = root.first_child(face).is_none();
        let whole = |c: usize| (sides > Sides::None).then(|| SidePlace::whole(c));
        let place = Place::root(1 << level);
        self.descend(below, 0, face, level, place, [0, 1, 2].map(whole));
        // Values of features may differ between the sides of a seam: each face takes its own from where it has diced to.
        if sides <= Sides::None && level > 0 && root.first_child(face).is_some() {
            return;
        }
        let mut at = place;
        for c in 0..3 {
            let (point, normal) = root.corner(3 * face + c as u32);
            self.dots.push(Dot {
                place: at.origin,
                point,
                normal,
            });
            at = at.turned();
            if sides > Sides::None && level > 0 {
                self.sides[c].set(0, point, normal);
                self.sides[(c + 2) % 3].set(1 << level, point, normal);
            }
        }
    }

    fn descend(
        &mut self,
        below: &dyn DescendTriangles,
        depth: u32,
        face: u32,
        level: u32,
        place: Place,
        mut sides: [Option<SidePlace>; 3],
    ) {
        let Some(view) = below.at(depth) else { return };
        let deeper = view.first_child(face).filter(|_| level > 0);
        let Some(first) = deeper else {
            let dots = self.dots.len();
            self.append(view.channel(), face, level, place, sides);
            for (c, dot) in self.dots[dots..].iter_mut().enumerate().take(3) {
                (dot.point, dot.normal) = view.corner(3 * face + c as u32);
            }
            return;
        };
        let own: [Option<SidePlace>; 3] =
            [0, 1, 2].map(|c: usize| sides[c].filter(|_| !view.is_feature_side(face, c as u32)));
        if own.iter().any(Option::is_some) {
            let (pieces, dots, hull) = (self.pieces.len(), self.dots.len(), self.hull.len());
            self.append(view.channel(), face, level, place, own);
            self.pieces.truncate(pieces);
            self.dots.truncate(dots);
            self.hull.truncate(hull);
        }
        for c in 0..3 {
            if own[c].is_some() {
                sides[c] = None;
            }
        }
        let half = 1_i64 << (level - 1);
        for c in 0..4 {
            let mut of_child = [None; 3];
            if c < 3 {
                let before = (c + 2) % 3;
                of_child[c] = sides[c];
                of_child[before] = sides[before].map(|s| SidePlace {
                    at: s.at + half * s.step,
                    ..s
                });
            }
            let child = first + c as u32;
            self.descend(below, depth + 1, child, level - 1, place.child(c), of_child);
        }
        let Some(next) = below.at(depth + 1) else {
            return;
        };
        for (c, side) in sides.iter().enumerate() {
            if let Some(side) = side {
                let middle = 3 * (first + c as u32) + (c as u32 + 1) % 3;
                let (point, normal) = next.corner(middle);
                self.sides[side.side].set((side.at + half * side.step) as usize, point, normal);
            }
        }
    }
}
