//! Files that are read and written.

use super::folder::Folder;
use earmark::files::{self, AtomicFile, FileErrorKind, FolderResolver};
use earmark::mesh::{ResolveError, Resolver};
use std::fs;
use std::io::Write;
use std::path::Path;

#[test]
fn outputs_appear_whole_or_not_at_all() {
    let folder = Folder::new("atomic");
    let out = folder.path("out.png");
    files::write_atomic(&out, b"first").unwrap();
    assert_eq!(fs::read(&out).unwrap(), b"first");
    // Dropped before it is done: the old file stays, and nothing else.
    let mut file = AtomicFile::create(&out).unwrap();
    file.write_all(&[7; 100_000]).unwrap();
    assert_eq!(folder.names().len(), 2);
    assert_eq!(fs::read(&out).unwrap(), b"first");
    drop(file);
    assert_eq!(fs::read(&out).unwrap(), b"first");
    assert_eq!(folder.names(), ["out.png"]);
    let mut file = AtomicFile::create(&out).unwrap();
    file.write_all(b"second").unwrap();
    file.commit().unwrap();
    assert_eq!(fs::read(&out).unwrap(), b"second");
    // A target that turns into a folder meanwhile.
    let late = folder.path("late");
    let file = AtomicFile::create(&late).unwrap();
    fs::create_dir(&late).unwrap();
    let error = file.commit().unwrap_err();
    assert!(error.to_string().ends_with("is a folder"), "{error}");
    assert_eq!(folder.names(), ["late", "out.png"]);
}

#[test]
fn outputs_go_only_where_a_file_may_be() {
    let folder = Folder::new("targets");
    fs::create_dir(folder.path("dir")).unwrap();
    let long = "x".repeat(300);
    for bad in [
        "dir",
        "dir/",
        "missing/out.png",
        "..",
        "nofile/",
        long.as_str(),
        "a\0b",
    ] {
        let error = files::write_atomic(&folder.path(bad), b"x").unwrap_err();
        assert_eq!(error.kind(), FileErrorKind::Io, "{error}");
        assert!(!error.to_string().contains('\0'));
        assert_eq!(folder.names(), ["dir"], "{bad}");
    }
    let error = files::write_atomic(Path::new(""), b"x").unwrap_err();
    assert_eq!(error.kind(), FileErrorKind::Io);
    let fixed = folder.path("fixed");
    fs::write(&fixed, b"keep").unwrap();
    let mut permissions = fs::metadata(&fixed).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&fixed, permissions).unwrap();
    assert!(
        files::write_atomic(&fixed, b"x")
            .unwrap_err()
            .to_string()
            .contains("write-protected")
    );
    assert_eq!(fs::read(&fixed).unwrap(), b"keep");
}

#[cfg(unix)]
#[test]
fn links_are_followed_to_files_and_nowhere_else() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("links");
    fs::write(folder.path("real"), b"old").unwrap();
    symlink(folder.path("real"), folder.path("link")).unwrap();
    files::write_atomic(&folder.path("link"), b"new").unwrap();
    assert_eq!(fs::read(folder.path("real")).unwrap(), b"new");
    assert!(
        fs::symlink_metadata(folder.path("link"))
            .unwrap()
            .is_symlink()
    );
    symlink(folder.path("none"), folder.path("dangling")).unwrap();
    symlink("/dev/null", folder.path("device")).unwrap();
    symlink(folder.path("loop"), folder.path("loop")).unwrap();
    for bad in ["dangling", "device", "loop"] {
        files::write_atomic(&folder.path(bad), b"x").unwrap_err();
        assert!(fs::symlink_metadata(folder.path(bad)).unwrap().is_symlink());
    }
    files::write_atomic(Path::new("/dev/null"), b"x").unwrap_err();
    use std::os::unix::fs::FileTypeExt;
    assert!(
        fs::metadata("/dev/null")
            .unwrap()
            .file_type()
            .is_char_device()
    );
    assert_eq!(
        folder.names(),
        ["dangling", "device", "link", "loop", "real"]
    );
}

#[test]
fn streams_and_files_keep_their_limits() {
    assert_eq!(files::read_stream("-", &b"12345"[..], 5).unwrap(), b"12345");
    let error = files::read_stream("-", &b"123456"[..], 5).unwrap_err();
    assert_eq!(error.kind(), FileErrorKind::Limit);
    let endless = std::io::repeat(b'v');
    assert_eq!(
        files::read_stream("-", endless, 1 << 20)
            .unwrap_err()
            .kind(),
        FileErrorKind::Limit
    );
    let folder = Folder::new("sizes");
    fs::write(folder.path("a"), b"12345").unwrap();
    assert_eq!(files::read_model(&folder.path("a"), 5).unwrap(), b"12345");
    assert_eq!(
        files::read_model(&folder.path("a"), 4).unwrap_err().kind(),
        FileErrorKind::Limit
    );
    assert!(files::same_file(
        &folder.path("a"),
        &folder
            .path("../")
            .join(folder.root().file_name().unwrap())
            .join("a")
    ));
    assert!(!files::same_file(&folder.path("a"), &folder.path("b")));
}

#[test]
fn the_reach_of_a_model_can_be_widened() {
    let folder = Folder::new("reach");
    fs::create_dir_all(folder.path("models")).unwrap();
    fs::create_dir_all(folder.path("textures")).unwrap();
    fs::write(folder.path("textures/a.png"), b"a").unwrap();
    fs::write(folder.path("models/m.obj"), b"m").unwrap();
    let mut narrow = FolderResolver::beside(&folder.path("models/m.obj")).unwrap();
    assert_eq!(narrow.read("./m.obj", 10).unwrap(), b"m");
    assert_eq!(narrow.read("../models/m.obj", 10).unwrap(), b"m");
    assert!(matches!(
        narrow.read("../textures/a.png", 10),
        Err(ResolveError::Refused(_))
    ));
    let mut wide = narrow.with_root(folder.root()).unwrap();
    assert_eq!(wide.read("..\\textures\\a.png", 10).unwrap(), b"a");
    assert!(matches!(
        wide.read("../../a.png", 10),
        Err(ResolveError::Refused(_))
    ));
    assert!(matches!(
        wide.read("../textures/a.png", 0),
        Err(ResolveError::TooLarge { limit: 0 })
    ));
}
