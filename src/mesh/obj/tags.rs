//! OpenSubdiv's tags: `t NAME ints/floats/strings ints… floats… strings…`, with vertex and face numbers from 0.
//!
//! The declared counts say how to split the arguments and nothing else: arguments are stored as they are met, and a count without
//! arguments behind it is an error.

use super::diag::{QUOTE_LIMIT, WarningKind, escape};
use super::number::{float, integer};
use super::parse::{Fault, Parser, push};
use crate::mesh::{Corner, Crease};
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule, INFINITE_SHARPNESS, TriangleRule};

/// Tags of one piece, or of the whole file.
#[derive(Debug, Default)]
pub(super) struct TagLists {
    pub(super) creases: Vec<Crease>,
    pub(super) corners: Vec<Corner>,
    /// By their number in the file, before faces were left out.
    pub(super) holes: Vec<u32>,
    pub(super) boundary: Option<Boundary>,
    pub(super) face_varying: Option<FaceVaryingRule>,
    pub(super) crease_method: Option<CreaseMethod>,
    pub(super) triangles: Option<TriangleRule>,
}

/// Declared numbers of arguments.
struct Declared {
    ints: u64,
    floats: u64,
    strings: u64,
}

impl Parser<'_> {
    /// Parses a tag; the cursor stands behind the `t`, which is at `at` in the file.
    pub(super) fn tag(&mut self, at: usize) -> Result<(), Fault> {
        self.cur.blanks();
        let name = self.cur.word();
        match name {
            b"crease" => self.creases(at)?,
            b"corner" => self.corners(at)?,
            b"hole" => {
                let declared = self.declared()?;
                for _ in 0..declared.ints {
                    let face = self.tag_index("face", self.total.faces)?;
                    push(&mut self.out.tags.holes, face).map_err(|()| self.memory())?;
                }
                self.skip_words(declared.floats)?;
                self.skip_words(declared.strings)?;
            }
            b"interpolateboundary" => {
                let rules = [Boundary::None, Boundary::EdgeAndCorner, Boundary::EdgeOnly];
                let rule = self.choice(&rules)?;
                self.out.tags.boundary = rule.or(self.out.tags.boundary);
            }
            b"facevaryinginterpolateboundary" => {
                let rules = [
                    FaceVaryingRule::None,
                    FaceVaryingRule::CornersOnly,
                    FaceVaryingRule::CornersPlus1,
                    FaceVaryingRule::CornersPlus2,
                    FaceVaryingRule::Boundaries,
                    FaceVaryingRule::All,
                ];
                let rule = self.choice(&rules)?;
                self.out.tags.face_varying = rule.or(self.out.tags.face_varying);
            }
            b"creasemethod" => {
                let names = [
                    (&b"normal"[..], CreaseMethod::Uniform),
                    (b"uniform", CreaseMethod::Uniform),
                    (b"chaikin", CreaseMethod::Chaikin),
                ];
                let method = self.keyword(at, &names)?;
                self.out.tags.crease_method = method.or(self.out.tags.crease_method);
            }
            b"smoothtriangles" => {
                let names = [
                    (&b"catmark"[..], TriangleRule::Catmark),
                    (b"normal", TriangleRule::Catmark),
                    (b"smooth", TriangleRule::Smooth),
                ];
                let rule = self.keyword(at, &names)?;
                self.out.tags.triangles = rule.or(self.out.tags.triangles);
            }
            b"vertexedit" | b"edgeedit" | b"faceedit" => {
                self.out.note(WarningKind::HierarchicalEdit, at, || {
                    "hierarchical edits are ignored".into()
                });
                return Ok(());
            }
            _ => {
                self.out.note(WarningKind::UnknownTag, at, || {
                    format!("unknown tag '{}' ignored", escape(name, QUOTE_LIMIT))
                });
                return Ok(());
            }
        }
        if !self.cur.at_end() {
            self.out.note(WarningKind::ExtraTagArguments, at, || {
                "more arguments than the tag declares; ignored".into()
            });
        }
        Ok(())
    }

    fn creases(&mut self, at: usize) -> Result<(), Fault> {
        let counts_at = self.cur.at;
        let declared = self.declared()?;
        let pairs = declared.ints / 2;
        if declared.ints % 2 != 0 || !fits(pairs, declared.floats) {
            return Err(self.counts_fault(
                counts_at,
                "a crease takes pairs of vertices, and one sharpness or one for each",
            ));
        }
        let first = self.out.tags.creases.len();
        for _ in 0..pairs {
            let a = self.tag_index("vertex", self.total.vertices)?;
            let b = self.tag_index("vertex", self.total.vertices)?;
            let crease = Crease {
                vertices: [a, b],
                sharpness: 0.0,
            };
            push(&mut self.out.tags.creases, crease).map_err(|()| self.memory())?;
        }
        let mut sharpness = 0.0;
        for i in 0..pairs as usize {
            if i == 0 || declared.floats > 1 {
                sharpness = self.sharpness(at)?;
            }
            self.out.tags.creases[first + i].sharpness = sharpness;
        }
        let whole = self.out.tags.creases.len();
        let mut kept = first;
        for i in first..whole {
            let crease = self.out.tags.creases[i];
            if crease.vertices[0] != crease.vertices[1] {
                self.out.tags.creases[kept] = crease;
                kept += 1;
            }
        }
        self.out.tags.creases.truncate(kept);
        for _ in kept..whole {
            self.out.note(WarningKind::CollapsedCrease, at, || {
                "crease from a vertex to itself ignored".into()
            });
        }
        self.skip_words(declared.strings)
    }

    fn corners(&mut self, at: usize) -> Result<(), Fault> {
        let counts_at = self.cur.at;
        let declared = self.declared()?;
        if !fits(declared.ints, declared.floats) {
            return Err(self.counts_fault(
                counts_at,
                "a corner takes vertices, and one sharpness or one for each",
            ));
        }
        let first = self.out.tags.corners.len();
        for _ in 0..declared.ints {
            let vertex = self.tag_index("vertex", self.total.vertices)?;
            let corner = Corner {
                vertex,
                sharpness: 0.0,
            };
            push(&mut self.out.tags.corners, corner).map_err(|()| self.memory())?;
        }
        let mut sharpness = 0.0;
        for i in 0..declared.ints as usize {
            if i == 0 || declared.floats > 1 {
                sharpness = self.sharpness(at)?;
            }
            self.out.tags.corners[first + i].sharpness = sharpness;
        }
        self.skip_words(declared.strings)
    }

    /// A tag with one number that picks one of `rules`.
    fn choice<T: Copy>(&mut self, rules: &[T]) -> Result<Option<T>, Fault> {
        let counts_at = self.cur.at;
        let declared = self.declared()?;
        if declared.ints == 0 {
            return Err(self.counts_fault(counts_at, "the tag takes one whole number"));
        }
        let rule = self.tag_number("value", rules.len())?;
        self.skip_words(declared.ints - 1)?;
        self.skip_words(declared.floats)?;
        self.skip_words(declared.strings)?;
        Ok(rules.get(rule as usize).copied())
    }

    /// A tag with one word that picks one of `names`; an unknown word is noted.
    fn keyword<T: Copy>(&mut self, at: usize, names: &[(&[u8], T)]) -> Result<Option<T>, Fault> {
        let counts_at = self.cur.at;
        let declared = self.declared()?;
        if declared.strings == 0 {
            return Err(self.counts_fault(counts_at, "the tag takes one word"));
        }
        self.skip_words(declared.ints)?;
        self.skip_words(declared.floats)?;
        if self.cur.at_end() {
            return Err(self.too_few_arguments());
        }
        let word = self.cur.word();
        self.skip_words(declared.strings - 1)?;
        let found = names.iter().find(|n| n.0 == word).map(|n| n.1);
        if found.is_none() {
            self.out.note(WarningKind::UnknownTag, at, || {
                format!(
                    "unknown option '{}' of a tag ignored",
                    escape(word, QUOTE_LIMIT)
                )
            });
        }
        Ok(found)
    }

    /// The counts `ints/floats/strings`; missing ones are 0.
    fn declared(&mut self) -> Result<Declared, Fault> {
        self.cur.blanks();
        let at = self.cur.at;
        let word = self.cur.word();
        let mut counts = [0_u64; 3];
        let mut slots = word.split(|&b| b == b'/');
        for (count, slot) in counts.iter_mut().zip(&mut slots) {
            match integer(slot, 0) {
                Some((value, end)) if end == slot.len() && value >= 0 => {
                    *count = value.unsigned_abs();
                }
                _ => return Err(self.bad_counts(at, word)),
            }
        }
        if slots.next().is_some() {
            return Err(self.bad_counts(at, word));
        }
        let [ints, floats, strings] = counts;
        Ok(Declared {
            ints,
            floats,
            strings,
        })
    }

    fn bad_counts(&self, at: usize, word: &[u8]) -> Fault {
        let quoted = escape(word, QUOTE_LIMIT);
        self.fault(
            at,
            format!("'{quoted}' does not count a tag's arguments (ints/floats/strings)"),
        )
    }

    fn counts_fault(&self, at: usize, what: &str) -> Fault {
        self.fault(at, what.to_owned())
    }

    fn too_few_arguments(&self) -> Fault {
        self.fault(
            self.cur.at,
            "fewer arguments than the tag declares".to_owned(),
        )
    }

    /// A vertex or face number from 0.
    fn tag_index(&mut self, what: &str, total: usize) -> Result<u32, Fault> {
        self.tag_number(what, total)
    }

    fn tag_number(&mut self, what: &str, total: usize) -> Result<u32, Fault> {
        if self.cur.at_end() {
            return Err(self.too_few_arguments());
        }
        let at = self.cur.at;
        let word = self.cur.word();
        let number = integer(word, 0).filter(|&(_, end)| end == word.len());
        if let Some((value, _)) = number
            && value >= 0
            && value.unsigned_abs() < total as u64
        {
            return Ok(value as u32);
        }
        let quoted = escape(word, QUOTE_LIMIT);
        let message = match (number, what) {
            (None, _) => format!("'{quoted}' is not a whole number"),
            (_, "value") => format!("{quoted} is not one of 0 to {}", total - 1),
            _ => format!(
                "{what} {quoted} in a tag, where they count from 0, but the file has {total}"
            ),
        };
        Err(self.fault(at, message))
    }

    fn sharpness(&mut self, tag_at: usize) -> Result<f32, Fault> {
        if self.cur.at_end() {
            return Err(self.too_few_arguments());
        }
        let at = self.cur.at;
        let word = self.cur.word();
        let bare = word.strip_prefix(b"+").unwrap_or(word);
        if bare.eq_ignore_ascii_case(b"inf") || bare.eq_ignore_ascii_case(b"infinity") {
            return Ok(INFINITE_SHARPNESS);
        }
        let value = match float(word, 0) {
            Some((value, end)) if end == word.len() => value,
            _ => {
                let quoted = escape(word, QUOTE_LIMIT);
                return Err(self.fault(at, format!("'{quoted}' is not a sharpness")));
            }
        };
        if value < 0.0 {
            self.out.note(WarningKind::NegativeSharpness, tag_at, || {
                "negative sharpness taken as 0".into()
            });
            return Ok(0.0);
        }
        let value = value as f32;
        Ok(if value.is_finite() {
            value
        } else {
            INFINITE_SHARPNESS
        })
    }

    fn skip_words(&mut self, n: u64) -> Result<(), Fault> {
        for _ in 0..n {
            if self.cur.at_end() {
                return Err(self.too_few_arguments());
            }
            self.cur.word();
        }
        Ok(())
    }
}

/// Whether `floats` values serve `items`: none for none, one for all, or one for each.
fn fits(items: u64, floats: u64) -> bool {
    if items == 0 {
        floats == 0
    } else {
        floats == 1 || floats == items
    }
}
