// Normals of corners that are made of the ring of faces around: src/gpu/rings.rs lists what of.
//
// A ring is a place of the face's own derivatives, a number of faces with a rule, and points, that of the vertex first.

// Where the derivatives stand that belong to a spot's normal.
fn own_place(spot: Spot) -> vec2<u32> {
    if spot.normal_index == RINGED {
        return vec2<u32>(gathers[spot.normal_stencil], gathers[spot.normal_stencil + 1u]);
    }
    return vec2<u32>(spot.normal_stencil, spot.normal_index);
}

// A weighted sum of control points, relative to one of them, and where the next begins.
struct RingPoint {
    p: vec3<f32>,
    next: u32,
}

fn ring_point(at: u32, origin: vec3<f32>) -> RingPoint {
    let terms = gathers[at];
    var out = RingPoint(vec3<f32>(0.0), at + 1u);
    for (var k = 0u; k < terms; k++) {
        out.p += bitcast<f32>(gathers[out.next + 1u]) * (control_point(gathers[out.next]) - origin);
        out.next += 2u;
    }
    return out;
}

fn ring_normal(ring: u32) -> vec3<f32> {
    let head = gathers[ring + 2u];
    let origin = control_point(gathers[ring + 4u]);
    let own = ring_point(ring + 3u, origin);
    var point = ring_point(own.next, origin);
    let first = point.p - own.p;
    var last = first;
    var sum = vec3<f32>(0.0);
    for (var k = 0u; k < (head >> 2u); k++) {
        point = ring_point(point.next, origin);
        let next = point.p - own.p;
        let c = cross(last, next);
        if (head & 3u) == RING_MEAN {
            sum += normalize_or_zero(c);
        } else {
            sum += c;
        }
        last = next;
    }
    if (head & 3u) == RING_ENDS {
        let n = cross(normalize_or_zero(first), normalize_or_zero(last));
        if dot(n, n) > 1e-10 {
            return normalize_or_zero(select(n, -n, dot(n, sum) < 0.0));
        }
    }
    return normalize_or_zero(sum);
}

// Unit normal of a table's place, or of a ring.
fn normal_at(stencil: u32, index: u32) -> vec3<f32> {
    if index == RINGED {
        return ring_normal(stencil);
    }
    return normal(evaluate(stencil, index));
}
