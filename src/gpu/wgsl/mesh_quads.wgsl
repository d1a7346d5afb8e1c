// Faces are quads: half-edges 4f..4f + 3 are face f. Numbers of the child are those of src/refine/connectivity.rs.

const TRIANGLES = false;

fn face_of(h: u32) -> u32 {
    return h / 4u;
}

fn first_half(f: u32) -> u32 {
    return 4u * f;
}

fn corners_of(f: u32) -> u32 {
    return 4u;
}

fn next(h: u32) -> u32 {
    return (h & ~3u) | ((h + 1u) & 3u);
}

fn before(h: u32) -> u32 {
    return (h & ~3u) | ((h + 3u) & 3u);
}

fn child_corner(h: u32, k: u32) -> u32 {
    return 4u * h + ((k + (h & 3u)) & 3u);
}
