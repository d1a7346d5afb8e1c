//! The limit surface of one quad at any parameter: position, derivatives, and what they are at the corners.
//!
//! The same pieces as in [`face`](super::face), made only where a parameter falls: a regular quad is one bicubic B-spline; any other is
//! split once, and towards an irregular corner as often as the parameter is close to it (Stam 1998, with refinement in place of the
//! eigenvectors). Pieces are kept, so the next parameter nearby costs one B-spline. Refinement near a corner is in `f64`, relative to the
//! corner's limit; pieces are `f32`, relative to a point of their own, so that derivatives of small faces far from the origin lose
//! nothing.

mod ring;
mod spline;

use super::control::Descend;
use super::face::Channel;
use super::linear;
use super::net::{Net, gather_net, once_refined, refine_node, turn, turn_back};
use super::point::{D4, P4, Point};
use super::window::Near;
use ring::Ring;
pub(crate) use spline::Jet;
use spline::{Curve, Row, Sheet, Weights};

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

/// The patch that holds a parameter of a quad.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf<'a> {
    /// The control level that the patch belongs to.
    pub(crate) channel: Channel<'a>,
    pub(crate) depth: u32,
    pub(crate) quad: u32,
    /// The parameter on the patch, which is 2 to the minus `depth` as large as the quad.
    pub(crate) at: [f32; 2],
    /// A corner that is a feature, if the parameter is that corner.
    pub(crate) tip: Option<usize>,
}

/// Follows the control levels below quad `q` down to the patch at (`u`, `v`). `None` where the quad itself is the patch.
pub(crate) fn leaf<'a>(below: &'a dyn Descend, q: u32, u: f32, v: f32) -> Option<Leaf<'a>> {
    let root = below.at(0)?;
    root.first_child(q)?;
    let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .iter()
        .position(|&at| at == [u, v]);
    let tip = corner.filter(|&c| root.features[root.whole.vertex(4 * q + c as u32) as usize]);
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
        tip,
    })
}

/// One quad of a mesh, ready to be evaluated; to be prepared again for the next.
#[derive(Clone, Debug)]
pub(crate) struct QuadEvaluator {
    q: u32,
    irregular: bool,
    origin: P4,
    rows: [Row; 4],
    /// Also kept while the quad is regular, for its memory.
    parts: Option<Box<Parts>>,
}

/// An irregular quad after one step.
#[derive(Clone, Debug)]
struct Parts {
    regular: [bool; 4],
    net: Net<5, D4>,
    origin: P4,
    sheet: Sheet,
    /// Kept from quad to quad for their memory; those that are of this one.
    chains: [Option<Box<Chain>>; 4],
    made: [bool; 4],
    ring: Ring,
}

/// The pieces towards an irregular corner.
#[derive(Clone, Debug, Default)]
struct Chain {
    limit: P4,
    ring: Ring,
    /// The net at the corner, seen from it, and its ring, both at the depth that was reached.
    node: Net<4, D4>,
    /// Of depths 2, 3, …, as the quad lies.
    sheets: Vec<Sheet>,
}

impl Default for QuadEvaluator {
    fn default() -> Self {
        Self {
            q: 0,
            irregular: false,
            origin: P4::ZERO,
            rows: [[0.0; 16]; 4],
            parts: None,
        }
    }
}

/// A piece of the quad: its rows and the parameter within.
struct Piece<'a> {
    rows: [&'a Row; 4],
    origin: P4,
    at: [f32; 2],
    scale: f32,
}

/// What stands at a parameter.
enum Found<'a> {
    Piece(Piece<'a>),
    /// The irregular corner of this number.
    Corner(usize),
}

impl Piece<'_> {
    #[inline(always)]
    fn jet<const ORDER: u32>(&self) -> Jet {
        let v = Weights::at(self.at[1]);
        let curve = Curve::across::<ORDER>(self.rows, &v);
        self.end::<ORDER>(&curve, &Weights::at(self.at[0]))
    }

    #[inline(always)]
    fn end<const ORDER: u32>(&self, curve: &Curve, u: &Weights) -> Jet {
        curve
            .at::<ORDER>(u, self.origin)
            .scaled::<ORDER>(self.scale)
    }
}

/// Where a parameter lies next to its nearest corner `c`: `s` along the side that leaves the corner, `t` along the one that comes in,
/// both 0 to 1/2. Exact, because what is subtracted from 1 is at least 1/2.
#[inline(always)]
fn from_corner(u: f32, v: f32) -> (usize, [usize; 2], [f32; 2]) {
    let (col, row) = (usize::from(u >= 0.5), usize::from(v >= 0.5));
    let c = [[0, 1], [3, 2]][row][col];
    let st = match c {
        0 => [u, v],
        1 => [v, 1.0 - u],
        2 => [1.0 - u, 1.0 - v],
        _ => [1.0 - v, u],
    };
    (c, [row, col], st)
}

/// Depth of the piece at (`s`, `t`) from an irregular corner: 2 from 1/4 on, one more for every halving.
#[inline(always)]
fn depth_at([s, t]: [f32; 2]) -> u32 {
    let exponent = 127 - (s.max(t).to_bits() >> 23) as i32;
    exponent.max(2) as u32
}

impl QuadEvaluator {
    /// Prepares quad `q`.
    pub(crate) fn prepare(&mut self, channel: Channel<'_>, q: u32) {
        let t = channel.topology;
        self.q = q;
        let regular: [bool; 4] = std::array::from_fn(|c| {
            channel.linear || t.fans()[t.fan(4 * q + c as u32) as usize].is_regular()
        });
        self.irregular = regular != [true; 4];
        if self.irregular {
            let parts = self.parts.get_or_insert_with(|| Box::new(Parts::empty()));
            parts.prepare(channel, q, regular);
            return;
        }
        let net = if channel.linear {
            linear::net(channel, q)
        } else {
            gather_net(t, channel.points, q)
        };
        self.origin = net[1][1];
        for (row, points) in self.rows.iter_mut().zip(&net) {
            for (out, p) in row.chunks_exact_mut(4).zip(points) {
                out.copy_from_slice(&(*p - self.origin).0);
            }
        }
    }

    /// The quad at (`u`, `v`), both in 0…1; `channel` is what the quad was prepared from.
    #[inline(always)]
    pub(crate) fn at<const ORDER: u32>(&mut self, channel: Channel<'_>, u: f32, v: f32) -> Place {
        if self.irregular {
            return self.at_irregular::<ORDER>(channel, u, v);
        }
        Place::Smooth(self.whole(u, v).jet::<ORDER>())
    }

    fn at_irregular<const ORDER: u32>(&mut self, channel: Channel<'_>, u: f32, v: f32) -> Place {
        let Some(parts) = &mut self.parts else {
            return Place::Smooth(Jet::default());
        };
        parts.deepen(channel, self.q, u, v);
        match parts.find(u, v) {
            Found::Piece(piece) => Place::Smooth(piece.jet::<ORDER>()),
            Found::Corner(c) => parts.corner::<ORDER>(channel, self.q, c),
        }
    }

    #[inline(always)]
    fn whole(&self, u: f32, v: f32) -> Piece<'_> {
        Piece {
            rows: self.rows.each_ref(),
            origin: self.origin,
            at: [u, v],
            scale: 1.0,
        }
    }

    /// The quad on a grid of `n` by `n` segments, row by row, u first.
    #[inline(always)]
    pub(crate) fn grid<const ORDER: u32>(
        &mut self,
        channel: Channel<'_>,
        n: u32,
        mut out: impl FnMut(Place),
    ) {
        let at = |i: u32| i as f32 / n as f32;
        if !self.irregular {
            let columns: Vec<Weights> = (0..=n).map(|i| Weights::at(at(i))).collect();
            for j in 0..=n {
                let piece = self.whole(0.0, at(j));
                let curve = Curve::across::<ORDER>(piece.rows, &Weights::at(at(j)));
                for u in &columns {
                    out(Place::Smooth(piece.end::<ORDER>(&curve, u)));
                }
            }
            return;
        }
        let Some(parts) = &mut self.parts else { return };
        let d = 1.0 / n as f32;
        for (u, v) in [(d, d), (1.0 - d, d), (1.0 - d, 1.0 - d), (d, 1.0 - d)] {
            parts.deepen(channel, self.q, u, v);
        }
        for j in 0..=n {
            let mut last: Option<(*const Row, Curve)> = None;
            for i in 0..=n {
                match parts.find(at(i), at(j)) {
                    Found::Corner(c) => {
                        let place = parts.corner::<ORDER>(channel, self.q, c);
                        out(place);
                        last = None;
                    }
                    Found::Piece(piece) => {
                        // Along a row of the grid v is the same all through a piece.
                        let key = std::ptr::from_ref(piece.rows[0]);
                        let curve = match &last {
                            Some((known, curve)) if *known == key => *curve,
                            _ => Curve::across::<ORDER>(piece.rows, &Weights::at(piece.at[1])),
                        };
                        out(Place::Smooth(
                            piece.end::<ORDER>(&curve, &Weights::at(piece.at[0])),
                        ));
                        last = Some((key, curve));
                    }
                }
            }
        }
    }
}

impl Parts {
    fn empty() -> Self {
        Self {
            regular: [true; 4],
            net: [[D4::ZERO; 5]; 5],
            origin: P4::ZERO,
            sheet: Sheet([[0.0; 20]; 5]),
            chains: [const { None }; 4],
            made: [false; 4],
            ring: Ring::default(),
        }
    }

    fn prepare(&mut self, channel: Channel<'_>, q: u32, regular: [bool; 4]) {
        self.regular = regular;
        self.made = [false; 4];
        let mut near = [Near::EMPTY; 4];
        for c in 0..4 {
            self.ring.gather(channel, 4 * q + c as u32);
            self.ring.step();
            near[c] = self.ring.near();
        }
        self.net = once_refined(&near, regular);
        let centre = self.net[2][2];
        self.origin = centre.narrow();
        self.sheet = Sheet::new(|r, c| (self.net[r][c] - centre).narrow());
    }

    /// Makes the pieces that (`u`, `v`) needs.
    #[inline]
    fn deepen(&mut self, channel: Channel<'_>, q: u32, u: f32, v: f32) {
        let (c, _, st) = from_corner(u, v);
        let depth = depth_at(st);
        if self.regular[c] || depth > MAX_DEPTH {
            return;
        }
        let chain = self.chains[c].get_or_insert_with(Box::default);
        if !self.made[c] {
            self.made[c] = true;
            chain.begin(channel, 4 * q + c as u32, c, &self.net);
        }
        while chain.sheets.len() + 1 < depth as usize {
            chain.deepen(c);
        }
    }

    #[inline]
    fn find(&self, u: f32, v: f32) -> Found<'_> {
        let (c, [row, col], st) = from_corner(u, v);
        if self.regular[c] {
            return Found::Piece(Piece {
                rows: self.sheet.rows(row, col),
                origin: self.origin,
                at: [2.0 * u - col as f32, 2.0 * v - row as f32],
                scale: 2.0,
            });
        }
        let depth = depth_at(st);
        let chain = self.chains[c]
            .as_ref()
            .filter(|_| self.made[c])
            .and_then(|chain| Some((chain, chain.sheets.get((depth as usize).wrapping_sub(2))?)));
        let Some((chain, sheet)) = chain else {
            return Found::Corner(c);
        };
        // Powers of two are exact, and so is what is left beyond the middle of the sheet.
        let scale = (1_u64 << depth) as f32;
        let [s, t] = st.map(|x| x * scale);
        let (i, j) = (usize::from(s >= 1.0), usize::from(t >= 1.0));
        let (s, t) = (s - i as f32, t - j as f32);
        let ([row, col], at) = match c {
            0 => ([j, i], [s, t]),
            1 => ([i, 1 - j], [1.0 - t, s]),
            2 => ([1 - j, 1 - i], [1.0 - s, 1.0 - t]),
            _ => ([1 - i, j], [t, 1.0 - s]),
        };
        Found::Piece(Piece {
            rows: sheet.rows(row, col),
            origin: chain.limit,
            at,
            scale,
        })
    }

    #[cold]
    fn corner<const ORDER: u32>(&self, channel: Channel<'_>, q: u32, c: usize) -> Place {
        let h = 4 * q + c as u32;
        let mut ring = Ring::default();
        ring.gather(channel, h);
        let mut jet = Jet {
            position: ring.limit().narrow(),
            ..Jet::default()
        };
        if ORDER > 0 {
            let [s, t] = ring.tangents(channel, h).map(D4::narrow);
            (jet.du, jet.dv) = (s, t);
        }
        Place::Corner(jet.turned::<ORDER>(c), c)
    }
}

impl Chain {
    fn begin(&mut self, channel: Channel<'_>, h: u32, c: usize, net: &Net<5, D4>) {
        self.sheets.clear();
        self.ring.gather(channel, h);
        let limit = self.ring.limit();
        self.ring.shift(limit);
        self.ring.step();
        let net = turn(net, c);
        self.node = std::array::from_fn(|r| std::array::from_fn(|k| net[r][k] - limit));
        self.limit = limit.narrow();
    }

    /// One more step towards the corner.
    fn deepen(&mut self, corner: usize) {
        self.ring.step();
        let next = refine_node(&self.node, &self.ring.near());
        let own = turn_back(&next, corner);
        self.sheets.push(Sheet::new(|r, c| own[r][c].narrow()));
        self.node = std::array::from_fn(|r| std::array::from_fn(|c| next[r][c]));
    }
}
