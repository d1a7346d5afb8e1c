// Projection and snapping, in the processor's order of operations (src/raster/project.rs), and sample places.

const GUARD_BAND = 4194304.0;
const SMALLEST = 1.17549435e-38;

struct Vertex {
    x: i32,
    y: i32,
    // 0 where the point is before the near plane or beyond the guard band.
    depth: f32,
}

fn row(r: vec4<f32>, p: vec3<f32>) -> f32 {
    return (r.x * p.x + r.y * p.y) + (r.z * p.z + r.w);
}

fn homogeneous(p: vec3<f32>) -> vec4<f32> {
    var w = 1.0;
    var d = 0.0;
    if frame.ortho != 0u {
        d = row(frame.d, p);
    } else {
        w = row(frame.w, p);
    }
    return vec4<f32>(row(frame.x, p), row(frame.y, p), w, d);
}

fn project(p: vec3<f32>) -> Vertex {
    let h = homogeneous(p);
    let before = select(h.z >= frame.near, h.w <= 2.0, frame.ortho != 0u);
    let w = select(1.0, h.z, before);
    let x = h.x / w;
    let y = h.y / w;
    if !(before && abs(x) < GUARD_BAND && abs(y) < GUARD_BAND) {
        return Vertex(0, 0, 0.0);
    }
    let depth = select(1.0 / w, max(h.w, SMALLEST), frame.ortho != 0u);
    return Vertex(i32(round(x)), i32(round(y)), depth);
}

// Offsets from a pixel's upper left, 1/256 pixel: src/raster/samples.rs.
const FOUR = array<vec2<i32>, 4>(vec2<i32>(96, 32), vec2<i32>(224, 96), vec2<i32>(32, 160), vec2<i32>(160, 224));
const EIGHT = array<vec2<i32>, 8>(
    vec2<i32>(144, 80), vec2<i32>(112, 176), vec2<i32>(208, 144), vec2<i32>(80, 48),
    vec2<i32>(48, 208), vec2<i32>(16, 112), vec2<i32>(176, 240), vec2<i32>(240, 16));
const SIXTEEN = array<vec2<i32>, 16>(
    vec2<i32>(144, 144), vec2<i32>(112, 80), vec2<i32>(80, 160), vec2<i32>(192, 112),
    vec2<i32>(48, 96), vec2<i32>(160, 208), vec2<i32>(208, 176), vec2<i32>(176, 48),
    vec2<i32>(96, 224), vec2<i32>(128, 16), vec2<i32>(64, 32), vec2<i32>(32, 192),
    vec2<i32>(0, 128), vec2<i32>(240, 64), vec2<i32>(224, 240), vec2<i32>(16, 0));

fn sample_offset(samples: u32, k: u32) -> vec2<i32> {
    var four = FOUR;
    var eight = EIGHT;
    var sixteen = SIXTEEN;
    switch samples {
        case 4u: { return four[k & 3u]; }
        case 8u: { return eight[k & 7u]; }
        case 16u: { return sixteen[k & 15u]; }
        default: { return vec2<i32>(128, 128); }
    }
}

// First pixel whose sample is at or after a place.
fn first_pixel(place: i32, offset: i32) -> i32 {
    return (place - offset + 255) >> 8u;
}

// The sign of an edge is positive where its value is at least this: a sample on an edge counts as moved by (+e, +e*e).
fn threshold(dx: i32, dy: i32) -> i32 {
    return select(1, 0, dy < 0 || (dy == 0 && dx > 0));
}
