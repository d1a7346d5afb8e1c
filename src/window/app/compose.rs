//! What the window shows: the last picture with its panels.

use super::{App, LONG, PATIENCE};
use crate::window::canvas::{Canvas, word};
use crate::window::figures;
use crate::window::hud::{Content, Place, Tone};
use std::time::{Duration, Instant};

/// How often what stands in the window is put there again: not every system says when it was covered.
const AGAIN: Duration = Duration::from_millis(500);
/// Height of a window in pixels from which everything on it is twice as large.
const LARGE: u32 = 1500;

impl App {
    /// What the window shows, where that has changed.
    pub(in super::super) fn frame(&mut self, now: Instant) -> Option<&Canvas> {
        let again = self.presented.is_none_or(|p| now > p + AGAIN);
        if !self.stale && !again {
            return None;
        }
        if self.stale {
            self.compose(now);
            self.stale = false;
        }
        self.presented = Some(now);
        Some(&self.window)
    }

    /// Puts the picture and what stands over it together.
    fn compose(&mut self, now: Instant) {
        if self.picture.pixels.is_empty() {
            let [r, g, b, _] = self.theme.backdrop;
            self.window.fill(self.size, word([r, g, b]));
        } else if self.picture.size == self.size {
            self.window.copy(&self.picture);
        } else {
            self.window.stretch(&self.picture, self.size);
        }
        let name = match self.studio.models().len() {
            0 | 1 => self.name(self.pictured),
            n => format!("{}  {} of {n}", self.name(self.pictured), self.pictured + 1),
        };
        let scale = 1 + u32::from(self.size[1] >= LARGE);
        let theme = &self.theme;
        let [figures, sheet, loading, messages] = &mut self.panels;
        if self.figures > 0 && self.drawn.is_some() {
            let how = (&self.clock, self.size);
            let content = figures::content(&name, &self.look, &self.stats, how, self.figures == 2);
            figures.show(&mut self.window, &content, Place::TopLeft, theme, scale);
        }
        if let Some(help) = &self.help {
            sheet.show(&mut self.window, help, Place::Middle, theme, scale);
        }
        if let Some(l) = &self.loading
            && now > l.task.begun + PATIENCE
        {
            let content = figures::loading(&l.task, now);
            // Beside the model that is shown meanwhile.
            let place = match self.shown {
                Some(_) => Place::BottomMiddle,
                None => Place::Middle,
            };
            loading.show(&mut self.window, &content, place, theme, scale);
        } else if let Some(d) = &self.drawing
            && now > d.begun + LONG
        {
            let content = figures::drawing(now - d.begun);
            loading.show(
                &mut self.window,
                &content,
                Place::BottomMiddle,
                theme,
                scale,
            );
        }
        let mut lines = Vec::new();
        for fault in [&self.broken, &self.fault].into_iter().flatten() {
            lines.extend(figures::wrapped(fault, self.size[0], scale).map(|l| (Tone::Fault, l)));
        }
        if let Some((message, _)) = &self.message {
            lines.push((Tone::Accent, message.clone()));
        }
        let content = Content {
            lines: lines.into_iter().map(|l| vec![l]).collect(),
            bar: None,
        };
        messages.show(&mut self.window, &content, Place::BottomLeft, theme, scale);
    }
}
