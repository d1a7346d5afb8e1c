//! Raw input to gestures. The screen says what it sees now; differences, drags and their ends are found here.

/// Where the pointer is and what is held, at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pointer {
    /// Pixels from the left and from the top of the window; outside of it too.
    pub(super) at: [f64; 2],
    /// Left, middle and right button.
    pub(super) buttons: [bool; 3],
    /// A shift key.
    pub(super) shift: bool,
    /// A control key.
    pub(super) control: bool,
}

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drag {
    /// Turns the camera.
    Orbit,
    /// Moves the model.
    Pan,
    /// Turns the lights.
    Light,
}

/// A drag that goes on: its kind, and pixels to the right and down since the last moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dragged {
    /// What it does.
    pub(super) drag: Drag,
    /// How far.
    pub(super) by: [f64; 2],
}

/// The drag that is going on, if any.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drags {
    last: Option<Pointer>,
    held: Option<(Drag, usize)>,
    /// Releases outside of the window are not told, so that leaving it ends a drag.
    ends_outside: bool,
}

impl Drags {
    /// No drag. Where the system does not tell of buttons that are released outside of the window, `ends_outside`: a drag then ends where
    /// the pointer leaves the window, because it would never end otherwise.
    #[must_use]
    pub(super) fn new(ends_outside: bool) -> Self {
        Self {
            ends_outside,
            ..Self::default()
        }
    }

    /// Whether a drag goes on.
    #[must_use]
    pub(super) fn is_on(&self) -> bool {
        self.held.is_some()
    }

    /// Takes in the pointer of a moment, in a window of `size` pixels.
    ///
    /// A drag begins where the pointer was before the button was seen to be down, and what it moved until the button is seen to be up
    /// counts: between two moments both may happen.
    pub(super) fn see(&mut self, now: Pointer, size: [u32; 2]) -> Option<Dragged> {
        let last = self.last.replace(now).unwrap_or(now);
        if self.held.is_none() {
            self.held = began(&last, &now);
            // A button that was down before it came into the window drags nothing.
            if !is_inside(last.at, size) {
                self.held = None;
            }
        }
        let (drag, button) = self.held?;
        if !now.buttons[button] || self.ends_outside && !is_inside(now.at, size) {
            self.held = None;
        }
        let by = [now.at[0] - last.at[0], now.at[1] - last.at[1]];
        (by != [0.0; 2]).then_some(Dragged { drag, by })
    }
}

/// The drag of a button that is down now and was not before.
fn began(last: &Pointer, now: &Pointer) -> Option<(Drag, usize)> {
    let pressed = |b: usize| now.buttons[b] && !last.buttons[b];
    let button = (0..3).find(|&b| pressed(b))?;
    let drag = match button {
        0 if now.shift => Drag::Pan,
        0 if now.control => Drag::Light,
        0 => Drag::Orbit,
        1 => Drag::Pan,
        _ => Drag::Light,
    };
    Some((drag, button))
}

fn is_inside(at: [f64; 2], size: [u32; 2]) -> bool {
    (0..2).all(|k| at[k] >= 0.0 && at[k] < f64::from(size[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [100, 80];

    fn at(x: f64, y: f64, left: bool) -> Pointer {
        Pointer {
            at: [x, y],
            buttons: [left, false, false],
            ..Pointer::default()
        }
    }

    fn moved(drags: &mut Drags, moments: &[Pointer]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for &m in moments {
            if let Some(d) = drags.see(m, SIZE) {
                sum = [sum[0] + d.by[0], sum[1] + d.by[1]];
            }
        }
        sum
    }

    #[test]
    fn a_drag_is_what_lies_between_press_and_release() {
        let mut drags = Drags::new(false);
        let path = [
            at(5.0, 5.0, false),
            at(10.0, 10.0, false),
            // Pressed and moved between two moments.
            at(15.0, 12.0, true),
            at(40.0, 30.0, true),
            // Moved and released between two moments.
            at(42.0, 31.0, false),
            at(90.0, 70.0, false),
        ];
        assert_eq!(moved(&mut drags, &path), [32.0, 21.0]);
        assert!(!drags.is_on());
    }

    #[test]
    fn a_drag_goes_on_outside_and_ends_there() {
        let path = [
            at(50.0, 50.0, false),
            at(50.0, 50.0, true),
            at(150.0, 50.0, true),
            at(250.0, -50.0, true),
            at(250.0, -50.0, false),
            at(50.0, 50.0, false),
        ];
        assert_eq!(moved(&mut Drags::new(false), &path), [200.0, -100.0]);
        // Where releases outside are lost, the pointer comes back with the button seemingly down.
        let mut lost = path;
        lost[4].buttons[0] = true;
        lost[5].buttons[0] = true;
        let mut drags = Drags::new(true);
        assert_eq!(moved(&mut drags, &lost), [100.0, 0.0]);
        assert!(!drags.is_on());
    }

    #[test]
    fn buttons_and_keys_choose_the_drag() {
        let drag = |button: usize, shift: bool, control: bool| {
            let mut drags = Drags::new(false);
            drags.see(at(1.0, 1.0, false), SIZE);
            let mut p = at(2.0, 1.0, false);
            p.buttons[button] = true;
            (p.shift, p.control) = (shift, control);
            drags.see(p, SIZE).unwrap().drag
        };
        assert_eq!(drag(0, false, false), Drag::Orbit);
        assert_eq!(drag(0, true, false), Drag::Pan);
        assert_eq!(drag(0, false, true), Drag::Light);
        assert_eq!(drag(1, false, false), Drag::Pan);
        assert_eq!(drag(2, false, false), Drag::Light);
    }

    #[test]
    fn a_button_that_is_down_already_drags_nothing() {
        let mut drags = Drags::new(false);
        let path = [
            at(-5.0, 5.0, false),
            at(5.0, 5.0, true),
            at(50.0, 5.0, true),
        ];
        assert_eq!(moved(&mut drags, &path), [0.0; 2]);
    }
}
