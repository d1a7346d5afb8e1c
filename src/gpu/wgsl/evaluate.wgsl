// A face at places of its grid, as sums of weights times control points, and where its sides have their points.

@group(0) @binding(0) var<uniform> chunk: Chunk;
@group(0) @binding(1) var<storage, read> control: array<f32>;
@group(0) @binding(2) var<storage, read> gathers: array<u32>;
@group(0) @binding(3) var<storage, read> weights: array<f32>;
@group(0) @binding(4) var<storage, read> stencils: array<Stencil>;

// The limit surface at a place: by u, by v, by u twice, by both, by v twice.
struct Jet {
    p: vec3<f32>,
    du: vec3<f32>,
    dv: vec3<f32>,
    duu: vec3<f32>,
    duv: vec3<f32>,
    dvv: vec3<f32>,
}

fn control_point(k: u32) -> vec3<f32> {
    return vec3<f32>(control[3u * k], control[3u * k + 1u], control[3u * k + 2u]);
}

// Relative to the first control point: weights of positions sum to one, those of derivatives to nothing, so surfaces far from the origin
// lose nothing.
fn evaluate(stencil: u32, index: u32) -> Jet {
    let s = stencils[stencil];
    let origin = control_point(gathers[s.gather]);
    var jet = Jet(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
    for (var k = 1u; k < s.count; k++) {
        let q = control_point(gathers[s.gather + k]) - origin;
        let w = chunk.width * (s.table + k * s.stride + index);
        jet.p += weights[w] * q;
        jet.du += weights[w + 1u] * q;
        jet.dv += weights[w + 2u] * q;
        if LIFTED && chunk.width == 6u {
            jet.duu += weights[w + 3u] * q;
            jet.duv += weights[w + 4u] * q;
            jet.dvv += weights[w + 5u] * q;
        }
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
