//! A small polygon-mesh kit: points, faces, face-varying texture coordinates, materials, creases, and OBJ text.
//!
//! Coordinates are `f64` while modelling and are written with five decimals, so the text does not depend on the last bit.

use std::fmt::Write;

/// A point or direction.
pub(crate) type V3 = [f64; 3];

/// Sum.
pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Difference.
pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Multiple.
pub(crate) fn scale(a: V3, s: f64) -> V3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Scalar product.
pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Length.
pub(crate) fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// The direction of `a`; `a` itself when it is zero.
pub(crate) fn unit(a: V3) -> V3 {
    let l = length(a);
    if l > 0.0 { scale(a, 1.0 / l) } else { a }
}

/// Point at `t` of the way from `a` to `b`.
pub(crate) fn mix(a: V3, b: V3, t: f64) -> V3 {
    add(scale(a, 1.0 - t), scale(b, t))
}

/// A polygon mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    /// Lines of comment at the top of the file.
    pub(crate) title: String,
    /// Positions.
    pub(crate) points: Vec<V3>,
    /// Vertices of every face, counter-clockwise from outside.
    pub(crate) faces: Vec<Vec<usize>>,
    /// Texture coordinate values.
    pub(crate) uvs: Vec<[f64; 2]>,
    /// Per face and corner the index of its texture coordinate; empty when there are none.
    pub(crate) face_uvs: Vec<Vec<usize>>,
    /// Material library and the names in it.
    pub(crate) library: Option<String>,
    /// Material name of every face; empty when there are none.
    pub(crate) materials: Vec<&'static str>,
    /// Creased edges and their sharpness.
    pub(crate) creases: Vec<(usize, usize, f64)>,
    /// What each face belongs to: the unit of unwrapping and painting.
    pub(crate) labels: Vec<u32>,
    /// Edges along which charts are cut although both faces have one label.
    pub(crate) seams: Vec<(usize, usize)>,
}

impl Mesh {
    /// An empty mesh with a comment for its file.
    pub(crate) fn new(title: &str) -> Self {
        Self {
            title: title.to_owned(),
            ..Self::default()
        }
    }

    /// Adds a point and returns its index.
    pub(crate) fn point(&mut self, p: V3) -> usize {
        self.points.push(p);
        self.points.len() - 1
    }

    /// Adds a face and returns its index.
    pub(crate) fn face(&mut self, corners: &[usize]) -> usize {
        self.labelled(corners, 0)
    }

    /// Adds a face with a label and returns its index.
    pub(crate) fn labelled(&mut self, corners: &[usize], label: u32) -> usize {
        self.faces.push(corners.to_vec());
        self.labels.push(label);
        self.faces.len() - 1
    }

    /// The mesh as OBJ text.
    pub(crate) fn to_obj(&self) -> String {
        let mut s = String::new();
        for line in self.title.lines() {
            let _ = writeln!(s, "# {line}");
        }
        if let Some(library) = &self.library {
            let _ = writeln!(s, "mtllib {library}");
        }
        for p in &self.points {
            let _ = writeln!(
                s,
                "v {} {} {}",
                number(p[0], 5),
                number(p[1], 5),
                number(p[2], 5)
            );
        }
        for t in &self.uvs {
            let _ = writeln!(s, "vt {} {}", number(t[0], 5), number(t[1], 5));
        }
        // Faces of one material stand together; the order within stays.
        let mut order: Vec<usize> = (0..self.faces.len()).collect();
        let material = |f: usize| self.materials.get(f).copied();
        let first = |f: usize| self.materials.iter().position(|&m| Some(m) == material(f));
        order.sort_by_key(|&f| first(f));
        let mut current = None;
        for f in order {
            if material(f) != current {
                current = material(f);
                if let Some(name) = current {
                    let _ = writeln!(s, "usemtl {name}");
                }
            }
            s.push('f');
            for (k, v) in self.faces[f].iter().enumerate() {
                let _ = match self.face_uvs.get(f) {
                    Some(t) => write!(s, " {}/{}", v + 1, t[k] + 1),
                    None => write!(s, " {}", v + 1),
                };
            }
            s.push('\n');
        }
        for &(a, b, sharpness) in &self.creases {
            let _ = writeln!(s, "t crease 2/1/0 {a} {b} {}", number(sharpness, 3));
        }
        s
    }
}

/// A decimal with at most `digits` places, without trailing zeros and without a negative zero.
fn number(x: f64, digits: usize) -> String {
    let s = format!("{x:.digits$}");
    let s = s.trim_end_matches('0').trim_end_matches('.');
    if s == "-0" {
        "0".to_owned()
    } else {
        s.to_owned()
    }
}
