//! Clipping of single triangles in homogeneous space, against the near plane and the guard band.
//!
//! Every new point is computed from the ends of its edge in one order, from the end inside to the end outside, so the two triangles
//! on an edge get the same bits and no gap opens between them. Sutherland, Hodgman, *Reentrant polygon clipping*, 1974; in f64.

use super::edge::ScreenVertex;
use super::project::GUARD_BAND;

/// A triangle cut by five planes has at most eight corners.
const MOST: usize = 8;

/// A vertex before division.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClipVertex {
    /// X, Y, W and (orthographic) depth.
    pub(super) h: [f64; 4],
    /// Where it stands on the screen, if it is inside and was snapped already.
    pub(super) snapped: Option<ScreenVertex>,
}

/// What is left of a triangle: a polygon on the screen.
pub(super) struct Polygon {
    vertices: [ScreenVertex; MOST],
    len: usize,
}

impl Polygon {
    pub(super) fn vertices(&self) -> &[ScreenVertex] {
        &self.vertices[..self.len]
    }
}

/// Signed distances, in any unit, to the near plane and the four sides of the guard band.
fn distance(plane: usize, h: &[f64; 4], near: f64, ortho: bool) -> f64 {
    let guard = f64::from(GUARD_BAND);
    match plane {
        0 if ortho => 2.0 - h[3],
        0 => h[2] - near,
        1 => guard * h[2] - h[0],
        2 => guard * h[2] + h[0],
        3 => guard * h[2] - h[1],
        _ => guard * h[2] + h[1],
    }
}

/// Clips a triangle. One with a coordinate that is not finite vanishes.
#[inline(never)]
pub(super) fn clip(triangle: &[ClipVertex; 3], near: f32, ortho: bool) -> Polygon {
    let mut polygon = [ClipVertex::default(); MOST];
    polygon[..3].copy_from_slice(triangle);
    let mut len = 3;
    if triangle.iter().any(|v| v.h.iter().any(|c| !c.is_finite())) {
        len = 0;
    }
    for plane in 0..5 {
        let mut kept = [ClipVertex::default(); MOST];
        let mut count = 0;
        let mut keep = |v: ClipVertex| {
            if count < MOST {
                kept[count] = v;
                count += 1;
            }
        };
        for k in 0..len {
            let (p, q) = (polygon[k], polygon[(k + 1) % len]);
            let dp = distance(plane, &p.h, f64::from(near), ortho);
            let dq = distance(plane, &q.h, f64::from(near), ortho);
            if dp >= 0.0 {
                keep(p);
            }
            if (dp >= 0.0) != (dq >= 0.0) {
                keep(if dp >= 0.0 {
                    cross(&p, dp, &q, dq)
                } else {
                    cross(&q, dq, &p, dp)
                });
            }
        }
        polygon = kept;
        len = count;
    }
    let mut out = Polygon {
        vertices: [ScreenVertex::default(); MOST],
        len,
    };
    for (o, v) in out.vertices.iter_mut().zip(&polygon[..len]) {
        *o = v.snapped.unwrap_or_else(|| snap(&v.h, ortho));
    }
    out
}

/// The point of an edge on a plane, from the end inside to the end outside.
fn cross(inside: &ClipVertex, d_in: f64, outside: &ClipVertex, d_out: f64) -> ClipVertex {
    let t = d_in / (d_in - d_out);
    let (p, q) = (&inside.h, &outside.h);
    ClipVertex {
        h: std::array::from_fn(|k| p[k] + (q[k] - p[k]) * t),
        snapped: None,
    }
}

fn snap(h: &[f64; 4], ortho: bool) -> ScreenVertex {
    let guard = f64::from(GUARD_BAND);
    let place = |v: f64| (v / h[2]).round_ties_even().clamp(-guard, guard) as i32;
    ScreenVertex {
        x: place(h[0]),
        y: place(h[1]),
        depth: if ortho {
            (h[3] as f32).max(f32::MIN_POSITIVE)
        } else {
            (1.0 / h[2]) as f32
        },
    }
}
