//! What of the lines of a tile is seen: triangles pass by one at a time, and each takes away the stretches of lines that it hides.
//!
//! Lines and triangles are straight on the screen, depth is linear along both, so a triangle hides one stretch of a line and its ends are
//! known exactly: no samples, no tolerance in depth, and so nothing to stutter. A triangle never hides its own edges, which are lines of the
//! very same points; a triangle that has one end of a line meets it there at equal depth, and the sign of the difference at the other end
//! decides. After Appel, *The notion of quantitative invisibility and the machine rendering of solids* (1967), with intervals in
//! place of counts.

use super::lens::{Spot, area};
use super::lines::Segment;
use super::squares::{Cells, Squares};

/// Lines per square in which they are looked up: more make triangles look at lines far off, fewer make them look into many squares.
const PER_CELL: f64 = 6.0;

/// Pixels by which a line is taken to be in squares beside it: more than rounding.
const SLACK: f64 = 1e-6;

/// Differences in depth below this, relative, are rounding.
const EQUAL: f64 = 1e-9;

/// Triangles of less, in square pixels, hide nothing.
const NO_AREA: f64 = 1e-9;

/// Stretches shorter than this, in pixels, are no stretches.
const NOTHING: f64 = 0.02;

/// A line in a tile, with what hides it.
#[derive(Clone, Debug)]
struct Line {
    segment: Segment,
    /// What of it is in the tile, from 0 at its first end to 1 at its second.
    from: f64,
    to: f64,
    low: [f64; 2],
    high: [f64; 2],
    /// Depth that something must have to hide all of it, or any of it.
    farthest: f64,
    /// Depths are taken as this many times what they are.
    lift: f64,
    /// Hidden stretches, apart from each other and in order.
    hidden: Vec<[f64; 2]>,
}

/// A point in a tile.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: Spot,
    hidden: bool,
}

/// Lines and points of a tile.
pub(super) struct Visibility {
    origin: [f64; 2],
    size: [f64; 2],
    /// In which lines and points are looked up.
    squares: Squares,
    lines: Vec<Line>,
    points: Vec<Point>,
    line_cells: Cells,
    point_cells: Cells,
}

impl Visibility {
    /// Lines and points of the tile `rect` (first column and row, columns and rows). Each line comes with how much nearer it is taken to be,
    /// relative; what is outside of the tile is left out.
    pub(super) fn new(
        rect: [u32; 4],
        lines: impl Iterator<Item = (Segment, f64)>,
        points: impl Iterator<Item = Spot>,
    ) -> Self {
        let [x, y, width, height] = rect.map(f64::from);
        let (origin, size) = ([x, y], [width, height]);
        let mut out = Self {
            origin,
            size,
            squares: Squares::new(origin, size, width.max(height).max(1.0)),
            lines: Vec::new(),
            points: points.map(|at| Point { at, hidden: false }).collect(),
            line_cells: Cells::default(),
            point_cells: Cells::default(),
        };
        for (segment, lift) in lines {
            out.lines.extend(out.clip(segment, lift));
        }
        out.sort_into_cells();
        out
    }

    fn sort_into_cells(&mut self) {
        let [width, height] = self.size;
        let count = self.lines.len().max(1) as f64;
        let extent = |l: &Line| (l.high[0] - l.low[0]) + (l.high[1] - l.low[1]);
        let extents: f64 = self.lines.iter().map(extent).sum();
        let usual = (width * height / count * PER_CELL).sqrt().clamp(2.0, 64.0);
        // Long lines are in many cells: no more, all in all, than a few for each line.
        let side = usual.max(extents / (8.0 * count + 65536.0));
        let squares = Squares::new(self.origin, self.size, side);
        self.squares = squares;
        self.line_cells = Cells::new(squares.len(), self.lines.len(), |k, visit| {
            let line = &self.lines[k];
            let (stretch, hull) = ([line.from, line.to], [line.low, line.high]);
            squares.through(&line.segment, stretch, hull, SLACK, visit);
        });
        self.point_cells = Cells::new(squares.len(), self.points.len(), |k, visit| {
            let [x, y, _] = self.points[k].at;
            let [[x, y], _] = squares.range([x, y], [x, y]);
            visit(squares.index(x, y));
        });
    }

    /// The part of a line that is in the tile. Lines that run along the border between two tiles belong to the second.
    fn clip(&self, segment: Segment, lift: f64) -> Option<Line> {
        let (a, b) = (segment.a, segment.b);
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for k in 0..2 {
            let (low, high) = (self.origin[k], self.origin[k] + self.size[k]);
            let d = b[k] - a[k];
            if d == 0.0 {
                if a[k] < low || a[k] >= high {
                    return None;
                }
                continue;
            }
            let [t0, t1] = [(low - a[k]) / d, (high - a[k]) / d];
            from = from.max(t0.min(t1));
            to = to.min(t0.max(t1));
        }
        if from >= to {
            return None;
        }
        let ends = [at(&segment, from), at(&segment, to)];
        let least = |k: usize| ends[0][k].min(ends[1][k]);
        let most = |k: usize| ends[0][k].max(ends[1][k]);
        Some(Line {
            segment,
            from,
            to,
            low: [least(0), least(1)],
            high: [most(0), most(1)],
            farthest: least(2) * (1.0 + lift),
            lift: 1.0 + lift,
            hidden: Vec::new(),
        })
    }

    /// Bytes held, about.
    pub(super) fn bytes(&self) -> u128 {
        let hidden: usize = self.lines.iter().map(|l| l.hidden.capacity()).sum();
        let cells = self.line_cells.len() + self.point_cells.len();
        let kept = self.lines.len() * size_of::<Line>() + self.points.len() * size_of::<Point>();
        (kept + cells * 4 + hidden * size_of::<[f64; 2]>()) as u128
    }

    /// Whether there is nothing to hide.
    pub(super) fn is_empty(&self) -> bool {
        self.lines.is_empty() && self.points.is_empty()
    }

    /// Takes away what a triangle hides.
    pub(super) fn pass(&mut self, triangle: [Spot; 3]) {
        let [p, q, r] = triangle;
        let least = |k: usize| p[k].min(q[k]).min(r[k]);
        let most = |k: usize| p[k].max(q[k]).max(r[k]);
        let (low, high) = ([least(0), least(1)], [most(0), most(1)]);
        let outside = |k: usize| high[k] < self.origin[k] || low[k] > self.origin[k] + self.size[k];
        if outside(0) || outside(1) {
            return;
        }
        let twice = area(p, q, r);
        // Not a number where a point is infinitely far away.
        if twice.is_nan() || twice.abs() <= NO_AREA {
            return;
        }
        let (nearest, sign) = (most(2), twice.signum());
        let [first, last] = self.squares.range(low, high);
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                let cell = self.squares.index(x, y);
                for &k in self.line_cells.of(cell) {
                    let line = &mut self.lines[k as usize];
                    let apart = (0..2).any(|k| line.low[k] > high[k] || line.high[k] < low[k]);
                    if !apart && nearest > line.farthest {
                        line.hide(&triangle, sign, twice);
                    }
                }
                for &k in self.point_cells.of(cell) {
                    let point = &mut self.points[k as usize];
                    if !point.hidden && nearest > point.at[2] {
                        point.hidden = hides_point(&triangle, sign, twice, point.at);
                    }
                }
            }
        }
    }

    /// What is left of every line, as its segment and the ends of the stretch.
    pub(super) fn seen(&self, mut visit: impl FnMut(&Segment, [Spot; 2])) {
        for line in &self.lines {
            line.seen(|stretch| {
                visit(&line.segment, stretch.map(|t| at(&line.segment, t)));
            });
        }
    }

    /// Whether each point is seen, in the order in which they were given.
    pub(super) fn points_seen(&self) -> impl Iterator<Item = bool> + '_ {
        self.points.iter().map(|p| !p.hidden)
    }
}

/// The place at `t` along a line; its ends themselves at 0 and 1.
fn at(s: &Segment, t: f64) -> Spot {
    if t == 1.0 {
        return s.b;
    }
    [0, 1, 2].map(|k| s.a[k] + (s.b[k] - s.a[k]) * t)
}

/// Whether a point is inside of a triangle or on its rim, behind it, and none of its corners.
fn hides_point(triangle: &[Spot; 3], sign: f64, twice: f64, at: Spot) -> bool {
    if triangle.contains(&at) {
        return false;
    }
    let mut depth = 0.0;
    for k in 0..3 {
        let weight = area(triangle[(k + 1) % 3], triangle[(k + 2) % 3], at) * sign;
        if weight < 0.0 {
            return false;
        }
        depth += weight * triangle[k][2];
    }
    depth / twice.abs() > at[2] * (1.0 + EQUAL)
}

impl Line {
    fn is_all_hidden(&self) -> bool {
        matches!(self.hidden.as_slice(), [[a, b]] if *a <= self.from && *b >= self.to)
    }

    /// Takes away what a triangle of `twice` the area hides.
    fn hide(&mut self, triangle: &[Spot; 3], sign: f64, twice: f64) {
        let (a, b) = (self.segment.a, self.segment.b);
        if self.is_all_hidden() || (triangle.contains(&a) && triangle.contains(&b)) {
            return;
        }
        let (mut from, mut to) = (self.from, self.to);
        // How far each end is on the inner side of each edge; edge k faces corner k.
        let mut inside = [[0.0; 2]; 3];
        for k in 0..3 {
            let (p, q) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
            let [f, g] = [area(p, q, a) * sign, area(p, q, b) * sign];
            inside[k] = [f, g];
            if f < 0.0 && g < 0.0 {
                return;
            }
            if f < 0.0 {
                from = from.max(f / (f - g));
            } else if g < 0.0 {
                to = to.min(f / (f - g));
            }
        }
        if from >= to {
            return;
        }
        // How much nearer the triangle is, at both ends of the stretch.
        let nearer = |t: f64| {
            let mut depth = 0.0;
            for k in 0..3 {
                let [f, g] = inside[k];
                depth += (f + (g - f) * t) * triangle[k][2];
            }
            let own = (a[2] + (b[2] - a[2]) * t) * self.lift;
            depth / twice.abs() - own * (1.0 + EQUAL)
        };
        let [d0, d1] = [nearer(from), nearer(to)];
        if d0 <= 0.0 && d1 <= 0.0 {
            return;
        }
        if d0 <= 0.0 {
            from += (to - from) * (d0 / (d0 - d1));
        } else if d1 <= 0.0 {
            to = from + (to - from) * (d0 / (d0 - d1));
        }
        if from < to {
            self.take([from, to]);
        }
    }

    /// Length in pixels from parameter 0 to 1.
    fn length(&self) -> f64 {
        let (a, b) = (self.segment.a, self.segment.b);
        let d = [b[0] - a[0], b[1] - a[1]];
        (d[0] * d[0] + d[1] * d[1]).sqrt()
    }

    /// Adds a hidden stretch. Gaps of rounding between two of them are closed.
    fn take(&mut self, mut new: [f64; 2]) {
        let gap = 1e-4 / self.length().max(1e-4);
        let first = self.hidden.partition_point(|h| h[1] + gap < new[0]);
        let last = self.hidden.partition_point(|h| h[0] <= new[1] + gap);
        if first < last {
            new[0] = new[0].min(self.hidden[first][0]);
            new[1] = new[1].max(self.hidden[last - 1][1]);
        }
        self.hidden.splice(first..last, [new]);
    }

    /// What is left of it.
    fn seen(&self, mut visit: impl FnMut([f64; 2])) {
        let nothing = NOTHING / self.length().max(NOTHING);
        let mut begin = self.from;
        let mut previous = false;
        for &[a, b] in &self.hidden {
            // Slivers hide nothing worth a gap, and nothing worth a line is seen between two that hide.
            if b - a < nothing && a > self.from && b < self.to {
                continue;
            }
            if a > begin && !(previous && a - begin < nothing) {
                visit([begin, a]);
            }
            begin = begin.max(b);
            previous = true;
        }
        if begin < self.to {
            visit([begin, self.to]);
        }
    }
}
