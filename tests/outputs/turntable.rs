//! Turns and sheets: the same pictures as `render`, in files or frames of their own.

use super::harness::{Folder, assert_clean, asset, code, earmark, kept, run, stderr, stdout};
use earmark::film::png::decode;
use std::fs;
use std::io::Cursor;
use std::process::Output;

fn turn(folder: &Folder, output: &str, more: &[&str]) -> Output {
    turn_of("64x48", folder, output, more)
}

fn turn_of(size: &str, folder: &Folder, output: &str, more: &[&str]) -> Output {
    let mut command = earmark();
    command
        .arg("turntable")
        .arg(asset("creature.obj"))
        .args(["-s", size, "-o"]);
    command
        .arg(folder.path(output))
        .args(more)
        .output()
        .unwrap()
}

fn picture(folder: &Folder, azimuth: &str) -> Vec<u8> {
    let out = folder.path("one.png");
    let render = earmark()
        .arg("render")
        .arg(asset("creature.obj"))
        .args(["-s", "64x48", "--azimuth", azimuth, "-o"])
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(code(&render), 0, "{}", stderr(&render));
    let bytes = fs::read(&out).unwrap();
    fs::remove_file(out).unwrap();
    bytes
}

/// Frames of an animated PNG, with how often they repeat and how long each is shown.
fn frames(bytes: &[u8]) -> (Vec<Vec<u8>>, u32, (u16, u16)) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let control = *reader.info().animation_control().unwrap();
    let mut out = Vec::new();
    let mut delay = (0, 0);
    for _ in 0..control.num_frames {
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((frame.width, frame.height), (64, 48));
        let shown = reader.info().frame_control().unwrap();
        delay = (shown.delay_num, shown.delay_den);
        assert_eq!(shown.blend_op, png::BlendOp::Source);
        out.push(pixels);
    }
    (out, control.num_plays, delay)
}

#[test]
fn frames_are_the_pictures_of_render() {
    let folder = Folder::new("turn");
    let numbered = turn(&folder, "f_###.png", &["--count", "8", "--stats", "-"]);
    assert_eq!(code(&numbered), 0, "{}", stderr(&numbered));
    let names: Vec<String> = (1..=8).map(|k| format!("f_{k:03}.png")).collect();
    assert_eq!(folder.names(), names);
    let json: serde_json::Value = serde_json::from_str(&stdout(&numbered)).unwrap();
    assert_eq!(json["frames"], 8);
    assert!(json["stages"]["tile_ms"].is_number() && json["stages"]["write_ms"].is_number());
    let animated = turn(&folder, "t.png", &["--count", "8", "--fps", "12"]);
    assert_eq!(code(&animated), 0, "{}", stderr(&animated));
    let (animation, plays, delay) = frames(&fs::read(folder.path("t.png")).unwrap());
    assert_eq!((animation.len(), plays, delay), (8, 0, (1, 12)));
    for k in 0..8 {
        let alone = picture(&folder, &format!("{}", 45 + 45 * k));
        assert_eq!(
            fs::read(folder.path(&names[k])).unwrap(),
            alone,
            "frame {}",
            k + 1
        );
        assert_eq!(
            animation[k],
            decode(&alone).unwrap().data,
            "frame {}",
            k + 1
        );
    }
    assert_ne!(animation[0], animation[1]);
}

#[test]
fn a_part_of_the_turn_is_a_part_of_its_frames() {
    let folder = Folder::new("turn-part");
    for (flags, names) in [
        (["--frames", "3-4"], vec!["f3.png", "f4.png"]),
        (["--frames", "8"], vec!["f8.png"]),
    ] {
        let out = turn(
            &folder,
            "f#.png",
            &[&["--count", "8", "-j", "1"], &flags[..]].concat(),
        );
        assert_eq!(code(&out), 0, "{}", stderr(&out));
        assert_eq!(folder.names(), names);
        for name in names {
            let k: u32 = name[1..2].parse().unwrap();
            let alone = picture(&folder, &format!("{}", 45 * k));
            assert_eq!(fs::read(folder.path(name)).unwrap(), alone);
            fs::remove_file(folder.path(name)).unwrap();
        }
    }
    let out = turn(&folder, "t.png", &["--count", "8", "--frames", "3-4"]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    assert_eq!(frames(&fs::read(folder.path("t.png")).unwrap()).0.len(), 2);
}

#[test]
fn progress_counts_frames() {
    let folder = Folder::new("turn-progress");
    let out = turn(
        &folder,
        "f#.png",
        &["--count", "40", "--progress", "always"],
    );
    assert_eq!(code(&out), 0);
    let text = stderr(&out);
    assert!(
        text.contains("frame ") && text.contains(" of 40, "),
        "{text}"
    );
    let quiet = turn(&folder, "f#.png", &["--count", "2", "--progress", "never"]);
    assert_eq!(stderr(&quiet), "");
}

#[test]
fn an_animation_appears_whole_or_not_at_all() {
    let folder = Folder::new("turn-late");
    fs::write(folder.path("t.png"), "old").unwrap();
    let out = turn_of(
        "300x300",
        &folder,
        "t.png",
        &["--count", "5000", "--timeout", "1"],
    );
    let message = assert_clean(&out);
    assert_eq!(code(&out), 5, "{message}");
    assert_eq!(folder.names(), ["t.png"]);
    assert_eq!(kept(&folder.path("t.png")), "old");
    // Numbered frames that are done stay, whole.
    let out = turn_of(
        "300x300",
        &folder,
        "f#.png",
        &["--count", "5000", "--timeout", "2"],
    );
    assert_eq!(code(&out), 5);
    let names = folder.names();
    assert!(names.len() > 1 && names.len() < 5000);
    for name in names.iter().filter(|n| n.starts_with('f')) {
        assert!(
            decode(&fs::read(folder.path(name)).unwrap()).is_ok(),
            "{name}"
        );
    }
    assert!(names.iter().all(|n| !n.ends_with(".tmp")));
}

#[test]
fn wrong_turns_are_refused() {
    let folder = Folder::new("turn-wrong");
    for flags in [
        &["--count", "0"][..],
        &["--frames", "0-2"],
        &["--frames", "4-3"],
        &["--frames", "61"],
        &["--fps", "0"],
        &["--eye", "1,2,3"],
        &["--views", "front"],
        &["--aov", "depth=d.png"],
    ] {
        let out = turn(&folder, "f#.png", flags);
        assert_clean(&out);
        assert_eq!(code(&out), 2, "{flags:?}");
        assert_eq!(folder.names(), Vec::<String>::new());
    }
    assert_eq!(code(&turn(&folder, "f#.jpg", &[])), 2);
    assert_eq!(code(&turn(&folder, "none/f#.png", &[])), 4);
}

#[test]
fn sheets_hold_every_view_of_every_model() {
    let folder = Folder::new("sheet");
    let out = folder.path("s.png");
    let size = |more: &[&str]| {
        let mut command = earmark();
        command
            .arg("render")
            .args(["-s", "60x50", "-o"])
            .arg(&out)
            .args(more);
        let done = command.output().unwrap();
        assert_eq!(code(&done), 0, "{}", stderr(&done));
        let image = decode(&fs::read(&out).unwrap()).unwrap();
        (image.width, image.height, image)
    };
    let [cube, torus, creature] = ["cube.obj", "torus.obj", "creature.obj"].map(asset);
    let names = [&cube, &torus, &creature].map(|p| p.to_str().unwrap());
    // Margins of 16, captions of 8 pixels with what they reach below.
    let (width, height, sheet) = size(&[
        names[0],
        names[2],
        "--views",
        "front,side,top,three-quarter",
    ]);
    assert_eq!((width, height), (16 + 4 * 76, 16 + 2 * (50 + 13 + 16)));
    let (width, _, _) = size(&[names[0], names[1], names[2], "--views", "front"]);
    assert_eq!(width, 16 + 2 * 76);
    // A cell is the picture of `render` with the view's angles, laid over the sheet's white.
    let (_, _, side) = size(&[names[2], "--azimuth", "90", "--elevation", "0"]);
    let at = (16 + 76, 16 + 50 + 13 + 16);
    let (mut opaque, mut clear) = (0, 0);
    for (y, x) in (0..50).flat_map(|y| (0..60).map(move |x| (y, x))) {
        let [a, b] = [sheet.pixel(at.0 + x, at.1 + y), side.pixel(x, y)];
        match b[3] {
            255 => assert_eq!(a, b, "{x},{y}"),
            0 => assert_eq!(a, [255; 4], "{x},{y}"),
            _ => continue,
        }
        opaque += u32::from(b[3] == 255);
        clear += u32::from(b[3] == 0);
    }
    assert!(opaque > 200 && clear > 1000, "{opaque} {clear}");
    for flags in [
        &["--eye", "1,2,3"][..],
        &["--aov", "depth=d.png"],
        &["--views", "inside"],
    ] {
        let views = [
            &[
                "render",
                names[0],
                "-o",
                out.to_str().unwrap(),
                "--views",
                "front",
            ],
            flags,
        ];
        assert_eq!(code(&run(&views.concat())), 2, "{flags:?}");
    }
}
