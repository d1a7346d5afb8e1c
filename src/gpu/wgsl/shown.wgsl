// The surface that a sample shows: what shading and the outputs beside the picture both read.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> chunk: Chunk;
@group(0) @binding(2) var<storage, read> blocks: array<Block>;
@group(0) @binding(3) var<storage, read> points: array<f32>;
// Two words per sample: the complement of the id, and the depth.
@group(0) @binding(4) var<storage, read> keys: array<u32>;
@group(0) @binding(5) var<storage, read> faces: array<Face>;
@group(0) @binding(6) var<storage, read> materials: array<Material>;

@group(0) @binding(8) var<storage, read> uvs: array<vec2<f32>>;
// Textures one after the other, as src/texture.rs lays them out.
@group(0) @binding(9) var<storage, read> textures: array<u32>;

@group(0) @binding(10) var<storage, read> colors: array<f32>;

// Two vectors at each of the same places, which tilt normals.
@group(0) @binding(11) var<storage, read> tangents: array<f32>;
@group(0) @binding(12) var<uniform> rise: Rise;
@group(0) @binding(13) var<storage, read> heights: array<f32>;
@group(0) @binding(15) var<storage, read> lists: array<u32>;

fn normal_at(at: u32) -> vec3<f32> {
    return vec3<f32>(points[POINT_FLOATS * at + 3u], points[POINT_FLOATS * at + 4u], points[POINT_FLOATS * at + 5u]);
}

fn color_at(at: u32) -> vec3<f32> {
    return vec3<f32>(colors[3u * at], colors[3u * at + 1u], colors[3u * at + 2u]);
}

fn has_direction(v: vec3<f32>) -> bool {
    let d = dot(v, v);
    return d >= SMALLEST && d <= 3.4e38;
}

fn ray(p: vec2<i32>) -> vec3<f32> {
    let s = vec2<f32>(p);
    return frame.ray_x.xyz * s.x + (frame.ray_y.xyz * s.y + frame.ray_0.xyz);
}

fn tangent_at(at: u32, which: u32) -> vec3<f32> {
    let k = 6u * at + 3u * which;
    return vec3<f32>(tangents[k], tangents[k + 1u], tangents[k + 2u]);
}

struct Shown {
    place: vec3<f32>,
    // Of any length, or none; with the slopes of a map that displaces pixel by pixel, without relief.
    n: vec3<f32>,
    // Of the micro-triangle, of any length or none.
    geometric: vec3<f32>,
    // Derivatives of the surface by its texture coordinates, where its material has relief.
    along: vec3<f32>,
    across: vec3<f32>,
    uv: vec2<f32>,
    // Side of a pixel in texture coordinates, where a map is read.
    footprint: f32,
    // Of the vertices.
    color: vec3<f32>,
    // See Weights.
    side: f32,
    material: u32,
    face: u32,
    level: u32,
    // Whether shading reads texture coordinates, and whether relief tilts the normal.
    textured: bool,
    relief: bool,
}

fn shown(id: Id, p: vec2<i32>) -> Shown {
    var out: Shown;
    let block = blocks[id.rank - chunk.first_rank];
    let face = faces[block.face];
    let corners = corners_of(block, id);
    let a = position(corners.a);
    let m = position(corners.m);
    let c = position(corners.c);
    let at = weights(a, m, c, corners.half, p);
    out.side = at.side;
    out.place = (at.w.x * a + at.w.y * m) + at.w.z * c;
    out.geometric = cross(m - a, c - a) * select(1.0, -1.0, corners.half == 1u);
    out.n = (at.w.x * normal_at(corners.a) + at.w.y * normal_at(corners.m)) + at.w.z * normal_at(corners.c);
    out.face = face.number;
    out.level = block.level;
    // The last one is that of faces without any.
    out.material = min(face.material, arrayLength(&materials) - 1u);
    out.textured = chunk.shaded != 0u && face.uv_count > 0u;
    if chunk.textured != 0u && face.uv_count > 0u {
        out.uv = (at.w.x * uvs[corners.a] + at.w.y * uvs[corners.m]) + at.w.z * uvs[corners.c];
    }
    let is_tilted = TILTED && out.textured && chunk.tangents != 0u;
    out.relief = is_tilted && rise.per_pixel == 0u;
    if out.textured && (materials[out.material].map != NONE || is_tilted) {
        out.footprint = footprint_at(block, id, corners, at.w);
    }
    if is_tilted {
        out.along = (at.w.x * tangent_at(corners.a, 0u) + at.w.y * tangent_at(corners.m, 0u)) + at.w.z * tangent_at(corners.c, 0u);
        out.across = (at.w.x * tangent_at(corners.a, 1u) + at.w.y * tangent_at(corners.m, 1u)) + at.w.z * tangent_at(corners.c, 1u);
        if rise.per_pixel != 0u {
            let size = vec2<f32>(f32(rise.width), f32(rise.height));
            let slope = map_slope(out.uv, slope_step(size, out.footprint));
            out.n -= out.along * slope.x + out.across * slope.y;
        }
    }
    out.color = vec3<f32>(1.0);
    if face.colors > 0u {
        let c = (at.w.x * color_at(corners.a) + at.w.y * color_at(corners.m)) + at.w.z * color_at(corners.c);
        out.color = max(c, vec3<f32>(0.0));
    }
    return out;
}

// Distance along the view axis from near, 0, to far, 1.
fn depth01(place: vec3<f32>) -> f32 {
    let distance = dot(-frame.back.xyz, place) + frame.back.w;
    return clamp((distance - frame.depth_near) / (frame.depth_far - frame.depth_near), 0.0, 1.0);
}

// Colour without light.
fn albedo_of(s: Shown) -> vec3<f32> {
    let material = materials[s.material];
    var albedo = material.diffuse.xyz;
    if s.textured && material.map != NONE {
        albedo *= sample_texture(material.map, s.uv, s.footprint).xyz;
    }
    return albedo * s.color;
}

// A normal with the relief of the material.
fn with_relief(s: Shown, n: vec3<f32>) -> vec3<f32> {
    if !s.relief {
        return n;
    }
    return tilted(materials[s.material], n, s.along, s.across, s.uv, s.footprint);
}

// The unit normal that is shown as such, never turned to the eye; zeros where there is none.
fn unit_normal(s: Shown) -> vec3<f32> {
    var n = with_relief(s, s.n);
    if !has_direction(n) {
        n = s.geometric;
    }
    return select(vec3<f32>(0.0), unit(n), has_direction(n));
}
