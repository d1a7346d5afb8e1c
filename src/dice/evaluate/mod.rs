//! The limit surface of one quad at any parameter: position, derivatives, and what they are at the corners.
//!
//! The same pieces as in [`face`](super::face), made only where a parameter falls: a regular quad is one bicubic B-spline; any other is
//! split once, and towards an irregular corner as often as the parameter is close to it (Stam 1998, with refinement in place of the
//! eigenvectors). Pieces are kept, so the next parameter nearby costs one B-spline. Refinement near a corner is in `f64`, relative to the
//! corner's limit; pieces are `f32`, relative to a point of their own, so that derivatives of small faces far from the origin lose
//! nothing.

mod once;
mod ring;
mod row;
mod spline;

use super::control::Descend;
use super::face::Channel;
use super::linear;
use super::net::{Net, fill_phantoms, gather_net, put_corner, refine_node, turn};
use super::point::{D4, P4, Point};
use super::window::Around;
pub(crate) use once::at_once;
use ring::Ring;
use row::Column;
pub(crate) use row::Row;
use spline::Patch;
pub(crate) use spline::{F4, Jet};
use std::ops::Range;

/// Parameters nearer than 2 to the minus this many to an irregular corner are the corner's.
pub(crate) const MAX_DEPTH: u32 = 40;

/// What a quad is at a parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// Inside, on a side, or at a regular corner.
    Smooth(Jet),
    /// At irregular corner `.1`: second derivatives do not exist, first ones are those of the flat star.
    Corner(Jet, usize),
}

/// The patch that holds a parameter of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf<C> {
    /// The control level that the patch belongs to.
    pub(crate) channel: C,
    pub(crate) depth: u32,
    pub(crate) quad: u32,
    /// The parameter on the patch, and how much faster it runs than the face's.
    pub(crate) at: [f32; 2],
    pub(crate) scale: f32,
    /// A corner that is a feature, if the parameter is that corner.
    pub(crate) tip: Option<usize>,
    /// The limit of a value at a feature that the control levels end at.
    pub(crate) value: Option<[f32; 3]>,
    /// Whether the control levels end before the patch does: it is at a feature still.
    pub(crate) open: bool,
}

/// Follows the control levels below quad `q` down to the patch at (`u`, `v`). `None` where the quad itself is the patch. `whole` where the quad
/// is one of the surface; else it is a part of one, whose corners are places as any other.
pub(crate) fn leaf(
    below: &dyn Descend,
    q: u32,
    u: f32,
    v: f32,
    whole: bool,
) -> Option<Leaf<Channel<'_>>> {
    let root = below.at(0)?;
    root.first_child(q)?;
    const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let corner = |at: [f32; 2]| CORNERS.iter().position(|&c| c == at);
    let mut tip = corner([u, v]).filter(|_| whole);
    if let Some(c) = tip {
        let h = 4 * q + c as u32;
        if !root.features[root.whole.vertex(h) as usize] {
            // The fan's own rule holds, and gives the same tangents in all faces around, refined or not.
            if !root.topology.fans()[root.topology.fan(h) as usize].is_regular() {
                return None;
            }
            tip = None;
        }
    }
    let (mut view, mut depth, mut quad, mut at) = (root, 0, q, [u, v]);
    while let Some(first) = view.first_child(quad) {
        // Below the last level there is nothing: darts end there.
        let Some(next) = below.at(depth + 1) else {
            break;
        };
        let [col, row] = at.map(|x| usize::from(x >= 0.5));
        quad = first + [[0, 1], [3, 2]][row][col];
        at = [2.0 * at[0] - col as f32, 2.0 * at[1] - row as f32];
        (view, depth) = (next, depth + 1);
    }
    Some(Leaf {
        channel: Channel {
            topology: view.topology,
            points: view.points,
            fans: view.fans,
            below: None,
            linear: false,
        },
        depth,
        quad,
        at,
        scale: (1_u32 << depth) as f32,
        tip,
        value: corner(at).and_then(|c| view.tip(4 * quad + c as u32)),
        open: view.first_child(quad).is_some(),
    })
}

/// One quad of a mesh, ready to be evaluated; to be prepared again for the next.
///
/// In this order, so that what every parameter needs lies on one line of the cache.
#[derive(Clone, Debug)]
#[repr(C)]
pub(crate) struct QuadEvaluator {
    irregular: bool,
    /// Of an irregular quad: corners by place, where bit 0 is set at u = 1, bit 1 at v = 1.
    regular: [bool; 4],
    /// The quad itself, or its pieces as parameters have asked for them.
    patches: Vec<Patch>,
    /// Places in `patches` by corner (by place), depth and cell of the sheet; [`MISSING`] if not made.
    slots: [[[u8; 4]; SHALLOW]; 4],
    q: u32,
    /// Kept while the quad is regular, for its memory.
    parts: Option<Box<Parts>>,
    /// Rows of the last grid, for their memory.
    row: Option<Box<Row>>,
}

/// Depths that are found without a search.
const SHALLOW: usize = 8;

/// What pieces of an irregular quad are made of.
#[derive(Clone, Debug)]
struct Parts {
    /// The net after one step.
    net: Net<5, D4>,
    /// Control points of pieces: first those of depth 1, around the middle, then what the corners have left.
    sheets: Vec<Sheet>,
    /// Patches deeper than slots go, or of numbers that slots do not hold.
    deep: Vec<(Slot, u16)>,
    /// Kept from quad to quad for their memory; `made` are of this one. By number of the corner.
    chains: [Option<Box<Chain>>; 4],
    made: [bool; 4],
    ring: Ring,
}

/// Corner by place, depth, cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slot {
    corner: u8,
    depth: u8,
    cell: u8,
}

/// Five by five control points, relative to an origin.
#[derive(Clone, Copy, Debug)]
struct Sheet {
    origin: P4,
    points: Net<5>,
}

impl Sheet {
    #[inline(always)]
    fn new(origin: P4, points: impl Fn(usize, usize) -> P4) -> Self {
        let mut out = Self {
            origin,
            points: [[P4::ZERO; 5]; 5],
        };
        for (r, row) in out.points.iter_mut().enumerate() {
            for (c, p) in row.iter_mut().enumerate() {
                *p = points(r, c);
            }
        }
        out
    }

    /// The patch of a cell: bit 0 is set for the right column, bit 1 for the upper row.
    fn patch(&self, cell: u8) -> Patch {
        let (row, col) = (usize::from(cell >> 1), usize::from(cell & 1));
        let line = |r: usize| {
            let p = &self.points[row + r];
            [p[col], p[col + 1], p[col + 2], p[col + 3]]
        };
        Patch::new(self.origin, &[line(0), line(1), line(2), line(3)])
    }
}

const MISSING: u8 = u8::MAX;

/// Numbers of corners by place.
const CORNERS: [usize; 4] = [0, 1, 3, 2];

/// What is next to an irregular corner, at the depth that was reached.
#[derive(Clone, Debug, Default)]
struct Chain {
    limit: P4,
    ring: Ring,
    /// The net, seen from the corner.
    node: Net<4, D4>,
    depth: u32,
    /// Places of its sheets, from depth 2 on.
    sheets: Vec<u32>,
}

impl Default for QuadEvaluator {
    fn default() -> Self {
        Self {
            q: 0,
            irregular: false,
            regular: [true; 4],
            slots: [[[MISSING; 4]; SHALLOW]; 4],
            patches: Vec::new(),
            parts: None,
            row: None,
        }
    }
}

/// A parameter of an irregular quad: which patch holds it, and where.
#[derive(Clone, Copy)]
struct Spot {
    slot: Slot,
    at: [f32; 2],
    scale: f32,
    /// 1 in the further column of a sheet, else 0.
    beyond: f32,
}

impl Spot {
    /// Depth of the piece whose larger distance from an irregular corner is `most`.
    #[inline(always)]
    fn depth(most: f32) -> u32 {
        (127 - (most.to_bits() >> 23) as i32).max(2) as u32
    }

    /// Along the row of this place: the parameter on its piece of another one that is on it too.
    #[inline(always)]
    fn along(&self, column: &Column) -> f32 {
        let far = f32::from(u8::from(column.far));
        (far - (column.from * self.scale - self.beyond)).abs()
    }

    /// Depth is 1 at a regular corner. At an irregular one it is 2 from 1/4 on, and one more for every halving of the distance.
    ///
    /// Without branches, which parameters at random would make wait.
    #[inline(always)]
    fn new(regular: &[bool; 4], u: f32, v: f32) -> Self {
        let far = [u >= 0.5, v >= 0.5].map(u8::from);
        // Distances from the nearest corner, 0 to 1/2. Exact, because what is subtracted from 1 is at least 1/2.
        let from = [(f32::from(far[0]) - u).abs(), (f32::from(far[1]) - v).abs()];
        let corner = far[0] | far[1] << 1;
        let most = if from[0] > from[1] { from[0] } else { from[1] };
        let exponent = Self::depth(most);
        let is_regular = u32::from(regular[corner as usize]);
        let depth = if is_regular == 1 { 1 } else { exponent };
        // Powers of two are exact, and so is what is left beyond the middle of the sheet.
        let scale = power(depth);
        let (mut cell, mut at, mut beyond) = (0, [0.0; 2], 0);
        for k in [1, 0] {
            let x = from[k] * scale;
            beyond = u8::from(x >= 1.0) & (is_regular as u8 ^ 1);
            cell |= (beyond ^ far[k]) << k;
            at[k] = (f32::from(far[k]) - (x - f32::from(beyond))).abs();
        }
        Self {
            slot: Slot {
                corner,
                depth: depth as u8,
                cell,
            },
            at,
            scale,
            beyond: f32::from(beyond),
        }
    }
}

impl QuadEvaluator {
    /// Prepares quad `q`.
    pub(crate) fn prepare(&mut self, channel: Channel<'_>, q: u32) {
        let t = channel.topology;
        self.q = q;
        self.patches.clear();
        let regular = |c: u32| channel.linear || t.fans()[t.fan(4 * q + c) as usize].is_regular();
        let regular = [regular(0), regular(1), regular(2), regular(3)];
        self.irregular = regular != [true; 4];
        if self.irregular {
            self.patches.reserve(2 * SHALLOW);
            self.slots = [[[MISSING; 4]; SHALLOW]; 4];
            self.regular = CORNERS.map(|c| regular[c]);
            let parts = self.parts.get_or_insert_with(|| Box::new(Parts::empty()));
            parts.prepare(channel, q, regular);
            return;
        }
        let mut net = if channel.linear {
            linear::net(channel, q)
        } else {
            let mut net = [[P4::ZERO; 4]; 4];
            gather_net(t, channel.points, q, &mut net);
            net
        };
        let origin = net[1][1];
        for p in net.iter_mut().flatten() {
            *p = *p - origin;
        }
        self.patches.push(Patch::new(origin, &net));
    }

    /// The patch at (`u`, `v`) of an irregular quad; `None` where it is an irregular corner.
    #[inline(always)]
    fn patch(&mut self, channel: Channel<'_>, slot: Slot) -> Option<&Patch> {
        let depth = slot.depth as usize;
        let mut known = MISSING;
        if depth < SHALLOW {
            known = self.slots[slot.corner as usize][depth][slot.cell as usize];
        }
        let at = match known {
            MISSING => self.seek(channel, slot)?,
            known => known.into(),
        };
        self.patches.get(at)
    }

    /// The place of a patch that slots do not tell: made, if it has to be.
    #[inline(never)]
    fn seek(&mut self, channel: Channel<'_>, slot: Slot) -> Option<usize> {
        let parts = self.parts.as_mut()?;
        let depth = slot.depth as usize;
        if depth > MAX_DEPTH as usize {
            return None;
        }
        if let Some(&(_, at)) = parts.deep.iter().find(|d| d.0 == slot) {
            return Some(at.into());
        }
        let at = self.patches.len();
        let sheet = parts.sheet(channel, self.q, slot);
        self.patches.push(sheet.patch(slot.cell));
        match u8::try_from(at) {
            Ok(at) if depth < SHALLOW && at != MISSING => {
                self.slots[slot.corner as usize][depth][slot.cell as usize] = at;
            }
            _ => parts.deep.push((slot, at as u16)),
        }
        Some(at)
    }

    /// The quad at (`u`, `v`), both in 0…1; `channel` is what the quad was prepared from.
    #[inline(always)]
    pub(crate) fn at<const ORDER: u32>(&mut self, channel: Channel<'_>, u: f32, v: f32) -> Place {
        if !self.irregular {
            let [patch, ..] = &self.patches[..] else {
                return Place::Smooth(Jet::at(F4::splat(0.0)));
            };
            return Place::Smooth(patch.jet::<ORDER>(u, v, 1.0));
        }
        let spot = Spot::new(&self.regular, u, v);
        match self.patch(channel, spot.slot) {
            Some(patch) => Place::Smooth(patch.jet::<ORDER>(spot.at[0], spot.at[1], spot.scale)),
            None => corner::<ORDER>(channel, self.q, spot.slot),
        }
    }

    /// Hands the rows of the quad's grid of `n` by `n` segments to `each`, u first in a row.
    #[inline(always)]
    pub(crate) fn grid<const ORDER: u32>(
        &mut self,
        channel: Channel<'_>,
        n: u32,
        mut each: impl FnMut(&Row),
    ) {
        let mut row = match self.row.take() {
            Some(row) if row.segments() == n => row,
            _ => Box::new(Row::new(n)),
        };
        for j in 0..=n {
            self.grid_row::<ORDER>(channel, j as f32 / n as f32, &mut row);
            each(&row);
        }
        self.row = Some(row);
    }

    #[inline(always)]
    pub(crate) fn grid_row<const ORDER: u32>(
        &mut self,
        channel: Channel<'_>,
        v: f32,
        row: &mut Row,
    ) {
        if !self.irregular {
            if let Some(patch) = self.patches.first() {
                row.fill::<ORDER>(&patch.curve::<ORDER>(v));
            }
            return;
        }
        row.begin();
        let line = Column::new(v);
        // Along a row of the grid v is the same all through a patch.
        let (mut first, mut last) = (0, None);
        for i in 0..row.columns.len() {
            let key = self.key(row.columns[i], line);
            if last != Some(key) {
                if last.is_some() {
                    self.grid_part::<ORDER>(channel, v, row, first..i);
                }
                (first, last) = (i, Some(key));
            }
        }
        self.grid_part::<ORDER>(channel, v, row, first..row.columns.len());
    }

    /// Different for places of a row on different pieces.
    #[inline(always)]
    fn key(&self, column: Column, line: Column) -> [u32; 3] {
        let corner = usize::from(column.far) | usize::from(line.far) << 1;
        if self.regular[corner] {
            return [corner as u32, 1, 0];
        }
        let depth = column.depth.min(line.depth);
        let beyond = column.from * power(depth) >= 1.0;
        [corner as u32, depth, u32::from(beyond)]
    }

    /// The part of a row that lies on one piece.
    #[inline(always)]
    fn grid_part<const ORDER: u32>(
        &mut self,
        channel: Channel<'_>,
        v: f32,
        row: &mut Row,
        columns: Range<usize>,
    ) {
        let u = row.columns[columns.start].u;
        let spot = Spot::new(&self.regular, u, v);
        let Some(patch) = self.patch(channel, spot.slot) else {
            for i in columns {
                if let Place::Corner(jet, c) = corner::<ORDER>(channel, self.q, spot.slot) {
                    row.put_corner::<ORDER>(i, jet, c);
                }
            }
            return;
        };
        let curve = patch.curve::<ORDER>(spot.at[1]);
        row.put::<ORDER>(&curve, &spot, columns);
    }
}

/// 2 to the `depth`.
#[inline(always)]
fn power(depth: u32) -> f32 {
    f32::from_bits((127 + depth) << 23)
}

#[cold]
fn corner<const ORDER: u32>(channel: Channel<'_>, q: u32, slot: Slot) -> Place {
    let c = CORNERS[slot.corner as usize];
    let h = 4 * q + c as u32;
    let mut ring = Ring::default();
    ring.gather(channel, h);
    let mut jet = Jet::at(F4::new(ring.limit().narrow().0));
    if ORDER > 0 {
        let [s, t] = ring.tangents(channel, h).map(|t| F4::new(t.narrow().0));
        (jet.du, jet.dv) = (s, t);
    }
    Place::Corner(jet.turned::<ORDER>(c), c)
}

impl Parts {
    fn empty() -> Self {
        Self {
            net: [[D4::ZERO; 5]; 5],
            sheets: Vec::with_capacity(SHALLOW),
            deep: Vec::new(),
            chains: [const { None }; 4],
            made: [false; 4],
            ring: Ring::default(),
        }
    }

    fn prepare(&mut self, channel: Channel<'_>, q: u32, regular: [bool; 4]) {
        self.made = [false; 4];
        self.sheets.clear();
        self.deep.clear();
        let mut open = [false; 4];
        for c in 0..4 {
            self.ring.gather(channel, 4 * q + c as u32);
            self.ring.step();
            put_corner(&mut self.net, c, &self.ring, regular[c]);
            open[c] = !self.ring.has(-1);
        }
        fill_phantoms(&mut self.net, 4, open);
        let (net, centre) = (&self.net, self.net[2][2]);
        self.sheets.push(Sheet::new(centre.narrow(), |r, c| {
            (net[r][c] - centre).narrow()
        }));
    }

    /// The sheet that holds a patch.
    fn sheet(&mut self, channel: Channel<'_>, q: u32, slot: Slot) -> &Sheet {
        let c = CORNERS[slot.corner as usize];
        let mut at = 0;
        if slot.depth > 1 {
            let chain = self.chains[c].get_or_insert_with(Box::default);
            if !self.made[c] {
                self.made[c] = true;
                chain.begin(channel, 4 * q + c as u32, c, &self.net);
            }
            while chain.depth < u32::from(slot.depth) {
                chain.sheets.push(self.sheets.len() as u32);
                chain.deepen(c, &mut self.sheets);
            }
            at = chain.sheets[slot.depth as usize - 2] as usize;
        }
        &self.sheets[at]
    }
}

impl Chain {
    fn begin(&mut self, channel: Channel<'_>, h: u32, c: usize, net: &Net<5, D4>) {
        self.ring.gather(channel, h);
        let limit = self.ring.limit();
        self.ring.shift(limit);
        self.ring.step();
        let net = turn(net, c);
        for (to, from) in self.node.iter_mut().zip(&net) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from - limit;
            }
        }
        self.limit = limit.narrow();
        self.depth = 1;
        self.sheets.clear();
    }

    /// One more step towards the corner: adds the pieces that it leaves, as the quad lies.
    fn deepen(&mut self, corner: usize, sheets: &mut Vec<Sheet>) {
        self.ring.step();
        let next = refine_node(&self.node, &self.ring);
        for (to, from) in self.node.iter_mut().zip(&next) {
            to.copy_from_slice(&from[..4]);
        }
        self.depth += 1;
        sheets.push(Sheet::new(self.limit, |r, c| {
            // From the quad's own view to the corner's.
            let (r, c) = match corner {
                0 => (r, c),
                1 => (4 - c, r),
                2 => (4 - r, 4 - c),
                _ => (c, 4 - r),
            };
            next[r][c].narrow()
        }));
    }
}
