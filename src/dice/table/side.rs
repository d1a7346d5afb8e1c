//! Sides of the faces of a mesh, which one of the two faces dices, and single points.

use super::super::face::{DiceFault, Sides};
use super::super::regular::{LINE, Line, unit_cross};
use super::patch::{Scratch, TableChannel, TablePatch, between};
use super::{Controls, Rows, inside_place, weigh_one};
use crate::topology::NONE;

/// Who dices a side of a face of the mesh.
struct Owner {
    face: u32,
    c: usize,
    half: u32,
    is_foreign: bool,
    /// Whether normals are its, not only points.
    shared: bool,
}

impl TablePatch {
    /// Leaves the points of side `c` of a face of the mesh in `scratch`, without its ends, and their normals if those are wanted.
    pub(super) fn dice_side(
        &self,
        channel: &TableChannel,
        face: u32,
        c: usize,
        steps: u32,
        scratch: &mut Scratch,
    ) {
        let t = &channel.mesh.topology;
        let with_normals = self.wanted == Sides::Normals;
        let spare = channel.spare(face);
        let side = self.owner(channel, face, c);
        // Across a cut points are shared and normals are not.
        let own = with_normals && !side.shared;
        if own || !side.is_foreign {
            channel.gather(face, &mut scratch.controls);
            let rows = &channel.table(face, steps).sides[c];
            channel.evaluate(self.simd, rows, face, spare, with_normals, scratch);
        }
        if side.is_foreign {
            let normals = own.then(|| std::mem::take(&mut scratch.normals));
            channel.gather(side.face, &mut scratch.controls);
            let rows = &channel.table(side.face, steps).sides[side.c];
            channel.evaluate(
                self.simd,
                rows,
                side.face,
                spare,
                with_normals && !own,
                scratch,
            );
            if t.vertex(side.half) != t.vertex(t.face_halves(face).start + c as u32) {
                scratch.points.reverse();
                scratch.normals.reverse();
            }
            if let Some(normals) = normals {
                scratch.normals = normals;
            }
        }
    }

    /// By which face side `c` of face `face` of the mesh is diced.
    fn owner(&self, channel: &TableChannel, face: u32, c: usize) -> Owner {
        let mesh = &*channel.mesh;
        let h = mesh.topology.face_halves(face).start + c as u32;
        let owner = mesh.owners.get(h as usize).copied().unwrap_or(h);
        let is_foreign =
            owner != h && self.wanted > Sides::None && self.fault != DiceFault::OwnDirection;
        let half = if is_foreign { owner } else { h };
        let owner = mesh.topology.face_of(half);
        Owner {
            face: owner,
            c: (half - mesh.topology.face_halves(owner).start) as usize,
            half,
            is_foreign,
            shared: !is_foreign || mesh.topology.twin(h) != NONE,
        }
    }

    /// One grid point of a level, with its normal if those are wanted.
    pub(super) fn point(
        &self,
        channel: &TableChannel,
        level: u32,
        at: [u32; 2],
    ) -> ([f32; 3], [f32; 3]) {
        let mesh = &*channel.mesh;
        // On the grid of the mesh, or a finer one.
        let level_at = level.max(channel.depth);
        let at = at.map(|k| k << (level_at - level));
        let steps = level_at - channel.depth;
        let (n, last) = (1_u32 << steps, (1_u32 << channel.depth) - 1);
        let cell = at.map(|k| (k / n).min(last));
        let in_cell = [0, 1].map(|k| (at[k] - cell[k] * n) as i32);
        let upper = channel.triangular && in_cell[1] > in_cell[0];
        let found = channel.cell(self.face, cell).find(|f| f.1 == upper);
        let Some((face, _)) = found else {
            return ([0.0; 3], [0.0; 3]);
        };
        let n = n as i32;
        let [i, j] = if upper {
            in_cell.map(|k| n - k)
        } else {
            in_cell
        };
        let (corners, sides) = (channel.corners(n), channel.sides());
        let first = mesh.topology.face_halves(face).start;
        if let Some(c) = corners[..sides].iter().position(|&c| c == [i, j]) {
            let h = first + c as u32;
            return (
                mesh.points[mesh.topology.vertex(h) as usize],
                mesh.normal(h),
            );
        }
        let mut controls = Controls::default();
        let with_normals = self.wanted == Sides::Normals;
        let spare = channel.spare(face);
        let mut one = |of: u32, rows: &Rows, k: usize| {
            channel.gather(of, &mut controls);
            evaluate_one(rows, k, &controls, channel.base(of), spare, with_normals)
        };
        let side = (0..sides).find_map(|c| {
            let (a, b) = (corners[c], corners[(c + 1) % sides]);
            let k = (1..n).find(|&k| between(a, b, k, n) == [i, j])?;
            Some((c, k as usize - 1))
        });
        let Some((c, k)) = side else {
            let k = inside_place(channel.triangular, n as usize, [i as usize, j as usize]);
            return one(face, &channel.table(face, steps).inside, k);
        };
        let owner = self.owner(channel, face, c);
        let t = &mesh.topology;
        let reversed = t.vertex(owner.half) != t.vertex(first + c as u32);
        let of_owner = if reversed { n as usize - 2 - k } else { k };
        let rows = &channel.table(owner.face, steps).sides[owner.c];
        let found = one(owner.face, rows, of_owner);
        match owner.shared {
            true => found,
            false => (
                found.0,
                one(face, &channel.table(face, steps).sides[c], k).1,
            ),
        }
    }

    /// Samples of side `c` at the level that was prepared, ends included; normals must have been wanted.
    pub(crate) fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        points.clear();
        normals.clear();
        let Some(channel) = self.channel.as_deref() else {
            return;
        };
        let mesh = &*channel.mesh;
        let per_side = 1_u32 << channel.depth;
        let last = per_side - 1;
        let mut scratch = Scratch::default();
        for k in 0..per_side {
            let cell = match (c, channel.triangular) {
                (0, _) => [k, 0],
                (1, _) => [last, k],
                (2, true) => [last - k; 2],
                (2, false) => [last - k, last],
                _ => [0, last - k],
            };
            // Sides of the face are sides of the same number of the faces along it.
            let Some((face, _)) = channel.cell(self.face, cell).next() else {
                continue;
            };
            let corner = |c: usize| {
                let h = mesh.topology.face_halves(face).start + (c % channel.sides()) as u32;
                (
                    mesh.points[mesh.topology.vertex(h) as usize],
                    mesh.normal(h),
                )
            };
            points.push(corner(c).0);
            normals.push(corner(c).1);
            if channel.steps > 0 {
                self.dice_side(channel, face, c, channel.steps, &mut scratch);
                points.append(&mut scratch.points);
                normals.append(&mut scratch.normals);
            }
            if k == last {
                points.push(corner(c + 1).0);
                normals.push(corner(c + 1).1);
            }
        }
    }
}

/// Point number `k` of `rows` and its unit normal if wanted, with the bits of [`evaluate`].
fn evaluate_one(
    rows: &Rows,
    k: usize,
    controls: &Controls,
    base: [f32; 3],
    spare: [f32; 3],
    with_normal: bool,
) -> ([f32; 3], [f32; 3]) {
    let size = controls.0[0].len();
    let Some((first, _, at, lanes)) = rows.lines(size).nth(k / LINE) else {
        return (base, spare);
    };
    let sum = |layer: usize| {
        let weights = &rows.layers[layer][at..at + size * lanes];
        weigh_one(weights, lanes, k - first, controls)
    };
    let p = sum(0);
    let p = [0, 1, 2].map(|k| base[k] + p[k]);
    if !with_normal {
        return (p, spare);
    }
    let zero: [Line; 3] = [[0.0; LINE]; 3];
    let (mut a, mut b, mut unit) = (zero, zero, zero);
    let (du, dv) = (sum(1), sum(2));
    for k in 0..3 {
        (a[k][0], b[k][0]) = (du[k], dv[k]);
    }
    unit_cross(&a, &b, 1, spare, &mut unit);
    (p, [unit[0][0], unit[1][0], unit[2][0]])
}
