//! Pieces to one cage: concatenation, material and hole numbers, and the origin.

use rayon::prelude::*;

use super::parse::{Piece, Span, name_at, pad, push};
use super::scan::positions;
use super::{Counts, UpAxis};
use crate::mesh::{Cage, Corner, Crease, NONE};

/// Runs of faces with their material names, and what else is left of the pieces.
#[derive(Default)]
pub(super) struct Merged {
    pub(super) cage: Cage,
    /// First face of each run and where the name of its material stands; faces before the first run have none.
    pub(super) switches: Vec<(u32, Span)>,
    pub(super) libraries: Vec<Span>,
    /// Faces that were left out, by their number in the file, ascending.
    pub(super) dropped: Vec<u32>,
    pub(super) groups: usize,
    pub(super) objects: usize,
    /// Corners without texture coordinates in a cage that has some.
    pub(super) corners_without_uv: usize,
}

/// Why pieces do not make one cage.
pub(super) enum MergeError {
    Memory,
    TooManyCorners,
}

/// Puts the pieces together, in their order. Coordinates are in place already and are not touched here.
pub(super) fn merge(pieces: Vec<Piece>, vertices: &[usize]) -> Result<Merged, MergeError> {
    let mut out = Merged::default();
    let corners: usize = pieces.iter().map(|p| p.corner_vertices.len()).sum();
    let faces: usize = pieces.iter().map(|p| p.face_ends.len()).sum();
    if corners >= NONE as usize {
        return Err(MergeError::TooManyCorners);
    }
    let memory = |()| MergeError::Memory;
    let cage = &mut out.cage;
    cage.corner_vertices = joined(&pieces, corners, |p| {
        (&p.corner_vertices, p.corner_vertices.len())
    })?;
    for (list, pick) in [
        (
            &mut cage.corner_uvs,
            (|p| &p.corner_uvs) as fn(&Piece) -> &Vec<u32>,
        ),
        (&mut cage.corner_normals, |p| &p.corner_normals),
    ] {
        if pieces.iter().any(|p| !pick(p).is_empty()) {
            *list = joined(&pieces, corners, |p| (pick(p), p.corner_vertices.len()))?;
        }
    }
    out.corners_without_uv = cage.corner_uvs.par_iter().filter(|&&i| i == NONE).count();
    cage.face_offsets
        .try_reserve_exact(faces + 1)
        .map_err(|_| MergeError::Memory)?;
    cage.face_offsets.push(0);
    let has_colors = pieces.iter().any(|p| !p.colors.is_empty());
    let (mut corner_base, mut face_base) = (0_u32, 0_u32);
    let mut vertex_end = 0;
    for (piece, &n) in pieces.into_iter().zip(vertices) {
        cage.face_offsets
            .extend(piece.face_ends.iter().map(|&e| e + corner_base));
        for (face, span) in piece.switches {
            push(&mut out.switches, (face + face_base, span)).map_err(memory)?;
        }
        append(&mut out.libraries, piece.libraries)?;
        append(&mut out.dropped, piece.dropped)?;
        vertex_end += n;
        if has_colors {
            append(&mut cage.colors, piece.colors)?;
            pad(&mut cage.colors, vertex_end, [1.0; 3]).map_err(memory)?;
        }
        let (tags, more) = (&mut cage.tags, piece.tags);
        append::<Crease>(&mut tags.creases, more.creases)?;
        append::<Corner>(&mut tags.corners, more.corners)?;
        append(&mut tags.holes, more.holes)?;
        tags.boundary = more.boundary.or(tags.boundary);
        tags.face_varying = more.face_varying.or(tags.face_varying);
        tags.crease_method = more.crease_method.or(tags.crease_method);
        tags.triangles = more.triangles.or(tags.triangles);
        out.groups += piece.groups;
        out.objects += piece.objects;
        corner_base += piece.corner_vertices.len() as u32;
        face_base += piece.face_ends.len() as u32;
    }
    renumber_holes(&mut cage.tags.holes, &out.dropped);
    Ok(out)
}

fn append<T>(list: &mut Vec<T>, more: Vec<T>) -> Result<(), MergeError> {
    if list.is_empty() {
        *list = more;
        return Ok(());
    }
    list.try_reserve(more.len())
        .map_err(|_| MergeError::Memory)?;
    list.extend(more);
    Ok(())
}

/// One list of all pieces, copied in parallel. A piece whose list is empty stands for as many [`NONE`] as it has corners.
fn joined<'a>(
    pieces: &'a [Piece],
    len: usize,
    pick: impl Fn(&'a Piece) -> (&'a Vec<u32>, usize) + Sync,
) -> Result<Vec<u32>, MergeError> {
    let mut out = Vec::new();
    out.try_reserve_exact(len).map_err(|_| MergeError::Memory)?;
    out.resize(len, NONE);
    let mut rest = &mut out[..];
    let mut jobs = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let (list, n) = pick(piece);
        let (head, tail) = rest.split_at_mut(n);
        rest = tail;
        if !list.is_empty() {
            jobs.push((list, head));
        }
    }
    jobs.into_par_iter()
        .for_each(|(from, to)| to.copy_from_slice(from));
    Ok(out)
}

/// Tags count the faces of the file, the cage only those that were kept.
fn renumber_holes(holes: &mut Vec<u32>, dropped: &[u32]) {
    if dropped.is_empty() {
        return;
    }
    holes.retain_mut(|face| match dropped.binary_search(face) {
        Ok(_) => false,
        Err(before) => {
            *face -= before as u32;
            true
        }
    });
}

/// Material names in the order of first use, and per face the number of its material.
pub(super) fn assign_materials(
    bytes: &[u8],
    switches: &[(u32, Span)],
    faces: usize,
) -> Result<(Vec<String>, Vec<u32>), MergeError> {
    let mut names: Vec<String> = Vec::new();
    let mut ids = std::collections::HashMap::new();
    let mut list = Vec::new();
    for (i, &(first, span)) in switches.iter().enumerate() {
        let end = switches.get(i + 1).map_or(faces, |next| next.0 as usize);
        if end <= first as usize {
            continue;
        }
        let name = name_at(bytes, span);
        let id = if name.is_empty() {
            NONE
        } else if let Some(&id) = ids.get(&name) {
            id
        } else {
            let id = names.len() as u32;
            push(&mut names, text(&name)).map_err(|()| MergeError::Memory)?;
            ids.insert(name, id);
            id
        };
        if list.is_empty() {
            list.try_reserve_exact(faces)
                .map_err(|_| MergeError::Memory)?;
            list.resize(first as usize, NONE);
        }
        list.resize(end, id);
    }
    if names.is_empty() {
        list = Vec::new();
    }
    Ok((names, list))
}

/// A name of the file as text: UTF-8, else Latin-1, so that different bytes stay different names.
pub(in crate::mesh) fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// Cages further from the origin than this many radii are moved there before rounding to `f32`.
const FAR: f64 = 16.0;
/// Beyond this many radii the text's own 16 digits do not hold the shape any more.
const LOST: f64 = 1e12;

/// Moves a cage that lies far from the origin next to it; says whether the shape is lost even in double precision.
///
/// Only vertices that belong to a face count: a stray vertex changes nothing.
pub(super) fn recentre(
    cage: &mut Cage,
    bytes: &[u8],
    cuts: &[usize],
    counts: &[Counts],
    up: UpAxis,
) -> Result<bool, MergeError> {
    let points = &cage.points;
    let [lo, hi] = bounds(&cage.corner_vertices, |v| points[v as usize].map(f64::from));
    let (centre, radius) = ball(lo, hi);
    if length(centre) <= FAR * radius {
        return Ok(false);
    }
    let mut exact: Vec<[f64; 3]> = Vec::new();
    exact
        .try_reserve_exact(points.len())
        .map_err(|_| MergeError::Memory)?;
    exact.resize(points.len(), [0.0; 3]);
    let mut rest = &mut exact[..];
    let mut jobs = Vec::with_capacity(counts.len());
    for (range, n) in cuts.windows(2).zip(counts) {
        let (head, tail) = rest.split_at_mut(n.vertices);
        rest = tail;
        jobs.push((&bytes[range[0]..range[1]], head));
    }
    jobs.into_par_iter()
        .for_each(|(s, out)| positions(s, up, out));
    let [lo, hi] = bounds(&cage.corner_vertices, |v| exact[v as usize]);
    let (centre, radius) = ball(lo, hi);
    if length(centre) <= FAR * radius {
        return Ok(false);
    }
    cage.origin = centre;
    cage.points.par_iter_mut().zip(&exact).for_each(|(p, e)| {
        for k in 0..3 {
            // A stray vertex may be too far away for its difference; it is clamped, nobody draws it.
            p[k] = ((e[k] - centre[k]) as f32).clamp(-f32::MAX, f32::MAX);
        }
    });
    Ok(length(centre) > LOST * radius && radius > 0.0)
}

fn bounds(corners: &[u32], point: impl Fn(u32) -> [f64; 3] + Sync) -> [[f64; 3]; 2] {
    let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    // Smallest and largest do not depend on the order of comparison, so threads may split this as they like.
    corners
        .par_chunks(1 << 16)
        .map(|part| {
            part.iter().fold(empty, |b, &v| {
                let p = point(v);
                join(b, [p, p])
            })
        })
        .reduce(|| empty, join)
}

fn join(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    let mut out = a;
    for k in 0..3 {
        // Plus zero makes one zero of both, whichever came first.
        out[0][k] = a[0][k].min(b[0][k]) + 0.0;
        out[1][k] = a[1][k].max(b[1][k]) + 0.0;
    }
    out
}

fn ball(lo: [f64; 3], hi: [f64; 3]) -> ([f64; 3], f64) {
    let centre = [0, 1, 2].map(|k| 0.5 * (lo[k] + hi[k]));
    (centre, 0.5 * length([0, 1, 2].map(|k| hi[k] - lo[k])))
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}
