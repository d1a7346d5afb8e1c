// Numbers into bytes (src/film/srgb.rs).

// A number from 0 to 1.
fn quantized(x: f32) -> u32 {
    return u32(clamp(x, 0.0, 1.0) * 255.0 + 0.5);
}

// Linear light as sRGB.
fn encoded(linear: f32) -> u32 {
    let x = clamp(linear, 0.0, 1.0);
    let low = x * 12.92;
    let high = 1.055 * pow(max(x, 1e-6), 1.0 / 2.4) - 0.055;
    return quantized(select(high, low, x <= 0.0031308));
}
