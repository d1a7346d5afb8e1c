// Corners and points of sides: evaluated once, whoever shares them.

@group(0) @binding(5) var<storage, read> spots: array<Spot>;
@group(0) @binding(13) var<storage, read> lifts: array<Lift>;

// One of the normals of a mitre.
fn mitred(lift: Lift, k: u32) -> vec3<f32> {
    if lift.mitre_curves == 0u {
        return normal_at(gathers[lift.mitre + 2u * k], gathers[lift.mitre + 2u * k + 1u]);
    }
    let at = lift.mitre + 4u * k;
    return on_curve(vec4<u32>(gathers[at], gathers[at + 1u], gathers[at + 2u], gathers[at + 3u])).n;
}

// A spot of a displaced surface, from its limit point, and from what says its limit normal.
fn put_lifted(at: u32, spot: Spot, p: vec3<f32>, own: Jet, n: vec3<f32>) {
    let lift = lifts[at];
    var direction = n;
    if lift.mitre_count > 0u {
        var sum = vec3<f32>(0.0);
        var first = vec3<f32>(0.0);
        var count = 0.0;
        for (var k = 0u; k < lift.mitre_count; k++) {
            let m = mitred(lift, k);
            if all(m == vec3<f32>(0.0)) {
                continue;
            }
            if count == 0.0 {
                first = m;
            }
            sum += m;
            count += 1.0;
        }
        direction = mitre(sum, count, first);
    }
    let uv = uv_at(lift.uv_gather, lift.uv_count, lift.uv_table, stencils[spot.stencil].stride, spot.index);
    let s = height_at(p, uv.uv);
    let place = own_place(spot);
    let own_uv = uv_at(lift.own_gather, lift.own_count, lift.own_table, stencils[place.x].stride, place.y);
    var by = s.by;
    if rise.shape == MAP {
        by = map_slopes(own_uv.uv);
    }
    let moved = p + direction * s.h;
    if chunk.differences != 0u {
        // Faces have normals of their own, made of this one.
        put(at, moved, n);
    } else {
        put(at, moved, lifted_normal(own, n, s.h, slopes_of(own, by, own_uv)));
    }
}

@compute @workgroup_size(GROUP)
fn sides(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = own_index(group, lane);
    if at >= chunk.spots {
        return;
    }
    let spot = spots[at];
    if is_lifted() && lifts[at].curved != 0u {
        return;
    }
    if chunk.patches == PN {
        let p = pn_spot(spot.stencil, spot.index).p;
        put(at, p, pn_spot(spot.normal_stencil, spot.normal_index).n);
        return;
    }
    let jet = evaluate(spot.stencil, spot.index);
    if spot.normal_index == NONE {
        put(at, jet.p, control_point(spot.normal_stencil));
        return;
    }
    var own = jet;
    let place = own_place(spot);
    if place.x != spot.stencil || place.y != spot.index {
        own = evaluate(place.x, place.y);
    }
    var n = normal(own);
    if spot.normal_index == RINGED {
        n = ring_normal(spot.normal_stencil);
    }
    if !is_lifted() || lifts[at].held != 0u {
        put(at, jet.p, n);
    } else {
        put_lifted(at, spot, jet.p, own, n);
    }
}

// The same for what stands on curves of displaced patches.
@compute @workgroup_size(GROUP)
fn curves(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = own_index(group, lane);
    if at >= chunk.spots || !is_lifted() {
        return;
    }
    let lift = lifts[at];
    if lift.curved == 0u {
        return;
    }
    var s = on_curve(lift.curve);
    if chunk.patches == PN {
        s.n = pn_spot(lift.curve.z, lift.curve.w).n;
    }
    if lift.held != 0u {
        put(at, s.p, s.n);
        return;
    }
    let spot = spots[at];
    let own = evaluate(spot.normal_stencil, spot.normal_index);
    if all(s.n == vec3<f32>(0.0)) {
        s.n = normal(own);
    }
    put_lifted(at, spot, s.p, own, s.n);
}
