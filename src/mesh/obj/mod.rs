//! OBJ text with OpenSubdiv's tags to a [`Cage`].
//!
//! The reader is our own because vertex numbers must stay what the file says (tags name them), one cage must stay one cage over
//! objects, groups and materials, and errors must name the line. It works on bytes: cut at line ends, count, parse the pieces in
//! parallel on the pool of the caller, put them together. What is accepted is stated where it is decided: `lex` for text, `number`
//! for numbers, `parse` for geometry, `tags` for tags, `mesh::mtl` for materials.
//!
//! Time is linear in the file's length, memory in what it really holds; declared counts are never trusted. Sums over the file are
//! reported in [`Report`], oddities in [`Warning`]s, one per kind.

mod diag;
mod face;
mod lex;
mod merge;
mod number;
mod parse;
mod scan;
mod sniff;
mod tags;

use rayon::prelude::*;

pub use diag::{QUOTE_LIMIT, ReadError, ReadErrorKind, Warning, WarningKind, escape};
use lex::LineCounter;
pub(in crate::mesh) use merge::text as lossless_text;
use merge::{MergeError, Merged};
use parse::{Fault, Note, Parser, Piece, Slots, Span};
use scan::Counts;

use super::resolver::Resolver;
use super::{Cage, mtl};

/// UTF-8's byte-order mark.
const BOM: &[u8] = b"\xef\xbb\xbf";

/// Which axis of the file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// Coordinates are taken as they are.
    #[default]
    Y,
    /// The cage is turned so that its z axis becomes y: (x, y, z) becomes (x, z, −y).
    Z,
}

impl UpAxis {
    fn turn(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, z, -y],
        }
    }
}

/// How to read; start from [`ReadOptions::default`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// Most bytes the cage and the working memory of the reader may take, beside the file itself.
    pub max_bytes: u64,
    /// About how many bytes one thread takes at a time. The result does not depend on it.
    pub chunk_bytes: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            up: UpAxis::Y,
            max_bytes: u64::MAX,
            chunk_bytes: 1 << 20,
        }
    }
}

/// A cage and what is to be said about its file.
#[derive(Clone, Debug)]
pub struct Read {
    /// The cage.
    pub cage: Cage,
    /// Oddities, in the order of their lines; those of material libraries last.
    pub warnings: Vec<Warning>,
    /// What was found.
    pub report: Report,
}

/// Sums over the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Report {
    /// Length of the file.
    pub bytes: usize,
    /// Positions (`v`).
    pub vertices: usize,
    /// Texture coordinates (`vt`).
    pub uvs: usize,
    /// Normals (`vn`).
    pub normals: usize,
    /// Faces (`f`), with those that were left out.
    pub faces: usize,
    /// Faces that were left out, by their 0-based number in the file, ascending.
    pub dropped_faces: Vec<u32>,
    /// Group statements (`g`).
    pub groups: usize,
    /// Object statements (`o`).
    pub objects: usize,
    /// Names of the material libraries that were read.
    pub libraries: Vec<String>,
}

/// Reads a cage from the bytes of an OBJ file. `name` is what messages call the file; `resolver` gives material libraries.
///
/// # Errors
/// [`ReadError`] with the line when the text holds what no cage can be made of, or when a budget is exceeded.
pub fn read(
    bytes: &[u8],
    name: &str,
    resolver: &mut dyn Resolver,
    options: &ReadOptions,
) -> Result<Read, ReadError> {
    let data = |what: String| ReadError::new(name, None, ReadErrorKind::Data, what);
    if bytes.is_empty() {
        return Err(data("the file is empty".into()));
    }
    if let Some(what) = sniff::foreign(bytes) {
        return Err(data(format!("not OBJ text; this looks like {what}")));
    }
    // The byte-order mark is dropped; it holds no line end, so lines stay the same.
    let text = bytes.strip_prefix(BOM).unwrap_or(bytes);
    let result = read_text(text, name, resolver, options);
    match result {
        Err(e) if e.kind() == ReadErrorKind::Data && sniff::binary(text) => {
            Err(data("not OBJ text; this looks like binary data".into()))
        }
        other => other,
    }
}

/// Line of a face in the file, counted from 1, given the face's number in the cage. For messages of later stages.
#[must_use]
pub fn line_of_face(bytes: &[u8], report: &Report, face: u32) -> Option<usize> {
    // The n-th kept face: step over the dropped ones at or before it.
    let mut number = face;
    for &dropped in &report.dropped_faces {
        if dropped > number {
            break;
        }
        number += 1;
    }
    let bytes = bytes.strip_prefix(BOM).unwrap_or(bytes);
    let offset = scan::face_offset(bytes, number as usize)?;
    Some(LineCounter::new(bytes).line(offset))
}

fn read_text(
    bytes: &[u8],
    name: &str,
    resolver: &mut dyn Resolver,
    options: &ReadOptions,
) -> Result<Read, ReadError> {
    let error = |kind, what: &str| ReadError::new(name, None, kind, what);
    let memory = || error(ReadErrorKind::Limit, "not enough memory");
    let merge_error = |e| match e {
        MergeError::Memory => memory(),
        MergeError::TooManyCorners => error(
            ReadErrorKind::Limit,
            "more corners than 32-bit indices can name",
        ),
    };

    let cuts = lex::cut(bytes, options.chunk_bytes);
    let counts: Vec<Counts> = cuts
        .par_windows(2)
        .map(|range| scan::count(&bytes[range[0]..range[1]]))
        .collect();
    let mut total = Counts::default();
    for &n in &counts {
        total.add(n);
    }
    let largest = total
        .vertices
        .max(total.uvs)
        .max(total.normals)
        .max(total.faces);
    if largest >= super::NONE as usize {
        return Err(error(
            ReadErrorKind::Limit,
            "more elements than 32-bit indices can name",
        ));
    }
    if total.vertices == 0 {
        return Err(error(ReadErrorKind::Data, "no vertices ('v') in the file"));
    }
    if total.faces == 0 {
        return Err(error(ReadErrorKind::Data, "no faces ('f') in the file"));
    }
    let mut wanted = coordinate_bytes(total);
    // Three corners at least, here and in their piece.
    let least = wanted + 24 * total.faces as u64;
    check_budget(least, options).map_err(|what| error(ReadErrorKind::Limit, &what))?;

    let mut points = zeros(total.vertices).ok_or_else(memory)?;
    let mut uvs = zeros(total.uvs).ok_or_else(memory)?;
    let mut normals = zeros(total.normals).ok_or_else(memory)?;
    let mut pieces = parse_all(
        bytes,
        &cuts,
        &counts,
        total,
        options.up,
        Slots {
            points: &mut points,
            uvs: &mut uvs,
            normals: &mut normals,
        },
    )
    .map_err(|fault| {
        let line = LineCounter::new(bytes).line(fault.at);
        ReadError::new(name, Some(line), fault.kind, fault.what)
    })?;
    wanted += 2 * piece_bytes(&pieces);
    check_budget(wanted, options).map_err(|what| error(ReadErrorKind::Limit, &what))?;
    let notes: Vec<Note> = pieces
        .iter_mut()
        .flat_map(|p| std::mem::take(&mut p.notes))
        .collect();
    let vertices: Vec<usize> = counts.iter().map(|c| c.vertices).collect();
    let Merged {
        mut cage,
        switches,
        libraries,
        dropped,
        groups,
        objects,
        corners_without_uv,
    } = merge::merge(pieces, &vertices).map_err(merge_error)?;
    let mut warnings = place_notes(bytes, name, notes);
    if cage.face_count() == 0 {
        return Err(error(
            ReadErrorKind::Data,
            "no face with three different corners in the file",
        ));
    }
    cage.points = points;
    if !cage.corner_uvs.is_empty() {
        cage.uvs = uvs;
    }
    if !cage.corner_normals.is_empty() {
        cage.normals = normals;
    }
    if corners_without_uv > 0 {
        let what = "a corner without texture coordinates, while others have them";
        warnings.push(
            Warning::new(WarningKind::MissingUvs, name, None, what).times(corners_without_uv),
        );
    }
    if merge::recentre(&mut cage, bytes, &cuts, &counts, options.up).map_err(merge_error)? {
        let what = "so far from the origin that its digits do not hold its shape";
        warnings.push(Warning::new(WarningKind::Precision, name, None, what));
    }

    let faces = cage.face_count();
    let (names, face_materials) =
        merge::assign_materials(bytes, &switches, faces).map_err(merge_error)?;
    cage.face_materials = face_materials;
    let mut lines = LineCounter::new(bytes);
    let libraries = library_names(bytes, &libraries, &mut lines);
    let found = mtl::gather(&names, &libraries, name, resolver, &mut warnings);
    cage.materials = found.materials;

    Ok(Read {
        cage,
        warnings,
        report: Report {
            bytes: bytes.len(),
            vertices: total.vertices,
            uvs: total.uvs,
            normals: total.normals,
            faces: total.faces,
            dropped_faces: dropped,
            groups,
            objects,
            libraries: found.libraries,
        },
    })
}

/// Refuses a file that cannot fit the budget: first by the counts of its statements, before anything is allocated, then by its corners.
fn check_budget(wanted: u64, options: &ReadOptions) -> Result<(), String> {
    let allowed = options.max_bytes;
    if wanted > allowed {
        return Err(format!(
            "needs about {wanted} bytes of memory, {allowed} are allowed"
        ));
    }
    Ok(())
}

/// Bytes for the coordinates, and for the ends of the faces here and in their pieces.
fn coordinate_bytes(total: Counts) -> u64 {
    12 * total.vertices as u64
        + 8 * total.uvs as u64
        + 12 * total.normals as u64
        + 8 * total.faces as u64
}

/// Bytes that the pieces take.
fn piece_bytes(pieces: &[Piece]) -> u64 {
    let of = |p: &Piece| {
        let indices = p.corner_vertices.len() + p.corner_uvs.len() + p.corner_normals.len();
        let tags = p.tags.creases.len() * 12 + p.tags.corners.len() * 8 + p.tags.holes.len() * 4;
        let names = (p.switches.len() + p.libraries.len()) * 24;
        (indices * 4 + tags + names + p.colors.len() * 12) as u64
    };
    pieces.iter().map(of).sum()
}

fn zeros<T: Copy + Default, const N: usize>(n: usize) -> Option<Vec<[T; N]>> {
    let mut list = Vec::new();
    list.try_reserve_exact(n).ok()?;
    list.resize(n, [T::default(); N]);
    Some(list)
}

fn parse_all(
    bytes: &[u8],
    cuts: &[usize],
    counts: &[Counts],
    total: Counts,
    up: UpAxis,
    mut slots: Slots<'_>,
) -> Result<Vec<Piece>, Fault> {
    let mut before = Counts::default();
    let mut jobs = Vec::with_capacity(counts.len());
    for (range, &n) in cuts.windows(2).zip(counts) {
        let s = &bytes[range[0]..range[1]];
        let (points, rest) = std::mem::take(&mut slots.points).split_at_mut(n.vertices);
        slots.points = rest;
        let (uvs, rest) = std::mem::take(&mut slots.uvs).split_at_mut(n.uvs);
        slots.uvs = rest;
        let (normals, rest) = std::mem::take(&mut slots.normals).split_at_mut(n.normals);
        slots.normals = rest;
        let mine = Slots {
            points,
            uvs,
            normals,
        };
        jobs.push((Parser::new(s, range[0], before, total, up), n.faces, mine));
        before.add(n);
    }
    let results: Vec<Result<Piece, Fault>> = jobs
        .into_par_iter()
        .map(|(parser, faces, mine)| parser.run(faces, mine))
        .collect();
    // The first fault in the order of the file, however the pieces were cut and timed.
    results.into_iter().collect()
}

/// Sums notes by kind and gives them lines.
fn place_notes(bytes: &[u8], name: &str, notes: Vec<Note>) -> Vec<Warning> {
    let mut summed: Vec<Note> = Vec::new();
    for note in notes {
        match summed.iter_mut().find(|n| n.kind == note.kind) {
            Some(first) => first.count += note.count,
            None => summed.push(note),
        }
    }
    summed.sort_by_key(|n| n.at);
    let mut lines = LineCounter::new(bytes);
    summed
        .into_iter()
        .map(|n| {
            let line = Some(lines.line(n.at));
            Warning::new(n.kind, name, line, n.what).times(n.count)
        })
        .collect()
}

/// The libraries that the file names, with their lines.
fn library_names(
    bytes: &[u8],
    spans: &[Span],
    lines: &mut LineCounter<'_>,
) -> Vec<(usize, String)> {
    spans
        .iter()
        .map(|&span| {
            (
                lines.line(span.0),
                merge::text(&parse::name_at(bytes, span)),
            )
        })
        .collect()
}
