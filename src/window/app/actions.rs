//! What keys do, and the work that they start.

use super::{App, Loading};
use crate::window::changes::{Changes, mark};
use crate::window::hud::{Theme, help};
use crate::window::keys::Action;
use crate::window::look::Look;
use crate::window::studio::{Shown, Task, start_loading, start_saving};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

impl App {
    /// Does what a key asks for.
    pub(super) fn act(&mut self, action: Action, now: Instant) {
        match action {
            Action::Quit => self.done = true,
            Action::Help => {
                self.help = match self.help {
                    Some(_) => None,
                    None => Some(help()),
                };
                self.stale = true;
            }
            Action::Figures => {
                self.figures = (self.figures + 1) % 3;
                // Stages are timed only where they are shown.
                self.change();
            }
            Action::Backdrop => {
                self.theme = match self.theme == Theme::DARK {
                    true => Theme::LIGHT,
                    false => Theme::DARK,
                };
                self.change();
            }
            Action::Ortho => {
                self.orbit.toggle_ortho();
                self.change();
            }
            Action::LookFrom(azimuth, elevation) => {
                self.orbit.look_from(azimuth.into(), elevation.into());
                self.change();
            }
            Action::Reset => {
                self.orbit.reset();
                self.change();
            }
            Action::Turntable => {
                self.turning = match self.turning {
                    Some(_) => None,
                    None => Some(now),
                };
                self.movement(now);
            }
            Action::Model(by) => {
                let count = self.studio.models().len() as i32;
                let next = (self.next_model() as i32 + by).rem_euclid(count.max(1)) as usize;
                if count > 1 {
                    let look = self.next_look();
                    self.load(next, look);
                }
            }
            Action::Reload => {
                let look = self.next_look();
                self.load(self.next_model(), look);
            }
            Action::Print => {
                let line = self.command_line();
                self.studio.print(&line);
                self.say("command line printed".into(), now);
            }
            Action::Save => self.save(now),
            other => {
                let mut look = self.next_look();
                let seen = self.stats.levels.iter().max().copied().unwrap_or(0);
                if look.apply(other, seen) {
                    self.take(look);
                }
            }
        }
    }

    /// The flags that the view has, or will have as soon as the model is loaded with them.
    pub(super) fn next_look(&self) -> Look {
        self.loading
            .as_ref()
            .map_or(&self.look, |l| &l.look)
            .clone()
    }

    /// The model that is shown, or will be as soon as it is loaded.
    fn next_model(&self) -> usize {
        self.loading.as_ref().map_or(self.model, |l| l.model)
    }

    /// Goes over to other flags: at once, or as soon as the model is loaded with them.
    fn take(&mut self, look: Look) {
        let loaded_so = look.flags.of_model() == self.look.flags.of_model();
        if loaded_so && self.shown.is_some() && self.loading.is_none() {
            self.look = look;
            self.fault = None;
            self.quality.forget();
            self.change();
        } else {
            self.load(self.next_model(), look);
        }
    }

    pub(super) fn load(&mut self, model: usize, look: Look) {
        if let Some(loading) = self.loading.take() {
            loading.task.cancel();
        }
        self.loads += 1;
        let task = Task::new(self.name(model));
        let path = self.studio.models().get(model).cloned();
        let path = path.unwrap_or_default();
        let file = (path.clone(), mark(&path));
        let started = start_loading(
            Arc::clone(&self.studio),
            self.sender.clone(),
            (model, look.flags.clone()),
            (self.loads, task.clone()),
        );
        match started {
            Err(e) => self.broken = Some(format!("no thread to load with: {}", e.kind())),
            Ok(()) => {
                self.loading = Some(Loading {
                    task,
                    number: self.loads,
                    model,
                    look,
                    file,
                });
            }
        }
        self.stale = true;
    }

    pub(super) fn loaded(
        &mut self,
        loading: Loading,
        result: Result<(Arc<Shown>, Vec<PathBuf>), String>,
        now: Instant,
    ) {
        self.stale = true;
        match result {
            Ok((shown, files)) => {
                // What is being drawn is of the model before, as are the times that say whether it is waited for.
                self.movement(now);
                let expected = expected(shown.scene.face_count(), self.size);
                self.shown = Some(shown);
                self.changes = Changes::of(files);
                self.changes.was(&loading.file.0, loading.file.1);
                self.model = loading.model;
                self.look = loading.look;
                (self.broken, self.fault) = (None, None);
                // A draft first, if the picture is expected to take long.
                self.quality.begin(expected);
            }
            Err(why) => {
                // What was there goes on being shown, and its files are watched until they can be read.
                self.broken = Some(why);
                if self.shown.is_none() {
                    let (path, mark) = loading.file;
                    self.changes = Changes::of([path.clone()]);
                    self.changes.was(&path, mark);
                    self.model = loading.model;
                }
            }
        }
    }

    /// The path that the picture is written to: the model's name, or with the first number that is free. Pictures that are being written are
    /// there already.
    fn picture_path(&self) -> String {
        let name = self.studio.models().get(self.model);
        let stem = name.and_then(|n| Some(n.file_stem()?.to_string_lossy().into_owned()));
        let stem = stem.filter(|s| !s.starts_with('-'));
        let stem = stem.unwrap_or_else(|| "picture".into());
        let free = |path: &String| !self.saving.contains(path) && !Path::new(path).exists();
        let first = format!("{stem}.png");
        let others = (2..10_000).map(|k| format!("{stem}-{k}.png"));
        std::iter::once(first)
            .chain(others)
            .find(free)
            .unwrap_or_default()
    }

    fn command_line(&self) -> String {
        let path = self.picture_path();
        self.studio.command(self.model, &self.flags(), &path)
    }

    fn save(&mut self, now: Instant) {
        let Some(shown) = &self.shown else { return };
        let path = self.picture_path();
        let flags = self.flags();
        let line = self.studio.command(self.model, &flags, &path);
        let started = start_saving(
            Arc::clone(&self.studio),
            self.sender.clone(),
            (self.model, flags),
            (Arc::clone(shown), path.clone()),
        );
        match started {
            Ok(()) => {
                self.studio.print(&line);
                self.say(format!("writing {path}"), now);
                self.saving.push(path);
            }
            Err(e) => self.fault = Some(format!("no thread to write with: {}", e.kind())),
        }
    }
}

/// About how long a full picture of so many faces takes, on an ordinary machine.
fn expected(faces: usize, size: [u32; 2]) -> Duration {
    /// Nanoseconds per face and per pixel: measured on two cores with four samples, adaptive.
    const PER_FACE: u64 = 3000;
    const PER_PIXEL: u64 = 20;
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    Duration::from_nanos(faces as u64 * PER_FACE + pixels * PER_PIXEL)
}
