//! A second crate takes golden pictures into use as the guide says, in a folder of its own, without network.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const GUIDE: &str = include_str!("../../src/golden/guide.md");

/// The first block of a language in the guide, without lines that the documentation hides.
fn block(language: &str) -> String {
    let begin = GUIDE.find(&format!("```{language}")).unwrap();
    let lines = GUIDE[begin..].lines().skip(1);
    let lines = lines.take_while(|l| !l.starts_with("```"));
    let lines = lines.filter(|l| !l.starts_with("# "));
    lines.map(|l| format!("{l}\n")).collect()
}

/// What the crate draws, which is its own business.
const DRAW: &str = r#"
use earmark::{Cage, Camera, Renderer, Scene, Surface};

fn draw() -> earmark::film::Image {
    let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
    let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    let cage = Cage::new(points, &[4; 6], corners).unwrap();
    let scene = Scene::of(Surface::new(cage, &Default::default()));
    let turned = std::env::var_os("TURNED").is_some();
    let camera = Camera::default().with_orbit(if turned { 47.0 } else { 45.0 }, 25.0);
    Renderer::new(96, 96).render(&scene, &camera).unwrap().image
}
"#;

struct Adopter {
    folder: PathBuf,
    target: PathBuf,
}

impl Adopter {
    fn test(&self, variables: &[&str]) -> Output {
        let mut cargo = Command::new(env!("CARGO"));
        cargo
            .current_dir(&self.folder)
            .args(["test", "--offline", "--quiet"])
            // What it depends on is built already, with the settings of this package; of earmark itself it takes another build.
            .env("CARGO_TARGET_DIR", &self.target)
            .env("CARGO_PROFILE_DEV_OPT_LEVEL", "2")
            .env("CARGO_PROFILE_DEV_DEBUG", "line-tables-only")
            .args(["--config", "profile.dev.package.earmark.opt-level=0"])
            .env("CARGO_INCREMENTAL", "0")
            .env_remove("EARMARK_BLESS")
            .env_remove("CI");
        for variable in variables {
            cargo.env(variable, "1");
        }
        cargo.output().unwrap()
    }
}

fn text(out: &Output) -> String {
    String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr)
}

#[test]
fn another_crate_adopts_goldens_by_the_guide() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::env::temp_dir().join(format!("earmark-adopter-{}", std::process::id()));
    fs::create_dir_all(folder.join("tests")).unwrap();
    fs::create_dir_all(folder.join("src")).unwrap();
    let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let adopter = Adopter {
        folder: folder.clone(),
        target: tmp.parent().unwrap().to_owned(),
    };
    // The lines that the guide asks for.
    let (dependency, test) = (block("toml"), block("rust"));
    let lines = dependency.lines().count() + test.lines().count();
    println!("lines to adopt golden pictures: {lines}");
    assert!(lines <= 7, "{lines} lines:\n{dependency}\n{test}");
    let path = format!("path = {:?}", here.display().to_string());
    let local = dependency.replace("version = \"0.1\"", &path);
    assert_ne!(local, dependency);
    let package =
        "[package]\nname = \"adopter\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[workspace]\n\n";
    fs::write(folder.join("Cargo.toml"), package.to_owned() + &local).unwrap();
    fs::copy(here.join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
    fs::write(folder.join("src/lib.rs"), "").unwrap();
    fs::write(folder.join("tests/pictures.rs"), DRAW.to_owned() + &test).unwrap();
    let golden = folder.join("tests/golden/model.png");
    let left = adopter.target.join("golden/adopter");
    let _ = fs::remove_dir_all(&left);

    let first = adopter.test(&[]);
    assert!(!first.status.success() && !golden.exists());
    assert!(
        text(&first).contains("picture \"model\": without golden"),
        "{}",
        text(&first)
    );
    // Nobody looks at pictures in CI.
    let refused = adopter.test(&["EARMARK_BLESS", "CI"]);
    assert!(!refused.status.success() && !golden.exists());
    let accepted = adopter.test(&["EARMARK_BLESS"]);
    assert!(accepted.status.success(), "{}", text(&accepted));
    assert!(golden.is_file() && !left.join("index.html").exists());
    let passes = adopter.test(&[]);
    assert!(passes.status.success(), "{}", text(&passes));
    let changed = adopter.test(&["TURNED"]);
    assert!(!changed.status.success());
    let message = text(&changed);
    for part in [
        "picture \"model\": different",
        " pixels differ (",
        "pixels with a delta above 0: ",
        "tests/golden/model.png",
        "golden/adopter/new/model.png",
        "golden/adopter/difference/model.png",
        "golden/adopter/index.html",
    ] {
        assert!(message.contains(part), "{part} in {message}");
    }
    let page = fs::read_to_string(left.join("index.html")).unwrap();
    assert!(page.contains("difference/model.png") && !page.contains("http:"));
    fs::remove_dir_all(&folder).unwrap();
}
