//! Random manifold cages: polygons of any arity, valences 3 to 12, boundaries, creases, corners, holes and torn texture coordinates.
//!
//! A cage is a plain mesh (sheet, tube, torus, prism, star, double pyramid) whose faces are then cut, merged, fanned and removed at random,
//! as long as it stays manifold. Coordinates are multiples of 1/1024, so that text, `f32` and `f64` agree. Cage `i` goes with combination
//! `i mod 36` of 6 face-varying, 3 boundary and 2 crease rules, and [`COUNT`] cages meet each of them six times.

use super::{Case, Shape, boundary, crease_method, fvar_rule, triangle_rule};
use earmark::mesh::{Corner, Crease};
use earmark::refine::Options;
use earmark::scheme::Scheme;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Six times all 36 combinations of rules.
pub const COUNT: u64 = 216;

mod mesh;

use mesh::{Mesh, Random, directed_edges, is_manifold};

const FVAR: [&str; 6] = [
    "none",
    "corners-only",
    "corners-plus1",
    "corners-plus2",
    "boundaries",
    "all",
];
const BOUNDARY: [&str; 3] = ["none", "edge-only", "edge-and-corner"];
const CREASES: [&str; 2] = ["uniform", "chaikin"];
const TRIANGLES: [&str; 2] = ["catmark", "smooth"];
const SHARPNESS: [f32; 10] = [0.25, 0.6, 1.0, 1.2, 1.4, 1.75, 2.0, 2.5, 10.0, 12.0];

/// One cage with the rules it goes with.
pub struct RandomCage {
    pub shape: Shape,
    pub case: Case,
    /// Names of the face-varying, boundary, crease and triangle rule.
    pub rules: [&'static str; 4],
    /// The cage as OBJ, without tags for the rules.
    pub obj: String,
}

impl RandomCage {
    /// The rules as flags of the reference program.
    pub fn flags(&self) -> Vec<&'static str> {
        let [fvar, boundary, creases, triangles] = self.rules;
        let scheme = match self.case.options.scheme {
            Scheme::Loop => "loop",
            _ => "catmull-clark",
        };
        vec![
            "-scheme",
            scheme,
            "-fvar",
            fvar,
            "-boundary",
            boundary,
            "-creases",
            creases,
            "-triangles",
            triangles,
        ]
    }
}

/// Undirected edges along a random walk.
fn walk(r: &mut Random, neighbours: &[Vec<u32>], steps: usize) -> Vec<(u32, u32)> {
    let mut at = r.below(neighbours.len()) as u32;
    let mut last = at;
    let mut edges = Vec::new();
    for _ in 0..steps {
        let own = &neighbours[at as usize];
        let next = own[r.below(own.len())];
        if next != last {
            edges.push((at.min(next), at.max(next)));
            last = at;
            at = next;
        }
    }
    edges
}

/// Texture coordinates: corners of a vertex share a value unless a cut edge comes between.
fn charts(r: &mut Random, mesh: &Mesh, cuts: &BTreeSet<(u32, u32)>) -> (Vec<[f64; 2]>, Vec<u32>) {
    let edges = directed_edges(&mesh.faces).unwrap();
    let mut starts = Vec::new();
    let mut count = 0;
    for face in &mesh.faces {
        starts.push(count);
        count += face.len();
    }
    let corner = |f: usize, v: u32| starts[f] + mesh.faces[f].iter().position(|&u| u == v).unwrap();
    let mut group: Vec<usize> = (0..count).collect();
    let mut join = |a: usize, b: usize| {
        let (x, y) = (group[a], group[b]);
        group.iter_mut().filter(|g| **g == x).for_each(|g| *g = y);
    };
    for (&(a, b), &f) in &edges {
        if let Some(&g) = edges
            .get(&(b, a))
            .filter(|_| !cuts.contains(&(a.min(b), a.max(b))))
        {
            join(corner(f, a), corner(g, a));
            join(corner(f, b), corner(g, b));
        }
    }
    // Some vertices are sewn together again, which leaves cut edges between single values.
    for v in 0..mesh.points.len() as u32 {
        if r.one_in(8) {
            let own: Vec<usize> = (0..mesh.faces.len())
                .filter(|&f| mesh.faces[f].contains(&v))
                .map(|f| corner(f, v))
                .collect();
            own.windows(2).for_each(|w| join(w[0], w[1]));
        }
    }
    let mut values = Vec::new();
    let mut of_group = BTreeMap::new();
    let mut corners = Vec::new();
    for (h, &v) in mesh.faces.iter().flatten().enumerate() {
        let id = *of_group.entry(group[h]).or_insert_with(|| {
            let p = mesh.points[v as usize];
            let round = |c: f64| (c * 256.0).round() / 1024.0;
            values.push([
                round(p[0]) + 0.25 * r.noise(),
                round(p[1] + 0.5 * p[2]) + 0.25 * r.noise(),
            ]);
            values.len() as u32 - 1
        });
        corners.push(id);
    }
    let exact = |c: f64| (c * 4096.0).round() / 4096.0;
    (values.iter().map(|v| v.map(exact)).collect(), corners)
}

fn sharpen(r: &mut Random, shape: &mut Shape, edges: &[(u32, u32)], neighbours: &[Vec<u32>]) {
    let mut creases: BTreeMap<(u32, u32), f32> = BTreeMap::new();
    for _ in 0..r.below(4) {
        let sharpness = SHARPNESS[r.below(SHARPNESS.len())];
        let varied = r.one_in(3);
        let steps = 1 + r.below(7);
        for e in walk(r, neighbours, steps) {
            let own = if varied {
                SHARPNESS[r.below(SHARPNESS.len())]
            } else {
                sharpness
            };
            creases.insert(e, own);
        }
    }
    if r.one_in(4) {
        for _ in 0..5 {
            creases.insert(
                edges[r.below(edges.len())],
                SHARPNESS[r.below(SHARPNESS.len())],
            );
        }
    }
    shape.creases = creases
        .into_iter()
        .map(|((a, b), sharpness)| Crease {
            vertices: [a, b],
            sharpness,
        })
        .collect();
    if r.one_in(2) {
        let vertices: BTreeSet<u32> = (0..1 + r.below(3))
            .map(|_| r.below(neighbours.len()) as u32)
            .collect();
        for vertex in vertices {
            let sharpness = SHARPNESS[r.below(SHARPNESS.len())];
            shape.sharp_vertices.push(Corner { vertex, sharpness });
        }
    }
    if r.one_in(3) {
        let holes: BTreeSet<u32> = (0..1 + r.below(2))
            .map(|_| r.below(shape.faces()) as u32)
            .collect();
        shape.holes = holes.into_iter().collect();
    }
}

/// Cage number `index`, for Catmull-Clark.
pub fn random_cage(index: u64) -> RandomCage {
    make(index, Scheme::CatmullClark)
}

/// Cage number `index` in triangles, for Loop; valences are up to 24.
pub fn random_triangles(index: u64) -> RandomCage {
    make(index, Scheme::Loop)
}

fn make(index: u64, scheme: Scheme) -> RandomCage {
    let r = &mut Random(index.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x5eed);
    let mut mesh = Mesh::start(r);
    for _ in 0..r.below(25) {
        let mut next = mesh.clone();
        next.change(r);
        if is_manifold(&next.faces) {
            mesh = next;
        }
    }
    assert!(is_manifold(&mesh.faces), "cage {index}");
    if scheme.is_triangular() {
        mesh.triangulate();
    }
    mesh.compact();
    for p in &mut mesh.points {
        *p = p.map(|c| (c * 1024.0).round() / 1024.0 + 0.25 * r.noise());
        *p = p.map(|c| (c * 1024.0).round() / 1024.0);
    }
    let edges: BTreeSet<(u32, u32)> = directed_edges(&mesh.faces)
        .unwrap()
        .into_keys()
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    let mut neighbours = vec![Vec::new(); mesh.points.len()];
    for &(a, b) in &edges {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    let edges: Vec<(u32, u32)> = edges.into_iter().collect();

    let faces: Vec<&[u32]> = mesh.faces.iter().map(Vec::as_slice).collect();
    let mut shape = Shape::new(&mesh.points, &faces);
    sharpen(r, &mut shape, &edges, &neighbours);
    let mut cuts = BTreeSet::new();
    for _ in 0..r.below(5) {
        let steps = 1 + r.below(9);
        cuts.extend(walk(r, &neighbours, steps));
    }
    (shape.uvs, shape.corner_uvs) = charts(r, &mesh, &cuts);

    let combination = index as usize;
    let rules = [
        FVAR[combination % 6],
        BOUNDARY[combination / 6 % 3],
        CREASES[combination / 18 % 2],
        TRIANGLES[combination / 36 % 2],
    ];
    let case = Case {
        name: format!("random{index}"),
        scheme: format!("{scheme:?}"),
        boundary: boundary(rules[1]),
        fvar: fvar_rule(rules[0]),
        options: Options {
            scheme,
            creases: crease_method(rules[2]),
            triangles: triangle_rule(rules[3]),
        },
        kind: "plain".into(),
        levels: vec![1, 2, 3],
    };
    let obj = write(&shape);
    RandomCage {
        shape,
        case,
        rules,
        obj,
    }
}

/// A shape as OBJ.
pub fn write(shape: &Shape) -> String {
    let mut out = String::new();
    for p in &shape.points {
        let _ = writeln!(out, "v {} {} {}", p[0], p[1], p[2]);
    }
    for p in &shape.uvs {
        let _ = writeln!(out, "vt {} {}", p[0], p[1]);
    }
    for f in shape.face_offsets.windows(2) {
        out.push('f');
        for h in f[0]..f[1] {
            let _ = write!(out, " {}", shape.corners[h as usize] + 1);
            if let Some(uv) = shape.corner_uvs.get(h as usize) {
                let _ = write!(out, "/{}", uv + 1);
            }
        }
        out.push('\n');
    }
    for c in &shape.creases {
        let [a, b] = c.vertices;
        let _ = writeln!(out, "t crease 2/1/0 {a} {b} {}", c.sharpness);
    }
    for c in &shape.sharp_vertices {
        let _ = writeln!(out, "t corner 1/1/0 {} {}", c.vertex, c.sharpness);
    }
    for f in &shape.holes {
        let _ = writeln!(out, "t hole 1/0/0 {f}");
    }
    out
}
