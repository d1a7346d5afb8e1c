// Face points: the centroid of the corners.

@compute @workgroup_size(GROUP)
fn face(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let f = own_index(group, lane);
    if f >= step.faces {
        return;
    }
    let h = 4u * f;
    let sum = ((point(vertices[h]) + point(vertices[h + 1u])) + point(vertices[h + 2u])) + point(vertices[h + 3u]);
    put(step.vertices + f, 0.25 * sum);
}
