//! Tables of interpolating surfaces, and the meshes that they are applied to.
//!
//! Faces are diced by tables of at most 32 segments a side ([`crate::dice::table`]), one table per shape of the surroundings. A mesh
//! whose faces all look different would need as many tables as it has faces; but after two or three steps extraordinary vertices lie so far
//! apart that no face sees more than one, and some hundred shapes are all there are. So the whole mesh is refined some levels first: none
//! where its shapes are few, else until they are, and as deep as tables of five levels ask for. The mesh of that depth is kept: it takes
//! four times the memory of the one before, per level.
//!
//! Kobbelt's rules beside pairs of extraordinary vertices reach further than two rings, so irregular cages take two steps at least.

mod build;
mod shape;
mod sheet;
mod size;
mod walk;

use super::Kind;
use crate::dice::MAX_LEVEL;
use crate::dice::table::{Table, TableChannel, TableMesh, TableShapes, cells};
use crate::limits::{Budget, LimitError, Limits};
use crate::refine::limit::Tangents;
use crate::refine::sharpness::Step;
use crate::refine::{Level, Options, Timings, limit};
use crate::scheme::Scheme;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;
use shape::Shape;
use sheet::Sheet;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

pub(super) use walk::surroundings;
pub(crate) use walk::{Found, STEPS, Walk};

/// Levels of a table, at most.
const TABLE_LEVELS: u32 = 5;
/// Bytes of the tables of one level; beyond, the mesh is refined further.
const MOST_BYTES: usize = 64 << 20;
/// Faces of all tables of one level, beyond which the mesh is refined further to have fewer or smaller ones …
const MOST_FACES: usize = 1 << 17;
/// … up to this depth, where shapes become no fewer.
const FEWEST_SHAPES: u32 = 3;

/// The channel of every kind: points, texture coordinates, colours.
type ByKind<T> = [Option<T>; 3];

/// The shapes of one depth, of points and of texture coordinates.
#[derive(Clone, Debug)]
struct Shapes {
    faces: [Option<Arc<TableShapes>>; 2],
    shapes: [Vec<Shape>; 2],
}

/// Tables of one level, of points and of texture coordinates.
#[derive(Clone, Debug)]
struct Tables {
    depth: u32,
    tables: [Arc<Vec<Arc<Table>>>; 2],
    cells: Arc<Vec<[u32; 2]>>,
}

/// What depends on connectivity alone, and so outlives moving points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plans {
    shapes: [OnceLock<Shapes>; MAX_LEVEL as usize + 1],
    tables: [OnceLock<Tables>; MAX_LEVEL as usize + 1],
    tangents: OnceLock<Arc<Tangents>>,
}

/// The whole mesh at one depth.
#[derive(Clone, Debug)]
struct Depth {
    level: Level<f64>,
    colors: Vec<[f64; 3]>,
    sheets: [Option<Sheet>; 2],
    meshes: ByKind<Arc<TableMesh>>,
}

/// All meshes and tables of a surface, made as deep as they are asked for.
#[derive(Clone, Debug)]
pub(crate) struct TableTree {
    options: Options,
    root: Arc<Depth>,
    deeper: [OnceLock<Option<Arc<Depth>>>; MAX_LEVEL as usize],
    channels: [OnceLock<ByKind<Arc<TableChannel>>>; MAX_LEVEL as usize + 1],
    plans: Arc<Plans>,
}

fn narrow(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|c| c as f32)).collect()
}

impl Depth {
    fn new(level: Level<f64>, colors: Vec<[f64; 3]>, options: &Options) -> Self {
        let t = &level.topology;
        let step = Step::new(t, options);
        let points = Sheet::of_points(&step, &level);
        let uvs = Sheet::of_uvs(&step, &level);
        let limits = (Level::new(t.clone(), level.points.clone()))
            .map(|bare| limit(&bare, options))
            .unwrap_or_default();
        let corner_normals = match limits.corner_normals.is_empty() {
            true => t.corner_vertices.clone(),
            false => limits.corner_normals,
        };
        // Where more than two faces share an edge, or a crease cuts it, the edge still has one owner.
        let owners = (0..t.half_count() as u32)
            .map(|h| t.edge_half(t.edge(h)))
            .collect();
        let mesh = TableMesh {
            topology: points.topology.clone(),
            points: narrow(&level.points),
            corner_normals,
            normals: narrow(&limits.normals),
            owners,
        };
        let plain = |topology: &Topology, points: Vec<[f32; 3]>| TableMesh {
            topology: topology.clone(),
            points,
            ..TableMesh::default()
        };
        let uv_mesh = (uvs.as_ref().zip(level.uvs.as_ref())).map(|(sheet, uvs)| {
            let wide = |&[u, v]: &[f64; 2]| [u as f32, v as f32, 0.0];
            plain(&sheet.topology, uvs.values.iter().map(wide).collect())
        });
        let color_mesh = (!colors.is_empty()).then(|| plain(&points.topology, narrow(&colors)));
        drop(step);
        Self {
            meshes: [Some(mesh), uv_mesh, color_mesh].map(|m| m.map(Arc::new)),
            sheets: [Some(points), uvs],
            level,
            colors,
        }
    }

    fn next(&self, options: &Options) -> Option<Self> {
        let mut timings = Timings::default();
        let level = self.level.next(options, &mut timings).ok()?;
        let colors = match self.colors.is_empty() {
            true => Vec::new(),
            false => {
                let colors = Level::new(self.level.topology.clone(), self.colors.clone()).ok()?;
                colors.next(options, &mut timings).ok()?.points
            }
        };
        Some(Self::new(level, colors, options))
    }
}

/// Whether no face point of Kobbelt's scheme depends on more than one irregular vertex: there is none.
fn is_regular(t: &Topology) -> bool {
    t.fans()
        .iter()
        .all(|f| f.first == NONE || if f.closed { f.faces == 4 } else { f.faces < 3 })
}

impl TableTree {
    /// The tree over `level`, whose faces are all quads or all triangles. `colors` holds one value per vertex, or nothing. `plans` may be
    /// those of a tree of the same connectivity.
    pub(crate) fn new(
        level: Level<f64>,
        colors: Vec<[f64; 3]>,
        options: Options,
        plans: Option<Arc<Plans>>,
    ) -> Self {
        Self {
            root: Arc::new(Depth::new(level, colors, &options)),
            options,
            deeper: [const { OnceLock::new() }; MAX_LEVEL as usize],
            channels: [const { OnceLock::new() }; MAX_LEVEL as usize + 1],
            plans: plans.unwrap_or_default(),
        }
    }

    /// A walk to single points, or to texture coordinates if there are any.
    pub(crate) fn walk(&self, kind: Kind) -> Option<Walk<'_>> {
        let uvs = match kind {
            Kind::Points => false,
            Kind::Uvs if self.root.level.uvs.is_some() => true,
            _ => return None,
        };
        Some(Walk::new(self, uvs))
    }

    /// The faces that are drawn as they hang together, infinite creases not cut open.
    pub(crate) fn whole(&self) -> &Topology {
        self.root_topology()
    }

    /// What depends on connectivity alone.
    pub(crate) fn plans(&self) -> Arc<Plans> {
        Arc::clone(&self.plans)
    }

    /// Masks of tangents, made once.
    fn tangents(&self) -> &Tangents {
        let make = || Arc::new(Tangents::new(self.options.scheme));
        self.plans.tangents.get_or_init(make)
    }

    /// The channel of the faces that are drawn.
    pub(crate) fn root(&self, kind: Kind) -> Option<&TableMesh> {
        self.root.meshes[kind as usize].as_deref()
    }

    /// A channel at a level that was made ready by [`TableTree::ensure`].
    pub(crate) fn channel(&self, kind: Kind, level: u32) -> Option<&Arc<TableChannel>> {
        let channels = self.channels.get(level as usize)?.get()?;
        channels[kind as usize].as_ref()
    }

    /// Bytes and number of the tables of a level that was made ready, and the depth of the mesh that they are applied to.
    pub(crate) fn table_bytes(&self, level: u32) -> Option<(usize, usize, u32)> {
        let tables = self.plans.tables.get(level as usize)?.get()?;
        let [a, b] = &tables.tables;
        let mut all: Vec<&Arc<Table>> = a.iter().chain(b.iter()).collect();
        all.sort_by_key(|t| Arc::as_ptr(t));
        all.dedup_by_key(|t| Arc::as_ptr(t));
        let bytes = all.iter().map(|t| t.bytes()).sum();
        Some((bytes, all.len(), tables.depth))
    }

    /// Makes what dicing at `level` needs. Nobody waits for another thread here; see `ControlTree::ensure`.
    pub(crate) fn ensure(&self, level: u32) {
        if self.channel(Kind::Points, level.min(MAX_LEVEL)).is_some() {
            return;
        }
        // Without limits nothing fails.
        let _ = self.try_ensure(level, &mut Budget::new(&Limits::default()));
    }

    /// The same within a budget, which counts what is there already too.
    ///
    /// # Errors
    /// The meshes or the tables would not fit.
    pub(crate) fn try_ensure(&self, level: u32, budget: &mut Budget<'_>) -> Result<(), LimitError> {
        let level = level.min(MAX_LEVEL);
        let depth = self.choose_depth(level, budget)?;
        self.take_tables(level, depth, budget)?;
        let slot = &self.channels[level as usize];
        if slot.get().is_some() {
            return Ok(());
        }
        let tables = match self.plans.tables[level as usize].get() {
            Some(tables) => tables.clone(),
            None => {
                let tables = self.make_tables(level, depth);
                let _ = self.plans.tables[level as usize].set(tables.clone());
                tables
            }
        };
        let (Some(depth), Some(shapes)) = (self.depth(tables.depth), self.shapes(tables.depth))
        else {
            return Ok(());
        };
        let channel = |kind: Kind| {
            // Colours are values of vertices, like points.
            let k = usize::from(kind == Kind::Uvs);
            Some(Arc::new(TableChannel {
                mesh: depth.meshes[kind as usize].clone()?,
                shapes: shapes.faces[k].clone()?,
                tables: Arc::clone(&tables.tables[k]),
                depth: tables.depth,
                steps: level - tables.depth,
                cells: Arc::clone(&tables.cells),
                triangular: self.options.scheme.is_triangular(),
            }))
        };
        let _ = slot.set([Kind::Points, Kind::Uvs, Kind::Colors].map(channel));
        Ok(())
    }

    fn depth(&self, depth: u32) -> Option<Arc<Depth>> {
        let mut at = Arc::clone(&self.root);
        for slot in self.deeper.iter().take(depth as usize) {
            if slot.get().is_none() {
                let _ = slot.set(at.next(&self.options).map(Arc::new));
            }
            at = slot.get()?.clone()?;
        }
        Some(at)
    }

    fn shapes(&self, depth: u32) -> Option<&Shapes> {
        let slot = &self.plans.shapes[depth as usize];
        if slot.get().is_none() {
            let mesh = self.depth(depth)?;
            let sides = if self.options.scheme.is_triangular() {
                3
            } else {
                4
            };
            let rings = build::rings(self.options.scheme);
            let of = |sheet: &Option<Sheet>| match sheet {
                None => (None, Vec::new()),
                Some(sheet) => {
                    let (faces, shapes) = shape::shapes(sheet, sides, rings);
                    (Some(Arc::new(faces)), shapes)
                }
            };
            let [points, uvs] = &mesh.sheets;
            let (points, uvs) = (of(points), of(uvs));
            let _ = slot.set(Shapes {
                faces: [points.0, uvs.0],
                shapes: [points.1, uvs.1],
            });
        }
        slot.get()
    }

    /// How deep the mesh has to be for a level. The budget is asked for every mesh before it is made.
    fn choose_depth(&self, level: u32, budget: &mut Budget<'_>) -> Result<u32, LimitError> {
        let mut depth = level.saturating_sub(TABLE_LEVELS);
        if self.options.scheme == Scheme::Kobbelt && !is_regular(self.root_topology()) {
            depth = depth.max(level.min(2));
        }
        self.take_meshes(0, depth, budget)?;
        while depth < level {
            let Some(shapes) = self.shapes(depth) else {
                break;
            };
            let faces = 1_usize << (2 * (level - depth));
            let bytes = shapes.table_bytes(level - depth);
            let all = || shapes.shapes.iter().flatten();
            let small = all().count() * faces <= MOST_FACES || depth >= FEWEST_SHAPES;
            if bytes <= MOST_BYTES && small {
                break;
            }
            depth += 1;
            self.take_meshes(depth - 1, depth, budget)?;
        }
        Ok(depth)
    }

    fn root_topology(&self) -> &Topology {
        &self.root.level.topology
    }

    fn make_tables(&self, level: u32, depth: u32) -> Tables {
        let steps = level - depth;
        let shapes = (steps > 0).then(|| self.shapes(depth)).flatten();
        let [points, uvs] = match shapes {
            Some(s) => [s.shapes[0].as_slice(), s.shapes[1].as_slice()],
            None => [&[][..]; 2],
        };
        let mut unique: BTreeMap<&Shape, Arc<Table>> = BTreeMap::new();
        let mut wanted: Vec<&Shape> = points.iter().chain(uvs).collect();
        wanted.sort();
        wanted.dedup();
        let tangents = self.tangents();
        let made: Vec<Arc<Table>> = (wanted.par_iter())
            .map(|s| Arc::new(build::table(s, &self.options, tangents, steps)))
            .collect();
        unique.extend(wanted.into_iter().zip(made));
        let tables_of = |shapes: &[Shape]| {
            let of = |s: &Shape| unique.get(s).map(Arc::clone).unwrap_or_default();
            Arc::new(shapes.iter().map(of).collect())
        };
        Tables {
            depth,
            tables: [tables_of(points), tables_of(uvs)],
            cells: Arc::new(cells(self.options.scheme.is_triangular(), depth)),
        }
    }
}
