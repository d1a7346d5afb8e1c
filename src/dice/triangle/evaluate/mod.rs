//! The limit surface of one triangle at any parameter: position, derivatives, and what they are at the corners.
//!
//! Twin of the code for quads in [`evaluate`](crate::dice::evaluate), with the pieces of [`patch`](super::patch): a regular triangle is
//! one quartic; any other is split in four, of which the middle one is regular, and towards an irregular corner again and again, as often
//! as the parameter is close to it. Parameters are the weights u and v of corners 1 and 2. All refinement is in `f64`, near a corner
//! relative to the corner's limit; pieces are `f32`, relative to a point of their own.

mod leaf;
mod line;
mod quartic;
mod ring;

use super::lattice::Lattice;
use super::patch::TriangleChannel;
use super::ring::{Hexagon, is_regular};
use super::tensor::turn;
use crate::dice::evaluate::{F4, Jet, MAX_DEPTH, Place};
use crate::dice::point::{D4, Point};
pub(crate) use leaf::leaf;
pub(crate) use line::JetLines;
use quartic::Patch;
use ring::Ring;

/// One triangle of a mesh, ready to be evaluated; to be prepared again for the next.
///
/// In this order, so that what every parameter needs lies on one line of the cache.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct TriangleEvaluator {
    irregular: bool,
    regular: [bool; 3],
    /// The triangle itself, or its pieces as parameters have asked for them.
    patches: Vec<Patch>,
    /// Places in `patches` by corner, depth and cell; [`MISSING`] if not made.
    slots: [[[u16; 4]; SHALLOW]; 3],
    face: u32,
    /// Kept while the triangle is regular, for its memory.
    parts: Option<Box<Parts>>,
}

/// Depths that are found without a search.
const SHALLOW: usize = 8;

const MISSING: u16 = u16::MAX;

/// The child of a split that is at no corner.
const MIDDLE: u8 = 3;

/// Corner, depth, and child of the split that the step to this depth makes: one of the corners', or the middle one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slot {
    corner: u8,
    depth: u8,
    cell: u8,
}

/// What pieces of an irregular triangle are made of.
#[derive(Clone, Debug)]
struct Parts {
    /// The control points after one step.
    lattice: Lattice<D4>,
    /// Patches deeper than slots go.
    deep: Vec<(Slot, u16)>,
    /// Kept from triangle to triangle for their memory; `made` are of this one.
    chains: [Option<Box<Chain>>; 3],
    made: [bool; 3],
    ring: Ring,
}

/// What is next to an irregular corner.
#[derive(Clone, Debug, Default)]
struct Chain {
    limit: D4,
    ring: Ring,
    /// Control points around the corner, as seen from it, at depths 1, 2, …; relative to `limit`.
    nodes: Vec<Lattice<D4>>,
}

/// A parameter of an irregular triangle: which patch holds it, and where.
#[derive(Clone, Copy)]
struct Spot {
    slot: Slot,
    at: [f32; 2],
    scale: f32,
}

impl Spot {
    /// Depth is 1 in the middle and at a regular corner. At an irregular one it is 2 from a distance of 1/4 on, and one more for every
    /// halving of it. Along a line of constant v, `at[1]` is constant within a slot.
    #[inline(always)]
    fn new(regular: &[bool; 3], u: f32, v: f32) -> Self {
        // Seen from the corner: along the side that leaves it, along the one that comes in, and the sum of both. Differences from 1 are
        // exact. A sum that is 1 only after rounding lies on the side.
        let (c, a, b, d) = if u >= 0.5 {
            let v = v.min(1.0 - u);
            (1, v, (1.0 - u) - v, 1.0 - u)
        } else if v >= 0.5 {
            let u = u.min(1.0 - v);
            (2, (1.0 - v) - u, u, 1.0 - v)
        } else if u + v <= 0.5 {
            (0, u, v, u + v)
        } else {
            let slot = Slot {
                corner: 0,
                depth: 1,
                cell: MIDDLE,
            };
            return Self {
                slot,
                at: [1.0 - 2.0 * u, 1.0 - 2.0 * v],
                scale: -2.0,
            };
        };
        // Weights of the piece's corners, as the corner sees them; powers of two are exact.
        let (depth, cell, weights, scale);
        if regular[c] {
            (depth, cell, scale) = (1, c, 2.0);
            weights = [1.0 - 2.0 * d, 2.0 * a, 2.0 * b];
        } else {
            depth = (127 - (d.to_bits() >> 23)).max(2);
            let size = f32::from_bits((127 + depth) << 23);
            let (a, b, d) = (a * size, b * size, d * size);
            if a >= 1.0 {
                (cell, scale) = ((c + 1) % 3, size);
                weights = [2.0 - d, a - 1.0, b];
            } else if b >= 1.0 {
                (cell, scale) = ((c + 2) % 3, size);
                weights = [2.0 - d, a, b - 1.0];
            } else {
                (cell, scale) = (3, -size);
                weights = [d - 1.0, 1.0 - a, 1.0 - b];
            }
        }
        Self {
            slot: Slot {
                corner: c as u8,
                depth: depth as u8,
                cell: cell as u8,
            },
            at: [weights[(4 - c) % 3], weights[(5 - c) % 3]],
            scale,
        }
    }
}

impl Default for TriangleEvaluator {
    fn default() -> Self {
        Self {
            irregular: false,
            regular: [true; 3],
            patches: Vec::new(),
            slots: [[[MISSING; 4]; SHALLOW]; 3],
            face: 0,
            parts: None,
        }
    }
}

impl TriangleEvaluator {
    /// Prepares triangle `face`.
    pub(crate) fn prepare(&mut self, channel: TriangleChannel<'_>, face: u32) {
        let t = channel.topology;
        self.face = face;
        self.patches.clear();
        let regular = |c: u32| is_regular(&t.fans()[t.fan(3 * face + c) as usize]);
        self.regular = [regular(0), regular(1), regular(2)];
        self.irregular = self.regular != [true; 3];
        if self.irregular {
            self.slots = [[[MISSING; 4]; SHALLOW]; 3];
            let parts = self.parts.get_or_insert_with(|| Box::new(Parts::empty()));
            parts.prepare(channel, face, self.regular);
            return;
        }
        let ring = |c: u32| Hexagon::<D4>::gather(t, channel.points, 3 * face + c);
        let (a, b, c) = (ring(0), ring(1), ring(2));
        let net = [
            a.e[4], a.e[5], b.e[3], a.e[3], a.v, a.e[0], b.e[4], a.e[2], a.e[1], b.e[5], c.e[4],
            c.e[3],
        ];
        self.patches.push(Patch::new(D4::ZERO, &net));
    }

    /// The patch at a spot of an irregular triangle; `None` where it is an irregular corner.
    #[inline(always)]
    fn patch(&mut self, channel: TriangleChannel<'_>, slot: Slot) -> Option<&Patch> {
        let depth = slot.depth as usize;
        let mut at = MISSING;
        if depth < SHALLOW {
            at = self.slots[slot.corner as usize][depth][slot.cell as usize];
        }
        if at == MISSING {
            at = self.seek(channel, slot)?;
        }
        self.patches.get(at as usize)
    }

    /// The place of a patch that slots do not tell: made, if it has to be.
    #[inline(never)]
    fn seek(&mut self, channel: TriangleChannel<'_>, slot: Slot) -> Option<u16> {
        let parts = self.parts.as_mut()?;
        let depth = slot.depth as usize;
        if depth > MAX_DEPTH as usize {
            return None;
        }
        if depth >= SHALLOW
            && let Some(&(_, at)) = parts.deep.iter().find(|d| d.0 == slot)
        {
            return Some(at);
        }
        let at = self.patches.len() as u16;
        self.patches.push(parts.patch(channel, self.face, slot));
        if depth < SHALLOW {
            self.slots[slot.corner as usize][depth][slot.cell as usize] = at;
        } else {
            parts.deep.push((slot, at));
        }
        Some(at)
    }

    /// The triangle at (`u`, `v`), which must be on it; `channel` is what the triangle was prepared from.
    #[inline(always)]
    pub(crate) fn at<const ORDER: u32>(
        &mut self,
        channel: TriangleChannel<'_>,
        u: f32,
        v: f32,
    ) -> Place {
        if !self.irregular {
            let [patch, ..] = &self.patches[..] else {
                return Place::Smooth(Jet::at(F4::splat(0.0)));
            };
            return Place::Smooth(patch.jet::<ORDER>(u, v, 1.0));
        }
        let spot = Spot::new(&self.regular, u, v);
        match self.patch(channel, spot.slot) {
            Some(patch) => Place::Smooth(patch.jet::<ORDER>(spot.at[0], spot.at[1], spot.scale)),
            None => corner::<ORDER>(channel, self.face, spot.slot),
        }
    }

    /// Row `j` of the triangle's grid of `n` segments along each side, where v = j/n.
    #[inline(always)]
    pub(crate) fn grid_row<const ORDER: u32>(
        &mut self,
        channel: TriangleChannel<'_>,
        n: u32,
        j: u32,
        row: &mut TriangleRow,
    ) {
        row.jets.clear();
        row.corners.clear();
        let at = |i: u32| i as f32 / n as f32;
        if !self.irregular {
            if let Some(patch) = self.patches.first() {
                let curve = patch.curve::<ORDER>(at(j));
                let jets = (0..=n - j).map(|i| curve.jet::<ORDER>(at(i), 1.0));
                row.jets.extend(jets);
            }
            return;
        }
        // Along a row v is the same all through a patch, but for roundings at its end.
        let mut last = None;
        for i in 0..=n - j {
            let spot = Spot::new(&self.regular, at(i), at(j));
            let Some(patch) = self.patch(channel, spot.slot) else {
                if let Place::Corner(jet, c) = corner::<ORDER>(channel, self.face, spot.slot) {
                    row.corners.push((i as usize, c));
                    row.jets.push(jet);
                }
                continue;
            };
            let key = (spot.slot, spot.at[1]);
            let curve = match &last {
                Some((of, curve)) if *of == key => curve,
                _ => &last.insert((key, patch.curve::<ORDER>(spot.at[1]))).1,
            };
            row.jets.push(curve.jet::<ORDER>(spot.at[0], spot.scale));
        }
    }
}

/// Position and derivatives along a row of a grid.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleRow {
    pub(crate) jets: Vec<Jet>,
    /// Places that are irregular corners, and which.
    pub(crate) corners: Vec<(usize, usize)>,
}

/// From the view of corner `c`, with its parameters along the side that leaves it and the one that comes in, to u and v.
fn turned(c: usize, [a, b]: [D4; 2]) -> [D4; 2] {
    match c {
        0 => [a, b],
        // Towards corner 0 u falls, and towards corner 2 it falls as well while v grows.
        1 => [b * -1.0, a - b],
        _ => [b - a, a * -1.0],
    }
}

#[cold]
fn corner<const ORDER: u32>(channel: TriangleChannel<'_>, face: u32, slot: Slot) -> Place {
    let c = slot.corner as usize;
    let h = 3 * face + slot.corner as u32;
    let mut ring = Ring::default();
    ring.gather(channel, h);
    let mut jet = Jet::at(F4::new(ring.limit().narrow().0));
    if ORDER > 0 {
        let tangents = turned(c, ring.tangents(channel, h));
        [jet.du, jet.dv] = tangents.map(|t| F4::new(t.narrow().0));
    }
    Place::Corner(jet, c)
}

impl Parts {
    fn empty() -> Self {
        Self {
            lattice: Lattice::ZERO,
            deep: Vec::new(),
            chains: [const { None }; 3],
            made: [false; 3],
            ring: Ring::default(),
        }
    }

    fn prepare(&mut self, channel: TriangleChannel<'_>, face: u32, regular: [bool; 3]) {
        self.made = [false; 3];
        self.deep.clear();
        let mut hexagons = [Hexagon::<D4>::EMPTY; 3];
        let near = [0, 1, 2].map(|c: usize| {
            let h = 3 * face + c as u32;
            if regular[c] {
                hexagons[c] = Hexagon::gather(channel.topology, channel.points, h).refined();
                hexagons[c].near()
            } else {
                self.ring.gather(channel, h);
                self.ring.step();
                self.ring.near()
            }
        });
        let hexagon = |c: usize| regular[c].then_some(&hexagons[c]);
        self.lattice = Lattice::around(&near, [hexagon(0), hexagon(1), hexagon(2)]);
    }

    fn patch(&mut self, channel: TriangleChannel<'_>, face: u32, slot: Slot) -> Patch {
        let (c, cell) = (slot.corner as usize, slot.cell as usize);
        if slot.depth < 2 {
            return Patch::new(D4::ZERO, &self.lattice.child(cell));
        }
        let chain = self.chains[c].get_or_insert_with(Box::default);
        if !self.made[c] {
            self.made[c] = true;
            chain.begin(channel, 3 * face + c as u32, c, &self.lattice);
        }
        while chain.nodes.len() < slot.depth as usize {
            chain.deepen();
        }
        // The corner sees its own number as 0.
        let seen = if slot.cell == MIDDLE {
            cell
        } else {
            (cell + 3 - c) % 3
        };
        let mut net = chain.nodes[slot.depth as usize - 1].child(seen);
        for _ in 0..(3 - c) % 3 {
            net = turn(&net);
        }
        Patch::new(chain.limit, &net)
    }
}

impl Chain {
    fn begin(&mut self, channel: TriangleChannel<'_>, h: u32, c: usize, lattice: &Lattice<D4>) {
        self.ring.gather(channel, h);
        self.limit = self.ring.limit();
        self.ring.shift(self.limit);
        self.ring.step();
        self.nodes.clear();
        let node = lattice.towards(c, self.limit, &self.ring.near());
        self.nodes.push(node);
    }

    /// One more step towards the corner.
    fn deepen(&mut self) {
        self.ring.step();
        if let Some(last) = self.nodes.last() {
            self.nodes.push(last.deeper(&self.ring.near()));
        }
    }
}
