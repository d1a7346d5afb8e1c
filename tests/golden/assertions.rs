//! The assertion bites: every way in which a picture can fail, what it leaves behind, and what takes it away again.

use earmark::compare::Tolerance;
use earmark::film::{DeepImage, Image};
use earmark::golden::{Goldens, Outcome, Verdict};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A crate of its own for one test.
struct Crate(PathBuf);

impl Crate {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("earmark-golden-{}-{n}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
    fn goldens(&self) -> Goldens {
        let goldens = Goldens::of(&self.0, "mine").blessing(false);
        goldens.leaving_in(&self.0.join("left"))
    }
    fn left(&self, name: &str) -> PathBuf {
        self.0.join("left").join(name)
    }
}

impl Drop for Crate {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn picture(seed: u8) -> Image {
    let mut image = Image::new(16, 12);
    for (k, b) in image.data.iter_mut().enumerate() {
        *b = (k as u8).wrapping_mul(7).wrapping_add(seed);
    }
    image
}

#[test]
fn a_picture_goes_from_new_to_golden_to_different() {
    let of = Crate::new();
    let goldens = of.goldens();
    let image = DeepImage::from(picture(1));
    // No golden yet.
    let failure = goldens.check("a/cube", &image).unwrap_err();
    assert_eq!(failure.verdict(), Some(&Verdict::New));
    assert!(of.left("new/a/cube.png").is_file() && failure.report().is_file());
    assert!(!goldens.file("a/cube").exists());
    // Accepted, it passes, and nothing is left of the failure.
    let blessing = goldens.clone().blessing(true);
    if std::env::var_os("CI").is_some() {
        goldens.write("a/cube", &image).unwrap();
    } else {
        assert_eq!(blessing.check("a/cube", &image).unwrap(), Outcome::Written);
    }
    assert_eq!(goldens.check("a/cube", &image).unwrap(), Outcome::Equal);
    for gone in ["index.html", "new/a/cube.png", "figures/a/cube.txt"] {
        assert!(!of.left(gone).exists(), "{gone}");
    }
    // One level of one byte is noticed, and the message says all there is to know.
    let mut changed = picture(1);
    changed.data[4 * (16 * 3 + 5) + 2] ^= 1;
    let failure = goldens
        .check("a/cube", &changed.clone().into())
        .unwrap_err();
    let text = failure.to_string();
    for part in [
        "picture \"a/cube\": different",
        "1 of 192 pixels differ (0.521 %), 0 of them visibly; inside 1x1 pixels at 5,3",
        "largest delta 1 of 255 at 5,3; pixels with a delta above 0: 1, above 1: 0",
        &goldens.file("a/cube").display().to_string(),
        &of.left("new/a/cube.png").display().to_string(),
        &of.left("difference/a/cube.png").display().to_string(),
        &of.left("index.html").display().to_string(),
        "EARMARK_BLESS=1",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    for kind in ["golden", "new", "difference"] {
        assert!(of.left(kind).join("a/cube.png").is_file());
    }
    let page = fs::read_to_string(failure.report()).unwrap();
    for part in [
        "a/cube",
        "new/a/cube.png",
        "difference/a/cube.png",
        "1 of 192",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // A tolerance lets it pass; a smaller one does not.
    let tolerant = |max_delta, max_pixels| {
        let goldens = goldens.clone().tolerating(Tolerance {
            max_delta,
            max_pixels,
        });
        goldens.check("a/cube", &changed.clone().into())
    };
    assert_eq!(tolerant(1, 0).unwrap(), Outcome::Within);
    assert!(!of.left("index.html").exists());
    assert_eq!(tolerant(0, 1).unwrap(), Outcome::Within);
    assert!(tolerant(0, 0).is_err());
}

#[test]
fn sizes_damage_and_names_are_failures_too() {
    let of = Crate::new();
    let goldens = of.goldens();
    goldens.write("x", &picture(1).into()).unwrap();
    let failure = goldens.check("x", &Image::new(12, 16).into()).unwrap_err();
    assert!(matches!(failure.verdict(), Some(Verdict::Size(_))));
    assert!(failure.to_string().contains("16x12 pixels against 12x16"));
    fs::write(goldens.file("x"), "no picture").unwrap();
    let failure = goldens.check("x", &picture(1).into()).unwrap_err();
    assert!(matches!(failure.verdict(), Some(Verdict::Unreadable(_))));
    let message = failure.to_string();
    assert!(
        message.contains("x.png") && message.contains("PNG"),
        "{message}"
    );
    for name in [
        "", "../x", "/x", "a//b", "a/../b", ".x", "a\\b", "a\nb", "c:x",
    ] {
        assert!(goldens.check(name, &picture(1).into()).is_err(), "{name:?}");
    }
    assert!(!of.0.join("x.png").exists());
    // A picture without pixels is none, accepted or not.
    for goldens in [of.goldens().blessing(true), of.goldens()] {
        let failure = goldens.check("none", &Image::new(0, 0).into()).unwrap_err();
        assert!(matches!(failure.verdict(), Some(Verdict::Unreadable(_))));
        assert!(!goldens.file("none").exists());
    }
}

#[test]
fn sixteen_bits_are_goldens_as_well() {
    let of = Crate::new();
    let goldens = of.goldens();
    let deep = DeepImage {
        width: 3,
        height: 1,
        bits: 16,
        data: (0..12).map(|k| k * 5000).collect(),
    };
    goldens.write("deep", &deep).unwrap();
    assert_eq!(goldens.check("deep", &deep).unwrap(), Outcome::Equal);
    let mut changed = deep.clone();
    changed.data[6] += 1;
    let failure = goldens.check("deep", &changed).unwrap_err();
    assert!(
        failure
            .to_string()
            .contains("largest delta 1 of 65535 at 1,0")
    );
}

#[test]
fn failures_of_many_threads_share_one_page() {
    let of = Crate::new();
    let goldens = of.goldens();
    std::thread::scope(|scope| {
        for k in 0..12_u8 {
            let goldens = &goldens;
            scope.spawn(move || {
                goldens
                    .check(&format!("p{k}"), &picture(k).into())
                    .unwrap_err()
            });
        }
    });
    let page = fs::read_to_string(of.left("index.html")).unwrap();
    for k in 0..12 {
        assert!(page.contains(&format!("new/p{k}.png")), "{k}");
    }
    assert!(page.contains("12 pictures do not pass"));
}

#[test]
fn the_macro_panics_with_the_message() {
    let of = Crate::new();
    let check = || {
        let manifest = of.0.to_str().unwrap();
        let tolerance = Tolerance::default();
        earmark::golden::assert_image_at(
            manifest,
            "assertions",
            "x",
            &picture(1).into(),
            tolerance,
        );
    };
    if std::env::var_os("EARMARK_BLESS").is_some() {
        return;
    }
    let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(check)).unwrap_err();
    let text = panic.downcast_ref::<String>().unwrap();
    assert!(text.contains("picture \"x\": without golden"), "{text}");
    // What it left is in the target folder, where the macro leaves it.
    let report = text.lines().find_map(|l| l.trim().strip_prefix("report:"));
    let left = PathBuf::from(report.unwrap().trim());
    assert!(left.ends_with("golden/assertions/index.html") && left.is_file());
    fs::remove_dir_all(left.parent().unwrap()).unwrap();
}
