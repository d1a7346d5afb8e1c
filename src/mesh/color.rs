//! Colours of files are sRGB, those of cages linear. The curve is that of IEC 61966-2-1.

/// Linear light of an sRGB value.
pub(super) fn linear(c: f64) -> f32 {
    let value = if c <= 0.04045 {
        c / 12.92
    } else {
        libm::pow((c + 0.055) / 1.055, 2.4)
    };
    value as f32
}

/// The sRGB value of linear light, kept between 0 and 1: refinement may leave that range by a little.
pub(super) fn encoded(light: f32) -> f32 {
    let c = f64::from(light).clamp(0.0, 1.0);
    let value = if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * libm::pow(c, 1.0 / 2.4) - 0.055
    };
    value as f32
}

/// [`encoded`] in 8 bits.
pub(super) fn byte(light: f32) -> u8 {
    (encoded(light) * 255.0 + 0.5) as u8
}
