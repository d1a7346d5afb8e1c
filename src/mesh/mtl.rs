//! Material libraries, read by `tobj` behind a guard.
//!
//! `tobj` gives up a whole library for one bad number, panics on a short colour, and opens any path it finds. So it never sees a file
//! here: bytes come from the [`Resolver`], are cleaned line by line ([`clean`](mod@clean)), and only blocks of materials that the cage uses are
//! handed over, in portions, inside `catch_unwind`. What is damaged is dropped with a warning; the mesh is never lost.

mod clean;

use std::collections::{HashMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::Material;
use super::obj::{QUOTE_LIMIT, Warning, WarningKind, escape};
use super::resolver::{ResolveError, Resolver};
use clean::{clean, finite, split_key, split_options, words};

/// Largest material library.
pub(super) const MAX_LIBRARY_BYTES: u64 = 64 << 20;
/// Most bytes of all libraries of one file together.
pub(super) const MAX_LIBRARY_SUM: u64 = 256 << 20;
/// Most libraries of one file.
pub(super) const MAX_LIBRARIES: usize = 1000;
/// Cleaned text is handed to the parser in portions of about this size.
const PORTION: usize = 1 << 16;

/// Materials found for a cage.
pub(super) struct Gathered {
    /// One for every name, in the same order; unknown ones have default values.
    pub(super) materials: Vec<Material>,
    /// Libraries that were read.
    pub(super) libraries: Vec<String>,
}

/// Finds the materials called `names` in the libraries of the file called `file`. `libraries` are the `mtllib` statements with their
/// lines. A material that is defined twice is the first one.
pub(super) fn gather(
    names: &[String],
    libraries: &[(usize, String)],
    file: &str,
    resolver: &mut dyn Resolver,
    warnings: &mut Vec<Warning>,
) -> Gathered {
    let mut wanted = Wanted::new(names);
    let mut read = Vec::new();
    let mut asked = HashSet::new();
    let mut budget = MAX_LIBRARY_SUM;
    for (line, rest) in libraries {
        if asked.len() >= MAX_LIBRARIES {
            let what =
                format!("more than {MAX_LIBRARIES} material libraries; the others are not read");
            Warning::new(WarningKind::TooManyLibraries, file, Some(*line), what).add_to(warnings);
            continue;
        }
        let mut queue = library_names(rest);
        if queue.is_empty() {
            library_warning(file, *line, rest, "has no name", warnings);
        }
        queue.reverse();
        while let Some(name) = queue.pop() {
            if !asked.insert(name.clone()) {
                continue;
            }
            match resolver.read(&name, MAX_LIBRARY_BYTES.min(budget)) {
                Ok(bytes) => {
                    budget = budget.saturating_sub(bytes.len() as u64);
                    load(&bytes, &name, &mut wanted, warnings);
                    read.push(name);
                }
                // One name with blanks, or several names that do not end in .mtl?
                Err(ResolveError::NotFound)
                    if name.contains(char::is_whitespace) && !is_mtl(&name) =>
                {
                    queue.extend(name.split_whitespace().rev().map(str::to_owned));
                }
                Err(e) => library_warning(file, *line, &name, &e.to_string(), warnings),
            }
        }
    }
    let mut materials = Vec::with_capacity(names.len());
    for (name, found) in names.iter().zip(wanted.found) {
        materials.push(found.unwrap_or_else(|| {
            let quoted = escape(name.as_bytes(), QUOTE_LIMIT);
            let what = format!("material '{quoted}' is not defined; default values used");
            Warning::new(WarningKind::MissingMaterial, file, None, what).add_to(warnings);
            Material {
                name: name.clone(),
                ..Material::default()
            }
        }));
    }
    Gathered {
        materials,
        libraries: read,
    }
}

fn library_warning(file: &str, line: usize, name: &str, why: &str, warnings: &mut Vec<Warning>) {
    let quoted = escape(name.as_bytes(), QUOTE_LIMIT);
    let what = format!("material library '{quoted}': {why}");
    Warning::new(WarningKind::Library, file, Some(line), what).add_to(warnings);
}

fn is_mtl(name: &str) -> bool {
    let n = name.len();
    n >= 4 && name.as_bytes()[n - 4..].eq_ignore_ascii_case(b".mtl")
}

/// Splits the names of an `mtllib` statement: a name ends with a word in `.mtl`, and blanks before that word belong to it.
fn library_names(rest: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut start = None;
    for (at, word) in words(rest) {
        let first = *start.get_or_insert(at);
        if is_mtl(word.trim_matches('"')) {
            names.push(rest[first..at + word.len()].trim_matches('"').to_owned());
            start = None;
        }
    }
    if let Some(first) = start {
        names.push(rest[first..].trim().trim_matches('"').to_owned());
    }
    names.retain(|n| !n.is_empty());
    names
}

/// Names that are looked for, and what was found.
struct Wanted<'a> {
    ids: HashMap<&'a str, usize>,
    found: Vec<Option<Material>>,
    /// Names whose block has been taken.
    taken: Vec<bool>,
}

impl<'a> Wanted<'a> {
    fn new(names: &'a [String]) -> Self {
        Self {
            ids: names
                .iter()
                .enumerate()
                .map(|(i, n)| (n.as_str(), i))
                .collect(),
            found: vec![None; names.len()],
            taken: vec![false; names.len()],
        }
    }
}

/// Reads one library.
fn load(bytes: &[u8], file: &str, wanted: &mut Wanted<'_>, warnings: &mut Vec<Warning>) {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut portion = String::new();
    // Whether the block at hand is of use; before the first `newmtl` there is none.
    let mut block = Block::None;
    let unix_lines = bytes.split(|&b| b == b'\n');
    let lines = unix_lines.flat_map(|l| l.strip_suffix(b"\r").unwrap_or(l).split(|&b| b == b'\r'));
    for (number, line) in lines.enumerate() {
        let line = super::obj::lossless_text(line);
        let Some((key, rest)) = split_key(&line) else {
            continue;
        };
        let mut say = |kind, what: String| {
            Warning::new(kind, file, Some(number + 1), what).add_to(warnings);
        };
        if key == "newmtl" {
            block = start_block(rest, wanted, &mut say);
            if let Block::Wanted = block {
                if portion.len() > PORTION {
                    parse(&portion, wanted);
                    portion.clear();
                }
                portion.push_str(&format!("newmtl {rest}\n"));
            }
            continue;
        }
        match block {
            Block::Wanted => clean(key, rest, &mut portion, &mut say),
            Block::Skipped => {}
            Block::None => say(
                WarningKind::MaterialLine,
                "a line that belongs to no material dropped".into(),
            ),
        }
    }
    parse(&portion, wanted);
}

#[derive(Clone, Copy)]
enum Block {
    None,
    Wanted,
    Skipped,
}

fn start_block(
    name: &str,
    wanted: &mut Wanted<'_>,
    say: &mut impl FnMut(WarningKind, String),
) -> Block {
    if name.is_empty() {
        say(
            WarningKind::MaterialLine,
            "a material without name dropped".into(),
        );
        return Block::Skipped;
    }
    match wanted.ids.get(name) {
        None => Block::Skipped,
        Some(&id) if wanted.taken[id] => {
            let quoted = escape(name.as_bytes(), QUOTE_LIMIT);
            say(
                WarningKind::DuplicateMaterial,
                format!("material '{quoted}' is defined again; the first one counts"),
            );
            Block::Skipped
        }
        Some(&id) => {
            wanted.taken[id] = true;
            Block::Wanted
        }
    }
}

/// Hands cleaned text to the parser and stores what it finds. A panic loses this portion and nothing else.
fn parse(portion: &str, wanted: &mut Wanted<'_>) {
    if portion.is_empty() {
        return;
    }
    let parsed = catch_unwind(AssertUnwindSafe(|| {
        tobj::load_mtl_buf(&mut portion.as_bytes())
    }));
    let Ok(Ok((materials, _))) = parsed else {
        return;
    };
    for m in materials {
        let Some(&id) = wanted.ids.get(m.name.as_str()) else {
            continue;
        };
        let map = |raw: Option<&String>| {
            let (name, _) = split_options(raw?.as_str());
            (!name.is_empty()).then(|| name.to_owned())
        };
        let default = Material::default();
        let transparent = m.unknown_param.get("Tr").and_then(|t| finite(t));
        wanted.found[id] = Some(Material {
            diffuse: m.diffuse.unwrap_or(default.diffuse),
            opacity: m
                .dissolve
                .or(transparent.map(|t| 1.0 - t))
                .unwrap_or(default.opacity),
            diffuse_map: map(m.diffuse_texture.as_ref()),
            opacity_map: map(m.dissolve_texture.as_ref()),
            bump_map: map(m.normal_texture.as_ref()),
            normal_map: map(m.unknown_param.get("norm")),
            displacement_map: map(m.unknown_param.get("disp")),
            name: m.name,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::resolver::MemoryFiles;

    fn one(library: &str) -> (Material, Vec<Warning>) {
        let mut files = MemoryFiles::new().with("a.mtl", library);
        let mut warnings = Vec::new();
        let names = ["m".to_owned()];
        let libraries = [(1, "a.mtl".to_owned())];
        let found = gather(&names, &libraries, "x.obj", &mut files, &mut warnings);
        (found.materials[0].clone(), warnings)
    }

    #[test]
    fn library_statements_are_split() {
        assert_eq!(library_names("a.mtl b.MTL"), ["a.mtl", "b.MTL"]);
        assert_eq!(library_names("my lib.mtl b.mtl"), ["my lib.mtl", "b.mtl"]);
        assert_eq!(library_names("\"my lib.mtl\""), ["my lib.mtl"]);
        assert_eq!(library_names(" plain name "), ["plain name"]);
        assert!(library_names("  ").is_empty());
    }

    #[test]
    fn good_material() {
        let (m, w) = one(
            "newmtl m\nKd 0.25 0.5 1\nd 0.5\nmap_Kd my tex.png\nnorm n.png\nmap_disp d.png\nbump b.png\n",
        );
        assert_eq!(m.diffuse, [0.25, 0.5, 1.0]);
        assert_eq!(m.opacity, 0.5);
        assert_eq!(m.diffuse_map.as_deref(), Some("my tex.png"));
        assert_eq!(m.normal_map.as_deref(), Some("n.png"));
        assert_eq!(m.displacement_map.as_deref(), Some("d.png"));
        assert_eq!(m.bump_map.as_deref(), Some("b.png"));
        assert!(w.is_empty(), "{w:?}");
    }

    #[test]
    fn damaged_lines_cost_only_themselves() {
        for (bad, kind) in [
            ("Kd 1 0", WarningKind::MaterialLine),
            ("Kd", WarningKind::MaterialLine),
            ("Ka 1 0", WarningKind::MaterialLine),
            ("Kd spectral file.rfl", WarningKind::MaterialLine),
            ("Kd nan 0 0", WarningKind::MaterialLine),
            ("Ns many", WarningKind::MaterialLine),
            ("illum x", WarningKind::MaterialLine),
            ("d inf", WarningKind::MaterialLine),
            ("map_Kd", WarningKind::MaterialLine),
            ("map_Kd -s 1 1", WarningKind::MaterialLine),
            ("d 7", WarningKind::MaterialRange),
            ("newmtl", WarningKind::MaterialLine),
        ] {
            let (m, w) = one(&format!("newmtl m\nKd 0 0 1\n{bad}\nnewmtl n\nKd 1 0 0\n"));
            assert_eq!(m.diffuse, [0.0, 0.0, 1.0], "{bad}");
            assert_eq!(w.len(), 1, "{bad}: {w:?}");
            assert_eq!((w[0].kind(), w[0].line()), (kind, Some(3)), "{bad}");
        }
        assert_eq!(one("newmtl m\nKd 0.5\n").0.diffuse, [0.5; 3]);
        assert_eq!(one("newmtl m\nTr 0.25\n").0.opacity, 0.75);
        assert_eq!(one("newmtl m\nd -halo 0.25\n").0.opacity, 0.25);
        assert_eq!(
            one("\u{feff}newmtl m\rKd 1 0 0\r").0.diffuse,
            [1.0, 0.0, 0.0]
        );
    }

    #[test]
    fn first_definition_counts_and_unused_blocks_are_skipped() {
        let (m, w) = one("newmtl x\nKd bad\nnewmtl m\nKd 1 0 0\nnewmtl m\nKd 0 1 0\n");
        assert_eq!(m.diffuse, [1.0, 0.0, 0.0]);
        assert_eq!(w.len(), 1);
        assert_eq!(w[0].kind(), WarningKind::DuplicateMaterial);
    }

    #[test]
    fn every_library_is_read_once_and_a_missing_one_is_a_warning() {
        let mut files = MemoryFiles::new().with("a.mtl", "newmtl m\n");
        let mut warnings = Vec::new();
        let names = ["m".to_owned(), "n".to_owned()];
        let libraries: Vec<_> = (1..100).map(|i| (i, "a.mtl b.mtl".to_owned())).collect();
        let found = gather(&names, &libraries, "x.obj", &mut files, &mut warnings);
        assert_eq!(files.reads(), ["a.mtl", "b.mtl"]);
        assert_eq!(found.libraries, ["a.mtl"]);
        let kinds: Vec<_> = warnings.iter().map(Warning::kind).collect();
        assert_eq!(kinds, [WarningKind::Library, WarningKind::MissingMaterial]);
        assert_eq!(found.materials[1].name, "n");
    }

    #[test]
    fn many_materials_pass_in_portions() {
        let names: Vec<String> = (0..20_000).map(|i| format!("m{i}")).collect();
        let library: String = names
            .iter()
            .rev()
            .map(|n| format!("newmtl {n}\nKd 0.{} 0 0\n", &n[1..]))
            .collect();
        let mut files = MemoryFiles::new().with("a.mtl", library);
        let mut warnings = Vec::new();
        let found = gather(
            &names,
            &[(1, "a.mtl".into())],
            "x.obj",
            &mut files,
            &mut warnings,
        );
        assert!(warnings.is_empty());
        assert_eq!(found.materials[12_345].diffuse[0], 0.12345);
    }
}
