//! `earmark render`.

use super::aov::{self, AovFlag};
use super::displace::DisplaceFlags;
use super::draw::{self, Lined};
use super::exit::Failure;
use super::flags::{Backend, LevelFlags, ModelFlags, PictureFlags, RunningFlags, Shade};
use super::gpu;
use super::job::{Job, model_names};
use super::messages::{note, warning};
use super::outputs::{Output, commit_all};
use super::stats::Json;
use super::views::{self, ViewName};
use super::watch::{self, Phase};
use clap::Args;
use earmark::camera::{Sphere, View};
use earmark::film::Image;
use earmark::frame::{Aov, Drawing, FrameStats, Plane};
use earmark::limits::Limits;
use earmark::records::ScreenSize;
use earmark::shade::{Relief, SurfaceMaterial};
use earmark::texture::{Meaning, Texture};
use earmark::{Camera, Scene, files, film, overlay};
use std::path::{Path, PathBuf};

/// Largest file of a picture given by `--color-map`, and most bytes it may take decoded.
const COLOR_MAP: u64 = 512 << 20;

#[derive(Args, Clone, Debug)]
pub(crate) struct Arguments {
    /// Models (OBJ), drawn together; - is standard input
    #[arg(required = true, value_name = "MODEL")]
    pub(crate) models: Vec<PathBuf>,
    /// Picture to write (.png; .svg for --shade wireframe); - is standard output, a PNG
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
    /// Write a further picture (.png) of the same frame; may be repeated. `depth`: grey of 16 bits, linear along the view axis from near, 0,
    /// to far, 65534, and 65535 for nothing. `normal`: as --shade normals. `position`, `uv`: RGB of 16 bits over a range. `albedo`: colour
    /// without light. `face`: number of the cage's face plus 1 in 24 bits. `level`: level plus 1. `coverage`: share of the samples in
    /// 255ths. All but coverage show the sample nearest to the pixel's centre, never an average; near, far and ranges are in text chunks of
    /// the file [default: none]
    #[arg(long, value_name = "NAME=PATH", value_parser = aov::parse, help_heading = "Picture")]
    pub(crate) aov: Vec<AovFlag>,
    /// Views in one picture with captions, each of --size, with commas between them; several models are framed one by one, a row each
    /// [default: one view, all models together]
    #[arg(
        long,
        value_enum,
        value_name = "VIEW,…",
        value_delimiter = ',',
        help_heading = "Picture"
    )]
    pub(crate) views: Vec<ViewName>,
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

/// Everything that is read.
pub(crate) fn inputs(a: &Arguments) -> Vec<&Path> {
    let mut inputs = input_paths(&a.models);
    inputs.extend(named_files(a));
    inputs
}

/// Where the picture, what is beside it, and the statistics go.
struct Outputs {
    picture: Output,
    aovs: Vec<Output>,
    stats: Option<Output>,
}

fn outputs(a: &Arguments) -> Result<Outputs, Failure> {
    let inputs = inputs(a);
    let picture = Output::checked(&a.output, &["png", "svg"], &inputs)?;
    if is_svg(&a.output) && (a.picture.shade != Shade::Wireframe || !a.views.is_empty()) {
        return Err(Failure::usage(format!(
            "{}: an SVG holds the lines of one picture alone; draw it with --shade wireframe",
            a.output.display()
        )));
    }
    let mut others = vec![a.output.as_path()];
    others.extend(a.running.stats.as_deref());
    let aovs = aov::outputs(&a.aov, &inputs, &others)?;
    let stats = match &a.running.stats {
        Some(stats) => Some(stats_output(stats, &a.output, &inputs)?),
        None => None,
    };
    Ok(Outputs {
        picture,
        aovs,
        stats,
    })
}

/// Whether a path ends as line work does.
fn is_svg(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
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

/// Models, coloured and displaced as the arguments say.
pub(crate) fn scene(job: &mut Job, a: &Arguments, models: &[PathBuf]) -> Result<Scene, Failure> {
    let mut scene = job.load(models, &a.model, &a.level)?;
    job.read_depth_tags(&mut scene, &a.level)?;
    if let Some(path) = &a.picture.color_map {
        job.time("read", |job| apply_color_map(job, &mut scene, path))?;
    }
    if let Some(path) = &a.picture.normal_map {
        job.time("read", |job| apply_normal_map(job, &mut scene, path))?;
    }
    job.time("read", |job| a.displace.apply(job, &mut scene))?;
    let has_uvs = scene.objects.iter().any(|o| o.surface.has_uvs());
    let maps = a.picture.color_map.is_some() || a.picture.normal_map.is_some();
    let outputs = a.aov.iter().any(|f| f.aov == Aov::Uv);
    if !has_uvs && (maps || outputs || a.picture.shade == Shade::Uv) {
        warning("no model has texture coordinates");
    }
    Ok(scene)
}

/// A picture with all that is known of it.
pub(crate) struct Drawn {
    pub(crate) image: Image,
    /// Line work, as an SVG has it; none of a sheet.
    pub(crate) lines: Option<overlay::LineArt>,
    pub(crate) planes: Vec<Plane>,
    pub(crate) stats: FrameStats,
    /// The view, and the origin of its coordinates; none of a sheet.
    pub(crate) seen: Option<(View, [f64; 3])>,
    /// What statistics say of it beside what every picture has.
    pub(crate) more: Vec<(&'static str, Json)>,
}

/// Draws the models of the arguments together.
fn single(job: &mut Job, a: &Arguments) -> Result<Drawn, Failure> {
    let scene = scene(job, a, &a.models)?;
    let (renderer, camera) = (draw::renderer(job, a), draw::camera(a, &scene));
    let (Lined { frame, lines, .. }, more) = match a.picture.backend {
        Backend::Cpu => (
            draw::draw(job, &renderer, &scene, &camera, &a.picture)?,
            Vec::new(),
        ),
        Backend::Gpu => draw::draw_on_gpu(job, &renderer, &scene, &camera, &a.picture)?,
    };
    if frame.stats.pixels_covered == 0 {
        draw::warn_empty();
    }
    Ok(Drawn {
        image: frame.image,
        lines,
        planes: frame.planes,
        stats: frame.stats,
        seen: Some((frame.view, draw::origin(&scene))),
        more,
    })
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
    if a.picture.backend == Backend::Gpu {
        gpu::check()?;
        if !a.views.is_empty() {
            draw::check_backend(&a.picture, "sheets of --views")?;
        }
        draw::check_lines_alone(&a.picture)?;
    }
    let outputs = outputs(a)?;
    // The picture itself, its tiles before they are put together, and the file at its largest.
    let beside: usize = a.aov.iter().map(|f| 2 * f.aov.pixel_bytes()).sum();
    check_picture(&a.picture, &job.limits(), 13 + beside as u128)?;
    let drawn = match a.views.is_empty() {
        true => single(job, a)?,
        false => {
            views::check(job, a)?;
            views::draw(job, a)?
        }
    };
    watch::phase(Phase::Writing);
    job.limits().check()?;
    let mut staged = vec![job.time("write", |_| match &drawn.lines {
        Some(art) if is_svg(&a.output) => {
            let document = art.to_svg(a.picture.background);
            outputs.picture.stage(document.as_bytes())
        }
        _ => outputs.picture.stage(&film::png::encode(&drawn.image)?),
    })?];
    if let Some((view, origin)) = &drawn.seen {
        let files = aov::stage(job, &drawn.planes, &outputs.aovs, view, *origin)?;
        staged.extend(files);
    }
    let done = &drawn.stats;
    note(&format!(
        "{} micro-triangles, levels {:?}, {} pixels covered, {:.0} ms",
        done.microtriangles,
        done.levels,
        done.pixels_covered,
        job.start.elapsed().as_secs_f64() * 1e3
    ));
    if let Some(stats) = outputs.stats {
        let mut middle = vec![
            ("faces", Json::Whole(done.faces)),
            ("microtriangles", Json::Whole(done.microtriangles)),
            ("pixels_covered", Json::Whole(done.pixels_covered)),
        ];
        if let Some((view, origin)) = &drawn.seen {
            middle.extend(aov::view_json(view, *origin));
        }
        middle.extend(drawn.more);
        let report = Json::Object(job.report(model_names(&a.models), middle));
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    commit_all(staged)
}
