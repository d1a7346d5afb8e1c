//! Helpers shared by the tests: a naive OBJ reader and point-set comparison. Not the reader of the crate, on purpose.
#![allow(dead_code, missing_docs, unreachable_pub)]

mod cages;
mod points;
pub mod random_cages;

pub use cages::*;
pub use points::*;

use earmark::mesh::{Corner, Crease};
use earmark::refine::{Level, Options, Timings, refine};
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
                        "loop" => Scheme::Loop,
                        "catmull-clark" => Scheme::CatmullClark,
                        other => panic!("scheme {other}"),
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

pub fn step(level: Level<f64>, levels: u32) -> Level<f64> {
    refined(level, levels, &Options::default())
}

pub fn refined(level: Level<f64>, levels: u32, options: &Options) -> Level<f64> {
    refine(level, options, levels, None, &mut Timings::default()).unwrap()
}

#[track_caller]
pub fn assert_close<const N: usize>(a: &[f64; N], b: &[f64; N], tolerance: f64) {
    let d = distance(a, b);
    assert!(d <= tolerance, "{a:?} and {b:?} are {d:.2e} apart");
}

#[track_caller]
pub fn assert_all_close<const N: usize>(a: &[[f64; N]], b: &[[f64; N]], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert_close(a, b, tolerance);
    }
}

/// A shape of everything at once.
pub fn all_shapes() -> Vec<Shape> {
    let mut semi = gem();
    semi.holes = vec![2];
    vec![gem(), patch(), semi, star(7, 1), half_star(3, 2)]
}
