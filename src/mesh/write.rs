//! A level of refinement as OBJ or PLY.
//!
//! Text is formatted in parallel runs and written in order, numbers in the shortest form that reads back to the same value. Colours of
//! vertices, texture coordinates and materials go along. Faces that are holes are left out, or written with their tags. Creases and corners
//! that are still sharp are written back as OpenSubdiv's tags, so that a level refines further like its cage; but where faces were left out
//! the new border is one more boundary.

use super::Material;
use super::color::encoded;
use crate::refine::channels::{COLOR, VertexValues};
use crate::refine::{Channels, FaceVarying, Level, Limit};
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule, TriangleRule};
use rayon::prelude::*;
use std::io::{self, Write};

mod ply;
mod tags;

pub use ply::ply;

/// Elements that one task formats.
const RUN: usize = 1 << 12;

/// What to write with a level.
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteOptions<'a> {
    /// Limit points to write in place of the control points, with their normals.
    pub limit: Option<&'a Limit<f32>>,
    /// Added to every point; see [`Cage::origin`](super::Cage::origin).
    pub origin: [f64; 3],
    /// All materials, and per face of the cage an index into them or [`NONE`](super::NONE).
    pub materials: Option<(&'a [Material], &'a [u32])>,
    /// Name of the material library; none, no `mtllib` line.
    pub material_library: Option<&'a str>,
    /// Tags of the whole mesh; none, no tags at all. Limit points never have tags.
    pub tags: Option<MeshTags>,
    /// Split every quad in two along its first diagonal.
    pub triangulate: bool,
    /// Write hole faces too. In an OBJ with tags they are tagged as holes.
    pub holes: bool,
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
    /// Weights beside triangles.
    pub triangles: TriangleRule,
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

/// Polygons that a face is written as, by their corners: none for a hole that is left out.
fn polygons<'a>(
    level: &'a Level<f32>,
    options: &WriteOptions<'_>,
) -> impl Fn(u32) -> Vec<Vec<u32>> + Sync + use<'a> {
    let t = &level.topology;
    let (triangulate, holes) = (options.triangulate, options.holes);
    move |f| {
        if t.is_hole(f) && !holes {
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

/// Texture coordinates to write.
fn uv_values<'a>(uvs: &'a FaceVarying<f32>, options: &WriteOptions<'a>) -> &'a [[f32; 2]] {
    (options.limit.map(|l| l.uvs.as_slice()))
        .filter(|limits| limits.len() == uvs.values.len())
        .unwrap_or(&uvs.values)
}

/// Channels to write.
fn channels<'a>(level: &'a Level<f32>, options: &WriteOptions<'a>) -> &'a Channels<f32> {
    options.limit.map_or(&level.channels, |l| &l.channels)
}

/// Colours of vertices to write.
fn colors<'a>(level: &'a Level<f32>, options: &WriteOptions<'a>) -> Option<&'a VertexValues<f32>> {
    channels(level, options)
        .vertex_named(COLOR)
        .filter(|c| c.width == 3)
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
    let colors = colors(level, options);
    in_runs(out, points.len(), |i, text| {
        push_point(text, "v ", &points[i], options.origin);
        if let Some(colors) = colors {
            for c in colors.value(i) {
                push(text, format_args!(" {}", encoded(c)));
            }
        }
        text.push(b'\n');
    })?;
    if let Some(uvs) = &level.uvs {
        let values = uv_values(uvs, options);
        in_runs(out, values.len(), |i, text| {
            let [u, v] = values[i];
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
    let faces = polygons(level, options);
    // A run needs to know the material before it, which is that of the last face drawn.
    in_runs(out, t.face_count(), |i, text| {
        let f = i as u32;
        let drawn = faces(f);
        if drawn.is_empty() {
            return;
        }
        let name = material(f);
        let before = (0..f)
            .rev()
            .find(|&g| options.holes || !t.is_hole(g))
            .and_then(material);
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
        tags::write(out, level, tags, options)?;
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
