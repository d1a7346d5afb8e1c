//! `earmark turntable`: a model that turns, as numbered pictures or as one animated PNG.

use super::draw::{self, Lined};
use super::exit::Failure;
use super::flags::PictureFlags;
use super::job::{Job, model_names};
use super::messages::note;
use super::outputs::{Output, Staged, commit_all, write_failure};
use super::render;
use super::stats::{Clock, Json, Time, frame_stages};
use super::watch::{self, Phase};
use clap::Args;
use earmark::film::png::{self, Animation};
use earmark::film::{Image, WriteError};
use earmark::frame::{FrameStats, RenderError, Renderer};
use earmark::limits::Progress;
use earmark::{Camera, Scene};
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Most frames of a turn.
const MOST: u32 = 100_000;

#[derive(Args, Debug)]
#[group(skip)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) render: render::Arguments,
    #[command(flatten)]
    turn: TurnFlags,
}

#[derive(Args, Debug)]
#[command(next_help_heading = "Turntable")]
struct TurnFlags {
    /// Frames of a full turn; frame K, from 1 on, is `render` with (K − 1)/N of 360 degrees added to --azimuth
    #[arg(long, value_name = "N", default_value_t = 60,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST)), allow_hyphen_values = true)]
    count: u32,
    /// Draw frames A to B only [default: the whole turn]
    #[arg(long, value_name = "A-B", value_parser = range, allow_hyphen_values = true)]
    frames: Option<RangeInclusive<u32>>,
    /// Frames per second of an animated PNG, 1 to 1000
    #[arg(long, value_name = "RATE", default_value_t = 30,
          value_parser = clap::value_parser!(u16).range(1..=1000), allow_hyphen_values = true)]
    fps: u16,
}

fn range(text: &str) -> Result<RangeInclusive<u32>, String> {
    let wrong = "not two numbers from 1 on with a - between them, or one";
    let number = |s: &str| match s.bytes().all(|b| b.is_ascii_digit()) {
        true => s.parse::<u32>().ok().filter(|n| *n >= 1),
        false => None,
    };
    let (a, b) = text.split_once('-').unwrap_or((text, text));
    match (number(a), number(b)) {
        (Some(a), Some(b)) if a <= b => Ok(a..=b),
        _ => Err(wrong.into()),
    }
}

/// Where frames go.
enum Frames {
    /// A file each.
    Numbered(Vec<Output>),
    Animated(Output),
}

/// A name with its last run of # replaced by a number of at least as many digits; `None` without #.
fn numbered(path: &Path, number: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let end = name.rfind('#')? + 1;
    let begin = name[..end].trim_end_matches('#').len();
    let digits = end - begin;
    let name = format!("{}{number:0digits$}{}", &name[..begin], &name[end..]);
    Some(path.with_file_name(name))
}

impl Arguments {
    /// The file by which the turn is known to be done: of numbered frames the last.
    pub(crate) fn last_output(&self) -> PathBuf {
        let last = self
            .turn
            .frames
            .as_ref()
            .map_or(self.turn.count, |f| *f.end());
        let path = &self.render.output;
        numbered(path, last).unwrap_or_else(|| path.clone())
    }

    /// Frames to draw.
    fn frames(&self) -> Result<RangeInclusive<u32>, Failure> {
        let count = self.turn.count;
        let frames = self.turn.frames.clone().unwrap_or(1..=count);
        if *frames.end() > count {
            let message = format!(
                "--frames ends at {}, and the turn has {count} frames",
                frames.end()
            );
            return Err(Failure::usage(message));
        }
        Ok(frames)
    }

    fn outputs(&self, frames: &RangeInclusive<u32>) -> Result<Frames, Failure> {
        let inputs = render::inputs(&self.render);
        let path = &self.render.output;
        if numbered(path, 1).is_none() {
            let output = Output::checked(path, &["png"], &inputs)?;
            return Ok(Frames::Animated(output));
        }
        let check = |k| Output::checked(&numbered(path, k).unwrap_or_default(), &["png"], &inputs);
        Ok(Frames::Numbered(
            frames.clone().map(check).collect::<Result<_, _>>()?,
        ))
    }

    /// The camera of a frame.
    fn camera(&self, scene: &Scene, frame: u32) -> Camera {
        let camera = draw::camera(&self.render, scene);
        let turned = f64::from(frame - 1) * 360.0 / f64::from(self.turn.count);
        camera.with_orbit(camera.azimuth + turned, camera.elevation)
    }

    fn check(&self) -> Result<(), Failure> {
        let r = &self.render;
        for (given, flag) in [
            (
                r.picture.eye.is_some(),
                "--eye: the eye goes round the model",
            ),
            (!r.views.is_empty(), "--views"),
            (!r.aov.is_empty(), "--aov"),
        ] {
            if given {
                return Err(Failure::usage(format!("turntable takes no {flag}")));
            }
        }
        Ok(())
    }
}

/// What all frames come to.
struct Turn<'a> {
    job: &'a mut Job,
    scene: &'a Scene,
    picture: &'a PictureFlags,
    renderer: Renderer,
    progress: Arc<Progress>,
    total: FrameStats,
    /// Whether any picture shows anything.
    shows: bool,
}

impl Turn<'_> {
    /// Draws a frame while `write` deals with the one before.
    fn step(
        &mut self,
        camera: &Camera,
        write: impl FnOnce() -> Result<(), Failure> + Send,
    ) -> Result<Image, Failure> {
        self.job.limits().check()?;
        let clock = Clock::now();
        let (renderer, scene) = (&self.renderer, self.scene);
        let picture = self.picture;
        let (drawn, (written, writing)) = rayon::join(
            || draw::lined(renderer, scene, camera, picture),
            || timed(write),
        );
        written?;
        let drawn: Result<Lined, RenderError> = drawn;
        let Lined {
            frame,
            lines,
            overlay,
        } = drawn?;
        if lines.is_some() {
            self.job.stages.add("overlay", overlay);
        }
        let cpu = (clock.elapsed().cpu - writing.cpu - overlay.cpu).max(0.0);
        for (name, time) in frame_stages(&frame.stats, cpu).0 {
            self.job.stages.add(name, time);
        }
        self.job.stages.add("write", writing);
        self.total.faces = frame.stats.faces;
        self.total.microtriangles += frame.stats.microtriangles;
        self.total.pixels_covered += frame.stats.pixels_covered;
        self.shows |= frame.stats.pixels_covered > 0;
        self.progress.step();
        Ok(frame.image)
    }
}

/// Runs work of one thread: its time is its processor time.
fn timed(work: impl FnOnce() -> Result<(), Failure>) -> (Result<(), Failure>, Time) {
    let begin = Instant::now();
    let result = work();
    let wall = begin.elapsed().as_secs_f64() * 1e3;
    (result, Time { wall, cpu: wall })
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    render::check_models(&a.render.models)?;
    render::check(&a.render.displace, &a.render.level)?;
    a.check()?;
    draw::check_backend(&a.render.picture, "turntables")?;
    let frames = a.frames()?;
    let outputs = a.outputs(&frames)?;
    let r = &a.render;
    let stats = match &r.running.stats {
        Some(path) => Some(render::stats_output(path, &r.output, &render::inputs(r))?),
        None => None,
    };
    // Two pictures, tiles before they are put together, and the file at its largest.
    render::check_picture(&r.picture, &job.limits(), 18)?;
    let scene = render::scene(job, r, &r.models)?;
    watch::phase(Phase::Turning);
    let mut renderer = draw::renderer(job, r);
    // The frames are counted, not their tiles.
    renderer.limits.progress = Arc::default();
    let progress = job.limits().progress;
    progress.begin(u64::from(frames.end() - frames.start()) + 1);
    let mut turn = Turn {
        job,
        scene: &scene,
        picture: &r.picture,
        renderer,
        progress,
        total: FrameStats::default(),
        shows: false,
    };
    let mut staged = match outputs {
        Frames::Numbered(outputs) => {
            numbered_frames(&mut turn, a, frames.clone(), &outputs)?;
            Vec::new()
        }
        Frames::Animated(output) => vec![animation(&mut turn, a, frames.clone(), &output)?],
    };
    if !turn.shows {
        draw::warn_empty();
    }
    let total = turn.total;
    let seconds = job.start.elapsed().as_secs_f64();
    note(&format!(
        "frames {} to {}, {seconds:.2} s",
        frames.start(),
        frames.end()
    ));
    if let Some(stats) = stats {
        let middle = vec![
            ("faces", Json::Whole(total.faces)),
            ("microtriangles", Json::Whole(total.microtriangles)),
            ("pixels_covered", Json::Whole(total.pixels_covered)),
            (
                "frames",
                Json::Whole(u64::from(frames.end() - frames.start()) + 1),
            ),
        ];
        let report = Json::Object(job.report(model_names(&r.models), middle));
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    commit_all(staged)
}

/// Every frame appears whole as soon as it is done, and stays if a later one fails: the turn can be taken up there by `--frames`.
fn numbered_frames(
    turn: &mut Turn<'_>,
    a: &Arguments,
    frames: RangeInclusive<u32>,
    outputs: &[Output],
) -> Result<(), Failure> {
    let mut before: Option<(Image, &Output)> = None;
    let write = |done: Option<(Image, &Output)>| match done {
        Some((image, output)) => output.stage(&png::encode(&image)?)?.commit(),
        None => Ok(()),
    };
    for (frame, output) in frames.zip(outputs) {
        let done = before.take();
        let image = turn.step(&a.camera(turn.scene, frame), || write(done))?;
        before = Some((image, output));
    }
    let (written, time) = timed(|| write(before));
    turn.job.stages.add("write", time);
    written
}

/// One file, written as frames come.
fn animation(
    turn: &mut Turn<'_>,
    a: &Arguments,
    frames: RangeInclusive<u32>,
    output: &Output,
) -> Result<Staged, Failure> {
    let mut failure = None;
    let staged = output.stage_with(|out| {
        let drawn = animate(turn, a, frames, out);
        drawn.map_err(|e| {
            failure = Some(e);
            io::Error::other("no animation")
        })
    });
    match failure {
        Some(e) => Err(e),
        None => staged,
    }
}

fn animate(
    turn: &mut Turn<'_>,
    a: &Arguments,
    frames: RangeInclusive<u32>,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let count = frames.end() - frames.start() + 1;
    let failure = |e: WriteError| Failure::from(e);
    let size = a.render.picture.size;
    let encoded = Encoded::default();
    let begun = Animation::begin(encoded.clone(), size, count, a.turn.fps);
    let mut animation = begun.map_err(failure)?;
    let mut before: Option<Image> = None;
    for frame in frames {
        let done = before.take();
        let camera = a.camera(turn.scene, frame);
        let image = turn.step(&camera, || match done {
            Some(image) => Ok(animation.add(&image)?),
            None => Ok(()),
        })?;
        before = Some(image);
        encoded.pass_on(out)?;
    }
    let (written, time) = timed(|| {
        if let Some(image) = before {
            animation.add(&image)?;
        }
        animation.finish()?;
        encoded.pass_on(out)
    });
    turn.job.stages.add("write", time);
    written
}

/// Bytes that another thread encodes, until they are passed on: standard output is locked to one thread.
#[derive(Clone, Default)]
struct Encoded(Arc<Mutex<Vec<u8>>>);

impl Encoded {
    fn lock(&self) -> MutexGuard<'_, Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    fn pass_on(&self, out: &mut dyn Write) -> Result<(), Failure> {
        let mut bytes = self.lock();
        out.write_all(&bytes).map_err(|e| write_failure(&e))?;
        bytes.clear();
        Ok(())
    }
}

impl Write for Encoded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lock().extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_place_of_their_signs() {
        let name = |p: &str, n| numbered(Path::new(p), n).map(|p| p.display().to_string());
        assert_eq!(name("a/f_####.png", 7).as_deref(), Some("a/f_0007.png"));
        assert_eq!(name("f#.png", 123).as_deref(), Some("f123.png"));
        assert_eq!(name("#1_##.png", 5).as_deref(), Some("#1_05.png"));
        assert_eq!(name("a#b/t.png", 1), None);
        assert_eq!(name("t.png", 1), None);
    }

    #[test]
    fn ranges_are_read_or_refused() {
        assert_eq!(range("3-12"), Ok(3..=12));
        assert_eq!(range("5"), Ok(5..=5));
        for text in ["", "0-3", "4-3", "-3", "3-", "a-b", "1-2-3", "+1-2"] {
            assert!(range(text).is_err(), "{text}");
        }
    }
}
