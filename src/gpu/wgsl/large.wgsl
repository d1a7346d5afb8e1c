// Quads of many pixels and clipped ones: a workgroup each, invocations over pixels.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> points: array<f32>;
@group(0) @binding(5) var<storage, read> large: array<u32>;
// What faces are cut out by.
@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> materials: array<Material>;
@group(0) @binding(8) var<storage, read> uvs: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read> textures: array<u32>;
// Of blocks that are no grids.
@group(0) @binding(10) var<storage, read> lists: array<u32>;

// Extents, 1/256 pixel, up to which edge values fit 32 bits.
const NARROW_EXTENT = 16383;

fn triangle(a: Vertex, m: Vertex, c: Vertex, id: u32, lane: u32) {
    let low = vec2<i32>(min(a.x, min(m.x, c.x)), min(a.y, min(m.y, c.y)));
    let high = vec2<i32>(max(a.x, max(m.x, c.x)), max(a.y, max(m.y, c.y)));
    let pa = vec2<i32>(a.x, a.y);
    let pm = vec2<i32>(m.x, m.y);
    let pc = vec2<i32>(c.x, c.y);
    // Pixels that any sample of may be covered in.
    let x0 = max((low.x - 255) >> 8u, 0);
    let x1 = min((high.x >> 8u) + 1, i32(frame.width));
    let y0 = max((low.y - 255) >> 8u, i32(frame.band_start));
    let y1 = min((high.y >> 8u) + 1, i32(frame.band_end));
    if x0 >= x1 || y0 >= y1 {
        return;
    }
    let t = vec3<i32>(threshold((pm - pa).x, (pm - pa).y), threshold((pc - pm).x, (pc - pm).y), threshold((pa - pc).x, (pa - pc).y));
    let across = u32(x1 - x0);
    let count = across * u32(y1 - y0);
    let narrow = max(high.x - low.x, high.y - low.y) <= NARROW_EXTENT;
    let area = wide_size(wide_edge(pm - pa, pa, pc));
    if area == 0.0 {
        return;
    }
    let inverse = 1.0 / area;
    for (var k = lane; k < count; k += GROUP) {
        let x = x0 + i32(k % across);
        let y = y0 + i32(k / across);
        let pixel = u32(y - i32(frame.band_start)) * frame.width + u32(x);
        for (var s = 0u; s < frame.samples; s++) {
            let p = vec2<i32>(x, y) * 256 + sample_offset(s);
            var sizes: vec3<f32>;
            if narrow {
                let v = vec3<i32>(edge(pm - pa, pa, p), edge(pc - pm, pm, p), edge(pa - pc, pc, p));
                let side = v >= t;
                if side.x != side.y || side.x != side.z {
                    continue;
                }
                sizes = vec3<f32>(abs(v));
            } else {
                let v0 = wide_edge(pm - pa, pa, p);
                let v1 = wide_edge(pc - pm, pm, p);
                let v2 = wide_edge(pa - pc, pc, p);
                let first = wide_at_least(v0, t.x);
                if first != wide_at_least(v1, t.y) || first != wide_at_least(v2, t.z) {
                    continue;
                }
                sizes = vec3<f32>(wide_size(v0), wide_size(v1), wide_size(v2));
            }
            let depth = ((sizes.y * a.depth + sizes.z * m.depth) + sizes.x * c.depth) * inverse;
            if shows(id, p) {
                put_key(pixel * frame.samples + s, depth, id, chunk.phase);
            }
        }
    }
}

fn edge(d: vec2<i32>, a: vec2<i32>, p: vec2<i32>) -> i32 {
    return d.x * (p.y - a.y) - d.y * (p.x - a.x);
}

fn draw(a: u32, m: u32, c: u32, id: u32, lane: u32) {
    let va = project(position(a));
    let vm = project(position(m));
    let vc = project(position(c));
    if va.depth != 0.0 && vm.depth != 0.0 && vc.depth != 0.0 {
        triangle(va, vm, vc, id, lane);
        return;
    }
    clip_triangle(homogeneous(position(a)), homogeneous(position(m)), homogeneous(position(c)));
    for (var k = 2u; k < polygon_len; k++) {
        triangle(clip_vertex(polygon[0]), clip_vertex(polygon[k - 1u]), clip_vertex(polygon[k]), id, lane);
    }
}

@compute @workgroup_size(GROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let count = min(large[0], chunk.large);
    for (var k = group.x; k < count; k += groups.x) {
        let entry = large[1u + k];
        let mask = (1u << BLOCK_BITS) - 1u;
        let number = entry >> (2u * BLOCK_BITS);
        let block = blocks[number];
        let rank = chunk.first_rank + number;
        if LISTED && block.list_count > 0u {
            let pair = entry & ((1u << (2u * BLOCK_BITS)) - 1u);
            for (var t = 2u * pair; t < min(2u * pair + 2u, block.list_count); t++) {
                let at = listed(block, t);
                draw(at.a, at.m, at.c, (rank << (2u * frame.id_bits + 1u)) | t, lane);
            }
            continue;
        }
        let line = (entry >> BLOCK_BITS) & mask;
        let col = entry & mask;
        let side = (1u << block.log) + 1u;
        let at = block.base + line * side + col;
        let id = ((((rank << frame.id_bits) | line) << frame.id_bits) | col) << 1u;
        draw(at, at + 1u, at + side + 1u, id, lane);
        draw(at, at + side, at + side + 1u, id | 1u, lane);
    }
}
