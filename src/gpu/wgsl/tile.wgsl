// Micro-quads into keys: a workgroup projects the points of a block once, then each invocation draws quads. Quads of more than a few pixels,
// and those that have to be clipped, go to a list.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> points: array<f32>;
// What faces are cut out by.
@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> materials: array<Material>;
@group(0) @binding(8) var<storage, read> uvs: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read> textures: array<u32>;
// Of blocks that are no grids.
@group(0) @binding(10) var<storage, read> lists: array<u32>;
// Their number, then a quad each: block of the chunk, row and column.
@group(0) @binding(5) var<storage, read_write> large: array<atomic<u32>>;

// Largest extent, 1/256 pixel, of what one invocation draws: edge values stay far below 2^31.
const SMALL_EXTENT = 2048;

var<workgroup> screen: array<Vertex, BLOCK_SIDE * BLOCK_SIDE>;

fn triangle(a: Vertex, m: Vertex, c: Vertex, id: u32) {
    let low = vec2<i32>(min(a.x, min(m.x, c.x)), min(a.y, min(m.y, c.y)));
    let high = vec2<i32>(max(a.x, max(m.x, c.x)), max(a.y, max(m.y, c.y)));
    let e0 = vec2<i32>(m.x - a.x, m.y - a.y);
    let e1 = vec2<i32>(c.x - m.x, c.y - m.y);
    let e2 = vec2<i32>(a.x - c.x, a.y - c.y);
    let area = e0.x * (c.y - a.y) - e0.y * (c.x - a.x);
    if area == 0 {
        return;
    }
    let inverse = 1.0 / f32(abs(area));
    let t0 = threshold(e0.x, e0.y);
    let t1 = threshold(e1.x, e1.y);
    let t2 = threshold(e2.x, e2.y);
    for (var s = 0u; s < frame.samples; s++) {
        let offset = sample_offset(s);
        let x0 = max(first_pixel(low.x, offset.x), 0);
        let x1 = min(first_pixel(high.x, offset.x), i32(frame.width));
        let y0 = max(first_pixel(low.y, offset.y), i32(frame.band_start));
        let y1 = min(first_pixel(high.y, offset.y), i32(frame.band_end));
        for (var y = y0; y < y1; y++) {
            for (var x = x0; x < x1; x++) {
                let px = x * 256 + offset.x;
                let py = y * 256 + offset.y;
                let v0 = e0.x * (py - a.y) - e0.y * (px - a.x);
                let v1 = e1.x * (py - m.y) - e1.y * (px - m.x);
                let v2 = e2.x * (py - c.y) - e2.y * (px - c.x);
                let p0 = v0 >= t0;
                if p0 != (v1 >= t1) || p0 != (v2 >= t2) {
                    continue;
                }
                let w0 = f32(abs(v1));
                let w1 = f32(abs(v2));
                let w2 = f32(abs(v0));
                let depth = ((w0 * a.depth + w1 * m.depth) + w2 * c.depth) * inverse;
                let pixel = u32(y - i32(frame.band_start)) * frame.width + u32(x);
                if shows(id, vec2<i32>(px, py)) {
                    put_key(pixel * frame.samples + s, depth, id, chunk.phase);
                }
            }
        }
    }
}

// Leaves a micro-quad, or two triangles of a list, to `large`.
fn keep_large(number: u32, quad: u32) {
    // There is room for all.
    if chunk.phase == 0u {
        let slot = atomicAdd(&large[0], 1u);
        if slot < chunk.large {
            atomicStore(&large[1u + slot], (number << (2u * BLOCK_BITS)) | quad);
        }
    }
}

// Where low and high corners of what is not clipped are.
fn is_beside(low: vec2<i32>, high: vec2<i32>) -> bool {
    return high.x < 0 || low.x >= i32(frame.width) * 256 || high.y < i32(frame.band_start) * 256 || low.y >= i32(frame.band_end) * 256;
}

// A block that is a list of triangles, two by two.
fn draw_list(number: u32, lane: u32) {
    let block = blocks[number];
    for (var pair = lane; 2u * pair < block.list_count; pair += GROUP) {
        let end = min(2u * pair + 2u, block.list_count);
        var is_large = false;
        for (var k = 2u * pair; k < end; k++) {
            let at = listed(block, k);
            let a = screen[at.a - block.base];
            let m = screen[at.m - block.base];
            let c = screen[at.c - block.base];
            let low = min(vec2<i32>(a.x, a.y), min(vec2<i32>(m.x, m.y), vec2<i32>(c.x, c.y)));
            let high = max(vec2<i32>(a.x, a.y), max(vec2<i32>(m.x, m.y), vec2<i32>(c.x, c.y)));
            let clipped = a.depth == 0.0 || m.depth == 0.0 || c.depth == 0.0;
            let beside = !clipped && is_beside(low, high);
            is_large |= !beside && (clipped || max(high.x - low.x, high.y - low.y) > SMALL_EXTENT);
        }
        if is_large {
            keep_large(number, pair);
            continue;
        }
        for (var k = 2u * pair; k < end; k++) {
            let at = listed(block, k);
            let id = ((chunk.first_rank + number) << (2u * frame.id_bits + 1u)) | k;
            triangle(screen[at.a - block.base], screen[at.m - block.base], screen[at.c - block.base], id);
        }
    }
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = own_group(group);
    if number >= chunk.blocks {
        return;
    }
    let log = blocks[number].log;
    let base = blocks[number].base;
    let n = 1u << log;
    let side = n + 1u;
    for (var at = lane; at < side * side; at += GROUP) {
        let k = POINT_FLOATS * (base + at);
        screen[at] = project(vec3<f32>(points[k], points[k + 1u], points[k + 2u]));
    }
    workgroupBarrier();
    if LISTED && blocks[number].list_count > 0u {
        draw_list(number, lane);
        return;
    }
    for (var q = lane; q < n * n; q += GROUP) {
        let col = q & (n - 1u);
        let line = q >> log;
        let k = line * side + col;
        let a = screen[k];
        let b = screen[k + 1u];
        let c = screen[k + side + 1u];
        let d = screen[k + side];
        let low = min(min(vec2<i32>(a.x, a.y), vec2<i32>(b.x, b.y)), min(vec2<i32>(c.x, c.y), vec2<i32>(d.x, d.y)));
        let high = max(max(vec2<i32>(a.x, a.y), vec2<i32>(b.x, b.y)), max(vec2<i32>(c.x, c.y), vec2<i32>(d.x, d.y)));
        let clipped = a.depth == 0.0 || b.depth == 0.0 || c.depth == 0.0 || d.depth == 0.0;
        if !clipped && is_beside(low, high) {
            continue;
        }
        if clipped || max(high.x - low.x, high.y - low.y) > SMALL_EXTENT {
            keep_large(number, (line << BLOCK_BITS) | col);
            continue;
        }
        let rank = chunk.first_rank + number;
        let id = ((((rank << frame.id_bits) | line) << frame.id_bits) | col) << 1u;
        triangle(a, b, c, id);
        triangle(a, d, c, id | 1u);
    }
}
