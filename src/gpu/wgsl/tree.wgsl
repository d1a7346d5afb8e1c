// Quadtrees of faces, and binary trees of the splits along edges: src/tessellate/quadtree.rs and tree.rs, as deep as one block.

// A face's tree is the number of its nodes, none where it is not drawn, then the nodes in the order in which they were made.
const NODE_LEAF = 0x8000u;

// A leaf: its depth and place, and the level that it needs, which is its own at first.
fn node_of(depth: u32, x: u32, y: u32, need: u32) -> u32 {
    return depth | (x << 2u) | (y << 5u) | (need << 8u) | (need << 11u) | NODE_LEAF;
}

fn node_depth(node: u32) -> u32 {
    return node & 3u;
}

fn node_place(node: u32) -> vec2<u32> {
    return vec2<u32>((node >> 2u) & 7u, (node >> 5u) & 7u);
}

fn node_need(node: u32) -> u32 {
    return (node >> 8u) & 7u;
}

fn node_level(node: u32) -> u32 {
    return (node >> 11u) & 7u;
}

fn is_leaf(node: u32) -> bool {
    return (node & NODE_LEAF) != 0u;
}

// Number of the segment along side `c` of the face, if the square lies there, else NONE.
fn segment(node: u32, c: u32) -> u32 {
    let last = (1u << node_depth(node)) - 1u;
    let p = node_place(node);
    switch c {
        case 0u: { return select(NONE, p.x, p.y == 0u); }
        case 1u: { return select(NONE, p.y, p.x == last); }
        case 2u: { return select(NONE, last - p.x, p.y == last); }
        default: { return select(NONE, last - p.y, p.x == 0u); }
    }
}

fn turned(is_back: bool, depth: u32, place: u32) -> u32 {
    return select(place, (1u << depth) - 1u - place, is_back);
}

// Bits of the segments below one that is number `place` of `2^depth`, at depth `d`.
fn below(depth: u32, place: u32, d: u32) -> u32 {
    let count = 1u << (d - depth);
    return ((1u << count) - 1u) << ((1u << d) + (place << (d - depth)));
}
