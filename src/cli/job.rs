//! What every verb works with: limits, clocks, threads, and the models it loads.

use super::exit::{Code, Failure};
use super::flags::{LevelFlags, ModelFlags, RunningFlags, Simd, scheme_name};
use super::machine::{address_space, default_memory, pool_of, threads};
use super::messages::{note, warning};
use super::pn_tags::PnTags;
use super::stats::{Clock, Json, Stages, held_bytes, peak_bytes, process_cpu_ms, reserved_bytes};
use super::watch::{self, Phase};
use earmark::files::{self, FolderResolver};
use earmark::frame::Object;
use earmark::limits::{Limits, Progress};
use earmark::load::{LoadOptions, Loader};
use earmark::mesh::resolver::{NoFiles, ResolveError, Resolver};
use earmark::mesh::{Cage, obj};
use earmark::refine::has_semi_sharp;
use earmark::simd::Level as SimdLevel;
use earmark::tessellate::depth_tags;
use earmark::topology::{Topology, TopologyWarning};
use earmark::{Scene, SurfaceOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// What messages call standard input.
const STDIN: &str = "standard input";

/// The bytes of a model, what messages call it, and what hands out the files that it names.
type Input = (Vec<u8>, String, Box<dyn Resolver>);

/// One run of the program.
pub(crate) struct Job {
    pub(crate) start: Instant,
    pub(crate) running: RunningFlags,
    pub(crate) simd: SimdLevel,
    pub(crate) threads: usize,
    pub(crate) stages: Stages,
    max_memory: Option<u64>,
    deadline: Option<(Instant, Duration)>,
    cancelled: Arc<AtomicBool>,
    progress: Arc<Progress>,
    /// Whether frames are timed stage by stage.
    pub(crate) measure: bool,
    /// Whether adaptive tessellation gives way to levels by the length of edges.
    #[cfg(feature = "window")]
    pub(crate) uniform: bool,
    /// What standard input held, where it was read before.
    pub(crate) stdin: Option<Arc<[u8]>>,
    /// A renderer that drew before, for its buffers.
    #[cfg(feature = "window")]
    pub(crate) kept: Option<earmark::Renderer>,
    /// The same on a GPU.
    #[cfg(feature = "window")]
    pub(crate) on_gpu: super::gpu::Kept,
    /// Files that models name.
    pub(crate) named: Vec<PathBuf>,
    /// Told of every stage that begins.
    pub(crate) tell: Option<Box<dyn Fn(&'static str) + Send>>,
}

impl Job {
    pub(crate) fn new(start: Instant, running: &RunningFlags) -> Result<Self, Failure> {
        let simd = SimdLevel::from_name(&running.simd.name())?;
        let deadline = running
            .timeout
            .and_then(|t| Some((start.checked_add(t)?, t)));
        Ok(Self {
            start,
            simd,
            threads: threads(running.threads),
            stages: Stages::default(),
            max_memory: running.max_memory.or_else(default_memory),
            deadline,
            cancelled: Arc::default(),
            progress: Arc::default(),
            measure: running.stats.is_some(),
            #[cfg(feature = "window")]
            uniform: false,
            stdin: None,
            #[cfg(feature = "window")]
            kept: None,
            #[cfg(feature = "window")]
            on_gpu: super::gpu::Kept::default(),
            named: Vec::new(),
            tell: None,
            running: running.clone(),
        })
    }

    /// A job within this one: its own flags and clocks; signals, threads and what is not in its flags are those of this one.
    pub(crate) fn inner(&self, running: Option<&RunningFlags>) -> Result<Self, Failure> {
        let plain = RunningFlags::default();
        let running = running.unwrap_or(&plain);
        let mut job = Self::new(Instant::now(), running)?;
        job.threads = self.threads;
        if running.simd == Simd::Auto {
            job.simd = self.simd;
        }
        job.max_memory = running.max_memory.or(self.max_memory);
        let deadlines = [job.deadline, self.deadline].into_iter().flatten();
        job.deadline = deadlines.min_by_key(|d| d.0);
        job.cancelled = Arc::clone(&self.cancelled);
        job.progress = Arc::clone(&self.progress);
        Ok(job)
    }

    /// Handlers of signals, deadline and progress.
    pub(crate) fn watch(&self) {
        watch::Watch {
            cancelled: Arc::clone(&self.cancelled),
            progress: Arc::clone(&self.progress),
            start: self.start,
            deadline: self.deadline,
            show: self.running.progress,
            quiet: self.running.quiet,
        }
        .start();
    }

    /// The thread pool that all of the work runs on.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        pool_of(self.threads)
    }

    /// The flag that ends the work.
    #[cfg(feature = "window")]
    pub(crate) fn cancelled(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.cancelled)
    }

    /// Lets another flag end the work.
    #[cfg(feature = "window")]
    pub(crate) fn set_cancelled(&mut self, cancelled: &Arc<AtomicBool>) {
        self.cancelled = Arc::clone(cancelled);
    }

    /// Limits for what is still to be done: memory that is held already is taken off.
    pub(crate) fn limits(&self) -> Limits {
        Limits {
            max_memory: self.memory_left(),
            max_faces: self.running.max_faces,
            deadline: self.deadline,
            cancelled: Arc::clone(&self.cancelled),
            progress: Arc::clone(&self.progress),
        }
    }

    /// Memory that may still be taken. A limit of address space counts what is reserved, as allocators do per thread, and is not used
    /// up to its end, because reservations grow by large steps.
    pub(crate) fn memory_left(&self) -> Option<u64> {
        let left = self.max_memory.map(|m| m.saturating_sub(held_bytes()));
        let space = address_space().map(|s| s.saturating_sub(reserved_bytes()) / 4 * 3);
        [left, space].into_iter().flatten().min()
    }

    /// Runs a stage with both clocks on.
    pub(crate) fn time<R>(&mut self, stage: &'static str, work: impl FnOnce(&mut Self) -> R) -> R {
        if let Some(tell) = &self.tell {
            tell(stage);
        }
        let clock = Clock::now();
        let result = work(self);
        self.stages.add(stage, clock.elapsed());
        result
    }

    /// Reads models into one scene and prints their warnings.
    pub(crate) fn load(
        &mut self,
        models: &[PathBuf],
        flags: &ModelFlags,
        level: &LevelFlags,
    ) -> Result<Scene, Failure> {
        watch::phase(Phase::Reading);
        let tags = PnTags::of(level, models.len())?;
        let mut loader = Loader::new(LoadOptions {
            surface: SurfaceOptions {
                patches: level.patches(),
                ..flags.surface()
            },
            ..LoadOptions::default()
        });
        loader.options_mut().read.up = flags.file_up();
        let mut names = Vec::new();
        for model in models {
            self.limits().check()?;
            let (read, name, mut resolver) = self.time("read", |job| {
                let (bytes, name, inner) = job.read_bytes(model, flags)?;
                if let Some(left) = job.memory_left() {
                    loader.options_mut().read.max_bytes = left;
                }
                let mut resolver = Asked {
                    inner,
                    folder: model.parent().unwrap_or(Path::new("")),
                    names: &mut names,
                };
                let read = loader.read(&bytes, &name, &mut resolver)?;
                let read = suitable(read, &bytes, &name, flags, flags.triangulate)?;
                Ok::<_, Failure>((read, name, resolver))
            })?;
            let obj::Read { cage, report, .. } = read;
            let faces = cage.face_count();
            self.limits().check()?;
            note(&format!(
                "{name}: {} faces, {} vertices; scheme {}",
                cage.face_count(),
                cage.points().len(),
                scheme_name(flags.scheme_of(&cage))
            ));
            if let Some(left) = self.memory_left() {
                loader.options_mut().max_surface = left;
            }
            self.time("connect", |job| {
                let line = |face| job.line_of_face(model, flags, (&report, faces), face);
                loader.add_cage_of_lines(cage, &name, &mut resolver, &line)
            })?;
        }
        self.named.append(&mut names);
        let (mut scene, warnings) = loader.finish();
        if let Some(tags) = tags {
            self.time("read", |job| tags.apply(&mut scene, job.memory_left()))?;
        }
        for w in &warnings {
            warning(w);
        }
        let fades = |o: &&Object| {
            o.surface.scheme().is_interpolating() && has_semi_sharp(o.surface.topology())
        };
        if let Some(object) = scene.objects.iter().find(fades) {
            warning(&format!(
                "semi-sharp creases and corners mean nothing to --scheme {}, and are ignored",
                scheme_name(object.surface.scheme())
            ));
        }
        Ok(scene)
    }

    /// Reads the file of `--depth-tags`, if it is one, for the one model of a scene.
    pub(crate) fn read_depth_tags(
        &mut self,
        scene: &mut Scene,
        flags: &LevelFlags,
    ) -> Result<(), Failure> {
        /// Bytes of a tag with its line, and of what may stand between: more is no file of tags.
        const PER_TAG: u64 = 64;
        let Some(path) = flags.tag_file() else {
            return Ok(());
        };
        let [object] = scene.objects.as_mut_slice() else {
            return Err(Failure::usage(
                "a file of --depth-tags belongs to one model; draw models one by one",
            ));
        };
        let vertices = object.surface.cage().points().len();
        self.time("read", |job| {
            let most = (vertices as u64 * PER_TAG).max(1 << 16);
            let most = most.min(job.memory_left().unwrap_or(u64::MAX));
            let text = files::read_model(path, most)?;
            let name = obj::escape(path.as_os_str().as_encoded_bytes(), 1024);
            object.depth_tags = depth_tags::parse(&text, &name, vertices)
                .map_err(|e| Failure::new(Code::Data, e.to_string()))?;
            Ok(())
        })
    }

    /// Reads one model as it stands, with all that the reader has to say. A scheme of the flags that takes triangles only wants to find
    /// nothing else, unless `any_faces`.
    pub(crate) fn read_cage(
        &mut self,
        model: &Path,
        flags: &ModelFlags,
        any_faces: bool,
    ) -> Result<obj::Read, Failure> {
        watch::phase(Phase::Reading);
        self.time("read", |job| {
            let (bytes, name, mut resolver) = job.read_bytes(model, flags)?;
            let mut options = obj::ReadOptions {
                up: flags.file_up(),
                ..obj::ReadOptions::default()
            };
            if let Some(left) = job.memory_left() {
                options.max_bytes = left;
            }
            let read = obj::read(&bytes, &name, resolver.as_mut(), &options)?;
            suitable(read, &bytes, &name, flags, any_faces)
        })
    }

    /// Warnings about a model, with lines where they are about faces.
    pub(crate) fn said(
        &self,
        model: &Path,
        flags: &ModelFlags,
        read: &obj::Read,
        (t, warnings): (&Topology, &[TopologyWarning]),
    ) -> Vec<String> {
        let name = obj::escape(model.as_os_str().as_encoded_bytes(), 1024);
        let of = (&read.report, read.cage.face_count());
        let place = |w: &TopologyWarning| {
            w.face(t)
                .and_then(|face| self.line_of_face(model, flags, of, face))
        };
        let said = |w: &TopologyWarning| match place(w) {
            Some(line) => format!("{name}:{line}: {w}"),
            None => format!("{name}: {w}"),
        };
        warnings.iter().map(said).collect()
    }

    /// The line of a face of a model that was read with `report` into so many faces. The text is not kept: it is read once more, and where
    /// that is not possible, or triangles took the place of its faces, there is no line.
    fn line_of_face(
        &self,
        model: &Path,
        flags: &ModelFlags,
        (report, faces): (&obj::Report, usize),
        face: u32,
    ) -> Option<usize> {
        if model.as_os_str() == "-" || faces + report.dropped_faces.len() != report.faces {
            return None;
        }
        let (bytes, ..) = self.read_bytes(model, flags).ok()?;
        // But for a byte-order mark.
        let same = matches!(bytes.len().checked_sub(report.bytes), Some(0 | 3));
        same.then(|| obj::line_of_face(&bytes, report, face))?
    }

    /// Opens a model.
    fn read_bytes(&self, model: &Path, flags: &ModelFlags) -> Result<Input, Failure> {
        let most = self.memory_left().unwrap_or(u64::MAX);
        if model.as_os_str() != "-" {
            let bytes = files::read_model(model, most)?;
            let resolver = FolderResolver::beside(model)?;
            return Ok((bytes, model.display().to_string(), Box::new(resolver)));
        }
        let bytes = match &self.stdin {
            Some(bytes) => bytes.to_vec(),
            None => self.read_stdin(flags, most)?,
        };
        // It has no folder, so the files that it names are not looked for.
        Ok((bytes, STDIN.to_owned(), Box::new(NoFiles)))
    }

    /// A model from standard input.
    pub(crate) fn read_stdin(&self, flags: &ModelFlags, most: u64) -> Result<Vec<u8>, Failure> {
        if flags.format.is_none() {
            return Err(Failure::usage(
                "a model from standard input needs --format obj",
            ));
        }
        Ok(files::read_stream(STDIN, io::stdin().lock(), most)?)
    }

    /// The members that every JSON report begins with; `middle` comes between.
    pub(crate) fn report(&self, model: Json, middle: Vec<(&str, Json)>) -> Vec<(String, Json)> {
        let mut members = vec![
            ("version", Json::text(env!("CARGO_PKG_VERSION"))),
            ("model", model),
        ];
        members.extend(middle);
        members.extend([
            ("threads", Json::count(self.threads)),
            ("simd", Json::text(self.simd.name())),
            ("peak_bytes", peak_bytes().map_or(Json::Null, Json::Whole)),
            (
                "wall_ms",
                Json::Number(self.start.elapsed().as_secs_f64() * 1e3),
            ),
            ("cpu_ms", Json::Number(process_cpu_ms())),
            ("stages", self.stages.json()),
        ]);
        members
            .into_iter()
            .map(|(k, v)| (k.to_owned(), v))
            .collect()
    }
}

/// A resolver that keeps the names of the files it is asked for.
struct Asked<'a> {
    inner: Box<dyn Resolver>,
    folder: &'a Path,
    names: &'a mut Vec<PathBuf>,
}

impl Resolver for Asked<'_> {
    fn read(&mut self, name: &str, max_bytes: u64) -> Result<Vec<u8>, ResolveError> {
        self.names.push(self.folder.join(name));
        self.inner.read(name, max_bytes)
    }
}

/// The same, with triangles in place of all faces where the scheme of the flags takes triangles only; finding others is an error unless
/// `any_faces`.
fn suitable(
    mut read: obj::Read,
    bytes: &[u8],
    name: &str,
    flags: &ModelFlags,
    any_faces: bool,
) -> Result<obj::Read, Failure> {
    let triangular = flags.named_scheme().filter(|s| s.is_triangular());
    match (triangular, read.cage.first_polygon()) {
        (Some(scheme), Some(f)) if !any_faces => {
            let place = match obj::line_of_face(bytes, &read.report, f) {
                Some(line) => format!("{name}:{line}: this face"),
                None => format!("{name}: face {f} (0-based)"),
            };
            Err(Failure::new(
                Code::Data,
                format!(
                    "{place} has {} corners, and --scheme {} takes triangles only; --triangulate makes triangles of all faces",
                    read.cage.face(f as usize).len(),
                    scheme_name(scheme)
                ),
            ))
        }
        (Some(_), Some(_)) => {
            read.cage = read.cage.triangulated();
            Ok(read)
        }
        _ => Ok(read),
    }
}

/// The models of a report: one name, or a list.
pub(crate) fn model_names(models: &[PathBuf]) -> Json {
    let mut names: Vec<Json> = models
        .iter()
        .map(|m| Json::text(m.display().to_string()))
        .collect();
    match names.len() {
        1 => names.remove(0),
        _ => Json::List(names),
    }
}

/// A cage's first and last coordinates with its origin, in double precision.
pub(crate) fn bounds(cage: &Cage) -> [[f64; 3]; 2] {
    let origin = cage.origin();
    cage.bounds()
        .map(|p| std::array::from_fn(|k| f64::from(p[k]) + origin[k]))
}
