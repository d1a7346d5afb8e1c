//! Where a place of the cage is among the patches: in which face that is prepared, and below features in which face of a deeper control
//! level.

use super::patches::Patches;
use crate::control::{ControlTree, Kind, TreeChannel, levels_beyond};
use crate::dice::MAX_LEVEL;
use crate::dice::evaluate::Jet;
use crate::surface::Surface;

/// Bytes of control levels that are made for all faces at once, and looked up from then on. It is a tenth of a second that the first
/// evaluation takes; what is deeper is made for the face of a place alone, in about a millisecond.
const WHOLE_BYTES: u128 = 16 << 20;

/// A place in a mesh of quads or triangles.
#[derive(Clone, Copy, Debug)]
pub struct Local {
    pub(crate) face: u32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    /// Control level that the face belongs to.
    pub(super) depth: u32,
    /// The quad is seen from this corner of the face, at this scale.
    turned: usize,
    scale: f32,
}

/// Control data of a surface, of points or texture coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a, P: Patches> {
    pub(super) root: P::Channel<'a>,
    pub(super) below: Option<TreeChannel<'a>>,
    is_points: bool,
    /// Depth of the root among the control levels of the surface: not 0 where a tree goes on below a single face.
    depth: u32,
    /// The corner of the surface's face that the place is.
    tip: Option<Tip>,
}

impl<'a, P: Patches> Source<'a, P> {
    pub(super) fn new(surface: &'a Surface, kind: Kind) -> Option<Self> {
        surface.ensure_evaluation(WHOLE_BYTES);
        Some(Self {
            root: P::channel(surface, kind)?,
            below: surface.below(kind, MAX_LEVEL, None),
            is_points: kind == Kind::Points,
            depth: 0,
            tip: None,
        })
    }

    /// Whether a face has deeper control levels.
    pub(super) fn is_refined(&self, face: u32) -> bool {
        (self.below.as_ref()).is_some_and(|below| P::is_refined(below, face))
    }

    /// Calls `then` with the patch at a place of the faces.
    #[inline(always)]
    pub(super) fn patch<R>(
        &self,
        at: Local,
        then: impl FnOnce(P::Channel<'_>, Local, Option<Tip>) -> R,
    ) -> R {
        let Some(below) = &self.below else {
            return then(self.root, at, None);
        };
        // A tree that begins where all levels end begins anew.
        let whole = self.depth == 0 || self.depth == MAX_LEVEL;
        match P::leaf(below, at.face, [at.u, at.v], whole) {
            None => then(self.root, at, None),
            Some(leaf) => {
                let mut local = Local {
                    face: leaf.quad,
                    u: leaf.at[0],
                    v: leaf.at[1],
                    depth: if at.depth == PASSING {
                        PASSING
                    } else {
                        leaf.depth
                    },
                    turned: at.turned,
                    scale: at.scale * leaf.scale,
                };
                let tip = match leaf.tip {
                    Some(c) => {
                        let (position, normal) = P::corner(self.root, at.face, c);
                        Some(Tip { position, normal })
                    }
                    None => self.tip,
                };
                let depth = (self.depth + leaf.depth).min(MAX_LEVEL);
                let ends = depth == MAX_LEVEL && (tip.is_some() || leaf.value.is_some());
                if leaf.open && !ends {
                    let levels = levels_beyond(depth);
                    if let Some((tree, own)) = below.continued(leaf.depth, leaf.quad, levels) {
                        (local.face, local.depth) = (own, PASSING);
                        let further = Further {
                            tree: &tree,
                            depth,
                            levels,
                            tip,
                        };
                        return self.further(further, local, then);
                    }
                }
                let tip = match (self.is_points, leaf.value) {
                    (true, _) => tip,
                    (false, Some(position)) => Some(Tip {
                        position,
                        normal: [0.0; 3],
                    }),
                    (false, None) => None,
                };
                then(leaf.channel, local, tip)
            }
        }
    }
}

/// A tree that goes on where another ends.
struct Further<'a> {
    tree: &'a ControlTree,
    depth: u32,
    levels: u32,
    tip: Option<Tip>,
}

/// Depth of places in faces that are made for one evaluation, and are not kept.
pub(super) const PASSING: u32 = u32::MAX;

impl<P: Patches> Source<'_, P> {
    /// The same in a tree that goes on where another ends.
    #[cold]
    #[inline(never)]
    fn further<R>(
        &self,
        further: Further<'_>,
        at: Local,
        then: impl FnOnce(P::Channel<'_>, Local, Option<Tip>) -> R,
    ) -> R {
        let kind = if self.is_points {
            Kind::Points
        } else {
            Kind::Uvs
        };
        let below = further.tree.channel(kind, further.levels, None);
        match P::root(&below) {
            Some(root) => {
                let source = Source::<P> {
                    root,
                    below: Some(below),
                    is_points: self.is_points,
                    depth: further.depth,
                    tip: further.tip.filter(|_| further.depth < MAX_LEVEL),
                };
                source.patch(at, then)
            }
            None => then(self.root, at, None),
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
    /// A place in a prepared face that is a face of the cage.
    pub(crate) fn whole(face: u32, u: f32, v: f32) -> Self {
        Self {
            face,
            u,
            v,
            depth: 0,
            turned: 0,
            scale: 1.0,
        }
    }

    /// What was found in the prepared face, by the parameters of the cage's face.
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
        face: first + corner as u32,
        u: 2.0 * s,
        v: 2.0 * t,
        depth: 0,
        turned: corner,
        scale: 2.0,
    }
}

impl Surface {
    #[inline(always)]
    pub(super) fn locate_quad(&self, face: u32, u: f32, v: f32) -> Option<Local> {
        // What is not a number is in no range.
        if face as usize >= self.topology().face_count() || !is_unit(v) {
            return None;
        }
        if self.is_split() {
            return self.locate_child(face, u, v);
        }
        is_unit(u).then_some(Local::whole(face, u, v))
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
        Some(Local::whole(halves.start + k, u, v))
    }
}
