//! `earmark compare`: codes, figures, pages, and what it accepts.

use super::harness::{Folder, assert_clean, code, earmark, run, stderr, stdout};
use earmark::film::png::{decode, encode, encode_deep, encode_gray16};
use earmark::film::{DeepImage, Image};
use std::fs;
use std::path::Path;
use std::process::Output;

fn picture(seed: u8) -> Image {
    let mut image = Image::new(20, 10);
    for (k, b) in image.data.iter_mut().enumerate() {
        *b = (k as u8).wrapping_mul(5).wrapping_add(seed) | if k % 4 == 3 { 255 } else { 0 };
    }
    image
}

fn write(path: &Path, image: &Image) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, encode(image).unwrap()).unwrap();
}

fn compare(a: &Path, b: &Path, more: &[&str]) -> Output {
    earmark()
        .arg("compare")
        .arg(a)
        .arg(b)
        .args(more)
        .output()
        .unwrap()
}

fn json(out: &Output) -> serde_json::Value {
    serde_json::from_str(&stdout(out)).unwrap()
}

#[test]
fn two_pictures_are_equal_or_not() {
    let folder = Folder::new("compare");
    let (a, b) = (folder.path("a.png"), folder.path("b.png"));
    let image = picture(3);
    let mut changed = image.clone();
    changed.data[4 * 27] = changed.data[4 * 27].wrapping_add(40);
    changed.data[4 * 28 + 1] ^= 1;
    write(&a, &image);
    write(&b, &image);
    let out = compare(&a, &b, &[]);
    assert_eq!(code(&out), 0);
    assert!(stdout(&out).contains("equal, pixel by pixel") && out.stderr.is_empty());
    write(&b, &changed);
    let out = compare(&a, &b, &[]);
    assert_eq!(code(&out), 1);
    let text = stdout(&out);
    for part in [
        "different",
        "2 of 200 pixels differ (1.000 %)",
        "largest delta 40 of 255 at 7,1",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert!(text.contains("above 0: 2, above 1: 1, above 2: 1") && text.contains("above 64: 0"));
    assert!(out.stderr.is_empty());
    assert_eq!(
        (
            code(&compare(&a, &b, &["-q"])),
            stdout(&compare(&a, &b, &["-q"]))
        ),
        (1, String::new())
    );
    for (flags, want) in [
        (&["--max-delta", "39"][..], 1),
        (&["--max-delta", "40"], 0),
        (&["--max-pixels", "1"], 1),
        (&["--max-pixels", "2"], 0),
        (&["--max-pixels", "1", "--max-delta", "1"], 0),
        (&["--max-delta", "-1"], 2),
        (&["--max-delta", "70000"], 2),
        (&["--prune"], 2),
        (&["--stats", "-"], 2),
    ] {
        assert_eq!(code(&compare(&a, &b, flags)), want, "{flags:?}");
    }
    // The picture of the difference is written on failure too.
    let diff = folder.path("d.png");
    let out = compare(&a, &b, &["--json", "--diff", diff.to_str().unwrap()]);
    assert_eq!(code(&out), 1);
    let found = json(&out);
    assert_eq!(found["verdict"], "different");
    assert_eq!(
        (&found["differing"], &found["max_delta"]),
        (&2.into(), &40.into())
    );
    assert_eq!(found["sweep"][1], serde_json::json!([1, 1]));
    assert_eq!(
        (&found["worst"], &found["bounds"]),
        (&serde_json::json!([7, 1]), &serde_json::json!([7, 1, 2, 1]))
    );
    let shown = decode(&fs::read(&diff).unwrap()).unwrap();
    assert_eq!(
        shown.pixel(8, 1),
        [150, 70, 255, 255],
        "violet: cannot be seen"
    );
    assert!(shown.pixel(7, 1)[0] > 200 && shown.pixel(7, 1)[2] < 100);
    let grey = shown.pixel(0, 0);
    assert!(grey[0] == grey[1] && grey[1] == grey[2]);
    // An input is never written over.
    assert_eq!(code(&compare(&a, &b, &["--diff", b.to_str().unwrap()])), 4);
}

#[test]
fn alpha_and_sixteen_bits_count() {
    let folder = Folder::new("compare-deep");
    let (a, b) = (folder.path("a.png"), folder.path("b.png"));
    let image = picture(3);
    let mut changed = image.clone();
    changed.data[4 * 27 + 3] = 200;
    write(&a, &image);
    write(&b, &changed);
    let found = json(&compare(&a, &b, &["--json"]));
    assert_eq!(
        (&found["differing"], &found["max_delta"], &found["visible"]),
        (&1.into(), &55.into(), &1.into())
    );
    // Colour under zero alpha counts too, and is not visible.
    let (mut clear, mut other) = (image.clone(), image);
    (clear.data[3], other.data[3], other.data[0]) = (0, 0, clear.data[0] ^ 9);
    write(&a, &clear);
    write(&b, &other);
    let found = json(&compare(&a, &b, &["--json"]));
    assert_eq!(
        (&found["differing"], &found["visible"]),
        (&1.into(), &0.into())
    );
    // 16 bits against 16, and against 8.
    let mut values: Vec<u16> = (0..200).map(|k| k * 257).collect();
    fs::write(&a, encode_gray16(20, 10, &values).unwrap()).unwrap();
    values[50] += 1;
    fs::write(&b, encode_gray16(20, 10, &values).unwrap()).unwrap();
    let found = json(&compare(&a, &b, &["--json"]));
    assert_eq!(
        (&found["max_delta"], &found["full_delta"]),
        (&1.into(), &65535.into())
    );
    assert_eq!(code(&compare(&a, &b, &["--max-delta", "1"])), 0);
    let shallow = DeepImage {
        width: 20,
        height: 10,
        bits: 8,
        data: (0..200).flat_map(|k| [k, k, k, 255]).collect(),
    };
    fs::write(&b, encode_deep(&shallow).unwrap()).unwrap();
    assert_eq!(code(&compare(&a, &b, &[])), 0);
}

#[test]
fn what_cannot_be_compared_is_said() {
    let folder = Folder::new("compare-wrong");
    let (a, b) = (folder.path("a.png"), folder.path("b.png"));
    write(&a, &picture(1));
    write(&b, &Image::new(10, 20));
    let out = compare(&a, &b, &["--diff", folder.path("d.png").to_str().unwrap()]);
    assert_eq!(code(&out), 1);
    assert!(stdout(&out).contains("20x10 pixels against 10x20"));
    assert!(!folder.path("d.png").exists());
    let bytes = fs::read(&a).unwrap();
    for (content, want) in [
        (&b"no picture"[..], 3),
        (&bytes[..bytes.len() / 2], 3),
        (&[], 3),
    ] {
        fs::write(&b, content).unwrap();
        for pair in [[&a, &b], [&b, &a]] {
            let out = compare(pair[0], pair[1], &[]);
            let message = assert_clean(&out);
            assert_eq!(code(&out), want, "{message}");
            assert!(message.contains("b.png"), "{message}");
        }
    }
    let missing = folder.path("none.png");
    for pair in [[&a, &missing], [&missing, &a]] {
        let out = compare(pair[0], pair[1], &[]);
        assert_eq!(code(&out), 4);
        assert!(assert_clean(&out).contains("none.png"));
    }
    let here = folder.path("");
    assert_eq!(code(&compare(&a, &here, &[])), 2);
    assert_eq!(code(&compare(&here, &here, &["--diff", "d.png"])), 2);
    assert_eq!(code(&compare(&a, &a, &["--max-memory", "1K"])), 5);
}

#[test]
fn folders_are_held_against_each_other() {
    let folder = Folder::new("compare-folders");
    let (goldens, new) = (folder.path("goldens"), folder.path("new"));
    for name in ["same.png", "sub/changed.png", "dead.png"] {
        write(&goldens.join(name), &picture(1));
    }
    write(&new.join("same.png"), &picture(1));
    write(&new.join("sub/changed.png"), &picture(2));
    write(&new.join("sub/<new> & \"more\".png"), &picture(4));
    fs::write(new.join("notes.txt"), "no picture").unwrap();
    let page = folder.path("page.html");
    let out = compare(&goldens, &new, &["--report", page.to_str().unwrap()]);
    assert_eq!(code(&out), 1, "{}", stderr(&out));
    let text = stdout(&out);
    for part in [
        "dead.png: dead golden",
        "sub/changed.png: different",
        "sub/<new> & \"more\".png: without golden",
        "1 dead golden, 1 equal, 1 without golden, 1 different",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let html = fs::read_to_string(&page).unwrap();
    // Four pictures and a difference, in the page itself, which asks for nothing else.
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 5);
    assert!(
        html.contains("prefers-color-scheme")
            && html.contains("sub/&lt;new&gt; &amp; &quot;more&quot;.png")
    );
    for outside in ["http:", "https:", "url(", "<link", "src=\"s", "@import"] {
        assert!(!html.contains(outside), "{outside}");
    }
    let found = json(&compare(&goldens, &new, &["--json"]));
    assert_eq!(found["passes"], false);
    assert_eq!(found["pictures"].as_array().unwrap().len(), 4);
    // The tolerance is that of every picture.
    assert_eq!(code(&compare(&goldens, &new, &["--max-delta", "255"])), 1);
    // Accepting copies what differs, says so, and leaves dead goldens alone.
    let out = compare(&goldens, &new, &["--accept"]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let text = stdout(&out);
    assert!(
        text.contains("accepted: sub/changed.png (changed)"),
        "{text}"
    );
    assert!(
        text.contains("accepted: sub/<new> & \"more\".png (new)")
            && !text.contains("accepted: same")
    );
    let bytes = |path: &Path| fs::read(path).unwrap();
    assert_eq!(
        bytes(&goldens.join("sub/changed.png")),
        bytes(&new.join("sub/changed.png"))
    );
    assert!(goldens.join("dead.png").exists());
    assert_eq!(
        code(&compare(&goldens, &new, &[])),
        1,
        "a dead golden is still there"
    );
    let out = compare(&goldens, &new, &["--accept", "--prune"]);
    assert_eq!(code(&out), 0, "{}", stdout(&out));
    assert!(stdout(&out).contains("accepted: dead.png (removed)"));
    assert_eq!(code(&compare(&goldens, &new, &[])), 0);
    // The first of all, where there is no folder yet.
    let first = folder.path("first/of/all");
    assert_eq!(code(&compare(&first, &new, &[])), 2);
    assert_eq!(code(&compare(&first, &new, &["--accept"])), 0);
    assert_eq!(code(&compare(&first, &new, &[])), 0);
    let temporary = |f: &fs::DirEntry| f.file_name().to_string_lossy().starts_with('.');
    assert!(
        !fs::read_dir(&goldens)
            .unwrap()
            .any(|f| temporary(&f.unwrap()))
    );
}

#[test]
fn unreadable_pictures_are_never_accepted() {
    let folder = Folder::new("compare-damaged");
    let (goldens, new) = (folder.path("goldens"), folder.path("new"));
    write(&goldens.join("a.png"), &picture(1));
    write(&new.join("a.png"), &picture(2));
    write(&goldens.join("b.png"), &picture(1));
    fs::write(new.join("b.png"), "no picture").unwrap();
    let page = folder.path("page.html");
    let out = compare(
        &goldens,
        &new,
        &["--accept", "--report", page.to_str().unwrap()],
    );
    assert_eq!(code(&out), 3);
    assert!(stderr(&out).contains("b.png") && page.exists());
    assert_eq!(
        decode(&fs::read(goldens.join("a.png")).unwrap()).unwrap(),
        picture(2)
    );
    assert_eq!(
        decode(&fs::read(goldens.join("b.png")).unwrap()).unwrap(),
        picture(1)
    );
    // One picture is accepted alone as well, new or changed.
    fs::remove_file(new.join("b.png")).unwrap();
    write(&new.join("c.png"), &picture(7));
    for name in ["a.png", "c.png"] {
        write(&new.join(name), &picture(7));
        let out = compare(&goldens.join(name), &new.join(name), &["--accept"]);
        assert_eq!(code(&out), 0, "{}", stderr(&out));
        assert!(stdout(&out).contains("accepted: "));
        assert_eq!(code(&compare(&goldens.join(name), &new.join(name), &[])), 0);
    }
    assert_eq!(code(&run(&["compare", "a.png"])), 2);
    // A damaged picture without a golden is no new one.
    fs::write(new.join("d.png"), "no picture").unwrap();
    let out = compare(&goldens, &new, &["--accept"]);
    assert_eq!(code(&out), 3);
    assert!(stderr(&out).contains("d.png") && !goldens.join("d.png").exists());
    // Nor is one that takes more memory than there may be.
    fs::remove_file(new.join("d.png")).unwrap();
    write(&new.join("e.png"), &Image::new(4000, 4000));
    let out = compare(&goldens, &new, &["--accept", "--max-memory", "100M"]);
    assert_eq!(code(&out), 5, "{}", stderr(&out));
    assert!(!goldens.join("e.png").exists());
}
