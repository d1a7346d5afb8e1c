// Limit positions of vertices and unit limit normals of corners: an invocation is a vertex, and walks its ring for its position, then sector by
// sector between sharp edges. Weights are the processor's (src/refine/limit/masks.rs).

// Where masks begin: of vertices that have their own, then by kind; behind, the masks.
@group(0) @binding(4) var<storage, read> masks: array<u32>;
@group(0) @binding(5) var<storage, read_write> limits: array<f32>;
@group(0) @binding(6) var<storage, read_write> normals: array<f32>;

// Sine of the angle below which two tangents are parallel, as src/refine/limit/sectors.rs has it.
const PARALLEL = 1e-5;

fn weight(at: u32) -> f32 {
    return bitcast<f32>(masks[at]);
}

// Which masks: those of the vertex, or of what became of an edge or a face: smooth, at a border, or on a crease by where it runs.
fn masks_at(v: u32, first: u32) -> u32 {
    let own = masks[0];
    if v < own {
        return masks[1u + v];
    }
    var kind = 0u;
    var h = first;
    for (var i = 0u; ; i++) {
        // Creases that fade are smooth by now; others come in opposite pairs.
        if kind == 0u && edge_sharpness(edge_of(h)) >= INFINITE {
            kind = 2u + i;
        }
        h = rotate(h);
        if h == NONE {
            kind = 1u;
            break;
        }
        if h == first {
            break;
        }
    }
    return masks[1u + own + kind];
}

// A place in the ring: the edge that leaves along h or, after the last face of an open fan, the one along which `last` arrived.
struct Place {
    h: u32,
    last: u32,
}

fn start_of(h: u32) -> Place {
    return Place(h, h);
}

fn advanced(p: Place) -> Place {
    return Place(rotate(p.h), p.h);
}

fn end_of(p: Place) -> vec3<f32> {
    var there = before(p.last);
    if p.h != NONE {
        there = next(p.h);
    }
    return point(vertex_of(there));
}

// The corner of a face across from the vertex; in a triangle the middle of the side there.
fn across(h: u32) -> vec3<f32> {
    let far = point(vertex_of(next(next(h))));
    if TRIANGLES {
        return 0.5 * (point(vertex_of(next(h))) + far);
    }
    return far;
}

fn has_direction(a: vec3<f32>) -> bool {
    let size = max(abs(a.x), max(abs(a.y), abs(a.z)));
    return size > 0.0 && size < 3.4e38;
}

// Scaled first: squares of small numbers would vanish.
fn unit(a: vec3<f32>) -> vec3<f32> {
    let b = a / max(abs(a.x), max(abs(a.y), abs(a.z)));
    return b / sqrt(dot(b, b));
}

// Twice the area of a face's part at the vertex, along its normal.
fn face_normal(x: vec3<f32>, h: u32) -> vec3<f32> {
    return cross(across(h) - x, point(vertex_of(before(h))) - point(vertex_of(next(h))));
}

// By differences to the vertex: far from the origin nothing is lost.
fn limit_position(x: vec3<f32>, first: u32, at: u32) -> vec3<f32> {
    let edges = masks[at];
    let faces = masks[at + 1u];
    var sum = vec3<f32>(0.0);
    var place = start_of(first);
    for (var i = 0u; i < edges; i++) {
        sum += weight(at + 4u + i) * (end_of(place) - x);
        if i < faces {
            sum += weight(at + 4u + edges + i) * (across(place.h) - x);
        }
        if place.h != NONE {
            place = advanced(place);
        }
    }
    return x + sum;
}

// The normal of the sector whose masks stand at `at`, from its first face on.
fn sector_normal(x: vec3<f32>, first: u32, at: u32) -> vec3<f32> {
    let count = masks[at];
    let edges = masks[at + 1u];
    let faces = masks[at + 2u];
    let other = edges + faces;
    var s = vec3<f32>(0.0);
    var t = vec3<f32>(0.0);
    var flat = vec3<f32>(0.0);
    var some = vec3<f32>(0.0);
    var place = start_of(first);
    for (var i = 0u; i < edges; i++) {
        let end = end_of(place) - x;
        s += weight(at + 4u + i) * end;
        t += weight(at + 4u + other + i) * end;
        if i < faces {
            let far = across(place.h) - x;
            s += weight(at + 4u + edges + i) * far;
            t += weight(at + 4u + other + edges + i) * far;
        }
        if i < count {
            let n = face_normal(x, place.h);
            flat += n;
            if !has_direction(some) {
                some = n;
            }
            place = advanced(place);
        }
    }
    if has_direction(s) && has_direction(t) {
        let n = cross(unit(s), unit(t));
        if dot(n, n) > PARALLEL * PARALLEL {
            let is_reflex = masks[at + 3u] != 0u && dot(n, flat) < 0.0;
            return unit(select(n, -n, is_reflex));
        }
    }
    if has_direction(flat) {
        return unit(flat);
    }
    return select(vec3<f32>(0.0, 0.0, 1.0), unit(some), has_direction(some));
}

fn put_limit(v: u32, p: vec3<f32>) {
    limits[3u * v] = p.x;
    limits[3u * v + 1u] = p.y;
    limits[3u * v + 2u] = p.z;
}

@compute @workgroup_size(GROUP)
fn limit(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let v = own_index(group, lane);
    if v >= mesh.vertices {
        return;
    }
    let x = point(v);
    let first = first_around(v);
    if first == NONE {
        put_limit(v, x);
        return;
    }
    var at = masks_at(v, first);
    put_limit(v, limit_position(x, first, at));
    let sectors = masks[at + 2u];
    // They follow each other, from the first sharp edge on.
    var h = first;
    for (var i = 0u; i < masks[at + 3u]; i++) {
        h = rotate(h);
    }
    at += 4u + masks[at] + masks[at + 1u];
    for (var k = 0u; k < sectors; k++) {
        let count = masks[at];
        let n = sector_normal(x, h, at);
        for (var i = 0u; i < count; i++) {
            normals[3u * h] = n.x;
            normals[3u * h + 1u] = n.y;
            normals[3u * h + 2u] = n.z;
            h = rotate(h);
        }
        at += 4u + 2u * (masks[at + 1u] + masks[at + 2u]);
    }
}
