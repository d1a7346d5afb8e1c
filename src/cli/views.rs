//! `render --views`: one picture of several models, or of one from several sides.

use super::draw;
use super::exit::Failure;
use super::job::Job;
use super::render::{self, Arguments, Drawn};
use clap::ValueEnum;
use earmark::frame::FrameStats;
use earmark::sheet::{Picture, SheetStyle, contact_sheet};
use std::path::Path;

/// A side to look from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViewName {
    /// Azimuth 0, elevation 0
    Front,
    /// Azimuth 180
    Back,
    /// Azimuth -90
    Left,
    /// Azimuth 90
    Right,
    /// The same as right
    Side,
    /// Elevation 90
    Top,
    /// Elevation -90
    Bottom,
    /// --azimuth and --elevation, 45 and 25 if they are not given
    ThreeQuarter,
}

impl ViewName {
    /// Azimuth and elevation; none where the flags have them.
    fn angles(self) -> Option<[f64; 2]> {
        match self {
            Self::Front => Some([0.0, 0.0]),
            Self::Back => Some([180.0, 0.0]),
            Self::Left => Some([-90.0, 0.0]),
            Self::Right | Self::Side => Some([90.0, 0.0]),
            Self::Top => Some([0.0, 90.0]),
            Self::Bottom => Some([0.0, -90.0]),
            Self::ThreeQuarter => None,
        }
    }
    fn name(self) -> String {
        let value = self.to_possible_value();
        value.map(|v| v.get_name().to_owned()).unwrap_or_default()
    }
}

/// What cannot be together with views.
pub(crate) fn check(job: &Job, a: &Arguments) -> Result<(), Failure> {
    if a.picture.eye.is_some() {
        return Err(Failure::usage(
            "--views and --eye are two ways to place the camera",
        ));
    }
    if !a.aov.is_empty() {
        return Err(Failure::usage(
            "--aov goes with one picture, not with --views",
        ));
    }
    let pixels = u128::from(a.picture.size[0]) * u128::from(a.picture.size[1]);
    let cells = a.models.len() as u128 * a.views.len() as u128;
    // Every picture, the sheet twice, and the file.
    job.limits()
        .memory("a sheet of this size", pixels * cells * 17)?;
    Ok(())
}

/// Draws every model, framed alone, from every side: models in rows, sides in columns.
pub(crate) fn draw(job: &mut Job, a: &Arguments) -> Result<Drawn, Failure> {
    let mut pictures = Vec::new();
    let mut stats = FrameStats::default();
    for model in &a.models {
        let scene = render::scene(job, a, std::slice::from_ref(model))?;
        let renderer = draw::renderer(job, a);
        let [mut covered, first] = [0, stats.faces];
        for &view in &a.views {
            let mut camera = draw::camera(a, &scene);
            if let Some([azimuth, elevation]) = view.angles() {
                camera = camera.with_orbit(azimuth, elevation);
            }
            let lined = draw::draw(job, &renderer, &scene, &camera, &a.picture)?;
            let frame = lined.frame;
            covered += frame.stats.pixels_covered;
            stats.faces = first + frame.stats.faces;
            stats.microtriangles += frame.stats.microtriangles;
            stats.levels.extend(frame.stats.levels);
            pictures.push(Picture {
                image: frame.image,
                caption: caption(a, model, view),
            });
        }
        stats.pixels_covered += covered;
        if covered == 0 {
            draw::warn_empty();
        }
    }
    let image = contact_sheet(&pictures, &style(a)).map_err(|e| Failure::usage(e.to_string()))?;
    Ok(Drawn {
        image,
        lines: None,
        more: Vec::new(),
        planes: Vec::new(),
        stats,
        seen: None,
    })
}

fn caption(a: &Arguments, model: &Path, view: ViewName) -> String {
    let stem = model.file_stem().unwrap_or_default().to_string_lossy();
    match (a.models.len(), a.views.len()) {
        (1, _) => view.name(),
        (_, 1) => stem.into_owned(),
        _ => format!("{stem} {}", view.name()),
    }
}

/// A row per model, or nearly a square where every model has one picture. Captions stand out from the background.
fn style(a: &Arguments) -> SheetStyle {
    let columns = match a.views.len() {
        1 => (1..).find(|c| c * c >= a.models.len()).unwrap_or(1),
        n => n,
    };
    let [width, height] = a.picture.size;
    let plain = SheetStyle::default();
    let background = a.picture.background.unwrap_or(plain.background);
    let [r, g, b, alpha] = background.map(u32::from);
    let dark = alpha > 127 && 2 * r + 5 * g + b < 8 * 110;
    SheetStyle {
        columns: columns as u32,
        text_height: (width.min(height) / 20).clamp(8, 64),
        background,
        ink: if dark {
            [225, 225, 228, 255]
        } else {
            plain.ink
        },
        ..plain
    }
}
