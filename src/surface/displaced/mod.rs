//! Faces that are diced displaced. The rules stand in [`displace`](crate::displace).

mod derivatives;
mod owners;

pub(super) use derivatives::linear_at;
pub(crate) use owners::Displaced;

use super::Surface;
use super::jets::{Derivatives, Jets};
use super::patch::ChannelPatch;
use crate::control::Kind;
use crate::dice::face::{Part, Sides};
use crate::displace::{Around, Heights, mitre};
use crate::records::{BLOCK_POINTS, BLOCK_STRIDE, BlockSize, Grid3};
use crate::simd::Level;
use crate::topology::{NONE, Topology};
use derivatives::{bend, differences, fold, linear_derivatives, two, uv_by};
use std::sync::Arc;

/// A side of a face that takes something from elsewhere.
#[derive(Clone, Debug, Default)]
struct Rim {
    /// The half-edge that owns the side, and whether it is the face's own.
    owner: u32,
    own: bool,
    /// Both directions of its sides differ.
    crease: bool,
    /// Texture coordinates of the owner, if they are others, and directions of points at the level that is prepared.
    uvs: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    uv: [f32; 3],
    direction: Option<[f32; 3]>,
    /// The half-edge whose face says the normal, and its texture coordinates.
    owner: u32,
    owner_uv: [f32; 3],
}

/// Buffers of one thread for dicing displaced faces.
#[derive(Clone, Debug)]
pub(super) struct DisplacedPatch {
    pub(super) on: Option<Arc<Displaced>>,
    simd: Level,
    face: u32,
    level: u32,
    triangle: bool,
    has_uvs: bool,
    rims: [Rim; 4],
    corners: [Corner; 4],
    /// Another face.
    other: ChannelPatch,
    work: Option<Box<Work>>,
    spare: Option<[Box<Grid3>; 2]>,
    relief: Option<[Box<Grid3>; 3]>,
}

/// Derivatives of the face itself along a row of its grid, of points and of texture coordinates, and what evaluates them.
#[derive(Clone, Debug, Default)]
struct Rows {
    own: [Jets; 2],
    points: Vec<Derivatives>,
    uvs: Vec<Derivatives>,
}

#[derive(Clone, Debug)]
struct Work {
    limits: Box<Grid3>,
    normals: Box<Grid3>,
    directions: Box<Grid3>,
    uvs: Box<Grid3>,
    heights: Heights,
    rows: Rows,
    /// Of the faces that own the sides, and of those that own the corners.
    others: [[Jets; 2]; 4],
    owners: [[Jets; 2]; 4],
    /// Of the last block: texture coordinates that the owner of a crease replaced.
    replaced: Vec<([usize; 2], [f32; 3])>,
}

impl Default for Work {
    fn default() -> Self {
        Self {
            limits: Grid3::boxed(),
            normals: Grid3::boxed(),
            directions: Grid3::boxed(),
            uvs: Grid3::boxed(),
            heights: Heights::default(),
            rows: Rows::default(),
            others: Default::default(),
            owners: Default::default(),
            replaced: Vec::new(),
        }
    }
}

impl Default for DisplacedPatch {
    fn default() -> Self {
        Self {
            on: None,
            simd: Level::SCALAR,
            face: 0,
            level: 0,
            triangle: false,
            has_uvs: false,
            rims: Default::default(),
            corners: Default::default(),
            other: ChannelPatch::default(),
            work: None,
            spare: None,
            relief: None,
        }
    }
}

/// Columns and rows of corners in units of the whole face.
const QUAD: [[u32; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
const TRIANGLE: [[u32; 2]; 3] = [[0, 0], [1, 0], [1, 1]];

/// Grid point `k` of side `c` of a face of `n` segments.
fn on_side(corners: &[[u32; 2]], c: usize, k: u32, n: u32) -> [u32; 2] {
    let (a, b) = (corners[c], corners[(c + 1) % corners.len()]);
    [0, 1].map(|i| a[i] * (n - k) + b[i] * k)
}

impl DisplacedPatch {
    pub(super) fn set_simd(&mut self, simd: Level) {
        self.simd = simd;
        self.other.set_simd(simd);
    }

    /// Prepares face `q` of a displaced surface; false of one that is not.
    pub(super) fn prepare(&mut self, surface: &Surface, q: u32, level: u32, sides: Sides) -> bool {
        self.on.clone_from(&surface.displaced);
        (self.face, self.level) = (q, level);
        self.triangle = surface.triangles;
        if let Some(work) = &mut self.work {
            work.rows.own.iter_mut().for_each(Jets::forget);
            let others = work.others.iter_mut().chain(&mut work.owners);
            others.flatten().for_each(Jets::forget);
        }
        let Some(on) = self.on.clone() else {
            return false;
        };
        self.has_uvs = on.displacement.reads_uvs() && surface.has_uvs();
        if sides > Sides::Hull {
            self.prepare_rims(surface, &on);
        }
        true
    }

    /// Whether texture coordinates are to be given.
    pub(super) fn reads_uvs(&self) -> bool {
        self.has_uvs
    }

    /// Grids for normals and texture coordinates of the limit, lent while a part is diced.
    pub(super) fn take_spare(&mut self) -> [Box<Grid3>; 2] {
        self.spare
            .take()
            .unwrap_or_else(|| [Grid3::boxed(), Grid3::boxed()])
    }

    pub(super) fn give_spare(&mut self, spare: [Box<Grid3>; 2]) {
        self.spare = Some(spare);
    }

    /// The same for limit points, normals and texture coordinates, for relief.
    pub(super) fn take_relief(&mut self) -> [Box<Grid3>; 3] {
        (self.relief.take()).unwrap_or_else(|| [Grid3::boxed(), Grid3::boxed(), Grid3::boxed()])
    }

    pub(super) fn give_relief(&mut self, grids: [Box<Grid3>; 3]) {
        self.relief = Some(grids);
    }

    /// Texture coordinates along side `c` of a face where they are linear.
    pub(super) fn linear_side(&self, of: &[[f32; 3]; 4], c: usize) -> Vec<[f32; 3]> {
        let (corners, n) = (self.corners(), 1_u32 << self.level);
        let scale = 1.0 / n as f32;
        let all = (0..=n).map(|k| on_side(corners, c, k, n).map(|x| x as f32 * scale));
        all.map(|at| linear_at(of, self.triangle, at)).collect()
    }

    fn corners(&self) -> &'static [[u32; 2]] {
        if self.triangle { &TRIANGLE } else { &QUAD }
    }

    fn prepare_rims(&mut self, surface: &Surface, on: &Displaced) {
        let (whole, cut) = (surface.whole_quads(), surface.quads());
        let uv_topology = if self.has_uvs {
            surface.uv_topology()
        } else {
            None
        };
        let n = 1_usize << self.level;
        for (c, h) in surface.halves_of(self.face).enumerate() {
            let edge = whole.edge(h);
            let owner = whole.edge_half(edge);
            let twin = whole.twin(h);
            let held = on.held_edges.contains(&edge);
            let crease = !held && twin != NONE && (surface.linear || cut.twin(h) == NONE);
            // Only twins answer for each other.
            let own = owner == h || owner != twin;
            let rim = &mut self.rims[c];
            (rim.owner, rim.own, rim.crease) = (if own { h } else { owner }, own, crease);
            rim.uvs.clear();
            rim.directions.clear();
            if held {
                rim.directions.resize(n + 1, [0.0; 3]);
            }
            if crease && n > 1 {
                self.crease_directions(surface, whole, c, h);
            }
            let seam =
                !own && uv_topology.is_some_and(|t| surface.tables.is_some() || t.twin(h) == NONE);
            if seam && n > 1 {
                self.seam_uvs(surface, whole, c);
            }
        }
        for (c, h) in surface.halves_of(self.face).enumerate() {
            let v = whole.fan(h);
            let first = |t: &Topology, fan: u32| t.fans()[fan as usize].first;
            let uv = |h: u32| surface.uv_limit(h).unwrap_or_default();
            let held = on.held_vertices.contains(&whole.vertex(h));
            // Faces of the bilinear scheme have their own normals.
            let owner = if surface.linear {
                h
            } else {
                first(cut, cut.fan(h))
            };
            let corner = &mut self.corners[c];
            corner.owner = owner;
            corner.direction = match held {
                true => Some([0.0; 3]),
                false => on.directions.get(&v).copied(),
            };
            if self.has_uvs {
                corner.uv = uv(first(whole, v));
                corner.owner_uv = uv(owner);
            }
        }
    }

    /// Mitres along a crease, from the normals of both of its sides.
    fn crease_directions(&mut self, surface: &Surface, whole: &Topology, c: usize, h: u32) {
        let (first, second) = (
            whole.edge_half(whole.edge(h)),
            whole.twin(whole.edge_half(whole.edge(h))),
        );
        let mut normals = [first, second].map(|half| {
            self.other.prepare_side(
                surface,
                Kind::Points,
                whole.face_of(half),
                self.level,
                Sides::Normals,
            );
            let side = half - whole.face_halves(whole.face_of(half)).start;
            self.other.side_samples(side as usize).1
        });
        let own = usize::from(first != h);
        normals[1 - own].reverse();
        let [a, b] = normals;
        self.rims[c].directions = a.iter().zip(&b).map(|(&a, &b)| mitre(&[a, b])).collect();
    }

    /// Texture coordinates of the owner along a side.
    fn seam_uvs(&mut self, surface: &Surface, whole: &Topology, c: usize) {
        let half = self.rims[c].owner;
        let face = whole.face_of(half);
        let side = (half - whole.face_halves(face).start) as usize;
        let mut uvs = match surface.has_linear_uvs() {
            true => match surface.linear_corners(face) {
                Some(of) => self.linear_side(&of, side),
                None => return,
            },
            false => {
                self.other
                    .prepare_side(surface, Kind::Uvs, face, self.level, Sides::Points);
                self.other.side_samples(side).0
            }
        };
        uvs.reverse();
        self.rims[c].uvs = uvs;
    }

    /// Calls `put` with every point of a part that lies on a side, corners left out: the side, its number there at the level that is
    /// prepared, and its column and row in the part.
    fn on_rims(&self, part: Part, mut put: impl FnMut(usize, u32, [usize; 2])) {
        let corners = self.corners();
        let n = 1_u32 << part.level;
        let shift = self.level - part.level;
        for c in 0..corners.len() {
            let (a, b) = (corners[c], corners[(c + 1) % corners.len()]);
            // What runs along the side is beyond all points but those of the part.
            let axis = usize::from(a[0] == b[0]);
            let (low, high) = (part.start[axis], part.start[axis] + part.segments);
            let (low, high) = match a[axis] < b[axis] {
                true => (low, high),
                false => (n - high, n - low),
            };
            for k in low.max(1)..=high.min(n - 1) {
                let at = on_side(corners, c, k, n);
                let inside = |i: usize| {
                    at[i]
                        .checked_sub(part.start[i])
                        .filter(|&x| x <= part.segments)
                };
                if let (Some(i), Some(j)) = (inside(0), inside(1)) {
                    put(c, k << shift, [i as usize, j as usize]);
                }
            }
        }
    }

    /// The same of corners.
    fn on_corners(&self, part: Part, mut put: impl FnMut(usize, [usize; 2])) {
        let n = 1_u32 << part.level;
        for (c, at) in self.corners().iter().enumerate() {
            let inside = |i: usize| {
                (at[i] * n)
                    .checked_sub(part.start[i])
                    .filter(|&x| x <= part.segments)
            };
            if let (Some(i), Some(j)) = (inside(0), inside(1)) {
                put(c, [i as usize, j as usize]);
            }
        }
    }

    /// Displaces a part of the face, whose limit points are in `points`, unit normals in `normals` and texture coordinates, if they are
    /// read, in `uvs`. Normals become those of the displaced surface if `wants_normals`.
    pub(super) fn displace(
        &mut self,
        surface: &Surface,
        part: Part,
        points: &mut Grid3,
        normals: &mut Grid3,
        uvs: Option<&Grid3>,
        wants_normals: bool,
    ) {
        let Some(on) = self.on.clone() else { return };
        let side = part.segments as usize + 1;
        let size = BlockSize {
            cols: side,
            rows: side,
        };
        let mut work = self.work.take().unwrap_or_default();
        work.replaced.clear();
        work.directions.copy_rows(normals, size);
        if let Some(uvs) = uvs {
            work.uvs.copy_rows(uvs, size);
        }
        if wants_normals {
            work.limits.copy_rows(points, size);
            work.normals.copy_rows(normals, size);
        }
        self.on_rims(part, |c, k, [i, j]| {
            let rim = &self.rims[c];
            if let Some(&uv) = rim.uvs.get(k as usize) {
                if rim.crease && wants_normals {
                    work.replaced.push(([i, j], work.uvs.get(i, j)));
                }
                work.uvs.set(i, j, uv);
            }
            if let Some(&direction) = rim.directions.get(k as usize) {
                work.directions.set(i, j, direction);
            }
        });
        self.on_corners(part, |c, [i, j]| {
            let corner = &self.corners[c];
            if self.has_uvs {
                work.uvs.set(i, j, corner.uv);
            }
            if let Some(direction) = corner.direction {
                work.directions.set(i, j, direction);
            }
        });
        on.displacement.grid(
            (self.simd, size),
            points,
            &work.directions,
            &work.uvs,
            wants_normals,
            &mut work.heights,
        );
        // Under slopes by pixel, normals are those of the limit.
        let wants_normals = wants_normals && on.displacement.pixel_map().is_none();
        if wants_normals {
            self.normals(surface, &on, part, normals, &mut work);
        }
        if self.triangle && part.start[0] == part.start[1] {
            fold(points, side);
            if wants_normals {
                fold(normals, side);
            }
        }
        self.work = Some(work);
    }

    fn normals(
        &self,
        surface: &Surface,
        on: &Displaced,
        part: Part,
        normals: &mut Grid3,
        work: &mut Work,
    ) {
        let displacement = &on.displacement;
        let Work {
            limits,
            normals: limit_normals,
            directions,
            uvs,
            heights,
            rows,
            others,
            owners,
            replaced,
        } = work;
        let grids = [&**limits, &**limit_normals, &**uvs];
        self.each_around(surface, part, grids, (rows, self.has_uvs), |k, around| {
            if directions.at(k) != [0.0; 3] {
                let (height, slope) = (heights.values[k], heights.slopes.at(k));
                normals.put(k, displacement.normal(around, height, slope));
            }
        });
        if surface.tables.is_some() {
            return;
        }
        let n = 1_u32 << self.level;
        // What belongs to others, once more.
        let site = |[i, j]: [usize; 2]| {
            let k = j * BLOCK_STRIDE + i;
            let is_held = directions.at(k) == [0.0; 3];
            (!is_held).then(|| (k, limits.at(k), limit_normals.at(k), heights.values[k]))
        };
        self.on_rims(part, |c, k, at| {
            let rim = &self.rims[c];
            if !rim.own
                && !rim.crease
                && let Some((place, position, normal, height)) = site(at)
            {
                let slope = heights.slopes.at(place);
                let uv = two(uvs.at(place));
                let found = self.around(
                    surface,
                    &mut others[c],
                    self.place_of(surface, rim.owner, n - k),
                    (position, normal, uv),
                );
                if let Some(around) = found {
                    normals.put(place, displacement.normal(&around, height, slope));
                }
            }
        });
        for &(at, uv) in replaced.iter() {
            // The side of a crease that has other texture coordinates than its owner.
            let scale = 1.0 / (1_u32 << part.level) as f32;
            let own_place = [0, 1].map(|k| (part.start[k] + at[k] as u32) as f32 * scale);
            if let Some((place, position, normal, height)) = site(at)
                && let Some(around) = self.around(
                    surface,
                    &mut rows.own,
                    (self.face, own_place),
                    (position, normal, two(uv)),
                )
            {
                let slope = displacement.slope_at(position, around.uv).1;
                normals.put(place, displacement.normal(&around, height, slope));
            }
        }
        self.on_corners(part, |c, at| {
            if let Some((place, position, normal, height)) = site(at)
                && let Some(found) =
                    self.corner_normal(surface, on, (c, &mut owners[c]), (position, normal), height)
            {
                normals.put(place, found);
            }
        });
    }

    /// Normal at corner `c`, by the first face of its fan.
    fn corner_normal(
        &self,
        surface: &Surface,
        on: &Displaced,
        (c, jets): (usize, &mut [Jets; 2]),
        (position, normal): ([f32; 3], [f32; 3]),
        height: f32,
    ) -> Option<[f32; 3]> {
        let corner = &self.corners[c];
        let place = self.place_of(surface, corner.owner, 0);
        let around = self.around(
            surface,
            jets,
            place,
            (position, normal, two(corner.owner_uv)),
        )?;
        let slope = on.displacement.slope_at(position, around.uv).1;
        Some(on.displacement.normal(&around, height, slope))
    }

    /// Face and place of point `k` of the side that half-edge `half` is, at the level that is prepared.
    fn place_of(&self, surface: &Surface, half: u32, k: u32) -> (u32, [f32; 2]) {
        let whole = surface.whole_quads();
        let face = whole.face_of(half);
        let side = (half - whole.face_halves(face).start) as usize;
        let n = 1_u32 << self.level;
        (
            face,
            on_side(self.corners(), side, k, n).map(|x| x as f32 / n as f32),
        )
    }

    /// The limit surface around a point of another face.
    fn around(
        &self,
        surface: &Surface,
        [points, uvs]: &mut [Jets; 2],
        (face, at): (u32, [f32; 2]),
        (position, normal, uv): ([f32; 3], [f32; 3], [f32; 2]),
    ) -> Option<Around> {
        let found = points.at::<2>(surface, Kind::Points, self.level, face, at)?;
        let by = match self.has_uvs {
            true => self.uv_at(surface, uvs, face, at),
            false => Derivatives::default(),
        };
        Some(Around {
            position,
            normal,
            bend: bend(&found),
            uv,
            uv_by: uv_by(&by),
        })
    }

    /// Displaces the samples of side `c` in place; `uvs` are its texture coordinates if they are read.
    pub(super) fn displace_side(
        &mut self,
        surface: &Surface,
        c: usize,
        points: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        uvs: &[[f32; 3]],
    ) {
        let Some(on) = self.on.clone() else { return };
        let n = points.len() - 1;
        let next = (c + 1) % self.corners().len();
        let mut work = self.work.take().unwrap_or_default();
        for first in (0..=n).step_by(BLOCK_POINTS) {
            let size = BlockSize {
                cols: BLOCK_POINTS.min(n + 1 - first),
                rows: 1,
            };
            for (i, k) in (first..first + size.cols).enumerate() {
                let rim = &self.rims[c];
                let corner = if k == 0 {
                    Some(c)
                } else {
                    (k == n).then_some(next)
                };
                let (uv, direction) = match corner.map(|c| &self.corners[c]) {
                    Some(corner) => (Some(corner.uv), corner.direction),
                    None => {
                        let uv = rim.uvs.get(k).or(uvs.get(k));
                        (uv.copied(), rim.directions.get(k).copied())
                    }
                };
                work.limits.put(i, points[k]);
                work.uvs.put(i, uv.unwrap_or_default());
                work.directions.put(i, direction.unwrap_or(normals[k]));
            }
            work.normals.clone_from(&work.limits);
            on.displacement.grid(
                (self.simd, size),
                &mut work.normals,
                &work.directions,
                &work.uvs,
                true,
                &mut work.heights,
            );
            for (i, k) in (first..first + size.cols).enumerate() {
                let (position, normal) = (points[k], normals[k]);
                points[k] = work.normals.at(i);
                if work.directions.at(i) == [0.0; 3] {
                    continue;
                }
                let height = work.heights.values[i];
                let corner = if k == 0 {
                    Some(c)
                } else {
                    (k == n).then_some(next)
                };
                if let Some(corner) = corner {
                    let jets = &mut work.owners[corner];
                    let found = self.corner_normal(
                        surface,
                        &on,
                        (corner, jets),
                        (position, normal),
                        height,
                    );
                    normals[k] = found.unwrap_or(normal);
                    continue;
                }
                let rim = &self.rims[c];
                let own = surface.halves_of(self.face).start + c as u32;
                let at_owner = !rim.own && !rim.crease;
                let (half, at) = if at_owner {
                    (rim.owner, n - k)
                } else {
                    (own, k)
                };
                let uv = match (rim.crease, uvs.get(k)) {
                    (true, Some(&uv)) => two(uv),
                    _ => two(work.uvs.at(i)),
                };
                let place = self.place_of(surface, half, at as u32);
                if let Some(around) =
                    self.around(surface, &mut work.others[c], place, (position, normal, uv))
                {
                    let slope = on.displacement.slope_at(position, uv).1;
                    normals[k] = on.displacement.normal(&around, height, slope);
                }
            }
        }
        self.work = Some(work);
    }

    /// Leaves in `out` the vectors by which slopes of the map tilt normals, at the points of a part: limit points and normals, and texture
    /// coordinates.
    pub(super) fn tilts(
        &mut self,
        surface: &Surface,
        part: Part,
        [points, normals, uvs]: [&Grid3; 3],
        out: [&mut Grid3; 2],
    ) {
        let Some(on) = self.on.clone() else { return };
        let mut work = self.work.take().unwrap_or_default();
        self.each_around(
            surface,
            part,
            [points, normals, uvs],
            (&mut work.rows, true),
            |k, around| {
                let (height, _) = on.displacement.slope_at(around.position, around.uv);
                let [a, b] = on.displacement.tilts(around, height);
                out[0].put(k, a);
                out[1].put(k, b);
            },
        );
        self.work = Some(work);
    }

    /// Leaves in `out` the derivatives of the limit surface by its texture coordinates.
    pub(super) fn tangents(
        &mut self,
        surface: &Surface,
        part: Part,
        [points, normals, uvs]: [&Grid3; 3],
        out: [&mut Grid3; 2],
    ) {
        let mut work = self.work.take().unwrap_or_default();
        self.each_around(
            surface,
            part,
            [points, normals, uvs],
            (&mut work.rows, true),
            |k, around| {
                let [a, b] = around.bend.by_uv(around.uv_by);
                out[0].put(k, a);
                out[1].put(k, b);
            },
        );
        self.work = Some(work);
    }

    /// Calls `each` for the points of a part with the limit surface around them; without `with_uvs` texture coordinates stand still.
    fn each_around(
        &self,
        surface: &Surface,
        part: Part,
        [points, normals, uvs]: [&Grid3; 3],
        (rows, with_uvs): (&mut Rows, bool),
        mut each: impl FnMut(usize, &Around),
    ) {
        let side = part.segments as usize + 1;
        rows.points.resize(side, Derivatives::default());
        rows.uvs.clear();
        rows.uvs.resize(side, Derivatives::default());
        for j in 0..side {
            let row = (part, j as u32);
            let [own, own_uv] = &mut rows.own;
            if !own.row::<2>(
                surface,
                (Kind::Points, self.level),
                self.face,
                row,
                self.simd,
                &mut rows.points,
            ) {
                differences(points, j, &mut rows.points);
            }
            if with_uvs {
                self.uv_row(surface, own_uv, row, uvs, &mut rows.uvs);
            }
            for i in 0..side {
                let k = j * BLOCK_STRIDE + i;
                each(
                    k,
                    &Around {
                        position: points.at(k),
                        normal: normals.at(k),
                        bend: bend(&rows.points[i]),
                        uv: two(uvs.at(k)),
                        uv_by: uv_by(&rows.uvs[i]),
                    },
                );
            }
        }
    }

    fn uv_row(
        &self,
        surface: &Surface,
        jets: &mut Jets,
        row: (Part, u32),
        uvs: &Grid3,
        out: &mut [Derivatives],
    ) {
        if surface.has_linear_uvs() {
            let scale = 1.0 / (1_u32 << row.0.level) as f32;
            let t = (row.0.start[1] + row.1) as f32 * scale;
            for (i, out) in (0..).zip(&mut *out) {
                let s = (row.0.start[0] + i) as f32 * scale;
                *out = linear_derivatives(surface, self.face, self.triangle, [s, t]);
            }
            return;
        }
        if !jets.row::<1>(
            surface,
            (Kind::Uvs, self.level),
            self.face,
            row,
            self.simd,
            out,
        ) {
            differences(uvs, row.1 as usize, out);
        }
    }

    fn uv_at(&self, surface: &Surface, jets: &mut Jets, face: u32, at: [f32; 2]) -> Derivatives {
        if surface.has_linear_uvs() {
            return linear_derivatives(surface, face, self.triangle, at);
        }
        (jets.at::<1>(surface, Kind::Uvs, self.level, face, at)).unwrap_or_default()
    }
}
