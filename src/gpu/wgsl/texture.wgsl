// Textures as src/texture.rs has them, blended from the eight nearest texels of two levels.

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

fn texel(map: u32, at: u32) -> vec4<f32> {
    let first = textures[map + 2u];
    if textures[map + 4u] != 0u {
        let rg = textures[first + 2u * at];
        let ba = textures[first + 2u * at + 1u];
        return vec4<f32>(f32(rg & 0xffffu), f32(rg >> 16u), f32(ba & 0xffffu), f32(ba >> 16u)) * (1.0 / 65535.0);
    }
    let word = textures[first + at];
    let values = textures[map + 3u];
    return vec4<f32>(
        bitcast<f32>(textures[values + (word & 255u)]),
        bitcast<f32>(textures[values + ((word >> 8u) & 255u)]),
        bitcast<f32>(textures[values + ((word >> 16u) & 255u)]),
        f32(word >> 24u) * (1.0 / 255.0));
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

fn bilinear(map: u32, level: u32, u: f32, v: f32) -> vec4<f32> {
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

fn sample_texture(map: u32, uv: vec2<f32>, side: f32) -> vec4<f32> {
    let u = wrap(uv.x);
    let v = 1.0 - wrap(uv.y);
    let last = textures[map] - 1u;
    let lod = clamp(log2_rough(side) + bitcast<f32>(textures[map + 5u]), 0.0, f32(last));
    let level = u32(lod);
    let a = bilinear(map, level, u, v);
    return mix(a, bilinear(map, min(level + 1u, last), u, v), lod - f32(level));
}

// The texture as opacity: its alpha channel, or red where it has none.
fn sample_opacity(map: u32, uv: vec2<f32>, side: f32) -> f32 {
    let found = sample_texture(map, uv, side);
    return select(found.x, found.w, textures[map + 6u] != 0u);
}
