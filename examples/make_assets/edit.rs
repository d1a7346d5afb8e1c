//! Modelling operations on [`Mesh`]: extrude a region, lay its rim on an ellipse, mirror, relax.
//!
//! Meshes here have a thousand faces, so adjacency is found anew for every operation instead of being kept.

use super::mesh::{Mesh, V3, add, cross, dot, mix, scale, sub, unit};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// An ellipse in space: where [`Mesh::grow`] puts a rim.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    /// Middle.
    pub(crate) centre: V3,
    /// Direction of growth, normal to the ellipse.
    pub(crate) axis: V3,
    /// Direction of the first radius, made normal to `axis`.
    pub(crate) side: V3,
    /// Radii the limit curve shall have, along `side` and across it.
    pub(crate) radii: [f64; 2],
}

/// What an extrusion made.
#[derive(Clone, Debug)]
pub(crate) struct Extrusion {
    /// New rim, in order, counter-clockwise from outside.
    pub(crate) rim: Vec<usize>,
    /// The rim it grew from, in the same order.
    pub(crate) base: Vec<usize>,
    /// Side faces; `sides[k]` stands on the edge from `base[k]` to `base[k + 1]`.
    pub(crate) sides: Vec<usize>,
    /// Vertices of the region that are not on its rim.
    pub(crate) inner: Vec<usize>,
}

impl Mesh {
    /// Extrudes faces together. The region keeps its faces and gets a new rim at the old places; a side face gets the label that
    /// `label` makes from that of the face outside. Edges of the region without a face outside (a mirror plane) get no side.
    pub(crate) fn extrude(&mut self, region: &[usize], label: impl Fn(u32) -> u32) -> Extrusion {
        let mut owner = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for (k, &a) in face.iter().enumerate() {
                owner.insert((a, face[(k + 1) % face.len()]), f);
            }
        }
        let inside: BTreeSet<usize> = region.iter().copied().collect();
        let mut next = BTreeMap::new();
        for &f in region {
            let face = &self.faces[f];
            for (k, &a) in face.iter().enumerate() {
                let b = face[(k + 1) % face.len()];
                if let Some(&o) = owner.get(&(b, a))
                    && !inside.contains(&o)
                {
                    next.insert(a, (b, self.labels[o]));
                }
            }
        }
        // An open chain starts at the vertex that no edge leads to.
        let targets: BTreeSet<usize> = next.values().map(|&(b, _)| b).collect();
        let first_of_face = region.iter().flat_map(|&f| self.faces[f].clone());
        let start = next
            .keys()
            .copied()
            .find(|a| !targets.contains(a))
            .or_else(|| first_of_face.into_iter().find(|a| next.contains_key(a)))
            .unwrap_or(0);
        let mut base = vec![start];
        let mut labels = Vec::new();
        let mut at = start;
        while let Some(&(b, l)) = next.get(&at) {
            labels.push(label(l));
            at = b;
            if b == start {
                break;
            }
            base.push(b);
        }
        let rim: Vec<usize> = base.iter().map(|&v| self.point(self.points[v])).collect();
        let moved: BTreeMap<usize, usize> = base.iter().copied().zip(rim.iter().copied()).collect();
        let mut inner = BTreeSet::new();
        for &f in region {
            for v in &mut self.faces[f] {
                match moved.get(v) {
                    Some(&new) => *v = new,
                    None => {
                        inner.insert(*v);
                    }
                }
            }
        }
        let sides = (0..labels.len())
            .map(|k| {
                let n = (k + 1) % base.len();
                self.labelled(&[base[k], base[n], rim[n], rim[k]], labels[k])
            })
            .collect();
        Extrusion {
            rim,
            base,
            sides,
            inner: inner.into_iter().collect(),
        }
    }

    /// Lays a rim on an ellipse, evenly and without twist against where it was; inner vertices go to the middle.
    pub(crate) fn lay(&mut self, e: &Extrusion, ring: &Ring) {
        let axis = unit(ring.axis);
        let u = unit(sub(ring.side, scale(axis, dot(axis, ring.side))));
        let v = cross(axis, u);
        let n = e.rim.len() as f64;
        let old = self.middle(&e.rim);
        // Mean turn of the old rim against even spacing.
        let (mut s, mut c) = (0.0, 0.0);
        for (k, &i) in e.rim.iter().enumerate() {
            let d = sub(self.points[i], old);
            let angle = libm::atan2(dot(d, v), dot(d, u)) - TAU * k as f64 / n;
            s += libm::sin(angle);
            c += libm::cos(angle);
        }
        let mut turn = libm::atan2(s, c);
        if e.rim.len() == 4 {
            // A square tube turns its sides, not its edges, to `side`.
            turn = ((turn / TAU * 4.0).floor() + 0.5) * TAU / 4.0;
        }
        // A closed cubic B-spline with n even control points lies this much inside them.
        let shrink = (2.0 + libm::cos(TAU / n)) / 3.0;
        for (k, &i) in e.rim.iter().enumerate() {
            let angle = turn + TAU * k as f64 / n;
            let a = ring.radii[0] / shrink * libm::cos(angle);
            let b = ring.radii[1] / shrink * libm::sin(angle);
            self.points[i] = add(ring.centre, add(scale(u, a), scale(v, b)));
        }
        for &i in &e.inner {
            self.points[i] = ring.centre;
        }
    }

    /// Extrudes a region and lays the new rim on a ring.
    pub(crate) fn grow(
        &mut self,
        region: &[usize],
        ring: &Ring,
        label: impl Fn(u32) -> u32,
    ) -> Extrusion {
        let e = self.extrude(region, label);
        self.lay(&e, ring);
        e
    }

    /// Mean of some vertices.
    pub(crate) fn middle(&self, vertices: &[usize]) -> V3 {
        let sum = vertices
            .iter()
            .fold([0.0; 3], |s, &v| add(s, self.points[v]));
        scale(sum, 1.0 / vertices.len() as f64)
    }

    /// Direction of a face, of length one.
    pub(crate) fn normal(&self, f: usize) -> V3 {
        let p: Vec<V3> = self.faces[f].iter().map(|&v| self.points[v]).collect();
        let area = (1..p.len() - 1).fold([0.0; 3], |s, k| {
            add(s, cross(sub(p[k], p[0]), sub(p[k + 1], p[0])))
        });
        unit(area)
    }

    /// Adds the mirror image in the plane x = 0, sharing the vertices there.
    pub(crate) fn mirror(&mut self) {
        let mut image = Vec::with_capacity(self.points.len());
        for v in 0..self.points.len() {
            let [x, y, z] = self.points[v];
            image.push(if x.abs() < 1e-9 {
                self.points[v][0] = 0.0;
                v
            } else {
                self.point([-x, y, z])
            });
        }
        for f in 0..self.faces.len() {
            let corners: Vec<usize> = self.faces[f].iter().rev().map(|&v| image[v]).collect();
            self.labelled(&corners, self.labels[f]);
        }
        for k in 0..self.seams.len() {
            let (a, b) = self.seams[k];
            self.seams.push((image[a], image[b]));
        }
    }

    /// Removes faces, and the points that no face uses any more.
    pub(crate) fn remove(&mut self, dead: &BTreeSet<usize>) {
        let keep = |f: &usize| !dead.contains(f);
        let old = std::mem::take(&mut self.faces);
        self.labels = (0..old.len())
            .filter(keep)
            .map(|f| self.labels[f])
            .collect();
        if !self.materials.is_empty() {
            self.materials = (0..old.len())
                .filter(keep)
                .map(|f| self.materials[f])
                .collect();
        }
        let mut new = vec![None; self.points.len()];
        let mut points = Vec::new();
        for (f, mut face) in old.into_iter().enumerate() {
            if dead.contains(&f) {
                continue;
            }
            for v in &mut face {
                *v = *new[*v].get_or_insert_with(|| {
                    points.push(self.points[*v]);
                    points.len() - 1
                });
            }
            self.faces.push(face);
        }
        self.points = points;
        self.creases = self
            .creases
            .iter()
            .filter_map(|&(a, b, s)| Some((new[a]?, new[b]?, s)))
            .collect();
    }

    /// Neighbours of every vertex along edges.
    pub(crate) fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut n = vec![BTreeSet::new(); self.points.len()];
        for face in &self.faces {
            for (k, &a) in face.iter().enumerate() {
                let b = face[(k + 1) % face.len()];
                n[a].insert(b);
                n[b].insert(a);
            }
        }
        n.into_iter().map(|s| s.into_iter().collect()).collect()
    }

    /// Moves every vertex by its weight towards the mean of its neighbours and then most of the way back, several times: evens the
    /// spacing with little shrinking (Taubin, *A signal processing approach to fair surface design*, 1995).
    pub(crate) fn relax(&mut self, weights: &[f64], rounds: usize) {
        let neighbours = self.neighbours();
        for round in 0..2 * rounds {
            let step = if round % 2 == 0 { 1.0 } else { -0.94 };
            let next: Vec<V3> = (0..self.points.len())
                .map(|v| {
                    if neighbours[v].is_empty() {
                        return self.points[v];
                    }
                    mix(
                        self.points[v],
                        self.middle(&neighbours[v]),
                        step * weights[v],
                    )
                })
                .collect();
            self.points = next;
        }
    }
}
