//! A quad at one parameter, with nothing kept for the next.
//!
//! The patch of [`QuadEvaluator`](super::QuadEvaluator) that holds the parameter, bit for bit, with less on the way: control points come
//! straight from the half-edges, every point of the next level is made once (corners share what is between them; the formulas are
//! symmetric in the bits), only the sixteen points that the piece needs are made, and all of it stays on the stack. That is for quads
//! inside the surface at vertices of ordinary valence, which most are; any other is left to the evaluator.

use super::ring::{next_vertex, smooth_limit, step_closed};
use super::spline::{Jet, Patch};
use super::{CORNERS, MAX_DEPTH, Spot};
use crate::dice::face::Channel;
use crate::dice::net::{Net, face_at, refine_node};
use crate::dice::point::{D4, P4, Point};
use crate::dice::window::{Around, edge_point, face_point};
use crate::dispatch;
use crate::simd::Level;
use crate::topology::FanRule;

/// Most faces around a corner: beyond, what the stack would have to hold is seldom needed.
const MOST: usize = 8;

/// Quad `q` at (`u`, `v`), both in 0…1. `None` where the long way is to be gone: at boundaries, at vertices of fewer than 3 or more than
/// [`MOST`] faces, and right at irregular corners.
#[inline(never)]
pub(crate) fn at_once<const ORDER: u32>(
    channel: Channel<'_>,
    q: u32,
    u: f32,
    v: f32,
) -> Option<Jet> {
    at_level::<ORDER>(Level::detect(), channel, q, u, v)
}

#[inline(always)]
fn at_level<const ORDER: u32>(
    level: Level,
    channel: Channel<'_>,
    q: u32,
    u: f32,
    v: f32,
) -> Option<Jet> {
    if channel.linear {
        return None;
    }
    let t = channel.topology;
    let corners = t
        .corner_vertices
        .get(4 * q as usize..)?
        .first_chunk::<4>()?;
    let mut faces = [0; 4];
    for c in 0..4 {
        let fan = match t.corner_fans.get(4 * q as usize + c) {
            Some(&fan) => fan,
            None => corners[c],
        };
        let fan = t.fans.get(fan as usize)?;
        if fan.rule != FanRule::Smooth {
            return None;
        }
        faces[c] = fan.faces as usize;
    }
    // Number by number: as an array they would be compared in memory, before they have got there.
    if (faces[0] ^ 4) | (faces[1] ^ 4) | (faces[2] ^ 4) | (faces[3] ^ 4) == 0 {
        return dispatch!(level, whole::<ORDER>(channel, q, u, v));
    }
    if !faces.iter().all(|n| (3..=MOST).contains(n)) {
        return None;
    }
    let spot = Spot::new(&CORNERS.map(|c| faces[c] == 4), u, v);
    if u32::from(spot.slot.depth) > MAX_DEPTH {
        return None;
    }
    dispatch!(level, piece::<ORDER>(channel, q, faces, &spot))
}

/// A regular quad.
#[inline(always)]
fn whole<const ORDER: u32>(channel: Channel<'_>, q: u32, u: f32, v: f32) -> Option<Jet> {
    let mut net: Net<4> = gather(channel, q, 0)?;
    let origin = net[1][1];
    for p in net.iter_mut().flatten() {
        *p = *p - origin;
    }
    let patch = Patch::new(origin, &net);
    Some(patch.jet_here::<ORDER>(u, v, 1.0))
}

/// The point of a vertex.
#[inline(always)]
fn at<P: Point>(channel: Channel<'_>, vertex: u32) -> Option<P> {
    channel.points.get(vertex as usize).map(|&p| P::of(p))
}

/// The 16 control points around quad `q`, seen from its corner `first`. The one beyond an irregular corner means nothing.
#[inline(always)]
fn gather<P: Point>(channel: Channel<'_>, q: u32, first: usize) -> Option<Net<4, P>> {
    /// In walking order around the square: the corner, the two points beyond the side that leaves it, the point beyond the corner.
    const PLACES: [[(usize, usize); 4]; 4] = [
        [(1, 1), (0, 1), (0, 2), (0, 0)],
        [(1, 2), (1, 3), (2, 3), (0, 3)],
        [(2, 2), (3, 2), (3, 1), (3, 3)],
        [(2, 1), (2, 0), (1, 0), (3, 0)],
    ];
    let (twins, vertices) = (
        &channel.topology.twins[..],
        &channel.topology.corner_vertices[..],
    );
    let corners = vertices.get(4 * q as usize..)?.first_chunk::<4>()?;
    let across = twins.get(4 * q as usize..)?.first_chunk::<4>()?;
    let mut net = [[P::ZERO; 4]; 4];
    for (c, [own, near, far, beyond]) in PLACES.into_iter().enumerate() {
        let k = (first + c) & 3;
        net[own.0][own.1] = at(channel, corners[k])?;
        // No twin is a number that no half-edge has.
        let twin = across[k] as usize;
        let face = vertices.get(twin & !3..)?.first_chunk::<4>()?;
        net[near.0][near.1] = at(channel, face[(twin + 2) & 3])?;
        net[far.0][far.1] = at(channel, face[(twin + 3) & 3])?;
        let diagonal = *twins.get((twin & !3) | ((twin + 1) & 3))? as usize;
        net[beyond.0][beyond.1] = at(
            channel,
            *vertices.get((diagonal & !3) | ((diagonal + 3) & 3))?,
        )?;
    }
    Some(net)
}

/// A smooth vertex inside the surface, with its ring. Sector 0 belongs to the quad that asked.
struct Star {
    v: D4,
    /// e, f, e, f, …
    spokes: [D4; 2 * MOST],
    n: usize,
    /// Means of edge and face neighbours.
    edges: D4,
    faces: D4,
}

impl Star {
    const EMPTY: Self = Self {
        v: D4::ZERO,
        spokes: [D4::ZERO; 2 * MOST],
        n: 0,
        edges: D4::ZERO,
        faces: D4::ZERO,
    };

    /// Fills an empty one.
    #[inline(always)]
    fn gather(&mut self, channel: Channel<'_>, h: u32, n: usize) -> Option<()> {
        let (twins, vertices) = (
            &channel.topology.twins[..],
            &channel.topology.corner_vertices[..],
        );
        self.n = n;
        self.v = at(channel, *vertices.get(h as usize)?)?;
        let mut g = h as usize;
        for spoke in self.spokes.chunks_exact_mut(2).take(n) {
            let face = vertices.get(g & !3..)?.first_chunk::<4>()?;
            let e = at(channel, face[(g + 1) & 3])?;
            let f = at(channel, face[(g + 2) & 3])?;
            (spoke[0], spoke[1]) = (e, f);
            self.edges = self.edges + e;
            self.faces = self.faces + f;
            g = *twins.get((g & !3) | ((g + 3) & 3))? as usize;
        }
        let inverse = 1.0 / n as f64;
        self.edges = self.edges.times(inverse);
        self.faces = self.faces.times(inverse);
        Some(())
    }

    #[inline(always)]
    fn place(&self, i: i32) -> usize {
        let n = self.n as i32;
        let i = if i < 0 { i + n } else { i };
        let i = if i >= n { i - n } else { i };
        (2 * i as usize) & (2 * MOST - 1)
    }

    /// The face point of sector `i`.
    #[inline(always)]
    fn face(&self, i: i32) -> D4 {
        face_point(self.v, self.e(i), self.f(i), self.e(i + 1))
    }

    #[inline(always)]
    fn shift(&mut self, origin: D4) {
        for p in &mut self.spokes[..2 * self.n.min(MOST)] {
            *p = *p - origin;
        }
        self.v = self.v - origin;
        self.edges = self.edges - origin;
        self.faces = self.faces - origin;
    }

    #[inline(always)]
    fn step(&mut self) {
        let next = next_vertex(self.n as f64, self.v, &mut self.edges, &mut self.faces);
        step_closed(self.v, &mut self.spokes[..2 * self.n.min(MOST)]);
        self.v = next;
    }

    /// The net after steps to `depth` towards the vertex, relative to its limit; `node` is that of depth 1.
    #[inline(always)]
    fn descend(&mut self, limit: D4, mut node: Net<4, D4>, depth: u8) -> Net<5, D4> {
        self.shift(limit);
        self.step();
        for p in node.iter_mut().flatten() {
            *p = *p - limit;
        }
        let mut reached = 1;
        loop {
            self.step();
            let next = refine_node(&node, self);
            reached += 1;
            if reached >= depth {
                return next;
            }
            for (to, from) in node.iter_mut().zip(&next) {
                to.copy_from_slice(&from[..4]);
            }
        }
    }
}

impl Around<D4> for Star {
    #[inline(always)]
    fn v(&self) -> D4 {
        self.v
    }
    #[inline(always)]
    fn e(&self, i: i32) -> D4 {
        self.spokes[self.place(i)]
    }
    #[inline(always)]
    fn f(&self, i: i32) -> D4 {
        self.spokes[self.place(i) + 1]
    }
    #[inline(always)]
    fn has(&self, _: i32) -> bool {
        true
    }
}

/// What the next level needs of a corner: its point, and the face points of sectors 2 and −2, which are one at a regular corner.
struct Corner {
    v: D4,
    left: D4,
    below: D4,
}

impl Corner {
    /// Of half-edge `h`; `ring` is what is around it if it has 4 faces, seen with the own quad on the upper right.
    #[inline(always)]
    fn new(channel: Channel<'_>, h: u32, faces: usize, ring: &[[D4; 3]; 3]) -> Option<Self> {
        if faces == 4 {
            return Some(Self::regular(ring));
        }
        let mut star = Star::EMPTY;
        star.gather(channel, h, faces)?;
        Some(Self::of(&star))
    }

    #[inline(always)]
    fn of(star: &Star) -> Self {
        let (mut edges, mut faces) = (star.edges, star.faces);
        Self {
            v: next_vertex(star.n as f64, star.v, &mut edges, &mut faces),
            left: star.face(2),
            below: star.face(-2),
        }
    }

    #[inline(always)]
    fn regular(n: &[[D4; 3]; 3]) -> Self {
        let mut edges = (((D4::ZERO + n[1][2]) + n[2][1]) + n[1][0]) + n[0][1];
        let mut faces = (((D4::ZERO + n[2][2]) + n[2][0]) + n[0][0]) + n[0][2];
        (edges, faces) = (edges.times(0.25), faces.times(0.25));
        let face = face_point(n[0][0], n[0][1], n[1][1], n[1][0]);
        Self {
            v: next_vertex(4.0, n[1][1], &mut edges, &mut faces),
            left: face,
            below: face,
        }
    }
}

/// A piece of an irregular quad.
#[inline(always)]
fn piece<const ORDER: u32>(
    channel: Channel<'_>,
    q: u32,
    faces: [usize; 4],
    spot: &Spot,
) -> Option<Jet> {
    let first = CORNERS[spot.slot.corner as usize & 3];
    let n: Net<4, D4> = gather(channel, q, first)?;
    let b = [
        [n[0][3], n[1][3], n[2][3]],
        [n[0][2], n[1][2], n[2][2]],
        [n[0][1], n[1][1], n[2][1]],
    ];
    let c = [
        [n[3][3], n[3][2], n[3][1]],
        [n[2][3], n[2][2], n[2][1]],
        [n[1][3], n[1][2], n[1][1]],
    ];
    let d = [
        [n[3][0], n[2][0], n[1][0]],
        [n[3][1], n[2][1], n[1][1]],
        [n[3][2], n[2][2], n[1][2]],
    ];
    let half = [0, 1, 2, 3].map(|k| 4 * q + ((first + k) & 3) as u32);
    let n_of = [0, 1, 2, 3].map(|k| faces[(first + k) & 3]);
    let b = Corner::new(channel, half[1], n_of[1], &b)?;
    let c = Corner::new(channel, half[2], n_of[2], &c)?;
    let d = Corner::new(channel, half[3], n_of[3], &d)?;
    let mut own = Star::EMPTY;
    let a = if n_of[0] == 4 {
        Corner::regular(&[
            [n[0][0], n[0][1], n[0][2]],
            [n[1][0], n[1][1], n[1][2]],
            [n[2][0], n[2][1], n[2][2]],
        ])
    } else {
        own.gather(channel, half[0], n_of[0])?;
        Corner::of(&own)
    };
    let (down, left, centre, right, up) = (
        face_at(&n, 0, 1),
        face_at(&n, 1, 0),
        face_at(&n, 1, 1),
        face_at(&n, 1, 2),
        face_at(&n, 2, 1),
    );
    let net = [
        [
            a.left,
            edge_point(n[1][1], n[0][1], a.below, down),
            down,
            edge_point(n[1][2], n[0][2], down, b.left),
        ],
        [
            edge_point(n[1][1], n[1][0], left, a.left),
            a.v,
            edge_point(n[1][1], n[1][2], down, centre),
            b.v,
        ],
        [
            left,
            edge_point(n[1][1], n[2][1], left, centre),
            centre,
            edge_point(n[1][2], n[2][2], centre, right),
        ],
        [
            edge_point(n[2][1], n[2][0], left, d.below),
            d.v,
            edge_point(n[2][1], n[2][2], centre, up),
            c.v,
        ],
    ];
    let mut sheet = [P4::ZERO; 32];
    let origin;
    if n_of[0] == 4 {
        origin = centre;
        for r in 0..4 {
            for c in 0..4 {
                sheet[5 * r + c] = (net[r][c] - centre).narrow();
            }
        }
    } else {
        origin = smooth_limit(own.n as f64, own.v, own.edges, own.faces);
        let next = own.descend(origin, net, spot.slot.depth);
        for r in 0..5 {
            for c in 0..5 {
                sheet[5 * r + c] = next[r][c].narrow();
            }
        }
    }
    let patch = cell(origin.narrow(), &sheet, first, spot);
    Some(patch.jet_here::<ORDER>(spot.at[0], spot.at[1], spot.scale))
}

/// The patch of the cell of `spot`, as the quad lies, from a sheet as seen from `corner`.
#[inline(always)]
fn cell(origin: P4, sheet: &[P4; 32], corner: usize, spot: &Spot) -> Patch {
    // Place of the quad's own first point in the corner's view, and the way to the next row and column.
    let (start, down, along) = [(0, 5, 1), (20, 1, -5), (24, -5, -1), (4, -1, 5)][corner & 3];
    let (row, col) = (
        i32::from(spot.slot.cell >> 1),
        i32::from(spot.slot.cell & 1),
    );
    let start: i32 = start + row * down + col * along;
    let mut points = [[P4::ZERO; 4]; 4];
    let mut line = start;
    for row in &mut points {
        let mut at = line;
        for p in row {
            *p = sheet[at as usize & 31];
            at += along;
        }
        line += down;
    }
    Patch::new(origin, &points)
}

#[cfg(test)]
mod tests {
    use super::super::{Place, QuadEvaluator};
    use super::*;
    use crate::dice::fan_points::FanPoints;
    use crate::dice::tangent_masks::TangentMasks;
    use crate::topology::{ConnectOptions, Topology, connect};

    fn jets(channel: Channel<'_>, quads: u32) -> usize {
        let (mut once, mut state) = (0, 1_u64);
        let mut unit = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1_u32 << 24) as f32
        };
        for q in 0..quads {
            let mut kept = QuadEvaluator::default();
            kept.prepare(channel, q);
            for k in 0..200 {
                // Close to corners, too.
                let shrink = [1.0, 0.1, 1e-3, 1e-7][k % 4];
                let near = |x: f32| if k % 8 < 4 { x } else { 1.0 - x };
                let (u, v) = (near(unit() * shrink), near(unit() * shrink));
                let Place::Smooth(want) = kept.at::<2>(channel, u, v) else {
                    continue;
                };
                for level in Level::available() {
                    if let Some(got) = at_level::<2>(level, channel, q, u, v) {
                        assert_eq!(format!("{got:?}"), format!("{want:?}"), "{q} {u} {v}");
                        once += 1;
                    }
                }
            }
        }
        once / Level::available().len()
    }

    /// Quads around two vertices of valences `n` and 4, closed by hand: a prism of `n` sides, every side split in two, with lids of `n` quads.
    fn prism(n: u32) -> (Topology, Vec<[f32; 3]>) {
        let m = 2 * n;
        let ring = |level: u32, i: u32| level * m + i % m;
        let (mut points, mut corners) = (Vec::new(), Vec::new());
        for level in 0..4 {
            for i in 0..m {
                let angle = f64::from(i) * std::f64::consts::TAU / f64::from(m);
                let wide = 1.0 + 0.2 * f64::from(level);
                let height = f64::from(level) + 0.1 * f64::from(i * i % 7);
                points.push([libm::cos(angle) * wide, libm::sin(angle) * wide, height]);
            }
        }
        points.push([0.1, 0.0, -0.7]);
        points.push([0.0, 0.2, 3.9]);
        for level in 0..3 {
            for i in 0..m {
                corners.extend([ring(level, i), ring(level, i + 1)]);
                corners.extend([ring(level + 1, i + 1), ring(level + 1, i)]);
            }
        }
        for i in (0..m).step_by(2) {
            corners.extend([4 * m, ring(0, i + 2), ring(0, i + 1), ring(0, i)]);
            corners.extend([4 * m + 1, ring(3, i), ring(3, i + 1), ring(3, i + 2)]);
        }
        let points: Vec<[f32; 3]> = points.iter().map(|p| p.map(|c| c as f32)).collect();
        let offsets: Vec<u32> = (0..=corners.len() as u32 / 4).map(|f| 4 * f).collect();
        let (t, _) = connect(points.len(), &offsets, corners, &ConnectOptions::default());
        (t, points)
    }

    #[test]
    fn one_place_has_the_bits_of_a_kept_face_at_every_level_of_instructions() {
        for n in [3, 4, 5, 8, 9] {
            let (topology, points) = prism(n);
            let masks = TangentMasks::new(&topology);
            let fans = FanPoints::new(&topology, &masks, &points, None, true);
            let channel = Channel {
                topology: &topology,
                points: &points,
                fans: &fans,
                below: None,
                linear: false,
            };
            let quads = topology.face_count() as u32;
            let once = jets(channel, quads);
            // The lids' middles of more than 8 faces go the long way.
            let lids = if n > MOST as u32 { 2 * n } else { 0 };
            assert!(once as u32 > 150 * (quads - lids), "{once} of {quads}");
        }
    }
}
