// A level of a mesh of quads as half-edges, and walks around it. Half-edges 4f..4f + 3 are face f; numbers of the child are those of
// src/refine/connectivity.rs.

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> vertices: array<u32>;
@group(0) @binding(2) var<storage, read> twins: array<u32>;
@group(0) @binding(3) var<storage, read> edges: array<u32>;
@group(0) @binding(4) var<storage, read> edge_halves: array<u32>;
// First outgoing half-edge of every vertex: the boundary one of an open fan.
@group(0) @binding(5) var<storage, read> firsts: array<u32>;
@group(0) @binding(6) var<storage, read> sharpness: array<f32>;

fn next(h: u32) -> u32 {
    return (h & ~3u) | ((h + 1u) & 3u);
}

fn before(h: u32) -> u32 {
    return (h & ~3u) | ((h + 3u) & 3u);
}

// The next outgoing half-edge counter-clockwise, or NONE past the end of an open fan.
fn rotate(h: u32) -> u32 {
    return twins[before(h)];
}

fn decay(s: f32) -> f32 {
    return select(max(s - 1.0, 0.0), INFINITE, s >= INFINITE);
}

fn edge_sharpness(e: u32) -> f32 {
    return sharpness[e];
}

fn vertex_sharpness(v: u32) -> f32 {
    return sharpness[step.edges + v];
}
