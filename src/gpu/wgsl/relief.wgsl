// Normal and bump maps: the arithmetic of src/shade/relief.rs.

// Half of the step over which slopes of a map of `size` texels are taken, where a pixel is `side` wide.
fn slope_step(size: vec2<f32>, side: f32) -> vec2<f32> {
    return min(max(0.5 / size, vec2<f32>(0.5 * side)), vec2<f32>(0.25));
}

fn bump_at(map: u32, u: f32, v: f32, side: f32) -> f32 {
    return sample_texture(map, vec2<f32>(u, v), side).x;
}

// A normal tilted by the relief of a material; `along` and `across` are derivatives of the surface by u and v.
fn tilted(material: Material, normal: vec3<f32>, along: vec3<f32>, across: vec3<f32>, uv: vec2<f32>, side: f32) -> vec3<f32> {
    let map = material.relief_map;
    if map == NONE || !has_direction(normal) {
        return normal;
    }
    let n = unit(normal);
    let direction = along - n * dot(n, along);
    if !has_direction(direction) {
        return normal;
    }
    let t = unit(direction);
    let turned_b = cross(n, t);
    let b = select(turned_b, -turned_b, dot(turned_b, across) < 0.0);
    if material.bump == 0.0 {
        let m = 2.0 * sample_texture(map, uv, side).xyz - 1.0;
        // A vector that points inside is no normal.
        return (t * m.x + b * m.y) + n * max(m.z, 1e-3);
    }
    let sizes = textures[map + 1u];
    let size = vec2<f32>(f32(textures[sizes]), f32(textures[sizes + 1u]));
    let d = slope_step(size, side);
    let slope = vec2<f32>(
        bump_at(map, uv.x + d.x, uv.y, side) - bump_at(map, uv.x - d.x, uv.y, side),
        bump_at(map, uv.x, uv.y + d.y, side) - bump_at(map, uv.x, uv.y - d.y, side)) * (material.bump * 0.5 / d);
    return (t * -slope.x + b * -slope.y) + n;
}
