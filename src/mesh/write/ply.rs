//! A level as PLY, text or bytes.

use super::super::color::byte;
use super::{PlyFormat, WriteOptions, colors, in_runs, polygons, push, push_point, uv_values};
use crate::refine::{Level, Limit};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes `level` as PLY: points, normals if there are limit points, colours, polygons, and texture coordinates as a
/// list per face.
///
/// PLY has one normal per vertex; where sectors have several the vertex is written several times. Materials and tags have no place in it.
///
/// # Errors
/// Those of `out`, and [`io::ErrorKind::InvalidInput`] for a face of more corners than a list can count, unless it is triangulated.
pub fn ply(
    out: &mut impl Write,
    level: &Level<f32>,
    options: &WriteOptions<'_>,
    format: PlyFormat,
) -> io::Result<()> {
    let t = &level.topology;
    let faces = polygons(level, options);
    let (mut face_count, mut longest) = (0, 0);
    for f in 0..t.face_count() as u32 {
        let n = if t.is_hole(f) && !options.holes {
            0
        } else {
            t.face_halves(f).len()
        };
        longest = longest.max(n);
        face_count += match n {
            0 => 0,
            n if options.triangulate => n - 2,
            _ => 1,
        };
    }
    // A list counts to 255; texture coordinates have two numbers per corner.
    let most = if level.uvs.is_some() { 127 } else { 255 };
    if longest > most && !options.triangulate {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("a face of {longest} corners does not fit PLY's lists; triangulate"),
        ));
    }
    // Vertices in the order of normals, if there are any: those of vertices come first there, then those of further sectors.
    let copies = options.limit.map(|l| normal_vertices(level, l));
    let count = copies.as_ref().map_or(level.points.len(), Vec::len);
    let uvs = level.uvs.as_ref();
    let uv_values = uvs.map_or(&[][..], |uvs| uv_values(uvs, options));
    let colors = colors(level, options);

    let mut head = String::from("ply\n");
    let layout = match format {
        PlyFormat::Ascii => "ascii",
        PlyFormat::Binary => "binary_little_endian",
    };
    let scalar = if options.origin == [0.0; 3] {
        "float"
    } else {
        "double"
    };
    let _ = writeln!(head, "format {layout} 1.0\nelement vertex {count}");
    for axis in ["x", "y", "z"] {
        let _ = writeln!(head, "property {scalar} {axis}");
    }
    if options.limit.is_some() {
        head.push_str("property float nx\nproperty float ny\nproperty float nz\n");
    }
    if colors.is_some() {
        head.push_str("property uchar red\nproperty uchar green\nproperty uchar blue\n");
    }
    let _ = writeln!(
        head,
        "element face {face_count}\nproperty list uchar uint vertex_indices"
    );
    if uvs.is_some() {
        head.push_str("property list uchar float texcoord\n");
    }
    head.push_str("end_header\n");
    out.write_all(head.as_bytes())?;

    let binary = format == PlyFormat::Binary;
    in_runs(out, count, |i, text| {
        let v = copies.as_ref().map_or(i, |c| c[i] as usize);
        let p = &options.limit.map_or(&level.points, |l| &l.positions)[v];
        let n = options.limit.map(|l| &l.normals[i]);
        if !binary {
            push_point(text, "", p, options.origin);
            if let Some(n) = n {
                push_point(text, " ", n, [0.0; 3]);
            }
            for c in colors.into_iter().flat_map(|c| c.value(v)) {
                push(text, format_args!(" {}", byte(c)));
            }
            text.push(b'\n');
            return;
        }
        for (c, o) in p.iter().zip(options.origin) {
            if options.origin == [0.0; 3] {
                text.extend(c.to_le_bytes());
            } else {
                text.extend((f64::from(*c) + o).to_le_bytes());
            }
        }
        for c in n.into_iter().flatten() {
            text.extend(c.to_le_bytes());
        }
        text.extend(colors.into_iter().flat_map(|c| c.value(v)).map(byte));
    })?;
    in_runs(out, t.face_count(), |i, text| {
        let index = |h: u32| options.limit.map_or(t.vertex(h), |l| l.normal_index(t, h));
        let complete = uvs.filter(|uv| uv.is_complete(level.base_face(i as u32)));
        for polygon in faces(i as u32) {
            let values = complete.map_or(&[][..], |_| &polygon[..]);
            let values = values.iter().flat_map(|&h| {
                uvs.map_or([0.0; 2], |uv| uv_values[uv.corners[h as usize] as usize])
            });
            let value_count = if complete.is_some() {
                2 * polygon.len()
            } else {
                0
            };
            if binary {
                text.push(polygon.len() as u8);
                polygon
                    .iter()
                    .for_each(|&h| text.extend(index(h).to_le_bytes()));
                if uvs.is_some() {
                    text.push(value_count as u8);
                    values.for_each(|c| text.extend(c.to_le_bytes()));
                }
            } else {
                push(text, format_args!("{}", polygon.len()));
                polygon
                    .iter()
                    .for_each(|&h| push(text, format_args!(" {}", index(h))));
                if uvs.is_some() {
                    push(text, format_args!(" {value_count}"));
                    values.for_each(|c| push(text, format_args!(" {c}")));
                }
                text.push(b'\n');
            }
        }
    })
}

/// The vertex of every normal.
fn normal_vertices(level: &Level<f32>, limit: &Limit<f32>) -> Vec<u32> {
    let t = &level.topology;
    let mut out: Vec<u32> = (0..limit.normals.len() as u32).collect();
    for h in 0..t.half_count() as u32 {
        out[limit.normal_index(t, h) as usize] = t.vertex(h);
    }
    out
}
