// Points and normals of blocks, as sums of weights times control points.
//
// First `sides`: corners and points of sides, an invocation each, once per chunk whoever shares them. Then `inside`: what lies within
// faces is summed up, what lies on a side is copied, so that faces which meet there have the same bits, fused or not.

@group(0) @binding(5) var<storage, read> spots: array<Spot>;
@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> blocks: array<Block>;
@group(0) @binding(8) var<storage, read> moves: array<Move>;
@group(0) @binding(9) var<storage, read_write> points: array<f32>;

// Texture coordinates, at the same places as points.
@group(0) @binding(10) var<storage, read_write> uvs: array<vec2<f32>>;

// What displaces, what spots take from elsewhere, and the heights of all maps.
@group(0) @binding(12) var<uniform> rise: Rise;
@group(0) @binding(13) var<storage, read> lifts: array<Lift>;
@group(0) @binding(14) var<storage, read> heights: array<f32>;

// What tilts normals, two vectors at each of the same places.
@group(0) @binding(15) var<storage, read_write> tangents: array<f32>;

// Colours, at the same places.
@group(0) @binding(11) var<storage, read_write> colors: array<f32>;

fn put(at: u32, p: vec3<f32>, n: vec3<f32>) {
    let k = POINT_FLOATS * at;
    points[k] = p.x;
    points[k + 1u] = p.y;
    points[k + 2u] = p.z;
    points[k + 3u] = n.x;
    points[k + 4u] = n.y;
    points[k + 5u] = n.z;
}

fn copy(from_at: u32, to: u32) {
    for (var k = 0u; k < 6u; k++) {
        points[POINT_FLOATS * to + k] = points[POINT_FLOATS * from_at + k];
    }
}

@compute @workgroup_size(GROUP)
fn sides(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = own_index(group, lane);
    if at >= chunk.spots {
        return;
    }
    let spot = spots[at];
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
    if spot.normal_stencil != spot.stencil || spot.normal_index != spot.index {
        own = evaluate(spot.normal_stencil, spot.normal_index);
    }
    let n = normal(own);
    if !LIFTED || rise.shape == STILL || lifts[at].held != 0u {
        put(at, jet.p, n);
    } else {
        put_lifted(at, spot, jet.p, own, n);
    }
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
            let m = normal(evaluate(gathers[lift.mitre + 2u * k], gathers[lift.mitre + 2u * k + 1u]));
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
    let own_uv = uv_at(lift.own_gather, lift.own_count, lift.own_table, stencils[spot.normal_stencil].stride, spot.normal_index);
    var by = s.by;
    if rise.shape == MAP {
        by = map_slopes(own_uv.uv);
    }
    put(at, p + direction * s.h, lifted_normal(own, n, s.h, slopes_of(own, by, own_uv)));
}

// Under slopes by pixel, normals are those of the limit.
fn lifted_normal(jet: Jet, n: vec3<f32>, height: f32, slope: vec2<f32>) -> vec3<f32> {
    return select(displaced_normal(jet, n, height, slope), n, rise.per_pixel != 0u);
}

struct Sample {
    p: vec3<f32>,
    n: vec3<f32>,
}

fn sample_at(at: u32) -> Sample {
    let k = POINT_FLOATS * at;
    return Sample(
        vec3<f32>(points[k], points[k + 1u], points[k + 2u]),
        vec3<f32>(points[k + 3u], points[k + 4u], points[k + 5u]));
}

// Quadratic through values at 0, 1/2 and 1.
fn shares(t: f32) -> vec3<f32> {
    return vec3<f32>((1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0));
}

fn quadratic(a: Sample, m: Sample, b: Sample, w: vec3<f32>) -> Sample {
    return Sample((w.x * a.p + w.z * b.p) + w.y * m.p, (w.x * a.n + w.z * b.n) + w.y * m.n);
}

// QAS: quadratics through points and normals of level 1. A side is walked as its positions' owner walks it, by both faces.
fn patch_at(face: Face, x: u32, y: u32, n: u32) -> Sample {
    let side = side_of(x, y, n);
    let last = select(4u, 3u, chunk.triangles != 0u);
    if side.x != INSIDE {
        let c = side.x;
        let next = select(c + 1u, 0u, c + 1u == last);
        let turned = ((face.turns >> (8u * c)) & 64u) != 0u;
        let a = sample_at(face.corners[select(c, next, turned)]);
        let b = sample_at(face.corners[select(next, c, turned)]);
        let k = select(side.y, n - side.y, turned);
        return quadratic(a, sample_at(face.sides[c]), b, shares(f32(k) / f32(n)));
    }
    let u = f32(x) / f32(n);
    let v = f32(y) / f32(n);
    if chunk.triangles != 0u {
        let w = vec3<f32>(1.0 - u, u - v, v);
        let corner = w * (2.0 * w - 1.0);
        let middle = 4.0 * w * w.yzx;
        var sum = Sample(vec3<f32>(0.0), vec3<f32>(0.0));
        for (var c = 0u; c < 3u; c++) {
            let at = sample_at(face.corners[c]);
            let half = sample_at(face.sides[c]);
            sum.p += corner[c] * at.p + middle[c] * half.p;
            sum.n += corner[c] * at.n + middle[c] * half.n;
        }
        return sum;
    }
    let w = shares(u);
    let low = quadratic(sample_at(face.corners[0]), sample_at(face.sides[0]), sample_at(face.corners[1]), w);
    let middle = quadratic(sample_at(face.sides[3]), sample_at(face.middle), sample_at(face.sides[1]), w);
    let high = quadratic(sample_at(face.corners[3]), sample_at(face.sides[2]), sample_at(face.corners[2]), w);
    return quadratic(low, middle, high, shares(v));
}

// A weighted sum of vectors among control points.
fn blend(first: u32, w: vec3<f32>) -> vec3<f32> {
    return (control_point(first) * w.x + control_point(first + 1u) * w.y) + control_point(first + 2u) * w.z;
}

// A curved PN triangle at a place of its quad, as src/patch/face.rs has it: after its ten points come six normals and barycentric coordinates
// of three corners.
fn pn_at(quad: u32, x: u32, y: u32, n: u32) -> Sample {
    let net = select(quad, quad + PN_HALF, y > x);
    let far = f32(max(x, y)) / f32(n);
    let near = f32(min(x, y)) / f32(n);
    let corners = net + PN_HALF - 3u;
    let w = control_point(corners) * (1.0 - far)
        + (control_point(corners + 1u) * (far - near) + control_point(corners + 2u) * near);
    let next = w.yzx;
    let squares = w * w;
    let products = 2.0 * (w * next);
    // On each side the two control points near its first and its second end.
    let first = 3.0 * (squares * next);
    let second = 3.0 * (next * next * w);
    let sides = ((control_point(net + 3u) * first.x + control_point(net + 4u) * second.x)
        + (control_point(net + 5u) * first.y + control_point(net + 6u) * second.y))
        + (control_point(net + 7u) * first.z + control_point(net + 8u) * second.z);
    let p = (blend(net, squares * w) + sides) + control_point(net + 9u) * (6.0 * (w.x * w.y * w.z));
    let normals = net + 10u;
    var m = blend(normals, squares) + blend(normals + 3u, products);
    let size = dot(m, m);
    if !(size > 1e-12 && size < 3.4e38) {
        m = blend(normals, w);
    }
    m = normalize_or_zero(m);
    return Sample(p, select(m, vec3<f32>(0.0, 0.0, 1.0), all(m == vec3<f32>(0.0))));
}

fn pn_spot(quad: u32, place: u32) -> Sample {
    let mask = (1u << PLACE_BITS) - 1u;
    return pn_at(quad, place & mask, (place >> PLACE_BITS) & mask, 1u << (place >> (2u * PLACE_BITS)));
}

fn uv_at(gather: u32, count: u32, table: u32, stride: u32, place: u32) -> UvJet {
    var out = UvJet(vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0));
    for (var k = 0u; k < count; k++) {
        let at = gathers[gather + k];
        let value = vec2<f32>(control[at], control[at + 1u]);
        let w = table + chunk.uv_width * (k * stride + place);
        out.uv += weights[w] * value;
        if (LIFTED || TILTED) && chunk.uv_width == 3u {
            out.by_u += weights[w + 1u] * value;
            out.by_v += weights[w + 2u] * value;
        }
    }
    return out;
}

// Each face's own: no others need agree.
fn texture_coordinates(face: Face, place: u32) -> UvJet {
    return uv_at(face.uv_gather, face.uv_count, face.uv_table, face.row * face.row, place);
}

fn put_tangents(at: u32, jet: Jet, uv: UvJet) {
    var t = by_uv(jet, uv);
    if LIFTED && rise.per_pixel != 0u {
        t = tilts_of(jet, normal(jet), map_height(uv.uv), uv);
    }
    let k = 6u * at;
    tangents[k] = t.first.x;
    tangents[k + 1u] = t.first.y;
    tangents[k + 2u] = t.first.z;
    tangents[k + 3u] = t.second.x;
    tangents[k + 4u] = t.second.y;
    tangents[k + 5u] = t.second.z;
}

// Colours of vertices go by the weights of points.
fn color(face: Face, place: u32) -> vec3<f32> {
    let s = stencils[face.color_stencil];
    var c = vec3<f32>(0.0);
    for (var k = 0u; k < s.count; k++) {
        let at = face.colors + 3u * gathers[s.gather + k];
        c += weights[chunk.color_width * (s.table + k * s.stride + place)] * vec3<f32>(control[at], control[at + 1u], control[at + 2u]);
    }
    return c;
}

@compute @workgroup_size(GROUP)
fn inside(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = own_group(group);
    if number >= chunk.blocks {
        return;
    }
    let block = blocks[number];
    let face = faces[block.face];
    let side = (1u << block.log) + 1u;
    for (var at = lane; at < side * side; at += GROUP) {
        var x = block.start_x + (at % side) * block.step;
        var y = block.start_y + (at / side) * block.step;
        for (var m = 0u; m < block.move_count; m++) {
            let moved = moves[block.moves + m];
            if moved.at == at {
                x = moved.x;
                y = moved.y;
            }
        }
        if chunk.triangles != 0u {
            // Above the diagonal all is folded onto it.
            x = max(x, y);
        }
        let place = ((y << face.shift) * face.row) + (x << face.shift);
        let uv = texture_coordinates(face, place);
        let n = 1u << face.reach;
        let side_place = side_of(x, y, n);
        let is_own = side_place.x == INSIDE && chunk.patches == 0u;
        let wants_tangents = TILTED && chunk.tangents != 0u && chunk.textured != 0u && face.uv_count > 0u;
        var jet: Jet;
        if is_own || wants_tangents {
            jet = evaluate(face.stencil, place);
        }
        if chunk.textured != 0u && face.uv_count > 0u {
            uvs[block.base + at] = uv.uv;
            if wants_tangents {
                put_tangents(block.base + at, jet, uv);
            }
        }
        if face.colors > 0u {
            let c = color(face, place);
            let k = 3u * (block.base + at);
            colors[k] = c.x;
            colors[k + 1u] = c.y;
            colors[k + 2u] = c.z;
        }
        if side_place.x != INSIDE && (side_place.y == 0u || chunk.patches != QAS) {
            copy(on_side(face, side_place.x, side_place.y, n), block.base + at);
        } else if chunk.patches == PN {
            let s = pn_at(face.middle, x, y, n);
            put(block.base + at, s.p, s.n);
        } else if chunk.patches == QAS {
            let s = patch_at(face, x, y, n);
            put(block.base + at, s.p, normalize_or_zero(s.n));
        } else {
            let m = normal(jet);
            if !LIFTED || rise.shape == STILL {
                put(block.base + at, jet.p, m);
            } else {
                let s = height_at(jet.p, uv.uv);
                put(block.base + at, jet.p + m * s.h, lifted_normal(jet, m, s.h, slopes_of(jet, s.by, uv)));
            }
        }
    }
}
