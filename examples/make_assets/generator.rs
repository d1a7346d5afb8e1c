//! All generated files. A module of the example and of `tests/assets.rs`, which share this one source.

pub(crate) mod mesh;
mod teaching;

/// Name and content of every generated file.
pub(crate) fn files() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for (name, mesh) in teaching::all() {
        files.push((format!("{name}.obj"), mesh.to_obj().into_bytes()));
    }
    files
}
