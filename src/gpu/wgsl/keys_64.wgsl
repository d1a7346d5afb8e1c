// Visibility keys by one maximum: depth above the complement of the id.

@group(0) @binding(4) var<storage, read_write> keys: array<atomic<u64>>;

fn put_key(at: u32, depth: f32, id: u32, phase: u32) {
    atomicMax(&keys[at], (u64(bitcast<u32>(depth)) << 32u) | u64(~id));
}
