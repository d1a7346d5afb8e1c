// Points moved along normals, and the normals of what comes out: the arithmetic of src/displace/normal.rs.

// Texture coordinates there, with their derivatives.
struct UvJet {
    uv: vec2<f32>,
    by_u: vec2<f32>,
    by_v: vec2<f32>,
}

// Derivatives of the unit normal by both parameters.
struct Turns {
    u: vec3<f32>,
    v: vec3<f32>,
}

fn turns_of(jet: Jet, n: vec3<f32>) -> Turns {
    let e = dot(jet.du, jet.du);
    let f = dot(jet.du, jet.dv);
    let g = dot(jet.dv, jet.dv);
    let l = dot(jet.duu, n);
    let m = dot(jet.duv, n);
    let k = dot(jet.dvv, n);
    let det = e * g - f * f;
    // Of parallel tangents nothing follows.
    if !(det > 1e-10 * e * g) {
        return Turns(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    return Turns(
        (jet.du * (f * m - g * l) + jet.dv * (f * l - e * m)) / det,
        (jet.du * (f * k - g * m) + jet.dv * (f * m - e * k)) / det);
}

// Slopes of the height by both parameters.
fn slopes_of(jet: Jet, slope: vec3<f32>, at: UvJet) -> vec2<f32> {
    if rise.shape == MAP {
        return vec2<f32>(dot(slope.xy, at.by_u), dot(slope.xy, at.by_v)) * rise.scale;
    }
    return vec2<f32>(dot(jet.du, slope), dot(jet.dv, slope)) * rise.scale;
}

// Unit normal of the displaced surface; `n` where there is none.
fn displaced_normal(jet: Jet, n: vec3<f32>, height: f32, slope: vec2<f32>) -> vec3<f32> {
    let turn = turns_of(jet, n);
    let along = scaled((jet.du + turn.u * height) + n * slope.x);
    let across = scaled((jet.dv + turn.v * height) + n * slope.y);
    let c = cross(along, across);
    let square = dot(c, c);
    return select(n, c * inverseSqrt(square), square > 1e-12);
}

// The direction in which a point with several normals moves.
fn mitre(sum: vec3<f32>, count: f32, first: vec3<f32>) -> vec3<f32> {
    let square = dot(sum, sum);
    return select(sum * min(count / square, 2.0 * inverseSqrt(square)), first, square < 1e-6);
}

struct Tangents {
    first: vec3<f32>,
    second: vec3<f32>,
}

// Vectors by which the slopes of a map tilt the limit normal, pixel by pixel.
fn tilts_of(jet: Jet, n: vec3<f32>, height: f32, at: UvJet) -> Tangents {
    let turn = turns_of(jet, n);
    let du = jet.du + turn.u * height;
    let dv = jet.dv + turn.v * height;
    let area = dot(n, cross(du, dv));
    let factor = rise.scale / area;
    if area == 0.0 || !(abs(factor) < 3.4e38) {
        return Tangents(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let first = cross(dv, n);
    let second = cross(n, du);
    return Tangents(
        (first * at.by_u.x + second * at.by_v.x) * factor,
        (first * at.by_u.y + second * at.by_v.y) * factor);
}

// Derivatives of the surface by its texture coordinates.
fn by_uv(jet: Jet, at: UvJet) -> Tangents {
    let det = at.by_u.x * at.by_v.y - at.by_v.x * at.by_u.y;
    let factor = 1.0 / det;
    if det == 0.0 || !(abs(factor) < 3.4e38) {
        return Tangents(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    return Tangents(
        (jet.du * at.by_v.y - jet.dv * at.by_u.y) * factor,
        (jet.dv * at.by_u.x - jet.du * at.by_v.x) * factor);
}
