//! `earmark render`.

use super::displace::DisplaceFlags;
use super::exit::Failure;
use super::flags::{LevelFlags, ModelFlags, PictureFlags, RunningFlags, Shade};
use super::job::{Job, Output, commit_all, model_names};
use super::messages::{note, warning};
use super::stats::{Clock, Json, frame_stages};
use super::watch::{self, Phase};
use clap::Args;
use earmark::camera::Sphere;
use earmark::frame::{Drawing, Finished};
use earmark::limits::Limits;
use earmark::records::ScreenSize;
use earmark::shade::{Relief, SurfaceMaterial};
use earmark::texture::{Meaning, Texture};
use earmark::{Camera, Scene, files, film};
use std::path::{Path, PathBuf};

/// Largest file of a picture given by `--color-map`, and most bytes it may take decoded.
const COLOR_MAP: u64 = 512 << 20;

#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Models (OBJ), drawn together; - is standard input
    #[arg(required = true, value_name = "MODEL")]
    pub(crate) models: Vec<PathBuf>,
    /// Picture to write (.png); - is standard output
    #[arg(short, long, value_name = "OUT.png")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) model: ModelFlags,
    #[command(flatten)]
    pub(crate) level: LevelFlags,
    #[command(flatten)]
    pub(crate) displace: DisplaceFlags,
    #[command(flatten)]
    pub(crate) picture: PictureFlags,
    #[command(flatten)]
    pub(crate) running: RunningFlags,
}

/// The paths among `models`.
pub(crate) fn input_paths(models: &[PathBuf]) -> Vec<&Path> {
    models
        .iter()
        .map(PathBuf::as_path)
        .filter(|m| m.as_os_str() != "-")
        .collect()
}

/// Standard input can be read once.
pub(crate) fn check_models(models: &[PathBuf]) -> Result<(), Failure> {
    if models.iter().filter(|m| m.as_os_str() == "-").count() > 1 {
        return Err(Failure::usage("standard input can be one model only"));
    }
    Ok(())
}

/// The files that flags name.
pub(crate) fn named_files(a: &Arguments) -> Vec<&Path> {
    let maps = [
        &a.picture.color_map,
        &a.picture.normal_map,
        &a.displace.displace,
        &a.level.pn_tags,
    ];
    let maps = maps.into_iter().filter_map(Option::as_deref);
    maps.chain(a.level.tag_file()).collect()
}

/// Where the picture and the statistics go.
fn outputs(a: &Arguments) -> Result<(Output, Option<Output>), Failure> {
    let mut inputs = input_paths(&a.models);
    inputs.extend(named_files(a));
    let picture = Output::checked(&a.output, &["png"], &inputs)?;
    let Some(stats) = &a.running.stats else {
        return Ok((picture, None));
    };
    let stats = stats_output(stats, &a.output, &inputs)?;
    Ok((picture, Some(stats)))
}

/// Where statistics go, which is nowhere else.
pub(crate) fn stats_output(
    stats: &Path,
    other: &Path,
    inputs: &[&Path],
) -> Result<Output, Failure> {
    if stats == other || files::same_file(stats, other) {
        return Err(Failure::usage("--output and --stats are the same"));
    }
    Output::checked(stats, &[], inputs)
}

/// Refuses what can be seen to be impossible before anything is read: cameras, and pictures larger than memory.
pub(crate) fn check_picture(
    picture: &PictureFlags,
    limits: &Limits,
    outputs: u128,
) -> Result<(), Failure> {
    let size = ScreenSize {
        width: picture.size[0],
        height: picture.size[1],
        samples: picture.samples,
    };
    // What depends on the model's size is found later.
    let mut plain = Camera {
        near: None,
        far: None,
        ..picture.camera()
    };
    if plain.target.is_none() {
        plain.target = plain.eye.map(|[x, y, z]| [x, y, z - 1.0]);
    }
    let sphere = Sphere {
        center: [0.0; 3],
        radius: 1.0,
    };
    plain.framing(&sphere, size)?;
    if let (Some(near), Some(far)) = (picture.near, picture.far)
        && near >= far
    {
        return Err(Failure::usage(format!(
            "--near {near} is not below --far {far}"
        )));
    }
    if picture.eye.is_some() && picture.eye == picture.target {
        return Err(Failure::usage("--eye and --target are the same point"));
    }
    let pixels = u128::from(size.width) * u128::from(size.height);
    limits.memory("a picture of this size", pixels * outputs)?;
    Ok(())
}

/// Adds a picture to the scene's textures.
fn add_texture(
    job: &Job,
    scene: &mut Scene,
    path: &Path,
    meaning: Meaning,
) -> Result<u32, Failure> {
    let most = job.memory_left().unwrap_or(u64::MAX).min(COLOR_MAP);
    let bytes = files::read_model(path, most)?;
    let mut budget = most;
    let map =
        Texture::decode(&bytes, meaning, &mut budget).map_err(|e| Failure::texture(path, &e))?;
    scene.textures.push(map);
    Ok(scene.textures.len() as u32 - 1)
}

/// Gives the scene the picture of `--normal-map` in place of its own relief.
fn apply_normal_map(job: &Job, scene: &mut Scene, path: &Path) -> Result<(), Failure> {
    let relief = Some(Relief::Normals(add_texture(
        job,
        scene,
        path,
        Meaning::Data,
    )?));
    for material in &mut scene.materials {
        material.relief = relief;
    }
    let plain = scene.default_material.unwrap_or(SurfaceMaterial::CLAY);
    scene.default_material = Some(SurfaceMaterial { relief, ..plain });
    Ok(())
}

/// Gives the scene the picture of `--color-map` in place of its own maps.
fn apply_color_map(job: &Job, scene: &mut Scene, path: &Path) -> Result<(), Failure> {
    let index = add_texture(job, scene, path, Meaning::Color)?;
    for material in &mut scene.materials {
        material.diffuse = [1.0; 3];
        material.diffuse_map = Some(index);
    }
    scene.default_material = Some(SurfaceMaterial {
        diffuse_map: Some(index),
        ..SurfaceMaterial::WHITE
    });
    Ok(())
}

/// The models of the arguments, coloured.
pub(crate) fn scene(job: &mut Job, a: &Arguments) -> Result<Scene, Failure> {
    let mut scene = job.load(&a.models, &a.model, &a.level)?;
    job.read_depth_tags(&mut scene, &a.level)?;
    if let Some(path) = &a.picture.color_map {
        job.time("read", |job| apply_color_map(job, &mut scene, path))?;
    }
    if let Some(path) = &a.picture.normal_map {
        job.time("read", |job| apply_normal_map(job, &mut scene, path))?;
    }
    job.time("read", |job| a.displace.apply(job, &mut scene))?;
    Ok(scene)
}

/// Draws a scene that was made of the same arguments; `sphere` is what the camera frames, where that is known.
pub(crate) fn draw_scene(
    job: &mut Job,
    a: &Arguments,
    scene: &Scene,
    sphere: Option<&Sphere>,
) -> Result<Finished, Failure> {
    let mut renderer = a.picture.renderer(&a.level);
    renderer.simd = job.simd;
    renderer.measure = job.measure || super::messages::is_verbose();
    renderer.limits = job.limits();
    if job.uniform {
        renderer.refinement = renderer.refinement.without_flatness(scene, renderer.size);
    }
    if let Some(kept) = &mut job.kept {
        renderer.take_buffers(kept);
    }
    let mut camera = a.picture.camera();
    if let Some(first) = scene.objects.first() {
        camera = camera.relative_to(first.surface.cage().origin());
    }
    let frame = match sphere {
        Some(sphere) => {
            let view = camera.framing(sphere, renderer.size)?;
            renderer.render_view(scene, &view)
        }
        None => renderer.render(scene, &camera),
    };
    job.kept = Some(renderer);
    Ok(frame?)
}

/// Draws the models of the arguments, with all warnings said.
fn draw(job: &mut Job, a: &Arguments) -> Result<Finished, Failure> {
    let scene = scene(job, a)?;
    let has_uvs = scene.objects.iter().any(|o| o.surface.has_uvs());
    let maps = a.picture.color_map.is_some() || a.picture.normal_map.is_some();
    if !has_uvs && (maps || a.picture.shade == Shade::Uv) {
        warning("no model has texture coordinates");
    }
    watch::phase(Phase::Rendering);
    let clock = Clock::now();
    let frame = draw_scene(job, a, &scene, None)?;
    let stages = frame_stages(&frame.stats, clock.elapsed().cpu);
    job.stages.0.extend(stages.0);
    if frame.view.up_replaced {
        warning("--up is parallel to the direction of view; another direction points up");
    }
    if frame.stats.pixels_covered == 0 {
        warning(
            "no pixel is covered: the model is outside of the view, smaller than a pixel, or has no faces to draw",
        );
    }
    Ok(frame)
}

/// Refuses flags that contradict each other.
pub(crate) fn check(displace: &DisplaceFlags, level: &LevelFlags) -> Result<(), Failure> {
    if displace.is_on() && level.drawing() == Drawing::Cage {
        return Err(Failure::usage(
            "--surface cage shows the polygons as they are: nothing is displaced",
        ));
    }
    Ok(())
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    check_models(&a.models)?;
    check(&a.displace, &a.level)?;
    let (picture, stats) = outputs(a)?;
    // The picture itself, its tiles before they are put together, and the file at its largest.
    check_picture(&a.picture, &job.limits(), 13)?;
    let frame = draw(job, a)?;
    watch::phase(Phase::Writing);
    job.limits().check()?;
    let mut staged = vec![job.time("write", |_| {
        picture.stage(&film::png::encode(&frame.image)?)
    })?];
    note(&format!(
        "{} micro-triangles, levels {:?}, {} pixels covered, {:.0} ms",
        frame.stats.microtriangles,
        frame.stats.levels,
        frame.stats.pixels_covered,
        job.start.elapsed().as_secs_f64() * 1e3
    ));
    if let Some(stats) = stats {
        let middle = vec![
            ("faces", Json::Whole(frame.stats.faces)),
            ("microtriangles", Json::Whole(frame.stats.microtriangles)),
            ("pixels_covered", Json::Whole(frame.stats.pixels_covered)),
        ];
        let report = Json::Object(job.report(model_names(&a.models), middle));
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    commit_all(staged)
}
