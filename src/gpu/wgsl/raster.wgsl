// Micro-quads into keys by the device's own rasteriser, one pass for each sample of a pixel: an instance is a block, its vertices are pulled from
// diced points, fragments write ids, and these go into keys with their depths. Corners are snapped as for `tile`, then moved by what the sample
// is off the centre of its pixel, where the device looks.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> points: array<f32>;
@group(0) @binding(4) var<storage, read_write> keys: array<u32>;
// What faces are cut out by.
@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> materials: array<Material>;
@group(0) @binding(8) var<storage, read> uvs: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read> textures: array<u32>;
// Of blocks that are no grids.
@group(0) @binding(10) var<storage, read> lists: array<u32>;
// What one pass came to.
@group(0) @binding(11) var ids: texture_2d<u32>;
@group(0) @binding(12) var depths: texture_depth_2d;
// Blocks of a chunk that the device decides on: numbers, as many places for each size of a block, and what is drawn of each.
@group(0) @binding(13) var<storage, read_write> order: array<u32>;
@group(0) @binding(14) var<storage, read_write> draws: array<u32>;
@group(0) @binding(15) var<storage, read> totals: array<u32>;

@group(1) @binding(0) var<uniform> target_of: Target;

struct Corner {
    @builtin(position) place: vec4<f32>,
    // The complement of the id, as in keys: nothing is 0.
    @location(0) @interpolate(flat) key: u32,
}

// A point in clip space. One that `project` snaps comes out of the viewport where it was snapped to; others are left to the device to clip.
// Homogeneous coordinates may be scaled point by point: lines stay where they are.
fn placed(p: vec3<f32>) -> vec4<f32> {
    let centre = vec2<i32>(128, 128 - 256 * i32(frame.band_start));
    let shift = sample_offset(target_of.sample) - centre;
    let v = project(p);
    if v.depth != 0.0 {
        // Whole numbers below 2^24 times a power of two, less one: nothing is rounded.
        let at = vec2<f32>(vec2<i32>(v.x, v.y) - shift) * target_of.step - 1.0;
        let depth = v.depth * select(frame.near, 0.5, frame.ortho != 0u);
        return vec4<f32>(at.x, -at.y, clamp(depth, SMALLEST, 1.0), 1.0);
    }
    let h = homogeneous(p);
    let at = (h.xy - vec2<f32>(shift) * h.z) * target_of.step - h.z;
    return vec4<f32>(at.x, -at.y, select(frame.near, max(0.5 * h.w, SMALLEST), frame.ortho != 0u), h.z);
}

// A grid has every point twice, once for each half of the micro-quads around it: a triangle shows the half of all its corners, and the place
// of the first, which is never in the last row or column. Of a list every third vertex begins a triangle.
@vertex
fn corner(@builtin(vertex_index) vertex: u32, @location(0) number: u32) -> Corner {
    let block = blocks[number];
    var id = (chunk.first_rank + number) << (2u * frame.id_bits + 1u);
    if LISTED && block.list_count > 0u {
        let k = vertex / 3u;
        if k >= block.list_count {
            // Lists are drawn by the next power of two: one point three times.
            return Corner(vec4<f32>(0.0, 0.0, 0.0, 1.0), 0u);
        }
        let at = listed(block, k);
        let which = vertex % 3u;
        let point = select(select(at.c, at.m, which == 1u), at.a, which == 0u);
        return Corner(placed(position(point)), ~(id | k));
    }
    let side_len = (1u << block.log) + 1u;
    let point = vertex >> 1u;
    let line = point / side_len;
    id |= (((line << frame.id_bits) | (point - line * side_len)) << 1u) | (vertex & 1u);
    return Corner(placed(position(block.base + point)), ~id);
}

@fragment
fn seen(@builtin(position) place: vec4<f32>, @location(0) @interpolate(flat) key: u32) -> @location(0) u32 {
    let pixel = vec2<i32>(i32(place.x), i32(place.y) + i32(frame.band_start));
    if !shows(~key, pixel * 256 + sample_offset(target_of.sample)) {
        discard;
    }
    return key;
}

// What one pass came to, into keys: an invocation is a pixel.
@compute @workgroup_size(GROUP)
fn collect(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let pixel = own_index(group, lane);
    if pixel >= frame.width * (frame.band_end - frame.band_start) {
        return;
    }
    let at = vec2<u32>(pixel % frame.width, pixel / frame.width);
    let word = 2u * (pixel * frame.samples + target_of.sample);
    keys[word] = textureLoad(ids, at, 0).x;
    keys[word + 1u] = bitcast<u32>(textureLoad(depths, at, 0));
}

const SIZES = BLOCK_BITS + 1u;
const SORTERS = 256u;

var<workgroup> counts: array<u32, SIZES * SORTERS>;

// Blocks that the device decided on by their sizes, those of one size in their order: one workgroup, an even share for each invocation.
@compute @workgroup_size(SORTERS)
fn by_size(@builtin(local_invocation_index) lane: u32) {
    let count = totals[TOTAL_DRAWN];
    let share = (count + SORTERS - 1u) / SORTERS;
    let first = lane * share;
    let end = min(first + share, count);
    var next: array<u32, SIZES>;
    for (var k = first; k < end; k++) {
        next[blocks[k].log]++;
    }
    for (var size = 0u; size < SIZES; size++) {
        counts[size * SORTERS + lane] = next[size];
    }
    workgroupBarrier();
    // There is room for all blocks in every size.
    let room = arrayLength(&order) / SIZES;
    if lane < SIZES {
        var sum = 0u;
        for (var k = lane * SORTERS; k < (lane + 1u) * SORTERS; k++) {
            let own = counts[k];
            counts[k] = lane * room + sum;
            sum += own;
        }
        // Corners of an instance, instances, the first corner, and twice nothing.
        draws[5u * lane] = 6u << (2u * lane);
        draws[5u * lane + 1u] = sum;
        draws[5u * lane + 2u] = 2u * ((1u << (2u * lane)) - 1u);
        draws[5u * lane + 3u] = 0u;
        draws[5u * lane + 4u] = 0u;
    }
    workgroupBarrier();
    for (var size = 0u; size < SIZES; size++) {
        next[size] = counts[size * SORTERS + lane];
    }
    for (var k = first; k < end; k++) {
        let size = blocks[k].log;
        order[next[size]] = k;
        next[size]++;
    }
}
