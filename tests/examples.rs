//! Every example runs.

use std::process::Command;

/// `cargo test` builds the examples beside the test programs.
fn example(name: &str) -> Command {
    let mut folder = std::env::current_exe().unwrap();
    folder.pop();
    folder.pop();
    let path = folder
        .join("examples")
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(
        path.is_file(),
        "{} is not built; run the whole of `cargo test`, or `cargo build --examples` before",
        path.display()
    );
    Command::new(path)
}

fn output(name: &str, arguments: &[&str]) -> String {
    let out = example(name).args(arguments).output().unwrap();
    assert!(
        out.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&out.stderr)
    );
    String::from_utf8(out.stdout).unwrap()
}

#[test]
fn limit_points_prints_the_grid() {
    let text = output("limit_points", &[]);
    assert_eq!(text.lines().count(), 25);
    assert!(text.starts_with("[-0.5, -0.5, -0.5]"), "{text}");
}

#[test]
fn caller_pool_draws_eight_views() {
    let text = output("caller_pool", &[]);
    assert_eq!(text.lines().count(), 8);
    assert!(!text.contains(": 0 pixels"));
}

#[test]
fn render_writes_a_picture() {
    let folder = std::env::temp_dir().join(format!("earmark-example-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let out = folder.join("cube.png");
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cube.obj");
    output("render", &[model, out.to_str().unwrap(), "3"]);
    assert!(std::fs::read(&out).unwrap().starts_with(b"\x89PNG"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn patch_distances_writes_a_sheet() {
    let out = std::env::temp_dir().join(format!("earmark-patches-{}.png", std::process::id()));
    output("patch_distances", &["-", out.to_str().unwrap(), "40"]);
    let bytes = std::fs::read(&out).unwrap();
    // Four columns of 40 pixels with margins of 16.
    assert_eq!(&bytes[16..20], &240_u32.to_be_bytes());
    std::fs::remove_file(&out).unwrap();
}

#[test]
fn contact_sheet_draws_a_folder() {
    let folder = std::env::temp_dir().join(format!("earmark-sheet-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for name in ["cube", "torus", "octahedron"] {
        let from = format!("{}/assets/{name}.obj", env!("CARGO_MANIFEST_DIR"));
        std::fs::copy(from, folder.join(name).with_extension("obj")).unwrap();
    }
    let out = folder.join("sheet.png");
    let arguments = [folder.to_str().unwrap(), out.to_str().unwrap(), "40"];
    output("contact_sheet", &arguments);
    let bytes = std::fs::read(&out).unwrap();
    // Two columns of 40 pixels with margins of 16.
    assert_eq!(&bytes[16..20], &128_u32.to_be_bytes());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn animations_and_displacement_write_their_pictures() {
    let folder = std::env::temp_dir().join(format!("earmark-frames-{}", std::process::id()));
    let at = folder.to_str().unwrap();
    for name in ["breathing", "lattice"] {
        output(name, &[at, "3", "64"]);
        let frame = |k: u32| std::fs::read(folder.join(format!("{name}_{k:04}.png"))).unwrap();
        assert!(frame(0).starts_with(b"\x89PNG") && frame(0) != frame(1) && frame(1) != frame(2));
    }
    output("displacement", &[at, "64"]);
    for name in [
        "terrain",
        "displaced_creature",
        "normal_map",
        "ball_displaced",
        "ball_mapped",
    ] {
        let bytes = std::fs::read(folder.join(name).with_extension("png")).unwrap();
        assert!(bytes.starts_with(b"\x89PNG"), "{name}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn gallery_writes_pictures_and_a_page() {
    let folder = std::env::temp_dir().join(format!("earmark-gallery-{}", std::process::id()));
    output("gallery", &[folder.to_str().unwrap(), "48"]);
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    let pictures: Vec<&str> = page
        .split("src=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    assert!(pictures.len() > 25, "{} pictures", pictures.len());
    for name in &pictures {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        assert!(bytes.starts_with(b"\x89PNG"), "{name}");
    }
    let drawings = std::fs::read_dir(&folder).unwrap().filter(|e| {
        let path = e.as_ref().unwrap().path();
        path.extension().is_some_and(|e| e == "svg")
    });
    assert!(drawings.count() >= 4);
    // The command below a picture draws it: of every fourth one, so that all topics have theirs, and of one with lines alone.
    let commands: Vec<&str> = page
        .split("<code>")
        .skip(1)
        .map(|rest| rest.split('<').next().unwrap())
        .collect();
    assert_eq!(commands.len(), pictures.len());
    let pairs = commands.iter().zip(&pictures).enumerate();
    let mut alone = 0;
    for (_, (command, name)) in pairs.filter(|(k, _)| k % 4 == 1) {
        let words = command.split_whitespace().skip(1);
        let drawn = folder.join("again.png");
        let words = words.map(|w| match w == *name {
            true => drawn.to_str().unwrap(),
            false => w,
        });
        let out = Command::new(env!("CARGO_BIN_EXE_earmark"))
            .args(words)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.success(), "{command}: {said}");
        let [shown, drawn] = [&folder.join(name), &drawn].map(|p| std::fs::read(p).unwrap());
        assert!(shown == drawn, "{name} is not what this draws: {command}");
        alone += usize::from(command.contains("--shade wireframe"));
    }
    assert!(alone > 0);
    std::fs::remove_dir_all(&folder).unwrap();
}
