// What is written beside the picture (src/frame/aov.rs): an invocation is a pixel. Of its samples that show anything the one nearest to the centre
// says all but the coverage. Codes stand in the order of their bytes in files, as what differs from those of a pixel that shows nothing: a
// cleared buffer shows nothing. Blocks of other chunks are left to their turn.

@group(0) @binding(7) var<storage, read_write> codes: array<u32>;
@group(0) @binding(14) var<uniform> outputs: Outputs;

// Two bytes, the higher one first.
fn wide(code: u32) -> u32 {
    return (code >> 8u) | ((code & 255u) << 8u);
}

fn code(x: f32, low: f32, high: f32) -> u32 {
    return u32(clamp((x - low) / (high - low), 0.0, 1.0) * 65535.0 + 0.5);
}

fn opaque(r: u32, g: u32, b: u32) -> u32 {
    return r | (g << 8u) | (b << 16u) | (255u << 24u);
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let pixel = own_index(group, lane);
    if pixel >= frame.width * (frame.band_end - frame.band_start) {
        return;
    }
    var nearest = NONE;
    var count = 0u;
    for (var k = 0u; k < frame.samples; k++) {
        let sample = outputs.order[k >> 2u][k & 3u];
        if keys[2u * (pixel * frame.samples + sample) + 1u] != 0u {
            count++;
            if nearest == NONE {
                nearest = sample;
            }
        }
    }
    if nearest == NONE {
        return;
    }
    let id = unpack(~keys[2u * (pixel * frame.samples + nearest)]);
    if id.rank < chunk.first_rank || id.rank >= chunk.first_rank + chunk.blocks {
        return;
    }
    let origin = vec2<i32>(i32(pixel % frame.width), i32(frame.band_start + pixel / frame.width)) * 256;
    let s = shown(id, origin + sample_offset(nearest));
    let first = pixel * outputs.words;
    if outputs.depth != NONE {
        let depth = min(u32(depth01(s.place) * 65535.0 + 0.5), 65534u);
        codes[first + outputs.depth] = wide(depth) ^ 0xffffu;
    }
    if outputs.normal != NONE {
        let n = unit_normal(s) * 0.5 + 0.5;
        codes[first + outputs.normal] = opaque(quantized(n.x), quantized(n.y), quantized(n.z));
    }
    if outputs.position != NONE {
        let low = outputs.position_low;
        let high = outputs.position_high;
        let x = max(code(s.place.x, low.x, high.x), 1u);
        let y = max(code(s.place.y, low.y, high.y), 1u);
        let z = max(code(s.place.z, low.z, high.z), 1u);
        codes[first + outputs.position] = wide(x) | (wide(y) << 16u);
        codes[first + outputs.position + 1u] = wide(z);
    }
    if outputs.albedo != NONE {
        let c = albedo_of(s);
        codes[first + outputs.albedo] = opaque(encoded(c.x), encoded(c.y), encoded(c.z));
    }
    if outputs.uv != NONE && chunk.textured != 0u {
        let range = outputs.uv_range;
        codes[first + outputs.uv] = wide(code(s.uv.x, range.x, range.z)) | (wide(code(s.uv.y, range.y, range.w)) << 16u);
        codes[first + outputs.uv + 1u] = 0xffffu;
    }
    if outputs.face != NONE {
        let number = s.face + 1u;
        codes[first + outputs.face] = ((number >> 16u) & 255u) | (number & 0xff00u) | ((number & 255u) << 16u);
    }
    if outputs.level != NONE {
        codes[first + outputs.level] = (s.level + 1u) & 255u;
    }
    if outputs.coverage != NONE {
        codes[first + outputs.coverage] = (count * 255u + frame.samples / 2u) / frame.samples;
    }
}
