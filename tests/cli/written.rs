//! Files that are written: whole or not at all, the same bytes everywhere.

use crate::harness::{Folder, assert_clean, asset, code, earmark, kept, run, stderr};
use std::fs;
use std::path::Path;

#[test]
fn outputs_are_checked() {
    let folder = Folder::new("outputs");
    let model = folder.path("cube.obj");
    fs::copy(asset("cube.obj"), &model).unwrap();
    fs::create_dir(folder.path("folder.png")).unwrap();
    let mut cases = vec![
        (folder.path("folder.png"), 4),
        (folder.path("missing/out.png"), 4),
        (folder.path("picture.bmp"), 2),
        (folder.path("picture"), 2),
        (model.clone(), 2),
    ];
    // An input by another name.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&model, folder.path("link.png")).unwrap();
        cases.push((folder.path("link.png"), 4));
        std::os::unix::fs::symlink("/dev/null", folder.path("null.png")).unwrap();
        cases.push((folder.path("null.png"), 4));
    }
    let before = folder.names();
    for (out, want) in cases {
        let result = earmark()
            .arg("render")
            .arg(&model)
            .arg("-o")
            .arg(&out)
            .output()
            .unwrap();
        let message = assert_clean(&result);
        assert_eq!(code(&result), want, "{}: {message}", out.display());
        assert_eq!(folder.names(), before);
    }
    assert_eq!(kept(&model), kept(&asset("cube.obj")));
    let same = folder.path("same.png");
    let result = earmark()
        .arg("render")
        .arg(&model)
        .arg("-o")
        .arg(&same)
        .arg("--stats")
        .arg(&same)
        .output()
        .unwrap();
    assert_eq!(code(&result), 2);
    assert_eq!(folder.names(), before);
}

#[test]
fn pictures_replace_files_and_follow_links() {
    let folder = Folder::new("replace");
    let out = folder.path("out.png");
    fs::write(&out, "old").unwrap();
    let draw = |out: &Path| {
        let result = earmark()
            .args(["render", "-s", "64x48"])
            .arg(asset("cube.obj"))
            .arg("-o")
            .arg(out)
            .output()
            .unwrap();
        assert_eq!(code(&result), 0, "{}", stderr(&result));
        assert_eq!(stderr(&result), "");
    };
    draw(&out);
    let picture = fs::read(&out).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    assert_eq!(&picture[16..24], &[0, 0, 0, 64, 0, 0, 0, 48]);
    #[cfg(unix)]
    {
        let link = folder.path("link.png");
        std::os::unix::fs::symlink("out.png", &link).unwrap();
        fs::write(&out, "old").unwrap();
        draw(&link);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&out).unwrap(), picture);
    }
}

#[test]
fn the_same_bytes_whatever_the_threads_and_instructions() {
    let draw = |arguments: &[&str], variables: &[(&str, &str)]| {
        let out = earmark()
            .args(["render", "-o", "-", "-s", "96x96", "--level", "3"])
            .arg(asset("creature.obj"))
            .args(arguments)
            .envs(variables.iter().copied())
            .output()
            .unwrap();
        assert_eq!(code(&out), 0, "{}", stderr(&out));
        out.stdout
    };
    let picture = draw(&[], &[]);
    assert!(picture.starts_with(b"\x89PNG"));
    for arguments in [&["-j", "1"][..], &["-j", "3"], &["--simd", "scalar"]] {
        assert_eq!(draw(arguments, &[]), picture, "{arguments:?}");
    }
    let variables = [("EARMARK_THREADS", "2"), ("EARMARK_SIMD", "scalar")];
    assert_eq!(draw(&[], &variables), picture);
    assert_eq!(draw(&[], &[("RAYON_NUM_THREADS", "2")]), picture);
}

#[test]
fn patches_are_drawn_and_tensions_read() {
    let folder = Folder::new("patches");
    let (out, tags) = (folder.path("out.png"), folder.path("tags.txt"));
    let cube = asset("cube.obj");
    let draw = |more: &[&str]| {
        let mut arguments = vec![
            "render",
            cube.to_str().unwrap(),
            "-o",
            out.to_str().unwrap(),
        ];
        arguments.extend(["-s", "32x32", "-l", "3", "-q"]);
        arguments.extend(more);
        run(&arguments)
    };
    let tags_flag = ["--surface", "pn", "--pn-tags", tags.to_str().unwrap()];
    let mut pictures = Vec::new();
    let mut good = |more: &[&str]| {
        let done = draw(more);
        assert_eq!(code(&done), 0, "{}", stderr(&done));
        pictures.push(fs::read(&out).unwrap());
    };
    good(&["--surface", "limit"]);
    good(&["--surface", "qas"]);
    good(&["--surface", "pn"]);
    fs::write(&tags, "0 0 0 0\n0 0 0 0 # flat\n").unwrap();
    good(&tags_flag);
    fs::write(&tags, "1\n".repeat(8)).unwrap();
    good(&tags_flag);
    assert!(pictures[4] == pictures[2]);
    assert!((0..4).all(|i| (0..i).all(|k| pictures[i] != pictures[k])));
    for (text, line, part) in [
        ("1\n1 2\n", 2, "\"2\""),
        ("1\n1\n", 2, "2 numbers"),
        ("1 1 1 1 1 1 1 1\n1", 2, "more numbers"),
        ("1\nx\n", 2, "\"x\""),
    ] {
        fs::write(&tags, text).unwrap();
        let failed = draw(&tags_flag);
        let message = assert_clean(&failed);
        assert_eq!(code(&failed), 3, "{message}");
        assert!(
            message.contains(&format!("tags.txt:{line}: ")) && message.contains(part),
            "{message}"
        );
    }
    fs::remove_file(&tags).unwrap();
    assert_eq!(code(&draw(&tags_flag)), 4);
    assert_eq!(code(&draw(&["--pn-tags", tags.to_str().unwrap()])), 2);
}

#[test]
fn line_work_is_written_as_pixels_and_as_svg() {
    let folder = Folder::new("lines");
    let render = |out: &str, more: &[&str]| {
        let mut command = earmark();
        command.args(["render", "-s", "96x64", "-l", "2", "-o"]);
        command.arg(folder.path(out)).arg(asset("cube.obj"));
        command.args(more).output().unwrap()
    };
    assert_eq!(code(&render("plain.png", &[])), 0);
    let stats = folder.path("stats.json");
    let more = ["--overlay", "wireframe,cage,patches,axes", "--stats"];
    let more = [&more[..], &[stats.to_str().unwrap()]].concat();
    assert_eq!(code(&render("lines.png", &more)), 0);
    assert!(kept(&stats).contains("\"overlay_ms\":"));
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_ne!(bytes("plain.png"), bytes("lines.png"));
    let alone = ["--shade", "wireframe", "--background", "ffffff"];
    for name in ["alone.png", "alone.svg"] {
        assert_eq!(code(&render(name, &alone)), 0, "{name}");
    }
    let text = kept(&folder.path("alone.svg"));
    assert!(text.starts_with("<svg xmlns") && text.contains("class=\"silhouettes\""));
    // A shaded picture is no line work, and layers have names.
    let shaded = render("x.svg", &[]);
    assert_eq!(code(&shaded), 2);
    assert!(assert_clean(&shaded).contains("--shade wireframe"));
    assert_eq!(code(&render("x.png", &["--overlay", "wires"])), 2);
    assert!(!folder.names().iter().any(|n| n.starts_with("x.")));
    let model = asset("cube.obj");
    let bench = run(&[
        "bench",
        "frame",
        model.to_str().unwrap(),
        "--overlay",
        "cage",
    ]);
    assert_eq!(code(&bench), 2);
    // Finer than lines can be.
    let mut command = earmark();
    command.args([
        "render",
        "-s",
        "96x64",
        "-l",
        "10",
        "--shade",
        "wireframe",
        "-v",
        "-o",
    ]);
    let out = command
        .arg(folder.path("deep.png"))
        .arg(asset("cube.obj"))
        .output()
        .unwrap();
    assert_eq!(code(&out), 0);
    assert!(
        stderr(&out).contains("lines are those of level"),
        "{}",
        stderr(&out)
    );
}
