//! One triangle of the control mesh, ready to be diced.
//!
//! A triangle with three regular corners is one quartic piece. Any other is split once in four, of which the middle one is always
//! regular; around each irregular corner the split goes on towards the corner, and every step leaves three regular pieces behind. The
//! sides come from the edges' own rule, the corners from their fans. Several control triangles can be put into one grid
//! ([`TrianglePatch::append`]): those of deeper levels, where creases are refined away first.

use super::super::basis::Target;
use super::super::edge::{EdgeSamples, SamplePart, Samples, sample_boundary};
use super::super::face::{DiceFault, Part, Sides};
use super::super::point::P4;
use super::fans::TriangleFans;
use super::lattice::Lattice;
use super::piece::{BlockRange, Piece, Range, hold};
use super::place::Place;
use super::ring::{Hexagon, Near, Window, is_regular, next, prev};
use super::side::{Strip, irregular_half, regular_half};
use super::tensor::Net12;
use crate::dispatch;
use crate::records::Grid3;
use crate::simd::Level;
use crate::topology::{FanRule, NONE, Ring, Topology};

/// Control data of one channel (positions, or texture coordinates as points) of a mesh of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleChannel<'a> {
    pub(crate) topology: &'a Topology,
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) fans: &'a TriangleFans,
}

/// Where the samples of a control triangle's side go: along which side of the face, and its first sample and step there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SidePlace {
    pub(crate) side: usize,
    pub(crate) at: i64,
    pub(crate) step: i64,
}

impl SidePlace {
    /// The side of the face itself.
    pub(crate) fn whole(side: usize) -> Self {
        Self {
            side,
            at: 0,
            step: 1,
        }
    }
}

/// A grid point that no piece knows better: the corner of a control triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dot {
    pub(super) place: [i32; 2],
    pub(super) point: [f32; 3],
    pub(super) normal: [f32; 3],
}

/// A triangle prepared for dicing at one level, with buffers that are used again for the next one.
#[derive(Clone, Debug)]
pub(crate) struct TrianglePatch {
    level: u32,
    target: Target,
    wanted: Sides,
    pub(super) pieces: Vec<Piece>,
    pub(super) dots: Vec<Dot>,
    pub(super) sides: [EdgeSamples; 3],
    /// Control points that no piece stands for, in hulls only.
    pub(super) hull: Vec<P4>,
    /// Rings of the regular corners of the triangle in work, before and after one step.
    hexagons: [[Hexagon; 2]; 3],
    windows: [Window; 3],
    /// Rings of every corner after 1, 2, … steps, relative to the corner's base.
    rings: [Vec<Near>; 3],
    /// Whether no control levels below are asked.
    pub(super) is_plain: bool,
    pub(crate) fault: DiceFault,
    /// Vector instructions; never changes a bit.
    pub(crate) simd: Level,
}

impl Default for TrianglePatch {
    fn default() -> Self {
        Self {
            level: 0,
            target: Target::Limit,
            wanted: Sides::Hull,
            pieces: Vec::new(),
            dots: Vec::new(),
            sides: Default::default(),
            hull: Vec::new(),
            hexagons: [[Hexagon::EMPTY; 2]; 3],
            windows: [const { Window::EMPTY }; 3],
            rings: Default::default(),
            is_plain: false,
            fault: DiceFault::None,
            simd: Level::SCALAR,
        }
    }
}

impl TrianglePatch {
    /// Prepares triangle `face` at `level`. Without `sides` (texture coordinates) all points come from the pieces.
    #[cfg(test)]
    pub(crate) fn prepare(
        &mut self,
        channel: TriangleChannel<'_>,
        face: u32,
        target: Target,
        level: u32,
        sides: Sides,
    ) {
        self.begin(target, level, sides);
        let whole = [0, 1, 2].map(|c| Some(SidePlace::whole(c)));
        self.append(channel, face, level, Place::root(1 << level), whole);
    }

    /// The control points of a face that is one piece: rows of 3, 4, 3 and 2 of the lattice whose first row lies beyond side 0.
    pub(crate) fn spline(&self) -> Option<[[f32; 3]; 12]> {
        match &self.pieces[..] {
            [piece] if self.is_plain && self.hull.is_empty() => piece.whole_net(),
            _ => None,
        }
    }

    /// Whether its sides follow from the rings of their ends: no control levels below are asked.
    pub(crate) fn has_plain_sides(&self) -> bool {
        self.is_plain
    }

    /// Starts an empty grid of `2^level` segments, to be filled by [`TrianglePatch::append`].
    pub(crate) fn begin(&mut self, target: Target, level: u32, sides: Sides) {
        self.level = level;
        self.target = target;
        self.wanted = sides;
        self.pieces.clear();
        self.dots.clear();
        self.hull.clear();
        if sides > Sides::None && level > 0 {
            for side in &mut self.sides {
                side.resize(1 << level);
            }
        }
    }

    /// Puts control triangle `face` of `channel` into the grid, `level` steps (and `2^level` segments) deep, at `place`; and along
    /// those of its sides that lie on sides of the face, the samples by the edges' own rule.
    pub(crate) fn append(
        &mut self,
        channel: TriangleChannel<'_>,
        face: u32,
        level: u32,
        place: Place,
        sides: [Option<SidePlace>; 3],
    ) {
        let fans = [0, 1, 2].map(|c| channel.topology.fan(3 * face + c));
        let mut corner = place;
        for fan in fans {
            let normal = channel.fans.normals.get(fan as usize);
            self.dots.push(Dot {
                place: corner.origin,
                point: channel.fans.limits[fan as usize],
                normal: normal.copied().unwrap_or([0.0; 3]),
            });
            corner = corner.turned();
        }
        if level == 0 {
            return;
        }
        let work = Work {
            channel,
            face,
            level,
            place,
            fans,
            regular: fans.map(|f| is_regular(&channel.topology.fans()[f as usize])),
        };
        let shallow = self.append_pieces(&work);
        if self.wanted > Sides::None && !shallow {
            for (c, to) in sides.into_iter().enumerate() {
                if let Some(to) = to {
                    self.append_side(&work, c, to);
                }
            }
        }
    }

    /// The pieces of a control triangle; whether they only stand for a hull.
    fn append_pieces(&mut self, work: &Work<'_>) -> bool {
        let (t, points) = (work.channel.topology, work.channel.points);
        for c in 0..3 {
            if work.regular[c] {
                let ring = Hexagon::gather(t, points, work.half(c));
                self.hexagons[c][0] = ring;
            }
        }
        if work.regular == [true; 3] {
            let net = regular_net(&self.hexagons);
            let piece = Piece::new(net, P4::ZERO, work.place, work.level);
            self.pieces.push(piece);
            return false;
        }
        let shallow = self.wanted == Sides::Hull
            && work.level > 1
            && (0..3).all(|c| work.regular[c] || self.gather_small(work, c));
        let mut series = work.fans.map(|f| work.channel.fans.series(f));
        let bases = work.bases();
        for c in 0..3 {
            self.rings[c].clear();
            let near = match &mut series[c] {
                Some(series) => {
                    if !shallow {
                        let reach = work.level as usize + 1;
                        self.windows[c].gather(t, points, work.half(c), reach, bases[c]);
                    }
                    self.windows[c].step(series.step());
                    self.windows[c].near()
                }
                None => {
                    self.hexagons[c][1] = self.hexagons[c][0].refined();
                    self.hexagons[c][1].near()
                }
            };
            self.rings[c].push(near);
        }
        let hexagons = &self.hexagons;
        let lattice = Lattice::around(
            &[0, 1, 2].map(|c| self.rings[c][0].moved(bases[c])),
            [0, 1, 2].map(|c| work.regular[c].then_some(&hexagons[c][1])),
        );
        for c in 0..4 {
            if c == 3 || work.regular[c] {
                let place = work.place.child(c);
                let piece = Piece::new(lattice.child(c), P4::ZERO, place, work.level - 1);
                self.pieces.push(piece);
            }
        }
        if shallow {
            for c in (0..3).filter(|&c| !work.regular[c]) {
                self.windows[c].each(|p| self.hull.push(p + bases[c]));
                lattice.each_around(c, |p| self.hull.push(p));
            }
            return true;
        }
        let mut place = work.place;
        for c in 0..3 {
            if let Some(series) = &mut series[c] {
                let base = bases[c];
                let mut node = lattice.towards(c, base, &self.rings[c][0]);
                let mut at = place.child(0);
                for depth in 2..=work.level {
                    self.windows[c].step(series.step());
                    let near = self.windows[c].near();
                    self.rings[c].push(near);
                    node = node.deeper(&near);
                    for k in 1..4 {
                        let level = work.level - depth;
                        let piece = Piece::new(node.child(k), base, at.child(k), level);
                        self.pieces.push(piece);
                    }
                    at = at.child(0);
                }
            }
            place = place.turned();
        }
        false
    }

    /// Gathers a window that holds the whole ring of corner `c`, if that is small.
    fn gather_small(&mut self, work: &Work<'_>, c: usize) -> bool {
        let (t, points) = (work.channel.topology, work.channel.points);
        // One sector more than the ring at both ends, for the step.
        let base = work.bases()[c];
        self.windows[c].gather(t, points, work.half(c), 5, base);
        let mut after = self.windows[c].clone();
        after.step(P4::ZERO);
        after.holds(&t.fans()[work.fans[c] as usize])
    }

    /// Samples side `c` of a control triangle whose pieces were appended last.
    fn append_side(&mut self, work: &Work<'_>, c: usize, to: SidePlace) {
        let t = work.channel.topology;
        let n = 1_i64 << work.level;
        let d = (c + 1) % 3;
        let forward = self.runs_forward(t, work.half(c));
        let ahead = Samples {
            target: self.target,
            level: work.level,
            at: to.at,
            step: to.step,
            simd: self.simd,
            normals: self.wanted == Sides::Normals,
            part: SamplePart::All,
        };
        let back = Samples {
            at: to.at + n * to.step,
            step: -to.step,
            ..ahead
        };
        let out = &mut self.sides[to.side];
        if work.regular[c] && work.regular[d] {
            let strip = Strip::whole(&self.hexagons[c][0], 0, &self.hexagons[d][0], 1);
            if forward {
                strip.sample(ahead, out);
            } else {
                strip.reversed().sample(back, out);
            }
        } else {
            // The middle belongs to the half at the lower vertex, which is written last.
            let halves = [(c, 0_u8, d, ahead), (d, 1, c, back)];
            let order = if forward { [1, 0] } else { [0, 1] };
            let bases = work.bases();
            for (a, s, b, half) in order.map(|k: usize| halves[k]) {
                let far = self.rings[b][0].moved(bases[b]);
                let (sa, sb) = (i32::from(s), i32::from(1 - s));
                if work.regular[a] {
                    let ring = &self.hexagons[a][1];
                    regular_half(ring, usize::from(s), &far, sb, half, out);
                } else {
                    irregular_half(&self.rings[a], bases[a], sa, &far, sb, half, out);
                }
            }
        }
        if t.twin(work.half(c)) == NONE {
            let (target, level) = (self.target, work.level);
            let [before, a, b, after] = boundary_polygon(t, work.channel.points, work.half(c));
            if forward {
                sample_boundary([before, a, b, after], target, level, out, to.at, to.step);
            } else {
                let polygon = [after, b, a, before];
                sample_boundary(polygon, target, level, out, back.at, back.step);
            }
        }
        // The ends are the business of their fans.
        let fans = work.channel.fans;
        for (fan, k) in [(work.fans[c], to.at), (work.fans[d], back.at)] {
            let normal = fans.normals.get(fan as usize).copied();
            out.set(
                k as usize,
                fans.limits[fan as usize],
                normal.unwrap_or([0.0; 3]),
            );
        }
    }

    /// Whether half-edge `h` runs along its edge's canonical direction, from the lower to the higher vertex number.
    fn runs_forward(&self, t: &Topology, h: u32) -> bool {
        self.fault == DiceFault::OwnDirection || t.vertex(h) < t.vertex(next(h))
    }

    /// Dices block (`bu`, `bv`), of the size of a quad's blocks; `bv` is at most `bu`.
    pub(crate) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.dice_part(Part::block(self.level, [bu, bv]), points, normals);
    }

    /// Dices a part of the face, which may be of a coarser level and has an area. Points have the bits that every other part of the face,
    /// as it is prepared, gives them.
    pub(crate) fn dice_part(
        &self,
        part: Part,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let (m, start) = (part.segments as i32, part.start.map(|k| k as i32));
        let shift = self.level - part.level;
        let block = BlockRange {
            shift,
            range: Range {
                low: start,
                high: start.map(|k| k + m),
            },
        };
        dispatch!(
            self.simd,
            dice_pieces(
                &self.pieces,
                self.target,
                block,
                points,
                normals.as_deref_mut()
            )
        );
        let between = (1 << shift) - 1;
        for dot in &self.dots {
            let [i, j] = [0, 1].map(|k| (dot.place[k] >> shift) - start[k]);
            let on_grid = (dot.place[0] | dot.place[1]) & between == 0;
            if on_grid && (0..=m).contains(&i) && (0..=m).contains(&j) {
                points.set(i as usize, j as usize, dot.point);
                if let Some(normals) = normals.as_deref_mut() {
                    normals.set(i as usize, j as usize, dot.normal);
                }
            }
        }
        // Last, so that nothing but the edges' own rules shows on the sides.
        if self.wanted > Sides::None && self.level > 0 {
            self.dice_sides(part, points, normals.as_deref_mut());
        }
        if start[0] == start[1] {
            fold(points, m as usize);
            if let Some(normals) = normals {
                fold(normals, m as usize);
            }
        }
    }

    fn dice_sides(&self, part: Part, points: &mut Grid3, mut normals: Option<&mut Grid3>) {
        let n = 1_usize << part.level;
        let shift = self.level - part.level;
        let (m, start) = (part.segments as usize, part.start.map(|k| k as usize));
        let mut copy = |side: &EdgeSamples, k: usize, i: usize, j: usize| {
            let k = k << shift;
            points.set(i, j, [0, 1, 2].map(|c| side.points[c][k]));
            if let Some(normals) = normals.as_deref_mut() {
                normals.set(i, j, [0, 1, 2].map(|c| side.normals[c][k]));
            }
        };
        for i in 0..=m {
            if start[1] == 0 {
                copy(&self.sides[0], start[0] + i, i, 0);
            }
            if start[0] + m == n {
                copy(&self.sides[1], start[1] + i, m, i);
            }
            if start[0] == start[1] {
                copy(&self.sides[2], n - start[0] - i, i, i);
            }
        }
        // A block beside the diagonal touches it with one corner.
        if start[0] == start[1] + m {
            copy(&self.sides[2], n - start[0], 0, m);
        }
    }

    /// Samples of side `c` at the level that was prepared, at least 1, ends included; sides must have been wanted.
    pub(crate) fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        points.clear();
        normals.clear();
        let side = &self.sides[c];
        for k in 0..=1_usize << self.level {
            points.push([0, 1, 2].map(|i| side.points[i][k]));
            normals.push([0, 1, 2].map(|i| side.normals[i][k]));
        }
    }

    /// Points whose convex hull holds the whole diced face, but for rounding.
    pub(crate) fn hull(&self, mut out: impl FnMut([f32; 3])) {
        for piece in &self.pieces {
            piece.hull(self.target, &mut out);
        }
        self.hull.iter().for_each(|p| out(p.xyz()));
        self.dots.iter().for_each(|d| out(d.point));
    }

    /// The same for one block; needs pieces, that is, other sides than [`Sides::Hull`].
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.part_hull(Part::block(self.level, [bu, bv]), out);
    }

    /// Grid points of a part.
    fn range(&self, part: Part) -> Range {
        let shift = self.level - part.level;
        let low = part.start.map(|k| (k << shift) as i32);
        Range {
            low,
            high: low.map(|k| k + (part.segments << shift) as i32),
        }
    }

    /// Bounds of the unit normals at the grid points of a part: the least and greatest components, if they are known.
    pub(crate) fn part_normals(&self, part: Part) -> Option<[[f32; 3]; 2]> {
        let range = self.range(part);
        if self.target != Target::Limit || !self.hull.is_empty() {
            return None;
        }
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for piece in &self.pieces {
            if let Some(found) = piece.normals_within(range) {
                let [low, high] = found?;
                hold(&mut bounds, low);
                hold(&mut bounds, high);
            }
        }
        self.dots_in(range)
            .for_each(|d| hold(&mut bounds, d.normal));
        (bounds[0][0] <= bounds[1][0]).then_some(bounds)
    }

    fn dots_in(&self, range: Range) -> impl Iterator<Item = &Dot> {
        self.dots.iter().filter(move |dot| {
            (0..2).all(|k| (range.low[k]..=range.high[k]).contains(&dot.place[k]))
        })
    }

    /// The same for a part.
    pub(crate) fn part_hull(&self, part: Part, mut out: impl FnMut([f32; 3])) {
        let range = self.range(part);
        for piece in &self.pieces {
            piece.hull_within(self.target, range, &mut out);
        }
        self.hull.iter().for_each(|p| out(p.xyz()));
        self.dots_in(range).for_each(|d| out(d.point));
    }
}

/// A control triangle being prepared.
struct Work<'a> {
    channel: TriangleChannel<'a>,
    face: u32,
    level: u32,
    place: Place,
    fans: [u32; 3],
    regular: [bool; 3],
}

impl Work<'_> {
    fn half(&self, c: usize) -> u32 {
        3 * self.face + c as u32
    }

    /// What the rings of irregular corners are relative to; zero at regular ones.
    fn bases(&self) -> [P4; 3] {
        self.fans
            .map(|f| self.channel.fans.series(f).map_or(P4::ZERO, |s| s.base))
    }
}

/// The net of a triangle with three regular corners, from their rings.
fn regular_net(rings: &[[Hexagon; 2]; 3]) -> Net12 {
    // Corner 0 and its ring; what is next to side 1 comes from the others.
    let [a, b, c] = [0, 1, 2].map(|k| &rings[k][0]);
    [
        a.e[4], a.e[5], b.e[3], a.e[3], a.v, a.e[0], b.e[4], a.e[2], a.e[1], b.e[5], c.e[4], c.e[3],
    ]
}

/// The boundary polygon around half-edge `h`: before it, its two ends, after it.
fn boundary_polygon(t: &Topology, points: &[[f32; 3]], h: u32) -> [P4; 4] {
    let at = |g: u32| P4::new(points[t.vertex(g) as usize]);
    let (a, b) = (at(h), at(next(h)));
    let rule = |g: u32| t.fans()[t.fan(g) as usize].rule;
    let before = if rule(h) == FanRule::Corner {
        P4::beyond(a, b)
    } else {
        Ring::from_half(t, h).last().map_or(a, |g| at(prev(g)))
    };
    let after = if rule(next(h)) == FanRule::Corner {
        P4::beyond(b, a)
    } else {
        at(next(t.fans()[t.fan(next(h)) as usize].first))
    };
    [before, a, b, after]
}

#[inline(always)]
fn dice_pieces(
    pieces: &[Piece],
    target: Target,
    block: BlockRange,
    points: &mut Grid3,
    mut normals: Option<&mut Grid3>,
) {
    // The widest last: where pieces meet it is seen, as on quads, whichever points of the smaller ones are on the grid.
    for piece in pieces.iter().rev() {
        piece.dice(target, block, points, normals.as_deref_mut());
    }
}

/// Folds what lies above the diagonal onto it, so that no triangle there has an area.
fn fold(grid: &mut Grid3, m: usize) {
    for j in 1..=m {
        let p = grid.get(j, j);
        (0..j).for_each(|i| grid.set(i, j, p));
    }
}
