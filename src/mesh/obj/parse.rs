//! One piece of the file, in two passes: count its statements, then parse them.
//!
//! The counts of all pieces before give a piece its place in the file: relative indices become global at once, every index is checked
//! where it stands, and coordinates go straight to their place in the final arrays. Pieces share nothing, so they run in parallel and
//! the result does not depend on how the file was cut.

use super::diag::{QUOTE_LIMIT, ReadErrorKind, WarningKind, escape};
use super::lex::{Cursor, next_statement};
use super::number::float;
use super::scan::{Counts, Statement, statement};
use super::tags::TagLists;
use super::{UpAxis, lex};
use crate::mesh::NONE;

/// Why a statement cannot be read, and where. Boxed, so that what can fail returns in registers.
pub(super) type Fault = Box<FaultAt>;

#[derive(Debug)]
pub(super) struct FaultAt {
    /// Offset in the file.
    pub(super) at: usize,
    pub(super) kind: ReadErrorKind,
    pub(super) what: String,
}

/// One kind of warning in one piece.
#[derive(Debug)]
pub(super) struct Note {
    pub(super) kind: WarningKind,
    pub(super) at: usize,
    pub(super) count: usize,
    pub(super) what: String,
}

/// Range of bytes in the file.
pub(super) type Span = (usize, usize);

/// What a piece holds beside its coordinates.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) corner_vertices: Vec<u32>,
    /// Empty, or one per corner.
    pub(super) corner_uvs: Vec<u32>,
    /// Empty, or one per corner.
    pub(super) corner_normals: Vec<u32>,
    /// One past the last corner of each face, counted in this piece.
    pub(super) face_ends: Vec<u32>,
    /// Faces that were left out, by their number in the file.
    pub(super) dropped: Vec<u32>,
    /// From which face of this piece on a material is in use, and where its name stands.
    pub(super) switches: Vec<(u32, Span)>,
    pub(super) libraries: Vec<Span>,
    /// Empty, or one per vertex of the piece.
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) tags: TagLists,
    pub(super) notes: Vec<Note>,
    pub(super) groups: usize,
    pub(super) objects: usize,
}

impl Piece {
    pub(super) fn note(&mut self, kind: WarningKind, at: usize, what: impl FnOnce() -> String) {
        match self.notes.iter_mut().find(|n| n.kind == kind) {
            Some(n) => n.count += 1,
            None => self.notes.push(Note {
                kind,
                at,
                count: 1,
                what: what(),
            }),
        }
    }
}

/// The places of the final arrays that belong to a piece.
pub(super) struct Slots<'a> {
    pub(super) points: &'a mut [[f32; 3]],
    pub(super) uvs: &'a mut [[f32; 2]],
    pub(super) normals: &'a mut [[f32; 3]],
}

/// Second pass over one piece.
pub(super) struct Parser<'a> {
    pub(super) cur: Cursor<'a>,
    /// Offset of the piece in the file.
    pub(super) base: usize,
    /// What stands before this place in the file.
    pub(super) before: Counts,
    /// What the whole file holds.
    pub(super) total: Counts,
    pub(super) out: Piece,
    up: UpAxis,
}

impl<'a> Parser<'a> {
    pub(super) fn new(s: &'a [u8], base: usize, before: Counts, total: Counts, up: UpAxis) -> Self {
        Self {
            cur: Cursor { s, at: 0 },
            base,
            before,
            total,
            out: Piece::default(),
            up,
        }
    }

    /// Parses the piece; the slots are exactly as many as the first pass counted, and so is `faces`.
    pub(super) fn run(mut self, faces: usize, slots: Slots<'_>) -> Result<Piece, Fault> {
        // Quads, most likely; and no corner takes less than two bytes.
        let corners = faces.saturating_mul(4).min(self.cur.s.len() / 2);
        let out = &mut self.out;
        if out.face_ends.try_reserve(faces).is_err()
            || out.corner_vertices.try_reserve(corners).is_err()
        {
            return Err(self.memory());
        }
        let Slots {
            points,
            uvs,
            normals,
        } = slots;
        let vertices_here = points.len();
        let (mut points, mut uvs, mut normals) =
            (points.iter_mut(), uvs.iter_mut(), normals.iter_mut());
        while self.cur.at < self.cur.s.len() {
            match statement(&mut self.cur) {
                Statement::Vertex => {
                    let at = self.cur.at;
                    let p = [self.number("v")?, self.number("v")?, self.number("v")?];
                    if let Some(slot) = points.next() {
                        *slot = self.up.turn(p).map(|c| c as f32);
                    }
                    if !self.cur.at_end() {
                        let index = vertices_here - points.len() - 1;
                        self.vertex_extras(at, index)?;
                    }
                    self.before.vertices += 1;
                }
                Statement::Uv => {
                    let u = self.number("vt")?;
                    let v = if self.cur.at_end() {
                        0.0
                    } else {
                        self.number("vt")?
                    };
                    if !self.cur.at_end() {
                        self.number("vt")?;
                        self.no_more_numbers("vt")?;
                    }
                    if let Some(slot) = uvs.next() {
                        *slot = [u as f32, v as f32];
                    }
                    self.before.uvs += 1;
                }
                Statement::Normal => {
                    let n = [self.number("vn")?, self.number("vn")?, self.number("vn")?];
                    self.no_more_numbers("vn")?;
                    if let Some(slot) = normals.next() {
                        *slot = self.up.turn(n).map(|c| c as f32);
                    }
                    self.before.normals += 1;
                }
                Statement::Face => self.face()?,
                Statement::Empty => {}
                Statement::Other => self.other()?,
            }
            self.cur.at = next_statement(self.cur.s, self.cur.at);
        }
        if !self.out.colors.is_empty() {
            pad(&mut self.out.colors, vertices_here, [1.0; 3]).map_err(|()| self.memory())?;
        }
        let corners = self.out.corner_vertices.len();
        if !self.out.corner_uvs.is_empty() {
            pad(&mut self.out.corner_uvs, corners, NONE).map_err(|()| self.memory())?;
        }
        if !self.out.corner_normals.is_empty() {
            pad(&mut self.out.corner_normals, corners, NONE).map_err(|()| self.memory())?;
        }
        Ok(self.out)
    }

    /// The next number, finite also as `f32`.
    #[inline]
    fn number(&mut self, keyword: &str) -> Result<f64, Fault> {
        self.cur.blanks();
        let at = self.cur.at;
        if let Some((value, end)) = float(self.cur.s, at) {
            self.cur.at = end;
            if self.cur.at_separator() && (value as f32).is_finite() {
                return Ok(value);
            }
        }
        self.cur.at = at;
        Err(self.bad_number(keyword))
    }

    #[cold]
    fn bad_number(&mut self, keyword: &str) -> Fault {
        let at = self.cur.at;
        if self.cur.at_end() {
            return self.fault(at, format!("too few numbers after '{keyword}'"));
        }
        let word = self.cur.word();
        let quoted = escape(word, QUOTE_LIMIT);
        let what = match float(word, 0) {
            Some((_, end)) if end == word.len() => format!("'{quoted}' is out of range"),
            _ => {
                let lower = word.to_ascii_lowercase();
                let bare = lower.strip_prefix(b"-").unwrap_or(&lower);
                if bare.starts_with(b"nan") || bare.starts_with(b"inf") {
                    format!("'{quoted}' is not a finite number")
                } else {
                    format!("'{quoted}' is not a number")
                }
            }
        };
        self.fault(at, what)
    }

    /// What follows a position: a weight, or a colour, which may come after a weight or before an alpha.
    fn vertex_extras(&mut self, at: usize, index: usize) -> Result<(), Fault> {
        let mut extra = [0.0; 4];
        let mut n = 0;
        while !self.cur.at_end() {
            let value = self.number("v")?;
            if n < 4 {
                extra[n] = value;
            }
            n += 1;
        }
        if n == 2 || n > 4 {
            self.extra_numbers("v");
        }
        if n != 3 && n != 4 {
            return Ok(());
        }
        let written = [extra[0], extra[1], extra[2]];
        let color = written.map(|c| c.clamp(0.0, 1.0));
        if color != written {
            let at = self.base + at;
            self.out.note(WarningKind::ColorRange, at, || {
                "vertex colours outside 0 to 1 were clamped".into()
            });
        }
        pad(&mut self.out.colors, index, [1.0; 3]).map_err(|()| self.memory())?;
        push(&mut self.out.colors, color.map(crate::mesh::color::linear))
            .map_err(|()| self.memory())
    }

    fn no_more_numbers(&mut self, keyword: &str) -> Result<(), Fault> {
        if self.cur.at_end() {
            return Ok(());
        }
        while !self.cur.at_end() {
            self.number(keyword)?;
        }
        self.extra_numbers(keyword);
        Ok(())
    }

    fn extra_numbers(&mut self, keyword: &str) {
        let at = self.base + self.cur.at.saturating_sub(1);
        self.out.note(WarningKind::ExtraNumbers, at, || {
            format!("more numbers than '{keyword}' takes; ignored")
        });
    }

    /// Statements other than coordinates and faces.
    fn other(&mut self) -> Result<(), Fault> {
        let at = self.base + self.cur.at;
        let word = self.cur.word();
        match word {
            b"t" => return self.tag(at),
            b"usemtl" => {
                let span = self.rest();
                let face = self.out.face_ends.len() as u32;
                // A switch without faces behind it leaves no trace.
                if let Some(last) = self.out.switches.last_mut().filter(|s| s.0 == face) {
                    last.1 = span;
                } else {
                    push(&mut self.out.switches, (face, span)).map_err(|()| self.memory())?;
                }
            }
            b"mtllib" => {
                let span = self.rest();
                push(&mut self.out.libraries, span).map_err(|()| self.memory())?;
            }
            b"g" => self.out.groups += 1,
            b"o" => self.out.objects += 1,
            b"s" | b"mg" | b"usemap" | b"maplib" | b"shadow_obj" | b"trace_obj" | b"bevel"
            | b"c_interp" | b"d_interp" | b"lod" => {}
            b"l" => self
                .out
                .note(WarningKind::Lines, at, || "line elements skipped".into()),
            b"p" => self
                .out
                .note(WarningKind::Points, at, || "point elements skipped".into()),
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf"
            | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech"
            | b"stech" | b"bsp" | b"bzp" | b"cdc" | b"cdp" | b"res" => {
                self.out.note(WarningKind::FreeForm, at, || {
                    "free-form curves and surfaces skipped".into()
                });
            }
            b"call" | b"csh" => {
                let quoted = escape(word, QUOTE_LIMIT);
                self.out.note(WarningKind::Command, at, || {
                    format!("'{quoted}' is never followed; ignored")
                });
            }
            _ => self.out.note(WarningKind::Unknown, at, || {
                format!("unknown statement '{}' skipped", escape(word, QUOTE_LIMIT))
            }),
        }
        Ok(())
    }

    /// The rest of the statement, as a range of the file.
    fn rest(&self) -> Span {
        let end = next_statement(self.cur.s, self.cur.at);
        (self.base + self.cur.at, self.base + end)
    }

    #[cold]
    pub(super) fn fault(&self, at: usize, what: String) -> Fault {
        Box::new(FaultAt {
            at: self.base + at,
            kind: ReadErrorKind::Data,
            what,
        })
    }

    #[cold]
    pub(super) fn memory(&self) -> Fault {
        Box::new(FaultAt {
            at: self.base + self.cur.at,
            kind: ReadErrorKind::Limit,
            what: "not enough memory".into(),
        })
    }

    #[cold]
    pub(super) fn too_large(&self) -> Fault {
        Box::new(FaultAt {
            at: self.base + self.cur.at,
            kind: ReadErrorKind::Limit,
            what: "more corners than 32-bit indices can name".into(),
        })
    }
}

/// Appends, reporting a failed allocation instead of ending the program.
#[inline]
pub(super) fn push<T>(list: &mut Vec<T>, value: T) -> Result<(), ()> {
    if list.len() == list.capacity() {
        grow(list)?;
    }
    list.push(value);
    Ok(())
}

#[cold]
fn grow<T>(list: &mut Vec<T>) -> Result<(), ()> {
    list.try_reserve(list.len().max(256)).map_err(|_| ())
}

/// Lengthens a list to `len` entries.
pub(super) fn pad<T: Copy>(list: &mut Vec<T>, len: usize, value: T) -> Result<(), ()> {
    if list.len() < len {
        list.try_reserve(len - list.len()).map_err(|_| ())?;
        list.resize(len, value);
    }
    Ok(())
}

/// Names in a statement of the file, as `usemtl` and `mtllib` have them.
pub(super) fn name_at(bytes: &[u8], span: Span) -> std::borrow::Cow<'_, [u8]> {
    lex::names(&bytes[..span.1], span.0)
}
