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
    let k = 6u * at;
    points[k] = p.x;
    points[k + 1u] = p.y;
    points[k + 2u] = p.z;
    points[k + 3u] = n.x;
    points[k + 4u] = n.y;
    points[k + 5u] = n.z;
}

fn copy(from_at: u32, to: u32) {
    for (var k = 0u; k < 6u; k++) {
        points[6u * to + k] = points[6u * from_at + k];
    }
}

@compute @workgroup_size(64)
fn sides(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = (group.y * chunk.groups + group.x) * 64u + lane;
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

const NOWHERE = 0xffffffffu;

// The spot that a place of a face is, on its side `c` at `k` of `n`.
fn on_side(face: Face, c: u32, k: u32, n: u32) -> u32 {
    if k == 0u {
        return face.corners[c];
    }
    let turn = (face.turns >> (8u * c)) & 255u;
    let finer = turn & 127u;
    let along = select(k, n - k, (turn & 128u) != 0u) << finer;
    return face.sides[c] + along - 1u;
}

fn shared_spot(face: Face, x: u32, y: u32) -> u32 {
    let n = 1u << face.reach;
    if chunk.triangles != 0u {
        if x == y {
            // From corner 2 back to corner 0.
            if x == 0u {
                return face.corners[0];
            }
            return on_side(face, 2u, n - x, n);
        }
        if y == 0u {
            if x == n {
                return face.corners[1];
            }
            return on_side(face, 0u, x, n);
        }
        if x == n {
            return on_side(face, 1u, y, n);
        }
        return NOWHERE;
    }
    if y == 0u && x < n {
        return on_side(face, 0u, x, n);
    }
    if x == n && y < n {
        return on_side(face, 1u, y, n);
    }
    if y == n && x > 0u {
        return on_side(face, 2u, n - x, n);
    }
    if x == 0u {
        return on_side(face, 3u, n - y, n);
    }
    return NOWHERE;
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

@compute @workgroup_size(64)
fn inside(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.y * chunk.groups + group.x;
    if number >= chunk.blocks {
        return;
    }
    let block = blocks[number];
    let face = faces[block.face];
    let side = (1u << block.log) + 1u;
    for (var at = lane; at < side * side; at += 64u) {
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
        let spot = shared_spot(face, x, y);
        if spot != NOWHERE {
            copy(spot, block.base + at);
        } else {
            let jet = evaluate(face.stencil, place);
            put(block.base + at, jet.p, normal(jet));
        }
    }
}
