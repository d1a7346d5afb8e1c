//! Texts of the panels: figures about the picture, what is being loaded, messages that fit the window.

use super::hud::{Content, Line, Tone};
use super::keys::Cycle;
use super::look::Look;
use super::quality::LADDER;
use super::studio::Task;
use crate::frame::{FrameStats, Stage};
use crate::sheet::text_width;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Pictures that the rate is taken from.
const WINDOW: usize = 30;
/// A longer time between pictures is a rest.
const REST: Duration = Duration::from_millis(250);

/// When pictures were drawn, and how long they took.
#[derive(Clone, Debug, Default)]
pub(super) struct Clock {
    times: VecDeque<Instant>,
    took: Duration,
    step: usize,
}

impl Clock {
    /// A picture is there.
    pub(super) fn drawn(&mut self, now: Instant, took: Duration, step: usize) {
        if self.times.back().is_some_and(|t| now > *t + REST) {
            self.times.clear();
        }
        self.times.push_back(now);
        if self.times.len() > WINDOW {
            self.times.pop_front();
        }
        (self.took, self.step) = (took, step);
    }

    /// Pictures per second; none where there were too few without a rest.
    pub(super) fn rate(&self) -> Option<f64> {
        let (first, last) = (self.times.front()?, self.times.back()?);
        let span = (*last - *first).as_secs_f64();
        (self.times.len() >= 5 && span > 0.0).then(|| (self.times.len() - 1) as f64 / span)
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// A whole number with commas.
fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// Figures about a picture; with `all`, stage by stage.
pub(super) fn content(
    name: &str,
    look: &Look,
    stats: &FrameStats,
    (clock, size): (&Clock, [u32; 2]),
    all: bool,
) -> Content {
    let ink = |text: String| vec![(Tone::Ink, text)];
    let mut lines: Vec<Line> = vec![vec![(Tone::Accent, name.to_owned())]];
    let draft = &LADDER[clock.step];
    let mut picture = format!("{} x {}, {:.1} ms", size[0], size[1], ms(clock.took));
    if let Some(rate) = clock.rate() {
        picture += &format!(", {rate:.0} frames/s");
    }
    if draft.shrink > 1 {
        picture += &format!(", at 1/{}", draft.shrink);
    } else if clock.step > 0 {
        picture += ", draft";
    }
    lines.push(ink(picture));
    let faces = count(stats.faces);
    let triangles = count(stats.microtriangles);
    lines.push(ink(format!("{faces} faces, {triangles} triangles")));
    let mut how = vec![look.fineness()];
    for cycle in [Cycle::Surface, Cycle::Scheme, Cycle::Shade] {
        let value = look.value(cycle);
        let plain = cycle.values().1[0];
        if value != plain || cycle == Cycle::Surface {
            how.push(value.to_owned());
        }
    }
    how.extend(look.flags.text("overlay").map(str::to_owned));
    if let Some(turn) = look.flags.text("light-turn") {
        how.push(format!("light {turn}"));
    }
    lines.push(ink(how.join(", ")));
    if all {
        lines.push(Vec::new());
        lines.extend(stages(stats));
    }
    Content { lines, bar: None }
}

/// Wall time of each stage that ran; fused ones share the time of the tiles by what threads spent in them.
fn stages(stats: &FrameStats) -> impl Iterator<Item = Line> {
    let fused: f64 = Stage::ALL.iter().map(|&s| ms(stats.times.get(s))).sum();
    let tiles = ms(stats.wall[2]);
    let of = move |stage: Stage| match stage {
        Stage::Flatness => ms(stats.flatness),
        Stage::DepthTags => ms(stats.depth_tags),
        Stage::Patterns => ms(stats.patterns),
        Stage::Setup => ms(stats.wall[0]),
        Stage::Bin => ms(stats.wall[1]),
        fused_stage => tiles * ms(stats.times.get(fused_stage)) / fused.max(1e-9),
    };
    let times = Stage::ALL.map(|stage| (stage.name(), of(stage)));
    times
        .into_iter()
        .filter(|(_, t)| *t > 0.0)
        .map(|(name, t)| {
            vec![
                (Tone::Ink, name.replace('_', " ")),
                (Tone::Ink, format!("{t:6.2} ms")),
            ]
        })
}

/// What is being loaded, and for how long. How much of it is done nobody knows, so the bar comes and goes.
pub(super) fn loading(task: &Task, now: Instant) -> Content {
    let seconds = (now - task.begun).as_secs_f64();
    let doing = task.doing();
    let doing = if doing.is_empty() { "waiting" } else { doing };
    let lines = [
        format!("loading {}", task.name),
        format!("{doing}, {seconds:.1} s"),
    ];
    let mut content = Content::text(Tone::Ink, lines);
    content.bar = Some(to_and_fro(seconds));
    content
}

/// A picture that takes long.
pub(super) fn drawing(time: Duration) -> Content {
    let seconds = time.as_secs_f64();
    let mut content = Content::text(Tone::Ink, [format!("drawing, {seconds:.1} s")]);
    content.bar = Some(to_and_fro(seconds));
    content
}

/// A bar that goes from nothing to all in a second, and back.
fn to_and_fro(seconds: f64) -> f32 {
    let part = seconds % 2.0;
    (if part < 1.0 { part } else { 2.0 - part }) as f32
}

/// A message in lines that fit a window, four at most.
pub(super) fn wrapped(text: &str, width: u32, scale: u32) -> impl Iterator<Item = String> {
    let room = (width as f32 - 60.0 * scale as f32).max(80.0);
    let fits = |line: &str| text_width(line, 9.0 * scale as f32) <= room;
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        let joined = match line.is_empty() {
            true => word.to_owned(),
            false => format!("{line} {word}"),
        };
        if line.is_empty() || fits(&joined) {
            *line = joined;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines.into_iter().take(4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_of_pictures_without_a_rest() {
        let start = Instant::now();
        let mut clock = Clock::default();
        for k in 0..60 {
            clock.drawn(start + Duration::from_millis(20 * k), Duration::ZERO, 0);
        }
        assert!((clock.rate().unwrap() - 50.0).abs() < 0.1);
        clock.drawn(start + Duration::from_secs(9), Duration::ZERO, 0);
        assert_eq!(clock.rate(), None);
    }

    #[test]
    fn numbers_and_messages_are_easy_to_read() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(1_234_567), "1,234,567");
        let text = "word ".repeat(200);
        let lines: Vec<String> = wrapped(&text, 640, 1).collect();
        assert_eq!(lines.len(), 4);
        assert!(lines.iter().all(|l| text_width(l, 9.0) < 640.0));
        assert_eq!(wrapped("short", 640, 1).collect::<Vec<_>>(), ["short"]);
    }
}
