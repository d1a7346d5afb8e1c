//! What a face's points depend on: the faces around it, numbered from the face itself, so that faces with the same surroundings have the
//! same numbers.

use crate::mesh::{Cage, Corner, Crease, Tags};
use crate::patch::PatchKind;
use crate::surface::Surface;
use crate::topology::NONE;
use std::collections::{HashMap, HashSet};

/// The faces around one face of a cage.
#[derive(Clone, Debug, Default)]
pub(super) struct Surroundings {
    /// Vertex of the cage for every local one; those of the face come first, in order.
    pub(super) vertices: Vec<u32>,
    sizes: Vec<u32>,
    corners: Vec<u32>,
    creases: Vec<Crease>,
    sharp: Vec<Corner>,
    /// Texture coordinate of the cage for every local one.
    pub(super) uvs: Vec<u32>,
    /// Local texture coordinate of every corner, or [`NONE`]; empty without.
    corner_uvs: Vec<u32>,
}

/// Finds surroundings in one surface.
#[derive(Debug)]
pub(super) struct Finder<'a> {
    surface: &'a Surface,
    /// Corners of the cage by their vertex: where those of each vertex begin in `corners`.
    starts: Vec<u32>,
    corners: Vec<u32>,
    creases: HashMap<[u32; 2], f32>,
    sharp: HashMap<u32, f32>,
    /// Rings of faces that a point may depend on.
    rings: u32,
}

fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl<'a> Finder<'a> {
    pub(super) fn new(surface: &'a Surface) -> Self {
        let cage = surface.cage();
        let mut starts = vec![0_u32; cage.points().len() + 1];
        for &v in cage.corner_vertices() {
            starts[v as usize + 1] += 1;
        }
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; cage.corner_vertices().len()];
        for (corner, &v) in (0..).zip(cage.corner_vertices()) {
            corners[next[v as usize] as usize] = corner;
            next[v as usize] += 1;
        }
        let tags = cage.tags();
        let creases = tags.creases.iter();
        let sharp = tags.corners.iter();
        Self {
            surface,
            starts,
            corners,
            creases: creases
                .map(|c| (edge(c.vertices[0], c.vertices[1]), c.sharpness))
                .collect(),
            sharp: sharp.map(|c| (c.vertex, c.sharpness)).collect(),
            rings: if surface.scheme().is_interpolating() {
                3
            } else {
                1
            },
        }
    }

    /// The surroundings of face `face` of the cage.
    pub(super) fn find(&self, face: u32) -> Surroundings {
        let mut walk = Walk {
            finder: self,
            out: Surroundings::default(),
            local: HashMap::new(),
            local_uvs: HashMap::new(),
            faces: HashSet::new(),
            seen_at: Vec::new(),
        };
        let first = self.surface.topology().face_halves(face).start;
        walk.add_face(first);
        let mut done = 0;
        for _ in 0..self.rings {
            let end = walk.out.vertices.len();
            for v in done..end {
                walk.add_around(v);
            }
            done = end;
        }
        walk.finish()
    }
}

struct Walk<'a> {
    finder: &'a Finder<'a>,
    out: Surroundings,
    local: HashMap<u32, u32>,
    local_uvs: HashMap<u32, u32>,
    faces: HashSet<u32>,
    /// Half-edge in which each local vertex was met first.
    seen_at: Vec<u32>,
}

impl Walk<'_> {
    /// Adds the face of half-edge `h`, beginning with its vertex only where it is the first.
    fn add_face(&mut self, h: u32) {
        let t = self.finder.surface.topology();
        if !self.faces.insert(t.face_of(h)) {
            return;
        }
        let count = t.face_halves(t.face_of(h)).len();
        self.out.sizes.push(count as u32);
        let mut at = h;
        for _ in 0..count {
            let v = t.vertex(at);
            let next = self.out.vertices.len() as u32;
            let local = *self.local.entry(v).or_insert(next);
            if local == next {
                self.out.vertices.push(v);
                self.seen_at.push(at);
            }
            self.out.corners.push(local);
            if let Some(&uv) = self.finder.surface.cage().corner_uvs().get(at as usize) {
                let next = self.out.uvs.len() as u32;
                let local = match uv {
                    NONE => NONE,
                    uv => *self.local_uvs.entry(uv).or_insert(next),
                };
                if local == next {
                    self.out.uvs.push(uv);
                }
                self.out.corner_uvs.push(local);
            }
            at = t.next(at);
        }
    }

    /// Adds all faces at a local vertex: counter-clockwise from where it was met, then clockwise, then what hangs together in no other way.
    fn add_around(&mut self, v: usize) {
        let t = self.finder.surface.topology();
        let first = self.seen_at[v];
        for step in [true, false] {
            let mut h = first;
            loop {
                h = if step { t.rotate(h) } else { t.rotate_back(h) };
                if h == NONE || h == first {
                    break;
                }
                self.add_face(h);
            }
        }
        let vertex = self.out.vertices[v] as usize;
        let range = self.finder.starts[vertex] as usize..self.finder.starts[vertex + 1] as usize;
        for &h in &self.finder.corners[range] {
            self.add_face(h);
        }
    }

    fn finish(mut self) -> Surroundings {
        let mut seen = HashSet::new();
        let mut first = 0;
        if !self.finder.creases.is_empty() {
            for &size in &self.out.sizes {
                for k in 0..size {
                    let a = self.out.corners[(first + k) as usize];
                    let b = self.out.corners[(first + (k + 1) % size) as usize];
                    let whole = [a, b].map(|v| self.out.vertices[v as usize]);
                    let found = self.finder.creases.get(&edge(whole[0], whole[1]));
                    if let Some(&sharpness) = found
                        && seen.insert(edge(a, b))
                    {
                        self.out.creases.push(Crease {
                            vertices: edge(a, b),
                            sharpness,
                        });
                    }
                }
                first += size;
            }
        }
        for (local, v) in (0..).zip(&self.out.vertices) {
            if let Some(&sharpness) = self.finder.sharp.get(v) {
                self.out.sharp.push(Corner {
                    vertex: local,
                    sharpness,
                });
            }
        }
        self.out
    }
}

/// What faces of one shape differ in: where their surroundings are in the cage.
#[derive(Clone, Debug)]
pub(super) struct Places {
    /// Number of the shape.
    pub(super) shape: u32,
    /// As in [`Surroundings`].
    pub(super) vertices: Vec<u32>,
    /// As in [`Surroundings`].
    pub(super) uvs: Vec<u32>,
}

impl Places {
    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.vertices) + size_of_val(&*self.uvs)
    }
}

impl Surroundings {
    /// What is left of them when their shape is known.
    pub(super) fn into_places(self, shape: u32) -> Places {
        Places {
            shape,
            vertices: self.vertices,
            uvs: self.uvs,
        }
    }

    /// Bytes that they take.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val(&*self.vertices)
            + size_of_val(&*self.sizes)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.creases)
            + size_of_val(&*self.sharp)
            + size_of_val(&*self.uvs)
            + size_of_val(&*self.corner_uvs)
    }

    /// Whether the face itself has texture coordinates all around.
    pub(super) fn has_own_uvs(&self) -> bool {
        let own = self.corner_uvs.get(..self.size() as usize);
        own.is_some_and(|own| !own.contains(&NONE))
    }

    /// Numbers that are the same where all weights are.
    pub(super) fn key(&self) -> Vec<u32> {
        let mut key = vec![self.vertices.len() as u32, self.sizes.len() as u32];
        key.extend(&self.sizes);
        key.extend(&self.corners);
        for c in &self.creases {
            key.extend([c.vertices[0], c.vertices[1], c.sharpness.to_bits()]);
        }
        key.push(NONE);
        for c in &self.sharp {
            key.extend([c.vertex, c.sharpness.to_bits()]);
        }
        key
    }

    /// The same for texture coordinates.
    pub(super) fn uv_key(&self) -> Vec<u32> {
        let mut key = self.key();
        key.extend(&self.corner_uvs);
        key
    }

    /// Corners of the face itself.
    pub(super) fn size(&self) -> u32 {
        self.sizes.first().copied().unwrap_or(0)
    }

    /// The surface of these faces alone, by the rules of the whole. The face is its face 0.
    pub(super) fn surface(&self, whole: &Surface) -> Surface {
        self.surface_with(whole, &[])
    }

    /// The same with values for the texture coordinates, if any.
    pub(super) fn surface_with(&self, whole: &Surface, uvs: &[[f32; 2]]) -> Surface {
        let mut offsets = vec![0];
        for &size in &self.sizes {
            offsets.push(offsets[offsets.len() - 1] + size);
        }
        let tags = whole.cage().tags();
        let (mut corners, mut corner_uvs) = (self.corners.clone(), self.corner_uvs.clone());
        let mut count = self.vertices.len();
        // Where the whole is split into quads this has to be, too: a triangle apart sees to it.
        if whole.is_split() && self.sizes.iter().all(|&n| n == 4) {
            offsets.push(offsets[offsets.len() - 1] + 3);
            corners.extend([0, 1, 2].map(|k| count as u32 + k));
            if !corner_uvs.is_empty() {
                corner_uvs.extend([NONE; 3]);
            }
            count += 3;
        }
        let cage = Cage {
            points: vec![[0.0; 3]; count],
            face_offsets: offsets,
            corner_vertices: corners,
            tags: Tags {
                creases: self.creases.clone(),
                corners: self.sharp.clone(),
                holes: Vec::new(),
                ..tags.clone()
            },
            uvs: uvs.to_vec(),
            corner_uvs: if uvs.is_empty() {
                Vec::new()
            } else {
                corner_uvs
            },
            ..Cage::default()
        };
        let mut options = *whole.options();
        options.scheme = Some(whole.scheme());
        options.patches = PatchKind::None;
        Surface::new(cage, &options)
    }
}
