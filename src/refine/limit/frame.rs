//! Tangents of interpolating surfaces along the two sides of a face at one of its corners.
//!
//! The masks of the two rings give two directions that span the tangent plane. What they measure is scaled by what they say of a flat star
//! of equal sectors: so amid regular faces (and at smooth borders of regular ones) the result is the derivative by the parameters of the
//! faces, and at other vertices that of the flat star that the ring looks like. Where rows of points end (at corners), the row along the
//! side alone counts.

use super::Point;
use super::interpolating::{Sector, Tangents, refined_around, sector_normal};
use super::rings::{RingMasks, gather};
use super::sectors::{across, minus};
use crate::refine::Options;
use crate::refine::interpolating::Sheets;
use crate::refine::real::add_scaled;
use crate::refine::sharpness::Step;
use crate::scheme::Scheme;
use crate::topology::{NONE, Ring};
use std::f64::consts::PI;

/// How often the surroundings of a vertex may be refined to make its neighbours regular.
const SPARE: u32 = 2;

/// Directions at a corner of a face, per side of the face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Frame {
    /// Along the side that leaves the corner.
    pub(crate) ahead: Point,
    /// Along the side that arrives there, backwards.
    pub(crate) behind: Point,
    /// Unit normal.
    pub(crate) normal: Point,
}

/// The unit normal of two tangents, unless they are parallel.
pub(crate) fn normal(tangents: [Point; 2]) -> Option<Point> {
    across(tangents)
}

impl Tangents {
    /// The frame at corner `h` of a mesh with `points`, all of whose faces are quads or all triangles.
    pub(crate) fn frame(&self, step: &Step<'_>, points: &[Point], h: u32) -> Frame {
        let sheets = Sheets::<f64, f64, 3>::of_points(step, self.masks(), points);
        let start = sheets.start(h);
        let [ahead, behind] = self.sides(step, points, h, SPARE);
        Frame {
            ahead,
            behind,
            normal: sector_normal(step, self.rings(), points, start, SPARE),
        }
    }

    fn sides(&self, step: &Step<'_>, points: &[Point], h: u32, spare: u32) -> [Point; 2] {
        let (t, masks) = (step.topology, self.rings());
        let sheets = Sheets::<f64, f64, 3>::of_points(step, &masks.stencils, points);
        let start = sheets.start(h);
        let sector = Sector::new(t, &sheets, start);
        let quads = masks.scheme == Scheme::Kobbelt;
        if spare > 0
            && quads
            && sector.has_odd_neighbour(t, &sheets)
            && let Some((level, corner)) = refined_around(step, points, t.vertex(h), h)
        {
            let options: Options = step.options;
            let step = Step::new(&level.topology, &options);
            let sides = self.sides(&step, &level.points, corner, spare - 1);
            return sides.map(|d| d.map(|c| 2.0 * c));
        }
        let x = sheets.at(h);
        let ring = gather(t, &sheets, masks.scheme, &sector.halves, sector.closed);
        let count = sector.halves.len();
        let own = sector.halves.iter().position(|&g| g == h).unwrap_or(0);
        let edges = if sector.closed { count } else { count + 1 };
        let straight = edges + if quads { 0 } else { count };
        // The ring is that of one level on.
        let double = |d: Point| d.map(|c| 2.0 * c);
        let basis = match (sector.closed, sheets.runs_through(start)) {
            (true, _) => closed(masks, count as u32, &ring, &x),
            (false, true) => open(masks, count as u32, &ring, &x, straight),
            (false, false) => None,
        };
        [own, own + 1].map(|i| match &basis {
            Some(basis) => double(basis.along(i)),
            // A row that ends goes on as its mirror image.
            None => {
                let near = minus(&ring[i % edges], &x);
                let far = minus(&ring[straight + i % edges], &x);
                double([0, 1, 2].map(|k| (8.0 * near[k] - far[k]) / 6.0))
            }
        })
    }
}

impl Tangents {
    /// Two tangents at vertex `v` as linear maps of `points`: they span the tangent plane of its first sector, and their cross product points
    /// outward but at reflex corners; lengths mean nothing. Zero at a vertex of no face.
    pub(crate) fn pair(&self, step: &Step<'_>, points: &[Point], v: u32) -> [Point; 2] {
        let t = step.topology;
        if t.fans[v as usize].first == NONE {
            return [[0.0; 3]; 2];
        }
        let sheets = Sheets::<f64, f64, 3>::of_points(step, self.masks(), points);
        let cut = Ring::of_fan(t, v).find(|&h| sheets.twin(h) == NONE);
        let start = cut.unwrap_or(t.fans[v as usize].first);
        self.pair_at(step, points, start, SPARE)
    }

    fn pair_at(&self, step: &Step<'_>, points: &[Point], start: u32, spare: u32) -> [Point; 2] {
        let (t, masks) = (step.topology, self.rings());
        let sheets = Sheets::<f64, f64, 3>::of_points(step, &masks.stencils, points);
        let sector = Sector::new(t, &sheets, start);
        let quads = masks.scheme == Scheme::Kobbelt;
        if spare > 0
            && quads
            && (step.is_linear() || sector.has_odd_neighbour(t, &sheets))
            && let Some((level, corner)) = refined_around(step, points, t.vertex(start), start)
        {
            let options = Options {
                scheme: masks.scheme,
                ..step.options
            };
            let step = Step::new(&level.topology, &options);
            return self.pair_at(&step, &level.points, corner, spare - 1);
        }
        let x = sheets.at(start);
        let ring = gather(t, &sheets, masks.scheme, &sector.halves, sector.closed);
        let count = sector.halves.len();
        let edges = if sector.closed { count } else { count + 1 };
        let straight = edges + if quads { 0 } else { count };
        let basis = match (sector.closed, sheets.runs_through(start)) {
            (true, _) => closed(masks, count as u32, &ring, &x),
            (false, true) => open(masks, count as u32, &ring, &x, straight),
            (false, false) => None,
        };
        if let Some(basis) = basis {
            return [basis.first, basis.second];
        }
        // Rows that end go on as their mirror images. At the end of a crease they are one row: the other tangent is across it.
        let row = |i: usize| {
            let near = minus(&ring[i % edges], &x);
            let far = minus(&ring[straight + i % edges], &x);
            [0, 1, 2].map(|k| 8.0 * near[k] - far[k])
        };
        let last = sector.halves[count - 1];
        if t.twin(start) != t.prev(last) {
            return [row(0), row(count)];
        }
        let mut across = [0.0; 3];
        for (i, p) in ring[..count].iter().enumerate() {
            let angle = 2.0 * PI * i as f64 / count as f64;
            add_scaled(&mut across, libm::sin(angle), &minus(p, &x));
        }
        [row(0), across]
    }
}

/// Two directions at a right angle in the flat star, per unit of its spokes, and the angle between spokes.
struct Basis {
    first: Point,
    second: Point,
    angle: f64,
}

impl Basis {
    /// Along spoke `i`.
    fn along(&self, i: usize) -> Point {
        let angle = self.angle * i as f64;
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        // The spokes of a grid lie on its axes.
        let [cosine, sine] = [cosine, sine].map(|w| if w.abs() < 1e-15 { 0.0 } else { w });
        [0, 1, 2].map(|k| cosine * self.first[k] + sine * self.second[k])
    }
}

/// The two rings of a flat star of `count` sectors, as [`gather`] lists them; spokes have length 1.
fn star(count: usize, angle: f64, closed: bool, quads: bool) -> Vec<Point> {
    let edges = if closed { count } else { count + 1 };
    let spoke = |i: usize| {
        let a = angle * i as f64;
        [libm::cos(a), libm::sin(a), 0.0]
    };
    let between = |i: usize, u: f64, v: f64| {
        let (a, b) = (spoke(i), spoke(i + 1));
        [0, 1, 2].map(|k| u * a[k] + v * b[k])
    };
    let ends = |scale: f64| (0..edges).map(move |i| spoke(i).map(|c| scale * c));
    let corners = |u: f64, v: f64| (0..count).map(move |i| between(i, u, v));
    let mut out: Vec<Point> = ends(1.0).collect();
    if !quads {
        out.extend(corners(1.0, 1.0));
    }
    out.extend(ends(2.0));
    if quads {
        for [u, v] in [[1.0, 1.0], [2.0, 1.0], [1.0, 2.0], [2.0, 2.0]] {
            out.extend(corners(u, v));
        }
    }
    out
}

fn closed(masks: &RingMasks, count: u32, ring: &[Point], x: &Point) -> Option<Basis> {
    let quads = masks.scheme == Scheme::Kobbelt;
    let angle = 2.0 * PI / f64::from(count);
    let flat = star(count as usize, angle, true, quads);
    let [unit, _] = masks.closed(count, &flat, &[0.0; 3])?;
    let [first, second] = masks.closed(count, ring, x)?;
    let scaled = |d: Point| d.map(|c| c / unit[0]);
    Some(Basis {
        first: scaled(first),
        second: scaled(second),
        angle,
    })
}

/// Of a sector whose border is one smooth curve.
fn open(
    masks: &RingMasks,
    count: u32,
    ring: &[Point],
    x: &Point,
    straight: usize,
) -> Option<Basis> {
    let quads = masks.scheme == Scheme::Kobbelt;
    let n = count as usize;
    let angle = PI / f64::from(count);
    let flat = star(n, angle, false, quads);
    let unit = masks.across(count, &flat, &[0.0; 3])?;
    let inward = masks.across(count, ring, x)?;
    let (p, q) = (ring[0], ring[n]);
    let (far_p, far_q) = (ring[straight], ring[straight + n]);
    let along = |k: usize| (8.0 * (p[k] - q[k]) - (far_p[k] - far_q[k])) / 12.0;
    (unit[1] > 0.0).then(|| Basis {
        first: [0, 1, 2].map(along),
        second: inward.map(|c| c / unit[1]),
        angle,
    })
}
