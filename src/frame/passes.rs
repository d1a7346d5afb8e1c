//! The two passes over a frame that run in parallel: screen boxes of its items, then its tiles.

use super::aov::{self, Plane};
use super::stats::{FrameStats, Stage, StageTimes};
use super::tile::{self, Scratch};
use super::{Frame, Renderer};
use crate::film::Image;
use crate::limits::LimitError;
use crate::raster::PixelBox;
use crate::simd::Level;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Buffers of threads, kept from frame to frame: fresh memory for every tile costs more than the tile.
#[derive(Default)]
pub(super) struct ScratchPool(Mutex<Vec<Scratch>>);

impl std::fmt::Debug for ScratchPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ScratchPool")
    }
}

impl ScratchPool {
    pub(super) fn take(&self, samples: u32, simd: Level) -> Scratch {
        let kept = self.0.lock().ok().and_then(|mut pool| {
            let k = pool.iter().rposition(|s| s.fits(samples, simd))?;
            Some(pool.swap_remove(k))
        });
        kept.unwrap_or_else(|| Scratch::new(samples, simd))
    }
    pub(super) fn give_back(&self, mut scratch: Scratch) {
        scratch.forget_scene();
        if let Ok(mut pool) = self.0.lock() {
            pool.push(scratch);
        }
    }
}

impl Renderer {
    /// Screen boxes of all items, in parallel.
    pub(super) fn setup(
        &self,
        frame: &Frame<'_>,
        item_count: u32,
        diced: &mut u64,
    ) -> Result<Vec<Option<PixelBox>>, LimitError> {
        let points = AtomicU64::new(0);
        let mut boxes = vec![None; item_count as usize];
        const CHUNK: usize = 64;
        boxes
            .par_chunks_mut(CHUNK)
            .enumerate()
            .try_for_each(|(k, chunk)| {
                self.limits.check()?;
                let mut scratch = self.scratch.take(frame.size.samples, self.simd);
                let Scratch { source, hull, .. } = &mut scratch;
                for (i, out) in chunk.iter_mut().enumerate() {
                    let item = (k * CHUNK + i) as u32;
                    let of = frame.source_of(item);
                    *out = tile::item_box(frame, of, item - of.first_item, source, hull);
                }
                points.fetch_add(source.take_diced(), Ordering::Relaxed);
                self.scratch.give_back(scratch);
                Ok(())
            })?;
        *diced = points.into_inner();
        Ok(boxes)
    }

    /// Draws all tiles, in parallel.
    pub(super) fn tiles(
        &self,
        frame: &Frame<'_>,
        stats: &mut FrameStats,
    ) -> Result<(Image, Vec<Plane>), LimitError> {
        self.limits.progress.begin(frame.grid.len() as u64);
        let size = [self.size.width, self.size.height];
        let mut image = match frame.film.empty() {
            [0, 0, 0, 0] => Image::new(size[0], size[1]),
            empty => Image::filled(size, empty),
        };
        let (line, side) = (self.size.width as usize * 4, frame.grid.side() as usize);
        // Those with the most to do first, so that no thread is left alone with one at the end.
        let mut order: Vec<usize> = (0..frame.grid.len()).collect();
        order.sort_by_key(|&tile| Reverse(frame.bins.items(tile).len()));
        let next = AtomicUsize::new(0);
        // Rows of tiles, each behind a lock that is held while a tile's pixels are copied in.
        let bands: Vec<Mutex<&mut [u8]>> =
            image.data.chunks_mut(line * side).map(Mutex::new).collect();
        let mut planes = frame.wanted.planes(self.size.width, self.size.height);
        let plane_bands: Vec<Vec<Mutex<&mut [u8]>>> = planes
            .iter_mut()
            .map(|p| {
                let bytes = self.size.width as usize * p.aov.pixel_bytes() * side;
                p.data.chunks_mut(bytes).map(Mutex::new).collect()
            })
            .collect();
        let points = AtomicU64::new(0);
        let (covered, times) = (0..frame.grid.len())
            .into_par_iter()
            .with_max_len(1)
            .map(|_| {
                self.limits.check()?;
                let tile = order[next.fetch_add(1, Ordering::Relaxed)];
                let mut scratch = self.scratch.take(self.size.samples, self.simd);
                scratch.times = StageTimes::measuring(self.measure);
                let covered = tile::draw_tile(frame, tile, &mut scratch);
                let clock = scratch.times.start();
                let [x, _, width, _] = frame.grid.rect(tile);
                if let Ok(mut band) = bands[tile / frame.grid.cols() as usize].lock() {
                    for (to, (from, row)) in band.chunks_exact_mut(line).zip(scratch.shown_rows()) {
                        let at = (x + from) as usize * 4;
                        to[at..at + row.len() * 4].copy_from_slice(row.as_flattened());
                    }
                }
                let wanted = frame.wanted.aovs.iter();
                let outputs = wanted.zip(&plane_bands).zip(&scratch.planes.rows);
                for ((aov, bands), rows) in outputs {
                    if let Ok(mut band) = bands[tile / frame.grid.cols() as usize].lock() {
                        let size = aov.pixel_bytes();
                        aov::copy_rows(&mut band, rows, self.size.width, [x, width], size);
                    }
                }
                scratch.times.stop(Stage::Film, clock);
                let times = scratch.times;
                points.fetch_add(scratch.source.take_diced(), Ordering::Relaxed);
                self.scratch.give_back(scratch);
                Ok((covered, times))
            })
            .try_reduce(
                || (0, StageTimes::default()),
                |mut a, b| {
                    a.0 += b.0;
                    a.1.add(&b.1);
                    Ok(a)
                },
            )?;
        drop(bands);
        drop(plane_bands);
        stats.diced += points.into_inner();
        stats.pixels_covered += covered;
        stats.times.add(&times);
        Ok((image, planes))
    }
}
