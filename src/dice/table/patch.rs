//! A face of an interpolating surface, diced by the tables of the faces it is made of.

use super::super::face::{DiceFault, FacePatch, Sides};
use super::super::regular::{LINE, Line, unit_cross};
use super::{Controls, Place, Rows, Table, weigh};
use crate::dispatch;
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
    /// The latter by their places in the former; see [`super::cells`].
    pub(crate) cells: Arc<Vec<[u32; 2]>>,
    pub(crate) triangular: bool,
}

/// A face prepared for dicing.
#[derive(Clone, Debug)]
pub(crate) struct TablePatch {
    channel: Option<Arc<TableChannel>>,
    face: u32,
    level: u32,
    wanted: Sides,
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
struct Scratch {
    own: Controls,
    other: Controls,
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

/// The part of a block that a face of the mesh fills.
#[derive(Clone, Copy)]
struct Part {
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
    pub(crate) fn dice(
        &self,
        bu: u32,
        bv: u32,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let Some(channel) = self.channel.as_deref() else {
            return;
        };
        let m = 1_u32 << self.level.min(5);
        let n = 1_u32 << (self.level - channel.depth);
        let (per_block, per_side) = (m / n, 1_u32 << channel.depth);
        let first = channel.face(self.face);
        let mut scratch = Scratch::default();
        for j in 0..per_block {
            for i in 0..per_block {
                let cell = (bv * per_block + j) * per_side + bu * per_block + i;
                for (k, face) in channel.cells[cell as usize].into_iter().enumerate() {
                    if face == NONE {
                        continue;
                    }
                    let upper = k == 1;
                    let part = Part {
                        face: first + face,
                        place: Place {
                            origin: [i, j].map(|c| c as i32 + i32::from(upper)),
                            turn: if upper { -1 } else { 1 },
                        },
                        n: n as i32,
                    };
                    self.dice_part(channel, part, &mut scratch, points, normals.as_deref_mut());
                }
            }
        }
        if channel.triangular && bu == bv {
            fold(points, m as usize);
            if let Some(normals) = normals {
                fold(normals, m as usize);
            }
        }
    }

    fn dice_part(
        &self,
        channel: &TableChannel,
        part: Part,
        scratch: &mut Scratch,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let mesh = &*channel.mesh;
        let n = part.n;
        let halves = mesh.topology.face_halves(part.face);
        let corners: [[i32; 2]; 4] = match channel.triangular {
            true => [[0, 0], [n, 0], [n, n], [0, 0]],
            false => [[0, 0], [n, 0], [n, n], [0, n]],
        };
        let mut sum = [0.0; 3];
        for (h, &[i, j]) in halves.clone().zip(&corners) {
            let normal = mesh.normal(h);
            sum = [0, 1, 2].map(|k| sum[k] + normal[k]);
            let at = part.place.at(n, i, j).map(|c| c as usize);
            points.set(at[0], at[1], mesh.points[mesh.topology.vertex(h) as usize]);
            if let Some(normals) = normals.as_deref_mut() {
                normals.set(at[0], at[1], normal);
            }
        }
        if n == 1 {
            return;
        }
        // Where tangents are parallel.
        let spare = super::super::point::P4::new(sum).unit();
        let spare = spare.map_or([0.0, 0.0, 1.0], |p| p.xyz());
        let table = channel.table(part.face);
        channel.gather(part.face, &mut scratch.own);
        let base = channel.base(part.face);
        let mut copy =
            |scratch: &Scratch, at: &mut dyn FnMut(i32) -> [i32; 2], which: [bool; 2]| {
                for (k, p) in scratch.points.iter().enumerate() {
                    let [i, j] = at(k as i32);
                    let at = part.place.at(n, i, j).map(|c| c as usize);
                    if which[0] {
                        points.set(at[0], at[1], *p);
                    }
                    if which[1]
                        && let (Some(normals), Some(p)) =
                            (normals.as_deref_mut(), scratch.normals.get(k))
                    {
                        normals.set(at[0], at[1], *p);
                    }
                }
            };
        let simd = self.simd;
        let with_normals = self.wanted == Sides::Normals;
        let Scratch {
            own,
            points: out,
            normals: tangents,
            ..
        } = scratch;
        dispatch!(
            simd,
            evaluate(&table.inside, own, base, spare, with_normals, out, tangents)
        );
        let (mut i, mut j) = (0, 1);
        let mut inner = |_| {
            // Row j of a triangle begins beyond the diagonal.
            let (low, high) = if channel.triangular {
                (j + 1, n)
            } else {
                (1, n)
            };
            if i == 0 {
                i = low;
            }
            let at = [i, j];
            i += 1;
            if i == high {
                (i, j) = (0, j + 1);
            }
            at
        };
        copy(scratch, &mut inner, [true; 2]);
        for (c, h) in halves.enumerate() {
            let (a, b) = (
                corners[c],
                corners[if channel.triangular {
                    (c + 1) % 3
                } else {
                    (c + 1) % 4
                }],
            );
            let owner = mesh.owners.get(h as usize).copied().unwrap_or(h);
            let foreign =
                owner != h && self.wanted > Sides::None && self.fault != DiceFault::OwnDirection;
            let shared = mesh.topology.twin(h) != NONE;
            let Scratch {
                own,
                points: out,
                normals: tangents,
                ..
            } = scratch;
            // Across a cut points are shared and normals are not.
            if !foreign || !shared {
                let rows = &table.sides[c];
                dispatch!(
                    simd,
                    evaluate(rows, own, base, spare, with_normals, out, tangents)
                );
                let mut along = |k: i32| between(a, b, k + 1, n);
                copy(scratch, &mut along, [true; 2]);
            }
            if foreign {
                let t = &mesh.topology;
                let face = t.face_of(owner);
                let side = (owner - t.face_halves(face).start) as usize;
                let Scratch {
                    other,
                    points: out,
                    normals: tangents,
                    ..
                } = scratch;
                channel.gather(face, other);
                let (base, rows) = (channel.base(face), &channel.table(face).sides[side]);
                let want = with_normals && shared;
                dispatch!(
                    simd,
                    evaluate(rows, other, base, spare, want, out, tangents)
                );
                let reversed = t.vertex(owner) != t.vertex(h);
                let mut along = |k: i32| match reversed {
                    true => between(b, a, k + 1, n),
                    false => between(a, b, k + 1, n),
                };
                copy(scratch, &mut along, [true, shared]);
            }
        }
    }

    /// The corners of the box of all points of the face.
    pub(crate) fn hull(&self, out: impl FnMut([f32; 3])) {
        let blocks = FacePatch::blocks_per_side(self.level);
        let all = (0..blocks).flat_map(|bv| (0..blocks).map(move |bu| [bu, bv]));
        self.boxed(all, out);
    }

    /// The same for one block.
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.boxed(std::iter::once([bu, bv]), out);
    }

    /// Interpolating surfaces leave the hull of their control points: only the points themselves tell where they are.
    fn boxed(&self, blocks: impl Iterator<Item = [u32; 2]>, mut out: impl FnMut([f32; 3])) {
        let triangular = self.is_triangular();
        let mut grid = Grid3::boxed();
        let m = FacePatch::block_size(self.level).cols;
        let patch = Self {
            // A hull holds what is drawn, sides included.
            wanted: Sides::Points,
            ..self.clone()
        };
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for [bu, bv] in blocks.filter(|[bu, bv]| !triangular || bv <= bu) {
            patch.dice(bu, bv, &mut grid, None);
            for j in 0..m {
                for i in 0..m {
                    let p = grid.get(i, j);
                    low = [0, 1, 2].map(|k| low[k].min(p[k]));
                    high = [0, 1, 2].map(|k| high[k].max(p[k]));
                }
            }
        }
        for c in 0..8 {
            out([0, 1, 2].map(|k| if c >> k & 1 == 0 { low[k] } else { high[k] }));
        }
    }
}

/// Grid point `k` of `n` from corner `a` to corner `b`.
fn between(a: [i32; 2], b: [i32; 2], k: i32, n: i32) -> [i32; 2] {
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

    fn table(&self, face: u32) -> &Table {
        &self.tables[self.shapes.tables[face as usize] as usize]
    }

    fn base(&self, face: u32) -> [f32; 3] {
        let first = self.mesh.topology.face_halves(face).start;
        self.mesh.points[self.mesh.topology.vertex(first) as usize]
    }

    fn gather(&self, face: u32, out: &mut Controls) {
        let start = self.shapes.starts[face as usize];
        let points = self.table(face).controls.iter().map(|c| {
            let vertex = self.shapes.vertices[(start + c) as usize];
            self.mesh.points[vertex as usize]
        });
        out.gather(self.base(face), points);
    }
}
