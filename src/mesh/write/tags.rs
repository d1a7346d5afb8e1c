//! Tags of a level, as OpenSubdiv's shapes have them: what is sharp still, and the rules that go on.
//!
//! One thing no tag can say: where two charts meet at a vertex with semi-sharp edges in both, and those of one are smooth already, that one
//! stays a smooth border; read back it is taken for one that never had any, and waits for the other.

use super::{MeshTags, WriteOptions};
use crate::refine::Level;
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule, TriangleRule};
use crate::topology::NONE;
use std::io::{self, Write};

/// Writes the tags of `level`, which is written with `options`.
pub(super) fn write(
    out: &mut impl Write,
    level: &Level<f32>,
    tags: MeshTags,
    options: &WriteOptions<'_>,
) -> io::Result<()> {
    let t = &level.topology;
    let boundary = match tags.boundary {
        Boundary::EdgeAndCorner => 1,
        // The faces that the rule none takes away are holes already; on a finer mesh it would not take the same.
        Boundary::None | Boundary::EdgeOnly => 2,
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
    if tags.triangles == TriangleRule::Smooth {
        writeln!(out, "t smoothtriangles 0/0/1 smooth")?;
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
    if options.holes {
        // Numbers count what is written.
        let mut number = 0;
        for f in 0..t.face_count() as u32 {
            let written = if options.triangulate {
                t.face_halves(f).len() - 2
            } else {
                1
            };
            if t.is_hole(f) {
                for k in number..number + written {
                    writeln!(out, "t hole 1/0/0 {k}")?;
                }
            }
            number += written;
        }
    }
    Ok(())
}
