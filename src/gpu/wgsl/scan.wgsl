// Prefix sums over the faces of a chunk: blocks, their points, moved points and micro-quads at once. Sums of parts first, then the sums before
// each part, which also say whether all has room, then those before each face.

@group(0) @binding(10) var<storage, read_write> totals: array<u32>;
@group(0) @binding(13) var<storage, read> counts: array<vec4<u32>>;
@group(0) @binding(14) var<storage, read_write> offsets: array<vec4<u32>>;
@group(0) @binding(17) var<uniform> room: Room;
@group(0) @binding(18) var<storage, read_write> parts: array<vec4<u32>>;
// Workgroups of what is dispatched by them.
@group(0) @binding(19) var<storage, read_write> dispatched: array<u32>;

// Faces of an invocation.
const OWN = PART / GROUP;

var<workgroup> sums: array<vec4<u32>, GROUP>;

fn own_sum(first: u32) -> vec4<u32> {
    var sum = vec4<u32>(0u);
    for (var k = first; k < min(first + OWN, room.faces); k++) {
        sum += counts[k];
    }
    return sum;
}

// Makes of `sums` those of all lanes up to each.
fn add_up(lane: u32) {
    for (var step = 1u; step < GROUP; step *= 2u) {
        workgroupBarrier();
        var before = vec4<u32>(0u);
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += before;
    }
    workgroupBarrier();
}

@compute @workgroup_size(GROUP)
fn sum_parts(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    sums[lane] = own_sum(own_index(group, lane) * OWN);
    add_up(lane);
    if lane == 0u && own_group(group) < room.parts {
        parts[own_group(group)] = sums[GROUP - 1u];
    }
}

@compute @workgroup_size(GROUP)
fn scan_parts(@builtin(local_invocation_index) lane: u32) {
    // An even share of the parts for each invocation.
    let share = (room.parts + GROUP - 1u) / GROUP;
    var sum = vec4<u32>(0u);
    for (var k = lane * share; k < min((lane + 1u) * share, room.parts); k++) {
        sum += parts[k];
    }
    sums[lane] = sum;
    add_up(lane);
    var next = sums[lane] - sum;
    for (var k = lane * share; k < min((lane + 1u) * share, room.parts); k++) {
        let own = parts[k];
        parts[k] = next;
        next += own;
    }
    if lane == 0u {
        let all_of = sums[GROUP - 1u];
        let fits = all(all_of <= vec4<u32>(room.blocks, room.points, room.moves, room.quads));
        let drawn = select(0u, all_of.x, fits);
        totals[TOTAL_DRAWN] = drawn;
        totals[TOTAL_BLOCKS] = all_of.x;
        totals[TOTAL_POINTS] = all_of.y;
        totals[TOTAL_MOVES] = all_of.z;
        totals[TOTAL_QUADS] = all_of.w;
        dispatched[0] = min(drawn, ACROSS);
        dispatched[1] = (drawn + ACROSS - 1u) / ACROSS;
        dispatched[2] = 1u;
    }
}

@compute @workgroup_size(GROUP)
fn scan_faces(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let first = own_index(group, lane) * OWN;
    let own = own_sum(first);
    sums[lane] = own;
    add_up(lane);
    var next = sums[lane] - own;
    if own_group(group) < room.parts {
        next += parts[own_group(group)];
    }
    for (var k = first; k < min(first + OWN, room.faces); k++) {
        offsets[k] = next;
        next += counts[k];
    }
}
