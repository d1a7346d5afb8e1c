//! `--aov`: what is written beside the picture.

use super::exit::Failure;
use super::job::Job;
use super::outputs::{Output, Staged};
use super::stats::Json;
use earmark::camera::View;
use earmark::files;
use earmark::frame::{Aov, Plane};
use std::path::{Path, PathBuf};

/// An output and where it goes.
#[derive(Clone, Debug)]
pub(crate) struct AovFlag {
    pub(crate) aov: Aov,
    pub(crate) path: PathBuf,
}

/// `NAME=PATH`.
pub(crate) fn parse(text: &str) -> Result<AovFlag, String> {
    let known = || Aov::ALL.map(Aov::name).join(", ");
    let (name, path) = (text.split_once('=')).ok_or("expected NAME=PATH, as depth=depth.png")?;
    let aov = Aov::from_name(name).ok_or_else(|| format!("not one of {}", known()))?;
    match path {
        "" | "-" => Err("needs a file to write to".into()),
        path => Ok(AovFlag {
            aov,
            path: path.into(),
        }),
    }
}

/// Checks where outputs go: nowhere twice, and not where the others go.
pub(crate) fn outputs(
    flags: &[AovFlag],
    inputs: &[&Path],
    others: &[&Path],
) -> Result<Vec<Output>, Failure> {
    let mut out = Vec::new();
    for (k, flag) in flags.iter().enumerate() {
        let name = flag.aov.name();
        let earlier = flags[..k].iter();
        let mut taken = earlier
            .clone()
            .map(|f| f.path.as_path())
            .chain(others.iter().copied());
        if taken.any(|p| p == flag.path || files::same_file(p, &flag.path)) {
            let message = format!("--aov {name} is written where another output is");
            return Err(Failure::usage(message));
        }
        if earlier.clone().any(|f| f.aov == flag.aov) {
            return Err(Failure::usage(format!("--aov {name} is given twice")));
        }
        out.push(Output::checked(&flag.path, &["png"], inputs)?);
    }
    Ok(out)
}

fn list<const N: usize>(v: [f64; N]) -> String {
    v.map(|c| c.to_string()).join(" ")
}

fn wide(v: [f32; 3]) -> [f64; 3] {
    v.map(f64::from)
}

/// The view as the text chunks and the statistics have it; positions are those of the file, `origin` away from the scene's.
struct ViewFigures<'a> {
    view: &'a View,
    origin: [f64; 3],
}

impl ViewFigures<'_> {
    fn eye(&self) -> [f64; 3] {
        let eye = wide(self.view.eye);
        [0, 1, 2].map(|k| eye[k] + self.origin[k])
    }
    fn projection(&self) -> &'static str {
        match self.view.projection.ortho {
            true => "orthographic",
            false => "perspective",
        }
    }
}

/// Puts outputs where only committing is left.
pub(crate) fn stage(
    job: &mut Job,
    planes: &[Plane],
    outputs: &[Output],
    view: &View,
    origin: [f64; 3],
) -> Result<Vec<Staged>, Failure> {
    let mut staged = Vec::new();
    let figures = ViewFigures { view, origin };
    for (plane, output) in planes.iter().zip(outputs) {
        let mut texts = vec![
            ("Software", format!("earmark {}", env!("CARGO_PKG_VERSION"))),
            ("aov", plane.aov.name().to_owned()),
        ];
        let shift = |v: [f64; 3]| [0, 1, 2].map(|k| v[k] + origin[k]);
        match plane.aov {
            Aov::Depth => texts.extend([
                ("near", plane.low[0].to_string()),
                ("far", plane.high[0].to_string()),
                ("projection", figures.projection().to_owned()),
                ("eye", list(figures.eye())),
                ("right", list(wide(view.right))),
                ("up", list(wide(view.up))),
                ("forward", list(wide(view.forward))),
                ("scale", view.scale.to_string()),
            ]),
            Aov::Position => texts.extend([
                ("low", list(shift(plane.low))),
                ("high", list(shift(plane.high))),
            ]),
            Aov::Uv => texts.extend([
                ("low", list([plane.low[0], plane.low[1]])),
                ("high", list([plane.high[0], plane.high[1]])),
            ]),
            _ => {}
        }
        staged.push(job.time("write", |_| output.stage(&plane.encode(&texts)?))?);
    }
    Ok(staged)
}

/// Members of the statistics that say how depths and positions are meant.
pub(crate) fn view_json(view: &View, origin: [f64; 3]) -> Vec<(&'static str, Json)> {
    let figures = ViewFigures { view, origin };
    let numbers = |v: [f64; 3]| Json::List(v.map(Json::Exact).into());
    vec![
        ("near", Json::Exact(view.near.into())),
        ("far", Json::Exact(view.far.into())),
        (
            "view",
            Json::object([
                ("projection", Json::text(figures.projection())),
                ("eye", numbers(figures.eye())),
                ("right", numbers(wide(view.right))),
                ("up", numbers(wide(view.up))),
                ("forward", numbers(wide(view.forward))),
                ("scale", Json::Exact(view.scale.into())),
            ]),
        ),
    ]
}
