//! What a file looks like that is not OBJ text, so that the message can say it.

/// Magic numbers that no OBJ text starts with.
const MAGIC: &[(&[u8], &str)] = &[
    (b"\x1f\x8b", "a gzip archive; unpack it first"),
    (b"PK\x03\x04", "a zip archive (or USDZ); unpack it first"),
    (b"PK\x05\x06", "an empty zip archive"),
    (b"\xfd7zXZ\0", "an xz archive; unpack it first"),
    (b"\x28\xb5\x2f\xfd", "a zstd archive; unpack it first"),
    (b"BZh", "a bzip2 archive; unpack it first"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive; unpack it first"),
    (b"\xff\xfe\0\0", "UTF-32 text; save it as UTF-8"),
    (b"\0\0\xfe\xff", "UTF-32 text; save it as UTF-8"),
    (b"\xff\xfe", "UTF-16 text; save it as UTF-8"),
    (b"\xfe\xff", "UTF-16 text; save it as UTF-8"),
    (b"glTF", "a binary glTF file"),
    (b"Kaydara FBX Binary", "an FBX file"),
    (b"; FBX", "an FBX file"),
    (b"BLENDER", "a Blender file; export it as OBJ"),
    (b"PXR-USDC", "a USD file"),
    (b"#usda", "a USD file"),
    (b"Ogawa", "an Alembic file"),
    (b"\x89HDF", "an HDF5 file"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"RIFF", "a RIFF file"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"xof 0", "a DirectX file"),
    (
        b"version https://git-lfs",
        "a Git LFS pointer; fetch the file itself",
    ),
    (b"[Binary]", "a binary OBJ file"),
];

/// What the bytes look like, when they cannot be OBJ text; decided from their first bytes alone.
pub(super) fn foreign(bytes: &[u8]) -> Option<&'static str> {
    for (magic, what) in MAGIC {
        if bytes.starts_with(magic) {
            return Some(what);
        }
    }
    if bytes.len() >= 84 {
        let count = u32::from_le_bytes([bytes[80], bytes[81], bytes[82], bytes[83]]);
        if bytes.len() as u64 == 84 + 50 * u64::from(count) && bytes[..84].contains(&0) {
            return Some("a binary STL file");
        }
    }
    let head = &bytes[..bytes.len().min(1024)];
    let text = head.trim_ascii_start();
    let first_word = text
        .split(|b| b.is_ascii_whitespace())
        .next()
        .unwrap_or_default();
    match first_word {
        b"ply" => return Some("a PLY file"),
        b"solid" => return Some("an STL file"),
        b"OFF" | b"COFF" | b"NOFF" => return Some("an OFF file"),
        b"#VRML" => return Some("a VRML file"),
        _ => {}
    }
    if text.starts_with(b"<") {
        let lower = text.to_ascii_lowercase();
        let has = |word: &[u8]| lower.windows(word.len()).any(|w| w == word);
        return Some(if has(b"<html") || has(b"<!doctype html") {
            "a web page"
        } else if has(b"<collada") {
            "a COLLADA file"
        } else {
            "an XML file"
        });
    }
    if text.starts_with(b"{") {
        return Some("a JSON file (glTF?)");
    }
    // ASCII as UTF-16 without a mark: every other byte of the head is zero.
    let zeros = |odd: usize| {
        head.iter()
            .skip(odd)
            .step_by(2)
            .filter(|&&b| b == 0)
            .count()
    };
    if head.len() >= 16 && (zeros(0) * 8 >= head.len() * 3) != (zeros(1) * 8 >= head.len() * 3) {
        return Some("UTF-16 text; save it as UTF-8");
    }
    None
}

/// Whether the head of the file holds bytes that text does not: asked only when nothing could be made of it.
pub(super) fn binary(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(8192)];
    let odd = head
        .iter()
        .filter(|&&b| b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0x1a | 0x1b))
        .count();
    odd * 50 > head.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_it_sees() {
        let utf16: Vec<u8> = "v 0 0 0\nv 1 0 0\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        for (bytes, word) in [
            (&b"ply\nformat ascii 1.0\n"[..], "PLY"),
            (b"  <!DOCTYPE html><html>", "web page"),
            (b"<?xml version='1.0'?><COLLADA>", "COLLADA"),
            (b"{\"asset\":{}}", "glTF"),
            (b"solid x\nfacet", "STL"),
            (&utf16, "UTF-16"),
        ] {
            assert!(foreign(bytes).is_some_and(|w| w.contains(word)), "{word}");
        }
        let mut stl = vec![0; 84 + 100];
        stl[80] = 2;
        assert_eq!(foreign(&stl), Some("a binary STL file"));
    }

    #[test]
    fn obj_text_is_not_foreign() {
        for text in [
            "v 0 0 0\n",
            "# comment\n",
            "\n\n  v 1 2 3",
            "o solid\n",
            "mtllib a.mtl",
            "",
        ] {
            assert_eq!(foreign(text.as_bytes()), None, "{text}");
            assert!(!binary(text.as_bytes()));
        }
        assert!(binary(&[0; 100]));
    }
}
