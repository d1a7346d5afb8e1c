//! What a face reads of its chunk: the spots of its corners and sides, its stencils and tables. Each is listed once per chunk.

use super::chunk::{ALIGNED, Builder, ChunkData, Listed};
use super::dicer::{Dicer, FaceTable, Shown};
use super::error::GpuError;
use super::owners::Owners;
use super::records::{Face, Spot, Stencil};
use super::tables::{Table, rim_index};

impl ChunkData {
    /// The stencil of a quad, added with its table unless they are there.
    pub(super) fn stencil(
        &mut self,
        there: &mut Listed,
        dicer: &Dicer<'_>,
        quad: u32,
        of: FaceTable<'_, Table>,
        is_rim: bool,
    ) -> u32 {
        if let Some(&found) = there.stencils.get(&quad) {
            return found;
        }
        let table = of.table;
        let sub = dicer.sub(quad);
        let (of_table, offset, stride) = match is_rim {
            true => (&table.rim, table.rim_offset(sub), table.rim_stride),
            false => (&table.weights, table.offset(sub), table.stride()),
        };
        let weights = &mut self.weights;
        let base = *there.tables.entry(of.number).or_insert_with(|| {
            let base = weights.len() as u32 / table.width;
            weights.extend_from_slice(of_table);
            weights.resize(weights.len().next_multiple_of(ALIGNED as usize), 0.0);
            base
        });
        let next = self.stencils.len() as u32;
        self.stencils.push(Stencil {
            gather: self.gathers.len() as u32,
            count: table.columns.len() as u32,
            table: base + offset,
            stride,
        });
        let own = table.columns.iter();
        let own = own.map(|&k| of.places.vertices[k as usize] + dicer.first_point);
        self.gathers.extend(own);
        there.stencils.insert(quad, next);
        next
    }
}

impl Builder {
    /// What is diced of a quad whose blocks' places are given in `reach`.
    pub(super) fn face(
        &mut self,
        dicer: &Dicer<'_>,
        quad: u32,
        reach: u32,
    ) -> Result<Face, GpuError> {
        let whole = dicer.surface.whole_quads();
        let (mut corners, mut sides, mut turns) = ([0; 4], [0; 4], 0);
        let (mut base_corners, mut base_sides) = ([0; 4], [0; 4]);
        for (c, h) in whole.face_halves(quad).enumerate() {
            let owners = dicer.side_owners(h);
            let turned = |owner: u32| owner != h && whole.vertex(owner) != whole.vertex(h);
            let ways =
                u32::from(turned(owners.normal)) << 7 | u32::from(turned(owners.position)) << 6;
            if dicer.shown == Shown::Qas {
                base_corners[c] = self.base_corner(dicer, h)?;
                base_sides[c] = self.base_side(dicer, h)?;
            }
            let mut more = 0;
            if dicer.shown == Shown::Qas && !dicer.is_displaced() {
                corners[c] = base_corners[c];
            } else {
                let level = dicer.side_level(h)?;
                corners[c] = self.corner(dicer, h)?;
                sides[c] = self.side(dicer, h, owners, level)?;
                more = finer(level, reach)?;
            }
            turns |= (more | ways) << (8 * c);
        }
        let cage_face = dicer.surface.cage_face(quad);
        let level = match dicer.is_apart() {
            true => (dicer.drawn_levels.get(&cage_face).copied()).ok_or(GpuError::Missing {
                what: "level of a face",
            })?,
            false => dicer.table(quad)?.table.level,
        };
        let middle = self.middle(dicer, quad)?;
        let [uv_gather, uv_count, uv_table] = self.uv_stencil(dicer, quad, false);
        let stencil = match dicer.is_apart() {
            true => 0,
            false => self.stencil(dicer, quad)?,
        };
        Ok(Face {
            corners,
            sides,
            base_corners,
            base_sides,
            turns,
            stencil,
            row: (1 << level) + 1,
            shift: finer(level, reach)?,
            reach,
            number: dicer.first_face + cage_face,
            // The last material is that of faces without one.
            material: dicer.object.material(cage_face),
            uv_gather,
            uv_count,
            uv_table,
            colors: dicer.colors,
            middle,
            color_stencil: self.color_stencil(dicer, quad).unwrap_or(stencil),
            padding: [0; 3],
        })
    }

    /// First gather, count and first weight of a quad's texture coordinates, or of those on its sides alone; zeros without.
    pub(super) fn uv_stencil(&mut self, dicer: &Dicer<'_>, quad: u32, is_rim: bool) -> [u32; 3] {
        let Some(of) = dicer.uv_table(quad) else {
            return [0; 3];
        };
        if let Some(&found) = self.there.uvs.get(&(quad, is_rim)) {
            return found;
        }
        let (number, table) = (of.number, of.table);
        let sub = dicer.sub(quad);
        let (tables, of_table, offset) = match is_rim {
            true => (&mut self.there.uv_rims, &table.rim, table.rim_offset(sub)),
            false => (&mut self.there.uv_tables, &table.weights, table.offset(sub)),
        };
        let weights = &mut self.data.weights;
        let base = *tables.entry(number).or_insert_with(|| {
            let base = weights.len() as u32;
            weights.extend_from_slice(of_table);
            weights.resize(weights.len().next_multiple_of(ALIGNED as usize), 0.0);
            base
        });
        let gather = self.data.gathers.len() as u32;
        let own = of.places.uvs.iter().map(|&k| dicer.first_uv + 2 * k);
        self.data.gathers.extend(own);
        let found = [gather, table.count, base + offset];
        self.there.uvs.insert((quad, is_rim), found);
        found
    }

    fn stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> Result<u32, GpuError> {
        let there = &mut self.there.points;
        Ok((self.data).stencil(there, dicer, quad, dicer.table(quad)?, false))
    }

    /// The stencil of a quad's sides alone.
    fn rim_stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> Result<u32, GpuError> {
        let there = &mut self.there.rims;
        Ok((self.data).stencil(there, dicer, quad, dicer.table(quad)?, true))
    }

    /// The stencil of a quad's colours, where it is one of its own.
    fn color_stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> Option<u32> {
        let of = dicer.color_table(quad)?;
        Some((self.data).stencil(&mut self.there.colors, dicer, quad, of, false))
    }

    /// Stencil and point of a place of a quad, given on the grid of `level`, of the limit surface.
    ///
    /// Places are on sides: whoever shares them needs no more of another face.
    pub(super) fn place(
        &mut self,
        dicer: &Dicer<'_>,
        quad: u32,
        at: [u32; 2],
        level: u32,
    ) -> Result<[u32; 2], GpuError> {
        let deep = dicer.table(quad)?.table.level;
        let index = rim_place(dicer, at, level, deep)?;
        Ok([self.rim_stencil(dicer, quad)?, index])
    }

    /// The same of what is shown: of PN triangles, where their control points are, and the place.
    pub(super) fn shown_place(
        &mut self,
        dicer: &Dicer<'_>,
        quad: u32,
        at: [u32; 2],
        level: u32,
    ) -> Result<[u32; 2], GpuError> {
        match dicer.shown == Shown::Pn && !dicer.is_displaced() {
            true => Ok(dicer.net_place(quad, at, level)),
            false => self.place(dicer, quad, at, level),
        }
    }

    pub(super) fn corner(&mut self, dicer: &Dicer<'_>, h: u32) -> Result<u32, GpuError> {
        let owners = dicer.corner_owners(h);
        if let Some(&found) = self.there.corners.get(&owners.normal) {
            return Ok(found);
        }
        let count = dicer.corner_count();
        let mut of = |h: u32| {
            let at = dicer.along(h % count, 0, 1);
            self.shown_place(dicer, h / count, at, 0)
        };
        let (p, n) = (of(owners.position)?, of(dicer.evaluated(owners))?);
        let curve = self.corner_curve(dicer, h, owners)?;
        let n = match curve.is_none() && dicer.shown != Shown::Pn {
            true => self.corner_normal(dicer, h, n),
            false => n,
        };
        if curve.is_some() {
            let mitred = dicer.surface.mitred_corner(h).unwrap_or_default();
            self.mitred_corners(dicer, &mitred)?;
        }
        let at = self.data.spots.len() as u32;
        self.data.spots.push(spot([p, n]));
        if dicer.is_displaced() {
            self.lift_corner(dicer, h, (owners, curve))?;
        }
        self.there.corners.insert(owners.normal, at);
        Ok(at)
    }

    fn side(
        &mut self,
        dicer: &Dicer<'_>,
        h: u32,
        owners: Owners,
        level: u32,
    ) -> Result<u32, GpuError> {
        if let Some(&found) = self.there.sides.get(&owners.normal) {
            return Ok(found);
        }
        let (count, n) = (dicer.corner_count(), 1_u32 << level);
        let whole = dicer.surface.whole_quads();
        let same = owners.position == owners.normal
            || whole.vertex(owners.position) == whole.vertex(owners.normal);
        let ends = self.side_curve(dicer, h, owners)?;
        // Spots of the side follow each other: what they stand on is there before.
        if ends.is_some() {
            for h in dicer.surface.mitred_side(h).into_iter().flatten() {
                self.side_curve(dicer, h, owners)?;
            }
        }
        let first = self.data.spots.len() as u32;
        for k in 1..n {
            let turned = if same { k } else { n - k };
            let at = dicer.along(owners.position % count, turned, n);
            let p = self.shown_place(dicer, owners.position / count, at, level)?;
            let evaluated = dicer.evaluated(owners);
            let along = match whole.vertex(evaluated) == whole.vertex(owners.normal) {
                true => k,
                false => n - k,
            };
            let at = dicer.along(evaluated % count, along, n);
            let own = self.shown_place(dicer, evaluated / count, at, level)?;
            let curve = ends.map(|ends| ends.at(dicer, [turned, k], level));
            self.data.spots.push(spot([p, own]));
            if dicer.is_displaced() {
                self.lift_side(dicer, h, (owners, curve), [turned, level])?;
            }
        }
        self.there.sides.insert(owners.normal, first);
        Ok(first)
    }
}

/// A spot by stencil and point, of its position and of its normal.
pub(super) fn spot([position, normal]: [[u32; 2]; 2]) -> Spot {
    Spot {
        stencil: position[0],
        index: position[1],
        normal_stencil: normal[0],
        normal_index: normal[1],
    }
}

/// The point of a rim of level `deep` that a place on a side is, given on the grid of `level`.
pub(super) fn rim_place(
    dicer: &Dicer<'_>,
    [x, y]: [u32; 2],
    level: u32,
    deep: u32,
) -> Result<u32, GpuError> {
    let up = finer(deep, level)?;
    let triangles = dicer.surface.is_triangular();
    Ok(rim_index([x << up, y << up], 1 << deep, triangles))
}

/// By how many levels `deep` is finer than `level`.
fn finer(deep: u32, level: u32) -> Result<u32, GpuError> {
    deep.checked_sub(level).ok_or(GpuError::Missing {
        what: "table as fine as its face",
    })
}
