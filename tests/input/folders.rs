//! Names of other files, and files that are none.

use super::folder::Folder;
use super::{V, printed, run};
use earmark::files::{self, FileErrorKind, FolderResolver};
use earmark::mesh::{ResolveError, Resolver, WarningKind};
use std::fs;
use std::path::Path;

/// A folder with one of models in it, and one in that.
fn models(name: &str) -> Folder {
    let folder = Folder::new(name);
    fs::create_dir_all(folder.path("models/sub")).unwrap();
    folder
}

#[test]
fn names_of_other_files_stay_in_the_folder() {
    let folder = models("names");
    fs::write(folder.path("secret.mtl"), b"newmtl m\nKd 1 0 0\n").unwrap();
    fs::write(folder.path("models/sub/in.mtl"), b"newmtl m\nKd 0 1 0\n").unwrap();
    fs::write(folder.path("models/big.mtl"), vec![b'#'; 100]).unwrap();
    let model = folder.path("models/m.obj");
    let mut resolver = FolderResolver::beside(&model).unwrap();
    let absolute = folder.path("secret.mtl");
    for bad in [
        "../secret.mtl",
        "sub/../../secret.mtl",
        "..\\secret.mtl",
        absolute.to_str().unwrap(),
        "/etc/passwd",
        "C:\\secret.mtl",
        "c:secret.mtl",
        "\\\\server\\share\\a.mtl",
        "http://example.org/a.mtl",
        "file:///etc/passwd",
        "a\0.mtl",
        "",
        ".",
        "..",
        "sub",
        "data:,x",
    ] {
        assert!(
            matches!(resolver.read(bad, 1000), Err(ResolveError::Refused(_))),
            "{bad}"
        );
        // Through the reader: a warning that names no content, and the mesh is there.
        let bytes = format!("mtllib {bad}\n{V}usemtl m\nf 1 2 3\n");
        let found = run(bytes.as_bytes(), &mut resolver).unwrap();
        assert_eq!(found.cage.materials()[0].diffuse, [0.8; 3], "{bad}");
        assert_eq!(found.warnings[0].kind(), WarningKind::Library, "{bad}");
        assert!(!printed(&Ok(found)).contains("root:"));
    }
    assert_eq!(resolver.read("none.mtl", 1000), Err(ResolveError::NotFound));
    assert_eq!(
        resolver.read("sub/in.mtl/x", 1000),
        Err(ResolveError::NotFound)
    );
    assert_eq!(
        resolver.read("big.mtl", 99),
        Err(ResolveError::TooLarge { limit: 99 })
    );
    for good in [
        "sub/in.mtl",
        "./sub/in.mtl",
        "sub\\in.mtl",
        "sub/../sub/in.mtl",
    ] {
        let bytes = format!("mtllib {good}\n{V}usemtl m\nf 1 2 3\n");
        let found = run(bytes.as_bytes(), &mut resolver).unwrap();
        assert_eq!(found.cage.materials()[0].diffuse, [0.0, 1.0, 0.0], "{good}");
        assert!(found.warnings.is_empty());
    }
    assert!(resolver.read(&"x/".repeat(5000), 1000).is_err());
    assert!(resolver.read(&"y".repeat(5000), 1000).is_err());
}

#[test]
fn models_are_regular_files() {
    let folder = models("models");
    let missing = files::read_model(&folder.path("none.obj"), 1000).unwrap_err();
    assert!(
        missing
            .to_string()
            .ends_with("none.obj: no such file or folder"),
        "{missing}"
    );
    assert_eq!(missing.kind(), FileErrorKind::Io);
    let directory = files::read_model(&folder.path("models"), 1000).unwrap_err();
    assert!(
        directory.to_string().ends_with("is a folder"),
        "{directory}"
    );
    fs::write(folder.path("a.obj"), b"").unwrap();
    assert_eq!(files::read_model(&folder.path("a.obj"), 1000).unwrap(), b"");
    assert!(files::read_model(&folder.path("a.obj/x"), 1000).is_err());
    assert!(files::read_model(Path::new(""), 1000).is_err());
    assert!(files::read_model(Path::new("a\0b"), 1000).is_err());
    // Sparse: large without taking space.
    let sparse = fs::File::create(folder.path("sparse.obj")).unwrap();
    sparse.set_len(1 << 40).unwrap();
    let error = files::read_model(&folder.path("sparse.obj"), 1 << 30).unwrap_err();
    assert_eq!(error.kind(), FileErrorKind::Limit);
}

#[cfg(unix)]
#[test]
fn links_pipes_and_devices() {
    use std::os::unix::fs::symlink;
    let folder = models("links");
    fs::write(folder.path("secret.mtl"), b"newmtl m\n").unwrap();
    fs::write(folder.path("models/in.mtl"), b"newmtl m\n").unwrap();
    symlink(folder.path("secret.mtl"), folder.path("models/out.mtl")).unwrap();
    symlink("../secret.mtl", folder.path("models/relative.mtl")).unwrap();
    symlink("in.mtl", folder.path("models/inside.mtl")).unwrap();
    symlink(folder.root(), folder.path("models/up")).unwrap();
    symlink("/dev/zero", folder.path("models/zero.mtl")).unwrap();
    symlink("loop.mtl", folder.path("models/loop.mtl")).unwrap();
    let socket = std::os::unix::net::UnixListener::bind(folder.path("models/s.mtl"));
    let mut resolver = FolderResolver::beside(&folder.path("models/m.obj")).unwrap();
    for bad in ["out.mtl", "relative.mtl", "up/secret.mtl", "zero.mtl"] {
        assert!(
            matches!(resolver.read(bad, 1000), Err(ResolveError::Refused(_))),
            "{bad}"
        );
    }
    assert!(matches!(
        resolver.read("loop.mtl", 1000),
        Err(ResolveError::Io(_))
    ));
    assert_eq!(resolver.read("inside.mtl", 1000).unwrap(), b"newmtl m\n");
    if socket.is_ok() {
        assert_eq!(
            resolver.read("s.mtl", 1000),
            Err(ResolveError::Refused("is a socket"))
        );
    }
    let pipe = folder.path("models/pipe.mtl");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if made.is_ok_and(|s| s.success()) {
        // Opening it the usual way would wait for a writer for ever.
        assert_eq!(
            resolver.read("pipe.mtl", 1000),
            Err(ResolveError::Refused("is a named pipe"))
        );
        let error = files::read_model(&pipe, 1000).unwrap_err();
        assert!(error.to_string().ends_with("is a named pipe"), "{error}");
        assert!(files::write_atomic(&pipe, b"x").is_err());
    }
    for device in ["/dev/null", "/dev/zero"] {
        let error = files::read_model(Path::new(device), 1000).unwrap_err();
        assert!(error.to_string().ends_with("is a device"), "{error}");
    }
    assert!(files::read_model(&folder.path("models/loop.mtl"), 1000).is_err());
    assert_eq!(
        files::read_model(&folder.path("models/out.mtl"), 1000).unwrap(),
        b"newmtl m\n"
    );
    if Path::new("/proc/kmsg").exists() {
        // Pseudo-files announce no bytes; nothing is read from them.
        assert!(
            files::read_model(Path::new("/proc/self/status"), 1000).is_ok_and(|b| b.is_empty())
        );
    }
}
