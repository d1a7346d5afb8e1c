//! What of micro-edges is seen, found by rays through all triangles: slow, in model space, and sharing nothing with the module.
#![allow(unreachable_pub)]

use earmark::Surface;
use earmark::camera::View;
use earmark::overlay::Polyline;

type Point = [f64; 3];

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub fn distance(p: [f32; 2], q: [f32; 2]) -> f32 {
    ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)).sqrt()
}

fn from_segment(p: [f32; 2], a: [f32; 2], b: [f32; 2]) -> (f32, f32) {
    let d = [b[0] - a[0], b[1] - a[1]];
    let square = d[0] * d[0] + d[1] * d[1];
    let along = (p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1];
    let t = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (distance(p, [a[0] + d[0] * t, a[1] + d[1] * t]), t)
}

pub fn from_polyline(p: [f32; 2], line: &[[f32; 2]]) -> f32 {
    let each = line.windows(2).map(|s| from_segment(p, s[0], s[1]).0);
    each.fold(f32::INFINITY, f32::min)
}

/// Side of a cell of the lookup in pixels.
const CELL: f32 = 8.0;

/// Numbers by the cells that their boxes touch, and one cell around.
struct Cells {
    side: usize,
    lists: Vec<Vec<u32>>,
}

impl Cells {
    fn new(view: &View) -> Self {
        let side = (view.size.width.max(view.size.height) as f32 / CELL) as usize + 3;
        Self {
            side,
            lists: vec![Vec::new(); side * side],
        }
    }
    fn cell(&self, v: f32) -> usize {
        ((v / CELL).max(-1.0) as isize + 1).clamp(0, self.side as isize - 1) as usize
    }
    fn add(&mut self, item: u32, points: &[[f32; 2]]) {
        let bound = |k: usize, f: fn(f32, f32) -> f32, by: f32| {
            let all = points.iter().map(|p| p[k]);
            self.cell(all.reduce(f).unwrap_or(0.0) + by)
        };
        let [x0, y0] = [0, 1].map(|k| bound(k, f32::min, -1.0));
        let [x1, y1] = [0, 1].map(|k| bound(k, f32::max, 1.0));
        for y in y0..=y1 {
            for x in x0..=x1 {
                self.lists[y * self.side + x].push(item);
            }
        }
    }
    fn at(&self, p: [f32; 2]) -> &[u32] {
        &self.lists[self.cell(p[1]) * self.side + self.cell(p[0])]
    }
}

/// A surface at a level, in a view.
pub struct Oracle {
    view: View,
    triangles: Vec<[Point; 3]>,
    edges: Vec<[Point; 2]>,
    spots: Vec<[[f32; 2]; 2]>,
    by_triangle: Cells,
    by_edge: Cells,
    /// Size of the model.
    radius: f64,
}

impl Oracle {
    pub fn new(surface: &Surface, view: &View, level: u32) -> Self {
        let mut out = Self {
            view: *view,
            triangles: Vec::new(),
            edges: Vec::new(),
            spots: Vec::new(),
            by_triangle: Cells::new(view),
            by_edge: Cells::new(view),
            radius: 0.0,
        };
        let level = level - u32::from(surface.is_split());
        for q in 0..surface.quads().face_count() as u32 {
            let grid = surface.dice(q, level);
            let n = grid.side;
            let p = |i: usize, j: usize| grid.points[j * n + i].map(f64::from);
            for j in 0..n {
                for i in 0..n {
                    if i + 1 < n {
                        out.edge(p(i, j), p(i + 1, j));
                    }
                    if j + 1 < n {
                        out.edge(p(i, j), p(i, j + 1));
                    }
                    if i + 1 < n && j + 1 < n {
                        out.triangle([p(i, j), p(i + 1, j), p(i + 1, j + 1)]);
                        out.triangle([p(i, j), p(i + 1, j + 1), p(i, j + 1)]);
                    }
                }
            }
        }
        out
    }

    fn spot(&self, p: Point) -> Option<[f32; 2]> {
        let [x, y, _] = self.view.project(p.map(|c| c as f32))?;
        Some([x, y])
    }

    fn triangle(&mut self, t: [Point; 3]) {
        for p in t {
            self.radius = self.radius.max(dot(p, p).sqrt());
        }
        let spots = t.map(|p| self.spot(p));
        let number = self.triangles.len() as u32;
        self.triangles.push(t);
        if let [Some(p), Some(q), Some(r)] = spots {
            self.by_triangle.add(number, &[p, q, r]);
        } else if spots.iter().any(Option::is_some) {
            // The near plane cuts it: it may be anywhere.
            let most = self.view.size.width.max(self.view.size.height) as f32;
            self.by_triangle.add(number, &[[0.0; 2], [most; 2]]);
        }
    }

    fn edge(&mut self, a: Point, b: Point) {
        if let (Some(p), Some(q)) = (self.spot(a), self.spot(b)) {
            let number = self.edges.len() as u32;
            self.edges.push([a, b]);
            self.spots.push([p, q]);
            self.by_edge.add(number, &[p, q]);
        }
    }

    /// The point of an edge that is seen at a share of its length on the screen.
    fn point(&self, edge: usize, t: f64) -> Point {
        let [a, b] = self.edges[edge];
        let depth = |p: Point| f64::from(self.view.distance(p.map(|c| c as f32)));
        let (wa, wb) = match self.view.projection.ortho {
            true => (1.0, 1.0),
            false => (depth(a), depth(b)),
        };
        let s = t * wa / (wb + t * (wa - wb));
        [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * s)
    }

    /// How far before `p` the nearest triangle stands on the line of sight through `spot`, in model units: negative for one behind it.
    fn cover(&self, spot: [f32; 2], p: Point) -> f64 {
        let (from, along) = self.view.ray(spot[0], spot[1]);
        let (from, along) = (from.map(f64::from), along.map(f64::from));
        let forward = self.view.forward.map(f64::from);
        let before_near = |q: Point| {
            let eye = self.view.eye.map(f64::from);
            dot(sub(q, eye), forward) < f64::from(self.view.near)
        };
        let own = dot(sub(p, from), along);
        let mut most = f64::NEG_INFINITY;
        for &k in self.by_triangle.at(spot) {
            let [a, b, c] = self.triangles[k as usize];
            let (e, f) = (sub(b, a), sub(c, a));
            let h = cross(along, f);
            let det = dot(e, h);
            if det == 0.0 {
                continue;
            }
            let s = sub(from, a);
            let u = dot(s, h) / det;
            let q = cross(s, e);
            let v = dot(along, q) / det;
            if u < 0.0 || v < 0.0 || u + v > 1.0 {
                continue;
            }
            let at = dot(f, q) / det;
            if !before_near([0, 1, 2].map(|k| from[k] + along[k] * at)) {
                most = most.max(own - at);
            }
        }
        most
    }

    fn in_picture(&self, [x, y]: [f32; 2]) -> bool {
        let (w, h) = (self.view.size.width as f32, self.view.size.height as f32);
        x > 2.0 && y > 2.0 && x < w - 2.0 && y < h - 2.0
    }

    /// Places of drawn lines where no micro-edge is seen, and places looked at.
    pub fn hidden_but_drawn(&self, lines: &[Polyline]) -> (usize, usize) {
        let (mut wrong, mut all) = (0, 0);
        for segment in lines.iter().flat_map(|l| l.points.windows(2)) {
            let length = distance(segment[0], segment[1]);
            let count = (length / 4.0).ceil().max(1.0);
            for k in 0..count as u32 {
                let t = (k as f32 + 0.5) / count;
                let p = [0, 1].map(|k| segment[0][k] + (segment[1][k] - segment[0][k]) * t);
                if !self.in_picture(p) {
                    continue;
                }
                all += 1;
                let seen = self.by_edge.at(p).iter().any(|&e| {
                    let [a, b] = self.spots[e as usize];
                    let (off, t) = from_segment(p, a, b);
                    off < 0.12 && {
                        let point = self.point(e as usize, f64::from(t));
                        let spot = [0, 1].map(|k| a[k] + (b[k] - a[k]) * t);
                        self.cover(spot, point) < 2e-4 * self.radius
                    }
                });
                wrong += usize::from(!seen);
            }
        }
        (wrong, all)
    }

    /// Middles of micro-edges that are seen beyond doubt and not drawn.
    pub fn seen_but_not_drawn(&self, lines: &[Polyline]) -> usize {
        let segments: Vec<&[[f32; 2]]> = lines.iter().flat_map(|l| l.points.windows(2)).collect();
        let mut cells = Cells::new(&self.view);
        for (k, s) in segments.iter().enumerate() {
            cells.add(k as u32, s);
        }
        let mut wrong = 0;
        for (e, [a, b]) in self.spots.iter().enumerate() {
            let spot = [0, 1].map(|k| (a[k] + b[k]) * 0.5);
            if distance(*a, *b) < 0.5 || !self.in_picture(spot) {
                continue;
            }
            let point = self.point(e, 0.5);
            let beside = [[0.0, 0.0], [0.2, 0.0], [-0.2, 0.0], [0.0, 0.2], [0.0, -0.2]];
            let seen = beside.iter().all(|d| {
                let limit = if *d == [0.0, 0.0] { 1e-6 } else { 1e-2 };
                self.cover([spot[0] + d[0], spot[1] + d[1]], point) < limit * self.radius
            });
            let drawn = || {
                let near = cells.at(spot).iter();
                near.map(|&k| {
                    from_segment(spot, segments[k as usize][0], segments[k as usize][1]).0
                })
                .fold(f32::INFINITY, f32::min)
                    < 0.12
            };
            wrong += usize::from(seen && !drawn());
        }
        wrong
    }
}
