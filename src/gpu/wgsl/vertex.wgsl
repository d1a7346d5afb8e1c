// Vertex points: the rule of the parent's sharpness, that of the child's, or a blend of both. Gathered around the vertex.

// Weights of a neighbour in smooth points of triangles, by valence.
@group(0) @binding(9) var<storage, read> neighbours: array<f32>;

const SMOOTH = 0u;
const CREASE = 2u;
const CORNER = 3u;

// 0 smooth, 1 dart, 2 crease, 3 corner.
fn rule(sigma: f32, sharp: u32) -> u32 {
    return select(min(sharp, CORNER), CORNER, sigma > 0.0);
}

fn smooth_vertex(x: vec3<f32>, count: u32, ends: vec3<f32>, middles: vec3<f32>) -> vec3<f32> {
    let n = f32(count);
    if TRIANGLES {
        let near = neighbours[count];
        return near * ends + (1.0 - n * near) * x;
    }
    return (middles + ends) / (n * n) + ((n - 2.0) / n) * x;
}

@compute @workgroup_size(GROUP)
fn vertex(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let v = own_index(group, lane);
    if v >= mesh.vertices {
        return;
    }
    let x = point(v);
    let first = first_around(v);
    if LINEAR || first == NONE {
        put(v, x);
        return;
    }
    let sigma = vertex_sharpness(v);
    var lost = 0.0;
    var losing = 0u;
    if sigma > 0.0 && decay(sigma) <= 0.0 {
        lost += sigma;
        losing += 1u;
    }
    var sharp = 0u;
    var still = 0u;
    var sharp_ends = vec3<f32>(0.0);
    var still_ends = vec3<f32>(0.0);
    var ends = vec3<f32>(0.0);
    var middles = vec3<f32>(0.0);
    var count = 0u;
    var h = first;
    var last = NONE;
    loop {
        // The edge that leaves along h; after the last face of an open fan, the one that comes in.
        var along = h;
        var far: vec3<f32>;
        if h != NONE {
            far = point(vertex_of(next(h)));
            ends += far;
            if !TRIANGLES {
                middles += face_point(face_of(h));
            }
            count++;
        } else {
            along = before(last);
            far = point(vertex_of(along));
        }
        let e = edge_of(along);
        let s = edge_sharpness(e);
        let end = start_end(along);
        let c = child_sharpness(e, select(end, 1u - end, h == NONE));
        if s > 0.0 {
            sharp++;
            sharp_ends += far;
            if c <= 0.0 {
                lost += s;
                losing++;
            }
        }
        if c > 0.0 {
            still++;
            still_ends += far;
        }
        if h == NONE {
            break;
        }
        last = h;
        h = rotate(h);
        if h == first {
            break;
        }
    }
    let smooth_point = smooth_vertex(x, count, ends, middles);
    let own = rule(sigma, sharp);
    let later = rule(decay(sigma), still);
    var p = x;
    if own <= 1u {
        p = smooth_point;
    } else if own == CREASE {
        p = 0.125 * sharp_ends + 0.75 * x;
    }
    if own > 1u && own != later {
        var q = x;
        if later <= 1u {
            q = smooth_point;
        } else if later == CREASE {
            q = 0.125 * still_ends + 0.75 * x;
        }
        let weight = select(0.0, min(lost / f32(losing), 1.0), losing > 0u);
        p = weight * p + (1.0 - weight) * q;
    }
    put(v, p);
}
