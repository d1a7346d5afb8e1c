//! Normal maps and bump maps: finer normals than the surface has, pixel by pixel.
//!
//! A normal map holds vectors in the tangent space that MikkTSpace made common (Mikkelsen, *Simulation of wrinkled surfaces revisited*,
//! 2008): x along growing u, y along growing v (green points up in the picture), z along the normal; the tangent is made orthogonal to the
//! normal, and the bitangent is their cross product, turned round where texture coordinates are mirrored. Codes stand for numbers from −1
//! to 1. Tangents are those of the limit surface at the place itself, from its derivatives and those of the texture coordinates, and not
//! averaged over vertices.
//!
//! A bump map holds heights; its slopes tilt the normal (Blinn, *Simulation of wrinkled surfaces*, 1978). Heights are lengths in texture
//! coordinates, so that a model of another size looks the same.

use crate::math::{add, cross, dot, normalize, scale, sub};
use crate::texture::Texture;

/// Where finer normals come from; the numbers are indices of textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// A normal map in tangent space.
    Normals(u32),
    /// A bump map: its red channel times `strength` is a height in units of texture coordinates.
    Heights {
        /// The texture.
        map: u32,
        /// What white stands for; MTL's bump maps get [`Relief::BUMP`].
        strength: f32,
    },
}

impl Relief {
    /// Height of white in MTL's bump maps: a hundredth of the picture's side.
    pub const BUMP: f32 = 0.01;

    /// The normal at a point, of any length: `normal` tilted. `tangents` are the derivatives of the surface by u and v; `lod` is the level of
    /// detail for a footprint.
    pub(super) fn tilt(
        self,
        textures: &[Texture],
        normal: [f32; 3],
        tangents: [[f32; 3]; 2],
        [u, v]: [f32; 2],
        footprint: f32,
    ) -> [f32; 3] {
        let (Self::Normals(map) | Self::Heights { map, .. }) = self;
        let Some(map) = textures.get(map as usize) else {
            return normal;
        };
        let Some([t, b, n]) = frame(normal, tangents) else {
            return normal;
        };
        let lod = map.lod(footprint);
        let [x, y, z] = match self {
            Self::Normals(_) => {
                let [x, y, z, _] = map.sample(u, v, lod).map(|c| 2.0 * c - 1.0);
                // A vector that points inside is no normal.
                [x, y, if z > 1e-3 { z } else { 1e-3 }]
            }
            Self::Heights { strength, .. } => {
                let [w, h] = map.size().map(|n| n as f32);
                let step = |side: f32| (0.5 / side).max(0.5 * footprint).min(0.25);
                let (du, dv) = (step(w), step(h));
                let at = |u: f32, v: f32| map.sample(u, v, lod)[0];
                let slope = |a: f32, b: f32, d: f32| (b - a) * (strength * 0.5 / d);
                [
                    -slope(at(u - du, v), at(u + du, v), du),
                    -slope(at(u, v - dv), at(u, v + dv), dv),
                    1.0,
                ]
            }
        };
        add(add(scale(t, x), scale(b, y)), scale(n, z))
    }
}

/// Unit tangent, bitangent and normal. None where the texture has no direction.
fn frame(normal: [f32; 3], [along, across]: [[f32; 3]; 2]) -> Option<[[f32; 3]; 3]> {
    let n = normalize(normal)?;
    let t = normalize(sub(along, scale(n, dot(n, along))))?;
    let b = cross(n, t);
    Some([
        t,
        if dot(b, across) < 0.0 {
            scale(b, -1.0)
        } else {
            b
        },
        n,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Meaning;

    const Z: [f32; 3] = [0.0, 0.0, 1.0];

    fn map(texel: [u8; 4]) -> Vec<Texture> {
        vec![Texture::from_rgba8(1, 1, vec![texel], Meaning::Data).unwrap()]
    }

    fn tilt(texel: [u8; 4], tangents: [[f32; 3]; 2]) -> [f32; 3] {
        Relief::Normals(0).tilt(&map(texel), Z, tangents, [0.5; 2], 0.0)
    }

    #[test]
    fn red_tilts_along_u_and_green_along_v() {
        let plain = [[2.0, 0.0, 0.5], [0.0, 3.0, 0.1]];
        let [x, y, z] = tilt([255, 128, 128, 255], plain);
        assert!(x > 0.99 && y.abs() < 0.01 && z > 0.0);
        let [x, y, _] = tilt([128, 255, 128, 255], plain);
        assert!(y > 0.99 && x.abs() < 0.01);
    }

    #[test]
    fn mirrored_texture_has_a_left_handed_frame() {
        let mirrored = [[-2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
        assert!(tilt([255, 128, 128, 255], mirrored)[0] < -0.99);
        assert!(tilt([128, 255, 128, 255], mirrored)[1] > 0.99);
    }

    #[test]
    fn what_has_no_tangents_keeps_its_normal() {
        assert_eq!(tilt([255, 0, 0, 255], [[0.0; 3]; 2]), Z);
        assert_eq!(tilt([255, 0, 0, 255], [[f32::NAN; 3]; 2]), Z);
        assert_eq!(
            Relief::Normals(7).tilt(&[], Z, [[1.0; 3]; 2], [0.0; 2], 0.0),
            Z
        );
    }

    #[test]
    fn bumps_lean_away_from_the_rise() {
        let texels = (0..64).map(|i| [(i % 8 * 16) as u8, 0, 0, 255]).collect();
        let ramp = vec![Texture::from_rgba8(8, 8, texels, Meaning::Data).unwrap()];
        let relief = Relief::Heights {
            map: 0,
            strength: 1.0,
        };
        let [x, y, z] = relief.tilt(&ramp, Z, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [0.5; 2], 0.0);
        // A rise of 16 codes per eighth of the side.
        assert!(
            (x + 16.0 / 255.0 * 8.0).abs() < 1e-3 && y.abs() < 1e-6 && z == 1.0,
            "{x} {y} {z}"
        );
    }
}
