// Triangles against the near plane and the guard band, in homogeneous space (Sutherland, Hodgman, Reentrant polygon clipping, 1974). Every
// new point is computed from the end inside to the end outside, so both triangles on an edge get the same bits.

var<private> polygon: array<vec4<f32>, 8>;
var<private> polygon_len: u32;

fn plane_distance(plane: u32, h: vec4<f32>) -> f32 {
    switch plane {
        case 0u: { return select(h.z - frame.near, 2.0 - h.w, frame.ortho != 0u); }
        case 1u: { return GUARD_BAND * h.z - h.x; }
        case 2u: { return GUARD_BAND * h.z + h.x; }
        case 3u: { return GUARD_BAND * h.z - h.y; }
        default: { return GUARD_BAND * h.z + h.y; }
    }
}

fn crossing(inside: vec4<f32>, d_in: f32, outside: vec4<f32>, d_out: f32) -> vec4<f32> {
    let t = d_in / (d_in - d_out);
    return inside + (outside - inside) * t;
}

fn clip_triangle(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>) {
    polygon[0] = a;
    polygon[1] = b;
    polygon[2] = c;
    polygon_len = 3u;
    for (var plane = 0u; plane < 5u; plane++) {
        var kept: array<vec4<f32>, 8>;
        var count = 0u;
        for (var k = 0u; k < polygon_len; k++) {
            let p = polygon[k];
            let q = polygon[select(k + 1u, 0u, k + 1u == polygon_len)];
            let dp = plane_distance(plane, p);
            let dq = plane_distance(plane, q);
            if dp >= 0.0 && count < 8u {
                kept[count] = p;
                count++;
            }
            if (dp >= 0.0) != (dq >= 0.0) && count < 8u {
                if dp >= 0.0 {
                    kept[count] = crossing(p, dp, q, dq);
                } else {
                    kept[count] = crossing(q, dq, p, dp);
                }
                count++;
            }
        }
        polygon = kept;
        polygon_len = count;
    }
}

fn clip_vertex(h: vec4<f32>) -> Vertex {
    let x = clamp(round(h.x / h.z), -GUARD_BAND, GUARD_BAND);
    let y = clamp(round(h.y / h.z), -GUARD_BAND, GUARD_BAND);
    let depth = select(1.0 / h.z, max(h.w, SMALLEST), frame.ortho != 0u);
    return Vertex(i32(x), i32(y), depth);
}
