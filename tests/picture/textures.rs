//! Textures: files, levels and filtering.

use super::{Random, close, texture};
use earmark::film::srgb::{Srgb, to_linear};
use earmark::texture::{LoadError, MAX_BYTES, Meaning, Texture};

#[test]
fn a_constant_texture_is_constant() {
    let t = texture(37, 5, |_, _| [200, 100, 50, 128]);
    let exact = [200, 100, 50].map(|c| Srgb::tables().decode(c));
    let mut random = Random(5);
    for _ in 0..2000 {
        let lod = random.within(-1.0, 9.0) as f32;
        let s = t.sample(
            random.within(-3.0, 3.0) as f32,
            random.within(-3.0, 3.0) as f32,
            lod,
        );
        assert_eq!([s[0], s[1], s[2]], exact, "lod {lod}");
        assert_eq!(s[3], 128.0 / 255.0);
    }
}

#[test]
fn the_smallest_level_is_the_mean_light() {
    let mut random = Random(11);
    for (w, h) in [(16, 16), (7, 13), (100, 3), (1, 31), (63, 65)] {
        let texels: Vec<[u8; 4]> = (0..w * h)
            .map(|_| [0; 4].map(|_| (random.next() * 256.0) as u8))
            .collect();
        let t = texture(w, h, |x, y| texels[(y * w + x) as usize]);
        let last = t.texel(t.level_count() - 1, 0, 0);
        for (k, &got) in last.iter().enumerate().take(3) {
            let mean = texels
                .iter()
                .map(|t| to_linear(f64::from(t[k]) / 255.0))
                .sum::<f64>()
                / texels.len() as f64;
            // One rounding to 8 bits: half a code.
            let code = earmark::film::srgb::from_linear(mean) * 255.0;
            let got = earmark::film::srgb::from_linear(f64::from(got)) * 255.0;
            assert!((code - got).abs() < 0.55, "{w}x{h}: {code} {got}");
        }
    }
}

#[test]
fn a_far_checkerboard_is_half_the_light() {
    let t = texture(64, 64, |x, y| {
        let c = if (x + y) % 2 == 0 { 255 } else { 0 };
        [c, c, c, 255]
    });
    let lod = t.lod(0.25);
    assert!(close(lod, 4.0, 0.01));
    for i in 0..50 {
        let s = t.sample(i as f32 * 0.037, i as f32 * 0.011, lod);
        // Code 188 is the nearest to half the light; 128 would be a fifth.
        assert!(close(s[0], 0.5, 0.005), "{}", s[0]);
    }
}

#[test]
fn textures_repeat_and_stand_upright() {
    // Top left red, top right green, bottom left blue, bottom right white.
    let t = texture(2, 2, |x, y| match (x, y) {
        (0, 0) => [255, 0, 0, 255],
        (1, 0) => [0, 255, 0, 255],
        (0, 1) => [0, 0, 255, 255],
        _ => [255, 255, 255, 255],
    });
    let at = |u, v| t.sample(u, v, 0.0);
    assert_eq!(at(0.25, 0.75), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(at(0.75, 0.75), [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(at(0.25, 0.25), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(at(0.75, 0.25), [1.0, 1.0, 1.0, 1.0]);
    for (u, v) in [(0.25, 0.75), (0.6, 0.1), (0.0, 0.0), (0.99, 0.5)] {
        for (du, dv) in [(1.0, 0.0), (-2.0, 3.0), (8.0, -8.0)] {
            let (a, b) = (at(u, v), at(u + du, v + dv));
            assert!(a.iter().zip(b).all(|(a, b)| close(*a, b, 1e-5)));
        }
    }
    // The border blends with the opposite side.
    assert!(close(at(0.0, 0.75)[1], 0.5, 1e-6));
    for bad in [f32::NAN, f32::INFINITY, -1e30] {
        assert!(t.sample(bad, bad, bad).iter().all(|c| c.is_finite()));
    }
}

/// A PNG file of one colour, by colour type.
fn png_of(color: image::ExtendedColorType, pixel: &[u8]) -> Vec<u8> {
    use image::ImageEncoder;
    let mut out = Vec::new();
    image::codecs::png::PngEncoder::new(&mut out)
        .write_image(&pixel.repeat(6), 3, 2, color)
        .expect("encodes");
    out
}

#[test]
fn every_colour_type_decodes() {
    use image::ExtendedColorType as C;
    let word = |v: u16| v.to_ne_bytes();
    let words = |v: &[u16]| v.iter().flat_map(|&v| word(v)).collect::<Vec<u8>>();
    let l = |c: u8| Srgb::tables().decode(c);
    let (a, b, c) = (l(100), l(150), l(200));
    let half = 128.0 / 255.0;
    for (file, expected, alpha) in [
        (png_of(C::L8, &[100]), [a, a, a, 1.0], false),
        (png_of(C::La8, &[100, 128]), [a, a, a, half], true),
        (png_of(C::Rgb8, &[100, 150, 200]), [a, b, c, 1.0], false),
        (
            png_of(C::Rgba8, &[100, 150, 200, 128]),
            [a, b, c, half],
            true,
        ),
        (png_of(C::L16, &words(&[100 * 257])), [a, a, a, 1.0], false),
        (
            png_of(C::La16, &words(&[100 * 257, 128 * 257])),
            [a, a, a, half],
            true,
        ),
        (
            png_of(C::Rgb16, &words(&[100 * 257, 150 * 257, 200 * 257])),
            [a, b, c, 1.0],
            false,
        ),
        (
            png_of(
                C::Rgba16,
                &words(&[100 * 257, 150 * 257, 200 * 257, 128 * 257]),
            ),
            [a, b, c, half],
            true,
        ),
    ] {
        let mut budget = 10_000;
        let t = Texture::decode(&file, Meaning::Color, &mut budget).expect("decodes");
        assert_eq!(t.size(), [3, 2]);
        assert_eq!(t.has_alpha(), alpha);
        assert_eq!(10_000 - budget, t.bytes() as u64);
        let s = t.sample(0.4, 0.6, 0.0);
        for (s, e) in s.iter().zip(expected) {
            assert!(close(*s, e, 1e-5), "{s} for {e}");
        }
    }
    let data = Texture::decode(&png_of(C::L8, &[100]), Meaning::Data, &mut 1000).expect("decodes");
    assert!(close(data.opacity(0.5, 0.5, 0.0), 100.0 / 255.0, 1e-6));
    let masked =
        Texture::decode(&png_of(C::La8, &[9, 128]), Meaning::Data, &mut 1000).expect("decodes");
    assert!(close(masked.opacity(0.5, 0.5, 0.0), half, 1e-6));
}

#[test]
fn jpeg_decodes_and_limits_hold() {
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg)
        .encode(&[128; 48], 4, 4, image::ExtendedColorType::Rgb8)
        .expect("encodes");
    let ask = |bytes: &[u8], mut budget: u64| {
        Texture::decode(bytes, Meaning::Color, &mut budget).map(|t| t.size())
    };
    assert_eq!(ask(&jpeg, 1 << 20), Ok([4, 4]));
    // 16 + 4 + 1 texels of 4 bytes.
    assert_eq!(ask(&jpeg, 84), Ok([4, 4]));
    assert!(matches!(
        ask(&jpeg, 83),
        Err(LoadError::Budget {
            wanted: 84,
            allowed: 83,
            ..
        })
    ));
    assert_eq!(ask(b"GIF89a", 1 << 20), Err(LoadError::Unsupported));
    assert_eq!(ask(b"", 1 << 20), Err(LoadError::Unsupported));
    // A header that promises 60000x60000 pixels is refused although the file has no data for them.
    let mut bomb = png_of(image::ExtendedColorType::Rgb8, &[1, 2, 3]);
    bomb[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
    bomb[20..24].copy_from_slice(&60_000_u32.to_be_bytes());
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    assert!(matches!(
        ask(&bomb, u64::MAX),
        Err(LoadError::Budget {
            width: 60_000,
            allowed: MAX_BYTES,
            ..
        })
    ));
    // Cut and damaged files are errors or pictures, never a panic.
    let file = png_of(image::ExtendedColorType::Rgba8, &[1, 2, 3, 4]);
    for file in [&file, &jpeg] {
        for n in 0..file.len() {
            let _ = ask(&file[..n], 1 << 20);
            let mut damaged = file.clone();
            damaged[n] ^= 0x55;
            let _ = ask(&damaged, 1 << 20);
        }
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| {
            (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg())
        })
    })
}
