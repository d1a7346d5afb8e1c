//! Line work: what explains a subdivision surface. Lines over a shaded picture, or alone as an illustration, as pixels or as SVG.
//!
//! ```
//! use earmark::{Cage, Camera, Renderer, Scene, Surface, overlay::{self, Layers, Options}};
//!
//! let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
//! let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
//! let scene = Scene::of(Surface::new(Cage::new(points, &[4; 6], corners)?, &Default::default()));
//! let renderer = Renderer::new(128, 128);
//! let mut frame = renderer.render(&scene, &Camera::default())?;
//! let options = Options::overlay(Layers::PATCHES | Layers::VALENCES);
//! let art = overlay::trace(&renderer, &scene, &frame.view, &options)?;
//! art.draw(&mut frame.image);
//! // Two of the eight corners: from near, less than half of what is nearly a ball is seen.
//! assert_eq!(art.marks.iter().filter(|m| m.valence == 3).count(), 2);
//! assert!(art.to_svg(None).starts_with("<svg"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Lines on the surface are edges of the very triangles that the picture is made of, taken block by block from the tiles of a frame
//! (`lines`). What of them is seen is not read from samples: every triangle takes the stretches away that it hides, which are known exactly
//! (`hidden`). What is left is joined to polylines (`chain`), which a picture and an SVG file share. Nothing is stored but lines, tile by
//! tile; the mesh never is.
//!
//! Uniform levels at which nearly all edges are shorter than five pixels are traced at the first that is so: lines of finer ones would be closer
//! than pixels, and none would move by a tenth of one. Faces that an opacity map cuts out hide lines like whole ones.

mod chain;
mod free;
mod hidden;
mod lens;
mod lines;
mod marks;
mod paint;
mod squares;
mod style;
mod svg;

use crate::camera::View;
use crate::film::Image;
use crate::frame::{Block, FrameStats, RenderError, Renderer, Scene, Walk};
use crate::limits::{LimitError, Limits};
use crate::records::{BLOCK_STRIDE, ScreenSize};
use chain::Piece;
use free::FreeLines;
use hidden::Visibility;
use lens::{Lens, Screen, Spot};
use lines::{Collector, Segment};
use marks::Found;

pub use style::{Ink, Kind, Layers, Options, Style};

/// A visible line.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// What it is.
    pub kind: Kind,
    /// Its points in pixels from the upper left corner of the picture, in steps of 1/100; at least two, the last equal to the first where it is
    /// closed.
    pub points: Vec<[f32; 2]>,
}

/// A visible vertex that is marked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Where, in pixels.
    pub at: [f32; 2],
    /// Object of the scene.
    pub object: u32,
    /// Vertex of its cage; `None` for the middle of a polygon that is no quad.
    pub vertex: Option<u32>,
    /// Number of its edges.
    pub valence: u32,
    /// Whether it is not an ordinary vertex of its scheme.
    pub extraordinary: bool,
}

/// Letters.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Left end of the base line, in pixels.
    pub at: [f32; 2],
    /// Height of capitals, in pixels.
    pub height: f32,
    /// Printable ASCII.
    pub text: String,
}

/// Visible line work of one view.
#[derive(Clone, Debug)]
pub struct LineArt {
    /// The picture that it belongs to.
    pub size: ScreenSize,
    /// Lines, in the order in which they are drawn.
    pub polylines: Vec<Polyline>,
    /// Vertices that are marked.
    pub marks: Vec<Mark>,
    /// Letters and numbers.
    pub labels: Vec<Label>,
    /// What was looked at; [`FrameStats::levels`] says at which level lines were traced.
    pub stats: FrameStats,
    options: Options,
}

/// Lines, marks and covered pixels of a tile.
#[derive(Default)]
struct OfTile {
    pieces: Vec<Piece>,
    found: Vec<Found>,
    covered: u64,
}

/// Traces lines and draws them over a picture of the same view: [`trace`], then [`LineArt::draw`].
///
/// # Errors
/// As [`trace`].
pub fn draw(
    image: &mut Image,
    renderer: &Renderer,
    scene: &Scene,
    view: &View,
    options: &Options,
) -> Result<LineArt, RenderError> {
    let art = trace(renderer, scene, view, options)?;
    art.draw(image);
    Ok(art)
}

/// Finds the visible lines of `scene` in `view`, as `renderer` tessellates it. Runs on rayon's current thread pool; the result does not
/// depend on the number of threads.
///
/// # Errors
/// [`RenderError`]; [`LimitError::Memory`] also when there are more lines than memory allows.
pub fn trace(
    renderer: &Renderer,
    scene: &Scene,
    view: &View,
    options: &Options,
) -> Result<LineArt, RenderError> {
    let lens = Lens::new(view);
    let limits = &renderer.limits;
    let free = FreeLines::new(scene, options.layers, &lens, view.size, limits)?;
    let wants_marks =
        options.layers.contains(Layers::VALENCES) || options.layers.contains(Layers::LABELS);
    let share = rayon::current_num_threads() as u128;
    let (tiles, mut stats) = renderer.walk(scene, view, |walk| {
        let mut out = OfTile {
            covered: walk.covered(),
            ..OfTile::default()
        };
        let wanted = (options.layers, wants_marks);
        let (lines, found) = of_surface(walk, scene, wanted, &lens, limits)?;
        out.found = found;
        let near = free.near(walk.rect());
        let bytes = held(lines.len() + near.len(), out.found.len());
        limits.memory(TILES, bytes + free.bytes())?;
        let near = near.into_iter().map(|k| free.line(k));
        let surface = lines.into_iter().map(|line| (line, 0.0));
        let spots = out.found.iter().map(|f| f.spot);
        let mut visibility = Visibility::new(walk.rect(), surface.chain(near), spots);
        let bytes = visibility.bytes() * share;
        limits.memory(TILES, bytes + free.bytes())?;
        if visibility.is_empty() {
            return Ok(out);
        }
        let mut screen = Screen::new();
        walk.each(|_, block| {
            pass(block, &lens, &mut screen, &mut visibility);
            Ok(())
        })?;
        visibility.seen(|segment, ends| {
            if let Some(kind) = segment.kind(options.layers) {
                let ends = ends.map(|[x, y, _]| [x, y]);
                out.pieces.push(Piece { ends, kind });
            }
        });
        let mut seen = visibility.points_seen();
        out.found.retain(|_| seen.next() == Some(true));
        Ok(out)
    })?;
    stats.pixels_covered = tiles.iter().map(|t| t.covered).sum();
    let count: usize = tiles.iter().map(|t| t.pieces.len()).sum();
    // Pieces twice, joints, and polylines.
    let bytes = count as u128 * (2 * size_of::<Piece>() as u128 + 160);
    limits.memory("the lines of the picture", bytes)?;
    let mut pieces = Vec::with_capacity(count);
    let mut found = Vec::new();
    for tile in tiles {
        pieces.extend(tile.pieces);
        found.extend(tile.found);
    }
    let mut polylines = chain::join(&pieces);
    let size = view.size;
    let marks = marks::marks(scene, options.layers, found);
    let mut labels = Vec::new();
    let unit = options.style.unit_of(size);
    marks::annotate(
        scene,
        view,
        options.layers,
        unit,
        &marks,
        &mut polylines,
        &mut labels,
    );
    polylines.sort_by_key(|line| line.kind);
    Ok(LineArt {
        size,
        polylines,
        marks,
        labels,
        stats,
        options: *options,
    })
}

/// Micro-edges of a tile that are wanted and not plainly hidden, each once, and with `wants_marks` its vertices.
fn of_surface(
    walk: &mut Walk<'_>,
    scene: &Scene,
    (layers, wants_marks): (Layers, bool),
    lens: &Lens,
    limits: &Limits,
) -> Result<(Vec<Segment>, Vec<Found>), LimitError> {
    let mut collector = Collector::new(scene, layers, lens);
    let wants_surface = collector.wants_surface();
    let mut marks = Vec::new();
    if !wants_surface && !wants_marks {
        return Ok((Vec::new(), marks));
    }
    walk.each(|walk, block| {
        if wants_surface {
            collector.add(walk, block);
        }
        if wants_marks {
            marks::in_block(walk.rect(), block, lens, &mut marks);
        }
        limits.memory(TILES, held(collector.found.len(), marks.len()))
    })?;
    let mut found = collector.found;
    lines::join_equal(&mut found);
    found.retain(|line| line.kind(layers).is_some());
    marks::once(&mut marks);
    Ok((found, marks))
}

/// What messages call what is held while lines are traced.
const TILES: &str = "the lines of the tiles";

/// Bytes that so many lines and vertices of each tile come to: held as such, and again as what they are cut to, with cells and with what
/// hides them.
fn held(lines: usize, marks: usize) -> u128 {
    let bytes = lines as u128 * 6 * size_of::<Segment>() as u128
        + marks as u128 * 3 * size_of::<Found>() as u128;
    bytes * rayon::current_num_threads() as u128
}

/// Lets the triangles of a block hide what is behind them.
fn pass(block: &Block<'_>, lens: &Lens, screen: &mut Screen, visibility: &mut Visibility) {
    screen.project(lens, block.points, block.size);
    let mut hide = |corners: [usize; 3]| {
        let spots: [Spot; 3] = corners.map(|k| screen.spots[k]);
        if screen.is_clipped {
            let wide = corners.map(|k| &screen.wide[k]);
            lens.triangle(wide, |triangle| visibility.pass(triangle));
        } else {
            visibility.pass(spots);
        }
    };
    if let Some(list) = block.list {
        list.iter().for_each(|t| hide(t.map(usize::from)));
        return;
    }
    for j in 0..block.size.rows - 1 {
        for i in 0..block.size.cols - 1 {
            let k = j * BLOCK_STRIDE + i;
            let across = k + BLOCK_STRIDE + 1;
            hide([k, k + 1, across]);
            hide([k, across, k + BLOCK_STRIDE]);
        }
    }
}

impl LineArt {
    /// Draws it over a picture of its size, in sRGB values as browsers do.
    ///
    /// # Panics
    /// The picture has another size.
    pub fn draw(&self, image: &mut Image) {
        assert_eq!(
            (image.width, image.height),
            (self.size.width, self.size.height),
            "line work of another picture"
        );
        paint::paint(&paint::shapes(self), image);
    }

    /// An SVG document of its size that shows the same, on a background (sRGB with straight alpha) or on none.
    #[must_use]
    pub fn to_svg(&self, background: Option<[u8; 4]>) -> String {
        svg::document(self.size, &paint::shapes(self), background)
    }
}
