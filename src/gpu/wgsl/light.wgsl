// The studio: the arithmetic of src/shade/light.rs.

fn unit(v: vec3<f32>) -> vec3<f32> {
    return v * (1.0 / sqrt(max(dot(v, v), SMALLEST)));
}

fn positive(x: f32) -> f32 {
    return select(0.0, x, x > 0.0);
}

fn wrapped(cosine: f32) -> f32 {
    let wrap = frame.key_color.w;
    let w = positive((cosine + wrap) * (1.0 / (1.0 + wrap)));
    return w * (0.45 + 0.55 * w);
}

fn shoulder(light: f32) -> f32 {
    let knee = frame.sky.w;
    let x = min(positive(light), 1e4);
    let over = positive(x - knee) * (1.0 / (1.0 - knee));
    return min(x, knee) + (1.0 - knee) * (over / (1.0 + over));
}

// The side that is seen: 1 the front, -1 the back. `side` is that of the triangle, or 0 where it has none to tell; the normal is believed
// against it from the frame's cosine to the eye on.
fn side_seen(normal: vec3<f32>, side: f32, to_eye: vec3<f32>) -> f32 {
    let facing = dot(unit(normal), unit(to_eye));
    let turned = select(1.0, -1.0, facing < 0.0);
    return select(side, turned, side == 0.0 || facing * side < -frame.eye.w);
}

fn light(normal: vec3<f32>, side: f32, to_eye: vec3<f32>, albedo: vec3<f32>) -> vec3<f32> {
    let v = unit(to_eye);
    let n = unit(normal) * side;
    let key = wrapped(dot(n, frame.key_toward.xyz));
    let fill = wrapped(dot(n, frame.fill_toward.xyz));
    let edge = 1.0 - positive(dot(n, v));
    let edge2 = edge * edge;
    let rim = positive(dot(n, frame.rim_toward.xyz)) * edge2;
    let height = 0.5 + 0.5 * dot(n, frame.up.xyz);
    let h = frame.key_toward.xyz + v;
    let nh = positive(dot(n, h));
    let s2 = nh * nh / (dot(h, h) + 1e-6);
    let s4 = s2 * s2;
    let s8 = s4 * s4;
    let s16 = s8 * s8;
    let fresnel = frame.fill_color.w + frame.rim_color.w * edge2 * edge2 * edge;
    let gloss = s16 * s16 * fresnel * key;
    let surround = frame.ground.xyz + (frame.sky.xyz - frame.ground.xyz) * height;
    let diffuse = key * frame.key_color.xyz + fill * frame.fill_color.xyz + surround;
    let rims = rim * frame.rim_color.xyz * (0.35 + 0.65 * albedo);
    let sum = albedo * diffuse + rims + gloss * frame.key_color.xyz;
    return vec3<f32>(shoulder(sum.x), shoulder(sum.y), shoulder(sum.z));
}
