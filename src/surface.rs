//! The subdivision surface of a cage: topology once, points as often as they move.

use crate::dice::face::{Channel, FacePatch, Sides};
use crate::dice::fan_points::{FanPoints, TangentMasks};
use crate::dice::presplit::presplit;
use crate::dice::{DiceFault, MAX_LEVEL, Target};
use crate::math;
use crate::mesh::{Cage, NONE};
use crate::records::Grid3;
use crate::scheme::{Boundary, FaceVaryingRule};
use crate::simd::Level;
use crate::topology::channel::connect_channel;
use crate::topology::ears::Ears;
use crate::topology::split::{Split, split};
use crate::topology::{ConnectOptions, Topology, TopologyWarning, connect};

/// How a cage is read as a surface. What is `None` comes from the cage's tags, else from the defaults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceOptions {
    /// Boundary rule; default edge-and-corner.
    pub boundary: Option<Boundary>,
    /// Face-varying rule; default corners-plus1.
    pub face_varying: Option<FaceVaryingRule>,
}

/// One polygon mesh as quads: itself, or its first Catmull-Clark step.
#[derive(Clone, Debug)]
struct QuadMesh {
    base: Topology,
    split: Option<Split>,
    masks: TangentMasks,
    /// Points of the quads, by vertex.
    points: Vec<[f32; 3]>,
    fans: FanPoints,
}

impl QuadMesh {
    fn new(base: Topology, points: &[[f32; 3]], normals: bool) -> Self {
        let split = (!base.all_quads()).then(|| split(&base));
        let masks = TangentMasks::new(split.as_ref().map_or(&base, |s| &s.topology));
        let mut mesh = Self {
            base,
            split,
            masks,
            points: Vec::new(),
            fans: FanPoints::default(),
        };
        mesh.update(points, normals);
        mesh
    }

    fn quads(&self) -> &Topology {
        self.split.as_ref().map_or(&self.base, |s| &s.topology)
    }

    fn update(&mut self, points: &[[f32; 3]], normals: bool) {
        self.points = match &self.split {
            Some(split) => presplit(&self.base, split, points),
            None => points.to_vec(),
        };
        self.fans = FanPoints::new(self.quads(), &self.masks, &self.points, None, normals);
    }
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
    mesh: QuadMesh,
    uv: Option<QuadMesh>,
    linear_uv: bool,
    colors: Option<VertexChannel>,
    warnings: Vec<TopologyWarning>,
}

/// Points of one quad of the surface's quad mesh on a grid, row by row: `side` points along u, then the next v.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DicedQuad {
    /// Points along each side.
    pub side: usize,
    /// Limit points, or control points of the level.
    pub points: Vec<[f32; 3]>,
    /// Unit limit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; empty without.
    pub uvs: Vec<[f32; 2]>,
}

impl DicedQuad {
    /// Tangent and bitangent at every point, row by row: unit vectors in the tangent plane along which the texture's u and v grow (along
    /// the grid's u and v where there are no texture coordinates). From central differences of the grid, made normal to the limit
    /// normal; so they suit normal maps, and are not exact like the normals are. Mirrored texture shows as a left-handed pair.
    #[must_use]
    pub fn tangents(&self) -> Vec<[[f32; 3]; 2]> {
        let n = self.side;
        let step = |k: usize| (k.saturating_sub(1), (k + 1).min(n - 1));
        let mut out = Vec::with_capacity(n * n);
        for j in 0..n {
            for i in 0..n {
                let ((i0, i1), (j0, j1)) = (step(i), step(j));
                let (west, east, south, north) = (j * n + i0, j * n + i1, j0 * n + i, j1 * n + i);
                let along = math::sub(self.points[east], self.points[west]);
                let across = math::sub(self.points[north], self.points[south]);
                let [a, b, c, d] = match self.uvs.is_empty() {
                    true => [1.0, 0.0, 0.0, 1.0],
                    false => {
                        let uv = |k: usize| self.uvs[k];
                        [
                            uv(east)[0] - uv(west)[0],
                            uv(north)[0] - uv(south)[0],
                            uv(east)[1] - uv(west)[1],
                            uv(north)[1] - uv(south)[1],
                        ]
                    }
                };
                // (along, across) = (T, B) · [[a, b], [c, d]]; only directions matter, so the determinant enters by its sign.
                let sign = if a * d - b * c < 0.0 { -1.0 } else { 1.0 };
                let mix = |p: f32, q: f32| [0, 1, 2].map(|k| (along[k] * p + across[k] * q) * sign);
                let normal = self.normals[j * n + i];
                let flat = |v: [f32; 3], spare: [f32; 3]| {
                    let h = math::dot(v, normal);
                    math::normalize([0, 1, 2].map(|k| v[k] - normal[k] * h)).unwrap_or(spare)
                };
                let tangent = flat(mix(d, -c), flat(along, [1.0, 0.0, 0.0]));
                out.push([tangent, flat(mix(-b, a), math::cross(normal, tangent))]);
            }
        }
        out
    }

    /// Antal's triangle strips: one per row of micro-quads, each alternating between the row's upper and lower points, from column
    /// 0 on. Indices into the grid. At level 3 these are 8 strips of 18, 144 vertices in all.
    #[must_use]
    pub fn strips(&self) -> Vec<Vec<u32>> {
        let n = self.side as u32;
        (0..n - 1)
            .map(|j| (0..n).flat_map(|i| [(j + 1) * n + i, j * n + i]).collect())
            .collect()
    }
}

impl Surface {
    /// The surface of `cage`. Cannot fail: whatever the cage is, it has a surface; what had to be decided on the way is in
    /// [`Surface::warnings`].
    #[must_use]
    pub fn new(cage: Cage, options: &SurfaceOptions) -> Self {
        let boundary = options.boundary.or(cage.tags.boundary).unwrap_or_default();
        let connect_options = ConnectOptions {
            boundary,
            creases: &cage.tags.creases,
            corners: &[],
            holes: &cage.tags.holes,
        };
        let (base, warnings) = connect(
            cage.points.len(),
            &cage.face_offsets,
            cage.corner_vertices.clone(),
            &connect_options,
        );
        let rule = options
            .face_varying
            .or(cage.tags.face_varying)
            .unwrap_or_default();
        let uv = (!cage.corner_uvs.is_empty()).then(|| {
            // Corners without a value share one more, at the origin.
            let missing = cage.uvs.len() as u32;
            let values: Vec<u32> = cage
                .corner_uvs
                .iter()
                .map(|&i| if i == NONE { missing } else { i })
                .collect();
            let topology = connect_channel(&base, values, cage.uvs.len() + 1, rule, boundary);
            QuadMesh::new(topology, &uv_points(&cage), false)
        });
        let mesh = QuadMesh::new(base, &cage.points, true);
        let colors = (!cage.colors.is_empty()).then(|| {
            let points = match &mesh.split {
                Some(split) => presplit(&mesh.base, split, &cage.colors),
                None => cage.colors.clone(),
            };
            let fans = FanPoints::new(mesh.quads(), &mesh.masks, &points, None, false);
            VertexChannel { points, fans }
        });
        Self {
            colors,
            mesh,
            uv,
            linear_uv: rule == FaceVaryingRule::All,
            warnings,
            cage,
        }
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
        self.mesh.update(points, true);
        Ok(())
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
        self.mesh.quads()
    }
    /// Whether the quads are those of the first step; a level of the cage is then one less of the quads.
    #[must_use]
    pub fn is_split(&self) -> bool {
        self.mesh.split.is_some()
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
    /// Whether the cage has texture coordinates.
    #[must_use]
    pub fn has_uvs(&self) -> bool {
        self.uv.is_some()
    }
    /// Points of the cage, as they are now.
    #[must_use]
    pub fn control_base(&self) -> &[[f32; 3]] {
        &self.cage.points
    }
    /// Points of the quad mesh, by vertex.
    #[must_use]
    pub fn control_points(&self) -> &[[f32; 3]] {
        &self.mesh.points
    }
    /// The ears of the quads, in the layout of the published buffers.
    #[must_use]
    pub fn ears(&self) -> Ears {
        Ears::new(self.quads())
    }
    /// Limit points and unit normals at the vertices of fan `fan` of the quad mesh.
    #[must_use]
    pub fn fan_limit(&self, fan: u32) -> ([f32; 3], [f32; 3]) {
        (
            self.mesh.fans.limits[fan as usize],
            self.mesh.fans.normals[fan as usize],
        )
    }

    /// Dices quad `q` of [`Surface::quads`] on a grid of `2^level + 1` points along each side.
    ///
    /// # Panics
    /// When there is no such quad or `level` is above 10.
    #[must_use]
    pub fn dice(&self, q: u32, level: u32) -> DicedQuad {
        self.dice_with(q, level, DiceFault::None)
    }

    /// Every quad's control points after `level` steps, with the normals of the limit.
    ///
    /// # Panics
    /// As [`Surface::dice`].
    pub fn refine_quads(&self, level: u32) -> impl Iterator<Item = DicedQuad> + '_ {
        assert!(level <= MAX_LEVEL, "level {level} is above {MAX_LEVEL}");
        let fans = self.refined_fans(level);
        (0..self.quads().face_count() as u32)
            .map(move |q| self.dice_quad(q, level, DiceFault::None, Some(&fans)))
    }

    /// [`Surface::dice`] with a rule broken, for tests.
    #[doc(hidden)]
    #[must_use]
    pub fn dice_with(&self, q: u32, level: u32, fault: DiceFault) -> DicedQuad {
        self.dice_quad(q, level, fault, None)
    }

    fn dice_quad(
        &self,
        q: u32,
        level: u32,
        fault: DiceFault,
        refined: Option<&FanPoints>,
    ) -> DicedQuad {
        assert!(level <= MAX_LEVEL, "level {level} is above {MAX_LEVEL}");
        let mut patch = QuadPatch::default();
        patch.points.fault = fault;
        patch.set_simd(Level::detect());
        patch.prepare(self, q, level, refined);
        let side = (1_usize << level) + 1;
        let mut out = DicedQuad {
            side,
            ..DicedQuad::default()
        };
        out.points.resize(side * side, [0.0; 3]);
        out.normals.resize(side * side, [0.0; 3]);
        let (mut points, mut normals) = (Grid3::boxed(), Grid3::boxed());
        let mut uvs = self.uv.is_some().then(|| {
            out.uvs.resize(side * side, [0.0; 2]);
            Grid3::boxed()
        });
        let blocks = FacePatch::blocks_per_side(level);
        let m = FacePatch::block_size(level).cols - 1;
        for bv in 0..blocks {
            for bu in 0..blocks {
                patch.dice(bu, bv, &mut points, Some(&mut normals));
                if let Some(uvs) = uvs.as_deref_mut() {
                    patch.dice_uvs(bu, bv, uvs);
                }
                for j in 0..=m {
                    for i in 0..=m {
                        let k = (bv as usize * m + j) * side + bu as usize * m + i;
                        out.points[k] = points.get(i, j);
                        out.normals[k] = normals.get(i, j);
                        if let Some(uvs) = &uvs {
                            let [u, v, _] = uvs.get(i, j);
                            out.uvs[k] = [u, v];
                        }
                    }
                }
            }
        }
        out
    }

    /// Limit of the texture coordinates at corner `h` of the quad mesh.
    pub(crate) fn uv_limit(&self, h: u32) -> Option<[f32; 3]> {
        let uv = self.uv.as_ref()?;
        Some(uv.fans.limits[uv.quads().fan(h) as usize])
    }

    /// Limit of the vertex colours at corner `h` of the quad mesh.
    pub(crate) fn color_limit(&self, h: u32) -> Option<[f32; 3]> {
        let colors = self.colors.as_ref()?;
        Some(colors.fans.limits[self.quads().fan(h) as usize])
    }

    /// Fans for another target than the limit: control points after `level` steps of the quad mesh.
    pub(crate) fn refined_fans(&self, level: u32) -> FanPoints {
        FanPoints::new(
            self.quads(),
            &self.mesh.masks,
            &self.mesh.points,
            Some(level),
            true,
        )
    }
}

fn uv_points(cage: &Cage) -> Vec<[f32; 3]> {
    cage.uvs
        .iter()
        .map(|&[u, v]| [u, v, 0.0])
        .chain([[0.0; 3]])
        .collect()
}

/// A quad of a surface prepared for dicing: its points and its texture coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadPatch {
    points: FacePatch,
    uvs: FacePatch,
    colors: FacePatch,
    uv_ready: bool,
    color_ready: bool,
    linear: Option<[[f32; 3]; 4]>,
    level: u32,
}

impl QuadPatch {
    /// Chooses the vector instructions; never changes a bit.
    pub(crate) fn set_simd(&mut self, simd: Level) {
        self.points.simd = simd;
        self.uvs.simd = simd;
        self.colors.simd = simd;
    }

    /// Prepares quad `q`. `refined` holds the fans of [`Surface::refined_fans`] if control points are wanted.
    pub(crate) fn prepare(
        &mut self,
        surface: &Surface,
        q: u32,
        level: u32,
        refined: Option<&FanPoints>,
    ) {
        self.prepare_points(surface, q, level, refined, Sides::Normals);
        self.prepare_uvs(surface, q);
    }

    /// Only the points; without `sides` enough for a hull.
    pub(crate) fn prepare_points(
        &mut self,
        surface: &Surface,
        q: u32,
        level: u32,
        refined: Option<&FanPoints>,
        sides: Sides,
    ) {
        self.level = level;
        self.uv_ready = false;
        self.color_ready = false;
        let mesh = &surface.mesh;
        let channel = Channel {
            topology: mesh.quads(),
            points: &mesh.points,
            fans: refined.unwrap_or(&mesh.fans),
        };
        let target = if refined.is_some() {
            Target::Refined
        } else {
            Target::Limit
        };
        self.points.prepare(channel, q, target, level, sides);
    }

    pub(crate) fn prepare_uvs(&mut self, surface: &Surface, q: u32) {
        let Some(uv) = &surface.uv else { return };
        self.uv_ready = true;
        self.linear = None;
        if surface.linear_uv {
            let quads = uv.quads();
            let corner = |c: u32| uv.points[quads.vertex(4 * q + c) as usize];
            self.linear = Some([corner(0), corner(1), corner(2), corner(3)]);
            return;
        }
        let channel = Channel {
            topology: uv.quads(),
            points: &uv.points,
            fans: &uv.fans,
        };
        self.uvs
            .prepare(channel, q, Target::Limit, self.level, Sides::None);
    }

    pub(crate) fn has_uvs(&self) -> bool {
        self.uv_ready
    }

    /// Prepares the vertex colours of quad `q`; says whether there are any.
    pub(crate) fn prepare_colors(&mut self, surface: &Surface, q: u32) -> bool {
        if let (Some(colors), false) = (&surface.colors, self.color_ready) {
            let channel = Channel {
                topology: surface.quads(),
                points: &colors.points,
                fans: &colors.fans,
            };
            self.colors
                .prepare(channel, q, Target::Limit, self.level, Sides::None);
            self.color_ready = true;
        }
        self.color_ready
    }

    pub(crate) fn dice_colors(&self, bu: u32, bv: u32, out: &mut Grid3) {
        self.colors.dice(bu, bv, out, None);
    }

    pub(crate) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.points.dice(bu, bv, points, normals);
    }

    pub(crate) fn dice_uvs(&self, bu: u32, bv: u32, out: &mut Grid3) {
        let Some(c) = self.linear else {
            self.uvs.dice(bu, bv, out, None);
            return;
        };
        let size = FacePatch::block_size(self.level);
        let scale = 1.0 / (1_u32 << self.level) as f32;
        for j in 0..size.rows {
            let t = (bv as usize * (size.rows - 1) + j) as f32 * scale;
            for i in 0..size.cols {
                let s = (bu as usize * (size.cols - 1) + i) as f32 * scale;
                let at = |k: usize| {
                    (c[0][k] * (1.0 - s) + c[1][k] * s) * (1.0 - t)
                        + (c[3][k] * (1.0 - s) + c[2][k] * s) * t
                };
                out.set(i, j, [at(0), at(1), 0.0]);
            }
        }
    }

    pub(crate) fn hull(&self, out: impl FnMut([f32; 3])) {
        self.points.hull(out);
    }
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.points.block_hull(bu, bv, out);
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
