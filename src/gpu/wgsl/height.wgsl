// Heights and their slopes: the arithmetic of src/displace/map.rs, noise.rs and function.rs.

struct Slope {
    h: f32,
    // By x, y and z of a function, by u and v of a map.
    by: vec3<f32>,
}

// The two texels around a coordinate along a side of n texels, and the share of the second.
struct Taps {
    a: u32,
    b: u32,
    t: f32,
}

// Beyond 2^23 there is no fraction.
fn bounded(x: f32) -> f32 {
    return select(0.0, x, abs(x) < 8388608.0);
}

fn taps(at: f32, n: u32) -> Taps {
    let x = bounded(at);
    let p = (x - floor(x)) * f32(n) - 0.5;
    let below = floor(p);
    let a = select(min(i32(below), i32(n) - 1), i32(n) - 1, below < 0.0);
    return Taps(u32(a), u32(select(a + 1, 0, a + 1 == i32(n))), min(p - below, 1.0));
}

fn texel_height(x: u32, y: u32) -> f32 {
    return heights[rise.first + y * rise.width + x];
}

fn map_at(u: f32, v: f32) -> f32 {
    let x = taps(u, rise.width);
    let y = taps(-v, rise.height);
    let low = mix(texel_height(x.a, y.a), texel_height(x.b, y.a), x.t);
    let high = mix(texel_height(x.a, y.b), texel_height(x.b, y.b), x.t);
    return mix(low, high, y.t);
}

// Differences of the map over steps to both sides.
fn map_slope(uv: vec2<f32>, d: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(
        (map_at(uv.x + d.x, uv.y) - map_at(uv.x - d.x, uv.y)) * (0.5 / d.x),
        (map_at(uv.x, uv.y + d.y) - map_at(uv.x, uv.y - d.y)) * (0.5 / d.y));
}

fn lattice_hash(p: vec3<i32>, seed: u32) -> u32 {
    let q = bitcast<vec3<u32>>(p);
    var h = (q.x * 0x8da6b343u) ^ (q.y * 0xd8163841u) ^ (q.z * 0xcb1ab31fu) ^ (seed * 0x9e3779b9u);
    h ^= h >> 16u;
    h *= 0x7feb352du;
    h ^= h >> 15u;
    h *= 0x846ca68bu;
    return h ^ (h >> 16u);
}

// One of the twelve directions to the middles of a cube's edges; four of them twice.
fn lattice_direction(hash: u32) -> vec3<f32> {
    let h = hash & 15u;
    let a = select(-1.0, 1.0, (h & 1u) == 0u);
    let b = select(-1.0, 1.0, (h & 2u) == 0u);
    let first_x = h < 8u;
    let second_y = h < 4u;
    let second_x = !second_y && (h == 12u || h == 14u);
    let x = select(select(0.0, b, second_x), a, first_x);
    let y = select(a, select(0.0, b, second_y), first_x);
    return vec3<f32>(x, y, select(b, 0.0, second_y || second_x));
}

// Perlin's blend and its derivative.
fn fade(t: f32) -> vec2<f32> {
    let s = t * t;
    return vec2<f32>(s * t * (t * (t * 6.0 - 15.0) + 10.0), 30.0 * s * (t * (t - 2.0) + 1.0));
}

fn lattice_corner(of_cell: vec3<i32>, place: vec3<f32>, at: vec3<i32>, seed: u32) -> vec4<f32> {
    let g = lattice_direction(lattice_hash(of_cell + at, seed));
    return vec4<f32>(dot(g, place - vec3<f32>(at)), g);
}

// The blend of two values along an axis, which adds its own derivative.
fn blend_along(a: vec4<f32>, b: vec4<f32>, t: vec2<f32>, axis: vec4<f32>) -> vec4<f32> {
    return a + (b - a) * t.x + axis * ((b.x - a.x) * t.y);
}

fn row_along_x(of_cell: vec3<i32>, place: vec3<f32>, b: i32, c: i32, seed: u32, t: vec2<f32>) -> vec4<f32> {
    let near = lattice_corner(of_cell, place, vec3<i32>(0, b, c), seed);
    let far = lattice_corner(of_cell, place, vec3<i32>(1, b, c), seed);
    return blend_along(near, far, t, vec4<f32>(0.0, 1.0, 0.0, 0.0));
}

// Value and gradient.
fn perlin(p: vec3<f32>, seed: u32) -> vec4<f32> {
    let inside_of = vec3<f32>(bounded(p.x), bounded(p.y), bounded(p.z));
    let below = floor(inside_of);
    let of_cell = vec3<i32>(below);
    let at = inside_of - below;
    let u = fade(at.x);
    let v = fade(at.y);
    let w = fade(at.z);
    let along_y = vec4<f32>(0.0, 0.0, 1.0, 0.0);
    let low = blend_along(row_along_x(of_cell, at, 0, 0, seed, u), row_along_x(of_cell, at, 1, 0, seed, u), v, along_y);
    let high = blend_along(row_along_x(of_cell, at, 0, 1, seed, u), row_along_x(of_cell, at, 1, 1, seed, u), v, along_y);
    return blend_along(low, high, w, vec4<f32>(0.0, 0.0, 0.0, 1.0));
}

// A ridge where noise is 0: from 1 there down to -1.
fn ridge(n: vec4<f32>) -> vec4<f32> {
    let side = select(1.0, -1.0, n.x < 0.0);
    let rest = max(1.0 - n.x * side, 0.0);
    return vec4<f32>(2.0 * rest * rest - 1.0, (-4.0 * rest * side) * n.yzw);
}

// Sine and cosine of a number of turns from 0 to 1, by series around the nearest quarter: WGSL's own are too rough.
fn turned(turns: f32) -> vec2<f32> {
    let quarter = floor(turns * 4.0 + 0.5);
    let x = (turns - quarter * 0.25) * 6.2831853;
    let z = x * x;
    let s = x * (1.0 + z * (-1.6666667e-1 + z * (8.3333310e-3 + z * (-1.9840874e-4 + z * 2.7525562e-6))));
    let c = 1.0 + z * (-0.5 + z * (4.1666667e-2 + z * (-1.3888889e-3 + z * (2.4801587e-5 - z * 2.7557319e-7))));
    switch u32(quarter) & 3u {
        case 0u: { return vec2<f32>(s, c); }
        case 1u: { return vec2<f32>(c, -s); }
        case 2u: { return vec2<f32>(-s, -c); }
        default: { return vec2<f32>(-c, s); }
    }
}

// Waves about a centre, which is rounded off.
fn ripples(p: vec3<f32>) -> vec4<f32> {
    let d = p - rise.center.xyz;
    let soft = 0.25 / rise.frequency;
    let r = sqrt(dot(d, d) + soft * soft);
    if !(r < 3.4e38) {
        return vec4<f32>(0.0);
    }
    let phase = rise.frequency * r - rise.time;
    let wave = turned(phase - floor(phase));
    return vec4<f32>(wave.y, d * (-wave.x * 6.2831853 * rise.frequency / r));
}

fn function_at(p: vec3<f32>) -> vec4<f32> {
    if rise.shape == RIPPLES {
        return ripples(p);
    }
    // At whole times noise of one seed, between them a blend of two that keeps its strength about. One call of all: the code is long.
    let time = bounded(rise.time);
    let whole = floor(time);
    let later = fade(time - whole).x;
    let blend_size = inverseSqrt((1.0 - later) * (1.0 - later) + later * later);
    let steps = select(2u, 1u, time == whole);
    var frequency = rise.frequency;
    var weight = rise.weight;
    var sum = vec4<f32>(0.0);
    var n = vec4<f32>(0.0);
    for (var k = 0u; k < rise.octaves * steps; k++) {
        let number = k % steps;
        let seed = rise.seed + k / steps + (bitcast<u32>(i32(whole)) + number) * 0x632be5abu;
        let share = select(select(1.0 - later, later, number == 1u) * blend_size, 1.0, steps == 1u);
        n += perlin(p * frequency, seed) * share;
        if number + 1u == steps {
            n = vec4<f32>(n.x, n.yzw * frequency);
            sum += select(n, ridge(n), rise.shape == RIDGED) * weight;
            n = vec4<f32>(0.0);
            frequency *= rise.lacunarity;
            weight *= rise.gain;
        }
    }
    return sum;
}

fn map_height(uv: vec2<f32>) -> f32 {
    return map_at(uv.x, uv.y) * rise.scale + rise.bias;
}

fn map_slopes(uv: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(map_slope(uv, vec2<f32>(0.5 / f32(rise.width), 0.5 / f32(rise.height))), 0.0);
}

// Height in model units at a limit point and its texture coordinates, and the slope of what it comes from.
fn height_at(p: vec3<f32>, uv: vec2<f32>) -> Slope {
    if rise.shape == MAP {
        return Slope(map_height(uv), map_slopes(uv));
    }
    let found = function_at(p);
    return Slope(found.x * rise.scale + rise.bias, found.yzw);
}
