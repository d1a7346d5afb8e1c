//! What draws the keys of a scene: as its device was opened, as the caller says, or by measurement.

use super::draw::GpuScene;
use super::error::GpuError;
use super::raster::Raster;
use super::read_back::read_floats;
use std::sync::PoisonError;
use std::time::Duration;

impl GpuScene<'_> {
    /// Changes what draws keys from the next picture on. [`Raster::Measured`] draws a few pictures at once, unless the device has been
    /// measured at this size already.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the device's own rasteriser is asked for and its targets are smaller than the picture; otherwise
    /// [`GpuError`] of the device.
    pub fn raster_by(&mut self, raster: Raster) -> Result<(), GpuError> {
        match raster {
            Raster::Compute => {
                self.bands.by_hardware = None;
                Ok(())
            }
            Raster::Hardware => self.by_hardware(),
            Raster::Measured => self.by_measurement(),
        }
    }

    /// The keys of the last band that was drawn, for tests: per sample the complement of the id, and its depth, or zeros.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    #[doc(hidden)]
    pub fn read_keys(&self) -> Result<Vec<[u32; 2]>, GpuError> {
        let keys = &self.bands.keys;
        let floats = read_floats(self.gpu, keys, keys.size())?;
        let pairs = floats.as_chunks::<2>().0.iter();
        Ok(pairs.map(|pair| pair.map(f32::to_bits)).collect())
    }

    fn by_hardware(&mut self) -> Result<(), GpuError> {
        if self.bands.by_hardware.is_none() {
            let gpu = self.gpu;
            gpu.caught(|| self.bands.make_hardware(gpu, self.pipelines, &self.chunks))?;
            // Blocks that the device decides on are sorted when it does.
            self.decided_for = None;
        }
        Ok(())
    }

    fn by_measurement(&mut self) -> Result<(), GpuError> {
        let triangles = self.planned_triangles().checked_ilog2().unwrap_or(0);
        let size = self.drawn.size;
        let key = [size.width, size.height, size.samples, triangles];
        let gpu = self.gpu;
        let known = || gpu.measured.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&key).copied();
        if let Some(found) = found {
            return self.raster_by(found);
        }
        let by_compute = self.spent(Raster::Compute)?;
        // What a device cannot do it does slower than anything.
        let best = match self.spent(Raster::Hardware) {
            Ok(spent) if spent < by_compute => Raster::Hardware,
            Ok(_) | Err(_) => Raster::Compute,
        };
        // When another thread was first, what it found holds.
        let chosen = *known().entry(key).or_insert(best);
        self.raster_by(chosen)
    }

    /// How long a picture takes.
    fn spent(&mut self, raster: Raster) -> Result<Duration, GpuError> {
        self.raster_by(raster)?;
        // What is done once is done with the first.
        self.draw()?;
        let again = [self.draw()?, self.draw()?].map(|f| f.stats.wall);
        Ok(again[0].min(again[1]))
    }
}
