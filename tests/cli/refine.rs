//! `earmark refine`.

use crate::harness::{Folder, assert_clean, asset, code, earmark, kept, run, stderr, stdout};
use std::fs;

#[test]
fn schemes_of_refine() {
    let folder = Folder::new("schemes");
    let model = |name: &str, text: &str| {
        let path = folder.path(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let tetrahedron = model(
        "tetrahedron.obj",
        "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n",
    );
    let mixed = model(
        "mixed.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 2 5 3\nf 1 2 3 4\nt crease 2/1/0 1 2 0.5\n",
    );
    let refine = |flags: &[&str], model: &str| {
        let mut all = vec!["refine", "-l", "1", "-o", "-"];
        all.extend(flags);
        all.push(model);
        run(&all)
    };
    let lines = |out: &std::process::Output, key: &str| -> Vec<String> {
        assert_eq!(code(out), 0, "{}", stderr(out));
        let text = stdout(out);
        let of_key = text.lines().filter(|l| l.starts_with(key));
        of_key.map(str::to_owned).collect()
    };
    let corners = |face: &String| face.split_whitespace().count() - 1;

    // Loop is for cages of triangles alone, and then it is the default.
    let out = refine(&[], &tetrahedron);
    assert_eq!((lines(&out, "v ").len(), lines(&out, "f ").len()), (10, 16));
    assert!(lines(&out, "f ").iter().all(|f| corners(f) == 3));
    assert_eq!(
        out.stdout,
        refine(&["--scheme", "loop"], &tetrahedron).stdout
    );
    let out = refine(&["--scheme", "catmull-clark"], &tetrahedron);
    assert!(lines(&out, "f ").iter().all(|f| corners(f) == 4));
    let out = refine(&[], &mixed);
    assert_eq!(lines(&out, "f ").len(), 7);

    // Butterfly, Kobbelt and bilinear keep the vertices.
    for scheme in ["butterfly", "kobbelt", "bilinear"] {
        let out = refine(&["--scheme", scheme], &tetrahedron);
        assert_eq!(
            lines(&out, "v ")[..4],
            ["v 1 1 1", "v 1 -1 -1", "v -1 1 -1", "v -1 -1 1"]
        );
    }

    // Other faces are refused by line, or made triangles.
    for scheme in ["loop", "butterfly"] {
        let out = refine(&["--scheme", scheme], &mixed);
        assert_eq!(code(&out), 3);
        let message = assert_clean(&out);
        assert!(
            message.contains("mixed.obj:7:") && message.contains("4 corners"),
            "{message}"
        );
        let out = refine(&["--scheme", scheme, "--triangulate"], &mixed);
        assert_eq!(lines(&out, "f ").len(), 12);
    }

    // Semi-sharp creases mean nothing to interpolating schemes, which say so.
    let out = refine(&["--scheme", "kobbelt"], &mixed);
    assert!(stderr(&out).contains("semi-sharp"), "{}", stderr(&out));
    assert!(!stderr(&refine(&["--scheme", "bilinear"], &mixed)).contains("semi-sharp"));

    let rule = |flags: &[&str], model: &str| {
        let mut all = vec!["info", "--json"];
        all.extend(flags);
        all.push(model);
        let json: serde_json::Value = serde_json::from_str(&stdout(&run(&all))).unwrap();
        let of = |key: &str| json["rules"]["scheme"][key].as_str().unwrap().to_owned();
        (of("value"), of("from"))
    };
    let is = |value: &str, from: &str| (value.to_owned(), from.to_owned());
    assert_eq!(rule(&[], &tetrahedron), is("loop", "default"));
    assert_eq!(rule(&[], &mixed), is("catmull-clark", "default"));
    assert_eq!(
        rule(&["--scheme", "kobbelt"], &mixed),
        is("kobbelt", "flag")
    );
}

#[test]
fn refine_writes_meshes_that_can_be_read_again() {
    let folder = Folder::new("refine");
    let out = folder.path("out.obj");
    let result = earmark()
        .args(["refine", "--level", "3"])
        .arg(asset("cube.obj"))
        .arg("-o")
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    let json = stdout(&run(&["info", "--json", out.to_str().unwrap()]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["faces"], 6 * 64);
    assert_eq!(json["vertices"], 6 * 64 + 2);

    // Limit points of the cube's corners; holes are left out.
    let model = folder.path("hole.obj");
    fs::write(&model, kept(&asset("cube.obj")) + "\nt hole 1/0/0 5\n").unwrap();
    let result = earmark()
        .args(["refine", "-l", "1", "--limit", "-o", "-"])
        .arg(&model)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    let text = stdout(&result);
    let count = |key: &str| text.lines().filter(|l| l.starts_with(key)).count();
    assert_eq!((count("f "), count("vn ")), (5 * 4, 26));

    let ply = folder.path("out.ply");
    let result = earmark()
        .args(["refine", "-l", "1"])
        .arg(asset("creature.obj"))
        .arg("-o")
        .arg(&ply)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    assert!(fs::read(&ply).unwrap().starts_with(b"ply\n"));

    // A thousand million faces are refused at once.
    let result = earmark()
        .args(["refine", "-l", "10"])
        .arg(asset("creature.obj"))
        .arg("-o")
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(code(&result), 5, "{}", stderr(&result));
    assert_eq!(folder.names(), ["hole.obj", "out.obj", "out.ply"]);
}

#[test]
fn refined_materials_are_found_from_the_output() {
    let folder = Folder::new("library");
    fs::create_dir(folder.path("in")).unwrap();
    for name in ["part.obj", "part.mtl"] {
        fs::copy(asset(name), folder.path("in").join(name)).unwrap();
    }
    for out in ["in/out.obj", "out.obj"] {
        let result = earmark()
            .args(["refine", "-l", "1"])
            .arg(folder.path("in/part.obj"))
            .arg("-o")
            .arg(folder.path(out))
            .output()
            .unwrap();
        assert_eq!(code(&result), 0, "{}", stderr(&result));
    }
    let json = stdout(&run(&[
        "info",
        "--json",
        folder.path("in/out.obj").to_str().unwrap(),
    ]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["materials"].as_array().unwrap().len(), 2);
    assert_eq!(json["warnings"].as_array().unwrap().len(), 0, "{json}");
    assert!(kept(&folder.path("out.obj")).starts_with("mtllib in/part.mtl\n"));
}
