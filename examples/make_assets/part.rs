//! A flange: lobed plate, six bolt holes, a hub with a bore and two set-screw holes, open underneath.
//!
//! Half of the faces are no quads: pentagons where 48 columns become 24, octagons between the bolt holes, triangles in the bore
//! where 24 columns become 12. Twice the same part: once with support loops, so that plain smoothing keeps its edges, and once
//! with fewer faces and crease tags in their place.

use super::edit::Ring;
use super::mesh::{Mesh, V3};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Columns around the plate and hub.
const N: usize = 24;

/// Materials of the part.
pub(crate) const MATERIALS: &str = "\
newmtl steel
Kd 0.46 0.53 0.60

newmtl brass
Kd 0.86 0.60 0.25
";

fn polar(r: f64, y: f64, k: f64, n: usize) -> V3 {
    let a = TAU * k / n as f64;
    [r * libm::sin(a), y, r * libm::cos(a)]
}

/// Adds a circle of `n` points; `lobes` pulls it out at the bolts.
fn circle(m: &mut Mesh, n: usize, r: f64, y: f64, lobes: f64) -> Vec<usize> {
    (0..n)
        .map(|k| {
            let wave = libm::cos(6.0 * TAU * k as f64 / n as f64);
            m.point(polar(r + lobes * wave, y, k as f64, n))
        })
        .collect()
}

/// Quads between two circles, from the lower or outer one to the upper or inner one.
fn band(m: &mut Mesh, a: &[usize], b: &[usize]) -> Vec<usize> {
    let n = a.len();
    (0..n)
        .map(|k| m.face(&[a[k], a[(k + 1) % n], b[(k + 1) % n], b[k]]))
        .collect()
}

/// Drills a hole into a two by two patch: a collar, an edge and a wall that stays open.
fn drill(
    m: &mut Mesh,
    patch: [usize; 4],
    top: V3,
    axis: V3,
    radius: f64,
    depth: f64,
    support: bool,
) -> (Vec<usize>, Vec<usize>) {
    let at = |down: f64| -> V3 { std::array::from_fn(|k| top[k] - axis[k] * down) };
    let mut rings = vec![(1.5, 0.0), (1.0, 0.0), (1.0, depth)];
    if support {
        rings.insert(1, (1.14, 0.0));
        rings.insert(3, (1.0, 0.022));
    }
    let mut walls = Vec::new();
    let mut edge = Vec::new();
    for (factor, down) in rings {
        let ring = Ring {
            centre: at(down),
            axis,
            side: if axis[1] > 0.5 {
                [top[0], 0.0, top[2]]
            } else {
                [0.0, 1.0, 0.0]
            },
            radii: [radius * factor; 2],
        };
        let e = m.grow(&patch, &ring, |_| 0);
        if factor == 1.0 && down == 0.0 {
            edge = e.rim.clone();
        }
        if down > 0.0 || (factor < 1.1 && support) {
            walls.extend(e.sides);
        }
    }
    (walls, edge)
}

fn ring_edges(v: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    (0..v.len()).map(|k| (v[k], v[(k + 1) % v.len()]))
}

/// The part. `support` chooses loops beside the edges over crease tags.
pub(crate) fn build(support: bool) -> Mesh {
    let mut m = Mesh::new(if support {
        "Flange: triangles, quads, pentagons and octagons; open boundaries; two materials."
    } else {
        "Flange as in part.obj, with crease tags instead of support loops."
    });
    m.library = Some("part.mtl".to_owned());
    // Radius, height, columns, lobes, crease sharpness (without support), only with support.
    let profile: [(f64, f64, usize, f64, f64, bool); 21] = [
        (1.0, 0.0, 48, 0.075, 0.0, false),
        (1.0, 0.035, 48, 0.075, 0.0, true),
        (1.0, 0.165, 48, 0.075, 0.0, true),
        (1.0, 0.20, 48, 0.075, 10.0, false),
        (0.965, 0.20, 48, 0.073, 0.0, true),
        (0.905, 0.20, N, 0.04, 0.0, false),
        (0.745, 0.20, N, 0.0, 0.0, false),
        (0.585, 0.20, N, 0.0, 0.0, false),
        (0.46, 0.20, N, 0.0, 0.0, false),
        (0.40, 0.215, N, 0.0, 0.0, true),
        (0.375, 0.26, N, 0.0, 3.0, false),
        (0.37, 0.34, N, 0.0, 0.0, false),
        (0.37, 0.45, N, 0.0, 0.0, false),
        (0.37, 0.56, N, 0.0, 0.0, false),
        (0.37, 0.605, N, 0.0, 0.0, true),
        (0.37, 0.63, N, 0.0, 10.0, false),
        (0.345, 0.63, N, 0.0, 0.0, true),
        (0.29, 0.63, N, 0.0, 0.0, true),
        (0.265, 0.63, N, 0.0, 10.0, false),
        (0.265, 0.60, N, 0.0, 0.0, true),
        (0.265, 0.36, N, 0.0, 0.0, false),
    ];
    let mut rows: Vec<(f64, f64, Vec<usize>, Vec<usize>)> = Vec::new();
    for (r, y, n, lobes, sharpness, extra) in profile {
        if extra && !support {
            continue;
        }
        let line = circle(&mut m, n, r, y, lobes);
        if !support && sharpness > 0.0 {
            let edges: Vec<_> = ring_edges(&line).collect();
            m.creases
                .extend(edges.iter().map(|&(a, b)| (a, b, sharpness)));
        }
        let mut faces = Vec::new();
        if let Some((_, _, below, _)) = rows.last() {
            let below = below.clone();
            faces = if below.len() == n {
                band(&mut m, &below, &line)
            } else {
                (0..n)
                    .map(|k| {
                        let next = (k + 1) % n;
                        m.face(&[
                            below[2 * k],
                            below[2 * k + 1],
                            below[2 * next],
                            line[next],
                            line[k],
                        ])
                    })
                    .collect()
            };
        }
        rows.push((r, y, line, faces));
    }
    // The bore: 24 columns become 12 by triangles, then run to the ground.
    let mut brass: BTreeSet<usize> = BTreeSet::new();
    let above = rows[rows.len() - 1].2.clone();
    let low = circle(&mut m, N / 2, 0.27, 0.16, 0.0);
    for k in 0..N / 2 {
        let (a, b, c) = (above[2 * k], above[2 * k + 1], above[(2 * k + 2) % N]);
        let (p, q) = (low[k], low[(k + 1) % (N / 2)]);
        for t in [[a, b, p], [b, q, p], [b, c, q]] {
            brass.insert(m.face(&t));
        }
    }
    let ground = circle(&mut m, N / 2, 0.27, 0.0, 0.0);
    brass.extend(band(&mut m, &low, &ground));
    let find = |r: f64, y: f64| rows.iter().position(|row| row.0 == r && row.1 == y);
    let (Some(inner), Some(hub), Some(bore)) =
        (find(0.745, 0.20), find(0.37, 0.45), find(0.265, 0.63))
    else {
        return m;
    };
    for row in &rows[bore + 1..] {
        brass.extend(&row.3);
    }
    // Bolt holes; between them four quads become an octagon.
    let mut dead = BTreeSet::new();
    for bolt in 0..6 {
        let column = |k: usize| (4 * bolt + k + N) % N;
        let (l, r) = (column(N - 1), column(0));
        let faces = |row: usize, k: usize| rows[row].3[k];
        let patch = [
            faces(inner, l),
            faces(inner, r),
            faces(inner + 1, l),
            faces(inner + 1, r),
        ];
        let top = polar(0.745, 0.20, r as f64, N);
        let (walls, edge) = drill(&mut m, patch, top, [0.0, 1.0, 0.0], 0.085, 0.13, support);
        brass.extend(walls);
        dead.extend(patch);
        if !support {
            m.creases
                .extend(ring_edges(&edge).map(|(a, b)| (a, b, 10.0)));
        }
        let (c, d) = (column(1), column(2));
        let e = column(3);
        let (o, i, n) = (&rows[inner - 1].2, &rows[inner].2, &rows[inner + 1].2);
        m.face(&[o[c], o[d], o[e], i[e], n[e], n[d], n[c], i[c]]);
        for row in [inner, inner + 1] {
            dead.extend([faces(row, c), faces(row, d)]);
        }
    }
    // Set-screw holes in the hub.
    for k in [2, 14] {
        let patch = [
            rows[hub].3[k - 1],
            rows[hub].3[k],
            rows[hub + 1].3[k - 1],
            rows[hub + 1].3[k],
        ];
        let (top, axis) = (
            polar(0.365, 0.45, k as f64, N),
            polar(1.0, 0.0, k as f64, N),
        );
        let (walls, edge) = drill(&mut m, patch, top, axis, 0.055, 0.07, support);
        brass.extend(walls);
        dead.extend(patch);
        if !support {
            m.creases
                .extend(ring_edges(&edge).map(|(a, b)| (a, b, 10.0)));
        }
    }
    m.materials = (0..m.faces.len())
        .map(|f| if brass.contains(&f) { "brass" } else { "steel" })
        .collect();
    m.remove(&dead);
    m
}
