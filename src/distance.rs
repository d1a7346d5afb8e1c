//! How far patches are from the limit surface that they stand for.
//!
//! Two distances of each point of a patch: to the point of the limit surface with the same parameters, and to the nearest point that is found from
//! there, by Gauss and Newton's steps on the same face. The second is what is seen; the first is what texture coordinates, and colours, are off
//! by. Interpolating surfaces are known at few places, so of them there is the first alone.

use crate::evaluate::{FaceEvaluator, Tangents};
use crate::math;
use crate::mesh::{Cage, CageError};
use crate::patch::PatchKind;
use crate::surface::{DicedQuad, Surface, SurfaceOptions};

/// Most steps towards the nearest point.
const STEPS: u32 = 12;

/// The points of one face, with their distances.
#[derive(Clone, Debug, Default)]
pub struct FaceDistances {
    /// The face as it is diced.
    pub diced: DicedQuad,
    /// Distance of every point to the nearest point of the limit surface that was found, in model units.
    pub nearest: Vec<f32>,
    /// Distance to the limit point with the same parameters.
    pub same: Vec<f32>,
}

/// What many distances come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Points.
    pub points: u64,
    /// Largest distance to the nearest point.
    pub max: f64,
    /// Largest distance to the point with the same parameters.
    pub max_same: f64,
    squares: f64,
    squares_same: f64,
}

impl Summary {
    /// Adds a face.
    pub fn add(&mut self, face: &FaceDistances) {
        for (&a, &b) in face.nearest.iter().zip(&face.same) {
            let (a, b) = (f64::from(a), f64::from(b));
            self.points += 1;
            self.max = self.max.max(a);
            self.max_same = self.max_same.max(b);
            self.squares += a * a;
            self.squares_same += b * b;
        }
    }

    /// Adds what other points come to.
    pub fn merge(&mut self, other: &Self) {
        self.points += other.points;
        self.max = self.max.max(other.max);
        self.max_same = self.max_same.max(other.max_same);
        self.squares += other.squares;
        self.squares_same += other.squares_same;
    }

    /// Root of the mean square of the distances to nearest points.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares / self.points.max(1) as f64).sqrt()
    }

    /// The same of points with the same parameters.
    #[must_use]
    pub fn rms_same(&self) -> f64 {
        (self.squares_same / self.points.max(1) as f64).sqrt()
    }
}

/// The limit surface that the patches of `surface` stand for: of the same cage, corner by corner.
#[must_use]
pub fn limit_of(surface: &Surface, options: &SurfaceOptions) -> Surface {
    let options = SurfaceOptions {
        patches: PatchKind::None,
        ..*options
    };
    Surface::new(surface.cage().clone(), &options)
}

/// Limit positions of the cage's vertices: what a cage is moved to so that surfaces through its vertices come close to its limit surface.
#[must_use]
pub fn limit_points(limit: &Surface) -> Vec<[f32; 3]> {
    let (t, quads) = (limit.topology(), limit.quads());
    let mut out = limit.cage().points().to_vec();
    for h in 0..t.half_count() as u32 {
        // Faces that are split have a quad at each corner.
        let corner = if limit.is_split() { 4 * h } else { h };
        out[t.vertex(h) as usize] = limit.fan_limit(quads.fan(corner)).0;
    }
    out
}

/// Distances of face `q` of [`Surface::quads`], diced at `level`, from `limit`, which has the same faces. Empty where there is no such face.
///
/// # Panics
/// When `level` is above 10.
#[must_use]
pub fn of_face(surface: &Surface, limit: &Surface, q: u32, level: u32) -> FaceDistances {
    if q as usize >= surface.quads().face_count() {
        return FaceDistances::default();
    }
    let Some(mut face) = limit.face_evaluator(limit.cage_face(q)) else {
        return FaceDistances::default();
    };
    let diced = surface.dice(q, level);
    let mut out = FaceDistances {
        diced,
        ..FaceDistances::default()
    };
    let n = out.diced.side;
    for (k, &p) in out.diced.points.iter().enumerate() {
        let (i, j) = (k % n, k / n);
        let i = if limit.is_triangular() { i.max(j) } else { i };
        let [s, t] = [i, j].map(|k| k as f32 / (n - 1) as f32);
        let patch = Patch::of(limit, q);
        let (same, nearest) = patch.distances(&mut face, patch.place(s, t), p);
        out.same.push(same);
        out.nearest.push(nearest.min(same));
    }
    out
}

/// Where a face that is diced lies in its face of the cage.
enum Patch {
    Whole,
    /// The quad at a corner of a quad.
    Quarter(u32),
    /// The quad at a corner of another polygon.
    Sector(u32),
    Triangle,
    /// Known at dyadic places alone.
    Dyadic(bool),
}

impl Patch {
    fn of(limit: &Surface, q: u32) -> Self {
        let t = limit.topology();
        if limit.scheme().is_interpolating() && !limit.is_split() {
            return Self::Dyadic(limit.is_triangular());
        }
        if limit.is_triangular() {
            return Self::Triangle;
        }
        if !limit.is_split() {
            return Self::Whole;
        }
        let halves = t.face_halves(t.face_of(q));
        match halves.len() {
            4 => Self::Quarter(q - halves.start),
            _ => Self::Sector(q - halves.start),
        }
    }

    /// The parameters of the cage's face at (`s`, `t`) of the grid.
    fn place(&self, s: f32, t: f32) -> [f32; 2] {
        let (a, b) = (s * 0.5, t * 0.5);
        match self {
            Self::Whole | Self::Dyadic(false) => [s, t],
            Self::Triangle | Self::Dyadic(true) => [s - t, t],
            Self::Quarter(0) => [a, b],
            Self::Quarter(1) => [1.0 - b, a],
            Self::Quarter(2) => [1.0 - a, 1.0 - b],
            Self::Quarter(_) => [b, 1.0 - a],
            // The end of one quad would be the beginning of the next.
            Self::Sector(k) => {
                let k = *k as f32;
                [(k + s).min((k + 1.0).next_down()), t]
            }
        }
    }

    /// The nearest parameters on the face.
    fn inside(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        match self {
            Self::Triangle | Self::Dyadic(true) => {
                let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
                let over = ((u + v - 1.0) * 0.5).max(0.0);
                let v = (v - over).clamp(0.0, 1.0);
                [(u - over).clamp(0.0, 1.0 - v), v]
            }
            Self::Sector(k) => {
                let k = *k as f32;
                [u.clamp(k, (k + 1.0).next_down()), v.clamp(0.0, 1.0)]
            }
            _ => [u, v].map(|c| c.clamp(0.0, 1.0)),
        }
    }

    /// Distance of `p` to the limit point at a place, and to the nearest that is found from there.
    fn distances(&self, face: &mut FaceEvaluator<'_>, place: [f32; 2], p: [f32; 3]) -> (f32, f32) {
        let mut at = |[u, v]: [f32; 2]| face.at_as::<Tangents>(u, v);
        let distance = |sample: &Tangents| math::length(math::sub(p, sample.position));
        let mut place = self.inside(place);
        let Some(mut sample) = at(place) else {
            return (f32::INFINITY, f32::INFINITY);
        };
        let same = distance(&sample);
        let mut best = same;
        if matches!(self, Self::Dyadic(_)) {
            return (same, same);
        }
        for _ in 0..STEPS {
            let (d, du, dv) = (math::sub(p, sample.position), sample.du, sample.dv);
            let (a, b, c) = (math::dot(du, du), math::dot(du, dv), math::dot(dv, dv));
            let (x, y) = (math::dot(d, du), math::dot(d, dv));
            let det = a * c - b * b;
            if det.is_nan() || det <= 1e-12 * a * c {
                break;
            }
            let mut step = [(x * c - y * b) / det, (y * a - x * b) / det];
            let mut better = None;
            // Half as far while it leads away.
            for _ in 0..4 {
                let to = self.inside([place[0] + step[0], place[1] + step[1]]);
                if let Some(found) = at(to).filter(|s| distance(s) < best) {
                    better = Some((to, found));
                    break;
                }
                step = step.map(|c| c * 0.5);
            }
            let Some((to, found)) = better else { break };
            let now = distance(&found);
            let enough = now > best * 0.999;
            (place, sample, best) = (to, found, now);
            if enough {
                break;
            }
        }
        (same, best)
    }
}

/// A cap of the unit sphere around a vertex of valence `n`, three rings of quads or triangles wide, edges a third as long as the radius. The first
/// `n` faces are those around the vertex, which is their first corner.
///
/// # Errors
/// [`CageError`] when `n` is below 3.
pub fn cap(n: u32, triangles: bool) -> Result<Cage, CageError> {
    const RINGS: u32 = 3;
    const EDGE: f64 = 0.3;
    let point = |turn: f64, rings: f64| {
        let (a, r) = (turn * std::f64::consts::TAU / f64::from(n), rings * EDGE);
        let (s, c) = (libm::sin(r), libm::cos(r));
        [s * libm::cos(a), s * libm::sin(a), c].map(|c| c as f32)
    };
    let mut points = vec![point(0.0, 0.0)];
    let (mut sizes, mut corners, mut outer) = (Vec::new(), Vec::new(), Vec::new());
    let mut face = |near: bool, f: &[u32]| {
        if near {
            sizes.push(f.len() as u32);
            corners.extend_from_slice(f);
        } else {
            outer.extend_from_slice(f);
        }
    };
    if triangles {
        for r in 1..=RINGS {
            points.extend((0..n * r).map(|k| point(f64::from(k) / f64::from(r), f64::from(r))));
        }
        let at = |r: u32, k: u32| match r {
            0 => 0,
            _ => 1 + n * r * (r - 1) / 2 + k % (n * r),
        };
        for r in 1..=RINGS {
            for s in 0..n {
                for k in 0..r {
                    let inner = at(r - 1, s * (r - 1) + k);
                    face(r == 1, &[inner, at(r, s * r + k), at(r, s * r + k + 1)]);
                    if k + 1 < r {
                        let next = at(r - 1, s * (r - 1) + k + 1);
                        face(false, &[inner, at(r, s * r + k + 1), next]);
                    }
                }
            }
        }
    } else {
        // In every sector column 1 and on, of rows 0 and on; column 0 is row 0 of the next sector.
        for s in 0..n {
            for j in 0..=RINGS {
                points.extend((1..=RINGS).map(|i| {
                    let (x, y) = (f64::from(i), f64::from(j));
                    let turn = libm::atan2(y, x) / std::f64::consts::FRAC_PI_2;
                    point(f64::from(s) + turn, libm::sqrt(x * x + y * y))
                }));
            }
        }
        let at = |s: u32, i: u32, j: u32| match (i, j) {
            (0, 0) => 0,
            (0, j) => 1 + (s + 1) % n * RINGS * (RINGS + 1) + j - 1,
            (i, j) => 1 + (s % n * (RINGS + 1) + j) * RINGS + i - 1,
        };
        for s in 0..n {
            for j in 0..RINGS {
                for i in 0..RINGS {
                    let quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| at(s, i + a, j + b));
                    face(i + j == 0, &quad);
                }
            }
        }
    }
    let size = if triangles { 3 } else { 4 };
    sizes.resize(sizes.len() + outer.len() / size as usize, size);
    corners.extend(outer);
    match n {
        0..3 => Err(CageError::ShortFace {
            face: 0,
            corners: n as usize,
        }),
        _ => Cage::new(points, &sizes, corners),
    }
}
