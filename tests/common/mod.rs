//! Scenes and folders that several test targets use.
#![allow(dead_code, missing_docs, unreachable_pub)]

use earmark::golden::Goldens;
use earmark::load::{LoadOptions, Loader};
use earmark::topology::NONE;
use earmark::{Scene, Surface};
use std::path::{Path, PathBuf};

/// Folder of the project's own models.
pub fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

/// The golden pictures of this package stand beside its sources.
pub fn goldens() -> Goldens {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    Goldens::of(manifest, "earmark").in_folder(&manifest.join("golden"))
}

/// Folder of models and reference data outside the project, if the variable EARMARK_SHARED names it. A missing folder then fails.
pub fn shared() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("EARMARK_SHARED")?);
    assert!(
        folder.is_dir(),
        "EARMARK_SHARED names {}, which is no folder",
        folder.display()
    );
    Some(folder)
}

/// All OBJ files of a folder, by name.
pub fn models(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut found: Vec<PathBuf> = entries
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "obj"))
        .collect();
    found.sort();
    assert!(!found.is_empty(), "no models in {}", folder.display());
    found
}

pub fn name(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

pub fn load(path: &Path) -> Scene {
    let mut loader = Loader::new(LoadOptions::default());
    loader
        .add_file(path)
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    loader.finish().0
}

/// Whether every edge has two faces.
pub fn is_closed(surface: &Surface) -> bool {
    let t = surface.topology();
    (0..t.half_count() as u32).all(|h| t.twin(h) != NONE)
}

/// A deterministic stream of numbers (PCG).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let x = ((self.0 >> 18 ^ self.0) >> 27) as u32;
        x.rotate_right((self.0 >> 59) as u32)
    }
    /// Uniform in 0…1.
    pub fn unit(&mut self) -> f64 {
        f64::from(self.next()) / 4_294_967_296.0
    }
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
