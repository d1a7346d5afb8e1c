//! A level of refinement as OBJ or PLY.
//!
//! Text is formatted in parallel runs and written in order, numbers in the shortest form that reads back to the same value. Faces that are
//! holes are left out. Creases and corners that are still sharp are written back as OpenSubdiv's tags, so that a level refines further like
//! its cage; but where faces were left out the new border is one more boundary.

use super::{Material, NONE};
use crate::refine::{FaceVarying, Level, Limit};
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Elements that one task formats.
const RUN: usize = 1 << 12;

/// What to write with a level.
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteOptions<'a> {
    /// Limit points to write in place of the control points, with their normals.
    pub limit: Option<&'a Limit<f32>>,
    /// Added to every point; see [`Cage::origin`](super::Cage::origin).
    pub origin: [f64; 3],
    /// All materials, and per face of the cage an index into them or [`NONE`].
    pub materials: Option<(&'a [Material], &'a [u32])>,
    /// Name of the material library; none, no `mtllib` line.
    pub material_library: Option<&'a str>,
    /// Tags of the whole mesh; none, no tags at all. Limit points never have tags.
    pub tags: Option<MeshTags>,
    /// Split every quad in two along its first diagonal.
    pub triangulate: bool,
}

/// Tags of the whole mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshTags {
    /// Boundary rule.
    pub boundary: Boundary,
    /// Decay of sharpness.
    pub creases: CreaseMethod,
    /// Face-varying rule.
    pub face_varying: FaceVaryingRule,
}

/// Layout of a PLY file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlyFormat {
    /// Text.
    Ascii,
    /// Little-endian bytes.
    #[default]
    Binary,
}

/// Faces as drawn: corners of each, holes left out.
fn polygons<'a>(
    level: &'a Level<f32>,
    triangulate: bool,
) -> impl Fn(u32) -> Vec<Vec<u32>> + Sync + 'a {
    let t = &level.topology;
    move |f| {
        if t.is_hole(f) {
            return Vec::new();
        }
        let halves: Vec<u32> = t.face_halves(f).collect();
        if triangulate {
            (1..halves.len() - 1)
                .map(|i| vec![halves[0], halves[i], halves[i + 1]])
                .collect()
        } else {
            vec![halves]
        }
    }
}

/// Formats `count` items in parallel and writes them in order.
fn in_runs(
    out: &mut impl Write,
    count: usize,
    format: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    // A few runs at a time: the text of a large mesh is never held as a whole.
    let wave = 16 * rayon::current_num_threads().max(1);
    let runs: Vec<usize> = (0..count).step_by(RUN).collect();
    for group in runs.chunks(wave) {
        let texts: Vec<Vec<u8>> = group
            .par_iter()
            .map(|&start| {
                let mut text = Vec::with_capacity(RUN * 32);
                for i in start..(start + RUN).min(count) {
                    format(i, &mut text);
                }
                text
            })
            .collect();
        for text in texts {
            out.write_all(&text)?;
        }
    }
    Ok(())
}

fn push(text: &mut Vec<u8>, what: std::fmt::Arguments<'_>) {
    // Writing to memory cannot fail.
    let _ = text.write_fmt(what);
}

/// A point in the coordinates of the file. Without an offset the shortest decimals of `f32` do.
fn push_point(text: &mut Vec<u8>, key: &str, p: &[f32; 3], origin: [f64; 3]) {
    if origin == [0.0; 3] {
        push(text, format_args!("{key}{} {} {}", p[0], p[1], p[2]));
    } else {
        let at = |k: usize| f64::from(p[k]) + origin[k];
        push(text, format_args!("{key}{} {} {}", at(0), at(1), at(2)));
    }
}

/// Writes `level` as OBJ.
///
/// # Errors
/// Those of `out`.
pub fn obj(out: &mut impl Write, level: &Level<f32>, options: &WriteOptions<'_>) -> io::Result<()> {
    let t = &level.topology;
    if let Some(name) = options.material_library {
        writeln!(out, "mtllib {name}")?;
    }
    let points = options.limit.map_or(&level.points, |l| &l.positions);
    in_runs(out, points.len(), |i, text| {
        push_point(text, "v ", &points[i], options.origin);
        text.push(b'\n');
    })?;
    if let Some(uvs) = &level.uvs {
        in_runs(out, uvs.values.len(), |i, text| {
            let [u, v] = uvs.values[i];
            push(text, format_args!("vt {u} {v}\n"));
        })?;
    }
    if let Some(limit) = options.limit {
        in_runs(out, limit.normals.len(), |i, text| {
            push_point(text, "vn ", &limit.normals[i], [0.0; 3]);
            text.push(b'\n');
        })?;
    }
    let material = |f: u32| {
        let (materials, of_faces) = options.materials?;
        let index = of_faces.get(level.base_face(f) as usize).copied()?;
        Some(
            materials
                .get(index as usize)
                .map_or("", |m| m.name.as_str()),
        )
    };
    let faces = polygons(level, options.triangulate);
    // A run needs to know the material before it, which is that of the last face drawn.
    in_runs(out, t.face_count(), |i, text| {
        let f = i as u32;
        let drawn = faces(f);
        if drawn.is_empty() {
            return;
        }
        let name = material(f);
        let before = (0..f).rev().find(|&g| !t.is_hole(g)).and_then(material);
        if let Some(name) = name.filter(|&n| before.unwrap_or("") != n) {
            push(text, format_args!("usemtl {name}\n"));
        }
        let uvs = level
            .uvs
            .as_ref()
            .filter(|uv| uv.is_complete(level.base_face(f)));
        for polygon in drawn {
            text.push(b'f');
            for h in polygon {
                push_corner(text, level, uvs, options.limit, h);
            }
            text.push(b'\n');
        }
    })?;
    if let Some(tags) = options.tags.filter(|_| options.limit.is_none()) {
        write_tags(out, level, tags)?;
    }
    Ok(())
}

fn push_corner(
    text: &mut Vec<u8>,
    level: &Level<f32>,
    uvs: Option<&FaceVarying<f32>>,
    limit: Option<&Limit<f32>>,
    h: u32,
) {
    let v = level.topology.vertex(h) + 1;
    let uv = uvs.map(|uv| uv.corners[h as usize] + 1);
    let n = limit.map(|l| l.normal_index(&level.topology, h) + 1);
    match (uv, n) {
        (None, None) => push(text, format_args!(" {v}")),
        (Some(uv), None) => push(text, format_args!(" {v}/{uv}")),
        (None, Some(n)) => push(text, format_args!(" {v}//{n}")),
        (Some(uv), Some(n)) => push(text, format_args!(" {v}/{uv}/{n}")),
    }
}

fn write_tags(out: &mut impl Write, level: &Level<f32>, tags: MeshTags) -> io::Result<()> {
    let t = &level.topology;
    let boundary = match tags.boundary {
        Boundary::None => 0,
        Boundary::EdgeAndCorner => 1,
        Boundary::EdgeOnly => 2,
    };
    writeln!(out, "t interpolateboundary 1/0/0 {boundary}")?;
    let rule = match tags.face_varying {
        FaceVaryingRule::None => 0,
        FaceVaryingRule::CornersOnly => 1,
        FaceVaryingRule::CornersPlus1 => 2,
        FaceVaryingRule::CornersPlus2 => 3,
        FaceVaryingRule::Boundaries => 4,
        FaceVaryingRule::All => 5,
    };
    writeln!(out, "t facevaryinginterpolateboundary 1/0/0 {rule}")?;
    if tags.creases == CreaseMethod::Chaikin {
        writeln!(out, "t creasemethod 0/0/1 chaikin")?;
    }
    for e in 0..t.edge_count() as u32 {
        let h = t.edge_half(e);
        let s = t.edge_sharpness(e);
        // Edges without a twin are sharp anyway.
        if s > 0.0 && t.twin(h) != NONE {
            let (a, b) = (t.vertex(h), t.vertex(t.next(h)));
            writeln!(out, "t crease 2/1/0 {a} {b} {s}")?;
        }
    }
    for v in 0..t.vertex_count() as u32 {
        let s = t.vertex_sharpness(v);
        let fan = t.fans()[v as usize];
        let implied = tags.boundary == Boundary::EdgeAndCorner && fan.faces == 1 && !fan.closed;
        if s > 0.0 && !implied {
            writeln!(out, "t corner 1/1/0 {v} {s}")?;
        }
    }
    Ok(())
}

/// Writes `level` as PLY: points, normals if there are limit points, polygons, and texture coordinates as a list per face.
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
    let faces = polygons(level, options.triangulate);
    let (mut face_count, mut longest) = (0, 0);
    for f in 0..t.face_count() as u32 {
        let n = if t.is_hole(f) {
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
    })?;
    in_runs(out, t.face_count(), |i, text| {
        let index = |h: u32| options.limit.map_or(t.vertex(h), |l| l.normal_index(t, h));
        let complete = uvs.filter(|uv| uv.is_complete(level.base_face(i as u32)));
        for polygon in faces(i as u32) {
            let values = complete.map_or(&[][..], |_| &polygon[..]);
            let values = values.iter().flat_map(|&h| {
                uvs.map_or([0.0; 2], |uv| uv.values[uv.corners[h as usize] as usize])
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
