//! Texture charts: cut by label and seam, flatten, pack.
//!
//! A chart is first laid into a disc (Tutte, *How to draw a graph*, 1963), which cannot fold, and then relaxed to be as rigid as
//! possible (Liu et al., *A local/global approach to mesh parameterization*, 2008). Lengths are those of the smooth surface, not of
//! the cage.

use super::mesh::{Mesh, V3, cross, dot, length, sub, unit};
use super::pack::{CELLS, footprint, layout};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

/// A connected piece of the surface with its own flat coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Faces of the mesh.
    pub(crate) faces: Vec<usize>,
    /// Per face its corners as indices into `uv`.
    pub(crate) corners: Vec<Vec<usize>>,
    /// Mesh vertex of every chart vertex.
    pub(crate) vertex: Vec<usize>,
    /// Flat position.
    pub(crate) uv: Vec<[f64; 2]>,
}

fn find(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// Cuts the mesh where labels differ and along its seams.
pub(crate) fn cut(m: &Mesh) -> Vec<Chart> {
    let mut first_corner = vec![0];
    for f in &m.faces {
        first_corner.push(first_corner[first_corner.len() - 1] + f.len());
    }
    let mut corner_parent: Vec<usize> = (0..first_corner[m.faces.len()]).collect();
    let mut face_parent: Vec<usize> = (0..m.faces.len()).collect();
    let seam = |a: usize, b: usize| m.seams.contains(&(a, b)) || m.seams.contains(&(b, a));
    let mut half_edges = BTreeMap::new();
    for (f, face) in m.faces.iter().enumerate() {
        for k in 0..face.len() {
            half_edges.insert((face[k], face[(k + 1) % face.len()]), (f, k));
        }
    }
    for (&(a, b), &(f, k)) in &half_edges {
        let Some(&(g, l)) = half_edges.get(&(b, a)) else {
            continue;
        };
        if m.labels[f] != m.labels[g] || seam(a, b) {
            continue;
        }
        let corner = |f: usize, k: usize| first_corner[f] + k % m.faces[f].len();
        for (p, q) in [
            (corner(f, k), corner(g, l + 1)),
            (corner(f, k + 1), corner(g, l)),
        ] {
            let (p, q) = (find(&mut corner_parent, p), find(&mut corner_parent, q));
            corner_parent[p.max(q)] = p.min(q);
        }
        let (p, q) = (find(&mut face_parent, f), find(&mut face_parent, g));
        face_parent[p.max(q)] = p.min(q);
    }
    let mut charts: BTreeMap<usize, Chart> = BTreeMap::new();
    let mut local: BTreeMap<usize, usize> = BTreeMap::new();
    for (f, face) in m.faces.iter().enumerate() {
        let chart = charts
            .entry(find(&mut face_parent, f))
            .or_insert_with(|| Chart {
                faces: Vec::new(),
                corners: Vec::new(),
                vertex: Vec::new(),
                uv: Vec::new(),
            });
        let corners = (0..face.len())
            .map(|k| {
                let root = find(&mut corner_parent, first_corner[f] + k);
                *local.entry(root).or_insert_with(|| {
                    chart.vertex.push(face[k]);
                    chart.vertex.len() - 1
                })
            })
            .collect();
        chart.faces.push(f);
        chart.corners.push(corners);
    }
    charts.into_values().collect()
}

impl Chart {
    /// Boundary loops, longest first, clockwise as the faces see them.
    fn loops(&self, at: &[V3]) -> Vec<Vec<usize>> {
        let mut next: BTreeMap<usize, usize> = BTreeMap::new();
        let mut edges = BTreeMap::new();
        for c in &self.corners {
            for k in 0..c.len() {
                edges.insert((c[k], c[(k + 1) % c.len()]), ());
            }
        }
        for &(a, b) in edges.keys() {
            if !edges.contains_key(&(b, a)) {
                next.insert(a, b);
            }
        }
        let mut loops = Vec::new();
        while let Some((&start, _)) = next.iter().next() {
            let mut l = vec![start];
            let mut v = start;
            while let Some(n) = next.remove(&v) {
                if n == start {
                    break;
                }
                l.push(n);
                v = n;
            }
            loops.push(l);
        }
        let around = |l: &Vec<usize>| -> f64 {
            (0..l.len())
                .map(|k| {
                    length(sub(
                        at[self.vertex[l[k]]],
                        at[self.vertex[l[(k + 1) % l.len()]]],
                    ))
                })
                .sum()
        };
        loops.sort_by(|a, b| around(b).total_cmp(&around(a)));
        loops
    }

    /// Lays the chart into the unit disc; holes are held open by a point in their middle.
    fn tutte(&mut self, at: &[V3]) {
        let n = self.vertex.len();
        let loops = self.loops(at);
        let mut neighbours = vec![Vec::new(); n + loops.len()];
        for c in &self.corners {
            for k in 0..c.len() {
                let (a, b) = (c[k], c[(k + 1) % c.len()]);
                neighbours[a].push(b);
                neighbours[b].push(a);
            }
        }
        let mut uv = vec![[0.0; 2]; n + loops.len()];
        let mut free = vec![true; n + loops.len()];
        for (h, hole) in loops.iter().enumerate() {
            for &v in hole {
                if h > 0 {
                    neighbours[n + h].push(v);
                    neighbours[v].push(n + h);
                }
            }
        }
        if let Some(outer) = loops.first() {
            let step = |k: usize| {
                let (a, b) = (outer[k], outer[(k + 1) % outer.len()]);
                length(sub(at[self.vertex[a]], at[self.vertex[b]]))
            };
            let total: f64 = (0..outer.len()).map(step).sum();
            let mut sum = 0.0;
            for (k, &v) in outer.iter().enumerate() {
                let angle = TAU * sum / total;
                uv[v] = [libm::cos(angle), libm::sin(angle)];
                free[v] = false;
                sum += step(k);
            }
        }
        free[n] = false;
        for _ in 0..1500 {
            for v in 0..uv.len() {
                if free[v] {
                    let s = neighbours[v]
                        .iter()
                        .fold([0.0; 2], |s, &w| [s[0] + uv[w][0], s[1] + uv[w][1]]);
                    uv[v] = s.map(|x| x / neighbours[v].len() as f64);
                }
            }
        }
        uv.truncate(n);
        self.uv = uv;
    }

    /// Triangles of the chart, every quad split both ways, with their shapes in the plane.
    pub(crate) fn triangles(&self, at: &[V3]) -> Vec<([usize; 3], [[f64; 2]; 3])> {
        let mut t = Vec::new();
        for c in &self.corners {
            for split in [[0, 1, 2], [0, 2, 3], [1, 2, 3], [1, 3, 0]] {
                let i = split.map(|k| c[k]);
                let p = i.map(|v| at[self.vertex[v]]);
                let (a, b) = (sub(p[1], p[0]), sub(p[2], p[0]));
                let x = unit(a);
                let along = dot(b, x);
                let across = length(cross(x, b));
                t.push((i, [[0.0, 0.0], [length(a), 0.0], [along, across]]));
            }
        }
        t
    }

    /// As rigid as possible, from the present layout.
    fn relax(&mut self, at: &[V3], rounds: usize) {
        let triangles = self.triangles(at);
        let n = self.vertex.len();
        // Cotangent weights of the three edges of each triangle; edge k joins corners k and k + 1.
        let weights: Vec<[f64; 3]> = triangles
            .iter()
            .map(|(_, x)| {
                std::array::from_fn(|k| {
                    let (a, b, o) = (x[k], x[(k + 1) % 3], x[(k + 2) % 3]);
                    let (p, q) = ([a[0] - o[0], a[1] - o[1]], [b[0] - o[0], b[1] - o[1]]);
                    let cot =
                        (p[0] * q[0] + p[1] * q[1]) / (p[0] * q[1] - p[1] * q[0]).abs().max(1e-12);
                    cot.clamp(0.02, 20.0)
                })
            })
            .collect();
        let apply = |u: &[[f64; 2]]| {
            let mut out = vec![[0.0; 2]; n];
            for ((i, _), w) in triangles.iter().zip(&weights) {
                for k in 0..3 {
                    let (a, b) = (i[k], i[(k + 1) % 3]);
                    for d in 0..2 {
                        let f = w[k] * (u[a][d] - u[b][d]);
                        out[a][d] += f;
                        out[b][d] -= f;
                    }
                }
            }
            out
        };
        for _ in 0..rounds {
            let mut right = vec![[0.0; 2]; n];
            for ((i, x), w) in triangles.iter().zip(&weights) {
                // Best rotation of the flat shape onto the layout.
                let (mut s, mut c) = (0.0, 0.0);
                for k in 0..3 {
                    let l = (k + 1) % 3;
                    let e = [x[k][0] - x[l][0], x[k][1] - x[l][1]];
                    let (p, q) = (self.uv[i[k]], self.uv[i[l]]);
                    let d = [p[0] - q[0], p[1] - q[1]];
                    c += w[k] * (e[0] * d[0] + e[1] * d[1]);
                    s += w[k] * (e[0] * d[1] - e[1] * d[0]);
                }
                let r = (c * c + s * s).sqrt().max(1e-30);
                let (s, c) = (s / r, c / r);
                for k in 0..3 {
                    let l = (k + 1) % 3;
                    let e = [x[k][0] - x[l][0], x[k][1] - x[l][1]];
                    let turned = [c * e[0] - s * e[1], s * e[0] + c * e[1]];
                    for d in 0..2 {
                        right[i[k]][d] += w[k] * turned[d];
                        right[i[l]][d] -= w[k] * turned[d];
                    }
                }
            }
            // Conjugate gradients; the free translation stays what it is.
            let inner = |a: &[[f64; 2]], b: &[[f64; 2]]| -> f64 {
                a.iter()
                    .zip(b)
                    .map(|(p, q)| p[0] * q[0] + p[1] * q[1])
                    .sum()
            };
            let mut residual = apply(&self.uv);
            for (r, b) in residual.iter_mut().zip(&right) {
                *r = [b[0] - r[0], b[1] - r[1]];
            }
            let mut direction = residual.clone();
            let mut norm = inner(&residual, &residual);
            for _ in 0..60 {
                let image = apply(&direction);
                let slope = inner(&direction, &image);
                if slope <= 1e-24 || norm <= 1e-24 {
                    break;
                }
                let step = norm / slope;
                for v in 0..n {
                    for d in 0..2 {
                        self.uv[v][d] += step * direction[v][d];
                        residual[v][d] -= step * image[v][d];
                    }
                }
                let new = inner(&residual, &residual);
                for v in 0..n {
                    for d in 0..2 {
                        direction[v][d] = residual[v][d] + new / norm * direction[v][d];
                    }
                }
                norm = new;
            }
        }
    }

    /// Pulls the vertices of folded and nearly folded triangles towards their neighbours until none is left.
    fn unfold(&mut self, at: &[V3]) {
        let triangles = self.triangles(at);
        let mut neighbours = vec![Vec::new(); self.vertex.len()];
        for c in &self.corners {
            for k in 0..c.len() {
                let (a, b) = (c[k], c[(k + 1) % c.len()]);
                neighbours[a].push(b);
                neighbours[b].push(a);
            }
        }
        for _ in 0..100 {
            let folded: BTreeSet<usize> = triangles
                .iter()
                .filter(|(i, x)| {
                    area(i.iter().map(|&v| self.uv[v])) < 0.04 * area(x.iter().copied())
                })
                .flat_map(|(i, _)| *i)
                .collect();
            if folded.is_empty() {
                break;
            }
            for v in folded {
                let n = neighbours[v].len() as f64;
                let s = neighbours[v].iter().fold([0.0; 2], |s, &w| {
                    [s[0] + self.uv[w][0] / n, s[1] + self.uv[w][1] / n]
                });
                let p = self.uv[v];
                self.uv[v] = [p[0] * 0.8 + s[0] * 0.2, p[1] * 0.8 + s[1] * 0.2];
            }
        }
    }

    /// Turns the chart so that its box is smallest and lies lengthwise, and moves it to the origin.
    fn settle(&mut self) {
        let boxed = |uv: &[[f64; 2]]| {
            let (mut lo, mut hi) = ([f64::MAX; 2], [f64::MIN; 2]);
            for p in uv {
                for d in 0..2 {
                    lo[d] = lo[d].min(p[d]);
                    hi[d] = hi[d].max(p[d]);
                }
            }
            (lo, [hi[0] - lo[0], hi[1] - lo[1]])
        };
        let turned = |uv: &[[f64; 2]], angle: f64| -> Vec<[f64; 2]> {
            let (s, c) = (libm::sin(angle), libm::cos(angle));
            uv.iter()
                .map(|p| [c * p[0] - s * p[1], s * p[0] + c * p[1]])
                .collect()
        };
        let mut best = (f64::MAX, self.uv.clone());
        for k in 0..60 {
            let uv = turned(&self.uv, PI * f64::from(k) / 60.0);
            let (_, [w, h]) = boxed(&uv);
            if w >= h && w * h < best.0 {
                best = (w * h, uv);
            }
        }
        self.uv = best.1;
        let (lo, _) = boxed(&self.uv);
        for p in &mut self.uv {
            *p = [p[0] - lo[0], p[1] - lo[1]];
        }
    }

    /// Width and height of a settled chart.
    pub(crate) fn size(&self) -> [f64; 2] {
        [0, 1].map(|d| self.uv.iter().map(|p| p[d]).fold(0.0, f64::max))
    }
}

/// Unwraps the mesh: fills its texture coordinates.
///
/// `at` are the vertices on the smooth surface; `density` is the relative size of a chart by label.
pub(crate) fn unwrap(m: &mut Mesh, at: &[V3], density: impl Fn(u32) -> f64) {
    let mut charts = cut(m);
    for chart in &mut charts {
        chart.tutte(at);
        chart.relax(at, 120);
        chart.unfold(at);
        let d = density(m.labels[chart.faces[0]]);
        for p in &mut chart.uv {
            *p = p.map(|x| x * d);
        }
        chart.settle();
    }
    let (places, scale) = layout(&charts);
    m.uvs.clear();
    m.face_uvs = vec![Vec::new(); m.faces.len()];
    for (chart, &([x, y], turn)) in charts.iter().zip(&places) {
        let first = m.uvs.len();
        let mask = footprint(chart, scale);
        for p in &chart.uv {
            let mut q = p.map(|c| c * scale + 1.0);
            let mut size = [mask[0].len() as f64, mask.len() as f64];
            for _ in 0..turn {
                q = [q[1], size[0] - q[0]];
                size.reverse();
            }
            m.uvs.push([
                (q[0] + x as f64) / CELLS as f64,
                (q[1] + y as f64) / CELLS as f64,
            ]);
        }
        for (&f, c) in chart.faces.iter().zip(&chart.corners) {
            m.face_uvs[f] = c.iter().map(|&v| first + v).collect();
        }
    }
}

/// Signed area of a polygon.
pub(crate) fn area(p: impl Iterator<Item = [f64; 2]>) -> f64 {
    let p: Vec<[f64; 2]> = p.collect();
    (0..p.len())
        .map(|k| {
            let (a, b) = (p[k], p[(k + 1) % p.len()]);
            (a[0] * b[1] - a[1] * b[0]) / 2.0
        })
        .sum()
}
