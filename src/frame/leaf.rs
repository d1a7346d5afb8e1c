//! Blocks of an adaptive tessellation: a part of a quad, with the points of its rim that are drawn elsewhere.

use super::attributes::Attributes;
use super::prepared::SourceScratch;
use crate::dice::face::{Part, Sides};
use crate::math;
use crate::records::{BLOCK_POINTS, BlockSize, Grid3};
use crate::surface::Surface;
use crate::tessellate::{Leaf, List, Move, Tessellation};

/// Grids of single points.
pub(super) struct Spare {
    first: Box<Grid3>,
    second: Box<Grid3>,
    hull: Option<Box<Grid3>>,
}

impl Default for Spare {
    fn default() -> Self {
        Self {
            first: Grid3::boxed(),
            second: Grid3::boxed(),
            hull: None,
        }
    }
}

fn part(leaf: &Leaf) -> Part {
    Part {
        level: u32::from(leaf.level),
        start: leaf.start.map(u32::from),
        segments: 1 << leaf.log,
    }
}

/// The one point that a moved one goes to.
fn target(leaf: &Leaf, to: Move) -> Part {
    Part {
        level: u32::from(leaf.reach),
        start: to.to.map(u32::from),
        segments: 0,
    }
}

/// Where in the block the target of a move is, if it is there.
fn inside(leaf: &Leaf, to: Move) -> Option<[usize; 2]> {
    let up = u32::from(leaf.reach - leaf.level);
    let mut at = [0; 2];
    for k in 0..2 {
        let (to, start) = (u32::from(to.to[k]), u32::from(leaf.start[k]));
        let step = (to >> up).checked_sub(start)?;
        if to & ((1 << up) - 1) != 0 || step > 1 << leaf.log {
            return None;
        }
        at[k] = step as usize;
    }
    Some(at)
}

/// Moves points of the grid, and of a second one beside it; `dice` evaluates a single point.
fn apply(
    leaf: &Leaf,
    moves: &[Move],
    grid: &mut Grid3,
    mut other: Option<&mut Grid3>,
    spare: &mut Spare,
    dice: impl Fn(Part, &mut Grid3, Option<&mut Grid3>),
) {
    let mut last = None;
    for &to in moves {
        let [i, j] = to.at.map(usize::from);
        let (p, q) = match inside(leaf, to) {
            Some([a, b]) => (grid.get(a, b), other.as_deref().map(|o| o.get(a, b))),
            None => {
                if last != Some(to.to) {
                    let wanted = other.is_some().then_some(&mut *spare.second);
                    dice(target(leaf, to), &mut spare.first, wanted);
                    last = Some(to.to);
                }
                (spare.first.get(0, 0), Some(spare.second.get(0, 0)))
            }
        };
        grid.set(i, j, p);
        if let (Some(other), Some(q)) = (other.as_deref_mut(), q) {
            other.set(i, j, q);
        }
    }
}

/// The points of a leaf that is no grid at all.
pub(super) fn scattered<'a>(tessellation: &'a Tessellation, leaf: &Leaf) -> Option<&'a List> {
    tessellation.list(leaf).filter(|l| !l.points.is_empty())
}

/// Column and row of a scattered point in its block.
fn cell(k: usize) -> [usize; 2] {
    [k % BLOCK_POINTS, k / BLOCK_POINTS]
}

/// Evaluates the points of a leaf one by one; the rest of its block repeats the last.
fn scatter(
    leaf: &Leaf,
    list: &List,
    grid: &mut Grid3,
    mut other: Option<&mut Grid3>,
    spare: &mut Spare,
    dice: impl Fn(Part, &mut Grid3, Option<&mut Grid3>),
) {
    for k in 0..list.rows() * BLOCK_POINTS {
        if let Some(&place) = list.points.get(k) {
            let one = Part {
                level: u32::from(leaf.level),
                start: place.map(u32::from),
                segments: 0,
            };
            let wanted = other.is_some().then_some(&mut *spare.second);
            dice(one, &mut spare.first, wanted);
        }
        let [i, j] = cell(k);
        grid.set(i, j, spare.first.get(0, 0));
        if let Some(other) = other.as_deref_mut() {
            other.set(i, j, spare.second.get(0, 0));
        }
    }
}

pub(super) fn block_size(tessellation: &Tessellation, item: u32) -> BlockSize {
    let leaf = &tessellation.leaves[item as usize];
    if let Some(list) = scattered(tessellation, leaf) {
        return BlockSize {
            cols: BLOCK_POINTS,
            rows: list.rows(),
        };
    }
    let n = (1_usize << leaf.log) + 1;
    BlockSize { cols: n, rows: n }
}

/// Whether a leaf is the lower half of its square.
pub(super) fn is_half(tessellation: &Tessellation, leaf: &Leaf) -> bool {
    tessellation.triangular && leaf.is_diagonal()
}

/// Repeats the diagonal above it, so that no triangle there has an area.
fn fold(leaf: &Leaf, grid: &mut Grid3) {
    for j in 1..=1_usize << leaf.log {
        let p = grid.get(j, j);
        (0..j).for_each(|i| grid.set(i, j, p));
    }
}

/// Micro-triangles with an area. A point that moves takes the edge behind it away.
pub(crate) fn triangles(tessellation: &Tessellation) -> u64 {
    let leaves = tessellation.leaves.iter();
    let all = leaves.map(|l| match tessellation.list(l) {
        Some(list) => list.triangles.len() as u64,
        None => (2 - u64::from(is_half(tessellation, l))) << (2 * l.log),
    });
    all.sum::<u64>() - tessellation.move_count() as u64
}

/// Parameters of a leaf's points, row by row, as they are drawn.
pub(super) fn places(tessellation: &Tessellation, item: u32) -> Vec<[f32; 2]> {
    let leaf = &tessellation.leaves[item as usize];
    let n = (1_u32 << leaf.log) + 1;
    let scale = |level: u8| 1.0 / (1_u32 << level) as f32;
    if let Some(list) = scattered(tessellation, leaf) {
        let last = list.points.last().copied().unwrap_or_default();
        let place = |k| list.points.get(k).copied().unwrap_or(last);
        let all = (0..list.rows() * BLOCK_POINTS).map(place);
        return all
            .map(|p| p.map(|k| f32::from(k) * scale(leaf.level)))
            .collect();
    }
    let [x, y] = leaf.start.map(u32::from);
    let all = (0..n).flat_map(|j| (0..n).map(move |i| [x + i, y + j]));
    let mut out: Vec<[f32; 2]> = all
        .map(|at| at.map(|k| k as f32 * scale(leaf.level)))
        .collect();
    for to in tessellation.moves(item as usize) {
        let [i, j] = to.at.map(u32::from);
        out[(j * n + i) as usize] = to.to.map(|k| f32::from(k) * scale(leaf.reach));
    }
    if is_half(tessellation, leaf) {
        for j in 1..n {
            let p = out[(j * n + j) as usize];
            (0..j).for_each(|i| out[(j * n + i) as usize] = p);
        }
    }
    out
}

/// Points whose convex hull holds a leaf; of a displaced one, wherever its displacement may move it.
pub(super) fn hull(
    surface: &Surface,
    tessellation: &Tessellation,
    item: u32,
    scratch: &mut SourceScratch,
    out: &mut Vec<[f32; 3]>,
) {
    let leaf = &tessellation.leaves[item as usize];
    let displaced = surface.displacement().is_some();
    if let Some(list) = scattered(tessellation, leaf) {
        if displaced {
            return drawn_box(surface, tessellation, item, scratch, out);
        }
        // Triangles are flat: nothing is outside of the hull of their points.
        scratch.prepare(surface, leaf.quad, u32::from(leaf.reach), Sides::Points);
        let SourceScratch { patch, spare, .. } = scratch;
        for &place in &list.points {
            let one = Part {
                level: u32::from(leaf.level),
                start: place.map(u32::from),
                segments: 0,
            };
            patch.dice_part(surface, one, &mut spare.first, None);
            out.push(spare.first.get(0, 0));
        }
        return;
    }
    let reach = u32::from(leaf.reach);
    if displaced {
        scratch.prepare_part_hulls(surface, leaf.quad, reach);
        let patch = &scratch.patch;
        patch.displaced_hull(surface, part(leaf), |p| out.push(p));
    } else {
        scratch.prepare(surface, leaf.quad, reach, Sides::None);
        scratch.patch.part_hull(part(leaf), |p| out.push(p));
    }
    let mut last = None;
    for &to in tessellation.moves(item as usize) {
        if inside(leaf, to).is_none() && last != Some(to.to) {
            let SourceScratch { patch, spare, .. } = &mut *scratch;
            if displaced {
                patch.displaced_hull(surface, target(leaf, to), |p| out.push(p));
            } else {
                patch.dice_part(surface, target(leaf, to), &mut spare.first, None);
                out.push(spare.first.get(0, 0));
            }
            last = Some(to.to);
        }
    }
}

/// Corners of the box of what is drawn of a leaf, which no bound of a displacement comes close to.
pub(super) fn drawn_box(
    surface: &Surface,
    tessellation: &Tessellation,
    item: u32,
    scratch: &mut SourceScratch,
    out: &mut Vec<[f32; 3]>,
) {
    let mut points = scratch.spare.hull.take().unwrap_or_else(Grid3::boxed);
    dice(surface, tessellation, item, scratch, &mut points, None);
    let size = block_size(tessellation, item);
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for k in size.indices() {
        let p = points.at(k);
        low = [0, 1, 2].map(|k| low[k].min(p[k]));
        high = [0, 1, 2].map(|k| high[k].max(p[k]));
    }
    scratch.spare.hull = Some(points);
    out.extend(math::box_corners(low, high));
}

/// Dices a leaf: points, and what shading needs where asked for.
pub(super) fn dice(
    surface: &Surface,
    tessellation: &Tessellation,
    item: u32,
    scratch: &mut SourceScratch,
    points: &mut Grid3,
    attributes: Option<(&mut Attributes, bool)>,
) {
    let leaf = &tessellation.leaves[item as usize];
    let moves = tessellation.moves(item as usize);
    // Dicing folds what it dices; moved points are folded here.
    let half = is_half(tessellation, leaf) && !moves.is_empty();
    let folded = |grid: &mut Grid3| {
        if half {
            fold(leaf, grid);
        }
    };
    let reach = u32::from(leaf.reach);
    let list = scattered(tessellation, leaf);
    let lay = |grid: &mut Grid3,
               mut other: Option<&mut Grid3>,
               spare: &mut Spare,
               dice: &dyn Fn(Part, &mut Grid3, Option<&mut Grid3>)| {
        if let Some(list) = list {
            return scatter(leaf, list, grid, other, spare, dice);
        }
        dice(part(leaf), grid, other.as_deref_mut());
        apply(leaf, moves, grid, other, spare, dice);
    };
    let Some((a, wants_tangents)) = attributes else {
        scratch.prepare(surface, leaf.quad, reach, Sides::Points);
        let SourceScratch { patch, spare, .. } = scratch;
        lay(points, None, spare, &|part, p, n| {
            patch.dice_part(surface, part, p, n);
        });
        folded(points);
        return;
    };
    scratch.prepare(surface, leaf.quad, reach, Sides::Normals);
    let SourceScratch { patch, spare, .. } = scratch;
    lay(points, Some(&mut *a.normals), spare, &|part, p, n| {
        patch.dice_part(surface, part, p, n);
    });
    folded(points);
    folded(&mut a.normals);
    if a.wants_uvs && !patch.has_uvs() {
        patch.prepare_uvs(surface, leaf.quad);
    }
    a.has_uvs = a.wants_uvs && patch.has_uvs();
    if a.has_uvs {
        lay(&mut a.uvs, None, spare, &|part, p, _| {
            patch.dice_part_uvs(part, p);
        });
        folded(&mut a.uvs);
    }
    a.has_tangents = a.has_uvs && wants_tangents;
    if a.has_tangents {
        let [first, second] = &mut a.tangents;
        lay(first, Some(second), spare, &|part, p, q| {
            if let Some(q) = q {
                patch.dice_tangents(surface, part, p, q);
            }
        });
        folded(first);
        folded(second);
    }
    a.has_colors = patch.prepare_colors(surface, leaf.quad);
    if a.has_colors {
        lay(&mut a.colors, None, spare, &|part, p, _| {
            patch.dice_part_colors(part, p);
        });
        folded(&mut a.colors);
    }
}
