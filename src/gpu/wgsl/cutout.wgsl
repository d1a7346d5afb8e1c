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
    let side_len = (1u << block.log) + 1u;
    let first = block.base + id.line * side_len + id.col;
    let at_m = first + select(1u, side_len, id.half == 1u);
    let at_c = first + side_len + 1u;
    let w = weights(position(first), position(at_m), position(at_c), id.half, p).w;
    let uv = (w.x * uvs[first] + w.y * uvs[at_m]) + w.z * uvs[at_c];
    return sample_opacity(materials[face.material].opacity_map, uv, footprint_at(block.base, side_len, id, w)) >= 0.5;
}
