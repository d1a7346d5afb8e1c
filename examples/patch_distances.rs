//! Limit surface, QAS and PN patches beside each other, and how far the patches are off, by colour:
//! `cargo run --release --example patch_distances -- MODEL.obj OUT.png [SIDE]`.
//!
//! `SIDE` is the side of one picture in pixels, 400 by default. Without a model (`-`): an icosahedron under Loop's scheme.
#![allow(missing_docs)]

use earmark::distance::{Summary, limit_of, limit_points, of_face};
use earmark::film::Image;
use earmark::frame::Refinement;
use earmark::load::{LoadOptions, Loader};
use earmark::patch::PatchKind;
use earmark::shade::SurfaceMaterial;
use earmark::sheet::{Picture, SheetStyle, contact_sheet};
use earmark::{Cage, Camera, Renderer, Scene, Surface, SurfaceOptions, files, film};
use std::collections::HashMap;
use std::path::Path;

/// Distances of the first and the last colour, as parts of the diagonal of the cage's box.
const SCALE: [f64; 2] = [1e-5, 1e-1];

/// Linear colours from the first to the last.
const COLORS: [[f32; 3]; 5] = [
    [0.02, 0.03, 0.25],
    [0.02, 0.35, 0.45],
    [0.15, 0.5, 0.08],
    [0.9, 0.6, 0.03],
    [0.7, 0.02, 0.02],
];

/// The colour at `t` from 0 to 1.
fn ramp(t: f64) -> [f32; 3] {
    let at = t.clamp(0.0, 1.0) * (COLORS.len() - 1) as f64;
    let k = (at as usize).min(COLORS.len() - 2);
    let f = (at - k as f64) as f32;
    [0, 1, 2].map(|c| COLORS[k][c] * (1.0 - f) + COLORS[k + 1][c] * f)
}

fn color(distance: f64) -> [f32; 3] {
    let [low, high] = SCALE.map(f64::log10);
    ramp((distance.max(1e-30).log10() - low) / (high - low))
}

/// The colours beside each other, each decade with a darker end.
fn legend(side: u32) -> Image {
    let decades = (SCALE[1] / SCALE[0]).log10().round();
    let mut image = Image::new(side, side);
    for y in side * 2 / 5..side * 3 / 5 {
        for x in 0..side {
            let t = f64::from(x) / f64::from(side);
            let shade = if (t * decades).fract() * f64::from(side) < 2.0 * decades {
                0.0
            } else {
                1.0
            };
            let rgb = ramp(t).map(|c| (255.0 * (c * shade).powf(1.0 / 2.2)) as u8);
            let at = ((y * side + x) * 4) as usize;
            image.data[at..at + 4].copy_from_slice(&[rgb[0], rgb[1], rgb[2], 255]);
        }
    }
    image
}

/// The patches as a mesh of points with colours, and what their distances come to.
fn heat(
    patches: &Surface,
    limit: &Surface,
    level: u32,
    diagonal: f64,
) -> Result<(Scene, Summary), Box<dyn std::error::Error>> {
    let (mut points, mut colors, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    // Sides have the same bits from both faces.
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    let mut sum = Summary::default();
    for q in 0..patches.quads().face_count() as u32 {
        let face = of_face(patches, limit, q, level);
        sum.add(&face);
        let n = face.diced.side;
        let ids: Vec<u32> = (0..n * n)
            .map(|k| {
                let p = face.diced.points[k];
                *known
                    .entry(p.map(|c| (c + 0.0).to_bits()))
                    .or_insert_with(|| {
                        points.push(p);
                        colors.push(color(f64::from(face.nearest[k]) / diagonal));
                        points.len() as u32 - 1
                    })
            })
            .collect();
        let half = patches.is_triangular();
        for (i, j) in (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| (i, j))) {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
            let [a, b, c, d] = corners.map(|(x, y)| ids[(j + y) * n + i + x]);
            if !half || j <= i {
                faces.push([a, b, c]);
            }
            if !half || j < i {
                faces.push([a, c, d]);
            }
        }
    }
    faces.retain(|[a, b, c]| a != b && b != c && c != a);
    let start = Cage::builder().points(points).colors(colors);
    let builder = faces.into_iter().fold(start, |b, face| b.face(face));
    let mut scene = Scene::of(Surface::new(builder.build()?, &SurfaceOptions::default()));
    scene.default_material = Some(SurfaceMaterial::WHITE);
    Ok((scene, sum))
}

fn icosahedron() -> Result<Cage, earmark::mesh::CageError> {
    let g = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [(-1.0, -g), (1.0, -g), (-1.0, g), (1.0, g)] {
        points.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    // Three points are a face if they are next to one another, two units apart.
    let near = |a: usize, b: usize| {
        let d: f32 = (0..3).map(|k| (points[a][k] - points[b][k]).powi(2)).sum();
        (d - 4.0).abs() < 1e-3
    };
    let mut builder = Cage::builder();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let [p, q, r] = [a, b, c].map(|k: usize| points[k]);
                    let volume = p[0] * (q[1] * r[2] - q[2] * r[1])
                        + p[1] * (q[2] * r[0] - q[0] * r[2])
                        + p[2] * (q[0] * r[1] - q[1] * r[0]);
                    let face = if volume > 0.0 { [a, b, c] } else { [a, c, b] };
                    builder = builder.face(face.map(|k| k as u32));
                }
            }
        }
    }
    builder.points(points).build()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, model, out, rest @ ..] = arguments.as_slice() else {
        return Err("usage: patch_distances MODEL.obj|- OUT.png [SIDE]".into());
    };
    let side = rest.first().map_or(Ok(400), |s| s.parse())?;
    let options = SurfaceOptions::default();
    let mut first = match model.as_str() {
        "-" => Scene::of(Surface::new(icosahedron()?, &options)),
        path => {
            let mut loader = Loader::new(LoadOptions::default());
            loader.add_file(Path::new(path))?;
            loader.finish().0
        }
    };
    let surface = first.objects[0].surface.clone();
    let cage = surface.cage().clone();
    let [low, high] = cage.bounds().map(|p| p.map(f64::from));
    let diagonal = (0..3)
        .map(|k| (high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt();
    let mut renderer = Renderer::new(side, side);
    renderer.background = [255; 4];
    renderer.refinement = Refinement::Uniform(4);
    // Coloured meshes are drawn as they are.
    let mut plain = Renderer::new(side, side);
    plain.background = [255; 4];
    plain.refinement = Refinement::Uniform(0);
    let level = if cage.face_count() < 100 { 5 } else { 3 };

    let picture = |image: Image, caption: &str| Picture {
        image,
        caption: caption.to_owned(),
    };
    let mut top = vec![picture(
        renderer.render(&first, &Camera::default())?.image,
        "limit",
    )];
    let mut bottom = vec![picture(legend(side), "1e-5 to 1e-1 of the diagonal")];
    for (name, kind, moved) in [
        ("QAS", PatchKind::Qas, false),
        ("PN", PatchKind::Pn, false),
        ("PN at limit points", PatchKind::Pn, true),
    ] {
        let options = SurfaceOptions {
            patches: kind,
            ..options
        };
        let mut patches = Surface::new(cage.clone(), &options);
        let limit = limit_of(&patches, &options);
        if moved {
            patches.update_points(&limit_points(&limit))?;
        }
        let (scene, sum) = heat(&patches, &limit, level, diagonal)?;
        first.objects[0].surface = patches;
        top.push(picture(
            renderer.render(&first, &Camera::default())?.image,
            name,
        ));
        let caption = format!(
            "max {:.1e}, rms {:.1e}",
            sum.max / diagonal,
            sum.rms() / diagonal
        );
        bottom.push(picture(
            plain.render(&scene, &Camera::default())?.image,
            &caption,
        ));
    }
    top.append(&mut bottom);
    let style = SheetStyle {
        columns: 4,
        text_height: (side / 22).max(8),
        ..SheetStyle::default()
    };
    let sheet = contact_sheet(&top, &style)?;
    files::write_atomic(Path::new(out), &film::png::encode(&sheet)?)?;
    Ok(())
}
