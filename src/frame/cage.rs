//! Polygons of a cage as blocks: up to 256 quads and triangles each, in the order of the faces. Every one has four points of its own in the
//! block's grid, so that corners may have what they like, and the micro-quads between them are not drawn.

use super::scene::{Object, Scene};
use super::source::{Attributes, CORNERS};
use crate::Cage;
use crate::math;
use crate::mesh::{NONE, fan_corners};
use crate::records::{BlockSize, Grid3, SampleId};
use crate::shade::SurfaceMaterial;
use rayon::prelude::*;

/// Most polygons along a side of a block.
const SIDE: usize = 16;

/// Most polygons of a block.
const MOST: u16 = (SIDE * SIDE) as u16;

/// Faces that one thread looks at, at a time.
const CHUNK: usize = 4096;

/// How many times as large as all that is in it, by the squares of diagonals, the box of a block may be. Faces that lie far from each other would
/// have to be looked at wherever one of them is; a square of neighbours is at 1, a row of 32 at 16.
const SPREAD: f32 = 16.0;

/// A block: quads of the cage, and triangles of the fans of its other polygons around their first corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// The first face, and the first triangle of its fan.
    pub(super) face: u32,
    pub(super) fan: u32,
    /// Number of quads and triangles.
    count: u16,
    /// Whether every face is one of them.
    is_plain: bool,
    low: [f32; 3],
    high: [f32; 3],
}

/// A quad, or triangle of a fan.
type Cell = (u32, u32);

/// Number of cells of a face.
fn cells_of(cage: &Cage, face: u32) -> u32 {
    match cage.face(face as usize).len() as u32 {
        4 => 1,
        n => n - 2,
    }
}

/// Vertex and corner number of the four points of a cell; triangles repeat their last one.
fn corners(cage: &Cage, (face, fan): Cell) -> [(u32, u32); 4] {
    let first = cage.face_offsets[face as usize];
    let vertices = cage.face(face as usize);
    fan_corners(vertices.len(), fan).map(|k| (vertices[k as usize], first + k))
}

/// Columns and rows of cells in a grid, of their first corners.
fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..SIDE * SIDE).map(|k| (2 * (k % SIDE), 2 * (k / SIDE)))
}

/// Square of a box's diagonal.
fn diagonal(low: [f32; 3], high: [f32; 3]) -> f32 {
    let d = [0, 1, 2].map(|k| high[k] - low[k]);
    (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]
}

/// The blocks of an object's cage. `apart`: every cell is a block.
pub(super) fn blocks(scene: &Scene, object: &Object, apart: bool) -> Vec<Cells> {
    let faces = object.surface.cage().face_count();
    let chunks = (0..faces.div_ceil(CHUNK)).into_par_iter().map(|k| {
        let mut out = Vec::new();
        let faces = k * CHUNK..((k + 1) * CHUNK).min(faces);
        gather(scene, object, apart, faces, &mut out);
        out
    });
    let parts: Vec<Vec<Cells>> = chunks.collect();
    parts.concat()
}

/// Those of some faces.
fn gather(
    scene: &Scene,
    object: &Object,
    apart: bool,
    faces: std::ops::Range<usize>,
    out: &mut Vec<Cells>,
) {
    let cage = object.surface.cage();
    let (mut open, mut within) = (None::<Cells>, 0.0_f32);
    let (mut material, mut is_clear, mut most) = (None, false, MOST);
    for face in faces.map(|f| f as u32) {
        let own = object.material(face);
        if material != Some(own) {
            out.extend(open.take());
            material = Some(own);
            let found = scene.materials.get(own as usize);
            is_clear = found.is_some_and(SurfaceMaterial::is_clear);
            // A sample keeps few layers of a block with an opacity map.
            let is_cut_out = found.is_some_and(|m| m.opacity_map.is_some());
            most = if apart || is_cut_out { 1 } else { MOST };
        }
        if is_clear || object.surface.topology().is_hole(face) {
            out.extend(open.take());
            continue;
        }
        let cells = cells_of(cage, face);
        for fan in 0..cells {
            let points = corners(cage, (face, fan)).map(|(v, _)| cage.points[v as usize]);
            let (mut low, mut high) = (points[0], points[0]);
            for p in &points[1..] {
                low = [0, 1, 2].map(|k| low[k].min(p[k]));
                high = [0, 1, 2].map(|k| high[k].max(p[k]));
            }
            let size = diagonal(low, high);
            if let Some(block) = &mut open {
                let both = (
                    [0, 1, 2].map(|k| low[k].min(block.low[k])),
                    [0, 1, 2].map(|k| high[k].max(block.high[k])),
                );
                if block.count < most && diagonal(both.0, both.1) <= SPREAD * (within + size) {
                    (block.low, block.high) = both;
                    block.count += 1;
                    block.is_plain &= cells == 1;
                    within += size;
                    continue;
                }
            }
            out.extend(open.take());
            within = size;
            open = Some(Cells {
                face,
                fan,
                count: 1,
                is_plain: cells == 1,
                low,
                high,
            });
        }
    }
    out.extend(open);
}

impl Cells {
    /// Size of the grid.
    pub(super) fn size(&self) -> BlockSize {
        let count = usize::from(self.count);
        BlockSize {
            cols: 2 * count.min(SIDE),
            rows: 2 * count.div_ceil(SIDE),
        }
    }

    fn cells<'a>(&self, cage: &'a Cage) -> impl Iterator<Item = Cell> + use<'a> {
        let mut at = (self.face, self.fan);
        (0..self.count).map(move |_| {
            let cell = at;
            at.1 += 1;
            if at.1 >= cells_of(cage, at.0) {
                at = (at.0 + 1, 0);
            }
            cell
        })
    }

    /// The face that a sample shows.
    pub(super) fn face_at(&self, cage: &Cage, id: SampleId) -> u32 {
        let k = (id.row() / 2) as usize * SIDE + (id.col() / 2) as usize;
        if self.is_plain {
            return self.face + k as u32;
        }
        self.cells(cage).nth(k).map_or(self.face, |cell| cell.0)
    }

    /// Micro-triangles with an area.
    pub(super) fn triangles(&self, cage: &Cage) -> u64 {
        let of = |(face, _): Cell| {
            if cage.face(face as usize).len() == 4 {
                2
            } else {
                1
            }
        };
        self.cells(cage).map(of).sum()
    }

    /// Points whose convex hull holds it.
    pub(super) fn hull(&self, cage: &Cage, out: &mut Vec<[f32; 3]>) {
        if self.count == 1 {
            let points = corners(cage, (self.face, self.fan));
            return out.extend(points.map(|(v, _)| cage.points[v as usize]));
        }
        out.extend(math::box_corners(self.low, self.high));
    }

    /// Lays out points, and what shading needs where asked for.
    pub(super) fn dice(
        &self,
        cage: &Cage,
        points: &mut Grid3,
        mut attributes: Option<&mut Attributes>,
    ) {
        if let Some(a) = attributes.as_deref_mut() {
            a.has_tangents = false;
            a.has_uvs = a.wants_uvs && !cage.corner_uvs.is_empty();
            a.has_colors = !cage.colors.is_empty();
        }
        for ((x, y), cell) in places().zip(self.cells(cage)) {
            let corners = corners(cage, cell).into_iter().zip(CORNERS);
            for ((v, c), (i, j)) in corners {
                let (i, j) = (x + i, y + j);
                points.set(i, j, cage.points[v as usize]);
                if let Some(a) = attributes.as_deref_mut() {
                    a.set_corner((i, j), cage, v, c);
                }
            }
        }
        // What is left of the last row shows nothing.
        let size = self.size();
        let last = usize::from(self.count) % SIDE;
        if size.rows > 2 && last != 0 {
            let p = points.get(2 * last - 1, size.rows - 1);
            for j in [size.rows - 2, size.rows - 1] {
                (2 * last..size.cols).for_each(|i| points.set(i, j, p));
            }
        }
    }
}

impl Attributes {
    fn set_corner(&mut self, (i, j): (usize, usize), cage: &Cage, vertex: u32, corner: u32) {
        let of = |numbers: &[u32]| numbers.get(corner as usize).copied().filter(|&n| n != NONE);
        let normal = of(&cage.corner_normals).map(|n| cage.normals[n as usize]);
        self.normals.set(i, j, normal.unwrap_or_default());
        if self.has_uvs {
            let [u, v] = of(&cage.corner_uvs).map_or([0.0; 2], |n| cage.uvs[n as usize]);
            self.uvs.set(i, j, [u, v, 0.0]);
        }
        if self.has_colors {
            let color = cage.colors.get(vertex as usize).copied();
            self.colors.set(i, j, color.unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Surface, SurfaceOptions};

    fn scene(cage: Cage) -> Scene {
        Scene::of(Surface::new(cage, &SurfaceOptions::default()))
    }

    /// Cells of all blocks.
    fn all(scene: &Scene, blocks: &[Cells]) -> Vec<Cell> {
        let cage = scene.objects[0].surface.cage();
        blocks.iter().flat_map(|b| b.cells(cage)).collect()
    }

    /// A row of quads, every third one `far` beside it.
    fn row(n: u32, far: f32) -> Cage {
        let point = |k: u32| {
            let (i, j) = (k / 2, k % 2);
            let off = if i / 2 % 3 == 2 { far } else { 0.0 };
            [(i / 2 + i % 2) as f32, j as f32 + off, 0.0]
        };
        let mut cage = Cage::builder().points((0..4 * n).map(point));
        for k in 0..n {
            cage = cage.face([4 * k, 4 * k + 2, 4 * k + 3, 4 * k + 1]);
        }
        cage.build().unwrap()
    }

    #[test]
    fn every_face_is_in_one_block_in_order() {
        for far in [0.0, 1e3] {
            let scene = scene(row(1000, far));
            let blocks = blocks(&scene, &scene.objects[0], false);
            let wanted: Vec<Cell> = (0..1000).map(|f| (f, 0)).collect();
            assert_eq!(all(&scene, &blocks), wanted);
            // Faces far from each other are not together.
            let most = blocks.iter().map(|b| b.count).max().unwrap();
            assert!(if far == 0.0 { most > 8 } else { most <= 2 }, "{most}");
        }
    }

    #[test]
    fn a_polygon_may_be_in_several_blocks() {
        let n = 700;
        let at = |k: u32| {
            let (sin, cos) = (k as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
            [cos, sin, 0.0]
        };
        let points = (0..n).map(at).chain([[2.0, 0.0, 0.0]]);
        let cage = Cage::builder().points(points);
        let cage = cage.face(0..n).face([0, n, 1]).build().unwrap();
        let scene = scene(cage);
        let cage = scene.objects[0].surface.cage();
        let blocks = blocks(&scene, &scene.objects[0], false);
        let cells = all(&scene, &blocks);
        assert_eq!(cells.len(), n as usize - 2 + 1);
        assert_eq!(blocks.iter().map(|b| b.triangles(cage)).sum::<u64>(), 699);
        assert!(blocks.len() >= 3 && blocks.iter().all(|b| b.count <= MOST));
        for block in &blocks {
            let places = places().zip(block.cells(cage));
            for ((x, y), (face, _)) in places {
                let id = SampleId::new(0, x as u32, y as u32, 0);
                assert_eq!(block.face_at(cage, id), face);
            }
        }
    }
}
