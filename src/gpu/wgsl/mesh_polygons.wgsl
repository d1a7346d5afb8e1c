// Faces have any number of corners. Numbers of the child are those of src/refine/connectivity.rs.

// First half-edges of faces and one past the last, then the face of every half-edge.
@group(0) @binding(8) var<storage, read> polygons: array<u32>;

const TRIANGLES = false;

fn face_of(h: u32) -> u32 {
    return polygons[mesh.faces + 1u + h];
}

fn first_half(f: u32) -> u32 {
    return polygons[f];
}

fn corners_of(f: u32) -> u32 {
    return polygons[f + 1u] - polygons[f];
}

fn next(h: u32) -> u32 {
    let f = face_of(h);
    return select(h + 1u, polygons[f], h + 1u == polygons[f + 1u]);
}

fn before(h: u32) -> u32 {
    let f = face_of(h);
    return select(h, polygons[f + 1u], h == polygons[f]) - 1u;
}

// Children of quads keep the directions of their parent.
fn child_corner(h: u32, k: u32) -> u32 {
    let f = face_of(h);
    return 4u * h + ((k + select(0u, h - polygons[f], corners_of(f) == 4u)) & 3u);
}
