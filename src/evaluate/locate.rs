//! Where a place of the cage is among the patches: in which quad, and below features in which quad of a deeper control level.

use crate::control::{Kind, TreeChannel};
use crate::dice::MAX_LEVEL;
use crate::dice::control::Descend;
use crate::dice::evaluate::{Jet, leaf};
use crate::dice::face::Channel;
use crate::dice::fan_points::FanPoints;
use crate::surface::Surface;
use std::sync::LazyLock;

/// A place in a mesh of quads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Local {
    pub(crate) quad: u32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    /// Control level that the quad belongs to.
    pub(super) depth: u32,
    /// The quad is seen from this corner of the face, at this scale.
    turned: usize,
    scale: f32,
}

/// Control data of a surface, of points or texture coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) root: Channel<'a>,
    pub(super) below: Option<TreeChannel<'a>>,
}

impl<'a> Source<'a> {
    pub(super) fn new(surface: &'a Surface, kind: Kind) -> Option<Self> {
        surface.ensure(MAX_LEVEL);
        Some(Self {
            root: surface.channel(kind, None)?,
            below: surface.below(kind, MAX_LEVEL, None),
        })
    }

    /// Stands in on interpolating surfaces, which have no patches.
    pub(super) fn bare(surface: &'a Surface) -> Self {
        static NO_FANS: LazyLock<FanPoints> = LazyLock::new(FanPoints::default);
        Self {
            root: Channel {
                topology: surface.quads(),
                points: surface.control_points(),
                fans: &NO_FANS,
                below: None,
                linear: false,
            },
            below: None,
        }
    }

    /// Calls `then` with the patch at a place of the quads.
    #[inline(always)]
    pub(super) fn patch<R>(
        &self,
        at: Local,
        then: impl FnOnce(Channel<'_>, Local, Option<Tip>) -> R,
    ) -> R {
        let Some(below) = &self.below else {
            return then(self.root, at, None);
        };
        match leaf(below as &dyn Descend, at.quad, at.u, at.v) {
            None => then(self.root, at, None),
            Some(leaf) => {
                let local = Local {
                    quad: leaf.quad,
                    u: leaf.at[0],
                    v: leaf.at[1],
                    depth: leaf.depth,
                    turned: at.turned,
                    scale: at.scale * (1_u32 << leaf.depth) as f32,
                };
                let tip = leaf.tip.map(|c| {
                    let fan = self.root.topology.fan(4 * at.quad + c as u32) as usize;
                    let fans = self.root.fans;
                    Tip {
                        position: fans.limits[fan],
                        normal: fans.normals.get(fan).copied().unwrap_or_default(),
                    }
                });
                then(leaf.channel, local, tip)
            }
        }
    }
}

/// What is known of a corner where creases end or fade.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tip {
    pub(crate) position: [f32; 3],
    pub(crate) normal: [f32; 3],
}

impl Local {
    /// A place in a quad that is its own face.
    pub(crate) fn quad(quad: u32, u: f32, v: f32) -> Self {
        Self {
            quad,
            u,
            v,
            depth: 0,
            turned: 0,
            scale: 1.0,
        }
    }

    /// What was found in the quad, by the parameters of the face.
    #[inline(always)]
    pub(crate) fn outer<const ORDER: u32>(&self, jet: Jet) -> Jet {
        if self.scale == 1.0 {
            return jet;
        }
        jet.scaled::<ORDER>(self.scale).turned::<ORDER>(self.turned)
    }
}

#[inline(always)]
pub(super) fn is_unit(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

/// The child of `corner` of a quad that is split once.
pub(super) fn child(first: u32, u: f32, v: f32) -> Local {
    let (corner, [s, t]) = match (u >= 0.5, v >= 0.5) {
        (false, false) => (0, [u, v]),
        (true, false) => (1, [v, 1.0 - u]),
        (true, true) => (2, [1.0 - u, 1.0 - v]),
        (false, true) => (3, [1.0 - v, u]),
    };
    Local {
        quad: first + corner as u32,
        u: 2.0 * s,
        v: 2.0 * t,
        depth: 0,
        turned: corner,
        scale: 2.0,
    }
}

impl Surface {
    #[inline(always)]
    pub(super) fn locate(&self, face: u32, u: f32, v: f32) -> Option<Local> {
        // What is not a number is in no range.
        if face as usize >= self.topology().face_count() || !is_unit(v) {
            return None;
        }
        if self.is_split() {
            return self.locate_child(face, u, v);
        }
        is_unit(u).then_some(Local::quad(face, u, v))
    }

    fn locate_child(&self, face: u32, u: f32, v: f32) -> Option<Local> {
        let halves = self.topology().face_halves(face);
        let n = halves.len() as u32;
        if n == 4 {
            return is_unit(u).then(|| child(halves.start, u, v));
        }
        let k = (0.0..=n as f32)
            .contains(&u)
            .then(|| (u as u32).min(n - 1))?;
        let u = (u - k as f32).min(1.0);
        Some(Local::quad(halves.start + k, u, v))
    }
}
