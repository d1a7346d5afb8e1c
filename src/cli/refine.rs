//! `earmark refine`: the refined mesh as a file.

use super::displace::DisplaceFlags;
use super::exit::{Code, Failure};
use super::flags::{ModelFlags, RunningFlags, scheme_name};
use super::job::{Job, model_names};
use super::messages::{note, warning};
use super::outputs::{Output, Staged, commit_all};
use super::render::{input_paths, stats_output};
use super::stats::{Clock, Json, Time};
use super::watch::{self, Phase};
use clap::Args;
use earmark::Surface;
use earmark::files;
use earmark::mesh::NONE;
use earmark::mesh::write::{self, MeshTags, PlyFormat, WriteOptions};
use earmark::refine::{
    Level, Limit, Options, RefineError, Timings, counts, has_semi_sharp, limit, stencils,
};
use earmark::surface::SurfaceOptions;
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model (OBJ); - is standard input
    #[arg(value_name = "MODEL")]
    pub(crate) model_path: PathBuf,
    /// Mesh to write (.obj or .ply); - is standard output, as OBJ
    #[arg(short, long, value_name = "OUT.obj")]
    pub(crate) output: PathBuf,
    /// Steps of refinement, 0 to 10
    #[arg(short, long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=10), allow_hyphen_values = true)]
    pub(crate) level: u32,
    /// Write limit positions and unit limit normals in place of control points; displacement does so too
    #[arg(long)]
    pub(crate) limit: bool,
    /// Also write the stencils: for every point of the mesh the weights of the cage's points, with --limit also those of two tangents.
    /// A .json file is text, any other bytes, little-endian: "EARSTEN1"; cage points, rows, entries, weights per entry (1, or 3 with
    /// tangents) as u64; offsets of rows (u64, one more than rows), cage points of entries (u32), weights of entries (f32): all of the
    /// points, then all of the first tangents, then all of the second
    #[arg(long, value_name = "OUT")]
    pub(crate) stencils: Option<PathBuf>,
    /// Write hole faces too, tagged as holes, so that an OBJ of control points refines further as its cage does
    #[arg(long)]
    pub(crate) keep_holes: bool,
    #[command(flatten)]
    pub(crate) displace: DisplaceFlags,
    #[command(flatten)]
    pub(crate) model: ModelFlags,
    #[command(flatten)]
    pub(crate) running: RunningFlags,
}

/// Most faces without `--max-faces`.
const MAX_FACES: u64 = 100_000_000;
/// Bytes per corner of a cage as a surface, its own copy included.
const SURFACE_BYTES: u128 = 400;
/// Bytes per vertex of limit points, normals, and what they are collected in.
const LIMIT_BYTES: u128 = 120;

impl From<RefineError> for Failure {
    fn from(e: RefineError) -> Self {
        let code = match e {
            RefineError::WrongCount { .. } => Code::Internal,
            RefineError::NotTriangle { .. } => Code::Data,
            _ => Code::Limit,
        };
        Self::new(code, format!("earmark: {e}"))
    }
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    let path = a.model_path.as_path();
    let models = [a.model_path.clone()];
    let mut inputs = input_paths(&models);
    inputs.extend(a.displace.displace.as_deref());
    let displacement = job.time("read", |job| a.displace.displacement(job))?;
    let output = Output::checked(&a.output, &["obj", "ply"], &inputs)?;
    let stats = match &a.running.stats {
        Some(stats) => Some(stats_output(stats, &a.output, &inputs)?),
        None => None,
    };
    let weights = match &a.stencils {
        Some(stencils) => Some(stencils_output(stencils, a, &inputs)?),
        None => None,
    };
    let read = job.read_cage(path, &a.model, a.model.triangulate)?;
    for w in &read.warnings {
        warning(&w.to_string());
    }
    let scheme = a.model.scheme_of(&read.cage);
    let cage = &read.cage;
    let (topology, warnings) = job.time("connect", |_| a.model.connect(cage));
    for w in job.said(path, &a.model, &read, (&topology, &warnings)) {
        warning(&w);
    }
    if scheme.is_interpolating() && has_semi_sharp(&topology) {
        let name = scheme_name(scheme);
        warning(&format!(
            "{}: semi-sharp creases and corners mean nothing to --scheme {name}, and are ignored",
            path.display()
        ));
    }
    let tags = cage.tags();
    let flags = a.model.surface();
    let rule = a.model.face_varying(cage);
    let options = Options {
        scheme,
        creases: flags.creases.or(tags.crease_method).unwrap_or_default(),
        triangles: flags.triangles.or(tags.triangles).unwrap_or_default(),
    };
    let base = job.time("connect", |_| {
        Level::<f32>::of_cage(cage, topology, options.scheme, rule)
    })?;
    let boundary = a.model.boundary(cage);
    let mut staged = Vec::new();
    if let Some(output) = &weights {
        staged.push(write_stencils(job, a, output, &base, &options)?);
    }
    let (level, mut limit) = refine(job, a, base, &options)?;
    if let (Some(displacement), Some(limit)) = (displacement, &mut limit) {
        if displacement.needs_uvs() && cage.uvs().is_empty() {
            warning(
                "the model has no texture coordinates: --displace moves everything by the map's lower left corner",
            );
        }
        let corners = cage.corner_vertices().len() as u128;
        let wanted = corners * SURFACE_BYTES;
        job.limits().memory("the displaced surface", wanted)?;
        job.time("displace", |_| {
            let options = SurfaceOptions {
                scheme: Some(scheme),
                ..flags
            };
            let mut surface = Surface::new(cage.clone(), &options);
            let displacement = displacement.relative_to(cage.origin());
            surface.set_displacement(Some(displacement));
            surface.displace_limit(a.level, &level.topology, limit);
        });
    }

    watch::phase(Phase::Writing);
    job.limits().check()?;
    let library = library_line(path, &a.output, &read.report.libraries);
    let of_faces: Vec<u32> = (0..cage.face_count())
        .map(|f| cage.face_material_index(f).map_or(NONE, |m| m as u32))
        .collect();
    let options = WriteOptions {
        limit: limit.as_ref(),
        origin: cage.origin(),
        materials: (!cage.materials().is_empty()).then_some((cage.materials(), &of_faces)),
        material_library: library.as_deref(),
        tags: Some(MeshTags {
            boundary,
            creases: options.creases,
            face_varying: rule,
            triangles: options.triangles,
        }),
        triangulate: a.model.triangulate,
        holes: a.keep_holes,
    };
    let ply = a
        .output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    let written = job.time("write", |_| {
        output.stage_with(|mut out| {
            if ply {
                write::ply(&mut out, &level, &options, PlyFormat::default())
            } else {
                write::obj(&mut out, &level, &options)
            }
        })
    })?;
    let faces = level.topology.face_count();
    note(&format!(
        "scheme {}: {faces} faces, {} vertices, {:.0} ms",
        scheme_name(scheme),
        level.points.len(),
        job.start.elapsed().as_secs_f64() * 1e3
    ));
    staged.push(written);
    if let Some(stats) = stats {
        let middle = vec![
            ("faces", Json::count(cage.face_count())),
            ("refined_faces", Json::count(faces)),
            ("refined_vertices", Json::count(level.points.len())),
        ];
        let report = Json::Object(job.report(model_names(&models), middle));
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    commit_all(staged)
}

/// Where stencils go, which is nowhere else.
fn stencils_output(path: &Path, a: &Arguments, inputs: &[&Path]) -> Result<Output, Failure> {
    let others = [
        ("--output", Some(&a.output)),
        ("--stats", a.running.stats.as_ref()),
    ];
    for (name, other) in others {
        if other.is_some_and(|o| o == path || files::same_file(o, path)) {
            let message = format!("{name} and --stencils are the same");
            return Err(Failure::usage(message));
        }
    }
    Output::checked(path, &[], inputs)
}

/// Finds the stencils of what is written, and stages them.
fn write_stencils(
    job: &mut Job,
    a: &Arguments,
    output: &Output,
    base: &Level<f32>,
    options: &Options,
) -> Result<Staged, Failure> {
    let limits = job.limits();
    limits.check()?;
    limits.faces(counts(&base.topology, options.scheme, a.level).faces)?;
    watch::phase(Phase::Refining);
    let found = job.time("stencils", |_| {
        stencils(&base.topology, options, a.level, a.limit, limits.max_memory)
    })?;
    limits.check()?;
    watch::phase(Phase::Writing);
    let text = (a.stencils.iter()).any(|p| {
        p.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("json"))
    });
    job.time("write", |_| {
        output.stage_with(|mut out| {
            if text {
                found.write_json(&mut out)
            } else {
                found.write_bytes(&mut out)
            }
        })
    })
}

/// Refines step by step, and finds the limit points where they are asked for. What it will take is found before.
fn refine(
    job: &mut Job,
    a: &Arguments,
    base: Level<f32>,
    options: &Options,
) -> Result<(Level<f32>, Option<Limit<f32>>), Failure> {
    let limits = {
        let mut limits = job.limits();
        limits.max_faces.get_or_insert(MAX_FACES);
        limits
    };
    let last = counts(&base.topology, options.scheme, a.level);
    limits.faces(last.faces)?;
    if last.corners >= u128::from(NONE) {
        return Err(RefineError::TooManyCorners {
            level: a.level,
            corners: last.corners,
        }
        .into());
    }
    let wants_limit = a.limit || a.displace.is_on();
    let limit_bytes = if wants_limit { LIMIT_BYTES } else { 0 };
    let wanted = base.predicted_bytes(options.scheme, a.level) + last.vertices * limit_bytes;
    limits.memory("the refined mesh", wanted)?;

    watch::phase(Phase::Refining);
    let clock = Clock::now();
    let mut timings = Timings::default();
    let mut level = base;
    for _ in 0..a.level {
        limits.check()?;
        level = level.next(options, &mut timings)?;
    }
    let spent = clock.elapsed();
    let passes = [
        ("face", timings.face),
        ("edge", timings.edge),
        ("vertex", timings.vertex),
        ("connectivity", timings.connectivity),
    ];
    for (name, time) in passes {
        let wall = time.as_secs_f64() * 1e3;
        // All passes use the same threads.
        let cpu = spent.cpu * wall / spent.wall.max(1e-9);
        job.stages.add(name, Time { wall, cpu });
    }
    limits.check()?;
    let points = wants_limit.then(|| job.time("limit", |_| limit(&level, options)));
    Ok((level, points))
}

/// The material libraries of the model, as the output names them; none when they cannot be named from there.
fn library_line(model: &Path, output: &Path, libraries: &[String]) -> Option<String> {
    if libraries.is_empty() || model.as_os_str() == "-" || output.as_os_str() == "-" {
        return None;
    }
    let folder = |p: &Path| match p.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => fs::canonicalize(parent).ok(),
        _ => fs::canonicalize(".").ok(),
    };
    let (from, to) = (folder(output)?, folder(model)?);
    let shared = from
        .components()
        .zip(to.components())
        .take_while(|(a, b)| a == b)
        .count();
    let mut way = PathBuf::new();
    for _ in from.components().skip(shared) {
        way.push("..");
    }
    way.extend(to.components().skip(shared));
    let names: Vec<String> = libraries
        .iter()
        .map(|l| way.join(l).to_str().map(|s| s.replace('\\', "/")))
        .collect::<Option<_>>()?;
    Some(names.join(" "))
}
