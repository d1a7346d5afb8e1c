//! Masks of the two tangents at a fan of any valence, closed or open.
//!
//! Halstead, Kass, DeRose, *Efficient, fair interpolation using Catmull-Clark surfaces*, 1993, for the interior; the second tangent of a
//! boundary is the exact left eigenvector of its rule, which for three or more faces differs from the usual one.

use crate::math;
use crate::topology::{Fan, FanRule, NONE, Topology};
use std::collections::BTreeMap;

/// Tangent weights around a fan of one kind, made once per topology.
#[derive(Clone, Debug)]
pub(crate) struct TangentMask {
    /// (T1, T2) weights of e0, f0, e1, f1, …; of the vertex at the end.
    pub(super) weights: Vec<[f64; 2]>,
}

impl TangentMask {
    /// The mask of a fan of `faces` faces.
    pub(super) fn of(closed: bool, faces: u32) -> Self {
        if closed {
            interior_tangents(faces)
        } else {
            boundary_tangents(faces)
        }
    }

    /// Factors that make the two tangents those of the flat star which the ring is closest to: spokes of unit length at equal angles
    /// give unit vectors. These are left times right eigenvectors; a right one is the mask with its edge weights divided by 4.
    pub(super) fn scales(&self, closed: bool) -> [f64; 2] {
        // Opposite spokes: the mask is ±1 there, and so is the star. The same along a boundary.
        if closed && self.weights.len() == 5 {
            return [0.5, 0.5];
        }
        let last = self.weights.len() - 2;
        let product = |k: usize| {
            let mut sum = 0.0;
            for (i, w) in self.weights[..=last].iter().enumerate() {
                // The ends of a boundary do not move in the second mode.
                if closed || (i > 0 && i < last) {
                    sum += w[k] * w[k] * if i % 2 == 0 { 0.25 } else { 1.0 };
                }
            }
            if sum > 0.0 { 1.0 / sum } else { 0.0 }
        };
        if closed {
            [product(0), product(1)]
        } else {
            [0.5, product(1)]
        }
    }
}

/// Tangent masks of all kinds of irregular fans of a mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct TangentMasks(BTreeMap<(bool, u32), TangentMask>);

impl TangentMasks {
    pub(crate) fn new(t: &Topology) -> Self {
        let mut masks = BTreeMap::new();
        for fan in t.fans() {
            if fan.first != NONE && fan.rule != FanRule::Corner {
                masks
                    .entry((fan.closed, fan.faces))
                    .or_insert_with(|| TangentMask::of(fan.closed, fan.faces));
            }
        }
        Self(masks)
    }

    /// The mask of a fan of the mesh.
    pub(super) fn of(&self, fan: &Fan) -> Option<&TangentMask> {
        self.0.get(&(fan.closed, fan.faces))
    }
}

/// Tangents at the corner that half-edge `h` begins with where its fan [is flat](Fan::is_flat), in a mesh that was refined until parameters run
/// `scale` times as fast: those of the masks. Of one face, of quads or triangles, they are along the crease and its second difference; of two
/// quads from side to side and across. Refinement halves the first, and quarters all others.
pub(crate) fn flat_tangents(
    t: &Topology,
    points: &[[f32; 3]],
    h: u32,
    scale: f32,
) -> Option<[[f32; 3]; 2]> {
    let fan = t.fans()[t.fan(h) as usize];
    if !fan.is_flat() {
        return None;
    }
    let at = |h: u32| points[t.vertex(h) as usize];
    let along = math::sub(at(t.next(h)), at(t.prev(h)));
    let square = scale * scale;
    if fan.closed {
        let far = |h: u32| at(t.next(t.next(h)));
        let across = math::sub(far(h), far(t.rotate(h)));
        return Some([math::scale(along, square), math::scale(across, square)]);
    }
    let side = |end: u32| math::sub(at(end), at(h));
    let bend = math::add(side(t.next(h)), side(t.prev(h)));
    Some([math::scale(along, scale), math::scale(bend, square)])
}

/// Subdominant eigenvalue of the sector angle `cos`, `cos_half`, and the weight of face points against edge points.
fn eigen(cos: f64, cos_half: f64) -> (f64, f64) {
    let lambda = 5.0 / 16.0 + (cos + cos_half * (2.0 * (9.0 + cos)).sqrt()) / 16.0;
    (lambda, 1.0 / (4.0 * lambda - 1.0))
}

fn interior_tangents(n: u32) -> TangentMask {
    if n == 2 {
        // The tangents of the valence-2 rule are the differences across; see the limits of valence 2 in the crate documentation.
        return TangentMask {
            weights: vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [0.0, 0.0]],
        };
    }
    let angle = |i: f64| 2.0 * std::f64::consts::PI * i / f64::from(n);
    let (_, c) = eigen(libm::cos(angle(1.0)), libm::cos(angle(0.5)));
    let mut weights = Vec::with_capacity(2 * n as usize + 1);
    for i in 0..n {
        let (a, b) = (angle(f64::from(i)), angle(f64::from(i + 1)));
        weights.push([4.0 * libm::cos(a), 4.0 * libm::sin(a)]);
        weights.push([
            c * (libm::cos(a) + libm::cos(b)),
            c * (libm::sin(a) + libm::sin(b)),
        ]);
    }
    weights.push([0.0; 2]);
    TangentMask { weights }
}

fn boundary_tangents(k: u32) -> TangentMask {
    let n = k as usize;
    let mut weights = vec![[0.0; 2]; 2 * n + 2];
    weights[0][0] = 1.0;
    weights[2 * n][0] = -1.0;
    if n == 1 {
        weights[0][1] = 1.0;
        weights[2][1] = 1.0;
        weights[3][1] = -2.0;
        return TangentMask { weights };
    }
    let angle = |i: f64| std::f64::consts::PI * i / f64::from(k);
    let (lambda, c) = eigen(libm::cos(angle(1.0)), libm::cos(angle(0.5)));
    let (mut edges, mut faces) = (0.0, 0.0);
    for i in 0..n {
        let (a, b) = (angle(i as f64), angle((i + 1) as f64));
        if i > 0 {
            weights[2 * i][1] = 4.0 * libm::sin(a);
            edges += weights[2 * i][1];
        }
        weights[2 * i + 1][1] = c * (libm::sin(a) + libm::sin(b));
        faces += weights[2 * i + 1][1];
    }
    // Weights of the two boundary edges and of the vertex from the eigenvector equations of the crease rule:
    // (1/2 − λ) la + 1/8 lx = −(1/4 lf0 + 1/16 le1),   la + (3/4 − λ) lx = −(3/8 Σle + 1/4 Σlf).
    let (p, q) = (
        -(0.25 * weights[1][1] + weights[2][1] / 16.0),
        -(0.375 * edges + 0.25 * faces),
    );
    let (a11, a12, a21, a22) = (0.5 - lambda, 0.125, 1.0, 0.75 - lambda);
    let det = a11 * a22 - a12 * a21;
    let la = (p * a22 - a12 * q) / det;
    weights[0][1] = la;
    weights[2 * n][1] = la;
    weights[2 * n + 1][1] = (a11 * q - a21 * p) / det;
    TangentMask { weights }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangent_weights_sum_to_zero() {
        for n in 2..=64 {
            for mask in [interior_tangents(n), boundary_tangents(n)] {
                for k in 0..2 {
                    let sum: f64 = mask.weights.iter().map(|w| w[k]).sum();
                    let size: f64 = mask.weights.iter().map(|w| w[k].abs()).sum();
                    assert!(sum.abs() <= 1e-12 * size, "{n} {k}: {sum}");
                }
            }
        }
    }

    #[test]
    fn tangents_of_a_flat_star_are_its_spokes() {
        for n in 3..=40 {
            for closed in [true, false] {
                let mask = TangentMask::of(closed, n);
                let scales = mask.scales(closed);
                let turn = if closed { 2.0 } else { 1.0 } * std::f64::consts::PI / f64::from(n);
                // Along the first spoke and across, of the right eigenvector.
                let c = mask.weights[1][1] / libm::sin(turn);
                let mut sums = [[0.0; 2]; 2];
                for (i, w) in mask.weights[..mask.weights.len() - 1].iter().enumerate() {
                    let (a, b) = (turn * (i / 2) as f64, turn * (i / 2 + 1) as f64);
                    let p = if i % 2 == 0 {
                        [libm::cos(a), libm::sin(a)]
                    } else {
                        [libm::cos(a) + libm::cos(b), libm::sin(a) + libm::sin(b)].map(|x| c * x)
                    };
                    for k in 0..2 {
                        for j in 0..2 {
                            sums[k][j] += w[k] * scales[k] * p[j];
                        }
                    }
                }
                assert!((sums[1][1] - 1.0).abs() < 1e-12, "{closed} {n} {sums:?}");
                assert!((sums[0][0] - 1.0).abs() < 1e-12, "{closed} {n} {sums:?}");
                assert!(sums[0][1].abs() < 1e-12, "{closed} {n} {sums:?}");
            }
        }
    }

    #[test]
    fn boundary_with_two_faces_has_the_bspline_tangent() {
        // Known mask of the regular boundary: x −4, a and b −1, e1 4, f 1 each, up to a factor.
        let w = boundary_tangents(2).weights;
        let k = w[1][1];
        let got: Vec<f64> = w.iter().map(|w| w[1] / k).collect();
        for (g, want) in got.iter().zip([-1.0, 1.0, 4.0, 1.0, -1.0, -4.0]) {
            assert!((g - want).abs() < 1e-12, "{got:?}");
        }
    }
}
