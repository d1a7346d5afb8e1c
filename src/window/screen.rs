//! The window itself. The only file that names minifb.

use super::WindowError;
use super::app::Event;
use super::canvas::Canvas;
use super::input::Pointer;
use super::keys::Press;
use minifb::{InputCallback, Key, MouseButton, MouseMode, ScaleMode, Window, WindowOptions};
use std::cell::RefCell;
use std::rc::Rc;

/// Keys and characters in the order in which they came, however fast they were: samples of what is down would miss some.
#[derive(Debug, Default)]
struct Typed(Rc<RefCell<Vec<Press>>>, [bool; 2]);

impl Typed {
    fn push(&self, press: Press) {
        if let Ok(mut typed) = self.0.try_borrow_mut() {
            typed.push(press);
        }
    }
}

impl InputCallback for Typed {
    fn add_char(&mut self, code: u32) {
        let Some(c) = char::from_u32(code).filter(|c| !c.is_control()) else {
            return;
        };
        let shift = self.1.contains(&true);
        let small = c.to_lowercase().next().unwrap_or(c);
        self.push(match c.is_alphabetic() {
            true if shift => Press::Shift(small),
            true => Press::Char(small),
            false => Press::Char(c),
        });
    }

    fn set_key_state(&mut self, key: Key, down: bool) {
        match key {
            Key::LeftShift => self.1[0] = down,
            Key::RightShift => self.1[1] = down,
            _ => {}
        }
        if let Some(press) = named(key).filter(|_| down) {
            self.push(press);
        }
    }
}

/// Keys that write nothing.
fn named(key: Key) -> Option<Press> {
    Some(match key {
        Key::Left => Press::Left,
        Key::Right => Press::Right,
        Key::Up => Press::Up,
        Key::Enter | Key::NumPadEnter => Press::Enter,
        Key::Escape => Press::Escape,
        Key::F1 => Press::F(1),
        Key::F2 => Press::F(2),
        Key::F3 => Press::F(3),
        Key::F4 => Press::F(4),
        Key::F5 => Press::F(5),
        Key::F6 => Press::F(6),
        Key::F7 => Press::F(7),
        Key::F8 => Press::F(8),
        Key::F9 => Press::F(9),
        Key::F10 => Press::F(10),
        Key::F11 => Press::F(11),
        Key::F12 => Press::F(12),
        _ => return None,
    })
}

/// Whether a button that is released outside of the window is never heard of: there is no capture of the pointer.
pub(super) const LOSES_RELEASES: bool = cfg!(windows);

/// What a notch of the wheel is called, away from the user: the systems' units differ. X11's wheel is a button, and the library counts it
/// when it goes down and when it comes up.
fn notch() -> f64 {
    if cfg!(windows) {
        12.0
    } else if cfg!(target_os = "linux") && std::env::var_os("WAYLAND_DISPLAY").is_some() {
        -10.0
    } else if cfg!(target_os = "macos") {
        1.0
    } else {
        2.0
    }
}

/// An open window.
#[derive(Debug)]
pub(super) struct Screen {
    window: Window,
    typed: Rc<RefCell<Vec<Press>>>,
    notch: f64,
    size: [u32; 2],
    pointer: Option<Pointer>,
    events: Vec<Event>,
}

impl Screen {
    pub(super) fn open(title: &str, size: [u32; 2]) -> Result<Self, WindowError> {
        let options = WindowOptions {
            resize: true,
            scale_mode: ScaleMode::UpperLeft,
            ..WindowOptions::default()
        };
        let [width, height] = size.map(|s| s as usize);
        let window = Window::new(&printable(title), width, height, options);
        let mut window = window.map_err(|e| WindowError::Display(e.to_string()))?;
        let typed = Typed::default();
        let list = Rc::clone(&typed.0);
        window.set_input_callback(Box::new(typed));
        // The loop of the program has its own clock.
        window.set_target_fps(0);
        Ok(Self {
            window,
            typed: list,
            notch: notch(),
            size: [0; 2],
            pointer: None,
            events: Vec::new(),
        })
    }

    pub(super) fn set_title(&mut self, title: &str) {
        self.window.set_title(&printable(title));
    }

    /// What happened since the last time.
    pub(super) fn events(&mut self) -> Vec<Event> {
        self.window.update();
        self.collect();
        std::mem::take(&mut self.events)
    }

    /// Shows pixels. What happens meanwhile is kept for [`Screen::events`].
    pub(super) fn present(&mut self, canvas: &Canvas) -> Result<(), WindowError> {
        let [width, height] = canvas.size.map(|s| s as usize);
        self.window
            .update_with_buffer(&canvas.pixels, width, height)
            .map_err(|e| WindowError::Display(e.to_string()))?;
        self.collect();
        Ok(())
    }

    /// Takes what the last update of the window brought.
    fn collect(&mut self) {
        let (width, height) = self.window.get_size();
        let side = |s: usize| u32::try_from(s).unwrap_or(u32::MAX);
        let size = [side(width), side(height)];
        if size != self.size {
            self.size = size;
            self.events.push(Event::Size(size));
        }
        if let Some((x, y)) = self.window.get_unscaled_mouse_pos(MouseMode::Pass) {
            let keys = self.window.get_keys();
            let down = |pair: [Key; 2]| pair.iter().any(|k| keys.contains(k));
            let buttons = [MouseButton::Left, MouseButton::Middle, MouseButton::Right];
            let pointer = Pointer {
                at: [f64::from(x), f64::from(y)],
                buttons: buttons.map(|b| self.window.get_mouse_down(b)),
                shift: down([Key::LeftShift, Key::RightShift]),
                control: down([Key::LeftCtrl, Key::RightCtrl]),
            };
            if self.pointer != Some(pointer) {
                self.pointer = Some(pointer);
                self.events.push(Event::Pointer(pointer));
            }
        }
        if let Some((x, y)) = self.window.get_scroll_wheel() {
            let notches = [x, y].map(|s| f64::from(s) / self.notch);
            self.events.push(Event::Wheel(notches));
        }
        let typed = std::mem::take(&mut *self.typed.borrow_mut());
        self.events.extend(typed.into_iter().map(Event::Press));
        if !self.window.is_open() {
            self.events.push(Event::Close);
        }
    }
}

/// Titles end at a zero byte, and the library says so on standard output.
fn printable(title: &str) -> String {
    title.chars().filter(|c| !c.is_control()).collect()
}
