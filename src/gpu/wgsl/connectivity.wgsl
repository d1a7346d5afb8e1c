// The child's half-edges, edges and vertices, all by formulas from the parent's: nothing is searched and nothing waits. After Dupuy, Vanderhaeghe,
// A Halfedge Refinement Rule for Parallel Catmull-Clark Subdivision, 2021, with the numbers of src/refine/connectivity.rs.

// The part of the edge of h at end `end`.
fn outer(h: u32, end: u32) -> u32 {
    return mesh.halves + 2u * edge_of(h) + end;
}

fn put_half(corner: u32, v: u32, e: u32, twin: u32) {
    child_halves[corner] = v;
    child_halves[child.twins + corner] = twin;
    child_halves[child.numbers + corner] = e;
}

@compute @workgroup_size(GROUP)
fn halves_pass(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let h = own_index(group, lane);
    if h >= mesh.halves {
        return;
    }
    let b = before(h);
    let after = next(h);
    let first_edge = first_edge_point();
    let twin = twin_of(h);
    let twin_before = twin_of(b);
    var ahead = NONE;
    if twin != NONE {
        ahead = child_corner(next(twin), 3u);
    }
    var behind = NONE;
    if twin_before != NONE {
        behind = child_corner(twin_before, 0u);
    }
    let edge_point = first_edge + edge_of(h);
    put_half(child_corner(h, 0u), vertex_of(h), outer(h, start_end(h)), ahead);
    put_half(child_corner(h, 3u), first_edge + edge_of(b), outer(b, 1u - start_end(b)), behind);
    if TRIANGLES {
        // The triangle in the middle lies beyond the side from this edge point to the one before.
        put_half(child_corner(h, 1u), edge_point, h, child_corner(b, 2u));
        put_half(child_corner(h, 2u), edge_point, after, child_corner(after, 1u));
    } else {
        put_half(child_corner(h, 1u), edge_point, h, child_corner(after, 2u));
        put_half(child_corner(h, 2u), mesh.vertices + face_of(h), b, child_corner(b, 1u));
    }
}

// The child half-edge on the part of the edge of h at end `end`, in the face of h.
fn half_at_end(h: u32, end: u32) -> u32 {
    return select(child_corner(next(h), 3u), child_corner(h, 0u), start_end(h) == end);
}

fn is_fading(s: f32) -> bool {
    return s > 0.0 && s < INFINITE;
}

// What is left of the sharpness of edge e at vertex v.
fn faded(e: u32, v: u32) -> f32 {
    let s = edge_sharpness(e);
    if !CHAIKIN || !is_fading(s) {
        return decay(s);
    }
    var sum = 0.0;
    var count = 0u;
    let first = first_around(v);
    var h = first;
    loop {
        let own = edge_sharpness(edge_of(h));
        if is_fading(own) {
            sum += own;
            count++;
        }
        // The last edge of an open fan is a border, and never fades.
        h = rotate(h);
        if h == NONE || h == first {
            break;
        }
    }
    if count < 2u {
        return decay(s);
    }
    let others = (sum - s) / f32(count - 1u);
    return max(0.75 * s + 0.25 * others - 1.0, 0.0);
}

// One invocation per half-edge and per end of an edge of the parent.
@compute @workgroup_size(GROUP)
fn edges_pass(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = own_index(group, lane);
    if k >= child.edges {
        return;
    }
    if k < mesh.halves {
        var beyond = next(k);
        if TRIANGLES {
            beyond = before(k);
        }
        child_rest[k] = min(child_corner(k, 1u), child_corner(beyond, 2u));
        child_rest[child.sharpness + k] = 0u;
        return;
    }
    let e = (k - mesh.halves) / 2u;
    let end = (k - mesh.halves) & 1u;
    let h = edge_half(e);
    var half = half_at_end(h, end);
    if twin_of(h) != NONE {
        half = min(half, half_at_end(twin_of(h), end));
    }
    let there = select(h, next(h), end == 1u);
    child_rest[k] = half;
    child_rest[child.sharpness + k] = bitcast<u32>(faded(e, vertex_of(there)));
}

@compute @workgroup_size(GROUP)
fn vertices_pass(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let v = own_index(group, lane);
    if v >= child.vertices {
        return;
    }
    var half = NONE;
    var s = 0.0;
    if v < mesh.vertices {
        let first = first_around(v);
        if first != NONE {
            half = child_corner(first, 0u);
        }
        s = decay(vertex_sharpness(v));
    } else if v < first_edge_point() {
        half = child_corner(first_half(v - mesh.vertices), 2u);
    } else {
        let h = edge_half(v - first_edge_point());
        // On a border the boundary half-edge comes first.
        half = child_corner(h, 1u);
        if twin_of(h) == NONE {
            half = child_corner(next(h), 3u);
        }
    }
    child_rest[child.firsts + v] = half;
    child_rest[child.sharpness + child.edges + v] = bitcast<u32>(s);
}
