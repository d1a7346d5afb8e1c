// What a sample shows of a block: its id, and the place on its micro-triangle.

struct Id {
    rank: u32,
    line: u32,
    col: u32,
    half: u32,
}

fn unpack(id: u32) -> Id {
    let mask = (1u << frame.id_bits) - 1u;
    return Id(id >> (2u * frame.id_bits + 1u), (id >> (frame.id_bits + 1u)) & mask, (id >> 1u) & mask, id & 1u);
}

fn position(at: u32) -> vec3<f32> {
    return vec3<f32>(points[POINT_FLOATS * at], points[POINT_FLOATS * at + 1u], points[POINT_FLOATS * at + 2u]);
}

struct Weights {
    w: vec3<f32>,
    // Which side is seen, by the snapped triangle; 0 where it is too thin, 2 where it was clipped.
    side: f32,
}

fn weights(a: vec3<f32>, m: vec3<f32>, c: vec3<f32>, half: u32, p: vec2<i32>) -> Weights {
    let va = project(a);
    let vm = project(m);
    let vc = project(c);
    var w: vec3<f32>;
    var side = 2.0;
    if va.depth != 0.0 && vm.depth != 0.0 && vc.depth != 0.0 {
        let pa = vec2<i32>(va.x, va.y);
        let pm = vec2<i32>(vm.x, vm.y);
        let pc = vec2<i32>(vc.x, vc.y);
        w = vec3<f32>(wide_size(wide_edge(pc - pm, pm, p)), wide_size(wide_edge(pa - pc, pc, p)), wide_size(wide_edge(pm - pa, pa, p)));
        if frame.ortho == 0u {
            w *= vec3<f32>(va.depth, vm.depth, vc.depth);
        }
        let area = wide_edge(pm - pa, pa, pc);
        let size = abs(pm - pa) + abs(pc - pa);
        let thin = wide_size(area) <= f32(size.x + size.y) + 2.0;
        let front = wide_is_negative(area) == (half == 0u);
        side = select(select(-1.0, 1.0, front), 0.0, thin);
    } else {
        let ha = homogeneous(a);
        let hm = homogeneous(m);
        let hc = homogeneous(c);
        let s = vec3<f32>(vec2<f32>(p), 1.0);
        w = vec3<f32>(
            dot(s, cross(hm.xyz, hc.xyz)),
            dot(s, cross(hc.xyz, ha.xyz)),
            dot(s, cross(ha.xyz, hm.xyz)));
        w = max(w / (w.x + w.y + w.z), vec3<f32>(0.0));
    }
    let sum = (w.x + w.y) + w.z;
    if sum > 0.0 && sum < 3.4e38 {
        return Weights(w * (1.0 / sum), side);
    }
    return Weights(vec3<f32>(1.0, 0.0, 0.0), side);
}

// Points of what an id shows, and the half of a micro-quad that says which way round they run.
struct Corners {
    a: u32,
    m: u32,
    c: u32,
    half: u32,
}

// Triangle `k` of a block that is a list: two words, the first points in the halves of the first.
fn listed(block: Block, k: u32) -> Corners {
    let at = block.list + 2u * k;
    let word = lists[at];
    return Corners(block.base + (word & 0xffffu), block.base + (word >> 16u), block.base + lists[at + 1u], 0u);
}

fn corners_of(block: Block, id: Id) -> Corners {
    if LISTED && block.list_count > 0u {
        return listed(block, (((id.line << frame.id_bits) | id.col) << 1u) | id.half);
    }
    let side_len = (1u << block.log) + 1u;
    let first = block.base + id.line * side_len + id.col;
    return Corners(first, first + select(1u, side_len, id.half == 1u), first + side_len + 1u, id.half);
}

// Side of the square in texture coordinates that covers the area of a pixel, from differences along the grid.
fn footprint(base: u32, side_len: u32, i: u32, j: u32) -> f32 {
    var i0 = base + j * side_len + max(i, 1u) - 1u;
    var i1 = base + j * side_len + min(i + 1u, side_len - 1u);
    let above = max(j, 1u) - 1u;
    let below = min(j + 1u, side_len - 1u);
    let j0 = base + above * side_len + i;
    let j1 = base + below * side_len + i;
    var a = project(position(i0));
    var b = project(position(i1));
    if a.x == b.x && a.y == b.y && all(uvs[i0] == uvs[i1]) {
        // A triangle repeats its last corner: the row beside tells then.
        i0 = i0 + (above + below) * side_len - 2u * j * side_len;
        i1 = i1 + (above + below) * side_len - 2u * j * side_len;
        a = project(position(i0));
        b = project(position(i1));
    }
    let c = project(position(j0));
    let d = project(position(j1));
    let su = vec2<f32>(f32(b.x - a.x), f32(b.y - a.y)) / 256.0;
    let sv = vec2<f32>(f32(d.x - c.x), f32(d.y - c.y)) / 256.0;
    let tu = uvs[i1] - uvs[i0];
    let tv = uvs[j1] - uvs[j0];
    let pixels = abs(su.x * sv.y - su.y * sv.x);
    return sqrt(abs(tu.x * tv.y - tu.y * tv.x) / max(pixels, 1.0 / 256.0));
}

// The same at a point of a list, from the areas of the triangles around it.
fn list_footprint(block: Block, at: u32) -> f32 {
    let own = block.around + at - block.base;
    var texture = 0.0;
    var pixels = 0.0;
    for (var k = lists[own]; k < lists[own + 1u]; k++) {
        let t = listed(block, lists[block.around + k]);
        let a = project(position(t.a));
        let m = project(position(t.m));
        let c = project(position(t.c));
        let p = vec2<f32>(f32(m.x - a.x), f32(m.y - a.y)) / 256.0;
        let q = vec2<f32>(f32(c.x - a.x), f32(c.y - a.y)) / 256.0;
        let u = uvs[t.m] - uvs[t.a];
        let v = uvs[t.c] - uvs[t.a];
        texture += abs(u.x * v.y - u.y * v.x);
        pixels += abs(p.x * q.y - p.y * q.x);
    }
    return sqrt(texture / max(pixels, 1.0 / 256.0));
}

// The same at a sample, blended from the three corners of its micro-triangle.
fn footprint_at(block: Block, id: Id, at: Corners, w: vec3<f32>) -> f32 {
    if LISTED && block.list_count > 0u {
        return w.x * list_footprint(block, at.a) + w.y * list_footprint(block, at.m) + w.z * list_footprint(block, at.c);
    }
    let side_len = (1u << block.log) + 1u;
    let base = block.base;
    return w.x * footprint(base, side_len, id.col, id.line)
        + w.y * footprint(base, side_len, id.col + select(1u, 0u, id.half == 1u), id.line + select(0u, 1u, id.half == 1u))
        + w.z * footprint(base, side_len, id.col + 1u, id.line + 1u);
}
