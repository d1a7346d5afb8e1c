//! From a scene to a picture with its lines, by the processor or a GPU: what `render`, sheets, turntables and the window share.

use super::exit::Failure;
use super::flags::{Backend, PictureFlags, Shade};
use super::gpu;
use super::job::Job;
use super::messages::{note, warning};
use super::render::Arguments;
use super::stats::{Clock, Time, frame_stages};
use super::watch::{self, Phase};
#[cfg(feature = "window")]
use earmark::camera::Sphere;
use earmark::camera::View;
use earmark::film::Image;
use earmark::frame::{Finished, FrameStats, Refinement, RenderError, Renderer};
use earmark::{Camera, Scene, overlay};

/// A renderer within the limits of now.
pub(crate) fn renderer(job: &Job, a: &Arguments) -> Renderer {
    let mut renderer = a.picture.renderer(&a.level);
    renderer.simd = job.simd;
    renderer.aovs = a.aov.iter().map(|f| f.aov).collect();
    renderer.measure = job.measure || super::messages::is_verbose();
    renderer.limits = job.limits();
    renderer
}

/// The camera of the arguments in the coordinates of a scene.
pub(crate) fn camera(a: &Arguments, scene: &Scene) -> Camera {
    a.picture.camera().relative_to(origin(scene))
}

/// Where the origin of a scene's coordinates is in its files.
pub(crate) fn origin(scene: &Scene) -> [f64; 3] {
    let first = scene.objects.first();
    first.map_or([0.0; 3], |o| o.surface.cage().origin())
}

/// A frame with the lines over it.
pub(crate) struct Lined {
    pub(crate) frame: Finished,
    pub(crate) lines: Option<overlay::LineArt>,
    /// What the lines took.
    pub(crate) overlay: Time,
}

/// Draws a frame and its line work; line work alone is drawn on the background.
pub(crate) fn lined(
    renderer: &Renderer,
    scene: &Scene,
    camera: &Camera,
    picture: &PictureFlags,
) -> Result<Lined, RenderError> {
    let view = renderer.view(scene, camera)?;
    lined_view(renderer, scene, view, picture)
}

/// The same for a view.
fn lined_view(
    renderer: &Renderer,
    scene: &Scene,
    view: View,
    picture: &PictureFlags,
) -> Result<Lined, RenderError> {
    let alone = picture.shade == Shade::Wireframe;
    let mut frame = if alone && renderer.aovs.is_empty() {
        Finished {
            image: Image::new(0, 0),
            planes: Vec::new(),
            stats: FrameStats::default(),
            view,
        }
    } else {
        renderer.render_view(scene, &view)?
    };
    if alone {
        frame.image = Image::filled(picture.size, renderer.background);
    }
    let (lines, overlay) = line_work(renderer, scene, &view, picture, &mut frame.image)?;
    if let (true, Some(art)) = (alone, &lines) {
        frame.stats = art.stats.clone();
    }
    Ok(Lined {
        frame,
        lines,
        overlay,
    })
}

/// Draws the line work of a view over its picture, and what that took.
fn line_work(
    renderer: &Renderer,
    scene: &Scene,
    view: &View,
    picture: &PictureFlags,
    image: &mut Image,
) -> Result<(Option<overlay::LineArt>, Time), RenderError> {
    let clock = Clock::now();
    let options = picture.line_work();
    let lines = options.map(|options| overlay::draw(image, renderer, scene, view, &options));
    Ok((lines.transpose()?, clock.elapsed()))
}

/// Draws a scene that was made of the same arguments; `sphere` is what the camera frames, where that is known.
#[cfg(feature = "window")]
pub(crate) fn draw_scene(
    job: &mut Job,
    a: &Arguments,
    scene: &Scene,
    sphere: Option<&Sphere>,
) -> Result<Finished, Failure> {
    let mut renderer = renderer(job, a);
    if job.uniform {
        renderer.refinement = renderer.refinement.without_flatness(scene, renderer.size);
    }
    if let Some(kept) = &mut job.kept {
        renderer.take_buffers(kept);
    }
    let camera = camera(a, scene);
    if a.picture.backend == Backend::Gpu {
        check_lines_alone(&a.picture)?;
        let view = match sphere {
            Some(sphere) => camera.framing(sphere, renderer.size)?,
            None => renderer.view(scene, &camera)?,
        };
        let mut frame = gpu::draw_kept(&mut job.on_gpu, &a.picture, &renderer, scene, view)?;
        line_work(&renderer, scene, &view, &a.picture, &mut frame.image)?;
        return Ok(frame);
    }
    let lined = match sphere {
        Some(sphere) => {
            let view = camera.framing(sphere, renderer.size)?;
            lined_view(&renderer, scene, view, &a.picture)
        }
        None => lined(&renderer, scene, &camera, &a.picture),
    };
    job.kept = Some(renderer);
    Ok(lined?.frame)
}

/// Draws a frame of the arguments, with what is to be said about it.
pub(crate) fn draw(
    job: &mut Job,
    renderer: &Renderer,
    scene: &Scene,
    camera: &Camera,
    picture: &PictureFlags,
) -> Result<Lined, Failure> {
    watch::phase(Phase::Rendering);
    let clock = Clock::now();
    let lined = lined(renderer, scene, camera, picture)?;
    let cpu = clock.elapsed().cpu - lined.overlay.cpu;
    for (name, time) in frame_stages(&lined.frame.stats, cpu).0 {
        job.stages.add(name, time);
    }
    report(job, renderer, &lined);
    Ok(lined)
}

/// Says what is to be said of a frame with its lines.
fn report(job: &mut Job, renderer: &Renderer, lined: &Lined) {
    if let Some(art) = &lined.lines {
        job.stages.add("overlay", lined.overlay);
        if let Refinement::Uniform(level) = renderer.refinement
            && let Some(traced) = art.stats.levels.iter().find(|&&l| l < level)
        {
            note(&format!(
                "edges of level {level} are closer than lines can be; lines are those of level {traced}"
            ));
        }
    }
    if lined.frame.view.up_replaced {
        warning("--up is parallel to the direction of view; another direction points up");
    }
}

pub(crate) fn warn_empty() {
    warning(
        "no pixel is covered: the model is outside of the view, smaller than a pixel, or has no faces to draw",
    );
}

/// A frame from a GPU; lines are found and drawn by the processor.
pub(crate) fn draw_on_gpu(
    job: &mut Job,
    renderer: &Renderer,
    scene: &Scene,
    camera: &Camera,
    picture: &PictureFlags,
) -> Result<(Lined, gpu::Said), Failure> {
    watch::phase(Phase::Rendering);
    let (mut frame, more) = gpu::draw(job, picture, renderer, scene, camera)?;
    let view = frame.view;
    let (lines, overlay) = line_work(renderer, scene, &view, picture, &mut frame.image)?;
    let lined = Lined {
        frame,
        lines,
        overlay,
    };
    report(job, renderer, &lined);
    Ok((lined, more))
}

/// Whether the processor draws, which alone can do what `verb` names.
pub(crate) fn check_lines_alone(picture: &PictureFlags) -> Result<(), Failure> {
    match picture.shade {
        Shade::Wireframe => check_backend(picture, "line work alone"),
        _ => Ok(()),
    }
}

/// Refuses what another backend does not draw.
pub(crate) fn check_backend(picture: &PictureFlags, verb: &str) -> Result<(), Failure> {
    match picture.backend {
        Backend::Gpu => Err(Failure::usage(format!(
            "--backend gpu draws single pictures, not {verb}"
        ))),
        Backend::Cpu => Ok(()),
    }
}
