// Points and normals of blocks, as sums of weights times control points.
//
// First `sides` (sides.wgsl): corners and points of sides, an invocation each, once per chunk whoever shares them; then those that stand on
// others. Then `inside`: what lies within faces is summed up, what lies on a side is copied, so that faces which meet there have the same
// bits, fused or not.

@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> blocks: array<Block>;
@group(0) @binding(8) var<storage, read> moves: array<Move>;
@group(0) @binding(9) var<storage, read_write> points: array<f32>;

// Texture coordinates, at the same places as points.
@group(0) @binding(10) var<storage, read_write> uvs: array<vec2<f32>>;

// What displaces, and the heights of all maps.
@group(0) @binding(12) var<uniform> rise: Rise;
@group(0) @binding(14) var<storage, read> heights: array<f32>;

// What tilts normals, two vectors at each of the same places.
@group(0) @binding(15) var<storage, read_write> tangents: array<f32>;

// Colours, at the same places.
@group(0) @binding(11) var<storage, read_write> colors: array<f32>;

fn is_lifted() -> bool {
    return LIFTED && rise.shape != STILL;
}

// Under slopes by pixel, normals are those of the limit.
fn lifted_normal(jet: Jet, n: vec3<f32>, height: f32, slope: vec2<f32>) -> vec3<f32> {
    return select(displaced_normal(jet, n, height, slope), n, rise.per_pixel != 0u);
}

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

fn put_tangents(at: u32, jet: Jet, n: vec3<f32>, uv: UvJet) {
    var t = by_uv(jet, uv);
    if LIFTED && rise.per_pixel != 0u {
        t = tilts_of(jet, n, map_height(uv.uv), uv);
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

fn place_of(face: Face, x: u32, y: u32) -> u32 {
    return ((y << face.shift) * face.row) + (x << face.shift);
}

// Point and unit normal of a face before it is displaced, or of its patch; `jet` is that of the limit surface.
fn ground(face: Face, x: u32, y: u32, jet: Jet) -> Sample {
    if chunk.patches == PN {
        return pn_at(face.middle, x, y, 1u << face.reach);
    }
    if chunk.patches == QAS {
        let s = patch_at(face, x, y, 1u << face.reach);
        return Sample(s.p, normalize_or_zero(s.n));
    }
    return Sample(jet.p, normal(jet));
}

fn ground_point(face: Face, at: vec2<u32>) -> vec3<f32> {
    // Above the diagonal all is folded onto it.
    let x = select(at.x, max(at.x, at.y), chunk.triangles != 0u);
    var jet: Jet;
    if chunk.patches == 0u {
        jet = evaluate(face.stencil, place_of(face, x, at.y));
    }
    return ground(face, x, at.y, jet).p;
}

fn ground_uv(face: Face, at: vec2<u32>) -> vec2<f32> {
    let x = select(at.x, max(at.x, at.y), chunk.triangles != 0u);
    return texture_coordinates(face, place_of(face, x, at.y)).uv;
}

// Derivatives of surfaces that have no formula: differences of the block's points, and of its texture coordinates. None where a point was moved
// out of the block.
struct Differences {
    du: vec3<f32>,
    dv: vec3<f32>,
    uv_du: vec2<f32>,
    uv_dv: vec2<f32>,
}

fn differences(block: Block, face: Face, at: vec2<u32>) -> Differences {
    var out: Differences;
    let low = vec2<u32>(block.start_x, block.start_y);
    let high = low + (block.step << block.log);
    if block.step == 0u || any(at < low) || any(at > high) || any((at - low) % block.step != vec2<u32>(0u)) {
        return out;
    }
    let a = max(at, low + block.step) - block.step;
    let b = min(at + block.step, high);
    let steps = 1.0 / max(vec2<f32>((b - a) / block.step), vec2<f32>(1.0));
    out.du = (ground_point(face, vec2<u32>(b.x, at.y)) - ground_point(face, vec2<u32>(a.x, at.y))) * steps.x;
    out.dv = (ground_point(face, vec2<u32>(at.x, b.y)) - ground_point(face, vec2<u32>(at.x, a.y))) * steps.y;
    if face.uv_count > 0u {
        out.uv_du = (ground_uv(face, vec2<u32>(b.x, at.y)) - ground_uv(face, vec2<u32>(a.x, at.y))) * steps.x;
        out.uv_dv = (ground_uv(face, vec2<u32>(at.x, b.y)) - ground_uv(face, vec2<u32>(at.x, a.y))) * steps.y;
    }
    return out;
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
    let differs = (LIFTED || TILTED) && chunk.differences != 0u;
    for (var at = lane; at < side * side; at += GROUP) {
        // Above the diagonal of a triangle all is folded onto it, moved or not.
        let half = chunk.triangles != 0u && block.start_x == block.start_y && block.list_count == 0u;
        let place_in = select(at, at / side * side + max(at % side, at / side), half);
        var x = block.start_x + (place_in % side) * block.step;
        var y = block.start_y + (place_in / side) * block.step;
        if block.step == 0u {
            // What is left of the block repeats the last.
            let own = moves[block.moves + min(at, block.move_count - 1u)];
            x = own.x;
            y = own.y;
        }
        for (var m = 0u; block.step > 0u && m < block.move_count; m++) {
            let moved = moves[block.moves + m];
            if moved.at == place_in {
                x = moved.x;
                y = moved.y;
            }
        }
        if chunk.triangles != 0u {
            // Above the diagonal all is folded onto it.
            x = max(x, y);
        }
        let place = place_of(face, x, y);
        var uv = texture_coordinates(face, place);
        let n = 1u << face.reach;
        let side_place = side_of(x, y, n);
        let is_inside = side_place.x == INSIDE;
        let wants_tangents = TILTED && chunk.tangents != 0u && chunk.textured != 0u && face.uv_count > 0u;
        // Points of sides have their normals, but for those that are each face's own.
        let is_copied = !is_inside && (side_place.y == 0u || chunk.patches != QAS || is_lifted());
        let wants_own = wants_tangents || (differs && is_lifted());
        var jet: Jet;
        if wants_own || (is_inside && (chunk.patches == 0u || is_lifted())) {
            jet = evaluate(face.stencil, place);
        }
        var s: Sample;
        if wants_own || !is_copied {
            s = ground(face, x, y, jet);
            jet.p = s.p;
        }
        if differs && wants_own {
            let d = differences(block, face, vec2<u32>(x, y));
            jet = Jet(s.p, d.du, d.dv, vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
            uv = UvJet(uv.uv, d.uv_du, d.uv_dv);
        }
        if chunk.textured != 0u && face.uv_count > 0u {
            uvs[block.base + at] = uv.uv;
            if wants_tangents {
                put_tangents(block.base + at, jet, s.n, uv);
            }
        }
        if face.colors > 0u {
            let c = color(face, place);
            let k = 3u * (block.base + at);
            colors[k] = c.x;
            colors[k + 1u] = c.y;
            colors[k + 2u] = c.z;
        }
        if is_copied {
            let spot = on_side(face, side_place.x, side_place.y, n);
            copy(spot, block.base + at);
            if !(differs && is_lifted()) {
                continue;
            }
            s.n = sample_at(spot).n;
        }
        if !is_lifted() {
            put(block.base + at, s.p, s.n);
            continue;
        }
        let h = height_at(s.p, uv.uv);
        let m = lifted_normal(jet, s.n, h.h, slopes_of(jet, h.by, uv));
        if is_copied {
            put(block.base + at, sample_at(block.base + at).p, m);
        } else {
            put(block.base + at, s.p + s.n * h.h, m);
        }
    }
}
