//! A level's buffers on the device, and the cage's.

use crate::gpu::device::Gpu;
use crate::gpu::error::GpuError;
use crate::gpu::records::{Mesh, Record, words};
use crate::gpu::wgsl::ALIGN;
use crate::surface::Surface;
use crate::topology::{NONE, Topology};
use wgpu::BufferUsages as Usage;

/// How much there is of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) vertices: u32,
    pub(super) edges: u32,
    pub(super) faces: u32,
    pub(super) halves: u32,
}

impl Counts {
    pub(super) fn of(t: &Topology) -> Self {
        Self {
            vertices: t.vertex_count() as u32,
            edges: t.edge_count() as u32,
            faces: t.face_count() as u32,
            halves: t.half_count() as u32,
        }
    }

    /// Those of the next level, unless they are no `u32`. Triangles are split into triangles, all else into quads.
    pub(super) fn next(self, triangles: bool) -> Option<Self> {
        let (v, e, f, h) = (self.vertices, self.edges, self.faces, self.halves);
        let face_points = if triangles { 0 } else { f };
        Some(Self {
            vertices: v.checked_add(e)?.checked_add(face_points)?,
            edges: e.checked_mul(2)?.checked_add(h)?,
            faces: if triangles { f.checked_mul(4)? } else { h },
            halves: h.checked_mul(4)?,
        })
    }

    /// Bytes of its half-edges, the rest and points, if each fits a binding.
    pub(super) fn sizes(self, gpu: &Gpu) -> Result<[u64; 3], GpuError> {
        let record = self.record().ok_or(TOO_LARGE)?;
        let bytes = |words: u32| 4 * u64::from(words);
        let sizes = [
            bytes(record.numbers + self.halves),
            bytes(record.sharpness + self.edges + self.vertices),
            bytes(3 * self.vertices),
        ];
        match sizes.iter().all(|&bytes| bytes <= gpu.max_binding) {
            true => Ok(sizes),
            false => Err(TOO_LARGE),
        }
    }

    /// Where lists begin, unless that is no `u32`.
    fn record(self) -> Option<Mesh> {
        let twins = self.halves.checked_next_multiple_of(ALIGN)?;
        let firsts = self.edges.checked_next_multiple_of(ALIGN)?;
        let vertices = self.vertices.checked_next_multiple_of(ALIGN)?;
        // Numbers of all words.
        twins.checked_mul(3)?;
        self.vertices.checked_mul(3)?;
        let sharpness = firsts.checked_add(vertices)?;
        sharpness
            .checked_add(self.edges)?
            .checked_add(self.vertices)?;
        Some(Mesh {
            vertices: self.vertices,
            edges: self.edges,
            faces: self.faces,
            halves: self.halves,
            twins,
            numbers: 2 * twins,
            firsts,
            sharpness,
        })
    }
}

/// A level on the device.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) counts: Counts,
    /// Its [`Mesh`].
    pub(super) mesh: wgpu::Buffer,
    /// Of half-edges vertices, twins and edges.
    pub(super) halves: wgpu::Buffer,
    /// Half-edges of edges, first half-edges of vertices, sharpness.
    pub(super) rest: wgpu::Buffer,
    pub(super) points: wgpu::Buffer,
}

pub(super) const TOO_LARGE: GpuError = GpuError::OutOfMemory {
    what: "a level of this size in one buffer",
};

impl Level {
    /// Room for a level.
    pub(super) fn empty(gpu: &Gpu, counts: Counts) -> Result<Self, GpuError> {
        let record = counts.record().ok_or(TOO_LARGE)?;
        let [halves, rest, points] = counts.sizes(gpu)?;
        let usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
        let mesh = Usage::UNIFORM | Usage::COPY_DST;
        let made = Self {
            counts,
            mesh: gpu.empty("a mesh", Mesh::SIZE as u64, mesh)?,
            halves: gpu.empty("half-edges", halves, usage | Usage::INDEX)?,
            rest: gpu.empty("edges", rest, usage)?,
            points: gpu.empty("points", points, usage | Usage::VERTEX)?,
        };
        put(gpu, &made.mesh, 0, &words(&[record]));
        Ok(made)
    }

    /// The cage of `surface`.
    pub(super) fn of_cage(gpu: &Gpu, surface: &Surface) -> Result<Self, GpuError> {
        let t = surface.topology();
        let counts = Counts::of(t);
        let level = Self::empty(gpu, counts)?;
        let at = counts.record().ok_or(TOO_LARGE)?;
        let of_halves = |word: fn(&Topology, u32) -> u32| -> Vec<u32> {
            (0..counts.halves).map(|h| word(t, h)).collect()
        };
        put(gpu, &level.halves, 0, &of_halves(Topology::vertex));
        put(gpu, &level.halves, at.twins, &of_halves(Topology::twin));
        put(gpu, &level.halves, at.numbers, &of_halves(Topology::edge));
        let edges = 0..counts.edges;
        let halves: Vec<u32> = edges.clone().map(|e| t.edge_half(e)).collect();
        put(gpu, &level.rest, 0, &halves);
        let first = t
            .fans()
            .iter()
            .map(|f| if f.faces == 0 { NONE } else { f.first });
        put(gpu, &level.rest, at.firsts, &first.collect::<Vec<_>>());
        let sharp = edges.map(|e| t.edge_sharpness(e));
        let sharp = sharp.chain((0..counts.vertices).map(|v| t.vertex_sharpness(v)));
        let sharp: Vec<u32> = sharp.map(f32::to_bits).collect();
        put(gpu, &level.rest, at.sharpness, &sharp);
        let points: &[u32] = bytemuck::cast_slice(surface.control_base());
        put(gpu, &level.points, 0, points);
        Ok(level)
    }
}

fn put(gpu: &Gpu, buffer: &wgpu::Buffer, first: u32, words: &[u32]) {
    gpu.queue()
        .write_buffer(buffer, 4 * u64::from(first), bytemuck::cast_slice(words));
}

/// First half-edges of faces and one past the last, then the face of every half-edge.
pub(super) fn polygon_words(t: &Topology) -> Vec<u32> {
    let firsts = (0..t.face_count() as u32).map(|f| t.face_halves(f).start);
    let halves = t.half_count() as u32;
    let faces = (0..halves).map(|h| t.face_of(h));
    firsts.chain(std::iter::once(halves)).chain(faces).collect()
}

/// Most faces around a vertex.
pub(super) fn most_around(t: &Topology) -> u32 {
    t.fans().iter().map(|fan| fan.faces).max().unwrap_or(0)
}
