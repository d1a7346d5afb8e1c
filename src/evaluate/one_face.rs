//! A face of either kind, kept for many places.

use super::locate::{Local, PASSING, Source};
use super::patches::Patches;
use super::sample::sealed::{Asked, Kind as _};
use super::{EvaluateError, Evaluated};
use crate::control::Kind;
use crate::surface::Surface;
use std::collections::BTreeMap;

/// One face of the cage, with its control points and those of its pieces that were needed.
#[derive(Clone, Debug)]
#[repr(C)]
pub(super) struct OneFace<'a, P: Patches> {
    /// Whether the first prepared face is the face, a patch, and prepared.
    whole: bool,
    ready: bool,
    first: u32,
    patches: P,
    pub(super) face: u32,
    surface: &'a Surface,
    source: Source<'a, P>,
    /// Further quads of a face that is split, and patches of deeper control levels, by depth and number.
    others: Others<P>,
    uv: Option<Box<Uvs<'a, P>>>,
}

type Others<P> = BTreeMap<(u32, u32), Box<P>>;

/// Texture coordinates of a face.
#[derive(Clone, Debug)]
struct Uvs<'a, P: Patches> {
    source: Source<'a, P>,
    patches: P,
    ready: Option<(u32, u32)>,
}

impl<'a, P: Patches> OneFace<'a, P> {
    /// Face `face` of the cage; `first` is the first face prepared for it.
    pub(super) fn new(surface: &'a Surface, face: u32, first: u32) -> Option<Self> {
        Some(Self {
            whole: false,
            ready: false,
            first,
            patches: P::default(),
            face,
            surface,
            source: Source::<P>::new(surface, Kind::Points)?,
            others: BTreeMap::new(),
            uv: None,
        })
    }

    #[inline(always)]
    pub(super) fn at_as<S: Evaluated>(&mut self, u: f32, v: f32) -> Option<S> {
        if self.whole && P::holds(u, v) {
            return Some(S::evaluate(Asked {
                patches: &mut self.patches,
                channel: self.source.root,
                at: Local::whole(self.first, u, v),
                tip: None,
            }));
        }
        self.elsewhere(u, v)
    }

    #[inline(never)]
    fn elsewhere<S: Evaluated>(&mut self, u: f32, v: f32) -> Option<S> {
        let local = P::locate(self.surface, self.face, u, v)?;
        Some(self.local(local))
    }

    fn local<S: Evaluated>(&mut self, local: Local) -> S {
        if !self.ready {
            self.patches.prepare(self.source.root, self.first);
            self.ready = true;
            self.whole = !self.source.is_refined(self.first) && !self.surface.is_split();
        }
        let (first, own, others) = (self.first, &mut self.patches, &mut self.others);
        self.source.patch(local, |channel, at, tip| {
            let mut passing;
            let patches = if at.depth == 0 && at.face == first {
                own
            } else if at.depth == PASSING {
                passing = P::default();
                passing.prepare(channel, at.face);
                &mut passing
            } else {
                other(others, channel, (at.depth, at.face))
            };
            S::evaluate(Asked {
                patches,
                channel,
                at,
                tip,
            })
        })
    }

    pub(super) fn grid_len(&self, n: u32) -> usize {
        P::grid_len(n).saturating_mul(P::grids(self.surface, self.face).0)
    }

    pub(super) fn grid<S: Evaluated>(
        &mut self,
        n: u32,
        out: &mut [S],
    ) -> Result<(), EvaluateError> {
        let wanted = self.grid_len(n);
        if out.len() != wanted || n == 0 {
            return Err(EvaluateError::WrongCount {
                got: out.len(),
                wanted,
            });
        }
        let (_, split) = P::grids(self.surface, self.face);
        for (k, out) in (0..).zip(out.chunks_exact_mut(P::grid_len(n))) {
            let face = self.first + k;
            if split || self.source.is_refined(face) {
                for (out, [u, v]) in out.iter_mut().zip(P::grid_places(n)) {
                    *out = self.local(if split {
                        P::in_children(self.first, u, v)
                    } else {
                        Local::whole(face, u, v)
                    });
                }
                continue;
            }
            // A grid visits every piece but once: they are made in memory that grids of other faces use too.
            let channel = self.source.root;
            P::with_own(|patches| {
                patches.prepare(channel, face);
                let asked = Asked {
                    patches,
                    channel,
                    at: Local::whole(face, 0.0, 0.0),
                    tip: None,
                };
                S::grid(asked, n, out);
            });
        }
        Ok(())
    }

    pub(super) fn uv(&mut self, u: f32, v: f32) -> Option<[f32; 2]> {
        let local = P::locate(self.surface, self.face, u, v)?;
        let uvs = match &mut self.uv {
            Some(uvs) => uvs,
            none => none.insert(Box::new(Uvs {
                source: Source::new(self.surface, Kind::Uvs)?,
                patches: P::default(),
                ready: None,
            })),
        };
        if self.surface.has_linear_uvs() {
            return Some(P::linear(uvs.source.root, local));
        }
        let (patches, ready) = (&mut uvs.patches, &mut uvs.ready);
        let position = uvs.source.patch(local, |channel, at, tip| {
            let key = Some((at.depth, at.face));
            if *ready != key || at.depth == PASSING {
                patches.prepare(channel, at.face);
                *ready = key;
            }
            <[f32; 3]>::evaluate(Asked {
                patches,
                channel,
                at,
                tip,
            })
        });
        Some([position[0], position[1]])
    }
}

#[inline(never)]
fn other<'q, P: Patches>(
    others: &'q mut Others<P>,
    channel: P::Channel<'_>,
    key: (u32, u32),
) -> &'q mut P {
    others.entry(key).or_insert_with(|| {
        let mut patches = Box::<P>::default();
        patches.prepare(channel, key.1);
        patches
    })
}
