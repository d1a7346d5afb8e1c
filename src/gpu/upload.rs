//! Buffers of a scene on a device.

use super::chunk::{ChunkData, NamedBlock};
use super::device::Gpu;
use super::error::GpuError;
use super::flatness::{Chunk, DeviceFlatness};
use super::order::Size;
use super::pipelines::Pipelines;
use super::records::{Lift, Material, POINT_FLOATS, Record, words};
use crate::frame::Scene;
use crate::limits::Budget;
use crate::shade::{Relief, SurfaceMaterial};
use crate::topology::NONE;
use wgpu::BufferUsages as Usage;

/// A chunk on the device, ready to be diced.
pub(super) struct DeviceChunk {
    pub(super) data: ChunkCounts,
    pub(super) points: wgpu::Buffer,
    pub(super) large: wgpu::Buffer,
    pub(super) uvs: wgpu::Buffer,
    pub(super) colors: wgpu::Buffer,
    pub(super) tangents: wgpu::Buffer,
    pub(super) rise: wgpu::Buffer,
    pub(super) lists: wgpu::Buffer,
    pub(super) sides: wgpu::BindGroup,
    /// Where patches are displaced.
    pub(super) curves: Option<wgpu::BindGroup>,
    pub(super) inside: wgpu::BindGroup,
    /// Which blocks there are.
    pub(super) named: Vec<NamedBlock>,
    pub(super) blocks: wgpu::Buffer,
    pub(super) faces: wgpu::Buffer,
    /// Sizes of the blocks that the processor decided on.
    pub(super) sizes: Vec<Size>,
    /// What decides on its blocks, where that is the device.
    pub(super) flatness: Option<DeviceFlatness>,
    /// For the first and, with keys in two passes, the second pass.
    pub(super) phases: Vec<wgpu::Buffer>,
}

#[derive(Clone, Copy)]
pub(super) struct ChunkCounts {
    pub(super) blocks: u32,
    pub(super) spots: u32,
    pub(super) points: u32,
}

/// All textures in one buffer, and where each begins.
pub(super) fn textures(
    gpu: &Gpu,
    scene: &Scene,
    budget: &mut Budget<'_>,
) -> Result<(wgpu::Buffer, Vec<u32>), GpuError> {
    let bytes: u64 = scene.textures.iter().map(|t| 2048 + t.bytes() as u64).sum();
    if bytes > gpu.max_binding {
        return Err(GpuError::OutOfMemory {
            what: "the textures in one buffer",
        });
    }
    // All of them together, and one alone on its way there.
    budget.take("the textures of the GPU backend", 0, 2 * u128::from(bytes))?;
    let (mut words, mut places) = (Vec::new(), Vec::new());
    for texture in &scene.textures {
        places.push(words.len() as u32);
        words.extend(texture.words(words.len() as u32));
    }
    Ok((gpu.filled("textures", &words)?, places))
}

/// All materials, the last one that of faces without; `places` says where textures begin.
pub(super) fn materials(scene: &Scene, places: &[u32]) -> Vec<Material> {
    let default = scene.default_material.unwrap_or(SurfaceMaterial::CLAY);
    let materials = scene.materials.iter().chain([&default]);
    let place = |map: Option<u32>| {
        let found = map.and_then(|map| places.get(map as usize).copied());
        found.unwrap_or(NONE)
    };
    let materials = materials.map(|m| {
        let [r, g, b] = m.diffuse;
        let (relief, bump) = match m.relief {
            None => (None, 0.0),
            Some(Relief::Normals(map)) => (Some(map), 0.0),
            Some(Relief::Heights { map, strength }) => (Some(map), strength),
        };
        Material {
            diffuse: [r, g, b, 1.0],
            map: place(m.diffuse_map),
            opacity_map: place(m.opacity_map),
            relief_map: match bump == 0.0 && matches!(m.relief, Some(Relief::Heights { .. })) {
                // Heights of nothing.
                true => NONE,
                false => place(relief),
            },
            bump,
        }
    });
    materials.collect()
}

pub(super) fn point_words(points: &[[f32; 3]]) -> Vec<u32> {
    points.iter().flatten().map(|c| c.to_bits()).collect()
}

/// A uniform with one record.
pub(super) fn uniform<R: Record>(gpu: &Gpu, record: &R) -> Result<wgpu::Buffer, GpuError> {
    let mut words = Vec::new();
    record.put(&mut words);
    let usage = Usage::UNIFORM | Usage::COPY_DST;
    let buffer = gpu.empty("numbers", R::SIZE as u64, usage)?;
    gpu.queue()
        .write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
    Ok(buffer)
}

pub(super) fn device_chunk(
    gpu: &Gpu,
    pipelines: &Pipelines,
    [control, heights]: [&wgpu::Buffer; 2],
    data: ChunkData,
    phases: usize,
    scene_bytes: &mut u64,
) -> Result<DeviceChunk, GpuError> {
    let floats: &[u32] = bytemuck::cast_slice(&data.weights);
    let gathers = gpu.filled("lists of control points", &data.gathers)?;
    let weights = gpu.filled("tables of weights", floats)?;
    let stencils = gpu.filled("stencils", &words(&data.stencils))?;
    let spots = gpu.filled("points of sides", &words(&data.spots))?;
    let faces = gpu.filled("faces", &words(&data.faces))?;
    let [blocks, moves] = match &data.deciding {
        Some(deciding) => DeviceFlatness::lists(gpu, deciding)?,
        None => [
            gpu.filled("blocks", &data.block_words())?,
            gpu.filled("moved points", &words(&data.moves))?,
        ],
    };
    let bytes = 4 * u64::from(POINT_FLOATS) * u64::from(data.points());
    let points = gpu.empty("diced points", bytes, Usage::STORAGE | Usage::COPY_SRC)?;
    let large = 4 + 4 * u64::from(data.quads);
    let large = gpu.empty("large quads", large, Usage::STORAGE | Usage::COPY_DST)?;
    let phases = (0..phases)
        .map(|phase| uniform(gpu, &data.record(phase as u32)))
        .collect::<Result<Vec<_>, _>>()?;
    let lists = gpu.filled("lists of triangles", &data.lists)?;
    let rise = uniform(gpu, &data.look.rise)?;
    // A binding holds one record at least.
    let lifts = match &data.lifts[..] {
        [] => words(&[Lift::default()]),
        lifts => words(lifts),
    };
    let lifts = gpu.filled("what spots take from elsewhere", &lifts)?;
    let shared = [
        (0, &phases[0]),
        (1, control),
        (2, &gathers),
        (3, &weights),
        (4, &stencils),
        (9, &points),
        (12, &rise),
        (14, heights),
    ];
    let has_curves = data.lifts.iter().any(|l| l.curved != 0);
    let side_bindings = [&shared[..], &[(5, &spots), (13, &lifts)]].concat();
    let has_uvs = data.look.textured && data.faces.iter().any(|f| f.uv_count > 0);
    let uv_bytes = if has_uvs {
        8 * u64::from(data.points())
    } else {
        16
    };
    let uvs = gpu.empty("texture coordinates", uv_bytes, Usage::STORAGE)?;
    let has_colors = data.faces.iter().any(|f| f.colors > 0);
    let color_bytes = if has_colors {
        12 * u64::from(data.points())
    } else {
        16
    };
    let colors = gpu.empty("colours", color_bytes, Usage::STORAGE)?;
    let tangent_bytes = if has_uvs && data.look.tilted {
        24 * u64::from(data.points())
    } else {
        16
    };
    let tangents = gpu.empty("what tilts normals", tangent_bytes, Usage::STORAGE)?;
    let own = [
        (6, &faces),
        (7, &blocks),
        (8, &moves),
        (10, &uvs),
        (11, &colors),
        (15, &tangents),
    ];
    let inside_bindings = [&shared[..], &own].concat();
    let all = [
        &gathers, &weights, &stencils, &spots, &faces, &blocks, &moves, &points, &large, &uvs,
        &colors, &tangents, &lifts, &lists,
    ];
    *scene_bytes += all.iter().map(|b| b.size()).sum::<u64>();
    let of = Chunk {
        chunk: &phases[0],
        control,
        gathers: &gathers,
        weights: &weights,
        stencils: &stencils,
        faces: &faces,
        points: &points,
        blocks: &blocks,
        moves: &moves,
    };
    let flatness = match &data.deciding {
        Some(deciding) => Some(DeviceFlatness::new(gpu, &of, deciding)?),
        None => None,
    };
    *scene_bytes += flatness.as_ref().map_or(0, DeviceFlatness::bytes);
    Ok(DeviceChunk {
        data: ChunkCounts {
            blocks: data.blocks.len() as u32,
            spots: data.spots.len() as u32,
            points: data.points(),
        },
        sides: pipelines.sides.bind(gpu, &side_bindings),
        curves: has_curves.then(|| pipelines.curves.bind(gpu, &side_bindings)),
        inside: pipelines.inside.bind(gpu, &inside_bindings),
        sizes: data.blocks.iter().map(Size::of).collect(),
        named: data.named,
        points,
        large,
        uvs,
        colors,
        tangents,
        rise,
        lists,
        blocks,
        faces,
        flatness,
        phases,
    })
}
