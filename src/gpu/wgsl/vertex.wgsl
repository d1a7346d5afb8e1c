// Vertex points: the rule of the parent's sharpness, that of the child's, or a blend of both. Gathered around the vertex.

const SMOOTH = 0u;
const CREASE = 2u;
const CORNER = 3u;

// 0 smooth, 1 dart, 2 crease, 3 corner.
fn rule(sigma: f32, sharp: u32) -> u32 {
    return select(min(sharp, CORNER), CORNER, sigma > 0.0);
}

@compute @workgroup_size(GROUP)
fn vertex(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let v = own_index(group, lane);
    if v >= step.vertices {
        return;
    }
    let x = point(v);
    let first = firsts[v];
    if first == NONE {
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
        var e: u32;
        var far: vec3<f32>;
        if h != NONE {
            e = edges[h];
            far = point(vertices[next(h)]);
            ends += far;
            middles += child_point(step.vertices + h / 4u);
            count++;
        } else {
            e = edges[before(last)];
            far = point(vertices[before(last)]);
        }
        let s = edge_sharpness(e);
        let c = decay(s);
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
    let n = f32(count);
    let smooth_point = (middles + ends) / (n * n) + ((n - 2.0) / n) * x;
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
