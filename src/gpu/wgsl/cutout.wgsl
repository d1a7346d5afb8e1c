// Faces with opacity maps: a sample shows them where the map is at least one half (src/frame/cutout.rs), so this is asked before keys are
// written.

// Whether the micro-triangle of an id is there at a place of the screen, 1/256 pixel.
fn shows(packed: u32, p: vec2<i32>) -> bool {
    if !CUT || chunk.cut == 0u {
        return true;
    }
    let id = unpack(packed);
    let block = blocks[id.rank - chunk.first_rank];
    let face = faces[block.face];
    // The last one, of faces without any, cuts nothing out.
    if face.uv_count == 0u || face.material >= arrayLength(&materials) - 1u || materials[face.material].opacity_map == NONE {
        return true;
    }
    let at = corners_of(block, id);
    let w = weights(position(at.a), position(at.m), position(at.c), at.half, p).w;
    let uv = (w.x * uvs[at.a] + w.y * uvs[at.m]) + w.z * uvs[at.c];
    return sample_opacity(materials[face.material].opacity_map, uv, footprint_at(block, id, at, w)) >= 0.5;
}
