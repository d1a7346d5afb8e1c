//! The four sides of a quad: which strips they are made of, and where their samples go.

use super::edge::{GridLine, PointLine, Put, SideRange, Span, Strip, sample_polygon};
use super::face::{DiceFault, FacePatch, Part, Sides};
use super::plan::{Case, Plan, PlannedStrip};
use super::point::P4;
use super::regular::BlockRange;
use super::sheet::HIGH;
use crate::dispatch;
use crate::records::Grid3;
use crate::topology::{FanRule, NONE, Ring, Topology};

impl FacePatch {
    /// Whether the middle of side `c` belongs to its half at the high end of u or v, which is that at the lower vertex number; and whether
    /// that end is regular.
    pub(super) fn middle(&self, t: &Topology, q: u32, c: usize, regular: [bool; 4]) -> [bool; 2] {
        let h = 4 * q + c as u32;
        let forward = self.fault == DiceFault::OwnDirection
            || t.vertex(h) < t.vertex((h & !3) | ((h + 1) & 3));
        let owner = if forward { c } else { (c + 1) % 4 };
        // Sides 2 and 3 run against u and v.
        [forward == (c >= 2), regular[owner]]
    }

    /// Polygons of the boundary curves of quad `q`.
    pub(super) fn prepare_polygons(&mut self, t: &Topology, points: &[[f32; 3]], q: u32) {
        let at = |g: u32| P4::new(points[t.vertex(g) as usize]);
        for c in 0..4 {
            let h = 4 * q + c as u32;
            if t.twin(h) != NONE {
                continue;
            }
            let next = t.next(h);
            let (a, b) = (at(h), at(next));
            let before = if t.fans()[t.fan(h) as usize].rule == FanRule::Corner {
                P4::beyond(a, b)
            } else {
                Ring::from_half(t, h).last().map_or(a, |g| at(t.prev(g)))
            };
            let end = t.fans()[t.fan(next) as usize];
            let after = if end.rule == FanRule::Corner {
                P4::beyond(b, a)
            } else {
                at(t.next(end.first))
            };
            let mut polygon = [before, a, b, after];
            if c >= 2 {
                polygon.reverse();
            }
            self.polygons[c] = Some(polygon);
        }
    }

    /// Where strip `k` of side `c` begins, if there is one: in which sheet and where in its net, or in that of the whole face. The last place of
    /// a strip that it does not show belongs to the strip before, or to a corner, or is the middle.
    #[inline(always)]
    fn strip(&self, c: usize, k: usize) -> Option<(Option<usize>, [usize; 2], Span)> {
        if self.whole >> c & 1 != 0 {
            let span = Span {
                first: 0,
                level: self.level,
                own: [0, (1 << self.level) - 1],
            };
            // A face that is one spline keeps its net there.
            let sheet = (self.whole == 0b1111).then_some(0);
            return (k == 0).then_some((sheet, [0, 0], span));
        }
        // The first sheet has a spline at every regular corner; the others lead to their own, with splines before and after it.
        let sheet = self.sheets.get(k / 2)?;
        let ends = [c, (c + 1) & 3];
        let (end, other) = (ends[k & 1], ends[1 - (k & 1)]);
        let quadrant = if k < 2 { end } else { other };
        let leads = k < 2 || sheet.corner == end && sheet.size > 0;
        if !(leads && sheet.has(quadrant)) {
            return None;
        }
        let (at, origin) = sheet.place(quadrant);
        let first = origin[c & 1];
        let own = match HIGH[end][c & 1] {
            true => [first + 1, first + sheet.size],
            false => [first, first + sheet.size - 1],
        };
        let span = Span {
            first,
            level: sheet.level,
            own,
        };
        Some((Some(k / 2), at, span))
    }

    /// The strips that a range has of side `c`.
    #[inline(always)]
    fn strips(&self, c: usize, range: SideRange) -> impl Iterator<Item = PlannedStrip> {
        let count = match self.whole >> c & 1 {
            0 => 2 * self.sheets.len(),
            _ => 1,
        };
        (0..count).filter_map(move |k| {
            let (sheet, at, span) = self.strip(c, k)?;
            let (run, level) = span.run(range)?;
            Some(PlannedStrip {
                side: c,
                sheet,
                at,
                level,
                run,
            })
        })
    }

    #[inline(always)]
    fn sample_strip(
        &self,
        strip: &PlannedStrip,
        points: &mut impl Put,
        normals: Option<&mut impl Put>,
    ) {
        let net = match strip.sheet {
            Some(sheet) => &self.sheets[sheet].net,
            None => &self.whole_net,
        };
        let lines = Strip::of(net, strip.at, strip.side);
        lines.sample(strip.run, self.target, strip.level, points, normals);
    }

    /// Samples what a range has of side `c`.
    #[inline(always)]
    fn sample_side(
        &self,
        c: usize,
        range: SideRange,
        points: &mut impl Put,
        mut normals: Option<&mut impl Put>,
    ) {
        for strip in self.strips(c, range) {
            self.sample_strip(&strip, points, normals.as_deref_mut());
        }
        self.sample_rest(c, range, points, normals);
    }

    /// What the strips leave out of side `c`.
    #[inline(always)]
    fn sample_rest(
        &self,
        c: usize,
        range: SideRange,
        points: &mut impl Put,
        normals: Option<&mut impl Put>,
    ) {
        if self.whole >> c & 1 == 0 {
            self.sample_middle(c, range, points, normals);
        }
        if let Some(polygon) = &self.polygons[c] {
            sample_polygon(polygon, self.level, range, points);
        }
    }

    #[inline(always)]
    fn sample_middle(
        &self,
        c: usize,
        range: SideRange,
        points: &mut impl Put,
        normals: Option<&mut impl Put>,
    ) {
        let (Some(sheet), Some(level)) =
            (self.sheets.first(), self.level.checked_sub(range.shift + 1))
        else {
            return;
        };
        let at = 1 << level;
        if !(range.low..=range.high).contains(&at) {
            return;
        }
        let [high, regular] = self.middles[c];
        let (strip, end) = Strip::at_middle(&sheet.net, c, high, regular);
        let place = (at - range.start) as usize;
        points.put_one(place, strip.end(range.target, level, end));
        if let Some(normals) = normals {
            normals.put_one(place, strip.end_normal(level, end));
        }
    }

    /// Writes the sides that a part has.
    pub(super) fn dice_sides(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        if self.refined {
            self.put_kept_sides(part, points, normals);
        } else {
            dispatch!(self.simd, self.put_sides(part, points, normals));
        }
    }

    /// What a part has of side `c`, and the row or column where.
    #[inline(always)]
    fn side_range(&self, c: usize, part: Part) -> Option<(SideRange, usize)> {
        let along = c & 1;
        let range = SideRange {
            target: self.target,
            shift: self.level - part.level,
            low: part.start[along],
            high: part.start[along] + part.segments,
            start: part.start[along],
        };
        Some((range, part.side(c)?))
    }

    #[inline(always)]
    fn put_sides(&self, part: Part, points: &mut Grid3, mut normals: Option<&mut Grid3>) {
        for c in 0..4 {
            if let Some((range, across)) = self.side_range(c, part) {
                let mut points = GridLine::new(points, c, across);
                let mut normals = normals.as_deref_mut().map(|g| GridLine::new(g, c, across));
                self.sample_side(c, range, &mut points, normals.as_mut());
            }
        }
    }

    /// The same for the whole face, as planned.
    #[inline(always)]
    pub(super) fn put_planned(
        &self,
        plan: &Plan,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let part = Part::block(self.level, [0, 0]);
        for strip in &plan.strips {
            let c = strip.side;
            let across = part.side(c).unwrap_or(0);
            let mut points = GridLine::new(points, c, across);
            let mut normals = normals.as_deref_mut().map(|g| GridLine::new(g, c, across));
            self.sample_strip(strip, &mut points, normals.as_mut());
        }
        for c in 0..4 {
            if self.whole >> c & 1 != 0 && self.polygons[c].is_none() {
                continue;
            }
            if let Some((range, across)) = self.side_range(c, part) {
                let mut points = GridLine::new(points, c, across);
                let mut normals = normals.as_deref_mut().map(|g| GridLine::new(g, c, across));
                self.sample_rest(c, range, &mut points, normals.as_mut());
            }
        }
    }

    /// The plan for a whole face with these corners.
    pub(super) fn plan(&self, part: Part, range: BlockRange) -> Option<&'static Plan> {
        let case = Case {
            level: self.level,
            regular: self.regular?,
            sides: self.wanted > Sides::None,
        };
        let strips = || {
            let side = |c: usize| {
                let range = self.side_range(c, part).filter(|_| case.sides)?.0;
                Some(self.strips(c, range))
            };
            (0..4).filter_map(side).flatten().collect()
        };
        Plan::get(case, || Plan::new(&self.sheets, range, strips()))
    }

    fn put_kept_sides(&self, part: Part, points: &mut Grid3, mut normals: Option<&mut Grid3>) {
        let n = 1_usize << part.level;
        let shift = self.level - part.level;
        for c in 0..4 {
            let (Some(across), along) = (part.side(c), c & 1) else {
                continue;
            };
            for k in 0..=part.segments as usize {
                let place = part.start[along] as usize + k;
                let from = if c >= 2 { n - place } else { place } << shift;
                let [i, j] = if along == 0 { [k, across] } else { [across, k] };
                let side = &self.sides[c];
                points.set(i, j, [0, 1, 2].map(|x| side.points[x][from]));
                if let Some(normals) = normals.as_deref_mut() {
                    normals.set(i, j, [0, 1, 2].map(|x| side.normals[x][from]));
                }
            }
        }
    }

    /// Samples of a whole side in its own direction, without the corners.
    fn side_lines(&self, c: usize, points: &mut [[f32; 3]], normals: Option<&mut [[f32; 3]]>) {
        let range = SideRange {
            target: self.target,
            shift: 0,
            low: 0,
            high: 1 << self.level,
            start: 0,
        };
        let line = |points| PointLine {
            points,
            reversed: c >= 2,
        };
        let mut normals = normals.map(line);
        dispatch!(
            self.simd,
            self.sample_side(c, range, &mut line(points), normals.as_mut())
        );
    }

    /// Keeps what the edge's own rule says of side `c`, before the strips are lost.
    pub(super) fn keep_side(&mut self, c: usize) {
        let n = (1_usize << self.level) + 1;
        let (mut points, mut normals) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        let wanted = (self.wanted == Sides::Normals).then_some(&mut normals[..]);
        self.side_lines(c, &mut points, wanted);
        for (i, (&point, &normal)) in points.iter().zip(&normals).enumerate() {
            self.sides[c].set(i, point, normal);
        }
    }

    /// Samples of side `c` at the level that was prepared, ends included; sides must have been wanted.
    pub(crate) fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        let n = 1_usize << self.level;
        points.clear();
        normals.clear();
        points.resize(n + 1, [0.0; 3]);
        normals.resize(n + 1, [0.0; 3]);
        if self.refined {
            let side = &self.sides[c];
            for k in 1..n {
                points[k] = [0, 1, 2].map(|i| side.points[i][k]);
                normals[k] = [0, 1, 2].map(|i| side.normals[i][k]);
            }
        } else if self.level > 0 {
            let wanted = (self.wanted == Sides::Normals).then_some(&mut normals[..]);
            self.side_lines(c, points, wanted);
        }
        let (first, last) = (self.corners[c], self.corners[(c + 1) % 4]);
        (points[0], normals[0]) = first;
        (points[n], normals[n]) = last;
    }
}
