//! The work behind the window: everything goes from flags through the arguments of `render`, and is loaded, drawn and written by its code.

use super::Arguments;
use crate::cli::exit::Failure;
use crate::cli::flags::RunningFlags;
use crate::cli::job::Job;
use crate::cli::machine::pool_of;
use crate::cli::outputs::{Output, print_text};
use crate::cli::{draw, gpu, render};
use clap::parser::ValueSource;
use clap::{ArgMatches, Command, FromArgMatches, Parser};
use earmark::window::{Draft, Drawn, Flags, Loaded, Order, Shown, Start, Studio, Task, shell_line};
use earmark::{Camera, files, film};
use std::ffi::OsString;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

/// Flags that change no pixel, or that a picture gets from the window. Those of the camera are not among them.
const NOT_SAID: &[&str] = &[
    "models",
    "threads",
    "simd",
    "timeout",
    "max_memory",
    "max_faces",
    "stats",
    "quiet",
    "verbose",
    "progress",
    "color",
    "size",
];

/// `earmark render` alone.
#[derive(Parser)]
#[command(name = "render", no_binary_name = true)]
struct Reader {
    #[command(flatten)]
    arguments: render::Arguments,
}

/// What draws the window's pictures, one after the other.
struct Draughtsman {
    job: Job,
    /// The flags that were read last, and what they say.
    read: Option<(Flags, render::Arguments)>,
    /// The model of the last picture, of which something may be kept.
    shown: Option<Arc<Shown>>,
}

/// The program's part of the window.
pub(super) struct Viewer {
    models: Vec<PathBuf>,
    running: RunningFlags,
    stdin: Option<Arc<[u8]>>,
    pool: rayon::ThreadPool,
    loading: rayon::ThreadPool,
    drawing: Mutex<Draughtsman>,
    cancelled: Arc<AtomicBool>,
    deadline: Option<Instant>,
}

/// The text of a failure without the program's name: the window has it.
fn text(failure: Failure) -> String {
    let message = failure.message;
    message
        .strip_prefix("earmark: ")
        .map_or(message.clone(), str::to_owned)
}

/// The flags on the command line that make a picture, as they were written.
fn given(command: &Command, matches: &ArgMatches) -> Flags {
    let mut flags = Flags::default();
    for arg in command.get_arguments() {
        let id = arg.get_id().as_str();
        let said = matches.value_source(id) == Some(ValueSource::CommandLine);
        let Some(long) = arg.get_long().filter(|_| said && !NOT_SAID.contains(&id)) else {
            continue;
        };
        if !arg.get_action().takes_values() {
            flags.switch(long, true);
        } else if let Some(values) = matches.get_raw(id) {
            let mut joined = OsString::new();
            for (k, value) in values.enumerate() {
                if k > 0 {
                    joined.push(",");
                }
                joined.push(value);
            }
            flags.set(long, joined);
        }
    }
    // Pictures get it from the window.
    flags.set_camera(&Camera::default());
    flags
}

/// What a panic in the work is for the window.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    std::panic::catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err(text(crate::cli::internal())))
}

/// The draughtsman, who goes on after a panic without what he had in hand.
fn taken(drawing: &Mutex<Draughtsman>) -> MutexGuard<'_, Draughtsman> {
    drawing.lock().unwrap_or_else(|poisoned| {
        drawing.clear_poison();
        let mut draughtsman = poisoned.into_inner();
        draughtsman.read = None;
        draughtsman.job.kept = None;
        draughtsman.job.on_gpu = gpu::Kept::default();
        draughtsman
    })
}

impl Viewer {
    /// Prepares a window for the arguments of the program.
    pub(super) fn open(job: &Job, a: &Arguments) -> Result<(Arc<Self>, Start), Failure> {
        let mut stdin = None;
        for model in &a.models {
            let most = job.memory_left().unwrap_or(u64::MAX);
            if model.as_os_str() == "-" {
                let bytes = job.read_stdin(&a.model, most)?;
                stdin = Some(bytes.into());
            } else if !model.is_file() {
                // What is not there at the beginning is a mistake of the command; what is wrong with it may be mended while it is shown.
                files::read_model(model, most)?;
            }
        }
        let running = RunningFlags {
            stats: None,
            ..a.running.clone()
        };
        let mut drawing = Job::new(Instant::now(), &running)?;
        drawing.measure = false;
        let deadline = a.running.timeout.and_then(|t| job.start.checked_add(t));
        let viewer = Self {
            models: a.models.clone(),
            running,
            stdin,
            pool: pool_of(job.threads)?,
            // A model that is read leaves threads to the one that is shown.
            loading: pool_of(job.threads.div_ceil(2))?,
            drawing: Mutex::new(Draughtsman {
                job: drawing,
                read: None,
                shown: None,
            }),
            cancelled: job.cancelled(),
            deadline,
        };
        let command = crate::cli::command();
        let matches = command.clone().get_matches_from(std::env::args_os());
        let view = command.find_subcommand("view");
        let flags = match (view, matches.subcommand()) {
            (Some(view), Some((_, matches))) => given(view, matches),
            _ => Flags::default(),
        };
        let start = Start {
            flags,
            camera: a.picture.camera(),
            size: a.picture.size,
        };
        Ok((Arc::new(viewer), start))
    }

    /// A model's name as an argument; one that looks like a flag gets a folder.
    fn model_token(&self, model: usize) -> OsString {
        let path = self.models.get(model).cloned().unwrap_or_default();
        let name = path.as_os_str().as_encoded_bytes();
        match name.starts_with(b"-") && name != b"-" {
            true => Path::new(".").join(path).into(),
            false => path.into(),
        }
    }

    fn tokens(&self, model: usize, flags: &Flags, path: &str) -> Vec<OsString> {
        let mut tokens = vec![self.model_token(model), "-o".into(), path.into()];
        tokens.extend(flags.tokens());
        tokens
    }

    /// What `render` would be told.
    fn arguments(
        &self,
        model: usize,
        flags: &Flags,
        path: &str,
    ) -> Result<render::Arguments, String> {
        let command = <Reader as clap::CommandFactory>::command();
        let matches = command.try_get_matches_from(self.tokens(model, flags, path));
        let read = matches.and_then(|m| Reader::from_arg_matches(&m));
        let a = read.map_err(|e| e.render().to_string())?.arguments;
        render::check(&a.displace, &a.level).map_err(text)?;
        Ok(a)
    }

    fn job(&self, cancelled: &Arc<AtomicBool>) -> Result<Job, Failure> {
        let mut job = Job::new(Instant::now(), &self.running)?;
        job.set_cancelled(cancelled);
        job.stdin.clone_from(&self.stdin);
        Ok(job)
    }
}

/// Changes what a picture of the window has otherwise.
fn at_draft(a: &mut render::Arguments, order: &Order, draft: &Draft) {
    a.picture.size = draft.size(order.size);
    a.picture.samples = a.picture.samples.min(draft.samples);
    a.level.level = a.level.level.map(|l| {
        // The last level stays: a cage is something else.
        l.saturating_sub(draft.coarser).max(l.min(1))
    });
    let Camera {
        azimuth,
        elevation,
        zoom,
        fov,
        ortho,
        eye,
        target,
        up,
        near,
        far,
    } = order.camera;
    let p = &mut a.picture;
    (p.azimuth, p.elevation, p.zoom, p.fov) = (azimuth, elevation, zoom, fov);
    (p.ortho, p.eye, p.target, p.up) = (ortho, eye, target, up);
    (p.near, p.far) = (near, far);
    p.background = Some(over(p.background.unwrap_or_default(), order.backdrop));
}

/// A background over the window's, opaque.
fn over(color: [u8; 4], backdrop: [u8; 4]) -> [u8; 4] {
    let alpha = u32::from(color[3]);
    let channel = |k: usize| {
        let sum = u32::from(color[k]) * alpha + u32::from(backdrop[k]) * (255 - alpha);
        ((sum + 127) / 255) as u8
    };
    [channel(0), channel(1), channel(2), 255]
}

impl Studio for Viewer {
    fn models(&self) -> &[PathBuf] {
        &self.models
    }

    fn load(&self, model: usize, flags: &Flags, task: &Task) -> Result<Loaded, String> {
        guarded(|| {
            let a = self.arguments(model, flags, "none.png")?;
            let mut job = self.job(&task.cancelled).map_err(text)?;
            let told = task.clone();
            job.tell = Some(Box::new(move |stage| told.say(stage)));
            let scene = self
                .loading
                .install(|| render::scene(&mut job, &a, &a.models));
            let scene = scene.map_err(text)?;
            let inputs = render::inputs(&a);
            let mut files: Vec<PathBuf> = inputs.into_iter().map(Path::to_owned).collect();
            files.append(&mut job.named);
            Ok(Loaded { scene, files })
        })
    }

    fn draw(&self, order: &Order) -> Result<Drawn, String> {
        guarded(|| {
            let Draughtsman { job, read, shown } = &mut *taken(&self.drawing);
            let is_same = |shown: &Arc<Shown>| Arc::ptr_eq(shown, &order.shown);
            if !shown.as_ref().is_some_and(is_same) {
                job.on_gpu = gpu::Kept::default();
                *shown = Some(Arc::clone(&order.shown));
            }
            let mut a = match read {
                Some((flags, a)) if *flags == order.flags => a.clone(),
                _ => {
                    let a = self.arguments(0, &order.flags, "none.png")?;
                    read.insert((order.flags.clone(), a)).1.clone()
                }
            };
            at_draft(&mut a, order, &order.draft);
            job.set_cancelled(&order.cancelled);
            job.measure = order.measure;
            job.uniform = order.draft.uniform;
            let sphere = order.shown.sphere(&order.flags);
            let frame = draw::draw_scene(job, &a, &order.shown.scene, Some(sphere));
            let frame = frame.map_err(text)?;
            Ok(Drawn {
                image: frame.image,
                stats: frame.stats,
            })
        })
    }

    fn save(&self, model: usize, flags: &Flags, shown: &Shown, path: &str) -> Result<(), String> {
        let a = self.arguments(model, flags, path)?;
        let write = || {
            let mut job = self.job(&Arc::default())?;
            let output = Output::checked(&a.output, &["png"], &render::inputs(&a))?;
            let frame = draw::draw_scene(&mut job, &a, &shown.scene, None)?;
            output.stage(&film::png::encode(&frame.image)?)?.commit()
        };
        guarded(|| self.pool.install(write).map_err(text))
    }

    fn command(&self, model: usize, flags: &Flags, path: &str) -> String {
        let mut tokens: Vec<OsString> = vec!["earmark".into(), "render".into()];
        tokens.extend(self.tokens(model, flags, path));
        shell_line(&tokens)
    }

    fn print(&self, line: &str) {
        // Who started the window may listen no more.
        let _ = print_text(&format!("{line}\n"));
    }

    fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }

    fn ended(&self) -> bool {
        let late = self.deadline.is_some_and(|d| Instant::now() >= d);
        late || self.cancelled.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_one_picture_and_no_more() {
        let drawing = Mutex::new(Draughtsman {
            job: Job::new(Instant::now(), &RunningFlags::default()).unwrap(),
            read: None,
            shown: None,
        });
        let a = Reader::try_parse_from(["a.obj", "-o", "a.png"]).unwrap();
        let ended = guarded(|| -> Result<(), String> {
            let mut draughtsman = taken(&drawing);
            draughtsman.read = Some((Flags::default(), a.arguments));
            draughtsman.job.kept = Some(earmark::Renderer::new(8, 8));
            panic!("a defect, as this test wants it");
        });
        assert!(ended.unwrap_err().starts_with("internal error"));
        assert!(drawing.is_poisoned());
        let draughtsman = taken(&drawing);
        assert!(draughtsman.read.is_none() && draughtsman.job.kept.is_none());
        assert!(!drawing.is_poisoned());
    }

    #[test]
    fn the_camera_is_not_among_the_flags_that_were_given() {
        let line =
            "earmark view a.obj --shade flat --zoom 2 --eye 1,2,3 --ortho --near 0.1 --size 9x9";
        let command = crate::cli::command();
        let matches = command.clone().get_matches_from(line.split(' '));
        let (name, matches) = matches.subcommand().unwrap();
        let flags = given(command.find_subcommand(name).unwrap(), matches);
        assert_eq!(flags.tokens(), ["--shade", "flat"]);
    }
}
