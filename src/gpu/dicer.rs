//! An object's faces with their tables of weights, and who owns what they share.

use super::error::GpuError;
use super::plan::ObjectPlan;
use super::surroundings::{Finder, Surroundings};
use super::tables::{self, Table, UvTable};
use crate::frame::Object;
use crate::limits::Limits;
use crate::patch::PatchKind;
use crate::scheme::Scheme;
use crate::surface::Surface;
use crate::topology::NONE;
use std::collections::HashMap;

/// Most faces around a vertex, and corners of a face.
const MOST_AROUND: u32 = 512;

/// An object with the tables of its faces.
pub(super) struct Dicer<'a> {
    pub(super) object: &'a Object,
    pub(super) surface: &'a Surface,
    /// First of its control points among those of the scene.
    pub(super) first_point: u32,
    pub(super) first_face: u32,
    /// Per cage face with a table: its surroundings, and the number of its shape.
    pub(super) faces: HashMap<u32, (Surroundings, u32)>,
    pub(super) tables: Vec<Table>,
    /// Per face of the cage the number of its shape with texture coordinates; empty without.
    pub(super) uv_shapes: HashMap<u32, u32>,
    pub(super) uv_tables: Vec<UvTable>,
    /// First of the object's texture coordinates among the control numbers.
    pub(super) first_uv: u32,
    /// See [`Face::colors`].
    pub(super) colors: u32,
    /// Whether faces are quadratic patches: nothing of the surface itself is known beyond level 1 then.
    pub(super) patches: bool,
    /// Per face of the cage that is drawn, its deepest level.
    pub(super) drawn_levels: HashMap<u32, u32>,
    /// Per edge of the whole quads, the level of the points on it; [`NONE`] where nothing is drawn.
    pub(super) edge_levels: Vec<u32>,
}

/// The half-edges whose faces give a side its points, and its normals.
#[derive(Clone, Copy)]
pub(super) struct Owners {
    pub(super) position: u32,
    pub(super) normal: u32,
}

impl<'a> Dicer<'a> {
    pub(super) fn new(
        object: &'a Object,
        plan: &ObjectPlan,
        [first_point, first_face, first_uv, first_color]: [u32; 4],
        wants_uvs: bool,
        limits: &Limits,
    ) -> Result<Self, GpuError> {
        let surface = &object.surface;
        let mut dicer = Self {
            object,
            surface,
            first_point,
            first_face,
            faces: HashMap::new(),
            tables: Vec::new(),
            uv_shapes: HashMap::new(),
            uv_tables: Vec::new(),
            first_uv,
            patches: surface.patch_kind() == PatchKind::Qas,
            drawn_levels: HashMap::new(),
            // Control points come first, so a place after them is above this product.
            colors: match surface.cage().colors().is_empty() {
                true => 0,
                false => first_color - 3 * first_point,
            },
            edge_levels: vec![NONE; surface.whole_quads().edge_count()],
        };
        dicer.check()?;
        let needs = dicer.needs(plan);
        dicer.make_tables(&needs, limits)?;
        if wants_uvs && surface.has_uvs() {
            dicer.make_uv_tables(limits)?;
        }
        Ok(dicer)
    }

    /// Tables grow with the faces around a vertex, and with the corners of a face.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        let t = self.surface.topology();
        let most = t.fans().iter().map(|f| f.faces).max().unwrap_or(0);
        let corners = (0..t.face_count() as u32).map(|f| t.face_halves(f).len() as u32);
        if most.max(corners.max().unwrap_or(0)) > MOST_AROUND {
            return Err(GpuError::Unsupported {
                what: "vertices of more than 512 faces, or faces of as many corners",
            });
        }
        Ok(())
    }

    /// Levels that faces of the cage have to be known at: their own blocks', and those of sides and corners that they own.
    pub(super) fn needs(&mut self, plan: &ObjectPlan) -> Vec<u32> {
        let whole = self.surface.whole_quads();
        for (quad, &reach) in plan.reach.iter().enumerate() {
            if reach == NONE {
                continue;
            }
            let face = self.surface.cage_face(quad as u32);
            let deepest = self.drawn_levels.entry(face).or_insert(reach);
            *deepest = reach.max(*deepest);
            let reach = if self.patches { 1 } else { reach };
            for h in whole.face_halves(quad as u32) {
                let level = &mut self.edge_levels[whole.edge(h) as usize];
                *level = if *level == NONE {
                    reach
                } else {
                    reach.max(*level)
                };
            }
        }
        let mut needs = vec![NONE; self.surface.topology().face_count()];
        let mut ask = |quad: u32, level: u32| {
            let need = &mut needs[self.surface.cage_face(quad) as usize];
            *need = if *need == NONE {
                level
            } else {
                level.max(*need)
            };
        };
        for (quad, &reach) in plan.reach.iter().enumerate() {
            if reach == NONE {
                continue;
            }
            ask(quad as u32, if self.patches { 1 } else { reach });
            for h in whole.face_halves(quad as u32) {
                let level = self.edge_levels[whole.edge(h) as usize];
                for owners in [self.side_owners(h), self.corner_owners(h)] {
                    ask(whole.face_of(owners.position), level);
                    ask(whole.face_of(owners.normal), level);
                }
            }
        }
        needs
    }

    pub(super) fn make_tables(&mut self, needs: &[u32], limits: &Limits) -> Result<(), GpuError> {
        let finder = Finder::new(self.surface);
        let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut shapes: Vec<(Surroundings, u32)> = Vec::new();
        for (face, &need) in needs.iter().enumerate() {
            if need == NONE {
                continue;
            }
            if face % 1024 == 0 {
                limits.check()?;
            }
            let found = finder.find(face as u32);
            let next = shapes.len() as u32;
            let number = *numbers.entry(found.key()).or_insert(next);
            if number == next {
                shapes.push((found.clone(), need));
            } else {
                let level = &mut shapes[number as usize].1;
                *level = need.max(*level);
            }
            self.faces.insert(face as u32, (found, number));
        }
        self.tables = tables::make(self.surface, &shapes, limits)?;
        Ok(())
    }

    /// Tables of texture coordinates, as fine as those of points.
    pub(super) fn make_uv_tables(&mut self, limits: &Limits) -> Result<(), GpuError> {
        let mut numbers: HashMap<(Vec<u32>, u32), u32> = HashMap::new();
        let mut shapes: Vec<(Surroundings, u32)> = Vec::new();
        let mut faces: Vec<u32> = self.drawn_levels.keys().copied().collect();
        faces.sort_unstable();
        for face in faces {
            let Some((shape, number)) = self.faces.get(&face) else {
                continue;
            };
            let level = match self.patches {
                true => self.drawn_levels[&face],
                false => self.tables[*number as usize].level,
            };
            let next = shapes.len() as u32;
            let number = *numbers.entry((shape.uv_key(), level)).or_insert(next);
            if number == next {
                shapes.push((shape.clone(), level));
            }
            self.uv_shapes.insert(face, number);
        }
        self.uv_tables = tables::make_uvs(self.surface, &shapes, limits)?;
        Ok(())
    }

    /// Whose points a side has: those of the edge's first half-edge; normals are one's own along creases and borders.
    pub(super) fn side_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let twin = cut.twin(h);
        let own = twin == NONE || self.is_faceted();
        Owners {
            position: whole.edge_half(whole.edge(h)),
            normal: if own { h } else { h.min(twin) },
        }
    }

    /// The same of a corner: the first half-edge around.
    pub(super) fn corner_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let first = |found: u32| if found == NONE { h } else { found };
        Owners {
            position: first(whole.fans()[whole.fan(h) as usize].first),
            normal: match self.is_faceted() {
                true => h,
                false => first(cut.fans()[cut.fan(h) as usize].first),
            },
        }
    }

    /// Whether every face has normals of its own all around.
    pub(super) fn is_faceted(&self) -> bool {
        self.surface.scheme() == Scheme::Bilinear
    }

    pub(super) fn table(&self, quad: u32) -> Option<(&Surroundings, u32, &Table)> {
        let (shape, number) = self.faces.get(&self.surface.cage_face(quad))?;
        Some((shape, *number, &self.tables[*number as usize]))
    }

    /// Quad `quad` among those of its cage face.
    pub(super) fn sub(&self, quad: u32) -> u32 {
        if self.surface.is_split() {
            let face = self.surface.cage_face(quad);
            quad - self.surface.topology().face_halves(face).start
        } else {
            0
        }
    }

    pub(super) fn corner_count(&self) -> u32 {
        if self.surface.is_triangular() { 3 } else { 4 }
    }

    /// Column and row of the point `k` of `n` along side `c`.
    pub(super) fn along(&self, c: u32, k: u32, n: u32) -> [u32; 2] {
        if self.surface.is_triangular() {
            return [[k, 0], [n, k], [n - k, n - k]][c as usize];
        }
        [[k, 0], [n, k], [n - k, n], [0, n - k]][c as usize]
    }

    /// Number of shapes, and bytes of their tables.
    pub(super) fn table_size(&self) -> (usize, u64) {
        let bytes = self.tables.iter().map(Table::bytes).sum();
        (self.tables.len(), bytes)
    }
}
