//! An object's faces with their tables of weights, and who owns what they share.

use super::error::GpuError;
use super::plan::ObjectPlan;
use super::records::Rise;
use super::rings::{Rings, rings};
use super::surroundings::Places;
use super::tables::Table;
use super::uv_tables::UvTable;
use super::wgsl::{MAP, STILL};
use crate::frame::{Drawing, Object};
use crate::limits::Budget;
use crate::patch::PatchKind;
use crate::surface::Surface;
use crate::topology::NONE;
use std::collections::HashMap;

/// Most faces around a vertex, and corners of a face.
pub(super) const MOST_AROUND: u32 = 512;

/// An object with the tables of its faces.
pub(super) struct Dicer<'a> {
    pub(super) object: &'a Object,
    pub(super) surface: &'a Surface,
    /// First of its control points among those of the scene.
    pub(super) first_point: u32,
    pub(super) first_face: u32,
    /// Per cage face with a table.
    pub(super) faces: HashMap<u32, Places>,
    /// Of the limit surface or of control points after some steps. Patches have some where they are displaced or tilted.
    pub(super) tables: Vec<Table>,
    /// Of each table, by quad, the weights of control points where the device decides on blocks; see [`nets`](super::deciding::nets).
    pub(super) nets: Vec<Vec<Option<Vec<f32>>>>,
    /// What quadratic patches run through: the limit surface at level 1.
    pub(super) base_tables: Vec<Table>,
    /// Whether patches are displaced or tilted, by derivatives of the limit surface.
    pub(super) on_limit: bool,
    /// Per face of the cage the number of its table of texture coordinates; empty without.
    pub(super) uv_numbers: HashMap<u32, u32>,
    pub(super) uv_tables: Vec<UvTable>,
    /// First of the object's texture coordinates among the control numbers.
    pub(super) first_uv: u32,
    pub(super) look: Look,
    /// See [`Face::colors`].
    pub(super) colors: u32,
    /// Whether colours have tables of their own: they are those of the limit surface, whatever is drawn of its points.
    pub(super) own_colors: bool,
    /// See [`ObjectPlan::polygonal`].
    pub(super) polygonal: bool,
    pub(super) shown: Shown,
    /// First of what stands behind the control points of the scene for this object, counted as they are: normals of a cage, or control
    /// points of PN triangles.
    pub(super) first_extra: u32,
    /// Per drawn face the number of its table of colours, where that is not the one of its points.
    pub(super) color_numbers: HashMap<u32, u32>,
    pub(super) color_tables: Vec<Table>,
    /// Of corners whose normals are made of what is around them.
    pub(super) rings: Rings,
    /// Per face of the cage that is drawn, its deepest level.
    pub(super) drawn_levels: HashMap<u32, u32>,
    /// Per edge of the whole quads, the level of the points on it; [`NONE`] where nothing is drawn.
    edge_levels: Vec<u32>,
}

/// What faces are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shown {
    /// Points by their tables: of the limit surface, or control points after some steps.
    Points,
    /// Quadratic patches: nothing of the surface itself is known beyond level 1.
    Qas,
    /// Curved PN triangles, whose control points the processor makes.
    Pn,
    /// The polygons of the cage.
    Polygons,
}

/// What an object is drawn with.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Look {
    /// See [`Chunk`](super::records::Chunk).
    pub(super) width: u32,
    pub(super) uv_width: u32,
    pub(super) textured: bool,
    pub(super) shaded: bool,
    pub(super) tilted: bool,
    pub(super) cut: bool,
    /// Whether derivatives are differences of a block's points.
    pub(super) differences: bool,
    pub(super) rise: Rise,
}

impl Shown {
    fn of(surface: &Surface, drawing: Drawing) -> Self {
        match (drawing, surface.patch_kind()) {
            (Drawing::Cage, _) => Self::Polygons,
            (Drawing::Limit, PatchKind::Qas) => Self::Qas,
            (Drawing::Limit, PatchKind::Pn) => Self::Pn,
            _ => Self::Points,
        }
    }

    /// Whether faces are patches: colours and texture coordinates are those of the limit surface, deeper than what is known of points.
    pub(super) fn is_patches(self) -> bool {
        matches!(self, Self::Qas | Self::Pn)
    }
}

/// Where what belongs to an object begins among all numbers of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Firsts {
    pub(super) point: u32,
    pub(super) extra: u32,
    pub(super) face: u32,
    /// Among single numbers, as the next one.
    pub(super) uv: u32,
    pub(super) color: u32,
}

/// The table of a face.
#[derive(Clone, Copy)]
pub(super) struct FaceTable<'a, T> {
    pub(super) places: &'a Places,
    pub(super) number: u32,
    pub(super) table: &'a T,
}

impl<'a> Dicer<'a> {
    pub(super) fn new(
        object: &'a Object,
        plan: &ObjectPlan,
        first: Firsts,
        drawing: Drawing,
        look: Look,
        budget: &mut Budget<'_>,
    ) -> Result<Self, GpuError> {
        let surface = &object.surface;
        let mut dicer = Self {
            object,
            surface,
            first_point: first.point,
            first_extra: first.extra,
            first_face: first.face,
            faces: HashMap::new(),
            tables: Vec::new(),
            nets: Vec::new(),
            base_tables: Vec::new(),
            on_limit: false,
            uv_numbers: HashMap::new(),
            uv_tables: Vec::new(),
            first_uv: first.uv,
            look,
            shown: match Shown::of(surface, drawing) {
                // Their corners are limit points still.
                Shown::Qas if plan.polygonal => Shown::Points,
                shown => shown,
            },
            polygonal: plan.polygonal,
            own_colors: false,
            color_numbers: HashMap::new(),
            color_tables: Vec::new(),
            rings: Rings::new(),
            drawn_levels: HashMap::new(),
            // Control points come first, so a place after them is above this product.
            colors: match surface.cage().colors().is_empty() {
                true => 0,
                false => first.color - 3 * first.point,
            },
            edge_levels: vec![NONE; surface.whole_quads().edge_count()],
        };
        if dicer.shown == Shown::Polygons {
            return Ok(dicer);
        }
        dicer.on_limit = dicer.shown.is_patches() && (dicer.is_displaced() || dicer.look.tilted);
        let other_points = dicer.is_apart() || drawing == Drawing::Refined;
        dicer.own_colors = dicer.colors > 0 && other_points;
        let has_tables =
            dicer.shown != Shown::Pn || dicer.on_limit || dicer.look.textured || dicer.colors > 0;
        if has_tables {
            // Before anything walks around vertices.
            dicer.check()?;
        }
        let needs = dicer.needs(plan);
        if !has_tables {
            return Ok(dicer);
        }
        dicer.rings = rings(surface, budget)?;
        dicer.make_tables(&needs, drawing, plan.flatness.is_some(), budget)?;
        Ok(dicer)
    }

    /// Tables grow with the faces around a vertex, and with the corners of a face.
    fn check(&self) -> Result<(), GpuError> {
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
    fn needs(&mut self, plan: &ObjectPlan) -> Vec<u32> {
        let whole = self.surface.whole_quads();
        for (quad, &reach) in plan.reach.iter().enumerate() {
            if reach == NONE {
                continue;
            }
            let face = self.surface.cage_face(quad as u32);
            let deepest = self.drawn_levels.entry(face).or_insert(reach);
            *deepest = reach.max(*deepest);
            let reach = self.known(reach);
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
            ask(quad as u32, self.known(reach));
            for h in whole.face_halves(quad as u32) {
                let level = self.edge_levels[whole.edge(h) as usize];
                for h in self.sources(h) {
                    ask(whole.face_of(h), level);
                }
            }
        }
        needs
    }

    /// The level at which points are wanted of a face that is drawn at another.
    fn known(&self, reach: u32) -> u32 {
        match self.shown {
            Shown::Qas if !self.on_limit => 1,
            _ => reach,
        }
    }

    /// Whether faces are patches and nothing is known of the limit surface's points.
    pub(super) fn is_apart(&self) -> bool {
        self.shown.is_patches() && !self.on_limit
    }

    /// Whether patches are displaced: points of their sides stand on curves.
    pub(super) fn lifts_patches(&self) -> bool {
        self.shown.is_patches() && self.is_displaced()
    }

    /// Weights of a colour by a control point.
    pub(super) fn color_width(&self) -> u32 {
        match self.own_colors || self.polygonal || self.shown == Shown::Polygons {
            true => 1,
            false => self.look.width,
        }
    }

    pub(super) fn is_displaced(&self) -> bool {
        self.look.rise.shape != STILL
    }

    /// Whether texture coordinates say how far points move.
    pub(super) fn lifts_by_uvs(&self) -> bool {
        self.look.rise.shape == MAP && self.surface.has_uvs()
    }

    /// Where the control points of a quad's PN triangles stand.
    pub(super) fn net(&self, quad: u32) -> u32 {
        self.first_extra + quad * self.surface.pn_net_len()
    }

    /// The table of a quad's face, which is drawn or gives points to one that is.
    pub(super) fn table(&self, quad: u32) -> Result<FaceTable<'_, Table>, GpuError> {
        self.one_of(&self.tables, quad)
    }

    /// The same of what quadratic patches run through.
    pub(super) fn base_table(&self, quad: u32) -> Result<FaceTable<'_, Table>, GpuError> {
        self.one_of(&self.base_tables, quad)
    }

    fn one_of<'t>(
        &'t self,
        tables: &'t [Table],
        quad: u32,
    ) -> Result<FaceTable<'t, Table>, GpuError> {
        const MISSING: GpuError = GpuError::Missing {
            what: "table of a face",
        };
        let places = self.faces.get(&self.surface.cage_face(quad));
        let places = places.ok_or(MISSING)?;
        Ok(FaceTable {
            places,
            number: places.shape,
            table: tables.get(places.shape as usize).ok_or(MISSING)?,
        })
    }

    /// The table of its texture coordinates; nothing where none are wanted.
    pub(super) fn uv_table(&self, quad: u32) -> Option<FaceTable<'_, UvTable>> {
        let face = self.surface.cage_face(quad);
        let number = *self.uv_numbers.get(&face)?;
        Some(FaceTable {
            places: self.faces.get(&face)?,
            number,
            table: &self.uv_tables[number as usize],
        })
    }

    /// The table of its colours; nothing where they go by the weights of its points.
    pub(super) fn color_table(&self, quad: u32) -> Option<FaceTable<'_, Table>> {
        let face = self.surface.cage_face(quad);
        let number = *self.color_numbers.get(&face)?;
        Some(FaceTable {
            places: self.faces.get(&face)?,
            number,
            table: &self.color_tables[number as usize],
        })
    }

    /// The level of the points on a side.
    pub(super) fn side_level(&self, h: u32) -> Result<u32, GpuError> {
        let whole = self.surface.whole_quads();
        match self.edge_levels[whole.edge(h) as usize] {
            NONE => Err(GpuError::Missing {
                what: "level of a side",
            }),
            level => Ok(level),
        }
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
}
