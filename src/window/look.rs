//! What keys change: the flags of the view.

use super::flags::Flags;
use super::keys::{Action, Cycle};

/// Highest level that keys reach; `--level` goes on to 10.
const HIGHEST: u32 = 9;
/// Largest and smallest flatness that keys reach, in pixels.
const FLATNESS: [f64; 2] = [0.0625, 32.0];
/// The flatness of adaptive tessellation without a flag.
const PLAIN_FLATNESS: f64 = 0.5;
/// The level that uniform refinement begins with where none was seen before.
const PLAIN_LEVEL: u32 = 3;

/// The flags of the view and those that it began with.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Look {
    /// As they are now.
    pub(super) flags: Flags,
    home: Flags,
    level: u32,
    flatness: f64,
}

impl Look {
    /// Begins with flags.
    #[must_use]
    pub(super) fn new(flags: Flags) -> Self {
        let level = flags.number("level").map(|l| l as u32);
        let flatness = flags.number("adaptive");
        Self {
            home: flags.clone(),
            flags,
            level: level.unwrap_or(PLAIN_LEVEL),
            flatness: flatness.unwrap_or(PLAIN_FLATNESS),
        }
    }

    /// Does what a key asks for, if that is a change of flags; `seen` is the deepest level of the last picture.
    pub(super) fn apply(&mut self, action: Action, seen: u32) -> bool {
        match action {
            Action::Level(level) => self.set_level(level),
            Action::Levels(by) => {
                let now = self.flags.number("level").map_or(seen, |l| l as u32);
                self.set_level(now.saturating_add_signed(by).min(HIGHEST.max(now)));
            }
            Action::Adaptive if self.is_uniform() => self.set_flatness(self.flatness),
            Action::Adaptive => self.set_level(self.level),
            Action::Flatness(finer) => {
                let now = self.flags.number("adaptive");
                let now = now.unwrap_or(self.flatness);
                let next = if self.is_uniform() {
                    now
                } else if finer > 0 {
                    now * 0.5
                } else {
                    now * 2.0
                };
                self.set_flatness(next.clamp(FLATNESS[0], FLATNESS[1]));
            }
            Action::Next(cycle, by) => self.next(cycle, by),
            Action::LimitOrRefined => {
                let refined = self.flags.text("surface") == Some("refined");
                let value = if refined { "limit" } else { "refined" };
                self.set_cycle(Cycle::Surface, value);
            }
            Action::Overlay(layer) => self.toggle_overlay(layer),
            Action::Light(by) => self.turn_light(f64::from(by)),
            _ => return false,
        }
        true
    }

    /// Adds lines to those over the picture, or takes them away.
    fn toggle_overlay(&mut self, layer: &str) {
        let now = self.flags.text("overlay").unwrap_or_default();
        let mut layers: Vec<&str> = now.split(',').filter(|l| !l.is_empty()).collect();
        match layers.iter().position(|l| *l == layer) {
            Some(k) => {
                layers.remove(k);
            }
            None => layers.push(layer),
        }
        let layers = layers.join(",");
        self.flags.set_unless("overlay", &layers, "");
    }

    /// Turns the lights by so many degrees.
    pub(super) fn turn_light(&mut self, degrees: f64) {
        let turn = self.flags.number("light-turn").unwrap_or(0.0) + degrees;
        let turn = turn - 360.0 * libm::round(turn / 360.0);
        // Hundredths, which print short; the sum of a drag keeps them.
        let turn = libm::round(turn * 100.0) / 100.0;
        self.flags.set_unless("light-turn", &turn.to_string(), "0");
    }

    /// What triangles follow, in words.
    #[must_use]
    pub(super) fn fineness(&self) -> String {
        let flags = &self.flags;
        match (flags.text("level"), flags.text("adaptive")) {
            (Some(level), _) => format!("level {level}"),
            (None, Some(pixels)) => format!("adaptive {pixels} px"),
            (None, None) if flags.get("depth-tags").is_some() => "depth tags".into(),
            (None, None) => "adaptive".into(),
        }
    }

    /// The value of a flag that keys step through.
    #[must_use]
    pub(super) fn value(&self, cycle: Cycle) -> &str {
        let (name, values) = cycle.values();
        self.flags.text(name).unwrap_or(values[0])
    }

    fn is_uniform(&self) -> bool {
        self.flags.get("level").is_some()
    }

    fn set_level(&mut self, level: u32) {
        for other in ["adaptive", "depth-tags", "pattern"] {
            self.flags.unset(other);
        }
        self.level = level;
        self.flags.set("level", level.to_string());
    }

    fn set_flatness(&mut self, pixels: f64) {
        for other in ["level", "depth-tags", "pattern"] {
            self.flags.unset(other);
        }
        self.flatness = pixels;
        let given = self.home.get("adaptive").is_some();
        // Said where it is not the default.
        match pixels == PLAIN_FLATNESS && !given {
            true => self.flags.unset("adaptive"),
            false => self.flags.set("adaptive", pixels.to_string()),
        }
    }

    fn next(&mut self, cycle: Cycle, by: i32) {
        let (_, values) = cycle.values();
        let now = self.value(cycle);
        let at = values.iter().position(|v| *v == now).unwrap_or(0);
        let next = (at as i32 + by).rem_euclid(values.len() as i32) as usize;
        self.set_cycle(cycle, values[next]);
    }

    fn set_cycle(&mut self, cycle: Cycle, value: &str) {
        let (name, values) = cycle.values();
        self.flags.set_unless(name, value, values[0]);
        match cycle {
            Cycle::Surface if value != "pn" => self.flags.unset("pn-tags"),
            Cycle::Scheme => {
                let triangles = matches!(value, "loop" | "butterfly");
                let given = self.home.get("triangulate").is_some();
                self.flags.switch("triangulate", triangles || given);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(look: &Look) -> String {
        super::super::flags::shell_line(&look.flags.tokens())
    }

    fn after(given: &[(&str, &str)], actions: &[Action]) -> String {
        let mut flags = Flags::default();
        for (name, value) in given {
            flags.set(name, *value);
        }
        let mut look = Look::new(flags);
        for &a in actions {
            assert!(look.apply(a, 4), "{a:?}");
        }
        tokens(&look)
    }

    #[test]
    fn levels_and_flatness_exclude_each_other() {
        use Action::{Adaptive, Flatness, Level, Levels};
        assert_eq!(after(&[], &[Level(5)]), "--level 5");
        assert_eq!(after(&[], &[Levels(1)]), "--level 5");
        assert_eq!(after(&[], &[Levels(-1)]), "--level 3");
        assert_eq!(after(&[("level", "0")], &[Levels(-1)]), "--level 0");
        assert_eq!(after(&[("level", "9")], &[Levels(1)]), "--level 9");
        assert_eq!(after(&[], &[Adaptive]), "--level 3");
        assert_eq!(after(&[], &[Adaptive, Adaptive]), "");
        assert_eq!(after(&[], &[Flatness(1)]), "--adaptive 0.25");
        assert_eq!(after(&[], &[Flatness(-1), Flatness(-1)]), "--adaptive 2");
        assert_eq!(
            after(&[("adaptive", "0.1")], &[Adaptive, Adaptive]),
            "--adaptive 0.1"
        );
        assert_eq!(
            after(&[("depth-tags", "distance")], &[Level(2)]),
            "--level 2"
        );
        assert_eq!(after(&[], &[Flatness(1); 9]), "--adaptive 0.0625");
    }

    #[test]
    fn lines_are_added_and_taken_away() {
        let [cage, axes] = ["cage", "axes"].map(Action::Overlay);
        assert_eq!(after(&[], &[cage]), "--overlay cage");
        assert_eq!(after(&[], &[cage, axes]), "--overlay cage,axes");
        assert_eq!(after(&[], &[cage, axes, cage]), "--overlay axes");
        assert_eq!(after(&[("overlay", "cage")], &[cage]), "");
    }

    #[test]
    fn values_go_round() {
        use Action::{LimitOrRefined, Next};
        let shade = Next(Cycle::Shade, 1);
        assert_eq!(after(&[], &[shade]), "--shade flat");
        assert_eq!(after(&[], &[shade; 7]), "");
        assert_eq!(after(&[], &[Next(Cycle::Shade, -1)]), "--shade wireframe");
        assert_eq!(after(&[], &[LimitOrRefined]), "--surface refined");
        assert_eq!(after(&[], &[LimitOrRefined, LimitOrRefined]), "");
        let scheme = Next(Cycle::Scheme, 1);
        assert_eq!(after(&[], &[scheme; 2]), "--scheme loop --triangulate");
        assert_eq!(after(&[], &[scheme; 4]), "--scheme kobbelt");
    }

    #[test]
    fn lights_turn() {
        use Action::Light;
        assert_eq!(after(&[], &[Light(15)]), "--light-turn 15");
        assert_eq!(after(&[], &[Light(15), Light(-15)]), "");
        assert_eq!(after(&[], &[Light(100), Light(100)]), "--light-turn=-160");
    }
}
