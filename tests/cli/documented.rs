//! Every command that the documentation prints.

use super::harness::{Folder, asset, earmark, run, stdout};
use std::fs;
use std::path::{Path, PathBuf};

/// Lines that begin with the program's name inside of shell blocks.
fn commands(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside && line.starts_with("earmark ") {
            out.push(line.to_owned());
        }
    }
    out
}

fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide = fs::read_dir(root.join("src/guide")).unwrap();
    let mut out: Vec<PathBuf> = guide
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "md"))
        .collect();
    out.sort();
    out.push(root.join("README.md"));
    out
}

/// A folder with all assets, one of which is called `model.obj`.
fn workplace() -> Folder {
    let folder = Folder::with_assets("documented");
    fs::create_dir(folder.path("assets")).unwrap();
    for name in ["creature.obj", "creature.mtl", "creature_skin.png"] {
        fs::copy(asset(name), folder.path("assets").join(name)).unwrap();
    }
    fs::copy(asset("creature.obj"), folder.path("model.obj")).unwrap();
    // Goldens, and pictures like them.
    for pictures in ["golden", "new"] {
        fs::create_dir(folder.path(pictures)).unwrap();
        fs::copy(
            asset("creature_skin.png"),
            folder.path(pictures).join("skin.png"),
        )
        .unwrap();
    }
    folder
}

#[cfg(unix)]
#[test]
fn commands_of_the_documentation_run() {
    let folder = workplace();
    let program = PathBuf::from(earmark().get_program());
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", program.parent().unwrap().display());
    let mut count = 0;
    for document in documents() {
        for command in commands(&fs::read_to_string(&document).unwrap()) {
            let out = std::process::Command::new("sh")
                .args(["-c", &command])
                .current_dir(folder.path(""))
                .env("PATH", &path)
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&out.stderr);
            assert!(
                out.status.success(),
                "{}: {command}\n{said}",
                document.display()
            );
            count += 1;
        }
    }
    assert!(count >= 20, "{count} commands");
}

#[test]
fn pictures_and_files_of_the_readme_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("README.md")).unwrap();
    let targets = text.split("](").skip(1).filter_map(|t| t.split(')').next());
    let local: Vec<&str> = targets.filter(|t| !t.contains("://")).collect();
    assert!(local.len() >= 5, "{local:?}");
    for target in local {
        assert!(
            root.join(target).is_file(),
            "README.md: {target} is missing"
        );
    }
}

#[test]
fn flags_of_the_documentation_are_known() {
    let mut known = String::new();
    for verb in ["render", "refine", "info", "bench", "turntable", "compare"] {
        known += &stdout(&run(&[verb, "--help"]));
    }
    let known =
        |flag: &str| known.contains(&format!("{flag} ")) || known.contains(&format!("{flag}\n"));
    for document in documents() {
        for command in commands(&fs::read_to_string(&document).unwrap()) {
            for flag in command.split(' ').filter(|w| w.starts_with("--")) {
                assert!(known(flag), "{}: {flag}", document.display());
            }
        }
    }
}

/// The script for Blender writes what earmark reads; run with a stand-in for Blender's module, where there is a Python.
#[test]
fn the_script_for_blender_keeps_creases() {
    const STAND_IN: &str = r#"
from types import SimpleNamespace as S
class Matrix:
    def __matmul__(self, p): return p
value = lambda v: S(value=v)
points = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
edges = sorted({tuple(sorted((f[k], f[(k + 1) % 4]))) for f in faces for k in range(4)})
loops = [S(index=i, vertex_index=v) for i, v in enumerate(v for f in faces for v in f)]
uvs = [S(uv=(points[l.vertex_index][0], points[l.vertex_index][1])) for l in loops]
mesh = S(
    vertices=[S(co=p) for p in points], loops=loops, edges=[S(vertices=e) for e in edges],
    polygons=[S(material_index=0, loop_indices=range(4 * k, 4 * k + 4)) for k in range(6)],
    uv_layers=S(active=S(data=uvs)),
    attributes={"crease_edge": S(data=[value(1.0 if k == 0 else 0.5 if k == 1 else 0.0) for k in range(12)]),
                "crease_vert": S(data=[value(1.0 if k == 7 else 0.0) for k in range(8)])})
material = S(name="my clay", diffuse_color=(0.5, 0.25, 1.0, 1.0))
cube = S(data=mesh, matrix_world=Matrix(), material_slots=[S(material=material)],
         modifiers=[S(type="SUBSURF", boundary_smooth="ALL")])
data = S(objects={"cube": cube}, filepath="")
context = S(object=cube)
"#;
    let folder = Folder::new("blender");
    fs::write(folder.path("bpy.py"), STAND_IN).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/blender_export.py");
    let python = std::process::Command::new("python3")
        .arg(script)
        .args(["--", "cube.obj"])
        .env("PYTHONPATH", folder.path(""))
        .current_dir(folder.path(""))
        .output();
    let Ok(out) = python else { return };
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    let text = fs::read_to_string(folder.path("cube.obj")).unwrap();
    for line in [
        "t crease 2/1/0 0 1 10",
        "t crease 2/1/0 0 2 2.5",
        "t corner 1/1/0 7 10",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}\n{text}");
    }
    // One number for the texture of every vertex.
    assert_eq!(text.lines().filter(|l| l.starts_with("vt ")).count(), 8);
    assert!(text.contains("mtllib cube.mtl") && text.contains("usemtl my_clay"));
    let out = earmark()
        .args(["info", "--json"])
        .arg(folder.path("cube.obj"))
        .output()
        .unwrap();
    let info: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    assert_eq!(info["faces"], 6, "{info}");
    assert!(String::from_utf8_lossy(&out.stderr).is_empty());
}
