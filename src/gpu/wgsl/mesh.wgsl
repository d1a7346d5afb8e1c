// A level of a whole mesh as half-edges, and walks around its vertices. What a face is (next, before, face_of, first_half, corners_of, child_corner) stands in
// mesh_quads.wgsl, mesh_triangles.wgsl or mesh_polygons.wgsl.

@group(0) @binding(0) var<uniform> mesh: Mesh;
// Of half-edges: vertices, twins, edges.
@group(0) @binding(1) var<storage, read> halves: array<u32>;
// A half-edge of every edge; of every vertex the first that leaves it, the boundary one of an open fan; sharpness of edges, then of vertices.
@group(0) @binding(2) var<storage, read> rest: array<u32>;
@group(0) @binding(3) var<storage, read> points: array<f32>;

fn vertex_of(h: u32) -> u32 {
    return halves[h];
}

fn twin_of(h: u32) -> u32 {
    return halves[mesh.twins + h];
}

fn edge_of(h: u32) -> u32 {
    return halves[mesh.numbers + h];
}

fn edge_half(e: u32) -> u32 {
    return rest[e];
}

fn first_around(v: u32) -> u32 {
    return rest[mesh.firsts + v];
}

fn edge_sharpness(e: u32) -> f32 {
    return bitcast<f32>(rest[mesh.sharpness + e]);
}

fn vertex_sharpness(v: u32) -> f32 {
    return bitcast<f32>(rest[mesh.sharpness + mesh.edges + v]);
}

// The next outgoing half-edge counter-clockwise, or NONE past the end of an open fan.
fn rotate(h: u32) -> u32 {
    return twin_of(before(h));
}

// 0 where h leaves the start of its edge, 1 where it leaves the end.
fn start_end(h: u32) -> u32 {
    return select(1u, 0u, edge_half(edge_of(h)) == h);
}

fn point(v: u32) -> vec3<f32> {
    return vec3<f32>(points[3u * v], points[3u * v + 1u], points[3u * v + 2u]);
}

fn decay(s: f32) -> f32 {
    return select(max(s - 1.0, 0.0), INFINITE, s >= INFINITE);
}
