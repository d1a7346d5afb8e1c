// A bound of how far a bicubic B-spline is from the two triangles of its corners: the arithmetic of src/tessellate/flatness/closed.rs.

// Control points of the face, row by row: as they are, and as the eye sees them, sheared.
var<workgroup> net: array<vec3<f32>, 16>;
var<workgroup> eye_net: array<vec3<f32>, 16>;

// In place of a number of samples where nothing has to be sampled.
const FLAT_FACE = 0u;

fn eye_size(v: vec3<f32>, spread: f32) -> f32 {
    return sqrt(v.x * v.x + v.y * v.y) + spread * abs(v.z);
}

// Second differences of points and of differences.
fn second(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    return (c - b) - (b - a);
}

fn mixed(k: u32) -> vec3<f32> {
    return (net[k + 5u] - net[k + 4u]) - (net[k + 1u] - net[k]);
}

fn along_u(k: u32) -> vec3<f32> {
    return second(net[k], net[k + 1u], net[k + 2u]);
}

fn along_v(k: u32) -> vec3<f32> {
    return second(net[k], net[k + 4u], net[k + 8u]);
}

// Bound of the angle in radians between normals and what interpolates those of the corners.
fn bound_angle() -> f32 {
    var a = vec3<f32>(0.0);
    var b = vec3<f32>(0.0);
    for (var k = 0u; k < 12u; k++) {
        let row = k / 3u * 4u + k % 3u;
        a += net[row + 1u] - net[row];
        b += net[k + 4u] - net[k];
    }
    a *= 1.0 / 12.0;
    b *= 1.0 / 12.0;
    var off = vec2<f32>(0.0);
    var uv = 0.0;
    var turn_u = 0.0;
    var turn_v = 0.0;
    var turns = vec4<f32>(0.0);
    for (var k = 0u; k < 12u; k++) {
        let row = k / 3u * 4u + k % 3u;
        off = max(off, vec2<f32>(length((net[row + 1u] - net[row]) - a), length((net[k + 4u] - net[k]) - b)));
    }
    for (var k = 0u; k < 9u; k++) {
        uv = max(uv, length(mixed(k / 3u * 4u + k % 3u)));
    }
    for (var k = 0u; k < 8u; k++) {
        turn_u = max(turn_u, length(along_u(k / 2u * 4u + k % 2u)));
        turn_v = max(turn_v, length(along_v(k)));
    }
    for (var k = 0u; k < 4u; k++) {
        turns.x = max(turns.x, length(along_u(4u * k + 1u) - along_u(4u * k)));
        turns.w = max(turns.w, length(along_v(k + 4u) - along_v(k)));
    }
    for (var k = 0u; k < 6u; k++) {
        let row = k / 2u * 4u + k % 2u;
        turns.y = max(turns.y, length(along_u(row + 4u) - along_u(row)));
        let column = k / 3u * 4u + k % 3u;
        turns.z = max(turns.z, length(mixed(column + 4u) - mixed(column)));
    }
    let area = length(cross(a, b));
    let la = length(a);
    let lb = length(b);
    let r = (la * off.y + off.x * lb + off.x * off.y) / area;
    if !(r < 0.3) {
        return 3.4e38;
    }
    let u = la + off.x;
    let v = lb + off.y;
    let most = (turns.x * v + 2.0 * turn_u * uv + u * turns.y)
        + 2.0 * (turns.y * v + turn_u * turn_v + u * turns.z)
        + (turns.z * v + 2.0 * uv * turn_v + u * turns.w);
    let left = 1.0 - r;
    return 0.125 * most / area * (1.0 + r) / (left * left) + 2.0 * r * r / (left * left);
}

// How many samples a face of these control points begins with, as a power of two, or FLAT_FACE.
fn first_log() -> u32 {
    var factor = metric.scale;
    var spread = 0.0;
    var nearest = 3.4e38;
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < 16u; k++) {
        eye_net[k] = to_eye(net[k]);
        nearest = min(nearest, eye_net[k].z);
        sum += eye_net[k];
    }
    if metric.ortho == 0u {
        if !(nearest > metric.near) {
            return 2u;
        }
        let t = sum.xy / sum.z;
        var off = 0.0;
        for (var k = 0u; k < 16u; k++) {
            let p = eye_net[k];
            let q = p.xy - t * p.z;
            eye_net[k] = vec3<f32>(q, p.z);
            off = max(off, q.x * q.x + q.y * q.y);
        }
        factor = metric.scale / nearest;
        spread = sqrt(off) / nearest;
    }
    var most = vec3<f32>(0.0);
    var sides = vec2<f32>(0.0);
    for (var k = 0u; k < 12u; k++) {
        let row = k / 3u * 4u + k % 3u;
        sides = max(sides, vec2<f32>(eye_size(eye_net[row + 1u] - eye_net[row], spread), eye_size(eye_net[k + 4u] - eye_net[k], spread)));
    }
    for (var k = 0u; k < 8u; k++) {
        let row = k / 2u * 4u + k % 2u;
        most.x = max(most.x, eye_size(second(eye_net[row], eye_net[row + 1u], eye_net[row + 2u]), spread));
        most.z = max(most.z, eye_size(second(eye_net[k], eye_net[k + 4u], eye_net[k + 8u]), spread));
    }
    for (var k = 0u; k < 9u; k++) {
        let at = k / 3u * 4u + k % 3u;
        most.y = max(most.y, eye_size((eye_net[at + 5u] - eye_net[at + 4u]) - (eye_net[at + 1u] - eye_net[at]), spread));
    }
    let far = 0.125 * (most.x + 2.0 * most.y + most.z) * factor;
    let times = far / (metric.whole_pixels * BOUND_SHARE);
    if times <= 1.0 && ((sides.x + sides.y) * factor <= 1.0 || bound_angle() <= metric.whole_radians * BOUND_SHARE) {
        return FLAT_FACE;
    }
    return select(2u, 3u, times > ROUGH && times < 3.4e38);
}
