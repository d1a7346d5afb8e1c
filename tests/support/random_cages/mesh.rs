//! Plain manifold meshes, and changes to them.

use std::collections::{BTreeMap, BTreeSet};

/// Splitmix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
    /// From -1 to 1 in steps of 1/1024.
    pub fn noise(&mut self) -> f64 {
        (self.below(2049) as f64 - 1024.0) / 1024.0
    }
}

pub type Faces = Vec<Vec<u32>>;

/// The face at the left of every directed edge; nothing when two faces claim one.
pub fn directed_edges(faces: &Faces) -> Option<BTreeMap<(u32, u32), usize>> {
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
pub fn is_manifold(faces: &Faces) -> bool {
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
pub struct Mesh {
    pub points: Vec<[f64; 3]>,
    pub faces: Faces,
}

impl Mesh {
    pub fn start(r: &mut Random) -> Self {
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

    pub fn change(&mut self, r: &mut Random) {
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

    /// Puts a vertex amid every face with more than 3 corners.
    pub fn triangulate(&mut self) {
        while let Some(f) = self.faces.iter().position(|f| f.len() > 3) {
            self.fan(f);
        }
    }

    /// Drops unused vertices.
    pub fn compact(&mut self) {
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
