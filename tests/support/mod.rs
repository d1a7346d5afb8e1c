//! Helpers shared by the tests: a naive OBJ reader and point-set comparison. Not the reader of the crate, on purpose.
#![allow(dead_code, missing_docs, unreachable_pub)]

use earmark::mesh::{Corner, Crease};
use earmark::refine::{Level, Options};
use earmark::scheme::{Boundary, CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};
use earmark::topology::{ConnectOptions, NONE, Topology, connect};
use std::path::{Path, PathBuf};

/// What a cage file says.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub points: Vec<[f64; 3]>,
    pub uvs: Vec<[f64; 2]>,
    pub face_offsets: Vec<u32>,
    pub corners: Vec<u32>,
    /// Empty unless every corner has one.
    pub corner_uvs: Vec<u32>,
    pub creases: Vec<Crease>,
    pub sharp_vertices: Vec<Corner>,
    pub holes: Vec<u32>,
}

impl Shape {
    /// A shape from points and polygons.
    pub fn new(points: &[[f64; 3]], faces: &[&[u32]]) -> Self {
        let mut shape = Self {
            points: points.to_vec(),
            face_offsets: vec![0],
            ..Self::default()
        };
        for f in faces {
            shape.corners.extend(*f);
            shape.face_offsets.push(shape.corners.len() as u32);
        }
        shape
    }

    pub fn crease(mut self, a: u32, b: u32, sharpness: f32) -> Self {
        self.creases.push(Crease {
            vertices: [a, b],
            sharpness,
        });
        self
    }

    pub fn corner(mut self, vertex: u32, sharpness: f32) -> Self {
        self.sharp_vertices.push(Corner { vertex, sharpness });
        self
    }

    pub fn faces(&self) -> usize {
        self.face_offsets.len() - 1
    }

    pub fn topology(&self, boundary: Boundary) -> Topology {
        connect(
            self.points.len(),
            &self.face_offsets,
            self.corners.clone(),
            &ConnectOptions {
                boundary,
                creases: &self.creases,
                corners: &self.sharp_vertices,
                holes: &self.holes,
            },
        )
        .0
    }

    pub fn level(&self, boundary: Boundary) -> Level<f64> {
        Level::new(self.topology(boundary), self.points.clone()).unwrap()
    }

    pub fn read(text: &str) -> Self {
        let mut shape = Self {
            face_offsets: vec![0],
            ..Self::default()
        };
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let numbers = || words[1..].iter().map(|w| w.parse::<f64>().unwrap());
            match words.first() {
                Some(&"v") => shape.points.push(fixed(numbers())),
                Some(&"vt") => shape.uvs.push(fixed(numbers())),
                Some(&"f") => {
                    for w in &words[1..] {
                        let mut parts = w.split('/');
                        let index = |s: &str, count: usize| match s.parse::<i64>().unwrap() {
                            i if i < 0 => (count as i64 + i) as u32,
                            i => i as u32 - 1,
                        };
                        shape
                            .corners
                            .push(index(parts.next().unwrap(), shape.points.len()));
                        if let Some(uv) = parts.next().filter(|s| !s.is_empty()) {
                            shape.corner_uvs.push(index(uv, shape.uvs.len()));
                        }
                    }
                    shape.face_offsets.push(shape.corners.len() as u32);
                }
                Some(&"t") => shape.tag(&words),
                _ => {}
            }
        }
        if shape.corner_uvs.len() != shape.corners.len() {
            shape.corner_uvs.clear();
        }
        shape
    }

    fn tag(&mut self, words: &[&str]) {
        let counts: Vec<usize> = words[2].split('/').map(|c| c.parse().unwrap()).collect();
        let ints: Vec<u32> = words[3..3 + counts[0]]
            .iter()
            .filter_map(|w| w.parse().ok())
            .collect();
        let floats: Vec<f32> = words[3 + counts[0]..3 + counts[0] + counts[1]]
            .iter()
            .map(|w| w.parse().unwrap())
            .collect();
        match words[1] {
            "crease" => {
                for pair in ints.chunks_exact(2) {
                    self.creases.push(Crease {
                        vertices: [pair[0], pair[1]],
                        sharpness: floats[0],
                    });
                }
            }
            "corner" => self
                .sharp_vertices
                .extend(ints.iter().map(|&vertex| Corner {
                    vertex,
                    sharpness: floats[0],
                })),
            "hole" => self.holes.extend(ints),
            _ => {}
        }
    }
}

fn fixed<const N: usize>(numbers: impl Iterator<Item = f64>) -> [f64; N] {
    let mut out = [0.0; N];
    out.iter_mut().zip(numbers).for_each(|(o, n)| *o = n);
    out
}

/// A line of the list of reference shapes.
#[derive(Clone, Debug)]
pub struct Case {
    pub name: String,
    pub scheme: String,
    pub boundary: Boundary,
    pub fvar: FaceVaryingRule,
    pub options: Options,
    pub kind: String,
    pub levels: Vec<u32>,
}

/// The folder of reference data, if the environment names one.
pub fn shared() -> Option<PathBuf> {
    std::env::var_os("EARMARK_SHARED").map(PathBuf::from)
}

pub fn read(path: &Path) -> String {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    String::from_utf8_lossy(&bytes).into_owned()
}

pub fn cases(shared: &Path) -> Vec<Case> {
    let text = read(&shared.join("opensubdiv/cases.tsv"));
    text.lines()
        .skip(1)
        .map(|line| {
            let w: Vec<&str> = line.split('\t').collect();
            Case {
                name: w[0].into(),
                scheme: w[1].into(),
                boundary: boundary(w[2]),
                fvar: fvar_rule(w[4]),
                options: Options {
                    scheme: match w[1] {
                        "bilinear" => Scheme::Bilinear,
                        _ => Scheme::CatmullClark,
                    },
                    creases: crease_method(w[3]),
                    triangles: triangle_rule(w[5]),
                },
                kind: w[6].into(),
                levels: w[7].split(',').filter_map(|l| l.parse().ok()).collect(),
            }
        })
        .collect()
}

pub fn boundary(name: &str) -> Boundary {
    match name {
        "none" => Boundary::None,
        "edge-only" => Boundary::EdgeOnly,
        "edge-and-corner" => Boundary::EdgeAndCorner,
        other => panic!("boundary {other}"),
    }
}

pub fn crease_method(name: &str) -> CreaseMethod {
    match name {
        "uniform" => CreaseMethod::Uniform,
        "chaikin" => CreaseMethod::Chaikin,
        other => panic!("creases {other}"),
    }
}

pub fn triangle_rule(name: &str) -> TriangleRule {
    match name {
        "catmark" => TriangleRule::Catmark,
        "smooth" => TriangleRule::Smooth,
        other => panic!("triangles {other}"),
    }
}

pub fn fvar_rule(name: &str) -> FaceVaryingRule {
    match name {
        "none" => FaceVaryingRule::None,
        "corners-only" => FaceVaryingRule::CornersOnly,
        "corners-plus1" => FaceVaryingRule::CornersPlus1,
        "corners-plus2" => FaceVaryingRule::CornersPlus2,
        "boundaries" => FaceVaryingRule::Boundaries,
        "all" => FaceVaryingRule::All,
        other => panic!("face-varying rule {other}"),
    }
}

pub fn base_level(shape: &Shape, case: &Case) -> Level<f64> {
    let level = shape.level(case.boundary);
    if shape.corner_uvs.is_empty() {
        level
    } else {
        level
            .with_uvs(
                &shape.uvs,
                &shape.corner_uvs,
                case.options.scheme,
                case.fvar,
            )
            .unwrap()
    }
}

/// Length of the diagonal of the bounding box.
pub fn extent(points: &[[f64; 3]]) -> f64 {
    let mut sum = 0.0;
    for k in 0..3 {
        let lo = points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let hi = points
            .iter()
            .map(|p| p[k])
            .fold(f64::NEG_INFINITY, f64::max);
        sum += (hi - lo).powi(2);
    }
    sum.sqrt()
}

pub fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Points sorted for nearest-neighbour search within a small radius.
pub struct PointSet<'a, const N: usize> {
    points: &'a [[f64; N]],
    order: Vec<usize>,
    axis: usize,
}

impl<'a, const N: usize> PointSet<'a, N> {
    pub fn new(points: &'a [[f64; N]]) -> Self {
        let spread = |k: usize| {
            let mut c: Vec<i64> = points.iter().map(|p| (p[k] * 1e6) as i64).collect();
            c.sort_unstable();
            c.dedup();
            c.len()
        };
        let axis = (0..N).max_by_key(|&k| spread(k)).unwrap();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| points[a][axis].total_cmp(&points[b][axis]));
        Self {
            points,
            order,
            axis,
        }
    }

    /// All points within `radius` of `p`.
    pub fn near(&self, p: &[f64; N], radius: f64) -> Vec<usize> {
        let k = self.axis;
        let start = self
            .order
            .partition_point(|&i| self.points[i][k] < p[k] - radius);
        self.order[start..]
            .iter()
            .copied()
            .take_while(|&i| self.points[i][k] <= p[k] + radius)
            .filter(|&i| distance(&self.points[i], p) <= radius)
            .collect()
    }

    /// Distance of `p` to the nearest point, infinite beyond `radius`.
    pub fn nearest(&self, p: &[f64; N], radius: f64) -> f64 {
        self.near(p, radius)
            .into_iter()
            .map(|i| distance(&self.points[i], p))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Largest distance of a point of one set to the other set, both ways; infinite beyond `radius`.
pub fn set_distance<const N: usize>(a: &[[f64; N]], b: &[[f64; N]], radius: f64) -> f64 {
    let (sa, sb) = (PointSet::new(a), PointSet::new(b));
    let one = |p: &[[f64; N]], s: &PointSet<'_, N>| {
        p.iter().map(|p| s.nearest(p, radius)).fold(0.0, f64::max)
    };
    one(a, &sb).max(one(b, &sa))
}

/// (x, y, z, u, v) of every corner, with or without those of hole faces.
pub fn corner_set(level: &Level<f64>, holes: bool) -> Vec<[f64; 5]> {
    let t = &level.topology;
    let uvs = level.uvs.as_ref().unwrap();
    (0..t.half_count() as u32)
        .filter(|&h| holes || !t.is_hole(t.face_of(h)))
        .map(|h| {
            let p = level.points[t.vertex(h) as usize];
            let uv = uvs.values[uvs.corners[h as usize] as usize];
            [p[0], p[1], p[2], uv[0], uv[1]]
        })
        .collect()
}

/// Index of no value.
pub const NO_INDEX: u32 = NONE;

/// Pseudo-random numbers from -0.5 to 0.5.
pub struct Noise(pub u64);

impl Noise {
    pub fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
    pub fn point(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.number())
    }
}

/// Grid of `n` by `n` quads over [0, n]², height by `height`.
pub fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> Shape {
    let mut points = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (f64::from(i), f64::from(j));
            points.push([u, v, height(u, v)]);
        }
    }
    let quads: Vec<[u32; 4]> = (0..n * n)
        .map(|q| {
            let a = q / n * (n + 1) + q % n;
            [a, a + 1, a + n + 2, a + n + 1]
        })
        .collect();
    let faces: Vec<&[u32]> = quads.iter().map(|q| q.as_slice()).collect();
    Shape::new(&points, &faces)
}

/// Vertex 0 amid `n` quads with random heights: edge `i` ends in vertex 1 + 2i, face `i` has vertex 2 + 2i opposite.
pub fn star(n: u32, seed: u64) -> Shape {
    fan(n, true, seed)
}

/// As [`star`], but half a disc: vertex 0 on the boundary, `k` faces, `k + 1` edges.
pub fn half_star(k: u32, seed: u64) -> Shape {
    fan(k, false, seed)
}

fn fan(n: u32, closed: bool, seed: u64) -> Shape {
    let mut noise = Noise(seed);
    let turn = if closed {
        std::f64::consts::TAU
    } else {
        std::f64::consts::PI
    };
    let mut points = vec![[0.0, 0.0, noise.number()]];
    let edges = if closed { n } else { n + 1 };
    for i in 0..edges + n {
        let a = turn * f64::from(i) / f64::from(2 * n);
        let r = if i % 2 == 0 { 1.0 } else { 1.4 };
        let bump = noise.point().map(|c| 0.1 * c);
        points.push([r * a.cos() + bump[0], r * a.sin() + bump[1], 5.0 * bump[2]]);
    }
    let quads: Vec<[u32; 4]> = (0..n)
        .map(|i| [0, 1 + 2 * i, 2 + 2 * i, 1 + 2 * ((i + 1) % edges)])
        .collect();
    let faces: Vec<&[u32]> = quads.iter().map(|q| q.as_slice()).collect();
    Shape::new(&points, &faces)
}

/// The cube of corners ±1.
pub fn cube() -> Shape {
    let points: Vec<[f64; 3]> = (0..8)
        .map(|i| std::array::from_fn(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 }))
        .collect();
    Shape::new(
        &points,
        &[
            &[0, 2, 3, 1],
            &[4, 5, 7, 6],
            &[0, 1, 5, 4],
            &[2, 6, 7, 3],
            &[0, 4, 6, 2],
            &[1, 3, 7, 5],
        ],
    )
}

/// All edges of the cube.
pub fn cube_edges() -> Vec<[u32; 2]> {
    (0..8_u32)
        .flat_map(|a| [1, 2, 4].map(|k| [a, a ^ k]))
        .filter(|[a, b]| a < b)
        .collect()
}

/// A closed mesh of triangles, quads and pentagons with noise, and creases of several kinds: a prism over a pentagon, one lid fanned.
pub fn gem() -> Shape {
    let mut noise = Noise(7);
    let mut points = Vec::new();
    for z in [-1.0, 1.0] {
        for i in 0..5 {
            let a = std::f64::consts::TAU * f64::from(i) / 5.0;
            let b = noise.point().map(|c| 0.3 * c);
            points.push([a.cos() + b[0], a.sin() + b[1], z + b[2]]);
        }
    }
    points.push([0.1, -0.1, 1.8]);
    let mut faces: Vec<Vec<u32>> = vec![vec![4, 3, 2, 1, 0]];
    for i in 0..5 {
        let j = (i + 1) % 5;
        faces.push(vec![i, j, 5 + j, 5 + i]);
        faces.push(vec![5 + i, 5 + j, 10]);
    }
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    Shape::new(&points, &faces)
        .crease(0, 1, 10.0)
        .crease(1, 2, 10.0)
        .crease(5, 6, 1.5)
        .crease(6, 7, 0.6)
        .crease(7, 8, 2.3)
        .crease(8, 9, 10.0)
        .corner(10, 1.4)
}

/// An open mesh of triangles, quads and a hexagon, with noise and creases up to the boundary.
pub fn patch() -> Shape {
    let mut noise = Noise(11);
    let mut shape = grid(5, |_, _| 0.0);
    for p in &mut shape.points {
        let b = noise.point();
        *p = [p[0] + 0.3 * b[0], p[1] + 0.3 * b[1], b[2]];
    }
    // Quads 6 and 7 become a hexagon, quad 12 two triangles.
    let mut faces: Vec<Vec<u32>> = shape.corners.chunks(4).map(<[u32]>::to_vec).collect();
    faces[6] = vec![7, 8, 9, 15, 14, 13];
    faces[12] = vec![14, 15, 21];
    faces[7] = vec![14, 21, 20];
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    Shape::new(&shape.points, &faces)
        .crease(2, 8, 10.0)
        .crease(21, 22, 10.0)
        .crease(22, 23, 1.7)
        .crease(28, 29, 0.8)
        .crease(29, 30 - 7, 3.0)
        .corner(20, 2.2)
}
