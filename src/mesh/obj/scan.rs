//! First pass: which statements there are, without reading what they say.

use super::UpAxis;
use super::lex::{Cursor, next_statement};
use super::number::float;

/// What a statement is about.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Statement {
    Vertex,
    Uv,
    Normal,
    Face,
    Empty,
    Other,
}

/// How many statements of each kind there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) vertices: usize,
    pub(super) uvs: usize,
    pub(super) normals: usize,
    pub(super) faces: usize,
}

impl Counts {
    pub(super) fn add(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.uvs += other.uvs;
        self.normals += other.normals;
        self.faces += other.faces;
    }
}

/// Skips the keyword of a statement and says which it is. Of other statements the keyword is left in place.
#[inline]
pub(super) fn statement(cur: &mut Cursor<'_>) -> Statement {
    cur.blanks();
    let start = cur.at;
    let kind = match cur.peek() {
        b'v' => {
            cur.at += 1;
            match cur.peek() {
                b't' => {
                    cur.at += 1;
                    Statement::Uv
                }
                b'n' => {
                    cur.at += 1;
                    Statement::Normal
                }
                _ => Statement::Vertex,
            }
        }
        b'f' => {
            cur.at += 1;
            Statement::Face
        }
        b'\n' | b'\r' | b'#' => return Statement::Empty,
        0 if cur.at >= cur.s.len() => return Statement::Empty,
        _ => return Statement::Other,
    };
    if cur.at_separator() {
        return kind;
    }
    cur.at = start;
    Statement::Other
}

/// First pass: counts the statements of a piece.
pub(super) fn count(s: &[u8]) -> Counts {
    let mut counts = Counts::default();
    let mut cur = Cursor { s, at: 0 };
    while cur.at < s.len() {
        match statement(&mut cur) {
            Statement::Vertex => counts.vertices += 1,
            Statement::Uv => counts.uvs += 1,
            Statement::Normal => counts.normals += 1,
            Statement::Face => counts.faces += 1,
            Statement::Empty | Statement::Other => {}
        }
        cur.at = next_statement(s, cur.at);
    }
    counts
}

/// Positions of a piece once more, in double precision. The first pass over them has found them sound.
pub(super) fn positions(s: &[u8], up: UpAxis, out: &mut [[f64; 3]]) {
    let mut cur = Cursor { s, at: 0 };
    let mut slots = out.iter_mut();
    while cur.at < s.len() {
        if statement(&mut cur) == Statement::Vertex {
            let mut p = [0.0; 3];
            for c in &mut p {
                cur.blanks();
                if let Some((value, end)) = float(s, cur.at) {
                    *c = value;
                    cur.at = end;
                }
            }
            if let Some(slot) = slots.next() {
                *slot = up.turn(p);
            }
        }
        cur.at = next_statement(s, cur.at);
    }
}

/// Where the face statement with this number stands in the file.
pub(super) fn face_offset(s: &[u8], number: usize) -> Option<usize> {
    let mut cur = Cursor { s, at: 0 };
    let mut left = number;
    while cur.at < s.len() {
        if statement(&mut cur) == Statement::Face {
            if left == 0 {
                return Some(cur.at - 1);
            }
            left -= 1;
        }
        cur.at = next_statement(s, cur.at);
    }
    None
}
