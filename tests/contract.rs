//! What processor and device share has one layout, and all sources of the device's stages are valid: held by naga, without a GPU.

use earmark::gpu::records::{
    Block, Chunk, Edge, Face, Frame, Lift, Material, Mesh, Metric, Move, Outputs, Patch, Record,
    Rise, Room, Spot, Stencil, Target, words,
};
use earmark::gpu::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn parsed(source: &wgsl::Source) -> naga::Module {
    match naga::front::wgsl::parse_str(&source.text) {
        Ok(module) => module,
        Err(e) => panic!("{}: {}", source.name, e.emit_to_string(&source.text)),
    }
}

#[test]
fn sources_are_valid() {
    for source in wgsl::all() {
        let module = parsed(&source);
        let checked = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module);
        if let Err(e) = checked {
            panic!("{}: {}", source.name, e.emit_to_string(&source.text));
        }
        assert!(!module.entry_points.is_empty(), "{}", source.name);
    }
}

/// Members of a structure of the device as Rust would have them, and its size.
fn device_layout(module: &naga::Module, name: &str) -> (Vec<(String, usize, usize)>, usize) {
    let found = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, found)) = found else {
        panic!("no structure {name} in the sources");
    };
    let naga::TypeInner::Struct { members, span } = &found.inner else {
        panic!("{name} is no structure");
    };
    let all = members.iter().map(|m| {
        let size = module.types[m.ty].inner.size(module.to_ctx()) as usize;
        (m.name.clone().unwrap_or_default(), m.offset as usize, size)
    });
    (all.collect(), *span as usize)
}

fn check<R: Record>(module: &naga::Module) {
    let (members, size) = device_layout(module, R::NAME);
    let own: Vec<(String, usize, usize)> = R::layout()
        .into_iter()
        .map(|(name, offset, size)| (name.to_owned(), offset, size))
        .collect();
    assert_eq!(own, members, "{}", R::NAME);
    assert_eq!(R::SIZE, size, "{}", R::NAME);
    // Arrays of it have no gaps that the processor does not write.
    assert_eq!(R::SIZE % 16, 0, "{}", R::NAME);
}

#[test]
fn records_have_one_layout() {
    let module = parsed(&wgsl::shade(wgsl::Variant::ENDS[1]));
    check::<Frame>(&module);
    check::<Chunk>(&module);
    check::<Stencil>(&module);
    check::<Spot>(&module);
    check::<Lift>(&module);
    check::<Rise>(&module);
    check::<Face>(&module);
    check::<Block>(&module);
    check::<Move>(&module);
    check::<Material>(&module);
    check::<Mesh>(&module);
    check::<Metric>(&module);
    check::<Patch>(&module);
    check::<Edge>(&module);
    check::<Room>(&module);
    check::<Outputs>(&module);
    check::<Target>(&module);
}

#[test]
fn words_stand_where_fields_do() {
    let block = Block {
        face: 1,
        log: 5,
        level: 9,
        ..Block::default()
    };
    let out = words(&[block, Block::default()]);
    assert_eq!(out.len() * 4, 2 * Block::SIZE);
    for (name, value) in [("face", 1), ("log", 5), ("level", 9)] {
        let layout = Block::layout();
        let field = layout.iter().find(|f| f.0 == name).unwrap();
        assert_eq!(out[field.1 / 4], value, "{name}");
    }
}
