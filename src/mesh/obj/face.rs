//! Faces: indices, corners, and which faces are kept.
//!
//! A corner is `v`, `v/vt`, `v//vn` or `v/vt/vn`; slots behind the first may be empty. Indices count from 1, or back from the last element
//! before the face; those counted from 1 may point ahead. All must be there. A face that names a vertex twice is kept as long as three
//! different ones are left, and what its edges mean is up to the topology.

use super::diag::{QUOTE_LIMIT, WarningKind, escape};
use super::number::integer;
use super::parse::{Fault, Parser, pad, push};
use crate::mesh::NONE;

impl Parser<'_> {
    /// The next index as a 0-based number. `seen` of its kind come before this place, `total` are in the file.
    #[inline]
    fn index(&mut self, what: &str, seen: usize, total: usize) -> Result<u32, Fault> {
        if let Some((value, end)) = integer(self.cur.s, self.cur.at) {
            if value > 0 && value as u64 <= total as u64 {
                self.cur.at = end;
                return Ok((value - 1) as u32);
            }
            if value < 0 && value.unsigned_abs() <= seen as u64 {
                self.cur.at = end;
                return Ok((seen as u64 - value.unsigned_abs()) as u32);
            }
        }
        Err(self.bad_index(what, seen, total))
    }

    #[cold]
    fn bad_index(&mut self, what: &str, seen: usize, total: usize) -> Fault {
        let at = self.cur.at;
        let word = self.cur.word();
        let slot = word.split(|&b| b == b'/').next().unwrap_or_default();
        let quoted = escape(slot, QUOTE_LIMIT);
        let message = match integer(slot, 0) {
            Some((value, end)) if end == slot.len() => match value {
                0 => format!("{what} index 0; indices count from 1"),
                1.. => format!("{what} index {quoted}, but the file has {total}"),
                _ => format!("relative {what} index {quoted}, but only {seen} come before"),
            },
            _ => format!("'{quoted}' is not a {what} index"),
        };
        self.fault(at, message)
    }

    pub(super) fn face(&mut self) -> Result<(), Fault> {
        let number = self.before.faces;
        self.before.faces += 1;
        let line = self.cur.at;
        let start = self.out.corner_vertices.len();
        while !self.cur.at_end() {
            let token = self.cur.at;
            let vertex = self.index("vertex", self.before.vertices, self.total.vertices)?;
            let (mut uv, mut normal) = (NONE, NONE);
            if self.cur.peek() == b'/' {
                self.cur.at += 1;
                if self.cur.peek() != b'/' && !self.cur.at_separator() {
                    uv = self.index("texture coordinate", self.before.uvs, self.total.uvs)?;
                }
                if self.cur.peek() == b'/' {
                    self.cur.at += 1;
                    if !self.cur.at_separator() {
                        normal = self.index("normal", self.before.normals, self.total.normals)?;
                    }
                }
            }
            if !self.cur.at_separator() {
                self.cur.at = token;
                let quoted = escape(self.cur.word(), QUOTE_LIMIT);
                return Err(self.fault(token, format!("'{quoted}' is not a corner of a face")));
            }
            self.corner(vertex, uv, normal)
                .map_err(|()| self.memory())?;
        }
        self.end_face(line, number, start)
    }

    #[inline]
    fn corner(&mut self, vertex: u32, uv: u32, normal: u32) -> Result<(), ()> {
        let out = &mut self.out;
        let before = out.corner_vertices.len();
        push(&mut out.corner_vertices, vertex)?;
        for (value, list) in [(uv, &mut out.corner_uvs), (normal, &mut out.corner_normals)] {
            if value != NONE {
                if list.len() != before {
                    pad(list, before, NONE)?;
                }
                push(list, value)?;
            }
        }
        Ok(())
    }

    /// Keeps or drops the face whose corners begin at `start`.
    #[inline]
    fn end_face(&mut self, line: usize, number: usize, start: usize) -> Result<(), Fault> {
        let corners = &self.out.corner_vertices[start..];
        let distinct = distinct(corners);
        let n = corners.len();
        let end = start + n;
        if distinct < n || n < 3 {
            let at = self.base + line;
            if n < 3 {
                self.out.note(WarningKind::ShortFace, at, || {
                    format!("face with {n} corners left out")
                });
            } else if distinct < 3 {
                self.out.note(WarningKind::CollapsedFace, at, || {
                    format!("face with {distinct} different corners left out")
                });
            } else {
                self.out.note(WarningKind::RepeatedVertex, at, || {
                    "face with a vertex twice".into()
                });
            }
            if distinct < 3 {
                let out = &mut self.out;
                out.corner_vertices.truncate(start);
                out.corner_uvs.truncate(start);
                out.corner_normals.truncate(start);
                return push(&mut self.out.dropped, number as u32).map_err(|()| self.memory());
            }
        }
        if end >= NONE as usize {
            return Err(self.too_large());
        }
        push(&mut self.out.face_ends, end as u32).map_err(|()| self.memory())
    }
}

/// How many different vertices a face has.
#[inline]
fn distinct(corners: &[u32]) -> usize {
    if let [a, b, c, d] = *corners
        && a != b
        && a != c
        && a != d
        && b != c
        && b != d
        && c != d
    {
        return 4;
    }
    if corners.len() <= 8 {
        return (0..corners.len())
            .filter(|&i| !corners[..i].contains(&corners[i]))
            .count();
    }
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    sorted.len()
}
