// Face points: the centroid of the corners. Triangles that are split into triangles have none.

@compute @workgroup_size(GROUP)
fn face(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let f = own_index(group, lane);
    if f >= mesh.faces {
        return;
    }
    let first = first_half(f);
    let count = corners_of(f);
    var sum = point(vertex_of(first));
    for (var k = 1u; k < count; k++) {
        sum += point(vertex_of(first + k));
    }
    put(mesh.vertices + f, (1.0 / f32(count)) * sum);
}
