//! Faces with an opacity map: a sample shows them where the map is at least one half. The test happens before the sample takes part in
//! visibility, so it does not depend on the order of drawing.

use super::Frame;
use super::spot::{Listed, Quad, Shape, Spot, draw};
use super::tile::Scratch;
use crate::raster::{Cell, Key, Tile};
use crate::records::SampleId;
use crate::texture::Texture;

/// Layers of one block kept per sample. A block is at most 32×32 micro-quads of one face; it seldom lies over itself even once.
const DEPTH: usize = 4;

/// The nearest few surfaces of one block at a sample, nearest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layers([Key; DEPTH]);

impl Cell for Layers {
    #[inline(always)]
    fn put(&mut self, hit: bool, depth: f32, id: u32, front: bool) {
        self.put_packed(if hit {
            Self::pack(depth, id, front)
        } else {
            Key::EMPTY
        });
    }

    type Packed = Key;

    #[inline(always)]
    fn pack(depth: f32, id: u32, _front: bool) -> Key {
        Key::new(depth, SampleId(id))
    }

    #[inline(always)]
    fn put_packed(&mut self, mut key: Key) {
        for layer in &mut self.0 {
            if key > *layer {
                std::mem::swap(&mut key, layer);
            }
        }
    }
}

/// Draws the block that stands in the scratch buffers, with its texture coordinates and footprints, through its opacity map.
pub(super) fn draw_cutout(
    frame: &Frame<'_>,
    s: &mut Scratch,
    shape: Shape<'_>,
    map: &Texture,
    rank: u32,
) {
    let ([x0, y0], [width, height]) = (s.tile.origin(), s.tile.size());
    let samples = frame.size.samples;
    let layers = s
        .layers
        .get_or_insert_with(|| Tile::new(0, 0, 0, 0, samples));
    layers.place(x0, y0, width, height, samples);
    draw(frame.simd, layers, &s.projected, shape, rank);
    for sample in 0..samples {
        for y in 0..height {
            for x in 0..width {
                for key in layers.cell(x, y, sample).0 {
                    let Some(id) = key.id() else { break };
                    let at = [x0 + x, y0 + y, sample];
                    let mix = |g: &[f32]| match shape.list() {
                        None => Quad::new(&s.projected, id, at, samples).mix(g),
                        Some(list) => Listed::new(&s.projected, list, id, at, samples).mix(g),
                    };
                    let (u, v) = (mix(&s.attributes.uvs.x), mix(&s.attributes.uvs.y));
                    if map.opacity(u, v, map.lod(mix(&s.footprint))) >= 0.5 {
                        s.tile.merge(x, y, sample, key);
                        break;
                    }
                }
            }
        }
    }
}
