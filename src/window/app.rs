//! The view between input and pictures: takes events and news of its threads, orders pictures, and puts together what the window shows. It
//! knows no window, so tests play it through.

mod actions;
mod compose;

use super::WindowError;
use super::canvas::Canvas;
use super::changes::{Changes, Mark};
use super::figures::Clock;
use super::flags::Flags;
use super::hud::{Content, Panel, Theme};
use super::input::{Drag, Drags, Pointer};
use super::keys::{self, Press};
use super::look::Look;
use super::orbit::{Orbit, Pose};
use super::quality::{LADDER, Quality};
use super::studio::{Delivery, News, Order, Shown, Studio, Task, start_drawing};
use crate::camera::Camera;
use crate::frame::FrameStats;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// What happens to a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Event {
    /// The pointer is elsewhere, or buttons are held otherwise.
    Pointer(Pointer),
    /// The wheel was turned by so many notches across and away from the user.
    Wheel([f64; 2]),
    /// A key was pressed.
    Press(Press),
    /// The window has another size in pixels.
    Size([u32; 2]),
    /// The window is closed.
    Close,
}

/// Longest time that a picture takes while something moves.
const BUDGET: Duration = Duration::from_millis(16);
/// How long after the last movement the picture is drawn in full.
const STILL: Duration = Duration::from_millis(120);
/// How long a message stands.
const MESSAGE: Duration = Duration::from_secs(4);
/// When loading begins to be shown.
const PATIENCE: Duration = Duration::from_millis(150);
/// How long a picture takes before it is said that it is being drawn.
const LONG: Duration = Duration::from_millis(600);
/// How often progress is drawn.
const PROGRESS: Duration = Duration::from_millis(40);
/// Degrees of the turntable in a second.
const TURNTABLE: f64 = 30.0;
/// Degrees that a notch of the wheel across turns by.
const ACROSS: f64 = 7.5;

/// How the view begins.
#[derive(Clone, Debug)]
pub struct Start {
    /// The flags, but for those of the camera and of the size.
    pub flags: Flags,
    /// The camera.
    pub camera: Camera,
    /// Size of the window in pixels.
    pub size: [u32; 2],
}

/// A model that is being loaded.
#[derive(Debug)]
struct Loading {
    task: Task,
    number: u64,
    model: usize,
    /// The flags that the view will have.
    look: Look,
    /// Its file, as it was before it was read.
    file: (PathBuf, Mark),
}

/// A picture that is being drawn.
#[derive(Debug)]
struct Drawing {
    begun: Instant,
    step: usize,
    cancelled: Arc<AtomicBool>,
}

/// The view.
pub(super) struct App {
    studio: Arc<dyn Studio>,
    news: Receiver<News>,
    sender: Sender<News>,
    orders: Sender<(Order, Canvas)>,

    size: [u32; 2],
    orbit: Orbit,
    look: Look,
    drags: Drags,
    pointer: Pointer,
    theme: Theme,
    help: Option<Content>,
    figures: u32,
    turning: Option<Instant>,
    done: bool,
    /// Paths of pictures that are being written.
    saving: Vec<String>,

    model: usize,
    shown: Option<Arc<Shown>>,
    loading: Option<Loading>,
    loads: u64,
    changes: Changes,
    /// Why the files that are watched could not be loaded, until they can.
    broken: Option<String>,
    /// Why a picture could not be drawn or written.
    fault: Option<String>,
    message: Option<(String, Instant)>,

    /// Counts changes of what is to be seen.
    state: u64,
    drawn: Option<(u64, usize)>,
    drawing: Option<Drawing>,
    quality: Quality,
    moved: Option<Instant>,
    picture: Canvas,
    /// The model that it shows.
    pictured: usize,
    spare: Canvas,
    stats: FrameStats,
    clock: Clock,

    window: Canvas,
    panels: [Panel; 4],
    stale: bool,
    presented: Option<Instant>,
}

impl App {
    pub(super) fn new(
        studio: Arc<dyn Studio>,
        start: &Start,
        ends_outside: bool,
    ) -> std::io::Result<Self> {
        let (sender, news) = channel();
        let orders = start_drawing(Arc::clone(&studio), sender.clone())?;
        let mut app = Self {
            studio,
            news,
            sender,
            orders,
            size: start.size,
            orbit: Orbit::new(start.camera),
            look: Look::new(start.flags.clone()),
            drags: Drags::new(ends_outside),
            pointer: Pointer::default(),
            theme: Theme::DARK,
            help: None,
            figures: 1,
            turning: None,
            done: false,
            saving: Vec::new(),
            model: 0,
            shown: None,
            loading: None,
            loads: 0,
            changes: Changes::default(),
            broken: None,
            fault: None,
            message: None,
            state: 0,
            drawn: None,
            drawing: None,
            quality: Quality::new(BUDGET),
            moved: None,
            picture: Canvas::default(),
            pictured: 0,
            spare: Canvas::default(),
            stats: FrameStats::default(),
            clock: Clock::default(),
            window: Canvas::default(),
            panels: Default::default(),
            stale: true,
            presented: None,
        };
        let look = app.look.clone();
        app.load(0, look);
        Ok(app)
    }

    /// Whether the window is to be closed; what is being written is written first.
    pub(super) fn is_done(&self) -> bool {
        self.studio.ended() || self.done && self.saving.is_empty()
    }

    /// What the window is called.
    pub(super) fn title(&self) -> String {
        format!("{} - earmark", self.name(self.model))
    }

    /// The flags of the picture as it is: what `render` would be given.
    pub(super) fn flags(&self) -> Flags {
        let mut flags = self.look.flags.clone();
        flags.set_camera(&self.orbit.camera());
        let [width, height] = self.size;
        flags.set("size", format!("{width}x{height}"));
        flags
    }

    fn name(&self, model: usize) -> String {
        let models = self.studio.models();
        let path = models.get(model).map_or(Path::new(""), PathBuf::as_path);
        if path.as_os_str() == "-" {
            return "standard input".into();
        }
        let last = path.file_name().unwrap_or(path.as_os_str());
        last.to_string_lossy().into_owned()
    }

    /// What is to be seen is another: what is being drawn is out of date.
    fn change(&mut self) {
        self.state += 1;
        self.stale = true;
        // A full picture of something that moves comes too late.
        if let Some(drawing) = &self.drawing
            && drawing.step == 0
            && self.quality.is_slow(0)
        {
            drawing.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// The same by a movement: drafts will do until it ends.
    fn movement(&mut self, now: Instant) {
        self.moved = Some(now);
        self.change();
    }

    fn is_moving(&self, now: Instant) -> bool {
        self.turning.is_some() || self.moved.is_some_and(|m| now < m + STILL)
    }

    fn say(&mut self, message: String, now: Instant) {
        self.message = Some((message, now));
        self.stale = true;
    }

    fn pose(&self) -> Option<Pose> {
        let shown = self.shown.as_ref()?;
        let sphere = shown.sphere(&self.look.flags);
        Pose::new(&self.orbit.camera(), sphere, shown.origin, self.size).ok()
    }

    /// Takes in an event.
    pub(super) fn event(&mut self, event: Event, now: Instant) {
        match event {
            Event::Close => self.done = true,
            Event::Size(size) if size != self.size && !size.contains(&0) => {
                self.size = size;
                self.movement(now);
            }
            Event::Size(_) => {}
            Event::Pointer(pointer) => {
                self.pointer = pointer;
                let dragged = self.drags.see(pointer, self.size);
                if let Some(dragged) = dragged
                    && let Some(pose) = self.pose()
                {
                    match dragged.drag {
                        Drag::Orbit => self.orbit.drag(dragged.by, &pose),
                        Drag::Pan => self.orbit.pan(dragged.by, &pose),
                        Drag::Light => {
                            let side = f64::from(self.size[0].min(self.size[1]));
                            let degrees = dragged.by[0] * 180.0 / side;
                            self.look.turn_light(degrees);
                            if let Some(loading) = &mut self.loading {
                                loading.look.turn_light(degrees);
                            }
                        }
                    }
                    self.movement(now);
                }
            }
            Event::Wheel([across, away]) => {
                let Some(pose) = self.pose() else { return };
                if away != 0.0 {
                    self.orbit.zoom(away, self.pointer.at, &pose);
                }
                if across != 0.0 {
                    self.orbit.turn([across * ACROSS, 0.0], &pose);
                }
                self.movement(now);
            }
            Event::Press(press) => {
                if let Some(action) = keys::action(press) {
                    self.act(action, now);
                }
            }
        }
    }

    /// Waits for news, at most for a time, and takes in all there are.
    pub(super) fn wait(&mut self, rest: Duration) {
        let mut next = self.news.recv_timeout(rest).ok();
        while let Some(news) = next {
            self.take_news(news, Instant::now());
            next = self.news.try_recv().ok();
        }
    }

    fn take_news(&mut self, news: News, now: Instant) {
        match news {
            News::Drawn(delivery) => self.delivered(*delivery, now),
            News::Loaded { number, result } => {
                if let Some(loading) = self.loading.take_if(|l| l.number == number) {
                    self.loaded(loading, result, now);
                }
            }
            News::Saved { path, result } => {
                self.saving.retain(|p| *p != path);
                self.stale = true;
                match result {
                    Ok(()) => self.say(format!("written: {path}"), now),
                    Err(why) => self.fault = Some(why),
                }
            }
        }
    }

    fn delivered(&mut self, delivery: Delivery, now: Instant) {
        self.drawing = None;
        let Delivery {
            order,
            canvas,
            result,
            took,
        } = delivery;
        match result {
            Ok(stats) => {
                self.spare = std::mem::replace(&mut self.picture, canvas);
                self.stats = stats;
                // What another model took says nothing of this one.
                if self
                    .shown
                    .as_ref()
                    .is_some_and(|s| Arc::ptr_eq(s, &order.shown))
                {
                    self.quality.drawn(order.step, took);
                }
                self.drawn = Some((order.state, order.step));
                self.pictured = order.model;
                self.clock.drawn(now, took, order.step);
                self.stale = true;
            }
            Err(_) if order.cancelled.load(Ordering::Relaxed) => self.spare = canvas,
            Err(why) => {
                self.spare = canvas;
                self.fault = Some(why);
                // Not again before something changes.
                self.drawn = Some((order.state, 0));
                self.stale = true;
            }
        }
    }

    /// What has to be done by itself: turning, looking at files, ordering pictures.
    ///
    /// # Errors
    /// [`WindowError::Thread`] where nobody draws any more.
    pub(super) fn tick(&mut self, now: Instant) -> Result<(), WindowError> {
        if let Some(last) = self.turning
            && self.drawing.is_none()
            && let Some(pose) = self.pose()
        {
            let degrees = (now - last).as_secs_f64() * TURNTABLE;
            self.orbit.turn([degrees, 0.0], &pose);
            self.turning = Some(now);
            self.movement(now);
        }
        if self.loading.is_none() && self.changes.seen(now) {
            let look = self.look.clone();
            self.load(self.model, look);
        }
        if self
            .message
            .as_ref()
            .is_some_and(|(_, at)| now > *at + MESSAGE)
        {
            self.message = None;
            self.stale = true;
        }
        let loading = self.loading.as_ref().map(|l| l.task.begun + PATIENCE);
        let drawing = self.drawing.as_ref().map(|d| d.begun + LONG);
        if loading.into_iter().chain(drawing).any(|from| now > from)
            && self.presented.is_none_or(|p| now > p + PROGRESS)
        {
            self.stale = true;
        }
        self.order(now)
    }

    /// Orders the next picture where one is missing.
    fn order(&mut self, now: Instant) -> Result<(), WindowError> {
        let Some(shown) = &self.shown else {
            return Ok(());
        };
        let moving = self.is_moving(now);
        let up_to_date = self
            .drawn
            .is_some_and(|(state, step)| state == self.state && (step == 0 || moving));
        if up_to_date || self.drawing.is_some() {
            return Ok(());
        }
        let step = if moving { self.quality.next() } else { 0 };
        let order = Order {
            flags: self.look.flags.clone(),
            camera: self.orbit.camera(),
            model: self.model,
            shown: Arc::clone(shown),
            size: self.size,
            draft: LADDER[step],
            step,
            backdrop: self.theme.backdrop,
            measure: self.figures == 2,
            cancelled: Arc::default(),
            state: self.state,
        };
        self.drawing = Some(Drawing {
            begun: now,
            step,
            cancelled: Arc::clone(&order.cancelled),
        });
        let spare = std::mem::take(&mut self.spare);
        let sent = self.orders.send((order, spare));
        sent.map_err(|_| WindowError::Thread)
    }

    /// How long the window may rest before it looks for input again: each look is a question to the display and its answer.
    pub(super) fn rest(&self, now: Instant) -> Duration {
        let since = self.moved.map(|moved| now.saturating_duration_since(moved));
        Duration::from_millis(match since.map(|s| s.as_secs()) {
            _ if self.drags.is_on() || self.turning.is_some() => 1,
            Some(0..2) => 2,
            Some(2..30) => 4,
            _ => 8,
        })
    }
}

impl Drop for App {
    /// Threads that still work are told that nobody waits.
    fn drop(&mut self) {
        if let Some(loading) = &self.loading {
            loading.task.cancel();
        }
        if let Some(drawing) = &self.drawing {
            drawing.cancelled.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests;
