//! Limit points and normals of the last level.
//!
//! Masks depend on nothing but how sharp edges and faces lie around a vertex. Those of the cage's vertices, and of the points of its polygons, are
//! listed; all others came of an edge or a quad or triangle, and are of five kinds at most. The weights are the processor's own.

use super::mesh::{Counts, Level, most_around};
use crate::gpu::device::Gpu;
use crate::gpu::dicer::MOST_AROUND;
use crate::gpu::error::GpuError;
use crate::gpu::pipelines::{Stage, module, stage};
use crate::gpu::wgsl::{self, MeshStep};
use crate::refine::limit::{Masks, RingShape, VertexMasks};
use crate::refine::ring::fan_spokes;
use crate::scheme::Scheme;
use crate::scheme::crease::{is_infinite, is_semi_sharp};
use crate::scheme::limit::RingMask;
use crate::surface::Surface;
use std::collections::HashMap;
use wgpu::BufferUsages as Usage;

/// The stage's buffers.
#[derive(Debug)]
pub(super) struct LimitBuffers {
    stage: Stage,
    bindings: wgpu::BindGroup,
    vertices: u32,
    pub(super) points: wgpu::Buffer,
    pub(super) normals: wgpu::Buffer,
}

/// What no masks are made for.
pub(super) fn check(surface: &Surface, levels: u32) -> Result<(), GpuError> {
    let refuse = |what| Err(GpuError::Unsupported { what });
    let t = surface.topology();
    if levels == 0 && !surface.scheme().is_triangular() && !t.all_quads() {
        return refuse("limits of a cage's own polygons: refine it by a level");
    }
    let edges = (0..t.edge_count() as u32).map(|e| t.edge_sharpness(e));
    let mut all = edges.chain((0..t.vertex_count() as u32).map(|v| t.vertex_sharpness(v)));
    let fades = |s: f32| is_semi_sharp(s) && s > levels as f32;
    if surface.scheme() != Scheme::Bilinear && all.any(fades) {
        return refuse(
            "limits of creases that are still to fade: refine by as many levels as the sharpest",
        );
    }
    let mut corners = (0..t.face_count() as u32).map(|f| t.face_halves(f).len() as u32);
    if most_around(t) > MOST_AROUND || corners.any(|n| n > MOST_AROUND) {
        return refuse("limits at vertices of more than 512 faces, or of faces of more corners");
    }
    Ok(())
}

impl LimitBuffers {
    /// Of the last of `levels` levels of `surface`.
    pub(super) fn new(
        gpu: &Gpu,
        surface: &Surface,
        step: MeshStep,
        (levels, last): (u32, &Level),
    ) -> Result<Self, GpuError> {
        let Counts {
            vertices, halves, ..
        } = last.counts;
        let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::VERTEX;
        let points = gpu.empty("limit points", 12 * u64::from(vertices), usage)?;
        let normals = gpu.empty("limit normals", 12 * u64::from(halves), usage)?;
        let masks = gpu.filled("masks", &mask_words(surface, step, levels))?;
        let stage = stage(gpu, &module(gpu, &wgsl::limit(step)), "limit");
        let buffers = [
            &last.mesh,
            &last.halves,
            &last.rest,
            &last.points,
            &masks,
            &points,
            &normals,
        ];
        let numbered: Vec<_> = (0..).zip(buffers).collect();
        Ok(Self {
            bindings: stage.bind(gpu, &numbered),
            stage,
            vertices,
            points,
            normals,
        })
    }

    pub(super) fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        let groups = self.vertices.div_ceil(wgsl::GROUP);
        self.stage.run(pass, &self.bindings, groups);
    }
}

/// Rings of the vertices that have masks of their own. Creases that fade are smooth by then.
fn listed(surface: &Surface, levels: u32) -> Vec<Option<RingShape>> {
    let t = surface.topology();
    let mut spokes = Vec::new();
    let mut out: Vec<_> = (0..t.vertex_count() as u32)
        .map(|v| {
            spokes.clear();
            fan_spokes(t, v, &mut spokes);
            let sharp = spokes.iter().map(|s| is_infinite(t.edge_sharpness(s.edge)));
            let sharp: Vec<bool> = sharp.collect();
            (!sharp.is_empty()).then(|| RingShape {
                closed: t.fans()[v as usize].closed,
                corner: is_infinite(t.vertex_sharpness(v)),
                sharp,
            })
        })
        .collect();
    if levels > 0 && !surface.scheme().is_triangular() && !t.all_quads() {
        let corners = (0..t.face_count() as u32).map(|f| t.face_halves(f).len());
        out.extend(corners.map(|n| Some(inside(n, None))));
    }
    out
}

/// The ring of a vertex within the surface, on a crease whose first edge is the given one.
fn inside(edges: usize, crease: Option<usize>) -> RingShape {
    let mut sharp = vec![false; edges];
    if let Some(first) = crease {
        sharp[first] = true;
        sharp[first + edges / 2] = true;
    }
    RingShape {
        closed: true,
        corner: false,
        sharp,
    }
}

/// All that come of edges, quads and triangles: smooth, at a border, on a crease by the number of its first edge.
fn kinds(triangles: bool) -> Vec<RingShape> {
    let edges = if triangles { 6 } else { 4 };
    let mut border = vec![false; edges / 2 + 1];
    (border[0], border[edges / 2]) = (true, true);
    let border = RingShape {
        closed: false,
        corner: false,
        sharp: border,
    };
    let creases = (0..edges / 2).map(|first| inside(edges, Some(first)));
    [inside(edges, None), border]
        .into_iter()
        .chain(creases)
        .collect()
}

/// The number of listed vertices, where the masks of each begin, then of each kind; behind, the masks, once for all rings of a shape.
fn mask_words(surface: &Surface, step: MeshStep, levels: u32) -> Vec<u32> {
    let triangles = surface.scheme().is_triangular();
    let masks = Masks::new(triangles, step.linear);
    let listed = listed(surface, levels);
    let count = listed.len();
    let shapes: Vec<_> = listed
        .into_iter()
        .chain(kinds(triangles).into_iter().map(Some))
        .collect();
    let mut out = vec![0; 1 + shapes.len()];
    out[0] = count as u32;
    let mut starts = HashMap::new();
    for (k, shape) in (1..).zip(shapes) {
        let Some(shape) = shape else { continue };
        out[k] = *starts.entry(shape).or_insert_with_key(|shape| {
            let start = out.len() as u32;
            put_masks(&mut out, &masks.of(shape));
            start
        });
    }
    out
}

fn put_masks(out: &mut Vec<u32>, masks: &VertexMasks) {
    let count = |weights: &[f64]| weights.len() as u32;
    let put = |out: &mut Vec<u32>, mask: &RingMask| {
        let all = mask.edges.iter().chain(&mask.faces);
        out.extend(all.map(|&w| (w as f32).to_bits()));
    };
    let position = &masks.position;
    out.extend([
        count(&position.edges),
        count(&position.faces),
        masks.sectors.len() as u32,
        masks.sectors.first().map_or(0, |s| s.first as u32),
    ]);
    put(out, position);
    for sector in &masks.sectors {
        let [along, _] = &sector.tangents;
        out.extend([
            sector.count as u32,
            count(&along.edges),
            count(&along.faces),
            u32::from(sector.reflex),
        ]);
        for tangent in &sector.tangents {
            put(out, tangent);
        }
    }
}
