// Keys into colours: an invocation is a pixel. Samples that show one place of the surface are shaded together at the first of them, as on the
// processor (src/frame/visible.rs). Blocks of other chunks are left to their turn.

@group(0) @binding(7) var<storage, read_write> sums: array<vec4<f32>>;

fn color(id: Id, p: vec2<i32>) -> vec3<f32> {
    let s = shown(id, p);
    if frame.mode == DEPTH {
        return vec3<f32>(1.0 - depth01(s.place));
    }
    if frame.mode == UV {
        return select(vec3<f32>(0.0), vec3<f32>(uv_color(s.uv.x), uv_color(s.uv.y), 0.0), s.textured);
    }
    if frame.mode == NORMALS {
        return unit_normal(s) * 0.5 + 0.5;
    }
    var n = s.n;
    if frame.mode == LIT && s.side != 2.0 && !s.textured {
        let to_eye = ray(p);
        if !has_direction(n) {
            n = select(to_eye * select(sign(s.side), 1.0, s.side == 0.0), s.geometric, has_direction(s.geometric));
        }
        return light(n, side_seen(n, s.side, to_eye), to_eye, albedo_of(s));
    }
    var to_eye = frame.eye.xyz - s.place;
    if frame.ortho != 0u {
        to_eye = frame.back.xyz;
    }
    if !has_direction(n) {
        n = select(select(vec3<f32>(0.0, 0.0, 1.0), to_eye, has_direction(to_eye)), s.geometric, has_direction(s.geometric));
    }
    let geometric = select(n, s.geometric, has_direction(s.geometric));
    var seen = select(1.0, -1.0, dot(geometric, unit(to_eye)) < 0.0);
    if frame.mode == FLAT {
        return light(geometric, seen, to_eye, albedo_of(s));
    }
    // Relief does not say which side is seen.
    seen = side_seen(n, seen, to_eye);
    n = with_relief(s, n);
    if frame.mode == LIT {
        return light(n, seen, to_eye, albedo_of(s));
    }
    let facing = abs(dot(unit(n), unit(to_eye)));
    let tone = (0.55 + 0.45 * facing) * select(1.0, 0.86, (s.face & 1u) == 1u);
    var colors = LEVEL_COLORS;
    return colors[s.level % LEVEL_COUNT] * tone;
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
        let block = blocks[id.rank - chunk.first_rank];
        let reach = select((1u << block.log) / 8u, 0u, LISTED && block.list_count > 0u);
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
