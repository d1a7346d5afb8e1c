//! One quad of the control mesh, ready to be diced: gathered from its ear stencil and nothing else.
//!
//! A quad with four regular corners is one bicubic piece. Any other is split once; around each irregular corner the split goes on
//! towards the corner, and every step leaves three regular pieces behind (after Stam, *Exact evaluation of Catmull-Clark subdivision
//! surfaces at arbitrary parameter values*, 1998, with the refinement itself in place of its eigenvectors, so that any boundary or
//! valence works alike). The sides come from the edges' own rule, the corners from their fans.

use super::basis::Target;
use super::control::{Descend, Dot, Owner, is_refined};
use super::edge::{
    EdgeSamples, SamplePart, Samples, Strip, irregular_half, regular_half, sample_boundary,
    whole_strip,
};
use super::fan_points::FanPoints;
use super::net::{
    Net, corner_origin, gather_net, once_refined, refine_node, regular_vertex, side_strip, turn,
    turn_back,
};
use super::point::P4;
use super::regular::{BlockRange, Piece, dice_pieces};
use super::window::{Near, Window};
use crate::dispatch;
use crate::records::{BLOCK_POINTS, BlockSize, Grid3};
use crate::simd::Level;
use crate::topology::{FanRule, NONE, Ring, Topology};

/// Control data of one channel (positions, or texture coordinates as points) of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Channel<'a> {
    pub(crate) topology: &'a Topology,
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) fans: &'a FanPoints,
    /// Control levels below, where quads at features are no patches.
    pub(crate) below: Option<&'a dyn Descend>,
    /// Whether quads are bilinear patches instead.
    pub(crate) linear: bool,
}

/// A rule broken on purpose, so that tests can show that they would notice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
pub enum DiceFault {
    /// Nothing broken.
    #[default]
    None,
    /// Every face walks its edges in its own direction.
    OwnDirection,
}

/// What of the four sides is evaluated by the edges' own rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Sides {
    /// Nothing is diced at all: only [`FacePatch::hull`] is asked for.
    #[default]
    Hull,
    /// Nothing: for channels that are not drawn.
    None,
    /// Points.
    Points,
    /// Points and normals.
    Normals,
}

/// A square of a face's grid: the points of level `level` from `start` on, `segments` and one more along each side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// At most the level that the face is prepared for.
    pub(crate) level: u32,
    pub(crate) start: [u32; 2],
    /// At most 32; 0 for one point.
    pub(crate) segments: u32,
}

impl Part {
    /// Block (`bu`, `bv`) of a whole level.
    pub(crate) fn block(level: u32, block: [u32; 2]) -> Self {
        let segments = 1_u32 << level.min(5);
        Self {
            level,
            start: block.map(|b| b * segments),
            segments,
        }
    }
}

/// A quad prepared for dicing at one level, with buffers that are used again for the next quad.
#[derive(Clone, Debug)]
pub struct FacePatch {
    pub(super) level: u32,
    pub(super) target: Target,
    pub(super) pieces: Vec<Piece>,
    /// Points between the pieces of a quad with deeper levels.
    pub(super) dots: Vec<Dot>,
    pub(super) owner: Option<Box<Owner>>,
    /// Whether the corners are among the dots.
    refined: bool,
    pub(super) sides: [EdgeSamples; 4],
    pub(super) corners: [([f32; 3], [f32; 3]); 4],
    windows: [Window; 4],
    /// What is next to each corner at depth 1.
    near: [Near; 4],
    /// What is next to the irregular corner in work, at depths 1, 2, ….
    rings: Vec<Near>,
    pub(super) wanted: Sides,
    /// Control points that no piece stands for, in hulls only.
    pub(super) hull: Vec<P4>,
    pub(crate) fault: DiceFault,
    /// Vector instructions; never changes a bit.
    pub(crate) simd: Level,
}

impl Default for FacePatch {
    fn default() -> Self {
        Self {
            level: 0,
            target: Target::Limit,
            pieces: Vec::new(),
            dots: Vec::new(),
            owner: None,
            refined: false,
            sides: Default::default(),
            corners: Default::default(),
            windows: [const { Window::EMPTY }; 4],
            near: [Near::EMPTY; 4],
            rings: Vec::new(),
            wanted: Sides::Hull,
            hull: Vec::new(),
            fault: DiceFault::None,
            simd: Level::SCALAR,
        }
    }
}

impl FacePatch {
    /// Prepares quad `q` at `level`. Without `sides` (texture coordinates) all points come from the pieces.
    pub(crate) fn prepare(
        &mut self,
        channel: Channel<'_>,
        q: u32,
        target: Target,
        level: u32,
        sides: Sides,
    ) {
        let t = channel.topology;
        self.begin(level, target, sides);
        for c in 0..4 {
            let f = t.fan(4 * q + c as u32) as usize;
            let normal = channel.fans.normals.get(f).copied().unwrap_or([0.0; 3]);
            self.corners[c] = (channel.fans.limits[f], normal);
        }
        self.refined = is_refined(channel, q);
        match channel.below {
            Some(below) if self.refined && level == 0 => self.tip_corners(below, q),
            Some(below) if self.refined => self.prepare_refined(channel, below, q),
            _ if channel.linear => self.prepare_linear(channel, q),
            _ if level == 0 => {}
            _ => self.prepare_patch(channel, q),
        }
    }

    /// Empties the buffers for the next quad.
    pub(super) fn begin(&mut self, level: u32, target: Target, sides: Sides) {
        self.level = level;
        self.target = target;
        self.wanted = sides;
        self.pieces.clear();
        self.dots.clear();
        self.hull.clear();
        if sides > Sides::None && level > 0 {
            self.sides.iter_mut().for_each(|s| s.resize(1 << level));
        }
    }

    /// Adds the pieces of a quad whose fans' rules hold, and its sides.
    pub(super) fn prepare_patch(&mut self, channel: Channel<'_>, q: u32) {
        let t = channel.topology;
        let (level, sides) = (self.level, self.wanted);
        let n = 1_usize << level;
        let fans: [u32; 4] = std::array::from_fn(|c| t.fan(4 * q + c as u32));
        let regular: [bool; 4] = std::array::from_fn(|c| t.fans()[fans[c] as usize].is_regular());
        if regular == [true; 4] {
            let net = gather_net(t, channel.points, q);
            self.pieces.push(Piece {
                net,
                origin: [0, 0],
                size: n as u32,
                level,
            });
            if sides > Sides::None {
                for c in 0..4 {
                    let strip = side_strip(&net, c);
                    self.whole_side(t, channel.points, q, c, &strip);
                }
            }
        } else {
            self.prepare_irregular(channel, q, fans, regular);
        }
    }

    /// Whether side `c` of quad `q` runs along its edge's canonical direction, from the lower to the higher vertex number.
    fn runs_forward(&self, t: &Topology, q: u32, c: usize) -> bool {
        let h = 4 * q + c as u32;
        self.fault == DiceFault::OwnDirection || t.vertex(h) < t.vertex(t.next(h))
    }

    /// Samples an edge with two regular ends, along its canonical direction.
    fn whole_side(&mut self, t: &Topology, points: &[[f32; 3]], q: u32, c: usize, strip: &Strip) {
        self.sample_side(strip, t, q, c);
        if t.twin(4 * q + c as u32) == NONE {
            self.boundary_side(t, points, q, c);
        }
    }

    /// Samples the strip of side `c` in the edge's direction; says whether that is the side's own.
    pub(super) fn sample_side(&mut self, strip: &Strip, t: &Topology, q: u32, c: usize) -> bool {
        let n = 1_i64 << self.level;
        let forward = self.runs_forward(t, q, c);
        let to = Samples {
            target: self.target,
            level: self.level,
            at: 0,
            step: 1,
            simd: self.simd,
            normals: self.wanted == Sides::Normals,
            part: SamplePart::All,
        };
        let out = &mut self.sides[c];
        if forward {
            strip.sample(to, out);
        } else {
            strip.reversed().sample(
                Samples {
                    at: n,
                    step: -1,
                    ..to
                },
                out,
            );
        }
        forward
    }

    /// Puts the points of a boundary edge on the curve of the boundary polygon.
    fn boundary_side(&mut self, t: &Topology, points: &[[f32; 3]], q: u32, c: usize) {
        let h = 4 * q + c as u32;
        let at = |g: u32| P4::new(points[t.vertex(g) as usize]);
        let (a, b) = (at(h), at(t.next(h)));
        let before = if t.fans()[t.fan(h) as usize].rule == FanRule::Corner {
            P4::beyond(a, b)
        } else {
            Ring::from_half(t, h).last().map_or(a, |g| at(t.prev(g)))
        };
        let next = t.next(h);
        let end = t.fans()[t.fan(next) as usize];
        let after = if end.rule == FanRule::Corner {
            P4::beyond(b, a)
        } else {
            at(t.next(end.first))
        };
        let n = 1_i64 << self.level;
        if self.runs_forward(t, q, c) {
            sample_boundary(
                [before, a, b, after],
                self.target,
                self.level,
                &mut self.sides[c],
                0,
                1,
            );
        } else {
            sample_boundary(
                [after, b, a, before],
                self.target,
                self.level,
                &mut self.sides[c],
                n,
                -1,
            );
        }
    }

    fn prepare_irregular(
        &mut self,
        channel: Channel<'_>,
        q: u32,
        fans: [u32; 4],
        regular: [bool; 4],
    ) {
        let t = channel.topology;
        let level = self.level;
        // Windows of five sectors hold the whole ring of a closed fan of up to five faces: its control points are hull enough.
        let small = |f: u32| t.fans()[f as usize].closed && t.fans()[f as usize].faces <= 5;
        let shallow =
            self.wanted == Sides::Hull && level > 1 && (0..4).all(|c| regular[c] || small(fans[c]));
        for c in 0..4 {
            let reach = if regular[c] || shallow {
                3
            } else {
                level as usize + 1
            };
            self.windows[c].gather(t, channel.points, 4 * q + c as u32, reach);
        }
        if self.wanted > Sides::None {
            for c in 0..4 {
                let d = (c + 1) % 4;
                if regular[c] && regular[d] {
                    let strip = whole_strip(&self.windows[c].near(), 0, &self.windows[d].near(), 1);
                    self.whole_side(t, channel.points, q, c, &strip);
                }
            }
        }
        // Depth 1: refine the four windows; regular corners follow the smooth, crease or corner mask by the same series.
        let mut series: [_; 4] = std::array::from_fn(|c| channel.fans.series(fans[c]));
        for c in 0..4 {
            let v = match &mut series[c] {
                Some(s) => s.step(),
                None => regular_vertex(&self.windows[c], t.fans()[fans[c] as usize].rule),
            };
            self.windows[c].step(v);
            self.near[c] = self.windows[c].near();
        }
        let net = once_refined(&self.near, regular);
        let half = 1_u32 << (level - 1);
        let mut centre_done = false;
        for c in 0..4 {
            let (row, col) = [(0, 0), (0, 1), (1, 1), (1, 0)][c];
            if regular[c] {
                let net = std::array::from_fn(|r| std::array::from_fn(|k| net[row + r][col + k]));
                self.pieces.push(Piece {
                    net,
                    origin: [col as u32 * half, row as u32 * half],
                    size: half,
                    level: level - 1,
                });
                centre_done = true;
            }
        }
        if !centre_done {
            let mut at: Net<4> =
                std::array::from_fn(|r| std::array::from_fn(|k| net[1 + r][1 + k]));
            at[3][3] = P4::ZERO;
            self.pieces.push(Piece {
                net: at,
                origin: [half; 2],
                size: 0,
                level: level - 1,
            });
        }
        if shallow {
            for c in (0..4).filter(|&c| !regular[c]) {
                self.windows[c].each(|p| self.hull.push(p));
            }
            // The points diagonally beyond irregular corners are not set.
            let diagonal = [(0, 0), (0, 4), (4, 4), (4, 0)];
            for (r, row) in net.iter().enumerate() {
                for (k, p) in row.iter().enumerate() {
                    if !(0..4).any(|c| !regular[c] && diagonal[c] == (r, k)) {
                        self.hull.push(*p);
                    }
                }
            }
            return;
        }
        if level == 1 || self.wanted == Sides::None {
            // At level 1 no piece reaches the middle of a side between two irregular corners: a point of its own, without orientation.
            for c in 0..4 {
                if !regular[c] && !regular[(c + 1) % 4] {
                    let full = turn(&net, c);
                    let at = std::array::from_fn(|r| {
                        std::array::from_fn(|k| {
                            if r < 3 && k < 3 {
                                full[r][k + 1]
                            } else {
                                P4::ZERO
                            }
                        })
                    });
                    let origin = [[1, 0], [2, 1], [1, 2], [0, 1]][c];
                    self.pieces.push(Piece {
                        net: at,
                        origin: origin.map(|k| k * half),
                        size: 0,
                        level: level - 1,
                    });
                }
            }
        }
        for c in 0..4 {
            if !regular[c] {
                self.refine_corner(c, &net, series[c], level);
            }
            if self.wanted > Sides::None {
                self.half_sides(t, q, c, regular);
            }
        }
        if self.wanted > Sides::None {
            for c in 0..4 {
                if !(regular[c] && regular[(c + 1) % 4]) && t.twin(4 * q + c as u32) == NONE {
                    self.boundary_side(t, channel.points, q, c);
                }
            }
        }
    }

    /// Regular pieces towards the irregular corner `c`; leaves the corner's windows at depths 1, 2, … in `rings`.
    fn refine_corner(
        &mut self,
        c: usize,
        net: &Net<5>,
        series: Option<super::fan_points::FanSeries>,
        level: u32,
    ) {
        let full = turn(net, c);
        let mut node: Net<4> = std::array::from_fn(|r| std::array::from_fn(|k| full[r][k]));
        self.rings.clear();
        self.rings.push(self.near[c]);
        let Some(mut series) = series else { return };
        let n = 1_u32 << level;
        for depth in 2..=level {
            self.windows[c].step(series.step());
            let ring = self.windows[c].near();
            let next = refine_node(&node, &ring);
            let size = n >> depth;
            for (row, col) in [(0, 1), (1, 1), (1, 0)] {
                let local: Net<4> =
                    std::array::from_fn(|r| std::array::from_fn(|k| next[row + r][col + k]));
                let place = [col as u32 * size, row as u32 * size];
                self.pieces.push(Piece {
                    net: turn_back(&local, c),
                    origin: corner_origin(c, place, size, n),
                    size,
                    level: level - depth,
                });
            }
            node = std::array::from_fn(|r| std::array::from_fn(|k| next[r][k]));
            self.rings.push(ring);
        }
    }

    /// Samples the halves at corner `c` of its two sides, where the side has an irregular end.
    fn half_sides(&mut self, t: &Topology, q: u32, c: usize, regular: [bool; 4]) {
        let n = 1_i64 << self.level;
        for outgoing in [true, false] {
            let side = if outgoing { c } else { (c + 3) % 4 };
            let other = if outgoing { (c + 1) % 4 } else { side };
            if regular[c] && regular[other] {
                continue;
            }
            let (s, so) = if outgoing { (0, 1) } else { (1, 0) };
            let (at, step) = if outgoing { (0, 1) } else { (n, -1) };
            let half = Samples {
                target: self.target,
                level: self.level,
                at,
                step,
                simd: self.simd,
                normals: self.wanted == Sides::Normals,
                part: SamplePart::All,
            };
            // The middle belongs to the half at the lower vertex.
            let middle = (n / 2) as usize;
            let owner = self.runs_forward(t, q, side) == outgoing;
            let out = &mut self.sides[side];
            let kept: [f32; 6] = std::array::from_fn(|k| {
                if k < 3 {
                    out.points[k][middle]
                } else {
                    out.normals[k - 3][middle]
                }
            });
            if regular[c] {
                regular_half(&self.near[c], s, &self.near[other], so, half, out);
            } else {
                irregular_half(&self.rings, s, &self.near[other], so, half, out);
            }
            let other_done = other < c;
            if other_done && !owner {
                out.set(
                    middle,
                    [kept[0], kept[1], kept[2]],
                    [kept[3], kept[4], kept[5]],
                );
            }
        }
    }

    /// Number of blocks along each side of the face.
    #[must_use]
    pub fn blocks_per_side(level: u32) -> u32 {
        1 << level.saturating_sub(5)
    }

    /// Size of every block at a level.
    #[must_use]
    pub fn block_size(level: u32) -> BlockSize {
        let n = (1_usize << level.min(5)) + 1;
        BlockSize { cols: n, rows: n }
    }

    /// Dices block (`bu`, `bv`) of the face.
    pub(crate) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.dice_part(Part::block(self.level, [bu, bv]), points, normals);
    }

    /// Dices a part of the face, which may be of a coarser level. Points have the bits that every other part and level gives them.
    pub(crate) fn dice_part(
        &self,
        part: Part,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let Part {
            level,
            start,
            segments,
        } = part;
        // What the sides write is left out.
        let n = 1_u32 << level;
        let inner = u32::from(self.wanted > Sides::None);
        let range = BlockRange {
            shift: self.level - level,
            start,
            low: start.map(|k| k.max(inner)),
            high: start.map(|k| (k + segments).min(n - inner)),
        };
        dispatch!(
            self.simd,
            dice_pieces(
                &self.pieces,
                self.target,
                range,
                points,
                normals.as_deref_mut()
            )
        );
        if !self.dots.is_empty() {
            self.put_dots(range, points, normals.as_deref_mut());
        }
        if self.wanted > Sides::None && self.level > 0 {
            self.dice_sides(part, points, normals.as_deref_mut());
        }
        if self.refined && self.wanted <= Sides::None && self.level > 0 {
            return;
        }
        for (c, (col, row)) in [(0, 0), (n, 0), (n, n), (0, n)].into_iter().enumerate() {
            if (start[0]..=start[0] + segments).contains(&col)
                && (start[1]..=start[1] + segments).contains(&row)
            {
                let (i, j) = ((col - start[0]) as usize, (row - start[1]) as usize);
                points.set(i, j, self.corners[c].0);
                if let Some(normals) = normals.as_deref_mut() {
                    normals.set(i, j, self.corners[c].1);
                }
            }
        }
    }

    fn dice_sides(&self, part: Part, points: &mut Grid3, mut normals: Option<&mut Grid3>) {
        let n = 1_usize << part.level;
        let shift = self.level - part.level;
        let [u0, v0] = part.start.map(|k| k as usize);
        let m = part.segments as usize;
        debug_assert!(m < BLOCK_POINTS);
        let mut copy = |side: &EdgeSamples, k: usize, i: usize, j: usize| {
            let k = k << shift;
            points.set(i, j, std::array::from_fn(|c| side.points[c][k]));
            if let Some(normals) = normals.as_deref_mut() {
                normals.set(i, j, std::array::from_fn(|c| side.normals[c][k]));
            }
        };
        for i in 0..=m {
            if v0 == 0 {
                copy(&self.sides[0], u0 + i, i, 0);
            }
            if u0 + m == n {
                copy(&self.sides[1], v0 + i, m, i);
            }
            if v0 + m == n {
                copy(&self.sides[2], n - u0 - i, i, m);
            }
            if u0 == 0 {
                copy(&self.sides[3], n - v0 - i, 0, i);
            }
        }
    }

    /// Samples of side `c` at the level that was prepared, ends included; sides must have been wanted.
    pub(crate) fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        points.clear();
        normals.clear();
        let (first, last) = (self.corners[c], self.corners[(c + 1) % 4]);
        let side = &self.sides[c];
        points.push(first.0);
        normals.push(first.1);
        for k in 1..1 << self.level {
            points.push([0, 1, 2].map(|i| side.points[i][k]));
            normals.push([0, 1, 2].map(|i| side.normals[i][k]));
        }
        points.push(last.0);
        normals.push(last.1);
    }

    /// Points whose convex hull holds the whole diced face, but for rounding.
    pub(crate) fn hull(&self, mut out: impl FnMut([f32; 3])) {
        for piece in &self.pieces {
            piece.hull(self.target, [0.0, 1.0], [0.0, 1.0], &mut out);
        }
        self.hull.iter().for_each(|p| out(p.xyz()));
        self.dots.iter().for_each(|d| out(d.point));
        self.corners.iter().for_each(|c| out(c.0));
    }

    /// The same for one block.
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.part_hull(Part::block(self.level, [bu, bv]), out);
    }

    /// The same for a part.
    pub(crate) fn part_hull(&self, part: Part, mut out: impl FnMut([f32; 3])) {
        let shift = self.level - part.level;
        let segments = part.segments << shift;
        let n = 1_u32 << self.level;
        let start = part.start.map(|k| k << shift);
        for piece in &self.pieces {
            let range = |k: usize| {
                let lo = piece.origin[k].max(start[k]);
                let hi = (piece.origin[k] + piece.size).min(start[k] + segments);
                let scale = 1.0 / piece.size.max(1) as f32;
                (lo <= hi).then(|| {
                    [
                        (lo - piece.origin[k]) as f32 * scale,
                        (hi - piece.origin[k]) as f32 * scale,
                    ]
                })
            };
            if let (Some(u), Some(v)) = (range(0), range(1)) {
                piece.hull(self.target, u, v, &mut out);
            }
        }
        let end = start.map(|k| k + segments);
        let inside = self.dots.iter().filter(|d| d.is_in(start, end));
        inside.for_each(|d| out(d.point));
        for (c, (col, row)) in [(0, 0), (n, 0), (n, n), (0, n)].into_iter().enumerate() {
            if (start[0]..=start[0] + segments).contains(&col)
                && (start[1]..=start[1] + segments).contains(&row)
            {
                out(self.corners[c].0);
            }
        }
    }
}
