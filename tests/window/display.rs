//! A display in memory for one test: Xvfb, its pixels read straight from the file that it draws into, and xdotool to type and point.

use earmark::film::Image;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

/// Pixels across and down of the display.
pub(crate) const SIZE: [u32; 2] = [1400, 900];

/// A running Xvfb.
pub(crate) struct Display {
    server: Child,
    tool: Child,
    script: ChildStdin,
    folder: PathBuf,
    pixels: File,
    first: u64,
    line: u64,
    pub(crate) name: String,
}

fn word(header: &[u8], k: usize) -> u64 {
    u64::from(u32::from_be_bytes(header[k * 4..][..4].try_into().unwrap()))
}

impl Display {
    /// Starts a server on a number that is free.
    pub(crate) fn start(folder: PathBuf) -> Self {
        std::fs::create_dir_all(&folder).unwrap();
        let screen = format!("{}x{}x24", SIZE[0], SIZE[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-fbdir"])
            .arg(&folder)
            .args(["-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("EARMARK_XVFB is set, and there is no Xvfb");
        let mut number = String::new();
        let out = server.stdout.take().unwrap();
        BufReader::new(out).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        assert!(name.len() > 1, "Xvfb gives no display");
        let pixels = File::open(folder.join("Xvfb_screen0")).unwrap();
        // The format of xwd: sizes in a header of big-endian words, a table of colours, rows of blue, green, red, nothing.
        let mut header = [0; 100];
        pixels.read_exact_at(&mut header, 0).unwrap();
        assert_eq!([word(&header, 4), word(&header, 5)], SIZE.map(u64::from));
        let mut tool = Command::new("xdotool")
            .arg("-")
            .env("DISPLAY", &name)
            .stdin(Stdio::piped())
            .spawn()
            .expect("EARMARK_XVFB is set, and there is no xdotool");
        Self {
            server,
            script: tool.stdin.take().unwrap(),
            tool,
            folder,
            first: word(&header, 0) + word(&header, 19) * 12,
            line: word(&header, 12),
            pixels,
            name,
        }
    }

    /// Types or points, in the words of xdotool.
    pub(crate) fn tell(&mut self, what: &str) {
        writeln!(self.script, "{what}").unwrap();
        self.script.flush().unwrap();
    }

    /// The bytes of rows from `top` on.
    pub(crate) fn rows(&self, top: u32, count: u32) -> Vec<u8> {
        let mut out = vec![0; self.line as usize * count as usize];
        let at = self.first + u64::from(top) * self.line;
        self.pixels.read_exact_at(&mut out, at).unwrap();
        out
    }

    /// The display as a picture.
    pub(crate) fn shot(&self) -> Image {
        let mut image = Image::new(SIZE[0], SIZE[1]);
        let rows = self.rows(0, SIZE[1]);
        let across = SIZE[0] as usize * 4;
        for (to, from) in image
            .data
            .chunks_exact_mut(across)
            .zip(rows.chunks_exact(self.line as usize))
        {
            for (t, p) in to.chunks_exact_mut(4).zip(from.chunks_exact(4)) {
                t.copy_from_slice(&[p[2], p[1], p[0], 255]);
            }
        }
        image
    }

    /// Waits until the display has not changed for a while.
    pub(crate) fn settled(&self, still: Duration) -> Image {
        let begin = Instant::now();
        let (mut last, mut since) = (self.shot(), Instant::now());
        loop {
            std::thread::sleep(Duration::from_millis(40));
            let now = self.shot();
            if now != last {
                (last, since) = (now, Instant::now());
            } else if since.elapsed() > still {
                return last;
            }
            let waited = begin.elapsed();
            assert!(waited < Duration::from_secs(60), "the display never rests");
        }
    }

    /// Waits until the display is another than `before`, and rests.
    pub(crate) fn changed(&self, before: &Image) -> Image {
        let begin = Instant::now();
        while self.shot() == *before {
            let waited = begin.elapsed();
            assert!(waited < Duration::from_secs(60), "nothing changed");
            std::thread::sleep(Duration::from_millis(20));
        }
        self.settled(super::STILL)
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        for child in [&mut self.tool, &mut self.server] {
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
