// Patches in place of the limit surface: quadratics through points of level 1 (QAS), and curved PN triangles.

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

// Point and unit normal of a curve of a lift.
fn on_curve(curve: vec4<u32>) -> Sample {
    if chunk.patches == PN {
        return pn_spot(curve.x, curve.y);
    }
    let t = f32(curve.w & ((1u << PLACE_BITS) - 1u)) / f32(1u << (curve.w >> (2u * PLACE_BITS)));
    let s = quadratic(sample_at(curve.x), sample_at(curve.y), sample_at(curve.z), shares(t));
    return Sample(s.p, normalize_or_zero(s.n));
}

// QAS: quadratics through points and normals of level 1. A side is walked as its positions' owner walks it, by both faces.
fn patch_at(face: Face, x: u32, y: u32, n: u32) -> Sample {
    let side = side_of(x, y, n);
    let last = select(4u, 3u, chunk.triangles != 0u);
    if side.x != INSIDE {
        let c = side.x;
        let next = select(c + 1u, 0u, c + 1u == last);
        let turned = ((face.turns >> (8u * c)) & 64u) != 0u;
        let a = sample_at(face.base_corners[select(c, next, turned)]);
        let b = sample_at(face.base_corners[select(next, c, turned)]);
        let k = select(side.y, n - side.y, turned);
        return quadratic(a, sample_at(face.base_sides[c]), b, shares(f32(k) / f32(n)));
    }
    let u = f32(x) / f32(n);
    let v = f32(y) / f32(n);
    if chunk.triangles != 0u {
        let w = vec3<f32>(1.0 - u, u - v, v);
        let corner = w * (2.0 * w - 1.0);
        let middle = 4.0 * w * w.yzx;
        var sum = Sample(vec3<f32>(0.0), vec3<f32>(0.0));
        for (var c = 0u; c < 3u; c++) {
            let at = sample_at(face.base_corners[c]);
            let half = sample_at(face.base_sides[c]);
            sum.p += corner[c] * at.p + middle[c] * half.p;
            sum.n += corner[c] * at.n + middle[c] * half.n;
        }
        return sum;
    }
    let w = shares(u);
    let low = quadratic(sample_at(face.base_corners[0]), sample_at(face.base_sides[0]), sample_at(face.base_corners[1]), w);
    let middle = quadratic(sample_at(face.base_sides[3]), sample_at(face.middle), sample_at(face.base_sides[1]), w);
    let high = quadratic(sample_at(face.base_corners[3]), sample_at(face.base_sides[2]), sample_at(face.base_corners[2]), w);
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
