//! The subdivision surface of a cage: topology once, points as often as they move.

mod cells;
mod channel_patch;
mod channels;
mod diced;
mod displaced;
mod export;
mod hull;
mod jets;
mod limits;
mod make;
mod mesh;
mod patch;
mod patches;
mod polygons;

use crate::control::tables::TableTree;
use crate::control::{ControlTree, Kind};
use crate::dice::fan_points::FanPoints;
use crate::dice::triangle::is_regular as is_regular_triangle_fan;
use crate::mesh::Cage;
use crate::patch::{PatchKind, PnCage};
use crate::refine;
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};
use crate::topology::ears::Ears;
use crate::topology::{ConnectOptions, Topology, TopologyWarning, connect};
use displaced::Displaced;
use make::{given_normals, scheme_of, tagged_tension};
use mesh::QuadMesh;
use std::sync::{Arc, OnceLock};

pub(crate) use cells::{MOST_CELLS, PolygonBlock, PolygonBlocks, cell_places};
pub(crate) use channel_patch::Spline;
pub use diced::DicedQuad;
#[cfg(feature = "gpu")]
pub(crate) use jets::PlaceJets;
pub(crate) use limits::RefinedFans;
pub(crate) use patch::QuadPatch;

/// How a cage is read as a surface. What is `None` comes from the cage's tags, else from the defaults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceOptions {
    /// Subdivision scheme; by default the cage's own ([`Tags::scheme`](crate::mesh::Tags)), else Loop where every face is a triangle, else
    /// Catmull-Clark.
    pub scheme: Option<Scheme>,
    /// Decay of semi-sharp creases; default uniform.
    pub creases: Option<CreaseMethod>,
    /// Weights beside triangles; default Catmull-Clark's own.
    pub triangles: Option<TriangleRule>,
    /// Boundary rule; default edge-and-corner.
    pub boundary: Option<Boundary>,
    /// Face-varying rule; default corners-plus1.
    pub face_varying: Option<FaceVaryingRule>,
    /// Patches that are diced in place of the limit surface; default none.
    pub patches: PatchKind,
}

/// What patches are made of.
#[derive(Clone, Debug)]
enum PatchCage {
    /// Nothing but the limit surface.
    Qas,
    Pn(Box<PnCage>),
}

/// Values at the vertices, refined like the points: same topology, other numbers.
#[derive(Clone, Debug)]
struct VertexChannel {
    points: Vec<[f32; 3]>,
    fans: FanPoints,
}

/// A subdivision surface, ready to be diced and drawn.
///
/// ```
/// use earmark::{Cage, Surface};
///
/// // A cube: limit point and normal of its first corner.
/// let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
/// let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
/// let surface = Surface::new(Cage::new(points, &[4; 6], corners)?, &Default::default());
/// let grid = surface.dice(0, 3);
/// assert_eq!(grid.points[0], [-0.5, -0.5, -0.5]);
/// assert!((grid.normals[0][0] + 1.0 / 3.0_f32.sqrt()).abs() < 1e-6);
/// # Ok::<(), earmark::mesh::CageError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Surface {
    cage: Cage,
    options: SurfaceOptions,
    scheme: Scheme,
    /// The cage's connectivity, and its channels unless a control tree holds them.
    mesh: QuadMesh,
    uv: Option<QuadMesh>,
    colors: Option<VertexChannel>,
    /// All channels of a cage with creases or corners.
    control: Option<Box<ControlTree>>,
    /// Of the tree of a cage that is split first: the vertex of the split mesh that each vertex is.
    split_vertices: Vec<u32>,
    /// All channels under interpolating schemes.
    tables: Option<Box<TableTree>>,
    /// In place of the limit surface.
    patches: Option<PatchCage>,
    linear: bool,
    linear_uv: bool,
    /// Whether faces are triangles, under Loop's scheme and Modified Butterfly.
    triangles: bool,
    displaced: Option<Arc<Displaced>>,
    /// The cage as it is drawn as given, from the first time on.
    polygons: OnceLock<PolygonBlocks>,
    warnings: Vec<TopologyWarning>,
}

impl Surface {
    /// The surface of `cage`. Cannot fail: whatever the cage is, it has a surface; what had to be decided on the way is in
    /// [`Surface::warnings`].
    #[must_use]
    pub fn new(mut cage: Cage, options: &SurfaceOptions) -> Self {
        // Grids are parted from corner 0 to corner 2.
        let mut parted = Vec::new();
        if options.patches == PatchKind::Pn {
            parted = cage.second_diagonals();
            if cage.is_quads() {
                cage = cage.turned(&std::mem::take(&mut parted));
            }
        }
        let tags = &cage.tags;
        let boundary = options.boundary.or(tags.boundary).unwrap_or_default();
        let (base, mut warnings) = connect(
            cage.points.len(),
            &cage.face_offsets,
            cage.corner_vertices.clone(),
            &ConnectOptions {
                boundary,
                creases: &tags.creases,
                corners: &tags.corners,
                holes: &tags.holes,
            },
        );
        let rule = options
            .face_varying
            .or(tags.face_varying)
            .unwrap_or_default();
        let scheme = scheme_of(&cage, options, &mut warnings);
        let linear = scheme == Scheme::Bilinear;
        let triangles = scheme.is_triangular();
        let mut surface = Self {
            options: *options,
            scheme,
            mesh: QuadMesh::bare(base),
            uv: None,
            colors: None,
            control: None,
            split_vertices: Vec::new(),
            tables: None,
            patches: None,
            linear,
            linear_uv: linear || rule == FaceVaryingRule::All,
            triangles,
            displaced: None,
            polygons: OnceLock::new(),
            warnings,
            cage,
        };
        surface.tables = surface.table_tree(rule, None).map(Box::new);
        if surface.tables.is_none() {
            surface.control = surface.control_tree(rule).map(Box::new);
        }
        if surface.tables.is_none() && surface.control.is_none() {
            surface.make_channels(rule, boundary);
        }
        surface.patches = match options.patches {
            PatchKind::None => None,
            PatchKind::Qas => Some(PatchCage::Qas),
            PatchKind::Pn => {
                let (t, cage) = (&surface.mesh.base, &surface.cage);
                let (given, tension) = (given_normals(cage), tagged_tension(cage));
                let cage = PnCage::new(t, &cage.points, given, tension, parted);
                Some(PatchCage::Pn(Box::new(cage)))
            }
        };
        surface
    }

    /// The rules by which the cage is refined: options, else its tags, else defaults.
    #[must_use]
    pub fn refine_options(&self) -> refine::Options {
        let (options, tags) = (&self.options, &self.cage.tags);
        refine::Options {
            scheme: self.scheme,
            creases: options.creases.or(tags.crease_method).unwrap_or_default(),
            triangles: options.triangles.or(tags.triangles).unwrap_or_default(),
        }
    }

    /// The rule of face-varying values: the option, else the cage's tag, else corners-plus1.
    #[must_use]
    pub fn face_varying_rule(&self) -> FaceVaryingRule {
        let rule = self.options.face_varying;
        rule.or(self.cage.tags.face_varying).unwrap_or_default()
    }

    /// Moves the cage's points; topology stays.
    ///
    /// # Errors
    /// [`CageError`](crate::mesh::CageError) when there are not as many as before, or one is not finite.
    pub fn update_points(&mut self, points: &[[f32; 3]]) -> Result<(), crate::mesh::CageError> {
        use crate::mesh::CageError;
        if points.len() != self.cage.points.len() {
            return Err(CageError::WrongCount {
                what: "points",
                got: points.len(),
                wanted: self.cage.points.len(),
            });
        }
        if let Some(vertex) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(CageError::NotFinite { vertex });
        }
        self.cage.points.copy_from_slice(points);
        self.polygons = OnceLock::new();
        if let Some(tables) = &self.tables {
            let plans = Some(tables.plans());
            let rule = self.face_varying_rule();
            self.tables = self.table_tree(rule, plans).map(Box::new);
        } else if self.control.is_some() {
            let options = self.refine_options();
            let mut wide: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
            if self.is_split() {
                let all = refine::next_points(&self.mesh.base, &options, &wide);
                wide = (self.split_vertices.iter())
                    .map(|&v| all[v as usize])
                    .collect();
            }
            if let Some(control) = &mut self.control {
                control.update(wide);
            }
        } else {
            self.mesh.update(points, true);
        }
        if let Some(PatchCage::Pn(pn)) = &mut self.patches {
            pn.move_points(&self.mesh.base, &self.cage.points);
        }
        self.update_displacement();
        Ok(())
    }

    /// Whether the faces that are diced are triangles (under Loop's scheme and Modified Butterfly); else they are quads. A triangle fills the half of its grid
    /// where the row is at most the column: corner 0 at (0, 0), corner 1 at (n, 0), corner 2 at (n, n).
    #[must_use]
    pub fn is_triangular(&self) -> bool {
        self.triangles
    }
    /// How the cage was read.
    pub(crate) fn options(&self) -> &SurfaceOptions {
        &self.options
    }
    /// The scheme it is subdivided by.
    #[must_use]
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }
    /// The cage.
    #[must_use]
    pub fn cage(&self) -> &Cage {
        &self.cage
    }
    /// What was odd in the topology.
    #[must_use]
    pub fn warnings(&self) -> &[TopologyWarning] {
        &self.warnings
    }
    /// Connectivity of the cage.
    #[must_use]
    pub fn topology(&self) -> &Topology {
        &self.mesh.base
    }
    /// The quads that are diced: the cage's own, or those of its first step where it has other polygons.
    #[must_use]
    pub fn quads(&self) -> &Topology {
        if let Some(mesh) = self.table_root() {
            return &mesh.topology;
        }
        match self.control.as_ref().and_then(|c| c.root(Kind::Points)) {
            Some(root) => &root.topology,
            None => self.mesh.quads(),
        }
    }
    /// Whether the quads are those of the first step; a level of the cage is then one less of the quads.
    #[must_use]
    pub fn is_split(&self) -> bool {
        !self.triangles && !self.mesh.base.all_quads()
    }
    /// Face of the cage that quad `q` belongs to.
    #[must_use]
    pub fn cage_face(&self, q: u32) -> u32 {
        if self.is_split() {
            self.mesh.base.face_of(q)
        } else {
            q
        }
    }
    /// The cage's polygons, in blocks.
    pub(crate) fn polygon_blocks(&self) -> &PolygonBlocks {
        if self.polygons.get().is_none() {
            // Not inside of `get_or_init`: a thread that helps out while it waits may come here again.
            let made = PolygonBlocks::new(&self.cage, &self.mesh.base, |_| MOST_CELLS);
            let _ = self.polygons.set(made);
        }
        self.polygons.get_or_init(PolygonBlocks::default)
    }
    /// Whether the cage has texture coordinates.
    #[must_use]
    pub fn has_uvs(&self) -> bool {
        !self.cage.corner_uvs.is_empty()
    }
    /// Points of the cage, as they are now.
    #[must_use]
    pub fn control_base(&self) -> &[[f32; 3]] {
        &self.cage.points
    }
    /// Points of the quad mesh, by vertex.
    #[must_use]
    pub fn control_points(&self) -> &[[f32; 3]] {
        if let Some(mesh) = self.table_root() {
            return &mesh.points;
        }
        match self.control.as_ref().and_then(|c| c.root(Kind::Points)) {
            Some(root) => &root.points,
            None => &self.mesh.points,
        }
    }
    fn table_root(&self) -> Option<&crate::dice::table::TableMesh> {
        self.tables.as_ref()?.root(Kind::Points)
    }
    /// Bytes and number of the tables by which an interpolating surface is diced at `level` of its faces, and by how many steps the whole
    /// mesh is refined first. `None` for other surfaces.
    #[must_use]
    pub fn table_bytes(&self, level: u32) -> Option<(usize, usize, u32)> {
        self.ensure(level);
        self.tables.as_ref()?.table_bytes(level)
    }
    /// [`Surface::quads`] as they hang together, infinite creases not cut open. Faces and half-edges have the same numbers.
    pub(crate) fn whole_quads(&self) -> &Topology {
        if let Some(tables) = &self.tables {
            return tables.whole();
        }
        match &self.control {
            Some(control) => control.whole(),
            None => self.mesh.quads(),
        }
    }

    /// Whether faces are diced by tables, which are made for one level at a time.
    pub(crate) fn has_tables(&self) -> bool {
        self.tables.is_some()
    }

    /// Whether the inside of a face evaluates its rim as well, normals included, if not to the bits of its sides: where nothing but splines is
    /// drawn.
    pub(crate) fn has_rims_inside(&self) -> bool {
        !self.has_tables() && self.patches.is_none() && self.displacement().is_none()
    }

    /// At which corners of face `q` the surface is no spline. Features are not looked for; interpolating surfaces, which are splines nowhere,
    /// have none that stand out.
    pub(crate) fn irregular_corners(&self, q: u32) -> [bool; 4] {
        if self.has_tables() || self.patches.is_some() || self.linear {
            return [false; 4];
        }
        let t = self.quads();
        let mut out = [false; 4];
        for (out, h) in out.iter_mut().zip(t.face_halves(q)) {
            let fan = &t.fans()[t.fan(h) as usize];
            *out = match self.triangles {
                true => !is_regular_triangle_fan(fan),
                false => !fan.is_regular(),
            };
        }
        out
    }

    /// By how many steps the whole mesh is refined before tables of `level` are applied, once those are made.
    pub(crate) fn table_depth(&self, level: u32) -> Option<u32> {
        Some(self.tables.as_ref()?.table_bytes(level)?.2)
    }

    /// The ears of the quads, in the layout of the published buffers.
    #[must_use]
    pub fn ears(&self) -> Ears {
        Ears::new(self.quads())
    }
    /// Whether texture coordinates are bilinear in each quad.
    pub(crate) fn has_linear_uvs(&self) -> bool {
        self.linear_uv
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet() -> Surface {
        let corners: Vec<u32> = (0..9)
            .flat_map(|q| [0, 1, 5, 4].map(|k| q / 3 * 4 + q % 3 + k))
            .collect();
        let points = (0..16)
            .map(|k| [(k % 4) as f32, (k / 4) as f32, 0.0])
            .collect();
        // Texture turned by a quarter: u grows along y, v against x.
        let uvs = (0..16)
            .map(|k| [(k / 4) as f32, -((k % 4) as f32)])
            .collect();
        let cage = Cage::new(points, &[4; 9], corners.clone())
            .and_then(|c| c.with_uvs(uvs, corners))
            .unwrap();
        Surface::new(cage, &SurfaceOptions::default())
    }

    #[test]
    fn tangents_follow_the_texture() {
        for [t, b] in sheet().dice(4, 2).tangents() {
            let close = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5);
            assert!(
                close(t, [0.0, 1.0, 0.0]) && close(b, [-1.0, 0.0, 0.0]),
                "{t:?} {b:?}"
            );
        }
    }

    #[test]
    fn level_three_has_144_strip_vertices() {
        let strips = sheet().dice(4, 3).strips();
        assert_eq!(strips.len(), 8);
        assert_eq!(strips.iter().map(Vec::len).sum::<usize>(), 144);
        // Every micro-quad once: consecutive triples of a strip are its two triangles.
        assert!(strips.iter().flatten().all(|&k| k < 81));
    }

    #[test]
    fn moved_points_leave_nothing_of_the_old_ones() {
        let mut moved = sheet();
        let points: Vec<[f32; 3]> = (0..16)
            .map(|k| [(k % 4) as f32, (k / 4) as f32, (k * k % 7) as f32])
            .collect();
        moved.update_points(&points).unwrap();
        let corners: Vec<u32> = moved.cage().corner_vertices().to_vec();
        let fresh = Surface::new(
            Cage::new(points, &[4; 9], corners).unwrap(),
            &SurfaceOptions::default(),
        );
        for q in 0..9 {
            let (a, b) = (moved.dice(q, 3), fresh.dice(q, 3));
            assert_eq!((a.points, a.normals), (b.points, b.normals));
        }
    }
}
