//! Adapters and devices: which there are, which one is taken, and how its errors become [`GpuError`]s.

use super::error::GpuError;
use super::flatness::FlatnessPipelines;
use super::pipelines::Pipelines;
use super::raster::{Measured, Raster};
use super::wgsl::Variant;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// What an adapter computes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdapterKind {
    /// A GPU with memory of its own.
    Discrete,
    /// A GPU that shares the processor's memory.
    Integrated,
    /// A GPU of a virtual machine, or one that does not say.
    Other,
    /// The processor itself.
    Software,
}

impl AdapterKind {
    fn of(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::Cpu => Self::Software,
            _ => Self::Other,
        }
    }

    /// Its name, as `earmark info --gpu` writes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Other => "other",
            Self::Software => "software",
        }
    }
}

/// What is known of an adapter, or of a device that was opened, which may use less than its adapter has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterSummary {
    /// Name of the device.
    pub name: String,
    /// What it computes on.
    pub kind: AdapterKind,
    /// Interface: `vulkan`, `metal`, `dx12`.
    pub backend: String,
    /// Driver, with its version.
    pub driver: String,
    /// Largest buffer that a shader can see, in bytes.
    pub max_binding: u64,
    /// Whether visibility keys take one pass: maxima of 64 bits.
    pub wide_atomics: bool,
    /// Whether stages can be timed on the device.
    pub timestamps: bool,
}

/// How a device is chosen.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Take adapters that compute on the processor, too.
    pub allow_software: bool,
    /// A part of the adapter's name, in any case; else the best there is.
    pub name: Option<String>,
    /// No larger bindings than this many bytes, for tests; 0 for what the device allows.
    pub max_binding: u64,
    /// Draw keys in two passes although one would do, for tests.
    pub two_pass: bool,
    /// What draws keys; [`GpuScene::raster_by`](super::GpuScene::raster_by) changes it for one scene. Scenes whose pictures are too large for
    /// the device's own rasteriser are refused where that alone is asked for, not drawn otherwise.
    pub raster: Raster,
}

fn instance() -> wgpu::Instance {
    let mut wanted = wgpu::InstanceDescriptor::new_without_display_handle();
    wanted.backends = wgpu::Backends::PRIMARY;
    wgpu::Instance::new(wanted)
}

/// What is said of an adapter, or of a device that was opened with less than its adapter has.
fn summary(
    info: wgpu::AdapterInfo,
    limits: &wgpu::Limits,
    features: wgpu::Features,
) -> AdapterSummary {
    AdapterSummary {
        name: info.name,
        kind: AdapterKind::of(info.device_type),
        backend: info.backend.to_str().to_owned(),
        driver: format!("{} {}", info.driver, info.driver_info)
            .trim()
            .to_owned(),
        max_binding: limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size),
        wide_atomics: features.contains(WIDE),
        timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
    }
}

fn summary_of_adapter(adapter: &wgpu::Adapter) -> AdapterSummary {
    summary(adapter.get_info(), &adapter.limits(), adapter.features())
}

/// Storage buffers that a stage of a picture binds.
const STORAGE_BUFFERS: u32 = 12;

/// What one-pass keys need.
const WIDE: wgpu::Features =
    wgpu::Features::SHADER_INT64.union(wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX);

/// All adapters of this machine; none where there is no driver. Needs no display.
#[must_use]
pub fn adapters() -> Vec<AdapterSummary> {
    let all = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::PRIMARY));
    all.iter().map(summary_of_adapter).collect()
}

/// A device that is open, with its queue.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    summary: AdapterSummary,
    /// Bytes of the largest binding that is used.
    pub(super) max_binding: u64,
    /// Bytes of the largest buffer.
    max_buffer: u64,
    pub(super) wide: bool,
    pub(super) timestamps: bool,
    /// What draws keys unless a scene is told otherwise.
    pub(super) raster: Raster,
    pub(super) measured: Measured,
    /// By the numbers of their variants, made when a picture first needs them.
    pipelines: [OnceLock<Pipelines>; Variant::COUNT],
    flatness: OnceLock<FlatnessPipelines>,
    failed: Arc<Mutex<Option<GpuError>>>,
}

impl Gpu {
    /// Opens the adapter that `options` ask for: among several, GPUs with memory of their own first.
    ///
    /// # Errors
    /// [`GpuError`] when there is none, or only software that was not allowed.
    pub fn open(options: &DeviceOptions) -> Result<Self, GpuError> {
        let mut all = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::PRIMARY));
        let names = |all: &[wgpu::Adapter]| {
            let names: Vec<String> = all.iter().map(|a| a.get_info().name).collect();
            names.join(", ")
        };
        if all.is_empty() {
            return Err(GpuError::NoAdapter);
        }
        if let Some(wanted) = &options.name {
            let every = names(&all);
            let lower = wanted.to_lowercase();
            all.retain(|a| a.get_info().name.to_lowercase().contains(&lower));
            if all.is_empty() {
                return Err(GpuError::NoSuchAdapter {
                    wanted: wanted.clone(),
                    names: every,
                });
            }
        }
        let kind = |a: &wgpu::Adapter| AdapterKind::of(a.get_info().device_type);
        if !options.allow_software {
            let every = names(&all);
            all.retain(|a| kind(a) != AdapterKind::Software);
            if all.is_empty() {
                return Err(GpuError::SoftwareOnly { names: every });
            }
        }
        all.sort_by_key(|a| match kind(a) {
            AdapterKind::Discrete => 0,
            AdapterKind::Integrated => 1,
            AdapterKind::Other => 2,
            AdapterKind::Software => 3,
        });
        Self::of_adapter(&all[0], options)
    }

    /// A device and queue of the caller's, which keep their own limits and features. Pictures are refused by devices whose stages bind fewer
    /// than 12 storage buffers; [`Refiner`](super::Refiner) needs 8, WebGPU's default.
    #[must_use]
    pub fn of_device(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let limits = device.limits();
        let summary = summary(device.adapter_info(), &limits, device.features());
        Self {
            device: device.clone(),
            queue: queue.clone(),
            max_binding: summary.max_binding,
            max_buffer: limits.max_buffer_size,
            wide: summary.wide_atomics,
            timestamps: summary.timestamps,
            raster: Raster::default(),
            measured: Measured::default(),
            summary,
            pipelines: Default::default(),
            flatness: OnceLock::new(),
            failed: Arc::default(),
        }
    }

    fn of_adapter(adapter: &wgpu::Adapter, options: &DeviceOptions) -> Result<Self, GpuError> {
        let mut summary = summary_of_adapter(adapter);
        if options.max_binding != 0 {
            summary.max_binding = summary.max_binding.min(options.max_binding);
        }
        summary.wide_atomics &= !options.two_pass;
        let optional = WIDE | wgpu::Features::TIMESTAMP_QUERY;
        let limits = adapter.limits();
        let wanted = wgpu::DeviceDescriptor {
            label: Some("earmark"),
            required_features: adapter.features() & optional,
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&wanted)).map_err(|e| GpuError::Device {
                reason: e.to_string(),
            })?;
        let gpu = Self {
            max_binding: summary.max_binding,
            max_buffer: limits.max_buffer_size,
            wide: summary.wide_atomics,
            timestamps: summary.timestamps,
            raster: options.raster,
            measured: Measured::default(),
            device,
            queue,
            summary,
            pipelines: Default::default(),
            flatness: OnceLock::new(),
            failed: Arc::default(),
        };
        gpu.listen();
        Ok(gpu)
    }

    /// Keeps the first error that nobody waits for.
    fn listen(&self) {
        let failed = Arc::clone(&self.failed);
        self.device.on_uncaptured_error(Arc::new(move |error| {
            keep(&failed, of_error(&error));
        }));
        let failed = Arc::clone(&self.failed);
        self.device.set_device_lost_callback(move |reason, text| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                let reason = format!("lost: {text}");
                keep(&failed, GpuError::Device { reason });
            }
        });
    }

    /// What the adapter is.
    #[must_use]
    pub fn adapter(&self) -> &AdapterSummary {
        &self.summary
    }

    /// The device, for who draws with it as well.
    #[must_use]
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Its queue.
    #[must_use]
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The pipelines of pictures.
    pub(super) fn pipelines(&self, variant: Variant) -> Result<&Pipelines, GpuError> {
        let kept = &self.pipelines[variant.number()];
        if let Some(made) = kept.get() {
            return Ok(made);
        }
        if self.device.limits().max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
            return Err(GpuError::Unsupported {
                what: "a device whose stages bind fewer than 12 storage buffers",
            });
        }
        let made = self.caught(|| Ok(Pipelines::new(self, variant)))?;
        // When another thread was first, its pipelines are the same.
        Ok(kept.get_or_init(|| made))
    }

    /// Those that decide on blocks.
    pub(super) fn flatness_pipelines(&self) -> Result<&FlatnessPipelines, GpuError> {
        if let Some(made) = self.flatness.get() {
            return Ok(made);
        }
        let made = self.caught(|| Ok(FlatnessPipelines::new(self)))?;
        Ok(self.flatness.get_or_init(|| made))
    }

    /// Does `work` and returns what the device has against it: nobody listens to a caller's device, and what nobody hears ends the program.
    pub(super) fn caught<T>(
        &self,
        work: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let [memory, internal, validation] = [
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::Validation,
        ]
        .map(|kind| self.device.push_error_scope(kind));
        let done = work();
        // Scopes end in the order opposite to that in which they began.
        let found = [validation, internal, memory].map(|scope| pollster::block_on(scope.pop()));
        let done = done?;
        match found.iter().flatten().next() {
            Some(error) => Err(of_error(error)),
            None => self.check().map(|()| done),
        }
    }

    /// The error that came since this was asked last.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.take().map_or(Ok(()), Err)
    }

    /// Waits until the device has done all it was given.
    pub(super) fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| GpuError::Device {
                reason: e.to_string(),
            })?;
        self.check()
    }

    /// A buffer with something in it.
    pub(super) fn filled(
        &self,
        label: &'static str,
        words: &[u32],
    ) -> Result<wgpu::Buffer, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.empty(label, 4 * words.len() as u64, usage)?;
        self.queue
            .write_buffer(&buffer, 0, bytemuck::cast_slice(words));
        Ok(buffer)
    }

    /// A buffer of zeros; never an empty one, which could not be bound.
    pub(super) fn empty(
        &self,
        label: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let most = match usage.contains(wgpu::BufferUsages::STORAGE) {
            true => self.max_binding.min(self.max_buffer),
            false => self.max_buffer,
        };
        let size = bytes.max(16).checked_next_multiple_of(16);
        let size = size
            .filter(|&size| size <= most)
            .ok_or(GpuError::OutOfMemory { what: label })?;
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        });
        match pollster::block_on(memory.pop()) {
            Some(_) => Err(GpuError::OutOfMemory { what: label }),
            None => self.check().map(|()| buffer),
        }
    }
}

fn keep(place: &Mutex<Option<GpuError>>, error: GpuError) {
    let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
    place.get_or_insert(error);
}

fn of_error(error: &wgpu::Error) -> GpuError {
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory {
            what: "this picture",
        },
        other => GpuError::Device {
            reason: other.to_string(),
        },
    }
}
