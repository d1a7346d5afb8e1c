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
        vec![
            "-scheme",
            "catmull-clark",
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

/// Splitmix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
    /// From -1 to 1 in steps of 1/1024.
    fn noise(&mut self) -> f64 {
        (self.below(2049) as f64 - 1024.0) / 1024.0
    }
}

type Faces = Vec<Vec<u32>>;

/// The face at the left of every directed edge; nothing when two faces claim one.
fn directed_edges(faces: &Faces) -> Option<BTreeMap<(u32, u32), usize>> {
    let mut edges = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            if a == b || edges.insert((a, b), f).is_some() {
                return None;
            }
        }
    }
    Some(edges)
}

fn before(face: &[u32], v: u32) -> u32 {
    let i = face.iter().position(|&u| u == v).unwrap();
    face[(i + face.len() - 1) % face.len()]
}

fn after(face: &[u32], v: u32) -> u32 {
    let i = face.iter().position(|&u| u == v).unwrap();
    face[(i + 1) % face.len()]
}

/// Whether every vertex has one fan of 3 to 12 edges (2 on the boundary), and no face meets itself.
fn is_manifold(faces: &Faces) -> bool {
    let Some(edges) = directed_edges(faces) else {
        return false;
    };
    let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        let distinct: BTreeSet<u32> = face.iter().copied().collect();
        if face.len() < 3 || face.len() > 12 || distinct.len() != face.len() {
            return false;
        }
        for &v in face {
            around.entry(v).or_default().push(f);
        }
    }
    around.iter().all(|(&v, own)| {
        let starts: Vec<usize> = own
            .iter()
            .copied()
            .filter(|&f| !edges.contains_key(&(after(&faces[f], v), v)))
            .collect();
        let (open, first) = match starts[..] {
            [] => (false, own[0]),
            [f] => (true, f),
            _ => return false,
        };
        let mut seen = 1;
        let mut f = first;
        while let Some(&g) = edges.get(&(v, before(&faces[f], v))) {
            if g == first {
                break;
            }
            f = g;
            seen += 1;
        }
        let valence = seen + usize::from(open);
        seen == own.len() && valence <= 12 && (open || valence >= 3)
    })
}

/// A lattice of quads, closed or not in either direction.
fn lattice(n: usize, m: usize, wrap: [bool; 2], at: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let size = [n + usize::from(!wrap[0]), m + usize::from(!wrap[1])];
    let mut mesh = Mesh::default();
    for j in 0..size[1] {
        for i in 0..size[0] {
            mesh.points.push(at(i as f64, j as f64));
        }
    }
    let id = |i: usize, j: usize| (j % size[1] * size[0] + i % size[0]) as u32;
    for j in 0..m {
        for i in 0..n {
            mesh.faces
                .push(vec![id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
        }
    }
    mesh
}

#[derive(Clone, Default)]
struct Mesh {
    points: Vec<[f64; 3]>,
    faces: Faces,
}

impl Mesh {
    fn start(r: &mut Random) -> Self {
        let k = 3 + r.below(10);
        let turn = std::f64::consts::TAU / k as f64;
        let on_circle = |i: f64, radius: f64, z: f64| {
            let a = turn * i;
            [radius * a.cos(), radius * a.sin(), z]
        };
        match r.below(7) {
            0 => lattice(3 + r.below(3), 2 + r.below(3), [false; 2], |i, j| {
                [i, j, 0.1 * i * j]
            }),
            1 => {
                let (n, m) = (3 + r.below(4), 3 + r.below(3));
                let [u, v] = [n, m].map(|k| std::f64::consts::TAU / k as f64);
                lattice(n, m, [true; 2], |i, j| {
                    let radius = 2.0 + (v * j).cos();
                    [
                        radius * (u * i).cos(),
                        radius * (u * i).sin(),
                        (v * j).sin(),
                    ]
                })
            }
            2 => lattice(k, 2 + r.below(2), [true, false], |i, j| {
                on_circle(i, 2.0 - 0.3 * j, j)
            }),
            3 => {
                let mut mesh = lattice(k, 1 + r.below(2), [true, false], |i, j| {
                    on_circle(i, 2.0 + 0.2 * j, 1.5 * j)
                });
                let top = mesh.points.len() as u32 - k as u32;
                mesh.faces.push((0..k as u32).rev().collect());
                mesh.faces.push((0..k as u32).map(|i| top + i).collect());
                if r.one_in(2) {
                    mesh.fan(mesh.faces.len() - 1);
                }
                mesh
            }
            4 | 5 => {
                // A disc around one vertex, or a part of one.
                let open = r.one_in(2);
                let faces = if open { 1 + r.below(11) } else { k };
                let edges = faces + usize::from(open);
                let mut mesh = Self {
                    points: vec![[0.0, 0.0, 0.5]],
                    faces: Vec::new(),
                };
                let turn = if open { 3.0 } else { std::f64::consts::TAU };
                for i in 0..2 * faces + usize::from(open) {
                    let a = turn * i as f64 / (2 * faces) as f64;
                    let radius = if i % 2 == 0 { 1.5 } else { 2.2 };
                    mesh.points
                        .push([radius * a.cos(), radius * a.sin(), 0.3 * (2.0 * a).sin()]);
                }
                for i in 0..faces {
                    let next = (i + 1) % edges;
                    mesh.faces.push(
                        [0, 1 + 2 * i, 2 + 2 * i, 1 + 2 * next]
                            .map(|v| v as u32)
                            .to_vec(),
                    );
                }
                mesh
            }
            _ => {
                let mut mesh = Self {
                    points: (0..k).map(|i| on_circle(i as f64, 2.0, 0.0)).collect(),
                    faces: Vec::new(),
                };
                mesh.points.push([0.0, 0.0, 1.5]);
                mesh.points.push([0.0, 0.0, -1.5]);
                let (k, top, bottom) = (k as u32, k as u32, k as u32 + 1);
                for i in 0..k {
                    let j = (i + 1) % k;
                    mesh.faces.push(vec![i, j, top]);
                    mesh.faces.push(vec![j, i, bottom]);
                }
                mesh
            }
        }
    }

    /// Puts a vertex amid face `f`.
    fn fan(&mut self, f: usize) {
        let face = self.faces.swap_remove(f);
        let n = face.len() as f64;
        let middle = std::array::from_fn(|k| {
            face.iter()
                .map(|&v| self.points[v as usize][k])
                .sum::<f64>()
                / n
        });
        let centre = self.points.len() as u32;
        self.points.push(middle);
        for (i, &v) in face.iter().enumerate() {
            self.faces.push(vec![v, face[(i + 1) % face.len()], centre]);
        }
    }

    /// Cuts face `f` in two from its corner `i` to the corner `gap` further on.
    fn cut(&mut self, f: usize, i: usize, gap: usize) {
        let mut face = self.faces.swap_remove(f);
        face.rotate_left(i);
        let mut rest = face.split_off(gap);
        self.faces.push([&face[..], &rest[..1]].concat());
        rest.push(face[0]);
        self.faces.push(rest);
    }

    /// Removes the edge from corner `i` of face `f`.
    fn merge(&mut self, f: usize, i: usize) {
        let face = &self.faces[f];
        let (a, b) = (face[i], face[(i + 1) % face.len()]);
        let twin = (0..self.faces.len())
            .find(|&g| self.faces[g].contains(&b) && after(&self.faces[g], b) == a);
        let Some(g) = twin else { return };
        let mut own = self.faces[f].clone();
        let turn = (i + 1) % own.len();
        own.rotate_left(turn);
        let mut other = self.faces[g].clone();
        let j = other.iter().position(|&v| v == a).unwrap();
        other.rotate_left(j);
        // From b around to a, and from a around to b, both ends once.
        let joined = [&own[..], &other[1..other.len() - 1]].concat();
        let (hi, lo) = (f.max(g), f.min(g));
        self.faces.swap_remove(hi);
        self.faces.swap_remove(lo);
        self.faces.push(joined);
    }

    fn change(&mut self, r: &mut Random) {
        let f = r.below(self.faces.len());
        let n = self.faces[f].len();
        let i = r.below(n);
        match r.below(8) {
            0..=2 if n > 3 => self.cut(f, i, 2 + r.below(n - 3)),
            3 | 4 => self.merge(f, i),
            5 if n > 3 => self.fan(f),
            6 if self.faces.len() > 6 => {
                self.faces.swap_remove(f);
            }
            _ => {}
        }
    }

    /// Drops unused vertices.
    fn compact(&mut self) {
        let mut new = vec![None; self.points.len()];
        let mut points = Vec::new();
        for v in self.faces.iter_mut().flatten() {
            let old = *v as usize;
            *v = *new[old].get_or_insert_with(|| {
                points.push(self.points[old]);
                points.len() as u32 - 1
            });
        }
        self.points = points;
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

/// Cage number `index`.
pub fn random_cage(index: u64) -> RandomCage {
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
        scheme: "catmull-clark".into(),
        boundary: boundary(rules[1]),
        fvar: fvar_rule(rules[0]),
        options: Options {
            scheme: Scheme::CatmullClark,
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
