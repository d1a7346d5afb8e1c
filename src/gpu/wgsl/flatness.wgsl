// What every face needs: from samples of its inside, as far as they are needed. A workgroup decides one face, as src/tessellate/flatness does.
//
// Samples of one level are among those of the next: a step of refinement is measured once, whichever square of the face asks. The
// finest are not kept: each lies in the middle of one edge between samples that are.

@group(0) @binding(5) var<storage, read> faces: array<Face>;
@group(0) @binding(6) var<storage, read> patches: array<Patch>;
// Of the chunk: spots are there.
@group(0) @binding(7) var<storage, read> points: array<f32>;
@group(0) @binding(9) var<storage, read_write> nodes: array<u32>;
@group(0) @binding(10) var<storage, read_write> totals: array<atomic<u32>>;

const KEPT_SIDE = (1u << KEPT) + 1u;
const KEPT_SAMPLES = KEPT_SIDE * KEPT_SIDE;
var<workgroup> samples: array<f32, 6 * KEPT_SAMPLES>;
var<workgroup> far: array<f32, CELLS>;
var<workgroup> bend: array<f32, CELLS>;
var<workgroup> lengths: array<f32, CELLS>;
// Levels that squares need: of the face, of a quarter of it, and of a quarter of that, depth by depth.
var<workgroup> needs: array<u32, NEEDS>;
var<workgroup> costs: array<u32, SQUARES>;
// The square that is measured (NONE: all are), its samples as a power of two, and the corner that it lies at.
var<workgroup> square: u32;
var<workgroup> logs: array<u32, NESTED>;
var<workgroup> corner: u32;
// Level of the samples that are there.
var<workgroup> filled: u32;
var<workgroup> job: vec4<u32>;

fn first_cell(k: u32) -> u32 {
    return ((1u << (2u * k)) - 1u) / 3u;
}

fn first_need(of_square: u32) -> u32 {
    var at = 0u;
    for (var k = 0u; k < of_square; k++) {
        at += first_cell(KEPT + 1u - k);
    }
    return at;
}

// A sample at a place of the finest grid.
fn sampled(face: u32, x: u32, y: u32) -> Seen {
    let n = 1u << faces[face].reach;
    let side = side_of(x, y, n);
    if side.x != INSIDE {
        return spot_at(on_side(faces[face], side.x, side.y, n));
    }
    let jet = evaluate(faces[face].stencil, ((y << faces[face].shift) * faces[face].row) + (x << faces[face].shift));
    return Seen(to_eye(jet.p), normal(jet));
}

fn kept(x: u32, y: u32) -> Seen {
    let k = 6u * (y * KEPT_SIDE + x);
    return Seen(vec3<f32>(samples[k], samples[k + 1u], samples[k + 2u]), vec3<f32>(samples[k + 3u], samples[k + 4u], samples[k + 5u]));
}

// A sample of the grid of `level`, kept or not.
fn at_level(face: u32, x: u32, y: u32, level: u32) -> Seen {
    if level <= KEPT {
        return kept(x << (KEPT - level), y << (KEPT - level));
    }
    return sampled(face, x, y);
}

// What step `k` adds to cell (x, y): at the middles of its sides and of its diagonal.
fn measured(face: u32, k: u32, x: u32, y: u32) -> Added {
    let up = KEPT - k;
    let a = kept(x << up, y << up);
    let b = kept((x + 1u) << up, y << up);
    let c = kept((x + 1u) << up, (y + 1u) << up);
    let d = kept(x << up, (y + 1u) << up);
    let l = k + 1u;
    var out = surplus(at_level(face, 2u * x + 1u, 2u * y, l), a, b);
    out = most_added(out, surplus(at_level(face, 2u * x + 1u, 2u * y + 2u, l), d, c));
    out = most_added(out, surplus(at_level(face, 2u * x, 2u * y + 1u, l), a, d));
    out = most_added(out, surplus(at_level(face, 2u * x + 2u, 2u * y + 1u, l), b, c));
    return most_added(out, surplus(at_level(face, 2u * x + 1u, 2u * y + 1u, l), a, c));
}

// Samples of a level, but those of level `have`, which may be none.
fn fill(face: u32, level: u32, have: u32, lane: u32) {
    let side = (1u << level) + 1u;
    for (var k = lane; k < side * side; k += GROUP) {
        let x = k % side;
        let y = k / side;
        let mask = (1u << (level - min(have, level))) - 1u;
        if have != NONE && ((x | y) & mask) == 0u {
            continue;
        }
        let s = sampled(face, x << (KEPT + 1u - level), y << (KEPT + 1u - level));
        let at = 6u * ((y << (KEPT - level)) * KEPT_SIDE + (x << (KEPT - level)));
        samples[at] = s.p.x;
        samples[at + 1u] = s.p.y;
        samples[at + 2u] = s.p.z;
        samples[at + 3u] = s.n.x;
        samples[at + 4u] = s.n.y;
        samples[at + 5u] = s.n.z;
    }
}

// Steps from `from_step` to below `level`; of the last one, what lies in a square.
fn step_cells(face: u32, from_step: u32, level: u32, depth: u32, place: vec2<u32>, lane: u32) {
    for (var k = from_step; k < level; k++) {
        let whole = k < KEPT;
        let side = select(k - depth, k, whole);
        let first = select(place << vec2<u32>(k - min(depth, k)), vec2<u32>(0u), whole);
        for (var c = lane; c < (1u << (2u * side)); c += GROUP) {
            let x = first.x + (c & ((1u << side) - 1u));
            let y = first.y + (c >> side);
            let found = measured(face, k, x, y);
            let at = first_cell(k) + (y << k) + x;
            far[at] = found.far;
            bend[at] = found.bend;
            lengths[at] = found.length;
        }
    }
}

fn cell(k: u32, x: u32, y: u32) -> Added {
    let at = first_cell(k) + (y << k) + x;
    return Added(far[at], bend[at], lengths[at]);
}

// Whether a cell of `2^k` by `2^k` is at one of some corners, bit by bit.
fn is_at(corners: u32, k: u32, x: u32, y: u32) -> bool {
    let last = (1u << k) - 1u;
    let here = u32(x == 0u && y == 0u) | (u32(x == last && y == 0u) << 1u) | (u32(x == last && y == last) << 2u) | (u32(x == 0u && y == last) << 3u);
    return (here & corners) != 0u;
}

// The square of a number: its depth, place, which of its corners are the face's, and which of those are irregular.
struct Square {
    depth: u32,
    place: vec2<u32>,
    corners: u32,
    irregular: u32,
}

fn square_of(number: u32, at: u32, irregular: u32) -> Square {
    if number == 0u {
        return Square(0u, vec2<u32>(0u), 15u, irregular);
    }
    let last = (1u << number) - 1u;
    let place = vec2<u32>(select(0u, last, at == 1u || at == 2u), select(0u, last, at >= 2u));
    return Square(number, place, 1u << at, irregular & (1u << at));
}

// Cell (x, y) of step `k` of a square.
fn in_square(s: Square, k: u32, x: u32, y: u32) -> Added {
    return cell(s.depth + k, (s.place.x << k) + x, (s.place.y << k) + y);
}

// Whether cell (x, y) of the `2^k` by `2^k` of a square of `2^log` samples is too far from the surface.
fn is_cell_far(s: Square, log: u32, k: u32, x: u32, y: u32) -> bool {
    let own = in_square(s, k, x, y);
    let irregular = is_at(s.irregular, k, x, y);
    if k + 1u == log {
        return select(1.0, 2.0, irregular) * of_length(own, own.length) > 1.0;
    }
    var next = in_square(s, k + 1u, 2u * x, 2u * y);
    next = most_added(next, in_square(s, k + 1u, 2u * x + 1u, 2u * y));
    next = most_added(next, in_square(s, k + 1u, 2u * x + 1u, 2u * y + 1u));
    next = most_added(next, in_square(s, k + 1u, 2u * x, 2u * y + 1u));
    return is_far(own, next, select(1.0, UNEVEN, irregular));
}

// What the step after the last may add to the quarters of a cell of that.
fn beyond(s: Square, k: u32, x: u32, y: u32) -> f32 {
    let last = (1u << k) - 1u;
    var added = Added(0.0, 0.0, 0.0);
    for (var j = max(y, 1u) - 1u; j <= min(y + 1u, last); j++) {
        for (var i = max(x, 1u) - 1u; i <= min(x + 1u, last); i++) {
            added = most_added(added, in_square(s, k, i, j));
        }
    }
    return of_length(added, 0.5 * in_square(s, k, x, y).length);
}

// Finds what the cells of a square of `2^log` samples need at one depth, from those below.
fn solve(number: u32, s: Square, log: u32, depth: u32, lane: u32) {
    let cap = max(metric.max_level, s.depth) - s.depth;
    for (var c = lane; c < (1u << (2u * depth)); c += GROUP) {
        let x = c & ((1u << depth) - 1u);
        let y = c >> depth;
        var need = depth;
        if depth < cap && is_cell_far(s, log, depth, x, y) {
            need = depth + 1u;
            for (var k = 0u; k < 4u; k++) {
                let cx = 2u * x + (k & 1u);
                let cy = 2u * y + (k >> 1u);
                if depth + 1u < log {
                    need = max(need, needs[first_need(number) + first_cell(depth + 1u) + (cy << (depth + 1u)) + cx]);
                } else if depth + 1u < cap {
                    let left = select(LEFT, 1.0, is_at(s.corners, depth + 1u, cx, cy));
                    if beyond(s, depth, x, y) * left > 1.0 {
                        need = DEEPER;
                    }
                }
            }
        }
        needs[first_need(number) + first_cell(depth) + c] = need;
    }
}

// Number of the corner that a quarter lies at, and the quarter at a corner.
fn corner_of(quarter: u32) -> u32 {
    return select(quarter, 5u - quarter, quarter >= 2u);
}

// The most that quarters need other than those at some corners.
fn beside(number: u32, corners: u32) -> u32 {
    var most = 0u;
    for (var k = 0u; k < 4u; k++) {
        if (corners & (1u << corner_of(k))) == 0u {
            most = max(most, needs[first_need(number) + 1u + k]);
        }
    }
    return most;
}

// Puts what was found of the square `number` in the place of the quarter of the one around it.
fn insert(number: u32, at: u32) {
    let x = u32(at == 1u || at == 2u);
    let y = u32(at >= 2u);
    for (var depth = 0u; depth < TREE_DEPTH; depth++) {
        for (var k = 0u; k < (1u << (2u * depth)); k++) {
            let i = k & ((1u << depth) - 1u);
            let j = k >> depth;
            let need = needs[first_need(number) + first_cell(depth) + k];
            let to = first_need(number - 1u) + first_cell(depth + 1u) + (((y << depth) + j) << (depth + 1u)) + (x << depth) + i;
            needs[to] = select(need + 1u, DEEPER, need == DEEPER);
        }
    }
    needs[first_need(number - 1u)] = beside(number - 1u, 0u);
}

// How many samples a square asks for, if every step leaves a quarter of the one before.
fn promising(s: Square, log: u32) -> u32 {
    let k = log - 1u;
    var left = 0.0;
    for (var c = 0u; c < (1u << (2u * k)); c++) {
        let a = in_square(s, k, c & ((1u << k) - 1u), c >> k);
        left = max(left, of_length(a, a.length));
    }
    var more = log;
    while left > 1.0 && more < BLOCK_BITS {
        left *= 0.25;
        more++;
    }
    return more;
}

// Where a square is measured, says what is next: more samples of it, one of its quarters, or the square around it.
fn advance(irregular: u32) {
    let number = square;
    let s = square_of(number, corner, irregular);
    let log = logs[number];
    let need = needs[first_need(number)];
    let next = u32(log < TRUSTED);
    let is_uneven = s.irregular != 0u;
    let is_last = s.depth + log >= BLOCK_BITS;
    if !(need + select(next, UNEVEN_STEPS, is_uneven) <= log || is_last) {
        let parts = is_uneven && log >= TRUSTED && s.depth + 1u + TRUSTED <= BLOCK_BITS;
        if parts && beside(number, s.irregular) + next <= log {
            square = number + 1u;
            logs[number + 1u] = TRUSTED;
            if number == 0u {
                corner = firstTrailingBit(irregular);
            }
            return;
        }
        let wanted = promising(s, log);
        logs[number] = min(max(max(wanted, log + 1u), TRUSTED), BLOCK_BITS - s.depth);
        return;
    }
    // It is measured, and perhaps those around it are.
    for (var k = number; k > 0u; k--) {
        insert(k, corner);
        if k == 1u {
            let rest = irregular & ~((2u << corner) - 1u);
            if rest != 0u {
                corner = firstTrailingBit(rest);
                square = 1u;
                logs[1] = TRUSTED;
                return;
            }
        }
    }
    square = NONE;
}

// Whether what holds the face is in the picture, as src/raster/setup.rs says it of a hull.
fn is_seen(face: u32, has_net: bool) -> bool {
    let s = stencils[faces[face].stencil];
    var low = vec2<f32>(3.4e38);
    var high = vec2<f32>(-3.4e38);
    var visible = false;
    var hidden = false;
    for (var k = 0u; k < select(s.count, 16u, has_net); k++) {
        var p: vec3<f32>;
        if has_net {
            p = net[k];
        } else {
            p = control_point(gathers[s.gather + k]);
        }
        let x = (metric.x.x * p.x + metric.x.y * p.y) + (metric.x.z * p.z + metric.x.w);
        let y = (metric.y.x * p.x + metric.y.y * p.y) + (metric.y.z * p.z + metric.y.w);
        let h = (metric.h.x * p.x + metric.h.y * p.y) + (metric.h.z * p.z + metric.h.w);
        if !(abs(x + y + h) < 3.4e38) {
            return true;
        }
        let w = select(h, 1.0, metric.ortho != 0u);
        if select(h >= metric.plane, h <= 2.0, metric.ortho != 0u) {
            visible = true;
        } else {
            hidden = true;
        }
        if metric.ortho != 0u || h >= metric.plane {
            low = min(low, vec2<f32>(x, y) / w);
            high = max(high, vec2<f32>(x, y) / w);
        }
    }
    // Through the near plane it may be anywhere.
    if !visible || (hidden && metric.ortho == 0u) {
        return visible;
    }
    let slack = SCREEN_MARGIN + (abs(low) + abs(high)) * 1e-5;
    let first = max(floor((low - slack) / 256.0), vec2<f32>(0.0));
    let end = min(ceil((high + slack) / 256.0), vec2<f32>(metric.size.xy));
    return all(first < end);
}

fn control_net(face: u32, k: u32) -> vec3<f32> {
    let s = stencils[faces[face].stencil];
    let origin = control_point(gathers[s.gather]);
    var p = vec3<f32>(0.0);
    for (var j = 1u; j < s.count; j++) {
        p += weights[patches[face].net + 16u * j + k] * (control_point(gathers[s.gather + j]) - origin);
    }
    return p + origin;
}

@compute @workgroup_size(GROUP)
fn needs_of_faces(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let face = own_group(group);
    if face >= arrayLength(&patches) {
        return;
    }
    let patch_of = patches[face];
    let has_net = patch_of.net != NONE;
    if has_net && lane < 16u {
        net[lane] = control_net(face, lane);
    }
    workgroupBarrier();
    if lane == 0u {
        square = NONE;
        filled = NONE;
        if (patch_of.marks & PATCH_DRAWN) == 0u || !is_seen(face, has_net) {
            nodes[face * NODE_WORDS] = 0u;
        } else {
            var log = 2u;
            if has_net {
                log = first_log();
            }
            if log == FLAT_FACE {
                nodes[face * NODE_WORDS] = 1u;
                nodes[face * NODE_WORDS + 1u] = node_of(0u, 0u, 0u, 0u);
            } else {
                square = 0u;
                logs[0] = log;
            }
        }
        job = vec4<u32>(square, logs[0], 0u, filled);
    }
    let irregular = patch_of.marks & 15u;
    var work = workgroupUniformLoad(&job);
    let sampling = work.x != NONE;
    while work.x != NONE {
        let s = square_of(work.x, work.z, irregular);
        let level = s.depth + work.y;
        let have = work.w;
        let keep = min(level, KEPT);
        if have == NONE || have < keep {
            fill(face, keep, have, lane);
        }
        workgroupBarrier();
        let from_step = select(min(have, KEPT), 0u, have == NONE);
        step_cells(face, from_step, level, s.depth, s.place, lane);
        for (var below = 1u; below <= work.y; below++) {
            workgroupBarrier();
            solve(work.x, s, work.y, work.y - below, lane);
        }
        workgroupBarrier();
        if lane == 0u {
            filled = keep;
            if have != NONE {
                filled = max(keep, have);
            }
            advance(irregular);
            job = vec4<u32>(square, logs[min(square, NESTED - 1u)], corner, filled);
        }
        work = workgroupUniformLoad(&job);
    }
    if lane == 0u && sampling {
        find_costs();
        cut(face);
    }
}
