//! The preview window on a display in memory: what mouse and keys do to its pixels, and that the picture it saves is the one that the
//! printed command draws. Runs with `EARMARK_XVFB=1` alone, and then wants Xvfb and xdotool.

#![cfg(unix)]
#![allow(missing_docs, clippy::print_stdout)]

#[path = "window/display.rs"]
mod display;
#[allow(dead_code)]
#[path = "cli/harness.rs"]
mod harness;

use display::{Display, SIZE};
use earmark::film::Image;
use harness::{Folder, asset, earmark};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a picture stands until nothing better is to come. Under load a full picture takes longer than it should.
const STILL: Duration = Duration::from_millis(700);

/// One display at a time: what is measured is not to be disturbed.
static ALONE: Mutex<()> = Mutex::new(());

/// Whether the suite is asked for.
fn asked() -> Option<MutexGuard<'static, ()>> {
    if std::env::var_os("EARMARK_XVFB").is_none() {
        println!("not run: EARMARK_XVFB is not set");
        return None;
    }
    Some(ALONE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// A window on a display of its own, in a folder of its own.
struct Window {
    display: Display,
    program: Child,
    lines: Receiver<String>,
    folder: Folder,
    name: String,
}

/// Upper left corner of the window, which stands in the middle of the display.
fn corner(size: [u32; 2]) -> [u32; 2] {
    [(SIZE[0] - size[0]) / 2, (SIZE[1] - size[1]) / 2]
}

impl Window {
    /// Opens `earmark view` and waits for its first picture.
    fn open(name: &str, arguments: &[&str]) -> Self {
        let folder = Folder::new(name);
        let display = Display::start(folder.path("display"));
        let time: &[&str] = match arguments.contains(&"--timeout") {
            true => &[],
            false => &["--timeout", "300"],
        };
        let mut program = earmark()
            .arg("view")
            .args(arguments)
            .args(time)
            .current_dir(folder.path("display").parent().unwrap())
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(program.stdout.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        let mut window = Self {
            display,
            program,
            lines,
            folder,
            name: name.to_owned(),
        };
        let black = Image {
            data: [0, 0, 0, 255].repeat((SIZE[0] * SIZE[1]) as usize),
            ..Image::new(SIZE[0], SIZE[1])
        };
        window.display.changed(&black);
        // Without a window manager the keys go where the pointer is.
        let focused = Command::new("xdotool")
            .args([
                "search",
                "--onlyvisible",
                "--name",
                "earmark",
                "windowfocus",
            ])
            .env("DISPLAY", &window.display.name)
            .status()
            .unwrap();
        assert!(focused.success());
        // Panels hide nothing but the model; figures differ from run to run.
        window.keys("i i");
        window
    }

    fn tell(&mut self, what: &str) {
        self.display.tell(what);
    }

    fn settled(&self) -> Image {
        self.display.settled(STILL)
    }

    fn keys(&mut self, keys: &str) -> Image {
        self.tell(&format!("key {keys}"));
        // Keys may change nothing, so there is nothing to wait for but time.
        std::thread::sleep(Duration::from_millis(300));
        self.settled()
    }

    /// Does something that has to be seen, and keeps what is seen for people to look at.
    fn seen(&mut self, what: &str, script: &str) -> Image {
        let before = self.settled();
        for line in script.lines() {
            self.tell(line.trim());
            // A button that goes down and up within two looks of the window is not seen.
            std::thread::sleep(Duration::from_millis(60));
        }
        let after = self.display.changed(&before);
        self.keep(what, &after);
        after
    }

    /// Writes a picture to `target/window/`.
    fn keep(&self, what: &str, image: &Image) {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("window");
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join(format!("{}_{what}.png", self.name));
        fs::write(path, earmark::film::png::encode(image).unwrap()).unwrap();
    }

    /// The next line that the program prints.
    fn line(&self) -> String {
        let line = self.lines.recv_timeout(Duration::from_secs(30));
        line.expect("a line is printed")
    }

    /// The command line of what is seen.
    fn printed(&mut self) -> String {
        self.tell("key question");
        self.line()
    }

    /// Ends the window by its key, and gives the code and what was said on standard error.
    fn quit(mut self) -> (i32, String) {
        self.tell("key q");
        self.ended()
    }

    /// Waits for the end of the window, and gives the same.
    fn ended(mut self) -> (i32, String) {
        let out = wait(&mut self.program);
        let mut said = String::new();
        if let Some(mut err) = self.program.stderr.take() {
            let _ = std::io::Read::read_to_string(&mut err, &mut said);
        }
        (out, said)
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn wait(program: &mut Child) -> i32 {
    let begin = Instant::now();
    loop {
        if let Some(status) = program.try_wait().unwrap() {
            return status.code().unwrap_or(-1);
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "it goes on");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// How many pixels differ.
fn differing(a: &Image, b: &Image) -> usize {
    let pairs = a.data.chunks_exact(4).zip(b.data.chunks_exact(4));
    pairs.filter(|(p, q)| p != q).count()
}

fn creature() -> String {
    asset("creature.obj").display().to_string()
}

/// Runs a line that the window printed, with this build's program.
fn run_line(line: &str, folder: &Path) {
    let rest = line.strip_prefix("earmark ").expect("a command of earmark");
    let program = env!("CARGO_BIN_EXE_earmark");
    let status = Command::new("sh")
        .arg("-c")
        .arg(format!("{program} {rest}"))
        .current_dir(folder)
        .status()
        .unwrap();
    assert!(status.success(), "{line}");
}

#[test]
fn mouse_and_keys_change_the_picture() {
    let Some(_alone) = asked() else { return };
    let model = creature();
    let mut w = Window::open("keys", &[&model, "--size", "1280x720"]);
    let first = w.settled();
    w.keep("first", &first);
    w.tell("mousemove 700 450");
    let orbit = w.seen(
        "orbit",
        "mousedown 1
         mousemove 900 500
         mouseup 1",
    );
    assert!(differing(&first, &orbit) > 20_000);
    // The camera is as it was when the drag is taken back: the mapping is exact.
    let back = w.seen(
        "back",
        "mousedown 1
         mousemove 700 450
         mouseup 1",
    );
    assert_eq!(differing(&first, &back), 0);
    w.seen(
        "pan",
        "mousedown 2
         mousemove 800 350
         mouseup 2",
    );
    w.seen("zoom", "click --repeat 5 --delay 30 4");
    w.seen("reset", "key Return");
    assert_eq!(differing(&first, &w.settled()), 0);
    let mut last = w.settled();
    let keys = [
        "1",
        "plus",
        "c",
        "c",
        "c",
        "c",
        "c",
        "c",
        "c",
        "v",
        "bracketright",
        "o",
        "b",
        "F7",
    ];
    for (k, key) in keys.iter().enumerate() {
        let now = w.seen(&format!("{k:02}_{key}"), &format!("key {key}"));
        assert!(differing(&last, &now) > 100, "{key}");
        last = now;
    }
    let help = w.seen("help", "key h");
    assert!(differing(&last, &help) > 50_000);
    assert_eq!(differing(&last, &w.seen("no_help", "key h")), 0);
    w.seen("figures", "key i");
    w.seen("all_figures", "key i");
    assert_eq!(w.quit(), (0, String::new()));
}

#[test]
fn the_saved_picture_is_that_of_the_printed_command() {
    let Some(_alone) = asked() else { return };
    let model = creature();
    let mut w = Window::open("save", &[&model, "--size", "900x600", "--fvar", "all"]);
    w.tell("mousemove 700 450");
    w.seen(
        "view",
        "mousedown 1
         mousemove 777 431
         mouseup 1
         click 4
         mousedown 2
         mousemove 760 470
         mouseup 2
         key bracketright",
    );
    let folder = w.folder.path("");
    for (keys, name) in [
        ("s", "creature.png"),
        ("2 s", "creature-2.png"),
        ("v c s", "creature-3.png"),
        ("v v comma n s", "creature-4.png"),
    ] {
        for key in keys.split(' ') {
            w.keys(key);
        }
        let line = w.line();
        assert!(line.contains(&format!("-o {name} ")), "{line}");
        let begin = Instant::now();
        while !folder.join(name).exists() {
            assert!(begin.elapsed() < Duration::from_secs(30), "{name}");
            std::thread::sleep(Duration::from_millis(20));
        }
        w.settled();
        let again = folder.join("again");
        fs::create_dir_all(&again).unwrap();
        run_line(&line, &again);
        let [saved, drawn] = [&folder, &again].map(|f| fs::read(f.join(name)).unwrap());
        assert!(saved == drawn, "{name} is not what this draws: {line}");
        println!("{line}");
    }
    // Printed without writing; nothing else appears.
    let line = w.printed();
    assert!(line.contains("-o creature-5.png "), "{line}");
    for part in [
        "--size 900x600",
        "--fvar all",
        "--light-turn 15",
        "--zoom 1.1",
        "--target",
    ] {
        assert!(line.contains(part), "{line}");
    }
    // What the window shows is what it saves, but for the background.
    w.keys("Up");
    // Messages go away by themselves.
    std::thread::sleep(Duration::from_secs(5));
    let shot = w.settled();
    w.keep("shown", &shot);
    run_line(&line.replace(" -o", " --background 2b2d31 -o"), &folder);
    let png = fs::read(folder.join("creature-5.png")).unwrap();
    let drawn = earmark::film::png::decode(&png).unwrap();
    let at = corner([900, 600]);
    for y in 0..600 {
        for x in 0..900 {
            let seen = shot.pixel(at[0] + x, at[1] + y);
            assert_eq!(seen, drawn.pixel(x, y), "at {x}, {y}");
        }
    }
    assert_eq!(w.quit(), (0, String::new()));
}

/// Models, cameras and modes change what a GPU draws, and what it saves is what its printed command draws.
#[cfg(feature = "gpu")]
#[test]
fn a_gpu_draws_what_is_seen() {
    let Some(_alone) = asked() else { return };
    if std::env::var_os("EARMARK_GPU").is_none() {
        println!("not run: EARMARK_GPU is not set");
        return;
    }
    let (model, other) = (creature(), asset("torus.obj").display().to_string());
    let mut w = Window::open(
        "gpu",
        &[
            &model,
            &other,
            "--size",
            "320x240",
            "--level",
            "2",
            "--backend",
            "gpu",
            "--allow-software-gpu",
        ],
    );
    w.tell("mousemove 640 400");
    w.seen(
        "turned",
        "mousedown 1
         mousemove 700 420
         mouseup 1",
    );
    let folder = w.folder.path("");
    let again = folder.join("again");
    fs::create_dir_all(&again).unwrap();
    for (keys, name) in [("s", "creature.png"), ("c s", "creature-2.png")] {
        for key in keys.split(' ') {
            w.keys(key);
        }
        let line = w.line();
        assert!(line.contains("--backend gpu"), "{line}");
        let begin = Instant::now();
        while !folder.join(name).exists() {
            assert!(begin.elapsed() < Duration::from_secs(30), "{name}");
            std::thread::sleep(Duration::from_millis(20));
        }
        w.settled();
        run_line(&line, &again);
        let [saved, drawn] = [&folder, &again].map(|f| fs::read(f.join(name)).unwrap());
        assert!(saved == drawn, "{name} is not what this draws: {line}");
        println!("{line}");
    }
    w.seen("other", "key 2");
    assert_eq!(w.quit().0, 0);
}

#[test]
fn files_that_change_are_read_again() {
    let Some(_alone) = asked() else { return };
    let models = Folder::new("models");
    let path = models.path("model.obj");
    fs::copy(asset("cube.obj"), &path).unwrap();
    let name = path.display().to_string();
    let torus = asset("torus.obj").display().to_string();
    let mut w = Window::open("reload", &[&name, &torus]);
    let cube = w.settled();
    fs::copy(asset("octahedron.obj"), &path).unwrap();
    let other = w.display.changed(&cube);
    w.keep("octahedron", &other);
    // A broken file is said, with its line, and the model stays.
    fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let broken = w.display.changed(&other);
    w.keep("broken", &broken);
    let lower = |i: &Image| {
        let row = SIZE[0] as usize * 4;
        let bottom = corner([1280, 720])[1] as usize + 720;
        i.data[(bottom - 60) * row..].to_vec()
    };
    assert!(lower(&other) != lower(&broken), "no message");
    let upper = |i: &Image| i.data[..i.data.len() * 3 / 4].to_vec();
    assert!(upper(&other) == upper(&broken), "the model changed");
    // By another way that programs write: a new file that is renamed.
    let new = models.path("new.obj");
    fs::copy(asset("cube.obj"), &new).unwrap();
    fs::rename(&new, &path).unwrap();
    let mended = w.display.changed(&broken);
    assert_eq!(differing(&cube, &mended), 0);
    let next = w.seen("next", "key Right");
    assert!(differing(&next, &cube) > 1000);
    let previous = w.seen("previous", "key Left");
    assert_eq!(differing(&previous, &cube), 0);
    assert_eq!(w.quit(), (0, String::new()));
}

#[test]
fn a_drag_that_is_released_outside_ends() {
    let Some(_alone) = asked() else { return };
    let model = creature();
    let mut w = Window::open("outside", &[&model, "--size", "600x400"]);
    w.tell("mousemove 700 450");
    let out = w.seen(
        "dragged_out",
        "mousedown 1
         mousemove 800 450
         mousemove 1300 500",
    );
    // It goes on outside of the window, as long as the button is down: 650 pixels of 400.
    let further = w.seen("further", "mousemove 1350 600");
    assert!(differing(&out, &further) > 1000);
    let line = w.printed();
    assert!(line.contains(" --azimuth 112.5 --elevation 90 "), "{line}");
    w.tell("mouseup 1");
    std::thread::sleep(Duration::from_millis(100));
    w.tell("mousemove 700 450");
    w.tell("mousemove 650 400");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(line, w.printed(), "it goes on");
    assert_eq!(w.quit(), (0, String::new()));
}

#[test]
fn without_a_display_there_is_a_message() {
    let Some(_alone) = asked() else { return };
    for display in [None, Some(":4095")] {
        let mut command = earmark();
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        if let Some(display) = display {
            command.env("DISPLAY", display);
        }
        let out = command.arg("view").arg(creature()).output().unwrap();
        let message = harness::assert_clean(&out);
        assert_eq!(harness::code(&out), 6, "{message}");
        assert!(message.contains("earmark render MODEL"), "{message}");
        assert!(message.contains("xvfb-run"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn signals_and_deadlines_close_the_window() {
    let Some(_alone) = asked() else { return };
    let model = creature();
    let mut w = Window::open("signal", &[&model]);
    let id = w.program.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status().unwrap();
    assert!(sent.success());
    assert_eq!(wait(&mut w.program), 130);
    drop(w);
    let w = Window::open("deadline", &[&model, "--timeout", "12"]);
    let (code, said) = w.ended();
    assert_eq!(code, 5, "{said}");
    assert_eq!(said.trim_end(), "earmark: not done after 12 seconds");
}

/// Milliseconds from an event of the mouse to the first change on the display, and from the end of the drag to the full picture. Printed,
/// not judged: other programs run on the machine.
#[test]
fn latency_is_measured() {
    let Some(_alone) = asked() else { return };
    let bigguy = std::env::var_os("EARMARK_SHARED")
        .map(|s| PathBuf::from(s).join("models/Bigguy.obj"))
        .filter(|p| p.exists());
    let model = bigguy.map_or(creature(), |p| p.display().to_string());
    let mut w = Window::open("latency", &[&model, "--size", "1280x720"]);
    w.tell("mousemove 700 450");
    let still = w.settled();
    w.keep("still", &still);
    w.tell("mousedown 1");
    std::thread::sleep(Duration::from_millis(200));
    let mut all = Vec::new();
    let mut first_moves = Vec::new();
    for k in 0..60 {
        // Now and then the window rests first: the hardest case, with nothing on the way.
        let rested = k % 6 == 0;
        std::thread::sleep(Duration::from_millis(if rested { 500 } else { 60 }));
        let before = w.display.rows(300, 300);
        let begin = Instant::now();
        w.tell(&format!("mousemove {} {}", 640 + k * 7 % 200, 430 + k % 17));
        while w.display.rows(300, 300) == before {
            assert!(begin.elapsed() < Duration::from_secs(20), "nothing moved");
            std::thread::sleep(Duration::from_micros(200));
        }
        let ms = begin.elapsed().as_secs_f64() * 1e3;
        if rested {
            first_moves.push(ms)
        } else {
            all.push(ms)
        }
    }
    let begin = Instant::now();
    w.tell("mouseup 1");
    let end = w.settled();
    let full = (begin.elapsed() - STILL).as_secs_f64() * 1e3;
    w.keep("end", &end);
    for (what, times) in [("in motion", &mut all), ("after a rest", &mut first_moves)] {
        times.sort_by(f64::total_cmp);
        println!(
            "{model}, 1280x720, mouse to first changed picture {what}: best {:.1} ms, median {:.1} ms, worst {:.1} ms",
            times[0],
            times[times.len() / 2],
            times[times.len() - 1]
        );
    }
    println!("about {full:.0} ms from the last event to the picture that stays");
    assert_eq!(w.quit(), (0, String::new()));
}
