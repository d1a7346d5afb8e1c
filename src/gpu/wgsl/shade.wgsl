// Keys into colours: an invocation is a pixel. Samples that show one place of the surface are shaded together at the first of them, as on the
// processor (src/frame/visible.rs). Blocks of other chunks are left to their turn.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> points: array<f32>;
// Two words per sample: the complement of the id, and the depth.
@group(0) @binding(4) var<storage, read> keys: array<u32>;
@group(0) @binding(5) var<storage, read> faces: array<Face>;
@group(0) @binding(6) var<storage, read> materials: array<Material>;
@group(0) @binding(7) var<storage, read_write> sums: array<vec4<f32>>;

@group(0) @binding(8) var<storage, read> uvs: array<vec2<f32>>;
// Textures one after the other, as src/texture.rs lays them out.
@group(0) @binding(9) var<storage, read> textures: array<u32>;

@group(0) @binding(10) var<storage, read> colors: array<f32>;

// Two vectors at each of the same places, which tilt normals.
@group(0) @binding(11) var<storage, read> tangents: array<f32>;
@group(0) @binding(12) var<uniform> rise: Rise;
@group(0) @binding(13) var<storage, read> heights: array<f32>;

fn normal_at(at: u32) -> vec3<f32> {
    return vec3<f32>(points[POINT_FLOATS * at + 3u], points[POINT_FLOATS * at + 4u], points[POINT_FLOATS * at + 5u]);
}

fn color_at(at: u32) -> vec3<f32> {
    return vec3<f32>(colors[3u * at], colors[3u * at + 1u], colors[3u * at + 2u]);
}

fn has_direction(v: vec3<f32>) -> bool {
    let d = dot(v, v);
    return d >= SMALLEST && d <= 3.4e38;
}

fn ray(p: vec2<i32>) -> vec3<f32> {
    let s = vec2<f32>(p);
    return frame.ray_x.xyz * s.x + (frame.ray_y.xyz * s.y + frame.ray_0.xyz);
}

fn tangent_at(at: u32, which: u32) -> vec3<f32> {
    let k = 6u * at + 3u * which;
    return vec3<f32>(tangents[k], tangents[k + 1u], tangents[k + 2u]);
}

fn color(id: Id, p: vec2<i32>) -> vec3<f32> {
    let block = blocks[id.rank - chunk.first_rank];
    let face = faces[block.face];
    let side_len = (1u << block.log) + 1u;
    let first = block.base + id.line * side_len + id.col;
    let at_m = first + select(1u, side_len, id.half == 1u);
    let at_c = first + side_len + 1u;
    let a = position(first);
    let m = position(at_m);
    let c = position(at_c);
    let at = weights(a, m, c, id.half, p);
    let place = (at.w.x * a + at.w.y * m) + at.w.z * c;
    if frame.mode == DEPTH {
        let distance = dot(-frame.back.xyz, place) + frame.back.w;
        let d = (distance - frame.depth_near) / (frame.depth_far - frame.depth_near);
        return vec3<f32>(1.0 - clamp(d, 0.0, 1.0));
    }
    var geometric = cross(m - a, c - a) * select(1.0, -1.0, id.half == 1u);
    var n = (at.w.x * normal_at(first) + at.w.y * normal_at(at_m)) + at.w.z * normal_at(at_c);
    // The last one is that of faces without any.
    let material = materials[min(face.material, arrayLength(&materials) - 1u)];
    var albedo = material.diffuse.xyz;
    let textured = chunk.textured != 0u && face.uv_count > 0u;
    let is_tilted = TILTED && textured && chunk.tangents != 0u;
    var uv = vec2<f32>(0.0);
    var side = 0.0;
    var along = vec3<f32>(0.0);
    var across = vec3<f32>(0.0);
    if textured {
        uv = (at.w.x * uvs[first] + at.w.y * uvs[at_m]) + at.w.z * uvs[at_c];
        if frame.mode == UV {
            return vec3<f32>(uv_color(uv.x), uv_color(uv.y), 0.0);
        }
        if material.map != NONE || is_tilted {
            side = footprint_at(block.base, side_len, id, at.w);
        }
        if material.map != NONE {
            albedo *= sample_texture(material.map, uv, side).xyz;
        }
    } else if frame.mode == UV {
        return vec3<f32>(0.0);
    }
    if is_tilted {
        along = (at.w.x * tangent_at(first, 0u) + at.w.y * tangent_at(at_m, 0u)) + at.w.z * tangent_at(at_c, 0u);
        across = (at.w.x * tangent_at(first, 1u) + at.w.y * tangent_at(at_m, 1u)) + at.w.z * tangent_at(at_c, 1u);
        if rise.per_pixel != 0u {
            let size = vec2<f32>(f32(rise.width), f32(rise.height));
            let slope = map_slope(uv, slope_step(size, side));
            n -= along * slope.x + across * slope.y;
        }
    }
    let is_relief = is_tilted && rise.per_pixel == 0u;
    if frame.mode == NORMALS {
        if is_relief {
            n = tilted(material, n, along, across, uv, side);
        }
        if !has_direction(n) {
            n = geometric;
        }
        return select(vec3<f32>(0.5), unit(n) * 0.5 + 0.5, has_direction(n));
    }
    if face.colors > 0u {
        let c = (at.w.x * color_at(first) + at.w.y * color_at(at_m)) + at.w.z * color_at(at_c);
        albedo *= max(c, vec3<f32>(0.0));
    }
    if frame.mode == LIT && at.side != 2.0 && !textured {
        let to_eye = ray(p);
        if !has_direction(n) {
            n = select(to_eye * select(sign(at.side), 1.0, at.side == 0.0), geometric, has_direction(geometric));
        }
        return light(n, side_seen(n, at.side, to_eye), to_eye, albedo);
    }
    var to_eye = frame.eye.xyz - place;
    if frame.ortho != 0u {
        to_eye = frame.back.xyz;
    }
    if !has_direction(n) {
        n = select(select(vec3<f32>(0.0, 0.0, 1.0), to_eye, has_direction(to_eye)), geometric, has_direction(geometric));
    }
    if !has_direction(geometric) {
        geometric = n;
    }
    var seen = select(1.0, -1.0, dot(geometric, unit(to_eye)) < 0.0);
    if frame.mode != FLAT {
        // Relief does not say which side is seen.
        seen = side_seen(n, seen, to_eye);
    }
    if is_relief && frame.mode != FLAT {
        n = tilted(material, n, along, across, uv, side);
    }
    if frame.mode == LIT || frame.mode == FLAT {
        if frame.mode == FLAT {
            n = geometric;
        }
        return light(n, seen, to_eye, albedo);
    }
    let facing = abs(dot(unit(n), unit(to_eye)));
    let tone = (0.55 + 0.45 * facing) * select(1.0, 0.86, (face.number & 1u) == 1u);
    var colors = LEVEL_COLORS;
    return colors[block.level % LEVEL_COUNT] * tone;
}

fn uv_color(x: f32) -> f32 {
    return select(x - floor(x), x, x >= 0.0 && x <= 1.0);
}

fn near(a: Id, b: Id, reach: u32) -> bool {
    if a.rank != b.rank {
        return false;
    }
    if reach == 0u {
        return a.line == b.line && a.col == b.col && a.half == b.half;
    }
    return max(a.col, b.col) - min(a.col, b.col) <= reach && max(a.line, b.line) - min(a.line, b.line) <= reach;
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let pixel = own_index(group, lane);
    let rows = frame.band_end - frame.band_start;
    if pixel >= frame.width * rows {
        return;
    }
    let origin = vec2<i32>(i32(pixel % frame.width), i32(frame.band_start + pixel / frame.width)) * 256;
    // Samples that are in a fragment already.
    var done = 0u;
    var sum = vec4<f32>(0.0);
    for (var s = 0u; s < frame.samples; s++) {
        let word = 2u * (pixel * frame.samples + s);
        if (done & (1u << s)) != 0u || keys[word + 1u] == 0u {
            continue;
        }
        let id = unpack(~keys[word]);
        if id.rank < chunk.first_rank || id.rank >= chunk.first_rank + chunk.blocks {
            continue;
        }
        var count = 1.0;
        // Shaded together under light alone: other pictures show each sample.
        let reach = (1u << blocks[id.rank - chunk.first_rank].log) / 8u;
        if frame.mode == LIT {
            for (var t = s + 1u; t < frame.samples; t++) {
                let other = 2u * (pixel * frame.samples + t);
                if (done & (1u << t)) == 0u && keys[other + 1u] != 0u && near(id, unpack(~keys[other]), reach) {
                    done |= 1u << t;
                    count += 1.0;
                }
            }
        }
        let rgb = color(id, origin + sample_offset(s));
        sum += vec4<f32>(clamp(rgb, vec3<f32>(0.0), vec3<f32>(1.0)), 1.0) * count;
    }
    if sum.w > 0.0 {
        sums[pixel] += sum;
    }
}
