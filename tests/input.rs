//! Bad and odd inputs, over all classes that files can fall into, each with the outcome that is promised for it.
//!
//! Every case is made here, in memory or in a folder that goes away. What is never allowed, whatever the case: a panic, an error
//! without a message, a wrong line, control characters or much text in a message.

#[path = "common/folder.rs"]
mod folder;
#[path = "input/folders.rs"]
mod folders;
#[path = "input/materials.rs"]
mod materials;
#[path = "input/memory.rs"]
mod memory;
#[path = "input/records.rs"]
mod records;
#[path = "input/text.rs"]
mod text;

use std::panic::{AssertUnwindSafe, catch_unwind};

use earmark::mesh::obj::{Read, ReadOptions, read};
use earmark::mesh::{MemoryFiles, ReadError, ReadErrorKind, Resolver, WarningKind};

/// Four vertices, so that cases can be short.
const V: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// What must come of a case.
#[derive(Debug)]
enum Want {
    /// An error at this line (0: without line) whose text holds this.
    Error(usize, &'static str),
    /// A cage, and exactly one warning: of this kind, at this line (0: without line).
    Warn(WarningKind, usize),
    /// A cage with so many faces and no warning.
    Render(usize),
    /// A cage or a clean error: anything but a fault.
    Clean,
}
use Want::{Clean, Error, Render, Warn};

fn run(bytes: &[u8], files: &mut dyn Resolver) -> Result<Read, ReadError> {
    let options = ReadOptions {
        max_bytes: 1 << 30,
        ..ReadOptions::default()
    };
    catch_unwind(AssertUnwindSafe(|| {
        read(bytes, "case.obj", files, &options)
    }))
    .unwrap_or_else(|_| panic!("panicked on {}", excerpt(bytes)))
}

fn excerpt(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned()
}

/// What a program would print, checked for what no output may hold.
fn printed(result: &Result<Read, ReadError>) -> String {
    let text: String = match result {
        Ok(found) => found.warnings.iter().map(|w| format!("{w}\n")).collect(),
        Err(e) => format!("{e}\n"),
    };
    assert!(text.len() <= 64 << 10, "{} bytes of messages", text.len());
    for line in text.lines() {
        assert!(!line.chars().any(char::is_control), "{line:?}");
        assert!(
            !line.contains(['\u{2028}', '\u{2029}', '\u{202e}']),
            "{line:?}"
        );
        assert!(line.len() < 1000, "{line}");
        let rest = line.split_once(": ").expect("a place before the message").1;
        assert!(rest.len() > 8, "says nothing: {line}");
    }
    text
}

fn check(name: &str, bytes: &[u8], files: &mut dyn Resolver, want: &Want) {
    let result = run(bytes, files);
    let text = printed(&result);
    let what = format!("{name}: {} gave {text}", excerpt(bytes));
    match (want, &result) {
        (Clean, _) => {}
        (Error(line, holds), Err(e)) => {
            assert_eq!(e.kind(), ReadErrorKind::Data, "{what}");
            assert_eq!(e.line().unwrap_or(0), *line, "{what}");
            let place = match line {
                0 => "case.obj: ".to_owned(),
                n => format!("case.obj:{n}: "),
            };
            assert!(text.starts_with(&place) && text.contains(holds), "{what}");
        }
        (Warn(kind, line), Ok(found)) => {
            assert_eq!(found.warnings.len(), 1, "{what}");
            assert_eq!(found.warnings[0].kind(), *kind, "{what}");
            assert_eq!(found.warnings[0].line().unwrap_or(0), *line, "{what}");
            sound(found);
        }
        (Render(faces), Ok(found)) => {
            assert_eq!(found.cage.face_count(), *faces, "{what}");
            assert!(found.warnings.is_empty(), "{what}");
            sound(found);
        }
        _ => panic!("{what}, wanted {want:?}"),
    }
    // A cage of any outcome keeps its promises.
    if let Ok(found) = &result {
        sound(found);
    }
}

fn sound(found: &Read) {
    let cage = &found.cage;
    let n = cage.points().len() as u32;
    assert!(cage.face_count() > 0);
    assert!(cage.points().iter().flatten().all(|c| c.is_finite()));
    assert!(cage.uvs().iter().flatten().all(|c| c.is_finite()));
    assert!(cage.corner_vertices().iter().all(|&v| v < n));
    for f in 0..cage.face_count() {
        assert!(cage.face(f).len() >= 3);
    }
    assert_eq!(
        *cage.face_offsets().last().unwrap() as usize,
        cage.corner_vertices().len()
    );
    for list in [cage.corner_uvs(), cage.corner_normals()] {
        assert!(list.is_empty() || list.len() == cage.corner_vertices().len());
    }
    let tags = cage.tags();
    assert!(
        tags.creases
            .iter()
            .all(|c| c.vertices.iter().all(|&v| v < n) && c.sharpness >= 0.0)
    );
    assert!(tags.holes.iter().all(|&f| (f as usize) < cage.face_count()));
}

fn none() -> MemoryFiles {
    MemoryFiles::new()
}

/// Cases of text alone.
fn check_all(cases: Vec<(&str, Vec<u8>, Want)>) {
    for (name, bytes, want) in cases {
        check(name, &bytes, &mut none(), &want);
    }
}

#[test]
fn names_in_messages_are_escaped_and_cut() {
    let name = format!("\x1b]0;{}\x07\u{202e}", "n".repeat(100_000));
    let bytes = format!("mtllib {name}\nusemtl {name}\n{name}\n{V}f 1 2 3\n");
    let options = ReadOptions::default();
    let result = read(bytes.as_bytes(), &name, &mut none(), &options);
    let text: String = result
        .unwrap()
        .warnings
        .iter()
        .map(|w| format!("{w}\n"))
        .collect();
    assert!(
        text.len() < 64 << 10 && text.lines().count() == 3,
        "{}",
        text.len()
    );
    assert!(!text.contains(['\x1b', '\x07', '\u{202e}']));
}

#[test]
fn budgets_refuse_before_they_allocate() {
    let faces = "f 1 2 3\n".repeat(100_000);
    let bytes = format!("{V}{faces}").into_bytes();
    let options = ReadOptions {
        max_bytes: 1 << 20,
        ..ReadOptions::default()
    };
    let result = read(&bytes, "case.obj", &mut none(), &options);
    assert!(printed(&result).contains("allowed"));
    assert_eq!(result.unwrap_err().kind(), ReadErrorKind::Limit);
    check(
        "a budget that is enough",
        &bytes,
        &mut none(),
        &Render(100_000),
    );
}

/// Seeded damage to a good file: cut, exchanged and repeated bytes.
#[test]
fn damaged_files_never_fault() {
    let good = format!(
        "mtllib a.mtl\n{V}v 0.5 -1.25e-1 3\nvt 0 0\nvt 1 0.5\nvn 0 0 1\nusemtl m\nf 1/1/1 2/2/1 3/1/1\nf 3//1 -1 1 \\\n 2\n\
         t crease 2/1/0 0 1 2.5\nt hole 1/0/0 0\nt interpolateboundary 1/0/0 1\n"
    );
    let library = b"newmtl m\nKd 1 0 0\nmap_Kd -s 1 1 a.png\nd 0.5\nTr 0.5\nillum 2\n";
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = move |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 20) as usize % n
    };
    let pieces: [&[u8]; 14] = [
        b"nan",
        b"-",
        b"/",
        b"\\\n",
        b"\0",
        b"99999999999999999999",
        b"#",
        b"\r",
        b"f",
        b"t ",
        b"1e999",
        b" ",
        b"\xff",
        b"v ",
    ];
    for _ in 0..20_000 {
        let mut obj = good.as_bytes().to_vec();
        let mut mtl = library.to_vec();
        for _ in 0..1 + next(4) {
            let bytes = if next(4) == 0 { &mut mtl } else { &mut obj };
            let at = next(bytes.len());
            match next(4) {
                0 => bytes.truncate(at.max(1)),
                1 => bytes[at] = next(256) as u8,
                2 => {
                    bytes.splice(at..at, pieces[next(pieces.len())].iter().copied());
                }
                _ => {
                    let end = (at + next(30)).min(bytes.len());
                    let part = bytes[at..end].to_vec();
                    let to = next(bytes.len());
                    bytes.splice(to..to, part);
                }
            }
        }
        check("damaged", &obj, &mut none().with("a.mtl", mtl), &Clean);
    }
}
