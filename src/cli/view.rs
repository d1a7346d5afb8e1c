//! `earmark view`.

#[cfg(feature = "window")]
#[path = "view/studio.rs"]
mod studio;

use super::displace::DisplaceFlags;
use super::draw::check_lines_alone;
use super::exit::{Code, Failure};
use super::flags::{Backend, LevelFlags, ModelFlags, PictureFlags, RunningFlags};
use super::gpu;
use super::job::Job;
use super::render::{check, check_models, check_picture};
use clap::{Arg, Args, Command};
use std::path::PathBuf;

/// What the help says below the flags.
const KEYS: &str = "\
Drag with the left button to orbit, with the middle one (or Shift and the left) to pan, with the right one to turn the light; the wheel \
zooms. H shows all keys. S writes the picture as `earmark render` would, byte for byte, into the current folder and prints the command; ? \
prints it alone. Files that change are read again.

Needs a display, and a build with the feature `window`: cargo install earmark --features window. Without a display, `earmark render` \
writes pictures, and `xvfb-run -a` gives one.";

#[derive(Args, Debug)]
#[command(after_help = KEYS)]
pub(crate) struct Arguments {
    /// Models (OBJ), shown one at a time; - is standard input
    #[arg(required = true, value_name = "MODEL")]
    pub(crate) models: Vec<PathBuf>,
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

/// The verb with what its flags mean for a window.
pub(crate) fn adapted(command: Command) -> Command {
    let size =
        "Size of the window in pixels, each side 1 to 16383; it can be changed with the mouse";
    let backdrop = "Background, sRGB and opacity in hexadecimal [default: the window's, and transparent in pictures]";
    command
        .mut_arg("size", |a| a.default_value("1280x720").help(size))
        .mut_arg("background", |a| a.help(backdrop))
        .mut_arg("timeout", |a| {
            a.help("Close the window after so many seconds, with exit code 5 [default: never]")
        })
        .mut_arg("stats", |a: Arg| a.hide(true))
        .mut_arg("progress", |a: Arg| a.hide(true))
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    check_models(&a.models)?;
    check(&a.displace, &a.level)?;
    if a.picture.backend == Backend::Gpu {
        gpu::check()?;
        check_lines_alone(&a.picture)?;
    }
    if a.running.stats.is_some() {
        return Err(Failure::usage(
            "--stats is about one picture: --stats of `earmark render` writes it",
        ));
    }
    check_picture(&a.picture, &job.limits(), 17)?;
    open(job, a)
}

#[cfg(not(feature = "window"))]
fn open(_: &Job, _: &Arguments) -> Result<(), Failure> {
    Err(Failure::new(
        Code::Unavailable,
        "earmark: this build has no window; `cargo install earmark --features window` has, and `earmark render MODEL -o OUT.png` needs none",
    ))
}

#[cfg(feature = "window")]
fn open(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    use earmark::files;
    use earmark::window::{WindowError, run};
    if a.picture.backend == Backend::Gpu {
        gpu::ready(&a.picture)?;
    }
    let (studio, start) = studio::Viewer::open(job, a)?;
    let run = run(studio, &start).inspect_err(|_| files::abandon_outputs());
    run.map_err(|e| match e {
        WindowError::Display(_) => Failure::new(
            Code::Unavailable,
            format!(
                "earmark: {e}; `earmark render MODEL -o OUT.png` needs no display, and `xvfb-run -a earmark view MODEL` gives one"
            ),
        ),
        e => Failure::new(Code::Internal, format!("earmark: {e}")),
    })?;
    // A signal or the deadline may have closed it, while a picture was being written.
    job.limits()
        .check()
        .inspect_err(|_| files::abandon_outputs())?;
    Ok(())
}
