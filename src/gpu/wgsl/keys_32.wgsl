// Visibility keys in two passes: depths, then the lowest id among those of that depth. The same words in memory as with one maximum of 64
// bits. Both passes are one pipeline, so a depth has the same bits in both.

@group(0) @binding(4) var<storage, read_write> keys: array<atomic<u32>>;

fn put_key(at: u32, depth: f32, id: u32, phase: u32) {
    let bits = bitcast<u32>(depth);
    if phase == 0u {
        atomicMax(&keys[2u * at + 1u], bits);
    } else if atomicLoad(&keys[2u * at + 1u]) == bits {
        atomicMax(&keys[2u * at], ~id);
    }
}
