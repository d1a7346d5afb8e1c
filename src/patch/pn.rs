//! Curved PN triangles over a cage.
//!
//! A triangle of points `P_i` with unit normals `N_i` becomes a cubic whose points between `P_i` and `P_j` lie in the tangent planes of the
//! ends: `(2 P_i + P_j − σ_i w_ij N_i)/3` with `w_ij = (P_j − P_i)·N_i`. The tension σ_i of a vertex is 1 in the paper of 2001; 0 leaves its
//! surroundings flat. Normals are a quadratic, with `N_i + N_j` mirrored at the side's middle plane in between. (The mixed terms have Bernstein's factor
//! of 2. Much code leaves it out: on a sphere normals are then off by 1.2° where they would be by 0.03°.)
//!
//! Quads are two triangles, parted by the shorter diagonal of the cage as it was first, by the one with the lowest vertex if both are as
//! long. Polygons of more corners are fans around a point above their centroid: half as far above as the mean of the corners' tangent
//! planes, where a triangle's own middle is to second order.
//!
//! # Sharp edges
//!
//! Along an infinite crease, and wherever else the two faces of an edge have different normals at one of its ends, a tangent plane of
//! either face would open a crack. There the curve follows the crease: the control point is `P_i` plus a third of the edge's projection on
//! the tangent of the crease, which is parallel to the line between the two next vertices on it. Where creases end, cross or begin there is no such tangent, and
//! the edge stays straight at that end.

use super::bezier::{Cubic, Quadratic, Vector};
use super::face::{CORNERS, Half, Net, Shape};
use super::normals::corner_normals;
use crate::math;
use crate::topology::{NONE, Topology};

/// What is known of a cage with PN triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct PnCage {
    /// Per vertex; empty where all are 1.
    tension: Vec<f32>,
    /// Normals given for corners; not a number without. Empty where none are.
    given: Vec<Vector>,
    /// Normal of every corner.
    normals: Vec<Vector>,
    /// Per half-edge, control points near its first and its second end.
    sides: Vec<[Vector; 2]>,
    /// Middles of faces, for polygons; empty for cages of triangles and quads.
    middles: Vec<Middle>,
    /// Whether a quad is parted from corner 1 to 3; empty where none is.
    turned: Vec<bool>,
}

/// What the fan of a polygon goes around.
#[derive(Clone, Copy, Debug)]
struct Middle {
    tip: Tip,
    tension: f32,
}

/// How the curve of an edge leaves one of its ends.
#[derive(Clone, Copy)]
enum Leaves {
    /// In the plane of a normal.
    Plane(Vector),
    /// Along a crease.
    Line(Vector),
    Straight,
}

/// The control point near `p` of the curve from `p` to `q`.
fn near(p: Vector, q: Vector, leaves: Leaves, tension: f32) -> Vector {
    let d = math::sub(q, p);
    let off = match leaves {
        Leaves::Plane(n) => math::scale(n, math::dot(d, n)),
        Leaves::Line(t) => math::sub(d, math::scale(t, math::dot(d, t))),
        Leaves::Straight => [0.0; 3],
    };
    [0, 1, 2].map(|k| ((2.0 * p[k] + q[k]) - off[k] * tension) / 3.0)
}

/// The normal between two ends: the same from either.
fn normal_between(p: Vector, q: Vector, n: Vector, m: Vector) -> Vector {
    let (d, sum) = (math::sub(q, p), math::add(n, m));
    let square = math::dot(d, d);
    let v = 2.0 * math::dot(d, sum) / square;
    let mirrored = math::sub(sum, math::scale(d, v));
    let plain = || math::normalize(sum).unwrap_or([0.0; 3]);
    math::normalize(mirrored).unwrap_or_else(plain)
}

/// One corner of a triangle: point and normal.
type Tip = [Vector; 2];

/// A side of a triangle: control points near its ends.
type Curve = [Vector; 2];

/// Points and normals of a triangle.
fn triangle(tips: [Tip; 3], sides: [Curve; 3]) -> (Net, Quadratic) {
    let [p, n] = [0, 1].map(|k| tips.map(|tip| tip[k]));
    let [[a, b], [c, d], [e, f]] = sides;
    let middle = [0, 1, 2].map(|k| {
        let mean = (((a[k] + b[k]) + (c[k] + d[k])) + (e[k] + f[k])) / 6.0;
        let flat = ((p[0][k] + p[1][k]) + p[2][k]) / 3.0;
        mean + (mean - flat) * 0.5
    });
    let net: Cubic = [p[0], p[1], p[2], a, b, c, d, e, f, middle];
    let between = |i: usize, j: usize| normal_between(p[i], p[j], n[i], n[j]);
    let normals = [
        n[0],
        n[1],
        n[2],
        between(0, 1),
        between(1, 2),
        between(2, 0),
    ];
    (Net::Cubic(net), normals)
}

impl PnCage {
    /// PN triangles over the cage `t` with `points`. `given` holds normals of corners, or nothing; `turned` says which quads are parted from
    /// corner 1 to corner 3.
    pub(crate) fn new(
        t: &Topology,
        points: &[Vector],
        given: Vec<Vector>,
        tension: Vec<f32>,
        turned: Vec<bool>,
    ) -> Self {
        let mut out = Self {
            tension,
            given,
            turned,
            ..Self::default()
        };
        out.update(t, points);
        out
    }

    /// Other points; normals that were given belong to the old ones.
    pub(crate) fn move_points(&mut self, t: &Topology, points: &[Vector]) {
        self.given = Vec::new();
        self.update(t, points);
    }

    /// Another tension, one per vertex.
    pub(crate) fn set_tension(&mut self, t: &Topology, points: &[Vector], tension: Vec<f32>) {
        self.tension = tension;
        self.update(t, points);
    }

    fn tension(&self, v: u32) -> f32 {
        self.tension.get(v as usize).copied().unwrap_or(1.0)
    }

    fn update(&mut self, t: &Topology, points: &[Vector]) {
        let given = |h: u32| {
            let normal = self.given.get(h as usize).copied();
            normal.filter(|n| n[0].is_finite())
        };
        self.normals = corner_normals(t, points, given);
        self.sides = self.curves(t, points);
        let polygons = (0..t.face_count() as u32).any(|f| t.face_halves(f).len() > 4);
        self.middles = match polygons {
            true => (0..t.face_count() as u32)
                .map(|f| self.middle(t, points, f))
                .collect(),
            false => Vec::new(),
        };
    }

    /// Whether the faces of half-edge `h` have the same normal at its first and at its second end.
    fn shared(&self, t: &Topology, h: u32, faces: u32) -> [bool; 2] {
        let g = t.twin(h);
        if g == NONE {
            // A border has one face; where more meet they must agree without normals.
            return [faces == 1; 2];
        }
        let same = |a: u32, b: u32| self.normals[a as usize] == self.normals[b as usize];
        [same(h, t.next(g)), same(t.next(h), g)]
    }

    /// The curves of all half-edges.
    fn curves(&self, t: &Topology, points: &[Vector]) -> Vec<Curve> {
        let mut faces = vec![0_u32; t.edge_count()];
        for h in 0..t.half_count() as u32 {
            faces[t.edge(h) as usize] += 1;
        }
        let ends = |h: u32| [t.vertex(h), t.vertex(t.next(h))];
        // Neighbours along sharp edges: how many, and the first two.
        let mut creases = vec![(0_u32, [NONE; 2]); t.vertex_count()];
        for e in 0..t.edge_count() as u32 {
            let h = t.edge_half(e);
            if self.shared(t, h, faces[e as usize]) != [true; 2] {
                let [a, b] = ends(h);
                for (v, other) in [(a, b), (b, a)] {
                    let (count, others) = &mut creases[v as usize];
                    if let Some(slot) = others.get_mut(*count as usize) {
                        *slot = other;
                    }
                    *count += 1;
                }
            }
        }
        let line = |v: u32| match creases[v as usize] {
            (2, [a, b]) => {
                let along = math::sub(points[b as usize], points[a as usize]);
                math::normalize(along).map_or(Leaves::Straight, Leaves::Line)
            }
            _ => Leaves::Straight,
        };
        let curve = |h: u32| {
            let [a, b] = ends(h);
            let [p, q] = [a, b].map(|v| points[v as usize]);
            let shared = self.shared(t, h, faces[t.edge(h) as usize]);
            let leaves = |k: usize, v: u32, corner: u32| match shared[k] {
                true => Leaves::Plane(self.normals[corner as usize]),
                false => line(v),
            };
            [
                near(p, q, leaves(0, a, h), self.tension(a)),
                near(q, p, leaves(1, b, t.next(h)), self.tension(b)),
            ]
        };
        (0..t.half_count() as u32).map(curve).collect()
    }

    /// Point and normal above the centroid of a polygon.
    fn middle(&self, t: &Topology, points: &[Vector], f: u32) -> Middle {
        let halves = t.face_halves(f);
        let n = halves.len() as f32;
        let mean = |of: &dyn Fn(u32) -> Vector| {
            let sum = halves.clone().fold([0.0; 3], |s, h| math::add(s, of(h)));
            sum.map(|c| c / n)
        };
        let centroid = mean(&|h| points[t.vertex(h) as usize]);
        let lift = mean(&|h| {
            let (v, normal) = (t.vertex(h), self.normals[h as usize]);
            let below = math::dot(math::sub(points[v as usize], centroid), normal);
            math::scale(normal, below * self.tension(v) * 0.5)
        });
        let normal = math::normalize(mean(&|h| self.normals[h as usize]));
        let spare = || self.normals[halves.start as usize];
        let tension: f32 = halves.clone().map(|h| self.tension(t.vertex(h))).sum();
        Middle {
            tip: [math::add(centroid, lift), normal.unwrap_or_else(spare)],
            tension: tension / n,
        }
    }

    fn tip(&self, t: &Topology, points: &[Vector], h: u32) -> Tip {
        [points[t.vertex(h) as usize], self.normals[h as usize]]
    }

    /// The curve between two corners of a face that is no edge.
    fn inside(&self, a: Tip, b: Tip, tension: [f32; 2]) -> Curve {
        [
            near(a[0], b[0], Leaves::Plane(a[1]), tension[0]),
            near(b[0], a[0], Leaves::Plane(b[1]), tension[1]),
        ]
    }

    /// The patches of face `q` of the mesh that is diced: of the cage's own face, or where quads stand at the corners of its polygons, of the quad at corner
    /// `q`.
    pub(super) fn shape(&self, t: &Topology, points: &[Vector], q: u32, split: bool) -> Shape {
        let f = if split { t.face_of(q) } else { q };
        let halves = t.face_halves(f);
        let first = halves.start;
        match (halves.len(), split) {
            (3, false) => Shape::Triangle(half(self.whole(t, points, first), CORNERS)),
            (3, true) => {
                let net = self.whole(t, points, first);
                const THIRD: f32 = 1.0 / 3.0;
                let k = (q - first) as usize;
                Shape::Halves(
                    [(k + 1) % 3, (k + 2) % 3]
                        .map(|other| half(net, [CORNERS[k], middle(k, other), [THIRD; 3]])),
                )
            }
            (4, _) => {
                let turned = self.turned.get(f as usize).is_some_and(|&t| t);
                let nets = self.parted(t, points, first, u32::from(turned));
                if !split {
                    let [a, b, c] = CORNERS;
                    return Shape::Halves([half(nets[0], [a, b, c]), half(nets[1], [a, c, b])]);
                }
                quarter(nets, (q - first + 4 - u32::from(turned)) % 4)
            }
            _ => {
                let fan = |h: u32| half(self.fan(t, points, f, h), CORNERS);
                let (lower, upper) = (fan(q), fan(t.prev(q)));
                let corners = |k: usize| [CORNERS[k], middle(0, 1), CORNERS[2]];
                Shape::Halves([
                    Half {
                        corners: corners(0),
                        ..lower
                    },
                    Half {
                        corners: corners(1),
                        ..upper
                    },
                ])
            }
        }
    }

    /// The triangle of a triangular face.
    fn whole(&self, t: &Topology, points: &[Vector], first: u32) -> (Net, Quadratic) {
        let halves = [0, 1, 2].map(|k| first + k);
        triangle(
            halves.map(|h| self.tip(t, points, h)),
            halves.map(|h| self.sides[h as usize]),
        )
    }

    /// The two triangles of a quad: corners 0, 1, 2 and 0, 2, 3, counted from corner `turn`.
    fn parted(
        &self,
        t: &Topology,
        points: &[Vector],
        first: u32,
        turn: u32,
    ) -> [(Net, Quadratic); 2] {
        let h = [0, 1, 2, 3].map(|k| first + (k + turn) % 4);
        let tips = h.map(|h| self.tip(t, points, h));
        let sides = h.map(|h| self.sides[h as usize]);
        let tension = [h[0], h[2]].map(|h| self.tension(t.vertex(h)));
        let [there, back] = self.inside(tips[0], tips[2], tension);
        [
            triangle(
                [tips[0], tips[1], tips[2]],
                [sides[0], sides[1], [back, there]],
            ),
            triangle(
                [tips[0], tips[2], tips[3]],
                [[there, back], sides[2], sides[3]],
            ),
        ]
    }

    /// The triangle of side `h` of a polygon and its middle.
    fn fan(&self, t: &Topology, points: &[Vector], f: u32, h: u32) -> (Net, Quadratic) {
        let centre = self.middles[f as usize];
        let next = t.next(h);
        let [a, b] = [h, next].map(|h| self.tip(t, points, h));
        let spoke = |tip: Tip, h: u32| {
            let tension = [self.tension(t.vertex(h)), centre.tension];
            self.inside(tip, centre.tip, tension)
        };
        let [into, back] = [spoke(b, next), spoke(a, h)];
        triangle(
            [a, b, centre.tip],
            [self.sides[h as usize], into, [back[1], back[0]]],
        )
    }
}

fn half((points, normals): (Net, Quadratic), corners: [[f32; 3]; 3]) -> Half {
    Half {
        points,
        normals,
        corners,
    }
}

/// The middle between two corners of a triangle.
fn middle(a: usize, b: usize) -> [f32; 3] {
    [0, 1, 2].map(|k| if k == a || k == b { 0.5 } else { 0.0 })
}

/// The quad at corner `k` of a quad that is two triangles (corners 0, 1, 2 and 0, 2, 3): a quarter of the quad.
fn quarter([first, second]: [(Net, Quadratic); 2], k: u32) -> Shape {
    let (one, two) = (
        |corners| half(first, corners),
        |corners| half(second, corners),
    );
    // The middle of the quad, in either triangle.
    let (c, d) = (middle(0, 2), middle(0, 1));
    let [x, y, z] = CORNERS;
    Shape::Halves(match k {
        0 => [one([x, middle(0, 1), c]), two([x, middle(0, 2), d])],
        1 => [one([y, middle(1, 2), c]), one([y, middle(0, 1), c])],
        2 => [two([y, middle(1, 2), d]), one([z, middle(1, 2), c])],
        _ => [two([z, middle(0, 2), d]), two([z, middle(1, 2), d])],
    })
}
