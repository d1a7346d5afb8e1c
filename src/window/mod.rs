//! The preview window: orbit, pan and zoom around a model while it is being made. Needs the feature `window`.
//!
//! ```text
//! screen (minifb) ─▶ events ─▶ app ─▶ orders ─▶ thread that draws ─▶ pixels ─▶ app ─▶ panels ─▶ screen
//! ```
//!
//! The state of the view is the flags of the command line that draws it ([`Flags`]), so the command that is printed draws what is seen. While
//! something moves, pictures are drawn as good as 16 ms allow (`quality`); when it stands still, in full. Loading and drawing have threads
//! of their own, so the window answers whatever goes on. What is loaded, drawn and written is the program's matter ([`Studio`]).
//!
//! # Keys
//!
//! | | keys | |
//! |---|---|---|
//! | View | `left drag` | orbit; wheel across turns too |
//! | View | `middle or Shift+left drag` | pan |
//! | View | `wheel` | zoom at the pointer |
//! | View | `right or Ctrl+left drag` | turn the light |
//! | View | `[ ]` | turn the light by 15 degrees |
//! | View | `F5 F6 F7 F8` | front, right, top, three-quarter |
//! | View | `O` | parallel projection |
//! | View | `T` | turntable |
//! | View | `Enter` | camera as at the beginning |
//! | Surface | `0 - 9` | uniform level |
//! | Surface | `+ -` | level up, down |
//! | Surface | `A` | adaptive or uniform |
//! | Surface | `, .` | adaptive: coarser, finer |
//! | Surface | `L` | limit or refined |
//! | Surface | `V` | limit, refined, cage, qas, pn |
//! | Surface | `N` | next scheme |
//! | Picture | `C` | next shading |
//! | Picture | `W G P X` | lines: tessellation, cage, patches, axes |
//! | Picture | `E K M` | lines: creases, boundaries, valences |
//! | Picture | `B` | dark or light window |
//! | Picture | `S  F12` | save the picture |
//! | Picture | `?` | print its command line |
//! | Window | `Left Right` | previous, next model |
//! | Window | `Up  R` | read the files again |
//! | Window | `I` | figures: some, all, none |
//! | Window | `H  F1` | this sheet |
//! | Window | `Esc  Q` | quit |

mod app;
mod canvas;
mod changes;
mod figures;
mod flags;
mod hud;
mod input;
mod keys;
mod look;
mod orbit;
mod quality;
mod screen;
mod studio;

pub use app::Start;
pub use flags::{Flags, shell_line};
pub use quality::Draft;
pub use studio::{Drawn, Loaded, Order, Shown, Studio, Task};

use app::App;
use screen::Screen;
use std::sync::Arc;
use std::time::Instant;

/// Why there is no window.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WindowError {
    /// There is no display, or it gives no window.
    #[error("no window can be opened here ({0})")]
    Display(String),
    /// A thread cannot be started, or ended by itself.
    #[error("a thread of the window is not running")]
    Thread,
}

/// Opens a window and keeps it until it is closed. Belongs on the main thread of the program.
///
/// # Errors
/// [`WindowError`].
pub fn run(studio: Arc<dyn Studio>, start: &Start) -> Result<(), WindowError> {
    // The window first: without one nothing has to be loaded.
    let name = studio.models().first().map(|m| m.to_string_lossy());
    let mut screen = Screen::open(&name.unwrap_or_default(), start.size)?;
    let app = App::new(studio, start, screen::LOSES_RELEASES);
    let mut app = app.map_err(|_| WindowError::Thread)?;
    let mut title = String::new();
    while !app.is_done() {
        for event in screen.events() {
            app.event(event, Instant::now());
        }
        app.tick(Instant::now())?;
        if app.title() != title {
            title = app.title();
            screen.set_title(&title);
        }
        if let Some(canvas) = app.frame(Instant::now()) {
            screen.present(canvas)?;
        }
        app.wait(app.rest(Instant::now()));
    }
    Ok(())
}
