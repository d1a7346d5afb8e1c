// Projection and snapping, in the processor's order of operations (src/raster/project.rs), and sample places.

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

// Offset of sample `k` from a pixel's upper left, 1/256 pixel.
fn sample_offset(k: u32) -> vec2<i32> {
    let pair = frame.offsets[k >> 1u];
    return select(pair.xy, pair.zw, (k & 1u) == 1u);
}

// First pixel whose sample is at or after a place.
fn first_pixel(place: i32, offset: i32) -> i32 {
    return (place - offset + 255) >> 8u;
}

// The sign of an edge is positive where its value is at least this: a sample on an edge counts as moved by (+e, +e*e).
fn threshold(dx: i32, dy: i32) -> i32 {
    return select(1, 0, dy < 0 || (dy == 0 && dx > 0));
}
