//! Catmull-Clark refinement of a closed or open net, plain and whole-mesh: what painting needs to know where a texel lies.
//!
//! Independent of the crate on purpose: the assets must not move when the crate's own code does. Boundaries are smooth curves and
//! a vertex with one face is a corner, which for a chart of texture coordinates is the rule `corners-plus1`.

use std::collections::BTreeMap;

/// A net of `D`-dimensional points.
#[derive(Clone, Debug)]
pub(crate) struct Net<const D: usize> {
    /// Values of the vertices.
    pub(crate) points: Vec<[f64; D]>,
    /// Vertices of the faces.
    pub(crate) faces: Vec<Vec<usize>>,
    /// Vertices that stay where they are.
    pub(crate) fixed: Vec<bool>,
}

fn sum<const D: usize>(a: [f64; D], b: [f64; D], weight: f64) -> [f64; D] {
    std::array::from_fn(|k| a[k] + b[k] * weight)
}

impl<const D: usize> Net<D> {
    /// A net whose only fixed vertices are those of one face.
    pub(crate) fn new(points: Vec<[f64; D]>, faces: Vec<Vec<usize>>) -> Self {
        let mut count = vec![0; points.len()];
        for &v in faces.iter().flatten() {
            count[v] += 1;
        }
        let fixed = count.iter().map(|&n| n == 1).collect();
        Self {
            points,
            faces,
            fixed,
        }
    }

    /// One level finer: old vertices, then edge points, then face points; face `f` with `n` corners makes `n` quads in a row.
    pub(crate) fn refine(&self) -> Self {
        let zero = [0.0; D];
        let old = self.points.len();
        let mut edges: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let mut ends = Vec::new();
        let mut edge_faces: Vec<Vec<usize>> = Vec::new();
        let mut centres = Vec::with_capacity(self.faces.len());
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            let total = face.iter().fold(zero, |s, &v| sum(s, self.points[v], 1.0));
            centres.push(total.map(|x| x / n as f64));
            for k in 0..n {
                let (a, b) = (face[k], face[(k + 1) % n]);
                let e = *edges.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    ends.push((a, b));
                    edge_faces.push(Vec::new());
                    ends.len() - 1
                });
                edge_faces[e].push(f);
            }
        }
        let middle = |e: usize| {
            let (a, b) = ends[e];
            sum(self.points[a], self.points[b], 1.0).map(|x| x * 0.5)
        };
        let mut edge_points = Vec::with_capacity(ends.len());
        let mut valence = vec![0_usize; old];
        let mut edge_sum = vec![zero; old];
        let mut face_sum = vec![zero; old];
        let mut rim = vec![(0_usize, zero); old];
        for (e, faces) in edge_faces.iter().enumerate() {
            let (a, b) = ends[e];
            let m = middle(e);
            let boundary = faces.len() != 2;
            for v in [a, b] {
                valence[v] += 1;
                edge_sum[v] = sum(edge_sum[v], m, 1.0);
                if boundary {
                    rim[v].0 += 1;
                    rim[v].1 = sum(rim[v].1, m, 1.0);
                }
            }
            edge_points.push(if boundary {
                m
            } else {
                let c = sum(centres[faces[0]], centres[faces[1]], 1.0);
                sum(m, c, 0.5).map(|x| x * 0.5)
            });
        }
        for (f, face) in self.faces.iter().enumerate() {
            for &v in face {
                face_sum[v] = sum(face_sum[v], centres[f], 1.0);
            }
        }
        let mut points = Vec::with_capacity(old + ends.len() + centres.len());
        for v in 0..old {
            let p = self.points[v];
            let n = valence[v] as f64;
            points.push(if self.fixed[v] || valence[v] == 0 {
                p
            } else if rim[v].0 == 2 {
                sum(p.map(|x| x * 0.5), rim[v].1, 0.25)
            } else if rim[v].0 > 0 {
                p
            } else {
                let q = sum(p.map(|x| x * (n - 3.0) / n), edge_sum[v], 2.0 / (n * n));
                sum(q, face_sum[v], 1.0 / (n * n))
            });
        }
        points.extend(edge_points);
        points.extend(centres);
        let mut faces = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            let edge = |k: usize| {
                let (a, b) = (face[k % n], face[(k + 1) % n]);
                old + edges[&(a.min(b), a.max(b))]
            };
            for (k, &v) in face.iter().enumerate() {
                faces.push(vec![v, edge(k), old + ends.len() + f, edge(k + n - 1)]);
            }
        }
        let mut fixed = self.fixed.clone();
        fixed.resize(points.len(), false);
        Self {
            points,
            faces,
            fixed,
        }
    }
}
