// Points and normals of blocks, as sums of weights times control points.
//
// First `sides`: corners and points of sides, an invocation each, once per chunk whoever shares them. Then `inside`: what lies within
// faces is summed up, what lies on a side is copied, so that faces which meet there have the same bits, fused or not.

@group(0) @binding(0) var<uniform> chunk: Chunk;
@group(0) @binding(1) var<storage, read> control: array<f32>;
@group(0) @binding(2) var<storage, read> gathers: array<u32>;
@group(0) @binding(3) var<storage, read> weights: array<f32>;
@group(0) @binding(4) var<storage, read> stencils: array<Stencil>;
@group(0) @binding(5) var<storage, read> spots: array<Spot>;
@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> blocks: array<Block>;
@group(0) @binding(8) var<storage, read> moves: array<Move>;
@group(0) @binding(9) var<storage, read_write> points: array<f32>;

// Texture coordinates, at the same places as points.
@group(0) @binding(10) var<storage, read_write> uvs: array<vec2<f32>>;

// Colours, at the same places.
@group(0) @binding(11) var<storage, read_write> colors: array<f32>;

struct Jet {
    p: vec3<f32>,
    du: vec3<f32>,
    dv: vec3<f32>,
}

fn control_point(k: u32) -> vec3<f32> {
    return vec3<f32>(control[3u * k], control[3u * k + 1u], control[3u * k + 2u]);
}

// Relative to the first control point: weights of positions sum to one, those of derivatives to nothing, so surfaces far from the origin
// lose nothing.
fn evaluate(stencil: u32, index: u32) -> Jet {
    let s = stencils[stencil];
    let origin = control_point(gathers[s.gather]);
    var jet = Jet(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
    for (var k = 1u; k < s.count; k++) {
        let q = control_point(gathers[s.gather + k]) - origin;
        let w = 3u * (s.table + k * s.stride + index);
        jet.p += weights[w] * q;
        jet.du += weights[w + 1u] * q;
        jet.dv += weights[w + 2u] * q;
    }
    jet.p += origin;
    return jet;
}

// Largest component 1, so that products neither vanish nor run away.
fn scaled(v: vec3<f32>) -> vec3<f32> {
    let most = max(max(abs(v.x), abs(v.y)), abs(v.z));
    return select(vec3<f32>(0.0), v / most, most > 0.0);
}

// Unit normal, or zeros where the derivatives have none.
fn normal(jet: Jet) -> vec3<f32> {
    let n = cross(normalize_or_zero(jet.du), normalize_or_zero(jet.dv));
    let square = dot(n, n);
    return select(vec3<f32>(0.0), n * inverseSqrt(square), square > 1e-10);
}

fn normalize_or_zero(v: vec3<f32>) -> vec3<f32> {
    let s = scaled(v);
    let square = dot(s, s);
    return select(vec3<f32>(0.0), s * inverseSqrt(square), square > 0.0);
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

@compute @workgroup_size(GROUP)
fn sides(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = own_index(group, lane);
    if at >= chunk.spots {
        return;
    }
    let spot = spots[at];
    let jet = evaluate(spot.stencil, spot.index);
    var n = normal(jet);
    if spot.normal_stencil != spot.stencil || spot.normal_index != spot.index {
        n = normal(evaluate(spot.normal_stencil, spot.normal_index));
    }
    put(at, jet.p, n);
}

// The spot that a place of a face is, on its side `c` at `k` of `n`.
fn on_side(face: Face, c: u32, k: u32, n: u32) -> u32 {
    if k == 0u {
        return face.corners[c];
    }
    let turn = (face.turns >> (8u * c)) & 255u;
    let finer = turn & 63u;
    let along = select(k, n - k, (turn & 128u) != 0u) << finer;
    return face.sides[c] + along - 1u;
}

const INSIDE = 4u;

// Side of a place, and how far along; corners begin their side.
fn side_of(x: u32, y: u32, n: u32) -> vec2<u32> {
    if chunk.triangles != 0u {
        if x == y {
            // From corner 2 back to corner 0.
            return select(vec2<u32>(2u, n - x), vec2<u32>(0u, 0u), x == 0u);
        }
        if y == 0u {
            return select(vec2<u32>(0u, x), vec2<u32>(1u, 0u), x == n);
        }
        return select(vec2<u32>(INSIDE, 0u), vec2<u32>(1u, y), x == n);
    }
    if y == 0u && x < n {
        return vec2<u32>(0u, x);
    }
    if x == n && y < n {
        return vec2<u32>(1u, y);
    }
    if y == n && x > 0u {
        return vec2<u32>(2u, n - x);
    }
    return select(vec2<u32>(INSIDE, 0u), vec2<u32>(3u, n - y), x == 0u);
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

// Each face's own: no others need agree.
fn texture_coordinates(face: Face, place: u32) -> vec2<f32> {
    var uv = vec2<f32>(0.0);
    for (var k = 0u; k < face.uv_count; k++) {
        let at = gathers[face.uv_gather + k];
        uv += weights[face.uv_table + k * face.row * face.row + place] * vec2<f32>(control[at], control[at + 1u]);
    }
    return uv;
}

// Colours of vertices go by the weights of points.
fn color(face: Face, place: u32) -> vec3<f32> {
    let s = stencils[face.stencil];
    var c = vec3<f32>(0.0);
    for (var k = 0u; k < s.count; k++) {
        let at = face.colors + 3u * gathers[s.gather + k];
        c += weights[3u * (s.table + k * s.stride + place)] * vec3<f32>(control[at], control[at + 1u], control[at + 2u]);
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
        if face.uv_count > 0u {
            uvs[block.base + at] = texture_coordinates(face, place);
        }
        if face.colors > 0u {
            let c = color(face, place);
            let k = 3u * (block.base + at);
            colors[k] = c.x;
            colors[k + 1u] = c.y;
            colors[k + 2u] = c.z;
        }
        let n = 1u << face.reach;
        let side_place = side_of(x, y, n);
        if side_place.x != INSIDE && (side_place.y == 0u || chunk.patches == 0u) {
            copy(on_side(face, side_place.x, side_place.y, n), block.base + at);
        } else if chunk.patches != 0u {
            let s = patch_at(face, x, y, n);
            put(block.base + at, s.p, normalize_or_zero(s.n));
        } else {
            let jet = evaluate(face.stencil, place);
            put(block.base + at, jet.p, normal(jet));
        }
    }
}
