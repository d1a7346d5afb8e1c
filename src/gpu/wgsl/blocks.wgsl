// From what faces need and how edges are split to blocks, as src/tessellate/blocks.rs and quadtree.rs make them of one face. An invocation has a
// face: first its blocks are counted, then, when it is known where they go, listed.

@group(0) @binding(6) var<storage, read> patches: array<Patch>;
@group(0) @binding(9) var<storage, read_write> nodes: array<u32>;
@group(0) @binding(10) var<storage, read_write> totals: array<atomic<u32>>;
@group(0) @binding(12) var<storage, read> trees: array<u32>;
@group(0) @binding(13) var<storage, read_write> counts: array<vec4<u32>>;
@group(0) @binding(14) var<storage, read> offsets: array<vec4<u32>>;
@group(0) @binding(15) var<storage, read_write> blocks: array<Block>;
@group(0) @binding(16) var<storage, read_write> moves: array<Move>;
@group(0) @binding(17) var<uniform> room: Room;

// Squares of the finest depth along a side, and how many levels finer the grid of places is.
const CELL_SIDE = 1u << TREE_DEPTH;

// The face's tree: node by node, and of every cell the leaf that it lies in.
var<private> tree: array<u32, SQUARES>;
var<private> tree_size: u32;
var<private> cells: array<u32, CELL_SIDE * CELL_SIDE>;
// Splits of the edges at its sides.
var<private> sides: array<u32, 4>;
var<private> backs: array<bool, 4>;

fn cover(number: u32) {
    let size = CELL_SIDE >> node_depth(tree[number]);
    let first = node_place(tree[number]) * size;
    for (var k = 0u; k < size * size; k++) {
        cells[(first.y + k / size) * CELL_SIDE + first.x + k % size] = number;
    }
}

fn load(face: u32) {
    let base = face * NODE_WORDS;
    tree_size = nodes[base];
    for (var k = 0u; k < tree_size; k++) {
        tree[k] = nodes[base + 1u + k];
        if is_leaf(tree[k]) {
            cover(k);
        }
    }
    for (var c = 0u; c < 4u; c++) {
        let edge = patches[face].edges[c];
        sides[c] = trees[edge >> 1u];
        backs[c] = (edge & 1u) != 0u;
    }
}

// Level of the deepest points of side `c` inside of a segment.
fn deepest(c: u32, depth: u32, own: u32) -> u32 {
    let place = turned(backs[c], depth, own);
    var level = depth;
    for (var d = depth; d < BLOCK_BITS; d++) {
        if (sides[c] & below(depth, place, d)) != 0u {
            level = d + 1u;
        }
    }
    return level;
}

// The cell beyond side `c` of a square, `k` cells along it.
fn cell_beyond(node: u32, c: u32, k: u32) -> u32 {
    let size = CELL_SIDE >> node_depth(node);
    let first = node_place(node) * size;
    switch c {
        case 0u: { return (first.y - 1u) * CELL_SIDE + first.x + k; }
        case 1u: { return (first.y + k) * CELL_SIDE + first.x + size; }
        case 2u: { return (first.y + size) * CELL_SIDE + first.x + k; }
        default: { return (first.y + k) * CELL_SIDE + first.x - 1u; }
    }
}

// The level that a leaf needs to have the points of edges at its sides, and to be within one of its neighbours'.
fn wanted(node: u32) -> u32 {
    var level = node_level(node);
    for (var c = 0u; c < 4u; c++) {
        let own = segment(node, c);
        if own != NONE {
            level = max(level, deepest(c, node_depth(node), own));
            continue;
        }
        for (var k = 0u; k < (CELL_SIDE >> node_depth(node)); k++) {
            let other = tree[cells[cell_beyond(node, c, k)]];
            level = max(level, max(node_depth(other), max(node_level(other), 1u) - 1u));
        }
    }
    return level;
}

fn split(number: u32) {
    let node = tree[number];
    let depth = node_depth(node) + 1u;
    let place = 2u * node_place(node);
    tree[number] = node & ~NODE_LEAF;
    for (var k = 0u; k < 4u; k++) {
        tree[tree_size + k] = node_of(depth, place.x + (k & 1u), place.y + (k >> 1u), max(node_need(node), depth));
        cover(tree_size + k);
    }
    tree_size += 4u;
}

fn balance() {
    var changed = true;
    while changed {
        changed = false;
        for (var i = 0u; i < tree_size; i++) {
            let node = tree[i];
            if !is_leaf(node) {
                continue;
            }
            let level = wanted(node);
            // Far more than it needs is wanted along a side only: better of the part that lies there.
            if level > node_need(node) + 1u && level > node_depth(node) + 2u {
                split(i);
                changed = true;
            } else if level > node_level(node) {
                tree[i] = (node & ~(7u << 11u)) | (level << 11u);
                changed = true;
            }
        }
    }
}

// The point of an edge's splits next to place `t` of `2^level`; of two equally near ones the first.
fn nearest(splits: u32, level: u32, t: u32) -> u32 {
    var node = 1u;
    var low = 0u;
    var high = 1u << level;
    while t != low && t != high {
        if node >= (1u << BLOCK_BITS) || (splits & (1u << node)) == 0u {
            return select(high, low, t - low <= high - t);
        }
        let middle = (low + high) / 2u;
        if t >= middle {
            node = 2u * node + 1u;
            low = middle;
        } else {
            node = 2u * node;
            high = middle;
        }
    }
    return t;
}

fn along_side(c: u32, level: u32, t: u32) -> u32 {
    let n = 1u << level;
    return select(nearest(sides[c], level, t), n - nearest(sides[c], level, n - t), backs[c]);
}

// Where a point on side `c` of the face is drawn.
fn drawn_on_side(c: u32, level: u32, at: vec2<u32>) -> vec2<u32> {
    let n = 1u << level;
    switch c {
        case 0u: { return vec2<u32>(along_side(0u, level, at.x), 0u); }
        case 1u: { return vec2<u32>(n, along_side(1u, level, at.y)); }
        case 2u: { return vec2<u32>(n - along_side(2u, level, n - at.x), n); }
        default: { return vec2<u32>(0u, n - along_side(3u, level, n - at.y)); }
    }
}

// Where a point of a leaf's grid is drawn that lies on side `c` of the leaf.
fn drawn(node: u32, c: u32, place: vec2<u32>) -> vec2<u32> {
    let level = node_level(node);
    if segment(node, c) != NONE {
        return drawn_on_side(c, level, place);
    }
    var at = place;
    let axis = c & 1u;
    // Micro-quads along the leaf; its first one.
    let log = level - node_depth(node);
    if (at[axis] & ((1u << log) - 1u)) != 0u {
        // Cells beyond the point, before and after it, and whether it is where one of their leaves ends.
        let first = node_place(node)[axis] << log;
        let size = CELL_SIDE >> node_depth(node);
        let k = (at[axis] - first) * size;
        let after = k >> log;
        let is_between = (k & ((1u << log) - 1u)) == 0u;
        let before = select(after, after - 1u, is_between);
        var coarse = level;
        var corner = false;
        for (var cell = before; cell <= after; cell++) {
            let other = tree[cells[cell_beyond(node, c, cell)]];
            coarse = min(coarse, node_level(other));
            let width = CELL_SIDE >> node_depth(other);
            let low = node_place(other)[axis] * width;
            let own = node_place(node)[axis] * size + after;
            corner = corner || (is_between && (low == own || low + width == own));
        }
        let step = 1u << (level - coarse);
        if !corner && (at[axis] & (step - 1u)) != 0u {
            at[axis] = (at[axis] + (step - 1u) / 2u) / step * step;
        }
    }
    let n = 1u << level;
    if at.y == 0u {
        return drawn_on_side(0u, level, at);
    }
    if at.x == n {
        return drawn_on_side(1u, level, at);
    }
    if at.y == n {
        return drawn_on_side(2u, level, at);
    }
    if at.x == 0u {
        return drawn_on_side(3u, level, at);
    }
    return at;
}

// Column and row in a block of point `k` of `n` along its side `c`.
fn on_rim(c: u32, k: u32, n: u32) -> vec2<u32> {
    switch c {
        case 0u: { return vec2<u32>(k, 0u); }
        case 1u: { return vec2<u32>(n, k); }
        case 2u: { return vec2<u32>(n - k, n); }
        default: { return vec2<u32>(0u, n - k); }
    }
}

// The points of a leaf's rim that are elsewhere: how many, listed from `at` on if they are wanted.
fn rim(node: u32, at: u32, is_wanted: bool) -> u32 {
    let log = node_level(node) - node_depth(node);
    let n = 1u << log;
    let start = node_place(node) << vec2<u32>(log);
    let up = BLOCK_BITS - node_level(node);
    var count = 0u;
    for (var c = 0u; c < 4u; c++) {
        for (var k = 0u; k < n; k++) {
            let own = on_rim(c, k, n);
            let place = start + own;
            var to = drawn(node, c, place);
            if k == 0u && all(to == place) {
                // The corner may be moved along the side before it as well.
                to = drawn(node, (c + 3u) & 3u, place);
            }
            if all(to == place) {
                continue;
            }
            if is_wanted {
                moves[at + count] = Move(own.y * (n + 1u) + own.x, to.x << up, to.y << up, 0u);
            }
            count++;
        }
    }
    return count;
}

@compute @workgroup_size(GROUP)
fn count_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let face = own_index(group, lane);
    if face >= arrayLength(&patches) {
        return;
    }
    load(face);
    balance();
    // Blocks, their points, those that are moved, micro-quads.
    var sum = vec4<u32>(0u);
    var most = 0u;
    nodes[face * NODE_WORDS] = tree_size;
    for (var k = 0u; k < tree_size; k++) {
        nodes[face * NODE_WORDS + 1u + k] = tree[k];
        if is_leaf(tree[k]) {
            let n = 1u << (node_level(tree[k]) - node_depth(tree[k]));
            sum += vec4<u32>(1u, (n + 1u) * (n + 1u), rim(tree[k], 0u, false), n * n);
            most = max(most, node_level(tree[k]));
        }
    }
    counts[face] = sum;
    atomicMax(&totals[TOTAL_DEEPEST], most);
}

@compute @workgroup_size(GROUP)
fn list_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let face = own_index(group, lane);
    // All or nothing of the chunk.
    if face >= arrayLength(&patches) || atomicLoad(&totals[TOTAL_DRAWN]) == 0u {
        return;
    }
    load(face);
    var next = offsets[face];
    let split_once = u32((patches[face].marks & PATCH_SPLIT) != 0u);
    for (var k = 0u; k < tree_size; k++) {
        let node = tree[k];
        if !is_leaf(node) {
            continue;
        }
        let log = node_level(node) - node_depth(node);
        let up = BLOCK_BITS - node_level(node);
        let n = 1u << log;
        let start = (node_place(node) << vec2<u32>(log)) << vec2<u32>(up);
        let count = rim(node, next.z, true);
        blocks[next.x] = Block(face, start.x, start.y, 1u << up, log, room.spots + next.y, next.z, count, node_level(node) + split_once, 0u, 0u, 0u);
        next += vec4<u32>(1u, (n + 1u) * (n + 1u), count, n * n);
    }
}
