//! One quad of the control mesh, ready to be diced: gathered from its ear stencil and nothing else.
//!
//! A quad with four regular corners is one bicubic B-spline. Any other is split once; around each irregular corner the split goes on
//! towards the corner, and every step leaves three splines behind (after Stam, *Exact evaluation of Catmull-Clark subdivision
//! surfaces at arbitrary parameter values*, 1998, with the refinement itself in place of its eigenvectors, so that any boundary or
//! valence works alike). The sides come from the edges' own rule, the corners from their fans.

use super::basis::Target;
use super::control::{Descend, Dot, Owner, is_refined};
use super::edge::EdgeSamples;
use super::fan_points::{FanPoints, FanSeries};
use super::net::{
    Net, corner_origin, fill_phantoms, gather_net, once_refined, open_sides, put_corner,
    refine_node, turn, turn_back,
};
use super::plan::Plan;
use super::point::P4;
use super::regular::{BlockRange, dice_sheets};
use super::sheet::{HIGH, Sheet, Sheets};
use super::window::Window;
use crate::dispatch;
use crate::records::{BlockSize, Grid3};
use crate::simd::Level;
use crate::topology::Topology;

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

    /// Row or column of the part that lies on side `c` of the face.
    #[inline(always)]
    pub(super) fn side(&self, c: usize) -> Option<usize> {
        let start = self.start[1 - (c & 1)];
        match c == 1 || c == 2 {
            true => (start + self.segments == 1 << self.level).then_some(self.segments as usize),
            false => (start == 0).then_some(0),
        }
    }
}

/// A quad prepared for dicing at one level, with buffers that are used again for the next quad.
#[derive(Clone, Debug)]
pub struct FacePatch {
    pub(super) level: u32,
    pub(super) target: Target,
    pub(super) sheets: Sheets,
    /// Points between the splines of a quad with deeper levels.
    pub(super) dots: Vec<Dot>,
    pub(super) owner: Option<Box<Owner>>,
    /// Whether the corners are among the dots.
    pub(super) refined: bool,
    /// Sides of a quad with deeper levels.
    pub(super) sides: [EdgeSamples; 4],
    pub(super) corners: [([f32; 3], [f32; 3]); 4],
    /// Control points around a quad that is not one spline; what lies beyond irregular corners is not set.
    pub(super) whole_net: Net<5>,
    /// Sides that are one strip of `whole_net`, bit by bit.
    pub(super) whole: u8,
    /// Polygons of the curves of sides on a boundary, in the direction in which u or v grows.
    pub(super) polygons: [Option<[P4; 4]>; 4],
    /// Per side with an irregular end, whether its middle is that of the half at the high end of u or v, and whether that end is regular.
    pub(super) middles: [[bool; 2]; 4],
    windows: [Window; 4],
    pub(super) wanted: Sides,
    /// Which corners are regular, bit by bit, of faces without deeper levels.
    pub(super) regular: Option<u8>,
    /// Control points that no spline stands for, in hulls only.
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
            sheets: Sheets::default(),
            dots: Vec::new(),
            owner: None,
            refined: false,
            sides: Default::default(),
            corners: Default::default(),
            whole_net: [[P4::ZERO; 5]; 5],
            whole: 0,
            polygons: [None; 4],
            middles: [[false; 2]; 4],
            windows: [const { Window::EMPTY }; 4],
            wanted: Sides::Hull,
            regular: None,
            hull: Vec::new(),
            fault: DiceFault::None,
            simd: Level::SCALAR,
        }
    }
}

impl FacePatch {
    /// Prepares quad `q` at `level`. Without `sides` (texture coordinates) all points come from the splines.
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
        if self.refined {
            self.regular = None;
        }
    }

    /// Empties the buffers for the next quad.
    pub(super) fn begin(&mut self, level: u32, target: Target, sides: Sides) {
        self.level = level;
        self.target = target;
        self.wanted = sides;
        self.regular = None;
        self.sheets.clear();
        self.dots.clear();
        self.hull.clear();
        self.polygons = [None; 4];
    }

    /// Adds the splines of a quad whose fans' rules hold, and what its sides need.
    pub(super) fn prepare_patch(&mut self, channel: Channel<'_>, q: u32) {
        let t = channel.topology;
        let fans: [u32; 4] = std::array::from_fn(|c| t.fan(4 * q + c as u32));
        let regular = fans.map(|f| t.fans()[f as usize].is_regular());
        if regular == [true; 4] {
            self.whole = 0b1111;
            self.regular = Some(0b1111);
            let sheet = self.sheets.add();
            gather_net(t, channel.points, q, &mut sheet.net);
            sheet.be_whole(self.level);
        } else {
            gather_net(t, channel.points, q, &mut self.whole_net);
            self.prepare_irregular(channel, q, fans, regular);
        }
        if self.wanted > Sides::None {
            self.prepare_polygons(t, channel.points, q);
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
        self.whole = 0;
        for c in 0..4 {
            self.whole |= u8::from(regular[c] && regular[(c + 1) % 4]) << c;
            self.middles[c] = self.middle(t, q, c, regular);
        }
        // Depth 1, then on towards each irregular corner.
        let open = open_sides(t, q);
        let rules = fans.map(|f| t.fans()[f as usize].rule);
        let half = 1_u32 << (level - 1);
        let mask = (0..4).fold(0, |mask, c| mask | u8::from(regular[c]) << c);
        self.regular = Some(mask);
        let number = self.sheets.len();
        let first = self.sheets.add();
        let net = &mut first.net;
        once_refined(&self.whole_net, open, rules, net);
        let mut corners = [const { None }; 4];
        for c in (0..4).filter(|&c| !regular[c]) {
            let reach = if shallow { 3 } else { level as usize + 1 };
            self.windows[c].gather(t, channel.points, 4 * q + c as u32, reach);
            let mut series = channel.fans.series(fans[c]);
            if let Some(series) = &mut series {
                self.windows[c].step(series.step());
            }
            put_corner(net, c, &self.windows[c].near(), false);
            if shallow {
                let hull = &mut self.hull;
                self.windows[c].each(|p| hull.push(p));
            }
            corners[c] = series;
        }
        fill_phantoms(net, 4, open);
        first.origin = [0; 2];
        first.size = half;
        first.level = level - 1;
        first.corner = 0;
        first.present = mask;
        first.own = [[0; 2], [2 * half; 2]];
        if mask == 0 {
            let at = |r: usize, k: usize| match (r, k) {
                (3, 3) => P4::ZERO,
                _ => net[1 + r][1 + k],
            };
            let at: Net<4> = std::array::from_fn(|r| std::array::from_fn(|k| at(r, k)));
            self.add_point(&at, [half; 2]);
        }
        if shallow {
            // The points diagonally beyond irregular corners are not set.
            let diagonal = [(0, 0), (0, 4), (4, 4), (4, 0)];
            for (r, row) in self.sheets[number].net.iter().enumerate() {
                for (k, p) in row.iter().enumerate() {
                    if !(0..4).any(|c| !regular[c] && diagonal[c] == (r, k)) {
                        self.hull.push(*p);
                    }
                }
            }
            return;
        }
        if level == 1 || self.wanted == Sides::None {
            self.middle_dots(number, regular);
        }
        for c in 0..4 {
            if let Some(series) = corners[c] {
                self.refine_corner(c, number, regular, series);
            }
        }
    }

    /// Adds a spline of which only the first corner is seen, in the middle of the face or of a side.
    fn add_point(&mut self, net: &Net<4>, origin: [u32; 2]) {
        let sheet = self.sheets.add();
        for (to, from) in sheet.net.iter_mut().zip(net) {
            to[..4].copy_from_slice(from);
        }
        sheet.be_single(origin, 0, self.level - 1);
    }

    /// Adds the middles of sides between two irregular corners, which no spline reaches; `first` is the widest sheet.
    fn middle_dots(&mut self, first: usize, regular: [bool; 4]) {
        let half = 1_u32 << (self.level - 1);
        for c in (0..4).filter(|&c| !regular[c] && !regular[(c + 1) % 4]) {
            // Without orientation: one point.
            let full = turn(&self.sheets[first].net, c);
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
            self.add_point(&at, origin.map(|k| k * half));
        }
    }

    /// Sheets towards the irregular corner `c`; `first` is the widest sheet.
    fn refine_corner(&mut self, c: usize, first: usize, regular: [bool; 4], mut series: FanSeries) {
        let level = self.level;
        if level < 2 {
            return;
        }
        let full = turn(&self.sheets[first].net, c);
        let mut node: Net<4> = std::array::from_fn(|r| std::array::from_fn(|k| full[r][k]));
        let n = 1_u32 << level;
        for depth in 2..=level {
            self.windows[c].step(series.step());
            let next = refine_node(&node, &self.windows[c].near());
            let size = n >> depth;
            let origin = corner_origin(c, [0, 0], 2 * size, n);
            // The lines away from the corner are also those of wider sheets, or at first of the other corners'.
            let (mut low, mut high) = (origin, origin.map(|k| k + 2 * size));
            for (k, other) in [c ^ 1, 3 - c].into_iter().enumerate() {
                if depth == 2 && !regular[other] && c < other {
                    continue;
                }
                if HIGH[c][k] {
                    low[k] += 1;
                } else {
                    high[k] -= 1;
                }
            }
            let sheet = self.sheets.add();
            turn_back(&next, c, &mut sheet.net);
            sheet.origin = origin;
            sheet.size = size;
            sheet.level = level - depth;
            sheet.corner = c;
            sheet.present = 0b1111 & !(1 << c);
            sheet.own = [low, high];
            node = std::array::from_fn(|r| std::array::from_fn(|k| next[r][k]));
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

    /// The same where only rows from the first to the last of `rows` are wanted; the others keep what they hold, but for the sides.
    pub(crate) fn dice_rows(
        &self,
        [bu, bv]: [u32; 2],
        rows: [u32; 2],
        points: &mut Grid3,
        normals: &mut Grid3,
    ) {
        let part = Part::block(self.level, [bu, bv]);
        self.dice_rows_of(part, rows, points, Some(normals));
    }

    /// Dices a part of the face, which may be of a coarser level. Points have the bits that every other part and level gives them.
    pub(crate) fn dice_part(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.dice_rows_of(part, [0, part.segments], points, normals);
    }

    fn dice_rows_of(
        &self,
        part: Part,
        rows: [u32; 2],
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let Part {
            level,
            start,
            segments,
        } = part;
        let n = 1_u32 << level;
        // What the sides write is left out.
        let inner = u32::from(self.wanted > Sides::None);
        let range = BlockRange {
            shift: self.level - level,
            start,
            end: start[0] + segments,
            low: [start[0], start[1] + rows[0]].map(|k| k.max(inner)),
            high: [start[0] + segments, start[1] + rows[1]].map(|k| k.min(n - inner)),
        };
        let whole = level == self.level && segments == n && rows == [0, n];
        let plan = if whole { self.plan(part, range) } else { None };
        if let Some(plan) = plan {
            dispatch!(
                self.simd,
                self.dice_planned(plan, points, normals.as_deref_mut())
            );
        } else {
            dispatch!(
                self.simd,
                dice_sheets(
                    &self.sheets,
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

    #[inline(always)]
    fn dice_planned(&self, plan: &Plan, points: &mut Grid3, mut normals: Option<&mut Grid3>) {
        plan.dice(&self.sheets, self.target, points, normals.as_deref_mut());
        if self.wanted > Sides::None {
            self.put_planned(plan, points, normals);
        }
    }

    /// The control points of a face that is one B-spline, row by row.
    pub(crate) fn spline(&self) -> Option<[[[f32; 3]; 4]; 4]> {
        let [sheet] = &self.sheets[..] else {
            return None;
        };
        let whole = !self.refined && self.dots.is_empty() && sheet.level == self.level;
        let row = |j: usize| std::array::from_fn(|i| sheet.net[j][i].xyz());
        whole.then(|| std::array::from_fn(row))
    }

    /// Whether its sides follow from the rings of their ends: no control levels below are asked.
    pub(crate) fn has_plain_sides(&self) -> bool {
        !self.refined
    }

    /// Points whose convex hull holds the whole diced face, but for rounding.
    pub(crate) fn hull(&self, mut out: impl FnMut([f32; 3])) {
        for quadrant in self.sheets.iter().flat_map(Sheet::quadrants) {
            let end = if quadrant.sheet.size > 0 { 1.0 } else { 0.0 };
            quadrant.hull(self.target, [0.0, end], [0.0, end], &mut out);
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
        let end = start.map(|k| k + segments);
        for quadrant in self.sheets.iter().flat_map(Sheet::quadrants) {
            quadrant.part_hull(self.target, [start, end], &mut out);
        }
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
