//! Many places at once: sorted by face where that pays, so that what places on a face have in common is made once.

use super::locate::{PASSING, Source};
use super::patches::Patches;
use super::sample::sealed::Asked;
use super::{Evaluated, Place};
use crate::surface::Surface;

/// Places that one thread evaluates at a time.
pub(super) const CHUNK: usize = 1 << 16;

/// Memory of [`Surface::evaluate_many`].
#[derive(Default)]
pub(super) struct Batch<P> {
    patches: P,
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl<P: Patches> Batch<P> {
    pub(super) fn evaluate<S: Evaluated>(
        &mut self,
        surface: &Surface,
        source: &Source<'_, P>,
        places: &[Place],
        out: &mut [S],
    ) {
        let faces = P::faces(source.root);
        let changes = places.windows(2).filter(|p| p[0].face != p[1].face).count();
        // Sorting pays where a face comes more than once, and where its counters are no more than the places.
        if 4 * changes < places.len() || faces > places.len() {
            self.in_order(surface, source, places, out, 0..places.len() as u32);
            return;
        }
        self.starts.clear();
        self.starts.resize(faces + 1, 0);
        let face = |p: &Place| P::locate(surface, p.face, p.u, p.v).map_or(0, |l| l.face) as usize;
        for p in places {
            self.starts[face(p) + 1] += 1;
        }
        for q in 0..faces {
            self.starts[q + 1] += self.starts[q];
        }
        self.order.resize(places.len(), 0);
        for (i, p) in (0..).zip(places) {
            let at = &mut self.starts[face(p)];
            self.order[*at as usize] = i;
            *at += 1;
        }
        let order = std::mem::take(&mut self.order);
        self.in_order(surface, source, places, out, order.iter().copied());
        self.order = order;
    }

    fn in_order<S: Evaluated>(
        &mut self,
        surface: &Surface,
        source: &Source<'_, P>,
        places: &[Place],
        out: &mut [S],
        order: impl Iterator<Item = u32>,
    ) {
        let (patches, mut ready) = (&mut self.patches, None);
        for i in order {
            let p = places[i as usize];
            let Some(local) = P::locate(surface, p.face, p.u, p.v) else {
                continue;
            };
            out[i as usize] = source.patch(local, |channel, at, tip| {
                let key = Some((at.depth, at.face));
                if ready != key || at.depth == PASSING {
                    patches.prepare(channel, at.face);
                    ready = key;
                }
                S::evaluate(Asked {
                    patches,
                    channel,
                    at,
                    tip,
                })
            });
        }
    }
}
