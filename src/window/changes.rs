//! Files that change while they are shown, found by looking at them now and then: that works on any disk, network ones too.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How often files are looked at.
const EVERY: Duration = Duration::from_millis(150);

/// What tells one state of a file from another: when it was written, and how long it is. None where it is not there.
pub(super) type Mark = Option<(SystemTime, u64)>;

/// Some files, and how they were.
#[derive(Clone, Debug, Default)]
pub(super) struct Changes {
    files: Vec<(PathBuf, Mark)>,
    /// The state in which they were last seen, if that is another.
    last: Option<Vec<Mark>>,
    looked: Option<Instant>,
}

/// The state of a file.
pub(super) fn mark(path: &Path) -> Mark {
    let found = std::fs::metadata(path).ok()?;
    Some((found.modified().ok()?, found.len()))
}

impl Changes {
    /// Watches files from the state in which they are now.
    #[must_use]
    pub(super) fn of(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let files = files.into_iter().map(|f| {
            let now = mark(&f);
            (f, now)
        });
        Self {
            files: files.collect(),
            ..Self::default()
        }
    }

    /// A file was in that state when it was read: what changed since then is still to be seen.
    pub(super) fn was(&mut self, path: &Path, mark: Mark) {
        for file in self.files.iter_mut().filter(|f| f.0 == path) {
            file.1 = mark;
        }
    }

    /// Whether the files have become others, and are complete as far as one can see: they stayed the same for a moment. Says so once.
    pub(super) fn seen(&mut self, now: Instant) -> bool {
        if self.looked.is_some_and(|l| now < l + EVERY) {
            return false;
        }
        self.looked = Some(now);
        let marks: Vec<Mark> = self.files.iter().map(|(f, _)| mark(f)).collect();
        if self.files.iter().map(|(_, m)| m).eq(&marks) {
            self.last = None;
            return false;
        }
        if self.last.as_ref() != Some(&marks) {
            self.last = Some(marks);
            return false;
        }
        // A file that is away is about to come back: programs write another and rename it.
        let mut pairs = marks.iter().zip(&self.files);
        let there = pairs.all(|(m, f)| m.is_some() || f.1.is_none());
        if there {
            for (file, mark) in self.files.iter_mut().zip(marks) {
                file.1 = mark;
            }
            self.last = None;
        }
        there
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_change_is_seen_once_when_it_is_over() {
        let folder = std::env::temp_dir().join(format!("earmark-changes-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("a.obj");
        fs::write(&file, "1").unwrap();
        let start = Instant::now();
        let after = |k: u32| start + EVERY * k;
        let mut changes = Changes::of([file.clone(), folder.join("never.mtl")]);
        assert!(!changes.seen(after(0)));
        fs::write(&file, "12").unwrap();
        assert!(!changes.seen(after(1)), "it may go on");
        fs::write(&file, "123").unwrap();
        assert!(!changes.seen(after(2)), "it did go on");
        assert!(changes.seen(after(3)));
        assert!(!changes.seen(after(4)) && !changes.seen(after(5)));
        fs::remove_file(&file).unwrap();
        for k in 6..9 {
            assert!(!changes.seen(after(k)), "it is away");
        }
        fs::write(&file, "1234").unwrap();
        assert!(!changes.seen(after(9)));
        assert!(changes.seen(after(10)));
        // What changes between being read and being watched is seen too.
        let read = mark(&file);
        fs::write(&file, "12345").unwrap();
        let mut changes = Changes::of([file.clone()]);
        changes.was(&file, read);
        assert!(!changes.seen(after(11)) && changes.seen(after(12)));
        fs::remove_dir_all(&folder).unwrap();
    }
}
