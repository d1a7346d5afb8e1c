//! The view played through without a window, with a program that draws in no time, or as long as it is told to.

use super::*;
use crate::film::Image;
use crate::frame::Scene;
use crate::mesh::Cage;
use crate::surface::Surface;
use crate::window::studio::{Drawn, Loaded};
use std::sync::Mutex;
use std::sync::atomic::AtomicU64;

/// What was asked for: flags as text, azimuth, place in the ladder.
type Asked = (String, f64, usize);

struct Fake {
    models: Vec<PathBuf>,
    pool: rayon::ThreadPool,
    drawn: Mutex<Vec<Asked>>,
    cancelled: AtomicU64,
    printed: Mutex<Vec<String>>,
    /// Milliseconds of a full picture.
    slow: AtomicU64,
    /// Nothing is loaded as long as it is set.
    held: AtomicBool,
    broken: AtomicBool,
    /// Nothing is written as long as it is set.
    writes_held: AtomicBool,
}

fn scene() -> Scene {
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let points = points.map(|[x, y]| [x, y, 0.0]).to_vec();
    let cage = Cage::new(points, &[4], vec![0, 1, 2, 3]).unwrap();
    Scene::of(Surface::new(cage, &Default::default()))
}

fn sleep(ms: u64) {
    std::thread::sleep(Duration::from_millis(ms));
}

impl Studio for Fake {
    fn models(&self) -> &[PathBuf] {
        &self.models
    }
    fn load(&self, _: usize, _: &Flags, task: &Task) -> Result<Loaded, String> {
        task.say("reading");
        while self.held.load(Ordering::Relaxed) {
            sleep(1);
        }
        if self.broken.load(Ordering::Relaxed) {
            return Err("a.obj:3: broken".into());
        }
        let files = Vec::new();
        Ok(Loaded {
            scene: scene(),
            files,
        })
    }
    fn draw(&self, order: &Order) -> Result<Drawn, String> {
        let begin = Instant::now();
        let slow = Duration::from_millis(self.slow.load(Ordering::Relaxed));
        while order.step == 0 && begin.elapsed() < slow {
            if order.cancelled.load(Ordering::Relaxed) {
                self.cancelled.fetch_add(1, Ordering::Relaxed);
                return Err("cancelled".into());
            }
            sleep(1);
        }
        let flags = crate::window::shell_line(&order.flags.tokens());
        let asked = (flags, order.camera.azimuth, order.step);
        self.drawn.lock().unwrap().push(asked);
        let [width, height] = order.draft.size(order.size);
        Ok(Drawn {
            image: Image {
                data: [200, 100, 50, 255].repeat((width * height) as usize),
                width,
                height,
            },
            stats: FrameStats::default(),
        })
    }
    fn save(&self, _: usize, _: &Flags, _: &Shown, path: &str) -> Result<(), String> {
        while self.writes_held.load(Ordering::Relaxed) {
            sleep(1);
        }
        self.print(&format!("saved {path}"));
        Ok(())
    }
    fn command(&self, model: usize, flags: &Flags, path: &str) -> String {
        let flags = crate::window::shell_line(&flags.tokens());
        format!("draw {} {path} {flags}", self.models[model].display())
    }
    fn print(&self, line: &str) {
        self.printed.lock().unwrap().push(line.to_owned());
    }
    fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }
    fn ended(&self) -> bool {
        false
    }
}

const SIZE: [u32; 2] = [320, 200];

fn open() -> (Arc<Fake>, App) {
    let fake = Arc::new(Fake {
        models: vec!["no/such/folder/a.obj".into(), "b.obj".into()],
        pool: rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap(),
        drawn: Mutex::default(),
        cancelled: AtomicU64::new(0),
        printed: Mutex::default(),
        slow: AtomicU64::new(0),
        held: AtomicBool::new(false),
        broken: AtomicBool::new(false),
        writes_held: AtomicBool::new(false),
    });
    let start = Start {
        flags: Flags::default(),
        camera: Camera::default(),
        size: SIZE,
    };
    let studio: Arc<dyn Studio> = fake.clone();
    let app = App::new(studio, &start, false).unwrap();
    (fake, app)
}

/// Lets time pass until something holds.
fn until(app: &mut App, holds: impl FnMut(&App) -> bool) {
    until_by(app, Instant::now, holds);
}

/// Lets threads work until something holds, while the view's clock says what it is told to.
fn until_by(app: &mut App, now: impl Fn() -> Instant, mut holds: impl FnMut(&App) -> bool) {
    let begin = Instant::now();
    while !holds(app) {
        assert!(begin.elapsed() < Duration::from_secs(20), "it never holds");
        app.tick(now()).unwrap();
        app.frame(now());
        app.wait(Duration::from_millis(1));
    }
}

/// The last picture is full and shows what is wanted.
fn rests(app: &App) -> bool {
    app.drawn == Some((app.state, 0)) && app.drawing.is_none() && app.loading.is_none()
}

fn press(app: &mut App, press: Press) {
    app.event(Event::Press(press), Instant::now());
}

fn point(app: &mut App, x: f64, y: f64, left: bool) {
    point_at(app, [x, y], left, Instant::now());
}

fn point_at(app: &mut App, at: [f64; 2], left: bool, now: Instant) {
    let pointer = Pointer {
        at,
        buttons: [left, false, false],
        ..Pointer::default()
    };
    app.event(Event::Pointer(pointer), now);
}

#[test]
fn drags_are_drawn_and_end_in_a_full_picture() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    assert_eq!(app.picture.size, SIZE);
    // Full pictures are slow, so drafts are drawn while the mouse moves.
    fake.slow.store(60, Ordering::Relaxed);
    press(&mut app, Press::Char('o'));
    until(&mut app, rests);
    let now = Instant::now();
    point_at(&mut app, [100.0, 100.0], false, now);
    let before = fake.drawn.lock().unwrap().len();
    point_at(&mut app, [110.0, 100.0], true, now);
    // However long it takes, the mouse has just moved.
    until_by(
        &mut app,
        || now,
        |a| a.drawn.is_some_and(|d| d == (a.state, d.1)),
    );
    point_at(&mut app, [120.0, 100.0], false, now);
    // And from here on it rests.
    until_by(&mut app, || now + STILL, rests);
    let drawn = fake.drawn.lock().unwrap()[before..].to_vec();
    assert!(drawn.iter().any(|d| d.2 > 0), "{drawn:?}");
    // 20 pixels of a window that is 200 high.
    assert_eq!(drawn.last().unwrap(), &("".into(), 45.0 - 18.0, 0));
    assert_eq!(app.picture.size, SIZE);
}

#[test]
fn a_movement_cancels_what_would_come_too_late() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    fake.slow.store(100, Ordering::Relaxed);
    press(&mut app, Press::Char('o'));
    until(&mut app, rests);
    fake.slow.store(5_000, Ordering::Relaxed);
    press(&mut app, Press::Char('o'));
    until(&mut app, |a| {
        a.drawing.as_ref().is_some_and(|d| d.step == 0)
    });
    let now = Instant::now();
    point_at(&mut app, [100.0, 100.0], false, now);
    point_at(&mut app, [130.0, 100.0], true, now);
    let drawn = |a: &App| a.drawn.is_some_and(|d| d.0 == a.state);
    until_by(&mut app, || now, drawn);
    assert!(app.drawn.is_some_and(|d| d.1 > 0), "the full one was drawn");
    assert_eq!(fake.cancelled.load(Ordering::Relaxed), 1);
}

/// What takes too long is known from the model that is drawn, not guessed from the next one.
#[test]
fn another_model_cancels_what_is_drawn_of_the_last() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    fake.slow.store(100, Ordering::Relaxed);
    press(&mut app, Press::Char('o'));
    until(&mut app, rests);
    fake.slow.store(5_000, Ordering::Relaxed);
    press(&mut app, Press::Char('o'));
    until(&mut app, |a| {
        a.drawing.as_ref().is_some_and(|d| d.step == 0)
    });
    fake.slow.store(0, Ordering::Relaxed);
    press(&mut app, Press::Right);
    until(&mut app, rests);
    assert_eq!(app.title(), "b.obj - earmark");
    assert_eq!(fake.cancelled.load(Ordering::Relaxed), 1);
}

#[test]
fn late_pictures_of_another_model_are_no_measure() {
    let (_, mut app) = open();
    until(&mut app, rests);
    let times = |app: &App| format!("{:?}", app.quality);
    let before = times(&app);
    let late = |shown: Arc<Shown>, app: &App| Delivery {
        order: Order {
            flags: Flags::default(),
            camera: Camera::default(),
            model: 0,
            shown,
            size: SIZE,
            draft: LADDER[0],
            step: 0,
            backdrop: [0; 4],
            measure: false,
            cancelled: Arc::default(),
            state: app.state,
        },
        canvas: Canvas::default(),
        result: Ok(FrameStats::default()),
        took: Duration::from_secs(9),
    };
    let delivery = late(Arc::new(Shown::new(scene())), &app);
    app.delivered(delivery, Instant::now());
    assert_eq!(times(&app), before);
    let own = app.shown.clone().unwrap();
    let delivery = late(own, &app);
    app.delivered(delivery, Instant::now());
    assert_ne!(times(&app), before);
}

#[test]
fn a_thread_that_is_not_there_is_an_error() {
    let (_, mut app) = open();
    until(&mut app, rests);
    app.orders = channel().0;
    press(&mut app, Press::Char('o'));
    assert_eq!(app.tick(Instant::now()), Err(WindowError::Thread));
    assert!(!app.is_done());
}

#[test]
fn a_broken_file_leaves_the_model() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    fake.broken.store(true, Ordering::Relaxed);
    press(&mut app, Press::Up);
    until(&mut app, |a| a.loading.is_none());
    assert_eq!(app.broken.as_deref(), Some("a.obj:3: broken"));
    assert!(app.shown.is_some());
    // It stays broken whatever else is drawn.
    press(&mut app, Press::Char('c'));
    until(&mut app, rests);
    assert_eq!(app.broken.as_deref(), Some("a.obj:3: broken"));
    fake.broken.store(false, Ordering::Relaxed);
    press(&mut app, Press::Up);
    until(&mut app, rests);
    assert_eq!((&app.broken, &app.fault), (&None, &None));
}

#[test]
fn flags_of_a_model_hold_when_it_is_loaded() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    fake.held.store(true, Ordering::Relaxed);
    press(&mut app, Press::Char('n'));
    assert!(app.loading.is_some());
    // Others meanwhile join them; drags are drawn as before.
    press(&mut app, Press::Char('c'));
    point(&mut app, 100.0, 100.0, false);
    point(&mut app, 110.0, 100.0, true);
    until(&mut app, |a| a.drawn.is_some_and(|d| d.0 == a.state));
    let drawn = fake.drawn.lock().unwrap().last().unwrap().0.clone();
    assert_eq!(drawn, "");
    point(&mut app, 110.0, 100.0, false);
    fake.held.store(false, Ordering::Relaxed);
    until(&mut app, rests);
    let drawn = fake.drawn.lock().unwrap().last().unwrap().0.clone();
    assert_eq!(drawn, "--scheme catmull-clark --shade flat");
}

#[test]
fn models_go_round_and_the_last_one_asked_for_is_shown() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    assert_eq!(app.title(), "a.obj - earmark");
    fake.held.store(true, Ordering::Relaxed);
    for _ in 0..3 {
        press(&mut app, Press::Right);
    }
    fake.held.store(false, Ordering::Relaxed);
    until(&mut app, rests);
    assert_eq!(app.title(), "b.obj - earmark");
    press(&mut app, Press::Left);
    until(&mut app, rests);
    assert_eq!(app.title(), "a.obj - earmark");
    // Reading again means the model that is on its way.
    fake.held.store(true, Ordering::Relaxed);
    press(&mut app, Press::Right);
    press(&mut app, Press::Char('r'));
    fake.held.store(false, Ordering::Relaxed);
    until(&mut app, rests);
    assert_eq!(app.title(), "b.obj - earmark");
}

#[test]
fn pictures_are_saved_with_the_flags_that_are_printed() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    press(&mut app, Press::Char('3'));
    press(&mut app, Press::Char('?'));
    press(&mut app, Press::F(12));
    press(&mut app, Press::Escape);
    until(&mut app, App::is_done);
    let line = "draw no/such/folder/a.obj a.png --level 3 --size 320x200";
    let printed = fake.printed.lock().unwrap().clone();
    assert_eq!(printed, [line, line, "saved a.png"]);
}

#[test]
fn no_picture_takes_the_path_of_one_being_written() {
    let (fake, mut app) = open();
    until(&mut app, rests);
    fake.writes_held.store(true, Ordering::Relaxed);
    press(&mut app, Press::Char('s'));
    press(&mut app, Press::Char('s'));
    assert_eq!(app.saving, ["a.png", "a-2.png"]);
    press(&mut app, Press::Escape);
    app.wait(Duration::from_millis(20));
    assert!(!app.is_done());
    fake.writes_held.store(false, Ordering::Relaxed);
    until(&mut app, App::is_done);
    let mut written = fake.printed.lock().unwrap().clone();
    written.retain(|line| line.starts_with("saved "));
    written.sort();
    assert_eq!(written, ["saved a-2.png", "saved a.png"]);
}

#[test]
fn the_window_shows_panels_and_takes_other_sizes() {
    let (_, mut app) = open();
    until(&mut app, rests);
    let count = |app: &App, color: u32| app.window.pixels.iter().filter(|p| **p == color).count();
    app.frame(Instant::now());
    let all = (SIZE[0] * SIZE[1]) as usize;
    let seen = count(&app, 0xc8_6432);
    assert!(seen < all && seen > all / 2, "figures cover a part");
    press(&mut app, Press::Char('i'));
    press(&mut app, Press::Char('i'));
    until(&mut app, rests);
    app.frame(Instant::now());
    assert_eq!(count(&app, 0xc8_6432), all);
    press(&mut app, Press::Char('h'));
    app.frame(Instant::now());
    assert!(count(&app, 0xc8_6432) < all);
    let mut sizes = vec![];
    for size in [[500, 300], [1, 1], [0, 5], [64, 3000]] {
        app.event(Event::Size(size), Instant::now());
        app.frame(Instant::now());
        sizes.push(app.window.size);
    }
    // A window without pixels is none.
    assert_eq!(sizes, [[500, 300], [1, 1], [1, 1], [64, 3000]]);
    until(&mut app, rests);
    assert_eq!(app.picture.size, [64, 3000]);
}
