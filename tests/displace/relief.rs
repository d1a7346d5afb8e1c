//! Normal maps: baked ones against what they were baked from, and mirrored texture coordinates.

use super::*;
use earmark::bake;
use earmark::film::Image;
use earmark::frame::Refinement;
use earmark::shade::{Relief, ShadeMode, SurfaceMaterial};
use earmark::texture::{Meaning, Texture};
use earmark::{Camera, Renderer, Scene};

/// A cube, whose limit is nearly a sphere, with a chart for each of its faces.
fn ball() -> Surface {
    let points = (0..8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0))
        .collect();
    let corners = vec![
        0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5,
    ];
    let uvs = (0..24).map(|k| {
        let (face, corner) = (k / 4, k % 4);
        let at = [[0.02, 0.02], [0.31, 0.02], [0.31, 0.48], [0.02, 0.48]][corner];
        // Every other chart is mirrored.
        let u = if face % 2 == 0 { at[0] } else { 0.33 - at[0] };
        [u + (face % 3) as f32 / 3.0, at[1] + (face / 3) as f32 * 0.5]
    });
    let cage = Cage::new(points, &[4; 6], corners).unwrap();
    let cage = cage.with_uvs(uvs.collect(), (0..24).collect()).unwrap();
    Surface::new(cage, &SurfaceOptions::default())
}

fn draw(scene: &Scene, mode: ShadeMode) -> Image {
    let mut renderer = Renderer::new(200, 200);
    renderer.refinement = Refinement::Uniform(6);
    renderer.mode = mode;
    renderer.render(scene, &Camera::default()).unwrap().image
}

fn save(name: &str, image: &Image) {
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("displace");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(
        folder.join(name),
        earmark::film::png::encode(image).unwrap(),
    )
    .unwrap();
}

/// Mean difference of colours, of 255, over pixels that are covered in both.
fn difference(a: &Image, b: &Image) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (p, q) in a.data.chunks_exact(4).zip(b.data.chunks_exact(4)) {
        if p[3] == 255 && q[3] == 255 {
            sum += (0..3).map(|k| f64::from(p[k].abs_diff(q[k]))).sum::<f64>() / 3.0;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn a_baked_map_looks_like_what_it_was_baked_from() {
    let displacement = noise("fbm:frequency=4,octaves=3").scaled(0.03);
    let mut displaced = ball();
    displaced.set_displacement(Some(displacement));
    let map = bake::normal_map(&displaced, 1024, 1024).unwrap();
    let mut mapped = Scene::of(ball());
    mapped.textures.push(map);
    mapped.default_material = Some(SurfaceMaterial {
        relief: Some(Relief::Normals(0)),
        ..SurfaceMaterial::CLAY
    });
    let (displaced, plain) = (Scene::of(displaced), Scene::of(ball()));
    for mode in [ShadeMode::Lit, ShadeMode::Normals] {
        // The same camera: both scenes are framed by the plain one.
        let view = Camera::default()
            .framing(&plain.bounding_sphere(), Renderer::new(200, 200).size)
            .unwrap();
        let draw = |scene: &Scene| {
            let mut renderer = Renderer::new(200, 200);
            renderer.refinement = Refinement::Uniform(6);
            renderer.mode = mode;
            renderer.render_view(scene, &view).unwrap().image
        };
        let [a, b, c] = [&displaced, &mapped, &plain].map(draw);
        save(&format!("ball_displaced_{mode:?}.png"), &a);
        save(&format!("ball_mapped_{mode:?}.png"), &b);
        let (near, far) = (difference(&a, &b), difference(&a, &c));
        println!("{mode:?}: mapped {near:.2}, plain {far:.2} of 255");
        assert!(near < 0.3 * far, "{mode:?}: {near} of {far}");
    }
}

#[test]
fn slopes_by_pixel_look_like_slopes_by_vertex() {
    // A smooth map, on coarse triangles and on fine ones.
    let wave = |i: u32| {
        let (x, y) = ((i % 256) as f32 / 256.0, (i / 256) as f32 / 256.0);
        0.5 + 0.25 * ((x * 75.0).sin() + (y * 50.0).cos())
    };
    let map = Arc::new(HeightMap::new(256, 256, (0..256 * 256).map(wave).collect()).unwrap());
    let draw = |per_pixel: bool, level: u32| {
        let mut surface = ball();
        let displacement = Displacement::map(map.clone()).scaled(0.03);
        surface.set_displacement(Some(displacement.with_slopes_per_pixel(per_pixel)));
        let mut renderer = Renderer::new(200, 200);
        renderer.refinement = Refinement::Uniform(level);
        let image = renderer
            .render(&Scene::of(surface), &Camera::default())
            .unwrap()
            .image;
        save(&format!("waves_{per_pixel}_{level}.png"), &image);
        image
    };
    let fine = draw(false, 7);
    let (pixel, vertex) = (
        difference(&fine, &draw(true, 3)),
        difference(&fine, &draw(false, 3)),
    );
    let same = difference(&fine, &draw(true, 7));
    println!("level 3 by pixel {pixel:.2}, by vertex {vertex:.2}; level 7 by pixel {same:.2}");
    assert!(same < 1.0 && pixel < 0.5 * vertex);
}

#[test]
fn mirrored_texture_mirrors_the_normals() {
    let points = (0..25)
        .map(|k| [(k % 5) as f32 - 2.0, (k / 5) as f32 - 2.0, 0.0])
        .collect();
    let corners: Vec<u32> = (0..16)
        .flat_map(|q| [0, 1, 6, 5].map(|k| q / 4 * 5 + q % 4 + k))
        .collect();
    let uvs = (0..25)
        .map(|k: i32| [(k % 5 - 2).abs() as f32 * 0.25, (k / 5) as f32 * 0.25])
        .collect();
    let cage = Cage::new(points, &[4; 16], corners.clone())
        .unwrap()
        .with_uvs(uvs, corners)
        .unwrap();
    let mut scene = Scene::of(Surface::new(cage, &SurfaceOptions::default()));
    scene
        .textures
        .push(Texture::from_rgba8(1, 1, vec![[217, 128, 217, 255]], Meaning::Data).unwrap());
    scene.default_material = Some(SurfaceMaterial {
        relief: Some(Relief::Normals(0)),
        ..SurfaceMaterial::CLAY
    });
    let mut renderer = Renderer::new(64, 64);
    renderer.refinement = Refinement::Uniform(4);
    renderer.mode = ShadeMode::Normals;
    renderer.size.samples = 1;
    let camera = Camera::default().with_orbit(0.0, 0.0);
    let image = renderer.render(&scene, &camera).unwrap().image;
    let red = |x: u32| i32::from(image.pixel(x, 32)[0]);
    // Texture grows outwards on both sides, and normals lean outwards.
    assert!(red(44) > 200 && red(19) < 55, "{} {}", red(44), red(19));
    assert!((red(44) + red(19) - 255).abs() <= 1);
    // The same lean, the same light, up to the line between.
    assert_eq!(red(33), red(44));
    let _ = draw(&scene, ShadeMode::Lit);
}
