//! Polygons of a cage as they are given, in blocks of up to 256 cells, in the order of the faces. A cell is a quad, a triangle, or two triangles
//! that follow each other and share an edge, with what stands at its corners: a mesh of triangles takes half as many. Faces that are no
//! quads are fans around their first corner.

use crate::math;
use crate::mesh::{Cage, NONE, fan_corners};
use crate::records::{BlockSize, SampleId};
use crate::topology::Topology;
use rayon::prelude::*;
use std::ops::Range;

/// Most cells along a side of a block.
const SIDE: usize = 16;

/// Most cells of a block.
pub(crate) const MOST_CELLS: usize = SIDE * SIDE;

/// Faces that one thread looks at, at a time.
const CHUNK: usize = 4096;

/// How many times as large as all that is in it, by the squares of diagonals, the box of a block may be. Faces that lie far from each other would
/// have to be looked at wherever one of them is; a square of neighbours is at 1, a row of 32 at 16.
const SPREAD: f32 = 16.0;

/// A quad of the cage or a triangle of a fan: face, and number in its fan.
type Polygon = (u32, u32);

/// What is drawn of four points, as the two halves of a micro-quad.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Numbers of the corners at them, in the order of a quad's: of what is two triangles, the second and fourth belong to one each.
    corners: [u32; 4],
    face: u32,
}

/// A block of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PolygonBlock {
    /// The first face, and the first triangle of its fan.
    pub(crate) face: u32,
    pub(crate) fan: u32,
    /// The first of its cells.
    first: u32,
    count: u16,
    /// Triangles with an area.
    pub(crate) triangles: u16,
    low: [f32; 3],
    high: [f32; 3],
}

/// All blocks of a cage.
#[derive(Clone, Debug, Default)]
pub(crate) struct PolygonBlocks {
    pub(crate) blocks: Vec<PolygonBlock>,
    cells: Vec<Cell>,
}

/// Columns and rows of cells in a block's grid, of their first points.
pub(crate) fn cell_places() -> impl Iterator<Item = (usize, usize)> {
    (0..MOST_CELLS).map(|k| (2 * (k % SIDE), 2 * (k / SIDE)))
}

/// Square of a box's diagonal.
fn diagonal([low, high]: [[f32; 3]; 2]) -> f32 {
    let d = [0, 1, 2].map(|k| high[k] - low[k]);
    (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]
}

/// The box around two.
fn around(a: [[f32; 3]; 2], b: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    [
        [0, 1, 2].map(|k| a[0][k].min(b[0][k])),
        [0, 1, 2].map(|k| a[1][k].max(b[1][k])),
    ]
}

/// Quads and triangles of a face.
#[inline]
fn count_of(cage: &Cage, face: u32) -> u32 {
    match cage.face(face as usize).len() as u32 {
        4 => 1,
        n => n - 2,
    }
}

/// Numbers of the corners of a polygon; triangles repeat their last one.
#[inline]
fn corners_of(cage: &Cage, (face, fan): Polygon) -> [u32; 4] {
    let first = cage.face_offsets[face as usize];
    let count = (cage.face_offsets[face as usize + 1] - first) as usize;
    fan_corners(count, fan).map(|k| first + k)
}

#[inline]
fn point(cage: &Cage, corner: u32) -> [f32; 3] {
    cage.points[cage.corner_vertices[corner as usize] as usize]
}

#[inline]
fn is_triangle([.., c, d]: [u32; 4]) -> bool {
    c == d
}

/// The polygon after one.
#[inline]
fn next(cage: &Cage, (face, fan): Polygon) -> Polygon {
    if fan + 1 < count_of(cage, face) {
        (face, fan + 1)
    } else {
        (face + 1, 0)
    }
}

/// Corners of two triangles as those of a quad, if they share an edge with the same at both ends. Of `a` the edge goes from the third corner to
/// the first.
fn joined(cage: &Cage, [a, b]: [[u32; 4]; 2]) -> Option<[u32; 4]> {
    let vertex = |c: u32| cage.corner_vertices[c as usize];
    let of = |numbers: &[u32], c: u32| numbers.get(c as usize).copied().unwrap_or(NONE);
    let same = |c: u32, d: u32| {
        vertex(c) == vertex(d)
            && of(&cage.corner_normals, c) == of(&cage.corner_normals, d)
            && of(&cage.corner_uvs, c) == of(&cage.corner_uvs, d)
    };
    let turns = |[p, q, r, _]: [u32; 4]| [[p, q, r], [q, r, p], [r, p, q]];
    let both = turns(a).into_iter().flat_map(|a| turns(b).map(|b| (a, b)));
    let fits = |&(a, b): &([u32; 3], [u32; 3])| same(a[0], b[0]) && same(a[2], b[1]);
    both.into_iter()
        .find(fits)
        .map(|(a, b)| [a[0], a[1], a[2], b[2]])
}

impl PolygonBlocks {
    /// The blocks of a cage without its holes. `most` is the largest number of cells of a block with a material of the cage; blocks of 1 are a
    /// polygon each.
    pub(crate) fn new(
        cage: &Cage,
        topology: &Topology,
        most: impl Fn(u32) -> usize + Sync,
    ) -> Self {
        let faces = cage.face_count();
        let chunks = (0..faces.div_ceil(CHUNK)).into_par_iter().map(|k| {
            let mut part = Gather::new(cage);
            let faces = k * CHUNK..((k + 1) * CHUNK).min(faces);
            part.faces(topology, faces.start as u32..faces.end as u32, &most);
            part.out
        });
        let parts: Vec<Self> = chunks.collect();
        let mut all = Self::default();
        let sum = |of: fn(&Self) -> usize| parts.iter().map(of).sum();
        all.cells.reserve_exact(sum(|part| part.cells.len()));
        all.blocks.reserve_exact(sum(|part| part.blocks.len()));
        for part in parts {
            let first = all.cells.len() as u32;
            let moved = |b: &PolygonBlock| PolygonBlock {
                first: b.first + first,
                ..*b
            };
            all.blocks.extend(part.blocks.iter().map(moved));
            all.cells.extend(part.cells);
        }
        all
    }

    /// Bytes that making the blocks of a cage takes at most: those of all chunks, and of all together.
    pub(crate) fn making_bytes(cage: &Cage) -> u128 {
        let polygons = (cage.corner_vertices.len()).saturating_sub(2 * cage.face_count());
        2 * polygons as u128 * (size_of::<Cell>() + size_of::<PolygonBlock>()) as u128
    }

    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.blocks) + size_of_val(&*self.cells)
    }

    fn cells(&self, block: &PolygonBlock) -> &[Cell] {
        &self.cells[block.first as usize..][..usize::from(block.count)]
    }

    /// Per cell the numbers of the corners at its points, in the order of a quad's: of what is two triangles the second and fourth belong to one
    /// each.
    pub(crate) fn corners(&self, block: &PolygonBlock) -> impl Iterator<Item = [u32; 4]> {
        self.cells(block).iter().map(|cell| cell.corners)
    }

    /// The face that a sample of a block shows.
    pub(crate) fn face_at(&self, cage: &Cage, block: &PolygonBlock, id: SampleId) -> u32 {
        let k = (id.row() / 2) as usize * SIDE + (id.col() / 2) as usize;
        let Cell { corners, face } = self.cells(block)[k];
        let is_next = id.half() == 1 && corners[3] >= cage.face_offsets[face as usize + 1];
        face + u32::from(is_next)
    }

    /// Points whose convex hull holds a block.
    pub(crate) fn hull(&self, cage: &Cage, block: &PolygonBlock, out: &mut Vec<[f32; 3]>) {
        if block.count > 1 {
            return out.extend(math::box_corners(block.low, block.high));
        }
        let points = |corners: [u32; 4]| corners.map(|c| point(cage, c));
        out.extend(self.corners(block).flat_map(points));
    }
}

impl PolygonBlock {
    /// Size of the grid.
    pub(crate) fn size(&self) -> BlockSize {
        let count = usize::from(self.count);
        BlockSize {
            cols: 2 * count.min(SIDE),
            rows: 2 * count.div_ceil(SIDE),
        }
    }

    /// Cells of the last row, if that is neither full nor the only one.
    pub(crate) fn rest(&self) -> Option<usize> {
        let count = usize::from(self.count);
        (count > SIDE && count % SIDE != 0).then_some(count % SIDE)
    }
}

/// Blocks in the making.
struct Gather<'a> {
    cage: &'a Cage,
    out: PolygonBlocks,
    /// Box of the block that is open, and of what is in it the squares of diagonals.
    bounds: [[f32; 3]; 2],
    within: f32,
    is_open: bool,
}

impl<'a> Gather<'a> {
    fn new(cage: &'a Cage) -> Self {
        Self {
            cage,
            out: PolygonBlocks::default(),
            bounds: [[0.0; 3]; 2],
            within: 0.0,
            is_open: false,
        }
    }

    fn close(&mut self) {
        if let (true, Some(block)) = (self.is_open, self.out.blocks.last_mut()) {
            [block.low, block.high] = self.bounds;
        }
        self.is_open = false;
    }

    fn faces(&mut self, topology: &Topology, faces: Range<u32>, most: &impl Fn(u32) -> usize) {
        let cage = self.cage;
        let material = |face: u32| (cage.face_materials.get(face as usize)).map_or(NONE, |&m| m);
        let mut last = None;
        let mut at = (faces.start, 0);
        while at.0 < faces.end {
            let own = material(at.0);
            if last != Some(own) {
                self.close();
                last = Some(own);
            }
            if topology.is_hole(at.0) {
                self.close();
                at = (at.0 + 1, 0);
                continue;
            }
            let most = most(own);
            let mut corners = corners_of(cage, at);
            let mut after = next(cage, at);
            let mut triangles = if is_triangle(corners) { 1 } else { 2 };
            if most > 1 && triangles == 1 && after.0 < faces.end {
                let other = corners_of(cage, after);
                let is_alike = material(after.0) == own && !topology.is_hole(after.0);
                let can_join = is_alike && is_triangle(other);
                if let Some(both) = can_join.then(|| joined(cage, [corners, other])).flatten() {
                    (corners, triangles) = (both, 2);
                    after = next(cage, after);
                }
            }
            self.put(at, corners, triangles, most);
            at = after;
        }
        self.close();
    }

    /// Puts a cell into the block that is open, or into one of its own.
    fn put(&mut self, (face, fan): Polygon, corners: [u32; 4], triangles: u16, most: usize) {
        let [a, b, c, d] = corners.map(|c| [point(self.cage, c); 2]);
        let bounds = around(around(a, b), around(c, d));
        let size = diagonal(bounds);
        let both = around(self.bounds, bounds);
        let first = self.out.cells.len() as u32;
        self.out.cells.push(Cell { corners, face });
        match self.out.blocks.last_mut() {
            Some(block)
                if self.is_open
                    && usize::from(block.count) < most
                    && diagonal(both) <= SPREAD * (self.within + size) =>
            {
                self.bounds = both;
                self.within += size;
                block.count += 1;
                block.triangles += triangles;
            }
            _ => {
                self.close();
                (self.bounds, self.within, self.is_open) = (bounds, size, true);
                self.out.blocks.push(PolygonBlock {
                    face,
                    fan,
                    first,
                    count: 1,
                    triangles,
                    low: bounds[0],
                    high: bounds[1],
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Surface, SurfaceOptions};

    fn blocks(cage: &Cage, most: usize) -> PolygonBlocks {
        let surface = Surface::new(cage.clone(), &SurfaceOptions::default());
        PolygonBlocks::new(cage, surface.topology(), |_| most)
    }

    /// Vertices from the least one on, in their order.
    fn turned(mut v: Vec<u32>) -> Vec<u32> {
        let least = (0..v.len()).min_by_key(|&k| v[k]).unwrap_or(0);
        v.rotate_left(least);
        v
    }

    /// What is drawn: the face, and vertices of a quad or triangle.
    fn drawn(cage: &Cage, all: &PolygonBlocks) -> Vec<(u32, Vec<u32>)> {
        let mut out = Vec::new();
        for block in &all.blocks {
            let mut triangles = 0;
            for (k, corners) in all.corners(block).enumerate() {
                let (x, y) = cell_places().nth(k).unwrap();
                let v = corners.map(|c| cage.corner_vertices[c as usize]);
                let face = |half: u32| {
                    let id = SampleId::new(0, x as u32, y as u32, half);
                    all.face_at(cage, block, id)
                };
                let of_quad = cage.face(face(0) as usize).len() == 4;
                triangles += if v[2] == v[3] { 1 } else { 2 };
                if of_quad {
                    assert_eq!(face(0), face(1));
                    out.push((face(0), turned(v.to_vec())));
                    continue;
                }
                out.push((face(0), turned(vec![v[0], v[1], v[2]])));
                if v[2] != v[3] {
                    out.push((face(1), turned(vec![v[0], v[2], v[3]])));
                }
            }
            assert_eq!(triangles, block.triangles);
        }
        out
    }

    /// What there is to draw, in the same form.
    fn wanted(cage: &Cage) -> Vec<(u32, Vec<u32>)> {
        let mut out = Vec::new();
        for f in 0..cage.face_count() {
            let face = cage.face(f);
            if face.len() == 4 {
                out.push((f as u32, turned(face.to_vec())));
                continue;
            }
            for k in 1..face.len() - 1 {
                out.push((f as u32, turned(vec![face[0], face[k], face[k + 1]])));
            }
        }
        out
    }

    /// A strip of quads, every third one `far` beside it.
    fn strip(n: u32, far: f32) -> Cage {
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

    /// Points of a sheet of `n` by `n` squares.
    fn points(n: u32) -> impl Iterator<Item = [f32; 3]> {
        (0..(n + 1) * (n + 1)).map(move |k| [(k % (n + 1)) as f32, (k / (n + 1)) as f32, 0.0])
    }

    #[test]
    fn every_face_is_drawn_once_in_order() {
        for far in [0.0, 1e3] {
            let cage = strip(1000, far);
            let all = blocks(&cage, MOST_CELLS);
            assert_eq!(drawn(&cage, &all), wanted(&cage));
            // Faces far from each other are not together.
            let most = all.blocks.iter().map(|b| b.count).max().unwrap();
            assert!(if far == 0.0 { most > 8 } else { most <= 2 }, "{most}");
        }
    }

    #[test]
    fn a_polygon_may_be_in_several_blocks() {
        let n = 1400;
        let at = |k: u32| {
            let (sin, cos) = (k as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
            [cos, sin, 0.0]
        };
        let cage = Cage::builder().points((0..n).map(at).chain([[2.0, 0.0, 0.0]]));
        let cage = cage.face(0..n).face([0, n, 1]).build().unwrap();
        let all = blocks(&cage, MOST_CELLS);
        assert_eq!(drawn(&cage, &all), wanted(&cage));
        assert!(all.blocks.len() >= 3);
        assert_eq!(all.cells.len(), (n as usize - 2) / 2 + 1);
    }

    #[test]
    fn triangles_side_by_side_share_a_cell() {
        let n = 40;
        let corner = |k: u32| k / n * (n + 1) + k % n;
        // Every way to begin with a corner, for either triangle.
        let of = |k: u32| {
            let [a, b, c, d] = [0, 1, n + 2, n + 1].map(|o| corner(k) + o);
            let (mut first, mut second) = ([a, b, c], [a, c, d]);
            first.rotate_left((k % 3) as usize);
            second.rotate_left((k / 3 % 3) as usize);
            [first, second]
        };
        let cage = (0..n * n)
            .flat_map(of)
            .fold(Cage::builder().points(points(n)), |cage, triangle| {
                cage.face(triangle)
            });
        let cage = cage.build().unwrap();
        let all = blocks(&cage, MOST_CELLS);
        assert_eq!(drawn(&cage, &all), wanted(&cage));
        assert_eq!(all.cells.len(), (n * n) as usize);
        // One by one where they are to be.
        let apart = blocks(&cage, 1);
        assert_eq!(apart.blocks.len(), 2 * (n * n) as usize);
        assert_eq!(drawn(&cage, &apart), wanted(&cage));
    }

    #[test]
    fn what_stands_at_corners_keeps_triangles_apart() {
        let build = |second: [u32; 3], number: u32| {
            let mut cage =
                Cage::new(points(1).collect(), &[3, 3], [[0, 1, 3], second].concat()).unwrap();
            cage.uvs = vec![[0.0; 2]; 2];
            cage.corner_uvs = vec![0, 0, 0, number, 0, 0];
            blocks(&cage, MOST_CELLS).cells.len()
        };
        assert_eq!(build([0, 3, 2], 0), 1);
        assert_eq!(build([0, 3, 2], 1), 2);
        // Not where the edge is run through the same way, nor where one corner is shared alone.
        assert_eq!(build([3, 0, 2], 0), 2);
        assert_eq!(build([0, 2, 2], 0), 2);
    }

    #[test]
    fn blocks_move_with_the_points() {
        let mut surface = Surface::new(strip(8, 0.0), &SurfaceOptions::default());
        let hull = |surface: &Surface| {
            let mut out = Vec::new();
            let all = surface.polygon_blocks();
            all.hull(surface.cage(), &all.blocks[0], &mut out);
            out
        };
        let before = hull(&surface);
        let moved: Vec<[f32; 3]> = (surface.cage().points.iter())
            .map(|p| [p[0], p[1] + 5.0, p[2]])
            .collect();
        surface.update_points(&moved).unwrap();
        let wanted: Vec<[f32; 3]> = before.iter().map(|p| [p[0], p[1] + 5.0, p[2]]).collect();
        assert_eq!(hull(&surface), wanted);
    }
}
