// Edge points: smooth, the middle of a sharp edge, or in between where sharpness runs out. Face points are there already.

// Weight of a face point in the edge points of the face.
fn face_weight(f: u32) -> f32 {
    if SMOOTH_TRIANGLES && corners_of(f) == 3u {
        return FACE_OF_TRIANGLE;
    }
    return 0.25;
}

fn smooth_edge(h: u32, ends: vec3<f32>) -> vec3<f32> {
    let twin = twin_of(h);
    if TRIANGLES {
        return 0.125 * (point(vertex_of(before(h))) + point(vertex_of(before(twin)))) + 0.375 * ends;
    }
    let beside = face_of(h);
    let across = face_of(twin);
    let weight = 0.5 * (face_weight(beside) + face_weight(across));
    return (0.5 - weight) * ends + weight * (face_point(beside) + face_point(across));
}

@compute @workgroup_size(GROUP)
fn edge(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let e = own_index(group, lane);
    if e >= mesh.edges {
        return;
    }
    let h = edge_half(e);
    let ends = point(vertex_of(h)) + point(vertex_of(next(h)));
    let s = edge_sharpness(e);
    let stays = child_sharpness(e, 0u) > 0.0 && child_sharpness(e, 1u) > 0.0;
    let weight = select(0.0, select(s, 1.0, stays), s > 0.0);
    var p = 0.5 * ends;
    if !LINEAR && twin_of(h) != NONE && weight != 1.0 {
        let smooth_point = smooth_edge(h, ends);
        p = select(weight * p + (1.0 - weight) * smooth_point, smooth_point, weight == 0.0);
    }
    put(first_edge_point() + e, p);
}
