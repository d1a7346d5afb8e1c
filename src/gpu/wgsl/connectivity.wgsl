// The child's half-edges, edges and vertices, all by formulas from the parent's: nothing is searched and nothing waits. After Dupuy, Vanderhaeghe,
// A Halfedge Refinement Rule for Parallel Catmull-Clark Subdivision, 2021, with the numbers of src/refine/connectivity.rs.

@group(0) @binding(7) var<storage, read_write> child_halves: array<u32>;
@group(0) @binding(8) var<storage, read_write> child_rest: array<u32>;

// Half-edges of the child: vertices, twins, edges, one after the other. The rest: half-edges of edges, first half-edges of vertices, sharpness.

fn child_corner(h: u32, k: u32) -> u32 {
    return 4u * h + ((k + (h & 3u)) & 3u);
}

fn halves() -> u32 {
    return 4u * step.faces;
}

// 0 where h leaves the start of its edge, 1 where it leaves the end.
fn start_end(h: u32) -> u32 {
    return select(1u, 0u, vertices[h] == vertices[edge_halves[edges[h]]]);
}

fn outer(h: u32, end: u32) -> u32 {
    return halves() + 2u * edges[h] + end;
}

// Parts of a buffer begin at multiples of this.
fn aligned(count: u32) -> u32 {
    return (count + ALIGN - 1u) & ~(ALIGN - 1u);
}

fn put_half(corner: u32, v: u32, e: u32, twin: u32) {
    let all = aligned(4u * halves());
    child_halves[corner] = v;
    child_halves[all + corner] = twin;
    child_halves[2u * all + corner] = e;
}

@compute @workgroup_size(GROUP)
fn halves_pass(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let h = own_index(group, lane);
    if h >= halves() {
        return;
    }
    let b = before(h);
    let first_edge = step.vertices + step.faces;
    var ahead = NONE;
    if twins[h] != NONE {
        ahead = child_corner(next(twins[h]), 3u);
    }
    var behind = NONE;
    if twins[b] != NONE {
        behind = child_corner(twins[b], 0u);
    }
    put_half(child_corner(h, 0u), vertices[h], outer(h, start_end(h)), ahead);
    put_half(child_corner(h, 1u), first_edge + edges[h], h, child_corner(next(h), 2u));
    put_half(child_corner(h, 2u), step.vertices + h / 4u, b, child_corner(b, 1u));
    put_half(child_corner(h, 3u), first_edge + edges[b], outer(b, 1u - start_end(b)), behind);
}

// The child half-edge on the part of the edge of h at end `end`, in the face of h.
fn half_at_end(h: u32, end: u32) -> u32 {
    return select(child_corner(next(h), 3u), child_corner(h, 0u), start_end(h) == end);
}

// One invocation per half-edge and per end of an edge of the parent.
@compute @workgroup_size(GROUP)
fn edges_pass(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let k = own_index(group, lane);
    let inner = halves();
    let count = inner + 2u * step.edges;
    if k >= count {
        return;
    }
    let sharp = aligned(count) + aligned(step.vertices + step.faces + step.edges);
    if k < inner {
        child_rest[k] = min(child_corner(k, 1u), child_corner(next(k), 2u));
        child_rest[sharp + k] = 0u;
        return;
    }
    let e = (k - inner) / 2u;
    let end = (k - inner) & 1u;
    let h = edge_halves[e];
    var half = half_at_end(h, end);
    if twins[h] != NONE {
        half = min(half, half_at_end(twins[h], end));
    }
    child_rest[k] = half;
    child_rest[sharp + k] = bitcast<u32>(decay(edge_sharpness(e)));
}

@compute @workgroup_size(GROUP)
fn vertices_pass(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let v = own_index(group, lane);
    let count = step.vertices + step.faces + step.edges;
    if v >= count {
        return;
    }
    let own_edges = halves() + 2u * step.edges;
    let first = aligned(own_edges);
    let sharp = first + aligned(count) + own_edges;
    var half = NONE;
    var s = 0.0;
    if v < step.vertices {
        if firsts[v] != NONE {
            half = child_corner(firsts[v], 0u);
        }
        s = decay(vertex_sharpness(v));
    } else if v < step.vertices + step.faces {
        half = child_corner(4u * (v - step.vertices), 2u);
    } else {
        let h = edge_halves[v - step.vertices - step.faces];
        // On a border the boundary half-edge comes first.
        half = select(child_corner(h, 1u), child_corner(next(h), 3u), twins[h] == NONE);
    }
    child_rest[first + v] = half;
    child_rest[sharp + v] = bitcast<u32>(s);
}
