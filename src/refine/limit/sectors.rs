//! Limit masks on a local ring: the position, and one normal per sector between sharp edges.

use super::Point;
use super::local::LocalRing;
use crate::refine::real::{add, add_scaled, midpoint, scaled};
use crate::scheme::crease::Rule;
use crate::scheme::dart::{self, DartMasks};
use crate::scheme::limit::{self, RingMask};
use crate::scheme::{CreaseMethod, loop_scheme};
use std::ops::Range;
use std::sync::OnceLock;

const TABLE: usize = dart::MAX_VALENCE as usize + 1;
/// Steps after which the ring of a dart of high valence is taken as smooth.
const DART_STEPS: usize = 64;
/// Two tangents count as parallel when the sine of their angle is below this: points of 24 bits leave no direction in their cross product.
const PARALLEL: f64 = 1e-5;

/// Masks by valence, made when first needed.
pub(in crate::refine) struct Tables {
    triangles: bool,
    smooth: [OnceLock<[RingMask; 2]>; TABLE],
    sides: [OnceLock<RingMask>; TABLE],
    darts: [OnceLock<DartMasks>; TABLE],
}

impl Tables {
    /// Masks of Loop's triangles, or of Catmull-Clark's quads.
    pub(in crate::refine) fn new(triangles: bool) -> Self {
        Self {
            triangles,
            smooth: [const { OnceLock::new() }; TABLE],
            sides: [const { OnceLock::new() }; TABLE],
            darts: [const { OnceLock::new() }; TABLE],
        }
    }

    fn smooth<R>(&self, n: usize, using: impl FnOnce(&[RingMask; 2]) -> R) -> R {
        let make = if self.triangles {
            loop_scheme::smooth_tangents
        } else {
            limit::smooth_tangents
        };
        Self::with(&self.smooth, n, make, using)
    }

    fn side<R>(&self, k: usize, using: impl FnOnce(&RingMask) -> R) -> R {
        let make = if self.triangles {
            loop_scheme::side_tangent
        } else {
            limit::side_tangent
        };
        Self::with(&self.sides, k, make, using)
    }

    fn dart<R>(&self, n: usize, using: impl FnOnce(&DartMasks) -> R) -> R {
        let make = if self.triangles {
            DartMasks::of_loop
        } else {
            DartMasks::new
        };
        Self::with(&self.darts, n, make, using)
    }

    fn with<M, R>(
        table: &[OnceLock<M>],
        n: usize,
        make: impl Fn(u32) -> M,
        using: impl FnOnce(&M) -> R,
    ) -> R {
        match table.get(n) {
            Some(cell) => using(cell.get_or_init(|| make(n as u32))),
            None => using(&make(n as u32)),
        }
    }
}

pub(super) fn cross(a: &Point, b: &Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `v` with length 1, or nothing when it has no direction.
pub(super) fn unit(v: Point) -> Option<Point> {
    // Scale first: squares of small tangents would vanish.
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot(&v, &v).sqrt();
    Some(v.map(|c| c / length))
}

/// The direction across both tangents, unless they are parallel or vanish.
pub(super) fn across(tangents: [Point; 2]) -> Option<Point> {
    let [Some(a), Some(b)] = tangents.map(unit) else {
        return None;
    };
    let n = cross(&a, &b);
    if dot(&n, &n) < PARALLEL * PARALLEL {
        return None;
    }
    unit(n)
}

/// Faces `first`, `first + 1`, … of a ring, `count` of them, around the end if need be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sector {
    pub(super) first: usize,
    pub(super) count: usize,
}

impl LocalRing {
    fn edge(&self, i: usize) -> &Point {
        &self.edges[i % self.edges.len()]
    }
    /// The corner of face `i` opposite the vertex; in a triangle the middle of the opposite side will do.
    fn across(&self, i: usize) -> Point {
        if self.triangles {
            midpoint(self.edge(i), self.edge(i + 1))
        } else {
            self.faces[i % self.faces.len()]
        }
    }

    /// A mask over the ring from edge `first` on, about the vertex: only differences enter, so that far from the origin nothing is lost.
    fn apply(&self, mask: &RingMask, first: usize) -> Point {
        let mut sum = [0.0; 3];
        for (i, w) in mask.edges.iter().enumerate() {
            add_scaled(&mut sum, *w, &minus(self.edge(first + i), &self.x));
        }
        for (i, w) in mask.faces.iter().enumerate() {
            add_scaled(&mut sum, *w, &minus(&self.across(first + i), &self.x));
        }
        sum
    }

    /// Limit position. The ring must not be semi-sharp.
    pub(super) fn position(&self, tables: &Tables) -> Point {
        let n = self.face_count();
        let sharp = self.sharp_edges();
        match self.rule() {
            Rule::Corner => self.x,
            Rule::Crease => {
                let mut point = scaled(limit::CREASE_VERTEX, &self.x);
                for i in sharp {
                    add_scaled(&mut point, limit::CREASE_END, &self.edges[i]);
                }
                point
            }
            Rule::Dart if n < TABLE && n > 1 => {
                let mut point = self.x;
                let offset = tables.dart(n, |d| self.apply(&d.position, sharp[0]));
                add(&mut point, &offset);
                point
            }
            Rule::Dart => {
                let mut ring = self.clone();
                for _ in 0..DART_STEPS {
                    ring.advance(CreaseMethod::Uniform);
                }
                ring.smooth_position()
            }
            Rule::Smooth => self.smooth_position(),
        }
    }

    fn smooth_position(&self) -> Point {
        let n = self.face_count();
        if self.triangles {
            let [x, e] = loop_scheme::position(n as u32);
            let mut point = scaled(x, &self.x);
            for end in &self.edges[..n] {
                add_scaled(&mut point, e, end);
            }
            return point;
        }
        let [x, e, f] = limit::position(n as u32);
        let mut point = scaled(x, &self.x);
        for i in 0..n {
            add_scaled(&mut point, e, &self.edges[i]);
            add_scaled(&mut point, f, &self.faces[i]);
        }
        point
    }

    pub(super) fn sectors(&self, linear: bool) -> Vec<Sector> {
        let n = self.face_count();
        let sharp = self.sharp_edges();
        let each = || (0..n).map(|first| Sector { first, count: 1 }).collect();
        if linear {
            return each();
        }
        match self.rule() {
            Rule::Smooth => vec![Sector { first: 0, count: n }],
            Rule::Dart => vec![Sector {
                first: sharp[0],
                count: n,
            }],
            // A sharp point on a smooth sheet is the tip of a cone: it has as many normals as faces.
            Rule::Corner if sharp.len() < 2 => each(),
            Rule::Crease | Rule::Corner => {
                let mut out: Vec<Sector> = sharp
                    .windows(2)
                    .map(|w| Sector {
                        first: w[0],
                        count: w[1] - w[0],
                    })
                    .collect();
                if self.closed {
                    let last = sharp[sharp.len() - 1];
                    out.push(Sector {
                        first: last,
                        count: n - (last - sharp[0]),
                    });
                }
                out
            }
        }
    }

    pub(super) fn tangents(&self, tables: &Tables, sector: Sector, linear: bool) -> [Point; 2] {
        let n = self.face_count();
        let (a, b) = (
            self.edge(sector.first),
            self.edge(sector.first + sector.count),
        );
        let rule = if linear { Rule::Corner } else { self.rule() };
        match rule {
            Rule::Corner => [minus(a, &self.x), minus(b, &self.x)],
            Rule::Crease => {
                let inward = tables.side(sector.count, |m| self.apply(m, sector.first));
                [minus(a, b), inward]
            }
            Rule::Dart if n < TABLE && n > 1 => tables.dart(n, |d| {
                [0, 1].map(|k| self.apply(&d.tangents[k], sector.first))
            }),
            Rule::Smooth | Rule::Dart => {
                tables.smooth(n, |m| [0, 1].map(|k| self.apply(&m[k], sector.first)))
            }
        }
    }

    /// Both tangents of the first sector, as the masks give them. The ring must not be semi-sharp.
    pub(super) fn first_tangents(&self, tables: &Tables, linear: bool) -> [Point; 2] {
        let first = self.sectors(linear)[0];
        self.tangents(tables, first, linear)
    }

    /// Whether the sector of a corner may take more than half a turn: its two tangents know the plane, but not on which side of them it is.
    /// (Two triangles never come to do so: the edge between them turns to the sum of their outer ones.)
    pub(super) fn may_be_reflex(&self, sector: Sector) -> bool {
        sector.count > 1 + usize::from(self.triangles)
    }

    /// Sum of the face normals of a sector, each by its diagonals.
    fn face_normal(&self, sector: Sector) -> Point {
        let mut sum = [0.0; 3];
        for i in sector.first..sector.first + sector.count {
            add(&mut sum, &self.diagonal_normal(i));
        }
        sum
    }

    fn diagonal_normal(&self, i: usize) -> Point {
        cross(
            &minus(&self.across(i), &self.x),
            &minus(self.edge(i + 1), self.edge(i)),
        )
    }

    fn normal(&self, tables: &Tables, sector: Sector, linear: bool) -> Point {
        let mut ring = None;
        for _ in 0..3 {
            let at = ring.as_ref().unwrap_or(self);
            if let Some(n) = across(at.tangents(tables, sector, linear)) {
                let flip = at.rule() == Rule::Corner
                    && at.may_be_reflex(sector)
                    && dot(&n, &at.face_normal(sector)) < 0.0;
                return if flip { n.map(|c| -c) } else { n };
            }
            if linear {
                break;
            }
            // Parallel tangents: those of the next level may not be.
            let mut next = at.clone();
            next.advance(CreaseMethod::Uniform);
            ring = Some(next);
        }
        let faces = sector.first..sector.first + sector.count;
        unit(self.face_normal(sector))
            .or_else(|| faces.clone().find_map(|i| unit(self.diagonal_normal(i))))
            .or_else(|| (0..self.face_count()).find_map(|i| unit(self.diagonal_normal(i))))
            .unwrap_or([0.0, 0.0, 1.0])
    }

    /// One unit normal per sector, with the faces of the sector. The ring must not be semi-sharp.
    pub(super) fn normals(
        &self,
        tables: &Tables,
        linear: bool,
    ) -> Vec<(impl Iterator<Item = usize> + use<>, Point)> {
        let n = self.face_count();
        let wrap = move |r: Range<usize>| r.map(move |i| i % n);
        self.sectors(linear)
            .into_iter()
            .map(|s| {
                (
                    wrap(s.first..s.first + s.count),
                    self.normal(tables, s, linear),
                )
            })
            .collect()
    }
}
