//! What the window asks of the program: to load models, to draw them, to write pictures. All of it from flags, in threads of its own, and
//! cancellable, so that the window answers whatever goes on.

use super::canvas::Canvas;
use super::flags::Flags;
use super::quality::Draft;
use crate::camera::{Camera, Sphere};
use crate::frame::{FrameStats, Scene};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// The work behind the window.
pub trait Studio: Send + Sync + 'static {
    /// Paths of the models, in the order of the keys; `-` is standard input.
    fn models(&self) -> &[PathBuf];
    /// Reads a model with the flags that it depends on.
    ///
    /// # Errors
    /// What is wrong, in a line.
    fn load(&self, model: usize, flags: &Flags, task: &Task) -> Result<Loaded, String>;
    /// Draws a picture. Called in [`Studio::pool`].
    ///
    /// # Errors
    /// What is wrong, in a line; anything where the order was cancelled.
    fn draw(&self, order: &Order) -> Result<Drawn, String>;
    /// Writes the picture that [`Studio::command`] names with these flags.
    ///
    /// # Errors
    /// What is wrong, in a line.
    fn save(&self, model: usize, flags: &Flags, shown: &Shown, path: &str) -> Result<(), String>;
    /// The line for a shell that writes the same picture to `path`.
    fn command(&self, model: usize, flags: &Flags, path: &str) -> String;
    /// A line for standard output.
    fn print(&self, line: &str);
    /// The threads that pictures are drawn by.
    fn pool(&self) -> &rayon::ThreadPool;
    /// Whether the program has to end: a signal came, or time is up.
    fn ended(&self) -> bool;
}

/// A model that can be drawn.
#[derive(Debug)]
pub struct Loaded {
    /// Its scene.
    pub scene: Scene,
    /// Files that it was made of.
    pub files: Vec<PathBuf>,
}

/// A model with what the camera needs to know of it.
#[derive(Debug)]
pub struct Shown {
    /// Its scene.
    pub scene: Scene,
    /// What a camera frames, where the surface is drawn.
    pub surface: Sphere,
    /// And where the polygons are.
    pub cage: Sphere,
    /// Where its coordinates begin, in model units.
    pub origin: [f64; 3],
}

impl Shown {
    /// Finds what the camera needs.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        use crate::frame::Drawing;
        Self {
            surface: scene.framed_sphere(Drawing::Limit),
            cage: scene.framed_sphere(Drawing::Cage),
            origin: scene.origin(),
            scene,
        }
    }

    /// The sphere that is framed under some flags.
    #[must_use]
    pub fn sphere(&self, flags: &Flags) -> &Sphere {
        match flags.text("surface") {
            Some("cage") => &self.cage,
            _ => &self.surface,
        }
    }
}

/// A picture that is wanted.
#[derive(Debug)]
pub struct Order {
    /// Flags, but for those of the camera.
    pub flags: Flags,
    /// The camera.
    pub camera: Camera,
    /// The number of the model.
    pub model: usize,
    /// The same, loaded.
    pub shown: Arc<Shown>,
    /// Pixels of the window.
    pub size: [u32; 2],
    /// What may be left out.
    pub draft: Draft,
    /// Its place in the ladder.
    pub step: usize,
    /// Colour behind the model where the flags name none.
    pub backdrop: [u8; 4],
    /// Whether stages are timed.
    pub measure: bool,
    /// Set when the picture is no longer wanted.
    pub cancelled: Arc<AtomicBool>,
    /// Which state of the view it shows.
    pub state: u64,
}

/// A picture that was drawn.
#[derive(Debug)]
pub struct Drawn {
    /// The picture; opaque, or over the order's backdrop.
    pub image: crate::film::Image,
    /// What it took.
    pub stats: FrameStats,
}

/// What becomes of an order.
#[derive(Debug)]
pub(super) struct Delivery {
    /// The order.
    pub(super) order: Order,
    /// The window's pixels; what was there before, where something went wrong.
    pub(super) canvas: Canvas,
    /// What the picture took, or what went wrong.
    pub(super) result: Result<FrameStats, String>,
    /// From the beginning of the order to its end.
    pub(super) took: Duration,
}

/// A piece of work in a thread of its own.
#[derive(Clone, Debug)]
pub struct Task {
    /// What it is about.
    pub name: String,
    /// When it began.
    pub begun: Instant,
    /// Set when its result is no longer wanted.
    pub cancelled: Arc<AtomicBool>,
    doing: Arc<Mutex<&'static str>>,
}

impl Task {
    /// Begins now.
    #[must_use]
    pub fn new(name: String) -> Self {
        Self {
            name,
            begun: Instant::now(),
            cancelled: Arc::default(),
            doing: Arc::default(),
        }
    }
    /// Says what is being done.
    pub fn say(&self, what: &'static str) {
        if let Ok(mut doing) = self.doing.lock() {
            *doing = what;
        }
    }
    /// What is being done.
    #[must_use]
    pub fn doing(&self) -> &'static str {
        self.doing.lock().map_or("", |d| *d)
    }
    /// Its result is no longer wanted.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// What threads tell the window.
#[derive(Debug)]
pub(super) enum News {
    Drawn(Box<Delivery>),
    Loaded {
        number: u64,
        result: Result<(Arc<Shown>, Vec<PathBuf>), String>,
    },
    Saved {
        path: String,
        result: Result<(), String>,
    },
}

/// What a panic in the program's own work is called.
fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err("internal error, please report it".into()))
}

/// Starts the thread that draws: one order after the other.
pub(super) fn start_drawing(
    studio: Arc<dyn Studio>,
    news: Sender<News>,
) -> std::io::Result<Sender<(Order, Canvas)>> {
    let (orders, inbox) = std::sync::mpsc::channel::<(Order, Canvas)>();
    std::thread::Builder::new()
        .name("draw".into())
        .spawn(move || {
            while let Ok((order, mut canvas)) = inbox.recv() {
                let begin = Instant::now();
                let work = || {
                    let drawn = studio.draw(&order)?;
                    canvas.fit(&drawn.image, order.size);
                    Ok(drawn.stats)
                };
                let result = guarded(|| studio.pool().install(work));
                let delivery = Delivery {
                    canvas,
                    result,
                    order,
                    took: begin.elapsed(),
                };
                if news.send(News::Drawn(Box::new(delivery))).is_err() {
                    break;
                }
            }
        })?;
    Ok(orders)
}

/// Starts a thread that loads a model; `number` tells its result from those of others.
pub(super) fn start_loading(
    studio: Arc<dyn Studio>,
    news: Sender<News>,
    (model, flags): (usize, Flags),
    (number, task): (u64, Task),
) -> std::io::Result<()> {
    std::thread::Builder::new()
        .name("load".into())
        .spawn(move || {
            let result = guarded(|| {
                let loaded = studio.load(model, &flags, &task)?;
                task.say("measuring");
                Ok((Arc::new(Shown::new(loaded.scene)), loaded.files))
            });
            // Nobody listens any more where the window is closed.
            let _ = news.send(News::Loaded { number, result });
        })?;
    Ok(())
}

/// Starts a thread that writes a picture.
pub(super) fn start_saving(
    studio: Arc<dyn Studio>,
    news: Sender<News>,
    (model, flags): (usize, Flags),
    (shown, path): (Arc<Shown>, String),
) -> std::io::Result<()> {
    std::thread::Builder::new()
        .name("save".into())
        .spawn(move || {
            let result = guarded(|| studio.save(model, &flags, &shown, &path));
            let _ = news.send(News::Saved { path, result });
        })?;
    Ok(())
}
