// The cheapest way to cut a face into blocks, from what its squares need.

fn whole_cost(at: u32, depth: u32) -> u32 {
    return (1u << (2u * min(needs[at] - depth, 8u))) + OVERHEAD;
}

// Micro-quads of the cheapest way to cut each square into blocks.
fn find_costs() {
    for (var below = 0u; below <= TREE_DEPTH; below++) {
        let depth = TREE_DEPTH - below;
        let n = 1u << depth;
        for (var c = 0u; c < n * n; c++) {
            let at = first_cell(depth) + c;
            var cost = whole_cost(at, depth);
            if needs[at] >= depth + 2u && depth < TREE_DEPTH {
                let child = first_cell(depth + 1u) + 4u * (c >> depth) * n + 2u * (c & (n - 1u));
                let parts = costs[child] + costs[child + 1u] + costs[child + 2u * n] + costs[child + 2u * n + 1u];
                cost = min(cost, parts);
            }
            costs[at] = cost;
        }
    }
}

// Cuts the face into blocks: nodes of its quadtree, in the order in which they are made.
fn cut(face: u32) {
    let base = face * NODE_WORDS;
    var stack: array<u32, 1u + 3u * TREE_DEPTH>;
    var count = 1u;
    var high = 1u;
    var missing = 0.0;
    stack[0] = 0u;
    nodes[base + 1u] = node_of(0u, 0u, 0u, 0u);
    while high > 0u {
        high--;
        let number = stack[high];
        let node = nodes[base + 1u + number];
        let depth = node_depth(node);
        let place = node_place(node);
        let at = first_cell(depth) + (place.y << depth) + place.x;
        let need = needs[at];
        if need < DEEPER && (need < depth + 2u || costs[at] >= whole_cost(at, depth)) {
            nodes[base + 1u + number] = node_of(depth, place.x, place.y, need);
            continue;
        }
        if depth >= TREE_DEPTH {
            // As deep as there is.
            nodes[base + 1u + number] = node_of(depth, place.x, place.y, BLOCK_BITS);
            for (var k = 0u; k < 4u; k++) {
                let last = cell(KEPT, 2u * place.x + (k & 1u), 2u * place.y + (k >> 1u));
                missing = max(missing, shortfall(last));
            }
            continue;
        }
        nodes[base + 1u + number] = node & ~NODE_LEAF;
        for (var k = 0u; k < 4u; k++) {
            nodes[base + 1u + count + k] = node_of(depth + 1u, 2u * place.x + (k & 1u), 2u * place.y + (k >> 1u), depth + 1u);
            stack[high + 3u - k] = count + k;
        }
        count += 4u;
        high += 4u;
    }
    nodes[base] = count;
    if missing > 0.0 {
        atomicAdd(&totals[TOTAL_DEEPER], 1u);
        atomicMax(&totals[TOTAL_MISSING], u32(min(missing, 1000.0) * 1000.0));
    }
}
