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

struct Id {
    rank: u32,
    line: u32,
    col: u32,
    half: u32,
}

fn unpack(id: u32) -> Id {
    let mask = (1u << frame.id_bits) - 1u;
    return Id(id >> (2u * frame.id_bits + 1u), (id >> (frame.id_bits + 1u)) & mask, (id >> 1u) & mask, id & 1u);
}

fn position(at: u32) -> vec3<f32> {
    return vec3<f32>(points[POINT_FLOATS * at], points[POINT_FLOATS * at + 1u], points[POINT_FLOATS * at + 2u]);
}

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

struct Weights {
    w: vec3<f32>,
    // Which side is seen, by the snapped triangle; 0 where it is too thin, 2 where it was clipped.
    side: f32,
}

fn weights(a: vec3<f32>, m: vec3<f32>, c: vec3<f32>, half: u32, p: vec2<i32>) -> Weights {
    let va = project(a);
    let vm = project(m);
    let vc = project(c);
    var w: vec3<f32>;
    var side = 2.0;
    if va.depth != 0.0 && vm.depth != 0.0 && vc.depth != 0.0 {
        let pa = vec2<i32>(va.x, va.y);
        let pm = vec2<i32>(vm.x, vm.y);
        let pc = vec2<i32>(vc.x, vc.y);
        w = vec3<f32>(wide_size(wide_edge(pc - pm, pm, p)), wide_size(wide_edge(pa - pc, pc, p)), wide_size(wide_edge(pm - pa, pa, p)));
        if frame.ortho == 0u {
            w *= vec3<f32>(va.depth, vm.depth, vc.depth);
        }
        let area = wide_edge(pm - pa, pa, pc);
        let size = abs(pm - pa) + abs(pc - pa);
        let thin = wide_size(area) <= f32(size.x + size.y) + 2.0;
        let front = wide_is_negative(area) == (half == 0u);
        side = select(select(-1.0, 1.0, front), 0.0, thin);
    } else {
        let ha = homogeneous(a);
        let hm = homogeneous(m);
        let hc = homogeneous(c);
        let s = vec3<f32>(vec2<f32>(p), 1.0);
        w = vec3<f32>(
            dot(s, cross(hm.xyz, hc.xyz)),
            dot(s, cross(hc.xyz, ha.xyz)),
            dot(s, cross(ha.xyz, hm.xyz)));
        w = max(w / (w.x + w.y + w.z), vec3<f32>(0.0));
    }
    let sum = (w.x + w.y) + w.z;
    if sum > 0.0 && sum < 3.4e38 {
        return Weights(w * (1.0 / sum), side);
    }
    return Weights(vec3<f32>(1.0, 0.0, 0.0), side);
}

fn ray(p: vec2<i32>) -> vec3<f32> {
    let s = vec2<f32>(p);
    return frame.ray_x.xyz * s.x + (frame.ray_y.xyz * s.y + frame.ray_0.xyz);
}

// Side of the square in texture coordinates that covers the area of a pixel, from differences along the grid.
fn footprint(base: u32, side_len: u32, i: u32, j: u32) -> f32 {
    let i0 = base + j * side_len + max(i, 1u) - 1u;
    let i1 = base + j * side_len + min(i + 1u, side_len - 1u);
    let j0 = base + (max(j, 1u) - 1u) * side_len + i;
    let j1 = base + min(j + 1u, side_len - 1u) * side_len + i;
    let a = project(position(i0));
    let b = project(position(i1));
    let c = project(position(j0));
    let d = project(position(j1));
    let su = vec2<f32>(f32(b.x - a.x), f32(b.y - a.y)) / 256.0;
    let sv = vec2<f32>(f32(d.x - c.x), f32(d.y - c.y)) / 256.0;
    let tu = uvs[i1] - uvs[i0];
    let tv = uvs[j1] - uvs[j0];
    let pixels = abs(su.x * sv.y - su.y * sv.x);
    return sqrt(abs(tu.x * tv.y - tu.y * tv.x) / max(pixels, 1.0 / 256.0));
}

fn log2_rough(x: f32) -> f32 {
    let bits = bitcast<u32>(max(x, SMALLEST));
    let m = bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u) - 1.0;
    return f32(i32(bits >> 23u) - 127) + m * (1.346 - 0.346 * m);
}

// The fractional part, from 0 to below 1.
fn wrap(x: f32) -> f32 {
    if !(abs(x) < 16777216.0) {
        return 0.0;
    }
    let f = x - trunc(x);
    let g = select(f, f + 1.0, f < 0.0);
    return select(0.0, g, g < 1.0);
}

fn texel(map: u32, at: u32) -> vec3<f32> {
    let first = textures[map + 2u];
    if textures[map + 4u] != 0u {
        let rg = textures[first + 2u * at];
        let ba = textures[first + 2u * at + 1u];
        return vec3<f32>(f32(rg & 0xffffu), f32(rg >> 16u), f32(ba & 0xffffu)) * (1.0 / 65535.0);
    }
    let word = textures[first + at];
    let values = textures[map + 3u];
    return vec3<f32>(
        bitcast<f32>(textures[values + (word & 255u)]),
        bitcast<f32>(textures[values + ((word >> 8u) & 255u)]),
        bitcast<f32>(textures[values + ((word >> 16u) & 255u)]));
}

// The two texels around a coordinate along a side of n.
fn neighbours(x: f32, n: i32) -> vec2<i32> {
    let p = x * f32(n) - 0.5;
    var i = select(i32(p), -1, p < 0.0);
    i = select(select(i, i - n, i >= n), i + n, i < 0);
    return vec2<i32>(i, select(i + 1, 0, i + 1 == n));
}

fn share(x: f32, n: i32) -> f32 {
    let p = x * f32(n) - 0.5;
    return p - f32(select(i32(p), -1, p < 0.0));
}

fn bilinear(map: u32, level: u32, u: f32, v: f32) -> vec3<f32> {
    let sizes = textures[map + 1u] + 3u * level;
    let width = i32(textures[sizes]);
    let height = i32(textures[sizes + 1u]);
    let start = i32(textures[sizes + 2u]);
    let x = neighbours(u, width);
    let y = neighbours(v, height);
    let top = mix(texel(map, u32(start + y.x * width + x.x)), texel(map, u32(start + y.x * width + x.y)), share(u, width));
    let low = mix(texel(map, u32(start + y.y * width + x.x)), texel(map, u32(start + y.y * width + x.y)), share(u, width));
    return mix(top, low, share(v, height));
}

fn sample_texture(map: u32, uv: vec2<f32>, side: f32) -> vec3<f32> {
    let u = wrap(uv.x);
    let v = 1.0 - wrap(uv.y);
    let last = textures[map] - 1u;
    let lod = clamp(log2_rough(side) + bitcast<f32>(textures[map + 5u]), 0.0, f32(last));
    let level = u32(lod);
    let a = bilinear(map, level, u, v);
    return mix(a, bilinear(map, min(level + 1u, last), u, v), lod - f32(level));
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
    if frame.mode == NORMALS {
        if !has_direction(n) {
            n = geometric;
        }
        return select(vec3<f32>(0.5), unit(n) * 0.5 + 0.5, has_direction(n));
    }
    // The last one is that of faces without any.
    let material = materials[min(face.material, arrayLength(&materials) - 1u)];
    var albedo = material.diffuse.xyz;
    let textured = face.uv_count > 0u;
    if textured {
        let uv = (at.w.x * uvs[first] + at.w.y * uvs[at_m]) + at.w.z * uvs[at_c];
        if frame.mode == UV {
            return vec3<f32>(uv_color(uv.x), uv_color(uv.y), 0.0);
        }
        if material.map != NONE {
            let side = at.w.x * footprint(block.base, side_len, id.col, id.line)
                + at.w.y * footprint(block.base, side_len, id.col + select(1u, 0u, id.half == 1u), id.line + select(0u, 1u, id.half == 1u))
                + at.w.z * footprint(block.base, side_len, id.col + 1u, id.line + 1u);
            albedo *= sample_texture(material.map, uv, side);
        }
    } else if frame.mode == UV {
        return vec3<f32>(0.0);
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
        return light(n, at.side, to_eye, albedo);
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
    if frame.mode == LIT || frame.mode == FLAT {
        let seen = select(1.0, -1.0, dot(geometric, unit(to_eye)) < 0.0);
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
