//! Small cages, each for one fact of subdivision: valences 3 to 24, boundaries, corners, a seam, a one-sided strip.

use super::mesh::{Mesh, V3};
use std::f64::consts::{PI, TAU};

/// All of them, by file name.
pub(crate) fn all() -> Vec<(String, Mesh)> {
    let mut all: Vec<(String, Mesh)> = vec![
        ("cube".into(), cube()),
        ("tetrahedron".into(), tetrahedron()),
        ("octahedron".into(), octahedron()),
        ("torus".into(), torus(12, 8)),
        ("mobius".into(), mobius(16)),
        ("grid".into(), grid()),
        ("corner".into(), corner()),
    ];
    for n in [3, 5, 8, 24] {
        all.push((format!("fan{n}"), fan(n)));
    }
    all
}

fn cube() -> Mesh {
    let mut m = Mesh::new("Cube: 8 vertices of valence 3, 6 quads.");
    for i in 0..8_u8 {
        let sign = |bit: u8| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        m.point([sign(0), sign(1), sign(2)]);
    }
    for f in [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ] {
        m.face(&f);
    }
    m
}

fn tetrahedron() -> Mesh {
    let mut m = Mesh::new("Tetrahedron: 4 vertices of valence 3, 4 triangles.");
    for p in [
        [1.0, 1.0, 1.0],
        [-1.0, -1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [1.0, -1.0, -1.0],
    ] {
        m.point(p);
    }
    for f in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        m.face(&f);
    }
    m
}

fn octahedron() -> Mesh {
    let mut m = Mesh::new("Octahedron: 6 vertices of valence 4, 8 triangles.");
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut p = [0.0; 3];
            p[axis] = sign;
            m.point(p);
        }
    }
    for i in 0..8_usize {
        let (x, y, z) = (i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2));
        if i.count_ones().is_multiple_of(2) {
            m.face(&[x, y, z]);
        } else {
            m.face(&[x, z, y]);
        }
    }
    m
}

/// A closed surface without extraordinary vertices; the chart is cut along one meridian and one parallel.
fn torus(n: usize, k: usize) -> Mesh {
    let mut m = Mesh::new("Torus: every vertex has valence 4. One chart, cut twice.");
    for i in 0..n {
        let a = TAU * i as f64 / n as f64;
        for j in 0..k {
            let b = TAU * j as f64 / k as f64;
            let r = 1.0 + 0.45 * libm::cos(b);
            m.point([r * libm::cos(a), 0.45 * libm::sin(b), -r * libm::sin(a)]);
        }
    }
    for i in 0..=n {
        for j in 0..=k {
            m.uvs.push([i as f64 / n as f64, j as f64 / k as f64]);
        }
    }
    for i in 0..n {
        for j in 0..k {
            let v = |i: usize, j: usize| i % n * k + j % k;
            let t = |i: usize, j: usize| i * (k + 1) + j;
            m.face(&[v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]);
            m.face_uvs
                .push(vec![t(i, j), t(i + 1, j), t(i + 1, j + 1), t(i, j + 1)]);
        }
    }
    m
}

/// Two quads wide, so that it has interior vertices; the last column joins the first upside down.
fn mobius(n: usize) -> Mesh {
    let mut m =
        Mesh::new("Moebius strip: one side, one boundary; faces meet head to head at one seam.");
    for i in 0..n {
        let half = PI * i as f64 / n as f64;
        let (sin, cos) = (libm::sin(half), libm::cos(half));
        let (around_sin, around_cos) = (libm::sin(2.0 * half), libm::cos(2.0 * half));
        for j in 0..3 {
            let s = 0.4 * (f64::from(j) - 1.0);
            let r = 1.0 + s * cos;
            m.point([r * around_cos, s * sin, -r * around_sin]);
        }
    }
    for i in 0..n {
        let v = |i: usize, j: usize| if i == n { 2 - j } else { i * 3 + j };
        for j in 0..2 {
            m.face(&[v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]);
        }
    }
    m
}

fn grid() -> Mesh {
    let mut m = Mesh::new("Open 4 by 4 sheet: boundary vertices of valence 3, four corners.");
    let n = 4;
    for j in 0..=n {
        for i in 0..=n {
            let (x, z) = (i as f64 / 2.0 - 1.0, 1.0 - j as f64 / 2.0);
            let y = 0.3 * libm::sin(2.4 * x + 0.5) * libm::cos(2.0 * z - 0.4);
            m.point([x, y, z]);
            m.uvs.push([i as f64 / n as f64, j as f64 / n as f64]);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let v = |i: usize, j: usize| j * (n + 1) + i;
            let f = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
            m.face(&f);
            m.face_uvs.push(f.to_vec());
        }
    }
    m
}

/// An L of 12 quads: five corners with one face, one re-entrant corner with three.
fn corner() -> Mesh {
    let mut m = Mesh::new("L-shaped sheet: boundary corners with one face and one with three.");
    let inside = |i: usize, j: usize| i < 2 || j < 2;
    let mut index = [[None; 5]; 5];
    for j in 0..4 {
        for i in 0..4 {
            if !inside(i, j) {
                continue;
            }
            let mut f = [0; 4];
            for (k, (a, b)) in [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                .into_iter()
                .enumerate()
            {
                let (x, z) = (a as f64 / 2.0 - 1.0, 1.0 - b as f64 / 2.0);
                f[k] = *index[b][a]
                    .get_or_insert_with(|| m.point([x, 0.2 - 0.15 * (x * x + z * z), z]));
            }
            m.face(&f);
        }
    }
    m
}

/// `n` sectors of 2 by 2 quads: the middle vertex has valence `n` and its whole one-ring is interior and regular.
fn fan(n: usize) -> Mesh {
    let mut m = Mesh::new(&format!(
        "Fan: one interior vertex of valence {n}, its one-ring interior and regular."
    ));
    let at = |sector: usize, a: usize, b: usize| -> V3 {
        let (a, b) = (a as f64, b as f64);
        let r = (a * a + b * b).sqrt() / 8.0_f64.sqrt();
        let angle = TAU * (sector as f64 + b / (a + b)) / n as f64;
        let p = [r * libm::cos(angle), 0.0, -r * libm::sin(angle)];
        [p[0], 0.35 * (1.0 - r * r), p[2]]
    };
    m.point([0.0, 0.35, 0.0]);
    // Six points per sector: along its first spoke, then the rows inside it.
    for s in 0..n {
        for (a, b) in [(1, 0), (2, 0), (1, 1), (2, 1), (1, 2), (2, 2)] {
            m.point(at(s, a, b));
        }
    }
    for s in 0..n {
        let (me, next) = (1 + 6 * s, 1 + 6 * ((s + 1) % n));
        m.face(&[0, me, me + 2, next]);
        m.face(&[me, me + 1, me + 3, me + 2]);
        m.face(&[me + 2, me + 3, me + 5, me + 4]);
        m.face(&[next, me + 2, me + 4, next + 1]);
    }
    m
}
