//! All generated files. A module of the example and of `tests/assets.rs`, which share this one source.

pub(crate) mod creature;
mod edit;
mod limbs;
pub(crate) mod mesh;
mod pack;
mod paint;
mod part;
pub(crate) mod refine;
mod teaching;
pub(crate) mod unwrap;

/// Name and content of every generated file.
pub(crate) fn files() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for (name, mesh) in teaching::all() {
        files.push((format!("{name}.obj"), mesh.to_obj().into_bytes()));
    }
    for (name, support) in [("part.obj", true), ("part_creased.obj", false)] {
        files.push((name.into(), part::build(support).to_obj().into_bytes()));
    }
    files.push(("part.mtl".into(), part::MATERIALS.as_bytes().to_vec()));
    let c = creature::build();
    files.push(("creature.obj".into(), c.mesh.to_obj().into_bytes()));
    files.push((
        "creature.mtl".into(),
        b"newmtl skin\nKd 1 1 1\nmap_Kd creature_skin.png\n".to_vec(),
    ));
    files.push(("creature_skin.png".into(), paint::skin(&c)));
    files
}
