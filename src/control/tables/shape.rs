//! Surroundings of faces: which look alike, and so share a table.
//!
//! The faces in some rings around a face are numbered in an order that depends on their connectivity alone: ring by ring from the face's
//! first corner, around each vertex counter-clockwise. Two faces have the same shape when the numbered surroundings are the same.

use super::sheet::Sheet;
use crate::dice::table::TableShapes;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rings of faces whose vertices are control points.
pub(super) const CONTROL_RINGS: usize = 2;
/// Least number of faces to a task.
const RUN: usize = 1 << 12;

/// The surroundings of a face, in numbers of their own. The face is number 0.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Shape {
    /// Corners of a face.
    pub(super) sides: u32,
    /// Vertex of every corner.
    pub(super) corners: Vec<u32>,
    pub(super) twins: Vec<u32>,
    /// Vertices where curves along cuts end.
    pub(super) ends: Vec<bool>,
    /// Whether cut edges are straight lines.
    pub(super) straight: bool,
    /// The first vertices are those that points depend on.
    pub(super) inner: usize,
}

/// Marks that are forgotten all at once.
struct Marks {
    of: Vec<(u32, u32)>,
    epoch: u32,
}

impl Marks {
    fn new(size: usize) -> Self {
        Self {
            of: vec![(0, 0); size],
            epoch: 0,
        }
    }
    fn get(&self, i: u32) -> Option<u32> {
        let (epoch, mark) = self.of[i as usize];
        (epoch == self.epoch).then_some(mark)
    }
    fn set(&mut self, i: u32, mark: u32) {
        self.of[i as usize] = (self.epoch, mark);
    }
}

/// A walk over the surroundings of one face after the other.
struct Walk<'a> {
    sheet: &'a Sheet,
    sides: u32,
    faces: Marks,
    fans: Marks,
    turned: Marks,
    /// First half-edge of every face, as numbered.
    entries: Vec<u32>,
    /// Fan of every vertex, as numbered.
    vertices: Vec<u32>,
}

impl Walk<'_> {
    /// Half-edge `k` on from `h` in its face.
    fn turn(&self, h: u32, k: u32) -> u32 {
        let at = h % self.sides;
        h - at + (at + k) % self.sides
    }

    fn add_face(&mut self, entry: u32) {
        let t = &self.sheet.topology;
        if self.faces.get(t.face_of(entry)).is_some() {
            return;
        }
        self.faces.set(t.face_of(entry), self.entries.len() as u32);
        self.entries.push(entry);
        for k in 0..self.sides {
            let fan = t.fan(self.turn(entry, k));
            if self.fans.get(fan).is_none() {
                self.fans.set(fan, self.vertices.len() as u32);
                self.vertices.push(fan);
            }
        }
    }

    fn shape(&mut self, face: u32, rings: usize) -> Shape {
        let t = &self.sheet.topology;
        for marks in [&mut self.faces, &mut self.fans, &mut self.turned] {
            marks.epoch += 1;
        }
        self.entries.clear();
        self.vertices.clear();
        self.add_face(t.face_halves(face).start);
        let (mut done, mut inner) = (0, 0);
        for ring in 1..=rings {
            let end = self.entries.len();
            for f in done..end {
                for k in 0..self.sides {
                    let h = self.turn(self.entries[f], k);
                    if self.turned.get(t.fan(h)).is_some() {
                        continue;
                    }
                    self.turned.set(t.fan(h), 0);
                    self.add_fan(t, h);
                }
            }
            done = end;
            if ring <= CONTROL_RINGS {
                inner = self.vertices.len();
            }
        }
        let local = |h: u32| {
            let face = self.faces.get(t.face_of(h))?;
            let entry = self.entries[face as usize];
            let at = (h % self.sides + self.sides - entry % self.sides) % self.sides;
            Some(face * self.sides + at)
        };
        let halves: Vec<u32> = (self.entries.iter())
            .flat_map(|&e| [0, 1, 2, 3].map(|k| (k, e)))
            .filter(|&(k, _)| k < self.sides)
            .map(|(k, e)| self.turn(e, k))
            .collect();
        Shape {
            sides: self.sides,
            corners: (halves.iter())
                .map(|&h| self.fans.get(t.fan(h)).unwrap_or(0))
                .collect(),
            twins: (halves.iter())
                .map(|&h| match t.twin(h) {
                    NONE => NONE,
                    g => local(g).unwrap_or(NONE),
                })
                .collect(),
            ends: (self.vertices.iter())
                .map(|&fan| self.sheet.ends[fan as usize])
                .collect(),
            straight: self.sheet.straight,
            inner,
        }
    }

    fn add_fan(&mut self, t: &Topology, h: u32) {
        let mut at = h;
        loop {
            self.add_face(at);
            at = t.rotate(at);
            if at == h {
                return;
            }
            if at == NONE {
                break;
            }
        }
        at = t.rotate_back(h);
        while at != NONE && at != h {
            self.add_face(at);
            at = t.rotate_back(at);
        }
    }
}

/// Shapes of all faces of a sheet, each once, and the vertices around every face.
pub(super) fn shapes(sheet: &Sheet, sides: u32, rings: usize) -> (TableShapes, Vec<Shape>) {
    let t = &sheet.topology;
    let count = t.face_count();
    let run = count.div_ceil(64).max(RUN);
    let parts: Vec<(Vec<Shape>, TableShapes)> = (0..count.div_ceil(run))
        .into_par_iter()
        .map(|part| {
            let mut walk = Walk {
                sheet,
                sides,
                faces: Marks::new(count),
                fans: Marks::new(t.fans().len()),
                turned: Marks::new(t.fans().len()),
                entries: Vec::new(),
                vertices: Vec::new(),
            };
            let mut known = BTreeMap::new();
            let mut out = TableShapes::default();
            for face in part * run..((part + 1) * run).min(count) {
                let shape = walk.shape(face as u32, rings);
                out.starts.push(out.vertices.len() as u32);
                let around = &walk.vertices[..shape.inner];
                out.vertices.extend(around.iter().map(|&f| t.fan_vertex(f)));
                let next = known.len() as u32;
                out.tables.push(*known.entry(shape).or_insert(next));
            }
            let mut shapes: Vec<(Shape, u32)> = known.into_iter().collect();
            shapes.sort_by_key(|s| s.1);
            (shapes.into_iter().map(|s| s.0).collect(), out)
        })
        .collect();
    let mut known: BTreeMap<Shape, u32> = BTreeMap::new();
    let mut out = TableShapes::default();
    for (shapes, part) in parts {
        let numbers: Vec<u32> = shapes
            .into_iter()
            .map(|shape| {
                let next = known.len() as u32;
                *known.entry(shape).or_insert(next)
            })
            .collect();
        let first = out.vertices.len() as u32;
        out.starts.extend(part.starts.iter().map(|s| first + s));
        out.vertices.extend(part.vertices);
        (out.tables).extend(part.tables.iter().map(|&k| numbers[k as usize]));
    }
    let mut shapes: Vec<(Shape, u32)> = known.into_iter().collect();
    shapes.sort_by_key(|s| s.1);
    (out, shapes.into_iter().map(|s| s.0).collect())
}
