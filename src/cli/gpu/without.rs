//! What there is of it without a device: messages.

use super::Drawn;
use crate::cli::bench::{Arguments, Outcome};
use crate::cli::exit::{Code, Failure};
use crate::cli::flags::PictureFlags;
use crate::cli::job::Job;
use earmark::{Camera, Renderer, Scene};

fn missing<T>() -> Result<T, Failure> {
    let message = "earmark: this earmark was built without feature gpu; there is: cpu";
    Err(Failure::new(Code::Unavailable, message))
}

pub(in crate::cli) fn check() -> Result<(), Failure> {
    missing()
}
pub(in crate::cli) fn list(_: bool) -> Result<(), Failure> {
    missing()
}

/// What a window keeps from picture to picture.
#[cfg(feature = "window")]
#[derive(Default)]
pub(in crate::cli) struct Kept;

#[cfg(feature = "window")]
pub(in crate::cli) fn ready(_: &PictureFlags) -> Result<(), Failure> {
    missing()
}
#[cfg(feature = "window")]
pub(in crate::cli) fn draw_kept(
    _: &mut Kept,
    _: &PictureFlags,
    _: &Renderer,
    _: &Scene,
    _: earmark::camera::View,
) -> Result<earmark::frame::Finished, Failure> {
    missing()
}
pub(in crate::cli) fn draw(
    _: &mut Job,
    _: &PictureFlags,
    _: &Renderer,
    _: &Scene,
    _: &Camera,
) -> Result<Drawn, Failure> {
    missing()
}
pub(in crate::cli) fn frame(_: &Job, _: &Arguments, _: &Scene) -> Result<Outcome, Failure> {
    missing()
}
pub(in crate::cli) fn suite(_: &Job, _: &Arguments, _: &Scene) -> Result<Outcome, Failure> {
    missing()
}
