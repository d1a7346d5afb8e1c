// Faces are triangles: half-edges 3f..3f + 2 are face f. Numbers of the child are those of src/refine/connectivity.rs.

const TRIANGLES = true;

fn face_of(h: u32) -> u32 {
    return h / 3u;
}

fn first_half(f: u32) -> u32 {
    return 3u * f;
}

fn corners_of(f: u32) -> u32 {
    return 3u;
}

fn next(h: u32) -> u32 {
    return h - h % 3u + (h + 1u) % 3u;
}

fn before(h: u32) -> u32 {
    return h - h % 3u + (h + 2u) % 3u;
}

fn child_corner(h: u32, k: u32) -> u32 {
    let at = h % 3u;
    let first = 4u * (h - at);
    if k == 2u {
        return first + 9u + (at + 2u) % 3u;
    }
    return first + 3u * at + (at + select(k, 2u, k == 3u)) % 3u;
}
