//! The creature's skin: a colour as a function of the place on the rest pose, written into its texture.
//!
//! Since colour depends on the place in space and not on the chart, it agrees on both sides of every seam. Texels outside all
//! charts continue the nearest chart for some texels, so that filtering never reaches the background.

use super::creature::{Creature, EYE, label, mouth_height, profile, smoothstep};
use super::limbs::GILLS;
use super::mesh::{V3, add, cross, dot, length, mix, scale, sub, unit};
use super::refine::Net;
use std::collections::{BTreeMap, BTreeSet};

/// Side of the texture.
const SIZE: usize = 1024;

/// A number in 0 to 1 that looks random, from integers.
fn hash(x: i32, y: i32, z: i32, salt: u32) -> f64 {
    let mut h = salt.wrapping_mul(0x9e37_79b9);
    for v in [x, y, z] {
        h ^= v as u32;
        h = h.wrapping_mul(0x85eb_ca6b);
        h ^= h >> 15;
        h = h.wrapping_mul(0xc2b2_ae35);
        h ^= h >> 13;
    }
    f64::from(h >> 8) / f64::from(1_u32 << 24)
}

/// How deep `p` lies in a field of round spots, 0 outside and 1 in the middle of one; `cell` is their spacing.
fn spots(p: V3, cell: f64, radius: [f64; 2], share: f64, salt: u32) -> f64 {
    let base = p.map(|x| libm::floor(x / cell) as i32);
    let mut deepest = 0.0_f64;
    for k in 0..27 {
        let [i, j, l] = [
            base[0] + k % 3 - 1,
            base[1] + k / 3 % 3 - 1,
            base[2] + k / 9 - 1,
        ];
        if hash(i, j, l, salt) > share {
            continue;
        }
        let jitter = |axis: u32| 0.2 + 0.6 * hash(i, j, l, salt + 1 + axis);
        let c = [
            (f64::from(i) + jitter(0)) * cell,
            (f64::from(j) + jitter(1)) * cell,
            (f64::from(l) + jitter(2)) * cell,
        ];
        let r = radius[0] + (radius[1] - radius[0]) * hash(i, j, l, salt + 7);
        deepest = deepest.max(1.0 - length(sub(p, c)) / r);
    }
    deepest
}

fn gauss(p: V3, c: V3, r: f64) -> f64 {
    let d = sub([p[0].abs(), p[1], p[2]], c);
    libm::exp(-dot(d, d) / (r * r))
}

fn hex(c: u32) -> V3 {
    [c >> 16 & 255, c >> 8 & 255, c & 255].map(|x| f64::from(x) / 255.0)
}

fn eye(p: V3) -> V3 {
    let axis = unit(EYE[1]);
    let d = unit(sub(
        [p[0].abs(), p[1], p[2]],
        add(EYE[0], scale(axis, 0.005)),
    ));
    let right = unit(cross([0.0, 1.0, 0.0], axis));
    let up = cross(axis, right);
    let (x, y, z) = (dot(d, right), dot(d, up), dot(d, axis));
    let off = libm::acos(z.clamp(-1.0, 1.0));
    let mut c = mix(hex(0x14_0c18), hex(0x35_1c38), smoothstep(-0.2, -0.9, y));
    c = mix(c, hex(0xe0_9a48), smoothstep(1.10, 1.15, off));
    c = mix(c, hex(0x8c_3a4e), smoothstep(1.23, 1.30, off));
    // Two painted lights, on the same side of both eyes.
    let x = if p[0] < 0.0 { -x } else { x };
    let light = |cx: f64, cy: f64, r: f64| {
        let d = ((x - cx) * (x - cx) + (y - cy) * (y - cy)).sqrt();
        if z > 0.0 {
            smoothstep(r + 0.03, r - 0.03, d)
        } else {
            0.0
        }
    };
    c = mix(c, [1.0, 1.0, 1.0], light(0.26, 0.36, 0.24));
    mix(c, hex(0xf4_e4ea), light(-0.26, -0.34, 0.11))
}

fn body(p: V3) -> V3 {
    let [_, top, bottom, fin_above, fin_below] = profile(p[2].clamp(-1.5, 0.72));
    let height = (p[1] - bottom) / (top - bottom);
    let head = smoothstep(0.05, 0.22, p[2]);
    let mut c = mix(
        hex(0xff_ece0),
        hex(0xf7_a8a6),
        smoothstep(0.08, 0.62, height),
    );
    c = mix(
        c,
        hex(0xe9_7f8c),
        0.75 * smoothstep(0.70, 1.1, height) * (1.0 - 0.55 * head),
    );
    // Blotches on back and flanks, freckles everywhere above.
    let flank = smoothstep(0.34, 0.60, height);
    let away = 1.0 - smoothstep(0.04, 0.22, p[2]);
    let s = spots(p, 0.15, [0.040, 0.095], 0.60, 11);
    c = mix(
        c,
        hex(0xd4_5a76),
        0.80 * smoothstep(0.06, 0.30, s) * flank * away,
    );
    c = mix(
        c,
        hex(0xb8_3a62),
        0.80 * smoothstep(0.30, 0.62, s) * flank * away,
    );
    let s = spots(p, 0.070, [0.010, 0.024], 0.55, 5);
    let brow = smoothstep(0.66, 0.86, height) * smoothstep(0.70, 0.52, p[2]);
    let freckled = brow.max(0.7 * flank * away);
    c = mix(
        c,
        hex(0xb8_3f60),
        0.75 * smoothstep(0.15, 0.45, s) * freckled,
    );
    let s = spots(p, 0.085, [0.007, 0.015], 0.40, 31);
    c = mix(
        c,
        hex(0xff_e6c4),
        0.85 * smoothstep(0.15, 0.45, s) * flank * away,
    );
    // Fins: warm, with rays.
    let above = smoothstep(0.25, 1.0, (p[1] - top) / fin_above.max(0.02))
        * smoothstep(0.03, 0.12, fin_above);
    let below = smoothstep(0.25, 1.0, (bottom - p[1]) / fin_below.max(0.02))
        * smoothstep(0.02, 0.08, fin_below);
    let fin = above.max(below);
    let ray = 0.5 + 0.5 * libm::sin(p[2] * 62.0 + p[1] * 16.0);
    c = mix(c, hex(0xe8_4f63), 0.75 * fin);
    c = mix(c, hex(0xff_b59a), 0.55 * fin * smoothstep(0.35, 0.8, ray));
    // Face: blush, nostrils, darker lips.
    c = mix(
        c,
        hex(0xf2_5f74),
        0.62 * gauss(p, [0.465, 0.425, 0.35], 0.12),
    );
    let nostril = ((p[0].abs() - 0.095) / 0.017, (p[1] - 0.515) / 0.012);
    let nostril = (nostril.0 * nostril.0 + nostril.1 * nostril.1).sqrt();
    c = mix(
        c,
        hex(0x96_3450),
        0.9 * smoothstep(1.3, 0.7, nostril) * smoothstep(0.5, 0.6, p[2]),
    );
    let lip = (p[1] - mouth_height(p[2])).abs();
    c = mix(
        c,
        hex(0xd0_6474),
        0.55 * smoothstep(0.030, 0.012, lip) * smoothstep(0.40, 0.46, p[2]),
    );
    // A light ring round the eye.
    let e = length(sub([p[0].abs(), p[1], p[2]], EYE[0]));
    mix(c, hex(0xff_d6c8), 0.6 * smoothstep(0.175, 0.125, e))
}

fn leg(p: V3) -> V3 {
    // Like the flank at the hip, rosy at the foot.
    let thigh = smoothstep(0.24, 0.38, p[0].abs());
    let skin = mix(body(p), hex(0xf6_a3a4), thigh);
    let mut c = mix(hex(0xec_6f80), skin, smoothstep(0.02, 0.17, p[1]));
    let s = spots(p, 0.10, [0.022, 0.048], 0.5, 23);
    let above = smoothstep(0.09, 0.15, p[1]) * thigh;
    c = mix(c, hex(0xc4_4468), 0.8 * smoothstep(0.08, 0.35, s) * above);
    mix(c, hex(0xff_d9cf), smoothstep(0.014, 0.0, p[1]))
}

fn gill(p: V3) -> V3 {
    let q = [p[0].abs(), p[1], p[2]];
    // Along and off the nearest gill.
    let mut best = (f64::MAX, 0.0);
    let steps = 12;
    for g in &GILLS {
        for k in 0..steps {
            let t = |k: u32| f64::from(k) / f64::from(steps);
            let (a, b) = (g.at(t(k)).0, g.at(t(k + 1)).0);
            let d = sub(b, a);
            let s = (dot(sub(q, a), d) / dot(d, d)).clamp(0.0, 1.0);
            let off = length(sub(q, mix(a, b, s)));
            if off < best.0 {
                best = (off, t(k) + s / f64::from(steps));
            }
        }
    }
    let (off, t) = best;
    let out = t + 4.0 * (off - 0.04).max(0.0);
    let red = mix(hex(0xf0_6070), hex(0xc8_2852), smoothstep(0.30, 0.85, out));
    let red = mix(red, hex(0x8c_1446), smoothstep(0.85, 1.35, out));
    mix(body(p), red, smoothstep(0.03, 0.30, t))
}

/// Colour, sRGB 0 to 1, of the place `p` of the rest pose.
fn colour(l: u32, p: V3) -> V3 {
    match l {
        label::EYE => eye(p),
        label::MOUTH => {
            let deep = smoothstep(0.70, 0.60, p[2] + 0.3 * p[0].abs());
            mix(hex(0xa8_3a4e), hex(0x4a_1226), deep)
        }
        label::LEG | label::SOLE | label::FOOT_RIM => leg(p),
        label::GILL_FRONT | label::GILL_BACK | label::GILL_RIM => gill(p),
        _ => body(p),
    }
}

/// The texture coordinates as a net with the corners that `corners-plus1` holds.
fn chart_net(c: &Creature) -> Net<2> {
    let mut net = Net::new(c.mesh.uvs.clone(), c.mesh.face_uvs.clone());
    let mut values: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for (face, uvs) in c.mesh.faces.iter().zip(&c.mesh.face_uvs) {
        for (&v, &t) in face.iter().zip(uvs) {
            values.entry(v).or_default().insert(t);
        }
    }
    for set in values.values().filter(|s| s.len() > 2) {
        for &t in set {
            net.fixed[t] = true;
        }
    }
    net
}

/// The texture as a PNG.
pub(crate) fn skin(c: &Creature) -> Vec<u8> {
    let mut places = Net::new(c.rest.clone(), c.mesh.faces.clone());
    let mut charts = chart_net(c);
    let mut labels = c.mesh.labels.clone();
    for _ in 0..3 {
        places = places.refine();
        charts = charts.refine();
        labels = labels.iter().flat_map(|&l| [l; 4]).collect();
    }
    let mut texels: Vec<Option<V3>> = vec![None; SIZE * SIZE];
    for (f, &l) in labels.iter().enumerate() {
        for split in [[0, 1, 2], [0, 2, 3]] {
            let t = split.map(|k| charts.points[charts.faces[f][k]].map(|x| x * SIZE as f64));
            let p = split.map(|k| places.points[places.faces[f][k]]);
            fill(t, |x, y, w| {
                let at = (0..3).fold([0.0; 3], |s, k| add(s, scale(p[k], w[k])));
                texels[(SIZE - 1 - y) * SIZE + x] = Some(colour(l, at));
            });
        }
    }
    for _ in 0..8 {
        texels = spread(&texels);
    }
    let rest = hex(0xf7_b4ae);
    let bytes: Vec<u8> = texels
        .iter()
        .flat_map(|t| t.unwrap_or(rest))
        .map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
        .collect();
    encode(&bytes)
}

/// Calls `paint` for every texel whose middle lies in the triangle, with its weights.
fn fill(t: [[f64; 2]; 3], mut paint: impl FnMut(usize, usize, [f64; 3])) {
    let side = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let whole = side(t[0], t[1], t[2]);
    if whole.abs() < 1e-12 {
        return;
    }
    let range = |d: usize| {
        let lo = t.iter().map(|p| p[d]).fold(f64::MAX, f64::min);
        let hi = t.iter().map(|p| p[d]).fold(f64::MIN, f64::max);
        (lo.max(0.0) as usize)..((hi.max(0.0) as usize + 1).min(SIZE))
    };
    for y in range(1) {
        for x in range(0) {
            let p = [x as f64 + 0.5, y as f64 + 0.5];
            let w = [
                side(t[1], t[2], p) / whole,
                side(t[2], t[0], p) / whole,
                side(t[0], t[1], p) / whole,
            ];
            if w.iter().all(|&w| w >= -1e-6) {
                paint(x, y, w);
            }
        }
    }
}

/// Every empty texel becomes the mean of its filled neighbours.
fn spread(texels: &[Option<V3>]) -> Vec<Option<V3>> {
    (0..texels.len())
        .map(|i| {
            texels[i].or_else(|| {
                let (x, y) = (i % SIZE, i / SIZE);
                let (mut sum, mut n) = ([0.0; 3], 0.0);
                for v in y.saturating_sub(1)..(y + 2).min(SIZE) {
                    for u in x.saturating_sub(1)..(x + 2).min(SIZE) {
                        if let Some(c) = texels[v * SIZE + u] {
                            sum = add(sum, c);
                            n += 1.0;
                        }
                    }
                }
                (n > 0.0).then(|| scale(sum, 1.0 / n))
            })
        })
        .collect()
}

fn encode(rgb: &[u8]) -> Vec<u8> {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    use image::{ExtendedColorType, ImageEncoder};
    let mut bytes = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    // Writing to memory fails only for a wrong size.
    encoder
        .write_image(rgb, SIZE as u32, SIZE as u32, ExtendedColorType::Rgb8)
        .expect("a picture of SIZE by SIZE texels");
    bytes
}
