//! A view as the device sees it.

use super::records::Frame;
use crate::camera::View;
use crate::film::{Encoding, Film};
use crate::raster::sample_positions;
use crate::records::ScreenSize;
use crate::shade::{LightRig, ShadeMode, Shader};

/// What stays from picture to picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    pub(super) size: ScreenSize,
    pub(super) mode: ShadeMode,
    pub(super) background: [u8; 4],
    /// Degrees by which the lights are turned.
    pub(super) light_turn: f64,
    /// Whether triangles that are folded over are lit by their normals.
    pub(super) has_folds: bool,
    pub(super) id_bits: u32,
    /// Whether blocks were decided for the view.
    pub(super) tessellated: bool,
}

/// Sample positions, two by two.
fn offsets(samples: u32) -> [[i32; 4]; 8] {
    let mut out = [[0; 4]; 8];
    for (k, at) in sample_positions(samples).iter().enumerate() {
        out[k / 2][k % 2 * 2..k % 2 * 2 + 2].copy_from_slice(at);
    }
    out
}

/// What a picture in a view is, all rows of it.
pub(super) fn frame_record(scene: &Drawn, view: &View) -> Frame {
    let four = |[x, y, z]: [f32; 3], w: f32| [x, y, z, w];
    let p = &view.projection;
    let mut shader = Shader::new(scene.mode, view, &[], &[]);
    if scene.has_folds {
        shader = shader.with_folds();
    }
    let [ray_x, ray_y, ray_0] = shader.rays();
    let (lights, [wrap, gloss, rise, knee]) = LightRig::turned(view, scene.light_turn).numbers();
    let [
        key,
        fill,
        rim,
        key_color,
        fill_color,
        rim_color,
        up,
        sky,
        ground,
    ] = lights;
    let (f, e) = (view.forward, view.eye);
    let behind = -((f[0] * e[0] + f[1] * e[1]) + f[2] * e[2]);
    let film = Film::new(scene.mode.encoding(), scene.background);
    Frame {
        x: p.x,
        y: p.y,
        w: p.w,
        d: p.d,
        ray_x: four(ray_x, 0.0),
        ray_y: four(ray_y, 0.0),
        ray_0: four(ray_0, 0.0),
        eye: four(e, shader.decided()),
        back: four(f.map(|c| -c), behind),
        key_toward: four(key, 0.0),
        key_color: four(key_color, wrap),
        fill_toward: four(fill, 0.0),
        fill_color: four(fill_color, gloss),
        rim_toward: four(rim, 0.0),
        rim_color: four(rim_color, rise),
        up: four(up, 0.0),
        sky: four(sky, knee),
        ground: four(ground, 0.0),
        background: film.background(),
        offsets: offsets(scene.size.samples),
        near: p.near,
        depth_near: view.near,
        depth_far: view.far,
        ortho: u32::from(p.ortho),
        width: scene.size.width,
        height: scene.size.height,
        samples: scene.size.samples,
        mode: scene.mode as u32,
        band_start: 0,
        band_end: scene.size.height,
        srgb: u32::from(scene.mode.encoding() == Encoding::Srgb),
        id_bits: scene.id_bits,
    }
}
