// What a step of refinement adds, as a view sees it: the arithmetic of src/tessellate/flatness/screen.rs and surplus.rs.

@group(0) @binding(8) var<uniform> metric: Metric;

// A point as the eye sees it, and its unit normal.
struct Seen {
    p: vec3<f32>,
    n: vec3<f32>,
}

struct Added {
    // Distance, and that of normals, by what is allowed.
    far: f32,
    bend: f32,
    // The longest edge, in pixels.
    length: f32,
}

fn along(axis: vec4<f32>, d: vec3<f32>) -> f32 {
    return (axis.x * d.x + axis.y * d.y) + axis.z * d.z;
}

fn to_eye(p: vec3<f32>) -> vec3<f32> {
    let d = p - metric.eye.xyz;
    return vec3<f32>(along(metric.right, d), along(metric.up, d), along(metric.forward, d));
}

// What is nearer than the near plane is as far behind it.
fn depth_of(z: f32) -> f32 {
    return metric.near + abs(z - metric.near);
}

// How far `p` is from the middle of an edge from `a` to `b`.
fn surplus(p: Seen, a: Seen, b: Seen) -> Added {
    let m = (a.p.xy + b.p.xy) * 0.5;
    var e = p.p.xy - m;
    var l = b.p.xy - a.p.xy;
    var close = metric.scale;
    if metric.ortho == 0u {
        let z = vec3<f32>(depth_of(p.p.z), depth_of(a.p.z), depth_of(b.p.z));
        let zm = depth_of((a.p.z + b.p.z) * 0.5);
        // Without the difference of two large numbers.
        e -= m * ((z.x - zm) / zm);
        l -= a.p.xy * ((z.z - z.y) / z.y);
        close /= min(min(z.x, z.y), z.z);
    }
    let s = a.n + b.n;
    let square = (s.x * s.x + s.y * s.y) + s.z * s.z;
    // Where opposite normals meet, all is too far.
    var inverse = 0.0;
    if square >= 1e-12 {
        inverse = 1.0 / sqrt(square);
    }
    let t = p.n - s * inverse;
    return Added(
        sqrt(e.x * e.x + e.y * e.y) * (close * metric.pixels),
        sqrt((t.x * t.x + t.y * t.y) + t.z * t.z) * metric.chord,
        sqrt(l.x * l.x + l.y * l.y) * close);
}

fn most_added(a: Added, b: Added) -> Added {
    return Added(max(a.far, b.far), max(a.bend, b.bend), max(a.length, b.length));
}

// The larger of distance and bend, of triangles as long as `length`.
fn of_length(a: Added, length: f32) -> f32 {
    return select(a.far, max(a.far, a.bend), length > DOT);
}

// What a last step adds that is not followed by those that it asks for: normals of triangles of a few pixels do not show.
fn shortfall(a: Added) -> f32 {
    return select(a.far, max(a.far, a.bend), a.length > FEW_PIXELS);
}

// Whether triangles are too far that lack this step and the next one; later ones add `more` times as much as is to be expected.
fn is_far(own: Added, next: Added, more: f32) -> bool {
    let bent = own.length > DOT && more * (0.5 * own.bend + next.bend) > 1.0;
    return of_length(own, own.length) > 1.0 || more * (0.5 * own.far + next.far) > 1.0 || bent;
}

// A spot, as the eye sees it.
fn spot_at(at: u32) -> Seen {
    let k = POINT_FLOATS * at;
    return Seen(
        to_eye(vec3<f32>(points[k], points[k + 1u], points[k + 2u])),
        vec3<f32>(points[k + 3u], points[k + 4u], points[k + 5u]));
}
