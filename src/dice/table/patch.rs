//! A face of an interpolating surface, diced by the tables of the faces it is made of.

use super::super::face::{DiceFault, FacePatch, Part, Sides};
use super::super::regular::{LINE, Line, unit_cross};
use super::{Controls, Place, Rows, Table, weigh};
use crate::dispatch;
use crate::math;
use crate::records::Grid3;
use crate::simd::Level;
use crate::topology::{NONE, Topology};
use std::sync::Arc;

/// One channel of the mesh that tables are applied to: some levels below the faces that are drawn.
#[derive(Clone, Debug, Default)]
pub(crate) struct TableMesh {
    /// Cut open along infinite creases and seams.
    pub(crate) topology: Topology,
    pub(crate) points: Vec<[f32; 3]>,
    /// Normals of the corners, as indices into `normals`; both empty for channels without.
    pub(crate) corner_normals: Vec<u32>,
    pub(crate) normals: Vec<[f32; 3]>,
    /// The half-edge that every half-edge's side is diced by; empty where every face dices its own sides.
    pub(crate) owners: Vec<u32>,
}

/// The vertices around every face, and which surroundings look alike.
#[derive(Clone, Debug, Default)]
pub(crate) struct TableShapes {
    /// Table of every face.
    pub(crate) tables: Vec<u32>,
    /// Where the vertices of every face begin.
    pub(crate) starts: Vec<u32>,
    /// Vertices around the faces, in the order of their tables.
    pub(crate) vertices: Vec<u32>,
}

/// All that dicing one channel at one level needs.
#[derive(Clone, Debug)]
pub(crate) struct TableChannel {
    pub(crate) mesh: Arc<TableMesh>,
    pub(crate) shapes: Arc<TableShapes>,
    /// Empty where faces have no points but corners.
    pub(crate) tables: Arc<Vec<Arc<Table>>>,
    /// Levels from the faces that are drawn to those of the mesh.
    pub(crate) depth: u32,
    /// Levels of the tables.
    pub(crate) steps: u32,
    /// The latter by their places in the former; see [`super::cells`].
    pub(crate) cells: Arc<Vec<[u32; 2]>>,
    pub(crate) triangular: bool,
}

/// A face prepared for dicing.
#[derive(Clone, Debug)]
pub(crate) struct TablePatch {
    pub(super) channel: Option<Arc<TableChannel>>,
    pub(super) face: u32,
    pub(super) level: u32,
    pub(super) wanted: Sides,
    pub(crate) fault: DiceFault,
    /// Vector instructions; never changes a bit.
    pub(crate) simd: Level,
}

impl Default for TablePatch {
    fn default() -> Self {
        Self {
            channel: None,
            face: 0,
            level: 0,
            wanted: Sides::Hull,
            fault: DiceFault::None,
            simd: Level::SCALAR,
        }
    }
}

/// Buffers for one face of the mesh.
#[derive(Default)]
pub(super) struct Scratch {
    pub(super) controls: Controls,
    pub(super) points: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
}

/// The part of a block that a face of the mesh fills.
#[derive(Clone, Copy)]
struct Small {
    /// Number in the mesh.
    face: u32,
    place: Place,
    /// Segments along its sides.
    n: i32,
}

impl TablePatch {
    /// Prepares face `face` at `level`, which is that of `channel`.
    pub(crate) fn prepare(
        &mut self,
        channel: Arc<TableChannel>,
        face: u32,
        level: u32,
        sides: Sides,
    ) {
        self.channel = Some(channel);
        self.face = face;
        self.level = level;
        self.wanted = sides;
    }

    /// Whether its faces are triangles.
    pub(crate) fn is_triangular(&self) -> bool {
        self.channel.as_deref().is_some_and(|c| c.triangular)
    }

    /// Dices block (`bu`, `bv`), of the size that [`FacePatch::block_size`] says.
    pub(crate) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.dice_part(Part::block(self.level, [bu, bv]), points, normals);
    }

    /// Dices a part of the face, which may be of a coarser level and has an area. It is one point, or at least as large as a face of the
    /// mesh. Points have the bits that every other part gives them.
    pub(crate) fn dice_part(
        &self,
        part: Part,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let Some(channel) = self.channel.as_deref() else {
            return;
        };
        let m = part.segments;
        if m == 0 || part.level < channel.depth {
            let each = (0..=m).flat_map(|j| (0..=m).map(move |i| [i, j]));
            for [i, j] in
                each.filter(|[i, j]| !channel.triangular || part.start[1] + j <= part.start[0] + i)
            {
                let at = [part.start[0] + i, part.start[1] + j];
                let (point, normal) = self.point(channel, part.level, at);
                points.set(i as usize, j as usize, point);
                if let Some(normals) = normals.as_deref_mut() {
                    normals.set(i as usize, j as usize, normal);
                }
            }
        } else {
            self.dice_faces(channel, part, points, normals.as_deref_mut());
        }
        if channel.triangular && part.start[0] == part.start[1] {
            fold(points, m as usize);
            if let Some(normals) = normals {
                fold(normals, m as usize);
            }
        }
    }

    /// Dices the faces of the mesh in a part.
    fn dice_faces(
        &self,
        channel: &TableChannel,
        part: Part,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let n = 1_u32 << (part.level - channel.depth);
        let per_block = part.segments / n;
        let [u, v] = part.start.map(|k| k / n);
        let mut scratch = Scratch::default();
        for j in 0..per_block {
            for i in 0..per_block {
                for (face, upper) in channel.cell(self.face, [u + i, v + j]) {
                    let small = Small {
                        face,
                        place: Place {
                            origin: [i, j].map(|c| c as i32 + i32::from(upper)),
                            turn: if upper { -1 } else { 1 },
                        },
                        n: n as i32,
                    };
                    self.dice_face(channel, small, &mut scratch, points, normals.as_deref_mut());
                }
            }
        }
    }

    fn dice_face(
        &self,
        channel: &TableChannel,
        small: Small,
        scratch: &mut Scratch,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let mesh = &*channel.mesh;
        let n = small.n;
        let corners = channel.corners(n);
        for (h, &[i, j]) in mesh.topology.face_halves(small.face).zip(&corners) {
            let at = small.place.at(n, i, j).map(|c| c as usize);
            points.set(at[0], at[1], mesh.points[mesh.topology.vertex(h) as usize]);
            if let Some(normals) = normals.as_deref_mut() {
                normals.set(at[0], at[1], mesh.normal(h));
            }
        }
        if n == 1 {
            return;
        }
        let steps = n.ilog2();
        let with_normals = self.wanted == Sides::Normals;
        let mut put = |k: usize, at: [i32; 2], scratch: &Scratch| {
            let [i, j] = small.place.at(n, at[0], at[1]).map(|c| c as usize);
            points.set(i, j, scratch.points[k]);
            if let (Some(normals), Some(&p)) = (normals.as_deref_mut(), scratch.normals.get(k)) {
                normals.set(i, j, p);
            }
        };
        channel.gather(small.face, &mut scratch.controls);
        let spare = channel.spare(small.face);
        let rows = &channel.table(small.face, steps).inside;
        channel.evaluate(self.simd, rows, small.face, spare, with_normals, scratch);
        let mut k = 0;
        for j in 1..n {
            // Row j of a triangle begins beyond the diagonal.
            let low = if channel.triangular { j + 1 } else { 1 };
            for i in low..n {
                put(k, [i, j], scratch);
                k += 1;
            }
        }
        for c in 0..channel.sides() {
            self.dice_side(channel, small.face, c, steps, scratch);
            for k in 0..scratch.points.len() {
                let at = between(
                    corners[c],
                    corners[(c + 1) % channel.sides()],
                    k as i32 + 1,
                    n,
                );
                put(k, at, scratch);
            }
        }
    }

    /// The corners of the box of all points of the face.
    pub(crate) fn hull(&self, out: impl FnMut([f32; 3])) {
        let blocks = FacePatch::blocks_per_side(self.level);
        let all = (0..blocks).flat_map(|bv| (0..blocks).map(move |bu| [bu, bv]));
        self.boxed(all.map(|b| Part::block(self.level, b)), out);
    }

    /// The same for one block.
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.part_hull(Part::block(self.level, [bu, bv]), out);
    }

    /// The same for a part.
    pub(crate) fn part_hull(&self, part: Part, out: impl FnMut([f32; 3])) {
        self.boxed(std::iter::once(part), out);
    }

    /// Interpolating surfaces leave the hull of their control points: only the points themselves tell where they are.
    fn boxed(&self, parts: impl Iterator<Item = Part>, out: impl FnMut([f32; 3])) {
        let triangular = self.is_triangular();
        let mut grid = Grid3::boxed();
        let patch = Self {
            // A hull holds what is drawn, sides included.
            wanted: Sides::Points,
            ..self.clone()
        };
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for part in parts.filter(|p| !triangular || p.start[1] <= p.start[0]) {
            patch.dice_part(part, &mut grid, None);
            let m = part.segments as usize;
            for j in 0..=m {
                for i in 0..=m {
                    let p = grid.get(i, j);
                    low = [0, 1, 2].map(|k| low[k].min(p[k]));
                    high = [0, 1, 2].map(|k| high[k].max(p[k]));
                }
            }
        }
        math::box_corners(low, high).for_each(out);
    }
}

/// Grid point `k` of `n` from corner `a` to corner `b`.
pub(super) fn between(a: [i32; 2], b: [i32; 2], k: i32, n: i32) -> [i32; 2] {
    [0, 1].map(|c| a[c] + (b[c] - a[c]) / n * k)
}

/// Repeats the diagonal above it.
fn fold(grid: &mut Grid3, m: usize) {
    for j in 1..=m {
        let p = grid.get(j, j);
        (0..j).for_each(|i| grid.set(i, j, p));
    }
}

/// Points, and unit normals if wanted, of `rows`.
#[inline(always)]
fn evaluate(
    rows: &Rows,
    controls: &Controls,
    base: [f32; 3],
    spare: [f32; 3],
    with_normals: bool,
    points: &mut Vec<[f32; 3]>,
    normals: &mut Vec<[f32; 3]>,
) {
    points.clear();
    normals.clear();
    let zero: [Line; 3] = [[0.0; LINE]; 3];
    let (mut a, mut b, mut unit) = (zero, zero, zero);
    let size = controls.0[0].len();
    for (_, count, at, lanes) in rows.lines(size) {
        let weights = |layer: usize| &rows.layers[layer][at..at + size * lanes];
        weigh(weights(0), lanes, controls, &mut a);
        points.extend((0..count).map(|i| [0, 1, 2].map(|k| base[k] + a[k][i])));
        if with_normals {
            weigh(weights(1), lanes, controls, &mut a);
            weigh(weights(2), lanes, controls, &mut b);
            unit_cross(&a, &b, lanes, spare, &mut unit);
            normals.extend((0..count).map(|i| [0, 1, 2].map(|k| unit[k][i])));
        }
    }
}

impl TableMesh {
    /// The normal at corner `h`; zero without.
    pub(crate) fn normal(&self, h: u32) -> [f32; 3] {
        match self.corner_normals.get(h as usize) {
            Some(&n) => self.normals[n as usize],
            None => [0.0; 3],
        }
    }
}

impl TableChannel {
    /// The first face of the mesh that comes from face `face`.
    fn face(&self, face: u32) -> u32 {
        face << (2 * self.depth)
    }

    /// Faces of the mesh in a unit square of the grid of face `face`, and whether each is the one on the side of (i, j + 1).
    pub(super) fn cell(
        &self,
        face: u32,
        [i, j]: [u32; 2],
    ) -> impl Iterator<Item = (u32, bool)> + use<> {
        let first = self.face(face);
        let found = self.cells[((j << self.depth) + i) as usize];
        let all = found.into_iter().zip([false, true]);
        all.filter(|f| f.0 != NONE)
            .map(move |(f, upper)| (first + f, upper))
    }

    /// Number of sides of a face.
    pub(super) fn sides(&self) -> usize {
        if self.triangular { 3 } else { 4 }
    }

    /// Corners of a face of `n` segments a side; a triangle repeats its first.
    pub(super) fn corners(&self, n: i32) -> [[i32; 2]; 4] {
        match self.triangular {
            true => [[0, 0], [n, 0], [n, n], [0, 0]],
            false => [[0, 0], [n, 0], [n, n], [0, n]],
        }
    }

    /// The table of face `face` for `2^steps` segments a side.
    pub(super) fn table(&self, face: u32, steps: u32) -> &Table {
        let table = &self.tables[self.shapes.tables[face as usize] as usize];
        table.coarser(self.steps, self.steps - steps)
    }

    /// The normal of face `face` where tangents are parallel.
    pub(super) fn spare(&self, face: u32) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for h in self.mesh.topology.face_halves(face) {
            let normal = self.mesh.normal(h);
            sum = [0, 1, 2].map(|k| sum[k] + normal[k]);
        }
        let unit = super::super::point::P4::new(sum).unit();
        unit.map_or([0.0, 0.0, 1.0], |p| p.xyz())
    }

    /// Leaves points of face `face`, and unit normals if wanted, in `scratch`, which holds its control points.
    pub(super) fn evaluate(
        &self,
        simd: Level,
        rows: &Rows,
        face: u32,
        spare: [f32; 3],
        with_normals: bool,
        scratch: &mut Scratch,
    ) {
        let Scratch {
            controls,
            points,
            normals,
        } = scratch;
        let base = self.base(face);
        dispatch!(
            simd,
            evaluate(rows, controls, base, spare, with_normals, points, normals)
        );
    }

    pub(super) fn base(&self, face: u32) -> [f32; 3] {
        let first = self.mesh.topology.face_halves(face).start;
        self.mesh.points[self.mesh.topology.vertex(first) as usize]
    }

    pub(super) fn gather(&self, face: u32, out: &mut Controls) {
        let start = self.shapes.starts[face as usize];
        let points = self.table(face, self.steps).controls.iter().map(|c| {
            let vertex = self.shapes.vertices[(start + c) as usize];
            self.mesh.points[vertex as usize]
        });
        out.gather(self.base(face), points);
    }
}
