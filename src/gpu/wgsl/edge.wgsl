// Edge points: smooth, the middle of a sharp edge, or in between where sharpness runs out. Face points are there already.

@compute @workgroup_size(GROUP)
fn edge(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let e = own_index(group, lane);
    if e >= step.edges {
        return;
    }
    let h = edge_halves[e];
    let a = point(vertices[h]);
    let b = point(vertices[next(h)]);
    let middle = 0.5 * (a + b);
    let s = edge_sharpness(e);
    var weight = select(0.0, select(s, 1.0, decay(s) > 0.0), s > 0.0);
    if twins[h] == NONE {
        weight = 1.0;
    }
    var p = middle;
    if weight != 1.0 {
        let faces = child_point(step.vertices + h / 4u) + child_point(step.vertices + twins[h] / 4u);
        let smooth_point = 0.25 * (a + b) + 0.25 * faces;
        p = select(weight * middle + (1.0 - weight) * smooth_point, smooth_point, weight == 0.0);
    }
    put(step.vertices + step.faces + e, p);
}
