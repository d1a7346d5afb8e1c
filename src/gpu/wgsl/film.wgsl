// Colours into bytes: the mean of the samples over the background, encoded (src/film).

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> sums: array<vec4<f32>>;
// The band of rows, a word per pixel.
@group(0) @binding(2) var<storage, read_write> image: array<u32>;

fn encode(linear: f32) -> u32 {
    if frame.srgb == 0u {
        return quantized(linear);
    }
    return encoded(linear);
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let pixel = own_index(group, lane);
    let rows = frame.band_end - frame.band_start;
    if pixel >= frame.width * rows {
        return;
    }
    let seen = sums[pixel] * (1.0 / f32(frame.samples));
    let over = seen + frame.background * max(1.0 - seen.w, 0.0);
    var bytes = 0u;
    if over.w > 0.0 {
        let k = select(1.0 / over.w, 1.0, over.w >= 1.0);
        let rgb = over.xyz * k;
        let alpha = quantized(over.w);
        bytes = encode(rgb.x) | (encode(rgb.y) << 8u) | (encode(rgb.z) << 16u) | (alpha << 24u);
    }
    image[pixel] = bytes;
}
