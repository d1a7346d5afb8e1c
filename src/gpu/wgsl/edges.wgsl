// Which segments of each edge are split: from what its faces need beside it, and where their samples do not show that, from its own curve. An
// invocation decides an edge for both of its faces.

@group(0) @binding(5) var<storage, read> faces: array<Face>;
@group(0) @binding(6) var<storage, read> patches: array<Patch>;
@group(0) @binding(7) var<storage, read> points: array<f32>;
@group(0) @binding(9) var<storage, read> nodes: array<u32>;
@group(0) @binding(10) var<storage, read_write> totals: array<atomic<u32>>;
@group(0) @binding(11) var<storage, read> edges: array<Edge>;
@group(0) @binding(12) var<storage, read_write> trees: array<u32>;

// Adds the points that the leaves of a face at its side `c` ask for.
fn asked(face: u32, c: u32, is_back: bool) -> u32 {
    var splits = 0u;
    let base = face * NODE_WORDS;
    for (var k = 1u; k <= nodes[base]; k++) {
        let node = nodes[base + k];
        let own = segment(node, c);
        if !is_leaf(node) || own == NONE {
            continue;
        }
        let depth = node_depth(node);
        let place = turned(is_back, depth, own);
        for (var d = 0u; d < node_need(node); d++) {
            if d <= depth {
                splits |= 1u << ((1u << d) + (place >> (depth - d)));
            } else {
                splits |= below(depth, place, d);
            }
        }
    }
    return splits;
}

// The edge's point at a place of the finest grid, in its own direction.
fn edge_point(e: Edge, k: u32) -> Seen {
    let n = 1u << faces[e.first].reach;
    let c = e.marks & 3u;
    if k == n {
        return spot_at(on_side(faces[e.first], (c + 1u) & 3u, 0u, n));
    }
    return spot_at(on_side(faces[e.first], c, k, n));
}

// The most that the last step of its samples adds, of what asks for more.
var<private> missing: f32;

// What step `k` adds to segment `i`.
fn of_segment(e: Edge, k: u32, i: u32) -> Added {
    let up = BLOCK_BITS - k;
    return surplus(edge_point(e, (2u * i + 1u) << (up - 1u)), edge_point(e, i << up), edge_point(e, (i + 1u) << up));
}

// What the edge's own curve asks for by `2^log` samples; whether more of them would show more.
fn own_splits(e: Edge, log: u32, splits: ptr<function, u32>) -> bool {
    *splits = 0u;
    missing = 0.0;
    var front = 1u;
    for (var depth = 0u; depth < metric.max_level; depth++) {
        if depth >= log {
            return front != 0u;
        }
        var next = 0u;
        for (var i = 0u; i < (1u << depth); i++) {
            if (front & (1u << i)) == 0u {
                continue;
            }
            var later = Added(0.0, 0.0, 0.0);
            if depth + 1u < log {
                later = most_added(of_segment(e, depth + 1u, 2u * i), of_segment(e, depth + 1u, 2u * i + 1u));
            }
            let found = of_segment(e, depth, i);
            if is_far(found, later, 1.0) {
                if depth + 1u == log {
                    missing = max(missing, shortfall(found));
                }
                *splits |= 1u << ((1u << depth) + i);
                next |= 3u << (2u * i);
            }
        }
        front = next;
    }
    return false;
}

@compute @workgroup_size(GROUP)
fn edges_of_faces(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = own_index(group, lane);
    if at >= arrayLength(&edges) {
        return;
    }
    let e = edges[at];
    var splits = asked(e.first, e.marks & 3u, false);
    var drawn = nodes[e.first * NODE_WORDS] > 0u;
    if e.second != NONE {
        splits |= asked(e.second, (e.marks >> 2u) & 3u, (e.marks & EDGE_BACK) != 0u);
        drawn = drawn || nodes[e.second * NODE_WORDS] > 0u;
    }
    if drawn && (patches[e.first].marks & PATCH_PLAIN) == 0u {
        var own = 0u;
        if own_splits(e, 3u, &own) && own_splits(e, BLOCK_BITS, &own) {
            // As deep as there is.
            atomicAdd(&totals[TOTAL_DEEPER], 1u);
            atomicMax(&totals[TOTAL_MISSING], u32(min(missing, 1000.0) * 1000.0));
        }
        splits |= own;
    }
    trees[at] = splits;
}
