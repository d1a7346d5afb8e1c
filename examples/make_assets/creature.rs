//! An axolotl: 21 rings from snout to tail, half of it built and mirrored, then bent into a pose.
//!
//! The body is a tube of ten quads per half ring, closed at both ends by a 6 by 4 grid of quads, so there are no poles. Eyes, legs
//! and the slit of the mouth grow out of regions of that tube, gills and toes out of single quads; that is where the valences 3,
//! 5 and 6 come from.

use super::edit::Ring;
use super::limbs;
use super::mesh::{Mesh, V3, add, dot, length, mix, scale, sub, unit};
use super::refine::Net;
use super::unwrap::unwrap;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Labels of faces: what is unwrapped and painted as one.
pub(crate) mod label {
    pub(crate) const BACK: u32 = 0;
    pub(crate) const BELLY: u32 = 1;
    pub(crate) const MOUTH: u32 = 2;
    pub(crate) const EYE: u32 = 3;
    pub(crate) const LEG: u32 = 4;
    pub(crate) const SOLE: u32 = 5;
    pub(crate) const FOOT_RIM: u32 = 6;
    pub(crate) const GILL_FRONT: u32 = 7;
    pub(crate) const GILL_BACK: u32 = 8;
    pub(crate) const GILL_RIM: u32 = 9;
}

/// Quads in half a ring.
const ROWS: usize = 10;
/// The slit of the mouth lies between this line and the next.
const LIP: usize = 5;

/// Rings from the snout to the tip of the tail, by z.
const RINGS: [f64; 21] = [
    0.66, 0.60, 0.49, 0.37, 0.27, 0.18, 0.08, -0.03, -0.12, -0.21, -0.32, -0.43, -0.52, -0.61,
    -0.73, -0.86, -0.99, -1.12, -1.24, -1.35, -1.44,
];

/// z, half width, top, bottom, fin above, fin below.
const PROFILE: [[f64; 6]; 13] = [
    [0.72, 0.26, 0.60, 0.29, 0.0, 0.0],
    [0.64, 0.35, 0.67, 0.245, 0.0, 0.0],
    [0.54, 0.43, 0.755, 0.21, 0.0, 0.0],
    [0.40, 0.49, 0.83, 0.18, 0.0, 0.0],
    [0.25, 0.465, 0.81, 0.18, 0.0, 0.0],
    [0.12, 0.36, 0.70, 0.20, 0.0, 0.0],
    [0.02, 0.28, 0.62, 0.20, 0.0, 0.0],
    [-0.12, 0.285, 0.59, 0.16, 0.02, 0.0],
    [-0.35, 0.325, 0.59, 0.11, 0.08, 0.0],
    [-0.55, 0.265, 0.55, 0.14, 0.14, 0.0],
    [-0.74, 0.175, 0.49, 0.21, 0.21, 0.03],
    [-1.05, 0.100, 0.44, 0.27, 0.27, 0.13],
    [-1.46, 0.040, 0.38, 0.33, 0.10, 0.07],
];

/// The profile at z: cubic Hermite between the knots with the slopes of the neighbours.
pub(crate) fn profile(z: f64) -> [f64; 5] {
    let n = PROFILE.len();
    let k = (0..n - 2)
        .find(|&k| z >= PROFILE[k + 1][0])
        .unwrap_or(n - 2);
    let slope = |k: usize, c: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(n - 1));
        (PROFILE[b][c] - PROFILE[a][c]) / (PROFILE[b][0] - PROFILE[a][0])
    };
    let (z0, z1) = (PROFILE[k][0], PROFILE[k + 1][0]);
    let (h, t) = (z1 - z0, (z - z0) / (z1 - z0));
    std::array::from_fn(|i| {
        let c = i + 1;
        let (p, q) = (PROFILE[k][c], PROFILE[k + 1][c]);
        let (m, l) = (slope(k, c) * h, slope(k + 1, c) * h);
        let (t2, t3) = (t * t, t * t * t);
        p * (2.0 * t3 - 3.0 * t2 + 1.0)
            + m * (t3 - 2.0 * t2 + t)
            + q * (3.0 * t2 - 2.0 * t3)
            + l * (t3 - t2)
    })
}

/// 0 below `a`, 1 above `b`, smooth between.
pub(crate) fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Height of the mouth at z: nearly level in front, a smile further back.
pub(crate) fn mouth_height(z: f64) -> f64 {
    0.36 + 0.17 * smoothstep(0.74, 0.38, z)
}

/// Point of line `j` on the ring at `z`.
fn ring_point(z: f64, j: usize) -> V3 {
    let [w, top, bottom, fin_above, fin_below] = profile(z);
    let (mid, h) = ((top + bottom) / 2.0, (top - bottom) / 2.0);
    // Angle of the mouth, which the lines around it make room for; behind the mouth the lines are even.
    let even = PI * (LIP as f64 + 0.5) / ROWS as f64;
    let open = smoothstep(0.24, 0.44, z);
    let lip = libm::acos(((mouth_height(z) - mid) / h).clamp(-0.9, 0.9));
    let middle = even + (lip - even) * open;
    let gap = PI / ROWS as f64 / 2.0 * (1.0 - 0.80 * open);
    let angle = if j <= LIP {
        (middle - gap) * j as f64 / LIP as f64
    } else {
        let t = (ROWS - j) as f64 / (ROWS - LIP - 1) as f64;
        PI - (PI - middle - gap) * t
    };
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    let round = |x: f64| x.signum() * libm::pow(x.abs(), 0.9);
    // Narrower above than at the cheeks.
    let w = w * (1.0 - 0.14 * c.max(0.0));
    let mut p = [w * round(s), mid + h * round(c), z];
    // Fins pull the lines next to the middle together and out.
    let thin = |fin: f64| smoothstep(0.0, 0.09, fin);
    match j {
        0 => p[1] += fin_above,
        1 => {
            p[1] += 0.62 * fin_above;
            p[0] += (0.028 - p[0]) * thin(fin_above);
        }
        2 => p[1] += 0.08 * fin_above,
        8 => p[1] -= 0.08 * fin_below,
        9 => {
            p[1] -= 0.62 * fin_below;
            p[0] += (0.026 - p[0]) * thin(fin_below);
        }
        10 => p[1] -= fin_below,
        _ => {}
    }
    if j == 0 || j == ROWS {
        p[0] = 0.0;
    }
    p
}

/// Builds the half body and names its faces by section and row.
pub(crate) struct Body {
    pub(crate) mesh: Mesh,
    /// `face[section][row]`.
    pub(crate) face: Vec<[usize; ROWS]>,
    /// Faces of the snout, `snout[row][column]`, column 0 at the mirror plane.
    snout: [[usize; 3]; 4],
}

fn body() -> Body {
    let mut m = Mesh::new("");
    let lines: Vec<[usize; ROWS + 1]> = RINGS
        .iter()
        .map(|&z| std::array::from_fn(|j| m.point(ring_point(z, j))))
        .collect();
    let row_label = |j: usize| {
        if j <= LIP { label::BACK } else { label::BELLY }
    };
    let face = lines
        .windows(2)
        .map(|w| {
            std::array::from_fn(|j| {
                m.labelled(&[w[0][j], w[0][j + 1], w[1][j + 1], w[1][j]], row_label(j))
            })
        })
        .collect();
    let snout = cap(&mut m, &lines[0], 0.10, false);
    cap(&mut m, &lines[RINGS.len() - 1], -0.07, true);
    Body {
        mesh: m,
        face,
        snout,
    }
}

/// Closes an end of the tube with three columns and four rows of quads, domed by `depth` along z.
fn cap(m: &mut Mesh, line: &[usize; ROWS + 1], depth: f64, flip: bool) -> [[usize; 3]; 4] {
    let mut v = [[0; 4]; 5];
    for (c, &i) in line[..4].iter().enumerate() {
        v[0][c] = i;
    }
    for (c, &i) in line[ROWS - 3..].iter().rev().enumerate() {
        v[4][c] = i;
    }
    let (top, bottom) = (m.points[line[0]], m.points[line[ROWS]]);
    for r in 1..4 {
        v[r][3] = line[3 + r];
        let side = m.points[line[3 + r]];
        // In the middle column the mouth keeps its height; elsewhere rows are even.
        let even = mix(top, bottom, r as f64 / 4.0);
        let mut middle = even[1];
        if !flip {
            let lip = mouth_height(0.7);
            middle = match r {
                1 => (top[1] + lip) / 2.0 + 0.01,
                2 => lip + 0.010,
                _ => lip - 0.010,
            };
        }
        for (c, vertex) in v[r].iter_mut().enumerate().take(3) {
            let a = c as f64 / 3.0;
            let b = 2.0 * r as f64 / 4.0 - 1.0;
            let dome = (1.0 - a * a) * (1.0 - 0.6 * b * b);
            let p = [
                side[0] * a,
                middle + (side[1] - middle) * a * a,
                side[2] + depth * dome,
            ];
            *vertex = m.point(p);
        }
    }
    std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let mut f = [v[r][c], v[r + 1][c], v[r + 1][c + 1], v[r][c + 1]];
            if flip {
                f.reverse();
            }
            let l = if r < 3 { label::BACK } else { label::BELLY };
            m.labelled(&f, l)
        })
    })
}

/// Two by two faces of the tube.
pub(crate) fn patch(b: &Body, section: usize, row: usize) -> [usize; 4] {
    [
        b.face[section][row],
        b.face[section][row + 1],
        b.face[section + 1][row],
        b.face[section + 1][row + 1],
    ]
}

/// Middle and axis of the right eye.
pub(crate) const EYE: [V3; 2] = [[0.345, 0.605, 0.485], [0.74, 0.36, 0.56]];

/// A bulging eye in a low lid.
fn eye(b: &mut Body) {
    let region = patch(b, 1, 2);
    let axis = unit(EYE[1]);
    // Room for the lid: the patch is a little smaller than the eye.
    let rim: BTreeSet<usize> = region
        .iter()
        .flat_map(|&f| b.mesh.faces[f].clone())
        .collect();
    for v in rim {
        let d = sub(b.mesh.points[v], EYE[0]);
        let out = scale(axis, dot(axis, d));
        let d = sub(d, out);
        let far = length(d).max(0.158);
        if length(d) > 0.06 {
            b.mesh.points[v] = add(EYE[0], add(out, scale(unit(d), far)));
        }
    }
    for (radius, height) in [
        (0.124, 0.012),
        (0.114, 0.032),
        (0.103, 0.032),
        (0.098, 0.062),
        (0.061, 0.097),
    ] {
        let ring = Ring {
            centre: add(EYE[0], scale(axis, height)),
            axis,
            side: [0.0, 1.0, 0.0],
            radii: [radius; 2],
        };
        let own = if radius < 0.11 {
            label::EYE
        } else {
            label::BACK
        };
        let e = b.mesh.grow(&region, &ring, |_| own);
        for &v in &e.inner {
            b.mesh.points[v] = add(b.mesh.points[v], scale(axis, 0.008));
        }
    }
    for f in region {
        b.mesh.labels[f] = label::EYE;
    }
}

/// The slit: the row between the lips, from the middle to the corner of the mouth, pushed inwards.
fn mouth(b: &mut Body) {
    let mut region = b.snout[LIP - 3].to_vec();
    region.extend((0..2).map(|s| b.face[s][LIP]));
    for depth in [0.06] {
        let e = b.mesh.extrude(&region, |_| label::MOUTH);
        for &v in e.rim.iter().chain(&e.inner) {
            let p = b.mesh.points[v];
            let inward = unit([-p[0] * 0.9, 0.0, 0.25 - p[2]]);
            b.mesh.points[v] = add(p, scale(inward, depth));
            if p[0].abs() < 1e-9 {
                b.mesh.points[v][0] = 0.0;
            }
        }
    }
    for f in region {
        b.mesh.labels[f] = label::MOUTH;
    }
}

/// The creature as it stands, and its points in the straight pose in which it is unwrapped and painted.
pub(crate) struct Creature {
    pub(crate) mesh: Mesh,
    pub(crate) rest: Vec<V3>,
}

pub(crate) fn build() -> Creature {
    let mut b = body();
    mouth(&mut b);
    eye(&mut b);
    limbs::grow(&mut b);
    let mut m = b.mesh;
    m.mirror();
    let mut weights = vec![0.3; m.points.len()];
    for (f, face) in m.faces.iter().enumerate() {
        if m.labels[f] != label::BACK && m.labels[f] != label::BELLY {
            for &v in face {
                weights[v] = 0.0;
            }
        }
    }
    m.relax(&weights, 4);
    let smooth = |m: &Mesh| {
        let net = Net::new(m.points.clone(), m.faces.clone());
        net.refine().refine().refine().points
    };
    let at = smooth(&m);
    unwrap(&mut m, &at, |l| match l {
        label::EYE => 1.4,
        label::MOUTH | label::SOLE => 0.7,
        _ => 1.0,
    });
    let rest = m.points.clone();
    m.points = rest.iter().map(|&p| pose(p)).collect();
    // The smooth surface, not the cage, stands on the ground.
    let low = smooth(&m).iter().map(|p| p[1]).fold(f64::MAX, f64::min);
    for p in &mut m.points {
        p[1] -= low;
    }
    m.title = "Axolotl: closed, all quads, one texture.".to_owned();
    m.library = Some("creature.mtl".to_owned());
    m.materials = vec!["skin"; m.faces.len()];
    Creature { mesh: m, rest }
}

/// Bends the rest pose: a step forward, head tilted and turned, tail swung round.
fn pose([x, y, z]: V3) -> V3 {
    // Legs of one diagonal step ahead, those of the other back.
    let diagonal = if (z > -0.33) == (x > 0.0) { 1.0 } else { -1.0 };
    let z = z + diagonal
        * 0.07
        * smoothstep(0.34, 0.02, y)
        * smoothstep(0.24, 0.42, x.abs())
        * smoothstep(0.30, 0.15, z);
    // Head.
    let head = smoothstep(-0.02, 0.30, z);
    let tilt = -0.10 * head;
    let (s, c) = (libm::sin(tilt), libm::cos(tilt));
    let (dx, dy) = (x, y - 0.42);
    let (x, y) = (c * dx - s * dy, 0.42 + s * dx + c * dy);
    let y = y + 0.03 * head + 0.12 * smoothstep(-0.8, -1.5, z);
    // Spine: the heading is a function of z, the curve its integral. Hind legs turn as a whole about the hip.
    let heading = |z: f64| 0.22 * smoothstep(0.0, 0.45, z) - 1.6 * smoothstep(-0.45, -1.60, z);
    let hip = -0.56;
    let rigid = if z < -0.33 {
        smoothstep(0.20, 0.34, x.abs())
    } else {
        0.0
    };
    let at = z + (hip - z) * rigid;
    let steps = 64;
    let h = at / f64::from(steps);
    let mut spine = [0.0, 0.0];
    for k in 0..steps {
        let a = heading((f64::from(k) + 0.5) * h);
        spine[0] += libm::sin(a) * h;
        spine[1] += libm::cos(a) * h;
    }
    let (s, c) = (libm::sin(heading(at)), libm::cos(heading(at)));
    let rest = z - at;
    [spine[0] + x * c + rest * s, y, spine[1] - x * s + rest * c]
}
