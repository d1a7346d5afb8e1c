//! Signed coverage of a frame: at every sample of a closed model the surfaces seen from the front and from behind must be equal in
//! number. Tests hold the whole way from dicing to coverage against this, on the very blocks and bins that pictures are made of.

use super::prepared::SourceScratch;
use super::spot::Shape;
use super::{Frame, RenderError, Renderer, Scene, Use};
use crate::camera::View;
use crate::raster::{
    Coverage, Fault, Path, ProjectedBlock, Tile, draw_apart_with, draw_block_with, draw_list_with,
    project,
};
use crate::records::Grid3;
use rayon::prelude::*;

/// What is broken on purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoverageFault {
    /// Nothing.
    #[default]
    None,
    /// Samples on an edge are not given to one side.
    NoTieRule,
    /// A corner of one face is moved by 1/256 pixel.
    MovedCorner,
}

/// Counts of one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SignedCoverage {
    /// Samples looked at.
    pub samples: u64,
    /// Samples that anything covers.
    pub covered: u64,
    /// Samples with unequal numbers of front and back surfaces.
    pub unequal: u64,
}

impl Renderer {
    /// Counts fronts and backs at every sample of `scene` in `view`, with nothing culled.
    ///
    /// # Errors
    /// As [`Renderer::render_view`].
    pub fn signed_coverage(
        &self,
        scene: &Scene,
        view: &View,
        fault: CoverageFault,
    ) -> Result<SignedCoverage, RenderError> {
        self.with_frame(scene, view, Use::Picture, |frame, _| {
            let tiles: Vec<SignedCoverage> = (0..frame.grid.len())
                .into_par_iter()
                .map(|t| tile_coverage(frame, t, fault))
                .collect();
            let mut counts = SignedCoverage::default();
            for t in tiles {
                counts.samples += t.samples;
                counts.covered += t.covered;
                counts.unequal += t.unequal;
            }
            Ok(counts)
        })
    }
}

fn tile_coverage(frame: &Frame<'_>, tile: usize, fault: CoverageFault) -> SignedCoverage {
    let [x0, y0, width, height] = frame.grid.rect(tile);
    let mut cells: Tile<Coverage> = Tile::new(x0, y0, width, height, frame.size.samples);
    let (mut scratch, mut points, mut projected) = (
        SourceScratch::new(frame.simd),
        Grid3::boxed(),
        ProjectedBlock::boxed(),
    );
    let rule = if fault == CoverageFault::NoTieRule {
        Fault::NoTieRule
    } else {
        Fault::None
    };
    for &item in frame.bins.items(tile) {
        let source = frame.source_of(item);
        let local = item - source.first_item;
        let [nu, nv] = source.blocks();
        let all = (0..nu * nv).map(|b| [b % nu, b / nu]);
        for block in all.filter(|&b| source.has_block(b)) {
            source.dice(&mut scratch, local, block, &mut points, None);
            project(
                frame.simd,
                &points,
                source.block_size(local),
                &frame.view.projection,
                &mut projected,
            );
            if fault == CoverageFault::MovedCorner && item % 7 == 3 {
                projected.nudge(0, 0, 1);
            }
            match source.shape(local) {
                Shape::Grid => {
                    draw_block_with(frame.simd, &mut cells, &projected, 0, Path::Auto, rule);
                }
                Shape::Apart => draw_apart_with(frame.simd, &mut cells, &projected, 0, rule),
                Shape::List(list) => {
                    draw_list_with(frame.simd, &mut cells, &projected, list, 0, rule);
                }
            }
        }
    }
    let mut out = SignedCoverage::default();
    for sample in 0..frame.size.samples {
        for y in 0..height {
            for c in cells.row(y, sample) {
                out.samples += 1;
                out.covered += u64::from(c.hits > 0);
                out.unequal += u64::from(c.balance != 0);
            }
        }
    }
    out
}
