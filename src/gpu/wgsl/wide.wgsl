// Exact edge values of any size: integers of 64 bits as (low, high) in two's complement, for devices without them.

fn wide_product(a: i32, b: i32) -> vec2<u32> {
    let x = u32(abs(a));
    let y = u32(abs(b));
    let x0 = x & 0xffffu;
    let x1 = x >> 16u;
    let y0 = y & 0xffffu;
    let y1 = y >> 16u;
    let low = x0 * y0;
    let first = x1 * y0;
    let second = x0 * y1;
    let middle = (low >> 16u) + (first & 0xffffu) + (second & 0xffffu);
    let product = vec2<u32>((low & 0xffffu) | (middle << 16u), x1 * y1 + (first >> 16u) + (second >> 16u) + (middle >> 16u));
    return select(product, wide_negative(product), (a < 0) != (b < 0));
}

fn wide_negative(a: vec2<u32>) -> vec2<u32> {
    let low = ~a.x + 1u;
    return vec2<u32>(low, ~a.y + select(0u, 1u, low == 0u));
}

fn wide_difference(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x - b.x;
    return vec2<u32>(low, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn wide_is_negative(a: vec2<u32>) -> bool {
    return (a.y >> 31u) != 0u;
}

// Value of the edge from (ax, ay) with direction (dx, dy) at (px, py).
fn wide_edge(d: vec2<i32>, a: vec2<i32>, p: vec2<i32>) -> vec2<u32> {
    return wide_difference(wide_product(d.x, p.y - a.y), wide_product(d.y, p.x - a.x));
}

// Whether it is at least `t`, 0 or 1.
fn wide_at_least(a: vec2<u32>, t: i32) -> bool {
    return !wide_is_negative(a) && (t == 0 || (a.x | a.y) != 0u);
}

// Its size as a number.
fn wide_size(a: vec2<u32>) -> f32 {
    let m = select(a, wide_negative(a), wide_is_negative(a));
    return f32(m.y) * 4294967296.0 + f32(m.x);
}
