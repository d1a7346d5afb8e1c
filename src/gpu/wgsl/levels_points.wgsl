@group(0) @binding(7) var<storage, read> points: array<f32>;
// Points of the child: those of vertices, then of faces, then of edges.
@group(0) @binding(8) var<storage, read_write> child: array<f32>;

fn point(v: u32) -> vec3<f32> {
    return vec3<f32>(points[3u * v], points[3u * v + 1u], points[3u * v + 2u]);
}

fn child_point(v: u32) -> vec3<f32> {
    return vec3<f32>(child[3u * v], child[3u * v + 1u], child[3u * v + 2u]);
}

fn put(v: u32, p: vec3<f32>) {
    child[3u * v] = p.x;
    child[3u * v + 1u] = p.y;
    child[3u * v + 2u] = p.z;
}
