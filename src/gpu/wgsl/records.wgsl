// Structures that the processor fills: field by field those of src/gpu/records.rs.

struct Frame {
    x: vec4<f32>,
    y: vec4<f32>,
    w: vec4<f32>,
    d: vec4<f32>,
    ray_x: vec4<f32>,
    ray_y: vec4<f32>,
    ray_0: vec4<f32>,
    eye: vec4<f32>,
    back: vec4<f32>,
    key_toward: vec4<f32>,
    key_color: vec4<f32>,
    fill_toward: vec4<f32>,
    fill_color: vec4<f32>,
    rim_toward: vec4<f32>,
    rim_color: vec4<f32>,
    up: vec4<f32>,
    sky: vec4<f32>,
    ground: vec4<f32>,
    background: vec4<f32>,
    offsets: array<vec4<i32>, 8>,
    near: f32,
    depth_near: f32,
    depth_far: f32,
    ortho: u32,
    width: u32,
    height: u32,
    samples: u32,
    mode: u32,
    band_start: u32,
    band_end: u32,
    srgb: u32,
    id_bits: u32,
}

struct Chunk {
    first_rank: u32,
    blocks: u32,
    spots: u32,
    phase: u32,
    triangles: u32,
    large: u32,
    patches: u32,
    width: u32,
    uv_width: u32,
    textured: u32,
    tangents: u32,
    cut: u32,
    color_width: u32,
    shaded: u32,
    differences: u32,
    padding: u32,
}

struct Rise {
    center: vec4<f32>,
    shape: u32,
    first: u32,
    width: u32,
    height: u32,
    scale: f32,
    bias: f32,
    frequency: f32,
    lacunarity: f32,
    gain: f32,
    weight: f32,
    time: f32,
    octaves: u32,
    seed: u32,
    per_pixel: u32,
    padding: vec2<u32>,
}

struct Lift {
    curve: vec4<u32>,
    uv_gather: u32,
    uv_count: u32,
    uv_table: u32,
    held: u32,
    own_gather: u32,
    own_count: u32,
    own_table: u32,
    mitre: u32,
    mitre_count: u32,
    curved: u32,
    mitre_curves: u32,
    padding: u32,
}

struct Stencil {
    gather: u32,
    count: u32,
    table: u32,
    stride: u32,
}

struct Spot {
    stencil: u32,
    index: u32,
    normal_stencil: u32,
    normal_index: u32,
}

struct Face {
    corners: vec4<u32>,
    sides: vec4<u32>,
    base_corners: vec4<u32>,
    base_sides: vec4<u32>,
    turns: u32,
    stencil: u32,
    row: u32,
    shift: u32,
    reach: u32,
    number: u32,
    material: u32,
    uv_gather: u32,
    uv_count: u32,
    uv_table: u32,
    colors: u32,
    middle: u32,
    color_stencil: u32,
    padding: array<u32, 3>,
}

struct Block {
    face: u32,
    start_x: u32,
    start_y: u32,
    step: u32,
    log: u32,
    base: u32,
    moves: u32,
    move_count: u32,
    level: u32,
    list: u32,
    list_count: u32,
    around: u32,
}

struct Move {
    at: u32,
    x: u32,
    y: u32,
    padding: u32,
}

struct Material {
    diffuse: vec4<f32>,
    map: u32,
    opacity_map: u32,
    relief_map: u32,
    bump: f32,
}

struct Outputs {
    position_low: vec4<f32>,
    position_high: vec4<f32>,
    uv_range: vec4<f32>,
    order: array<vec4<u32>, 4>,
    words: u32,
    depth: u32,
    normal: u32,
    position: u32,
    albedo: u32,
    uv: u32,
    face: u32,
    level: u32,
    coverage: u32,
    padding: u32,
    more_padding: vec2<u32>,
}

struct Mesh {
    vertices: u32,
    edges: u32,
    faces: u32,
    halves: u32,
    twins: u32,
    numbers: u32,
    firsts: u32,
    sharpness: u32,
}

struct Metric {
    x: vec4<f32>,
    y: vec4<f32>,
    h: vec4<f32>,
    eye: vec4<f32>,
    right: vec4<f32>,
    up: vec4<f32>,
    forward: vec4<f32>,
    size: vec4<f32>,
    near: f32,
    plane: f32,
    scale: f32,
    pixels: f32,
    chord: f32,
    whole_pixels: f32,
    whole_radians: f32,
    max_level: u32,
    ortho: u32,
    padding: u32,
    more_padding: vec2<u32>,
}

struct Patch {
    edges: vec4<u32>,
    net: u32,
    marks: u32,
    padding: vec2<u32>,
}

struct Edge {
    first: u32,
    second: u32,
    marks: u32,
    padding: u32,
}

struct Room {
    blocks: u32,
    points: u32,
    moves: u32,
    quads: u32,
    spots: u32,
    faces: u32,
    parts: u32,
    padding: u32,
}

struct Target {
    sample: u32,
    step: f32,
    padding: vec2<u32>,
}
