//! `earmark compare`: two pictures, or two folders of pictures.

use super::exit::{Code, Failure};
use super::flags::RunningFlags;
use super::job::Job;
use super::outputs::{Output, Staged, commit_all, print_text};
use super::stats::Json;
use super::watch::{self, Phase};
use clap::Args;
use earmark::compare::{Comparison, Tolerance, difference};
use earmark::files;
use earmark::film::png;
use earmark::golden::{
    Folders, FoldersError, Page, PictureError, Pictures, Shown, Verdict, judge, read_picture, stage,
};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Golden picture (PNG), or a folder of them
    #[arg(value_name = "GOLDEN")]
    golden: PathBuf,
    /// New picture, or a folder with pictures of the same names
    #[arg(value_name = "NEW")]
    new: PathBuf,
    #[command(flatten)]
    compare: CompareFlags,
    #[command(flatten)]
    running: RunningFlags,
}

#[derive(Args, Debug)]
#[command(next_help_heading = "Comparison")]
struct CompareFlags {
    /// Largest difference of a pixel in any channel that counts as equal: in 255ths, or in 65535ths where a picture has 16 bits
    #[arg(
        long,
        value_name = "D",
        default_value_t = 0,
        allow_hyphen_values = true
    )]
    max_delta: u16,
    /// Pixels that may differ by more than that, of every picture
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_hyphen_values = true
    )]
    max_pixels: u64,
    /// Write a picture of the differences (.png), grey where there are none; violet: cannot be seen; red to white: can be [default: none]
    #[arg(long, value_name = "OUT.png")]
    diff: Option<PathBuf>,
    /// Write a page (.html) that shows what differs side by side, blinking, under a slider, and as a difference; one file, pictures
    /// and all [default: none]
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Make the new picture the golden one; of folders all that differ or have no golden. The code is 0 then, unless a picture cannot be
    /// read
    #[arg(long)]
    accept: bool,
    /// With --accept, of folders: remove dead goldens, those without a new picture
    #[arg(long, requires = "accept")]
    prune: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub(crate) fn running(&self) -> &RunningFlags {
        &self.running
    }

    fn tolerance(&self) -> Tolerance {
        Tolerance {
            max_delta: self.compare.max_delta,
            max_pixels: self.compare.max_pixels,
        }
    }

    fn output(&self, path: Option<&PathBuf>, ending: &str) -> Result<Option<Output>, Failure> {
        let inputs = [self.golden.as_path(), self.new.as_path()];
        path.map(|p| Output::checked(p, &[ending], &inputs))
            .transpose()
    }
}

impl From<FoldersError> for Failure {
    fn from(e: FoldersError) -> Self {
        match e {
            FoldersError::File(e) => e.into(),
            FoldersError::Limit(e) => e.into(),
            other => Self::new(Code::Io, other.to_string()),
        }
    }
}

/// The end of a comparison that does not pass. All has been said by then.
fn different(passes: bool) -> Result<(), Failure> {
    match passes {
        true => Ok(()),
        false => Err(Failure::new(Code::Different, "")),
    }
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    if a.running.stats.is_some() {
        return Err(Failure::usage(
            "compare has no --stats; --json says what was found",
        ));
    }
    // The first pictures of all are accepted into a folder that is not there yet.
    if a.compare.accept && a.new.is_dir() && !a.golden.exists() {
        files::make_folder(&a.golden)?;
    }
    let folder = |path: &Path| path.is_dir();
    match (folder(&a.golden), folder(&a.new)) {
        (false, false) => pictures(job, a),
        (true, true) => folders(job, a),
        (of_goldens, _) => {
            let (one, other) = match of_goldens {
                true => (&a.golden, &a.new),
                false => (&a.new, &a.golden),
            };
            Err(Failure::usage(format!(
                "{} is a folder and {} is none",
                one.display(),
                other.display()
            )))
        }
    }
}

impl From<PictureError> for Failure {
    fn from(e: PictureError) -> Self {
        match e {
            PictureError::File(e) => e.into(),
            PictureError::Limit(e) => e.into(),
            damaged => Self::new(Code::Data, damaged.to_string()),
        }
    }
}

/// Two files.
fn pictures(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    if a.compare.prune {
        return Err(Failure::usage("--prune is for folders"));
    }
    let diff = a.output(a.compare.diff.as_ref(), "png")?;
    let report = a.output(a.compare.report.as_ref(), "html")?;
    watch::phase(Phase::Comparing);
    let new = read_picture(&a.new, &job.limits())?;
    if a.compare.accept && !a.golden.exists() {
        let staged = Staged::of(stage(&a.golden, &new.0)?);
        commit_all(vec![staged])?;
        return say(job, a, &Verdict::New, &[(a.golden.clone(), "new")]);
    }
    let golden = read_picture(&a.golden, &job.limits())?;
    job.limits().check()?;
    let verdict = judge(&golden.1, &new.1, &a.tolerance());
    let picture = match (diff.is_some() || report.is_some(), &verdict) {
        (false, _) | (_, Verdict::Size(_)) => None,
        _ => difference(&golden.1, &new.1).ok(),
    };
    let picture = picture.map(|p| png::encode_rgb(&p)).transpose()?;
    let mut staged = Vec::new();
    if let (Some(diff), Some(picture)) = (&diff, &picture) {
        staged.push(diff.stage(picture)?);
    }
    if let Some(report) = report {
        let title = format!("{} against {}", a.new.display(), a.golden.display());
        staged.push(report.stage_with(|out| {
            let mut page = Page::begin(out, &title, verdict.word())?;
            let pictures = Pictures {
                golden: Some(Shown::Embedded(&golden.0)),
                new: Some(Shown::Embedded(&new.0)),
                difference: picture.as_deref().map(Shown::Embedded),
            };
            let name = a.golden.file_name().unwrap_or_default().to_string_lossy();
            page.entry(&name, &verdict, &verdict.figures(), pictures)?;
            page.end("", &[])
        })?);
    }
    let mut done = Vec::new();
    if a.compare.accept && verdict.is_acceptable() {
        staged.push(Staged::of(stage(&a.golden, &new.0)?));
        done.push((a.golden.clone(), "changed"));
    }
    commit_all(staged)?;
    say(job, a, &verdict, &done)?;
    different(verdict.passes() || a.compare.accept)
}

/// Prints what came of two pictures.
fn say(
    job: &Job,
    a: &Arguments,
    verdict: &Verdict,
    accepted: &[(PathBuf, &str)],
) -> Result<(), Failure> {
    if a.compare.json {
        let mut members = vec![
            (
                "golden".to_owned(),
                Json::text(a.golden.display().to_string()),
            ),
            ("new".to_owned(), Json::text(a.new.display().to_string())),
        ];
        members.extend(verdict_json(verdict));
        members.push(("accepted".to_owned(), Json::Bool(!accepted.is_empty())));
        return print_text(&format!("{}\n", Json::Object(members)));
    }
    if job.running.quiet {
        return Ok(());
    }
    let mut text = format!(
        "{}: {}\n",
        a.new.display(),
        match verdict {
            Verdict::Equal => "equal, pixel by pixel",
            v => v.word(),
        }
    );
    for line in verdict.figures().lines() {
        let _ = writeln!(text, "  {line}");
    }
    for (path, how) in accepted {
        let _ = writeln!(text, "accepted: {} ({how})", path.display());
    }
    print_text(&text)
}

/// Members of a verdict: `verdict`, and the figures where there are any.
fn verdict_json(verdict: &Verdict) -> Vec<(String, Json)> {
    let mut members = vec![("verdict".to_owned(), Json::text(verdict.word()))];
    match verdict {
        Verdict::Within(c) | Verdict::Different(c) => members.extend(comparison_json(c)),
        Verdict::Size(e) => {
            let size =
                |[w, h]: [u32; 2]| Json::List(vec![Json::Whole(w.into()), Json::Whole(h.into())]);
            members.push(("golden_size".to_owned(), size(e.a)));
            members.push(("new_size".to_owned(), size(e.b)));
        }
        Verdict::Unreadable(why) => members.push(("why".to_owned(), Json::text(why.as_str()))),
        _ => {}
    }
    members
}

fn comparison_json(c: &Comparison) -> Vec<(String, Json)> {
    let list = |values: &[u32]| Json::List(values.iter().map(|&v| Json::Whole(v.into())).collect());
    let sweep = c.sweep().into_iter();
    let sweep = sweep.map(|(t, n)| Json::List(vec![Json::Whole(t.into()), Json::Whole(n)]));
    let members = [
        ("pixels", Json::Whole(c.pixels())),
        ("differing", Json::Whole(c.differing())),
        ("visible", Json::Whole(c.visible())),
        ("max_delta", Json::Whole(c.max_delta().into())),
        ("full_delta", Json::Whole(c.full_delta().into())),
        ("worst", list(&c.worst())),
        ("bounds", c.bounds().map_or(Json::Null, |b| list(&b))),
        ("oklab", Json::Number(c.farthest().into())),
        ("sweep", Json::List(sweep.collect())),
    ];
    members
        .into_iter()
        .map(|(k, v)| (k.to_owned(), v))
        .collect()
}

/// Two folders.
fn folders(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    if a.compare.diff.is_some() {
        return Err(Failure::usage(
            "--diff is for two pictures; --report shows the differences of folders",
        ));
    }
    let report = a.output(a.compare.report.as_ref(), "html")?;
    watch::phase(Phase::Comparing);
    let limits = job.limits();
    let found = Folders::compare(&a.golden, &a.new, &a.tolerance(), &limits)?;
    let mut staged = Vec::new();
    if let Some(report) = report {
        staged.push(report.stage_with(|out| found.report(out))?);
    }
    let mut done: Vec<(String, &str)> = Vec::new();
    if a.compare.accept {
        for (f, file) in found.accept(&limits)? {
            staged.push(Staged::of(file));
            done.push((
                f.name(),
                if f.verdict == Verdict::New {
                    "new"
                } else {
                    "changed"
                },
            ));
        }
    }
    limits.check()?;
    commit_all(staged)?;
    if a.compare.prune {
        for path in found.dead() {
            files::remove(&path)?;
            let name = path.strip_prefix(&a.golden).unwrap_or(&path);
            done.push((name.display().to_string(), "removed"));
        }
    }
    print_folders(job, a, &found, &done)?;
    let settled = |v: &Verdict| match v {
        Verdict::Dead => a.compare.accept,
        // What was accepted is done.
        v => v.passes(),
    };
    let unreadable = |v: &Verdict| matches!(v, Verdict::Unreadable(_));
    if let Some(f) = found
        .found()
        .iter()
        .find(|f| unreadable(&f.verdict) && !is_done(&done, f))
    {
        return Err(Failure::new(Code::Data, f.verdict.figures()));
    }
    different(
        found
            .found()
            .iter()
            .all(|f| settled(&f.verdict) || is_done(&done, f)),
    )
}

fn is_done(done: &[(String, &str)], f: &earmark::golden::Found) -> bool {
    let name = f.name();
    done.iter().any(|(n, _)| *n == name)
}

fn print_folders(
    job: &Job,
    a: &Arguments,
    found: &Folders,
    done: &[(String, &str)],
) -> Result<(), Failure> {
    if a.compare.json {
        let pictures = found.found().iter().map(|f| {
            let mut members = vec![("name".to_owned(), Json::text(f.name()))];
            members.extend(verdict_json(&f.verdict));
            Json::Object(members)
        });
        let accepted = done.iter().map(|(name, how)| {
            Json::object([
                ("name", Json::text(name.as_str())),
                ("how", Json::text(*how)),
            ])
        });
        let json = Json::object([
            ("golden", Json::text(a.golden.display().to_string())),
            ("new", Json::text(a.new.display().to_string())),
            ("passes", Json::Bool(found.passes())),
            ("pictures", Json::List(pictures.collect())),
            ("accepted", Json::List(accepted.collect())),
        ]);
        return print_text(&format!("{json}\n"));
    }
    if job.running.quiet {
        return Ok(());
    }
    let mut text = String::new();
    for f in found.found().iter().filter(|f| !f.verdict.passes()) {
        let _ = writeln!(text, "{}: {}", f.name(), f.verdict.word());
        for line in f.verdict.figures().lines() {
            let _ = writeln!(text, "  {line}");
        }
    }
    for (name, how) in done {
        let _ = writeln!(text, "accepted: {name} ({how})");
    }
    let _ = writeln!(text, "{}", found.summary());
    print_text(&text)
}
