// The level that follows. Its points: those of vertices come first, then those of faces that are not split into triangles, then those of edges.

@group(0) @binding(4) var<uniform> child: Mesh;
@group(0) @binding(5) var<storage, read_write> child_halves: array<u32>;
@group(0) @binding(6) var<storage, read_write> child_rest: array<u32>;
@group(0) @binding(7) var<storage, read_write> child_points: array<f32>;

fn first_edge_point() -> u32 {
    return mesh.vertices + select(mesh.faces, 0u, TRIANGLES);
}

// Sharpness of the part of an edge at its start (0) or end (1).
fn child_sharpness(e: u32, end: u32) -> f32 {
    return bitcast<f32>(child_rest[child.sharpness + mesh.halves + 2u * e + end]);
}

fn child_point(v: u32) -> vec3<f32> {
    return vec3<f32>(child_points[3u * v], child_points[3u * v + 1u], child_points[3u * v + 2u]);
}

fn put(v: u32, p: vec3<f32>) {
    child_points[3u * v] = p.x;
    child_points[3u * v + 1u] = p.y;
    child_points[3u * v + 2u] = p.z;
}

fn face_point(f: u32) -> vec3<f32> {
    return child_point(mesh.vertices + f);
}
