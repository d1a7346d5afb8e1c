//! Which module may import which: the table of the code map, read from the source.

use std::collections::BTreeMap;
use std::path::Path;

/// Module, and the modules of the crate that it may name.
const ALLOWED: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("simd", &["dispatch"]),
    ("records", &[]),
    ("guide", &[]),
    ("limits", &[]),
    ("scheme", &[]),
    ("mesh", &["math", "limits", "scheme", "topology", "refine"]),
    ("texture", &["math", "limits", "film"]),
    ("camera", &["math", "records", "Cage"]),
    ("topology", &["scheme", "limits", "mesh", "Cage"]),
    ("refine", &["math", "mesh", "scheme", "topology", "limits"]),
    (
        "dice",
        &["math", "simd", "records", "scheme", "topology", "dispatch"],
    ),
    (
        "control",
        &[
            "simd", "records", "limits", "scheme", "topology", "refine", "dice",
        ],
    ),
    (
        "patch",
        &[
            "math", "simd", "records", "scheme", "topology", "dice", "dispatch",
        ],
    ),
    (
        "displace",
        &["math", "simd", "records", "texture", "dispatch"],
    ),
    (
        "bake",
        &[
            "math", "simd", "records", "texture", "dice", "displace", "surface",
        ],
    ),
    (
        "surface",
        &[
            "displace", "patch", "math", "simd", "records", "limits", "scheme", "topology", "mesh",
            "refine", "dice", "control", "Cage", "Surface",
        ],
    ),
    (
        "evaluate",
        &[
            "math", "mesh", "control", "dice", "surface", "Cage", "Surface",
        ],
    ),
    (
        "distance",
        &["math", "mesh", "patch", "surface", "evaluate"],
    ),
    (
        "stream",
        &["records", "dice", "surface", "simd", "Surface", "Cage"],
    ),
    ("raster", &["math", "simd", "records", "dispatch"]),
    (
        "shade",
        &[
            "math", "simd", "records", "camera", "texture", "film", "dispatch",
        ],
    ),
    ("film", &["math", "simd", "records"]),
    ("compare", &["math", "film"]),
    (
        "golden",
        &["compare", "film", "files", "limits", "assert_image"],
    ),
    ("sheet", &["math", "film"]),
    (
        "overlay",
        &[
            "math", "records", "limits", "camera", "topology", "mesh", "raster", "film", "sheet",
            "frame", "Camera", "Renderer", "Scene",
        ],
    ),
    ("files", &["mesh", "texture", "film", "limits"]),
    (
        "tessellate",
        &[
            "math", "simd", "records", "limits", "camera", "topology", "dice", "surface",
            "dispatch",
        ],
    ),
    (
        "frame",
        &[
            "tessellate",
            "patch",
            "displace",
            "evaluate",
            "math",
            "simd",
            "dispatch",
            "records",
            "limits",
            "scheme",
            "mesh",
            "texture",
            "camera",
            "topology",
            "dice",
            "surface",
            "raster",
            "shade",
            "film",
            "Surface",
            "Scene",
            "Cage",
            "Camera",
            "Renderer",
        ],
    ),
    (
        "window",
        &["camera", "math", "records", "frame", "film", "sheet"],
    ),
    (
        "gpu",
        &[
            "load",
            "displace",
            "texture",
            "tessellate",
            "patch",
            "evaluate",
            "records",
            "limits",
            "scheme",
            "mesh",
            "refine",
            "camera",
            "topology",
            "dice",
            "surface",
            "raster",
            "shade",
            "film",
            "frame",
        ],
    ),
    (
        "load",
        &[
            "files", "frame", "mesh", "patch", "shade", "surface", "texture", "topology", "limits",
            "scheme",
        ],
    ),
];

/// Packages that one file alone may name.
const PACKAGES: &[(&str, &[&str])] = &[
    ("glam", &["math.rs", "camera.rs"]),
    ("tobj", &["mesh/mtl.rs"]),
    (
        "tiny_skia",
        &["sheet.rs", "sheet/", "overlay/", "window/hud.rs"],
    ),
    ("minifb", &["window/screen.rs"]),
    ("image", &["texture/load.rs", "film/"]),
    ("wgpu", &["gpu/"]),
    ("bytemuck", &["gpu/"]),
    ("pollster", &["gpu/"]),
];

fn sources(folder: &Path, out: &mut Vec<(String, String)>, root: &Path) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, out, root);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let name = path
                .strip_prefix(root)
                .unwrap()
                .to_string_lossy()
                .replace('\\', "/");
            // Tests of a module may use anything.
            let text = std::fs::read_to_string(&path).unwrap();
            let text = text.split("#[cfg(test)]\nmod").next().unwrap().to_owned();
            if !name.ends_with("tests.rs") {
                out.push((name, text));
            }
        }
    }
}

/// Names behind `crate::` in code; comments are left out.
fn imports(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    for line in text.lines() {
        let line = line.trim_start();
        if line.starts_with("//") {
            continue;
        }
        for part in line.split("crate::").skip(1) {
            if let Some(group) = part.strip_prefix('{') {
                out.extend(
                    group
                        .split(',')
                        .map(|s| s.trim().split(':').next().unwrap_or("").to_owned()),
                );
            } else {
                out.push(
                    part.chars()
                        .take_while(|c| c.is_alphanumeric() || *c == '_')
                        .collect(),
                );
            }
        }
    }
    out
}

#[test]
fn modules_import_only_what_the_code_map_allows() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files, &root);
    let table: BTreeMap<&str, &[&str]> = ALLOWED.iter().copied().collect();
    let mut checked = 0;
    for (file, text) in &files {
        let module = file.split(['/', '.']).next().unwrap();
        if matches!(module, "lib" | "main" | "cli") {
            continue;
        }
        let allowed = table
            .get(module)
            .unwrap_or_else(|| panic!("{file} belongs to no module of the table"));
        for import in imports(text) {
            let ok = import == module || import.is_empty() || allowed.contains(&import.as_str());
            assert!(
                ok,
                "{file} names crate::{import}, which the code map does not allow"
            );
            checked += 1;
        }
    }
    assert!(checked > 30, "the test reads imports");
}

#[test]
fn packages_stay_in_their_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files, &root);
    for (package, homes) in PACKAGES {
        for (file, text) in &files {
            let named = text
                .lines()
                .any(|l| !l.trim_start().starts_with("//") && l.contains(&format!("{package}::")));
            assert!(
                !named || homes.iter().any(|h| file.starts_with(h)),
                "{file} names {package}"
            );
        }
    }
}
