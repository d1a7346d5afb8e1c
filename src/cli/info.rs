//! `earmark info`: what a file holds, and what had to be assumed where it says nothing.

use super::exit::Failure;
use super::flags::{ModelFlags, RunningFlags, scheme_name};
use super::job::{Job, bounds};
use super::messages::warning;
use super::outputs::{commit_all, print_text};
use super::render::stats_output;
use super::stats::Json;
use clap::Args;
use earmark::mesh::obj::{Report, escape};
use earmark::mesh::{Cage, NONE};
use earmark::scheme::{Boundary, CreaseMethod, FaceVaryingRule, INFINITE_SHARPNESS, TriangleRule};
use earmark::topology::{FanRule, Topology};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model (OBJ); - is standard input
    #[arg(value_name = "MODEL", required_unless_present = "gpu")]
    pub(crate) model_path: Option<PathBuf>,
    /// List the GPU adapters of this machine, in place of a model
    #[arg(long, conflicts_with_all = ["model_path", "stats"])]
    pub(crate) gpu: bool,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) model: ModelFlags,
    #[command(flatten)]
    pub(crate) running: RunningFlags,
}

/// A rule and where it comes from.
struct Rule {
    name: &'static str,
    value: &'static str,
    source: &'static str,
}

/// All that is said about a model.
struct Findings {
    arities: BTreeMap<usize, usize>,
    vertices: usize,
    isolated: usize,
    edges: usize,
    boundary: usize,
    not_manifold: usize,
    inner_valences: BTreeMap<u32, usize>,
    boundary_valences: BTreeMap<u32, usize>,
    irregular: usize,
    rules: Vec<Rule>,
    warnings: Vec<String>,
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    let Some(path) = a.model_path.as_deref() else {
        return super::gpu::list(a.json);
    };
    let stats = match &a.running.stats {
        Some(stats) => Some(stats_output(stats, Path::new(""), &[path])?),
        None => None,
    };
    let read = job.read_cage(path, &a.model, true)?;
    job.limits().check()?;
    let cage = &read.cage;
    let (topology, topology_warnings) = job.time("connect", |_| a.model.connect(cage));
    let mut warnings: Vec<String> = read.warnings.iter().map(ToString::to_string).collect();
    let name = escape(path.as_os_str().as_encoded_bytes(), 1024);
    warnings.extend(job.said(path, &a.model, &read, (&topology, &topology_warnings)));
    let found = find(cage, &topology, &a.model, warnings);
    job.limits().check()?;
    let mut staged = Vec::new();
    if let Some(stats) = stats {
        let middle = vec![("faces", Json::count(cage.face_count()))];
        let model = Json::text(path.display().to_string());
        let report = Json::Object(job.report(model, middle));
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    if a.json {
        print_text(&format!("{}\n", json(&name, cage, &read.report, &found)))?;
    } else {
        for w in &found.warnings {
            warning(w);
        }
        print_text(&text(&name, cage, &read.report, &found))?;
    }
    commit_all(staged)
}

fn find(cage: &Cage, t: &Topology, flags: &ModelFlags, warnings: Vec<String>) -> Findings {
    let mut found = Findings {
        arities: BTreeMap::new(),
        vertices: cage.points().len(),
        isolated: 0,
        edges: t.edge_count(),
        boundary: 0,
        not_manifold: 0,
        inner_valences: BTreeMap::new(),
        boundary_valences: BTreeMap::new(),
        irregular: 0,
        rules: rules(cage, flags),
        warnings,
    };
    for f in 0..cage.face_count() {
        *found.arities.entry(cage.face(f).len()).or_default() += 1;
    }
    let mut faces_of_edge = vec![0_u32; t.edge_count()];
    for h in 0..t.half_count() as u32 {
        faces_of_edge[t.edge(h) as usize] += 1;
    }
    for (e, &faces) in faces_of_edge.iter().enumerate() {
        let paired = t.twin(t.edge_half(e as u32)) != earmark::topology::NONE;
        match faces {
            1 => found.boundary += 1,
            2 if paired => {}
            _ => found.not_manifold += 1,
        }
    }
    for fan in t.fans() {
        if fan.faces == 0 {
            found.isolated += 1;
            continue;
        }
        let valences = if fan.closed {
            &mut found.inner_valences
        } else {
            &mut found.boundary_valences
        };
        *valences.entry(fan.edges()).or_default() += 1;
        let regular = if fan.rule == FanRule::Corner && fan.closed {
            false
        } else {
            fan.is_regular()
        };
        found.irregular += usize::from(!regular);
    }
    found
}

fn rules(cage: &Cage, flags: &ModelFlags) -> Vec<Rule> {
    let tags = cage.tags();
    let options = flags.surface();
    let rule = |name, flag: Option<&'static str>, file: Option<&'static str>, default| {
        let (value, source) = match (flag, file) {
            (Some(v), _) => (v, "flag"),
            (None, Some(v)) => (v, "file"),
            (None, None) => (default, "default"),
        };
        Rule {
            name,
            value,
            source,
        }
    };
    vec![
        rule(
            "scheme",
            flags.named_scheme().map(scheme_name),
            None,
            scheme_name(flags.scheme_of(cage)),
        ),
        rule(
            "boundary",
            options.boundary.map(boundary_name),
            tags.boundary.map(boundary_name),
            boundary_name(Boundary::default()),
        ),
        rule(
            "fvar",
            options.face_varying.map(fvar_name),
            tags.face_varying.map(fvar_name),
            fvar_name(FaceVaryingRule::default()),
        ),
        rule(
            "creases",
            None,
            tags.crease_method.map(|c| match c {
                CreaseMethod::Uniform => "uniform",
                CreaseMethod::Chaikin => "chaikin",
            }),
            "uniform",
        ),
        rule(
            "triangles",
            None,
            tags.triangles.map(|t| match t {
                TriangleRule::Catmark => "catmark",
                TriangleRule::Smooth => "smooth",
            }),
            "catmark",
        ),
    ]
}

fn boundary_name(b: Boundary) -> &'static str {
    match b {
        Boundary::None => "none",
        Boundary::EdgeOnly => "edge-only",
        Boundary::EdgeAndCorner => "edge-and-corner",
    }
}

fn fvar_name(f: FaceVaryingRule) -> &'static str {
    match f {
        FaceVaryingRule::None => "none",
        FaceVaryingRule::CornersOnly => "corners-only",
        FaceVaryingRule::CornersPlus1 => "corners-plus1",
        FaceVaryingRule::CornersPlus2 => "corners-plus2",
        FaceVaryingRule::Boundaries => "boundaries",
        FaceVaryingRule::All => "all",
    }
}

/// Number of sharpnesses above 0 and below infinite, and of infinite ones.
fn sharp(values: impl Iterator<Item = f32> + Clone) -> [usize; 2] {
    let semi = values
        .clone()
        .filter(|&s| s > 0.0 && s < INFINITE_SHARPNESS)
        .count();
    [semi, values.filter(|&s| s >= INFINITE_SHARPNESS).count()]
}

/// Faces of each material, and those without at the end.
fn material_faces(cage: &Cage) -> Vec<usize> {
    let mut faces = vec![0; cage.materials().len() + 1];
    for f in 0..cage.face_count() {
        let index = cage.face_material_index(f);
        faces[index.unwrap_or(cage.materials().len())] += 1;
    }
    faces
}

fn maps(m: &earmark::mesh::Material) -> Vec<(&'static str, &str)> {
    [
        ("diffuse", &m.diffuse_map),
        ("opacity", &m.opacity_map),
        ("bump", &m.bump_map),
        ("normal", &m.normal_map),
        ("displacement", &m.displacement_map),
    ]
    .into_iter()
    .filter_map(|(k, v)| Some((k, v.as_deref()?)))
    .collect()
}

fn corners_without_uv(cage: &Cage) -> usize {
    cage.corner_uvs().iter().filter(|&&i| i == NONE).count()
}

fn histogram<K: ToString>(map: &BTreeMap<K, usize>) -> Json {
    let members = map.iter().map(|(k, &n)| (k.to_string(), Json::count(n)));
    Json::Object(members.collect())
}

fn json(name: &str, cage: &Cage, report: &Report, found: &Findings) -> Json {
    let tags = cage.tags();
    let [creases_semi, creases_hard] = sharp(tags.creases.iter().map(|c| c.sharpness));
    let [corners_semi, corners_hard] = sharp(tags.corners.iter().map(|c| c.sharpness));
    let coordinates = |p: [f64; 3]| Json::List(p.map(Json::Exact).into());
    let [low, high] = bounds(cage);
    let faces = material_faces(cage);
    let materials = cage.materials().iter().zip(&faces).map(|(m, &faces)| {
        let maps = maps(m);
        let maps = maps.iter().map(|(k, v)| ((*k).to_owned(), Json::text(*v)));
        Json::object([
            ("name", Json::text(&*m.name)),
            ("faces", Json::count(faces)),
            ("maps", Json::Object(maps.collect())),
        ])
    });
    let rules = found.rules.iter().map(|r| {
        let rule = Json::object([
            ("value", Json::text(r.value)),
            ("from", Json::text(r.source)),
        ]);
        (r.name.to_owned(), rule)
    });
    Json::object([
        ("version", Json::text(env!("CARGO_PKG_VERSION"))),
        ("model", Json::text(name)),
        ("bytes", Json::count(report.bytes)),
        ("faces", Json::count(cage.face_count())),
        ("faces_by_arity", histogram(&found.arities)),
        ("faces_left_out", Json::count(report.dropped_faces.len())),
        ("vertices", Json::count(found.vertices)),
        ("isolated_vertices", Json::count(found.isolated)),
        ("valences", histogram(&found.inner_valences)),
        ("boundary_valences", histogram(&found.boundary_valences)),
        ("irregular_vertices", Json::count(found.irregular)),
        ("edges", Json::count(found.edges)),
        ("boundary_edges", Json::count(found.boundary)),
        ("non_manifold_edges", Json::count(found.not_manifold)),
        ("creases", sharpness_json(creases_semi, creases_hard)),
        ("corners", sharpness_json(corners_semi, corners_hard)),
        ("holes", Json::count(tags.holes.len())),
        ("uvs", Json::count(cage.uvs().len())),
        ("corners_without_uv", Json::count(corners_without_uv(cage))),
        ("normals", Json::count(cage.normals().len())),
        ("vertex_colors", Json::Bool(!cage.colors().is_empty())),
        ("groups", Json::count(report.groups)),
        ("objects", Json::count(report.objects)),
        ("materials", Json::List(materials.collect())),
        (
            "faces_without_material",
            Json::count(faces.last().copied().unwrap_or(0)),
        ),
        ("rules", Json::Object(rules.collect())),
        (
            "bounding_box",
            Json::List(vec![coordinates(low), coordinates(high)]),
        ),
        ("origin", coordinates(cage.origin())),
        (
            "warnings",
            Json::List(found.warnings.iter().map(|w| Json::text(&**w)).collect()),
        ),
    ])
}

fn sharpness_json(semi: usize, hard: usize) -> Json {
    Json::object([
        ("semi_sharp", Json::count(semi)),
        ("sharp", Json::count(hard)),
    ])
}

fn text(name: &str, cage: &Cage, report: &Report, found: &Findings) -> String {
    let mut out = String::new();
    let mut row = |key: &str, value: String| {
        let _ = writeln!(out, "{key:<14} {value}");
    };
    let list = |map: &BTreeMap<u32, usize>| {
        let parts: Vec<String> = map.iter().map(|(k, n)| format!("{n} of {k}")).collect();
        if parts.is_empty() {
            "none".to_owned()
        } else {
            parts.join(", ")
        }
    };
    row("model", name.to_owned());
    let arities: Vec<String> = found
        .arities
        .iter()
        .map(|(k, n)| match k {
            3 => format!("{n} triangles"),
            4 => format!("{n} quads"),
            k => format!("{n} with {k} corners"),
        })
        .collect();
    row(
        "faces",
        format!("{} ({})", cage.face_count(), arities.join(", ")),
    );
    if !report.dropped_faces.is_empty() {
        row("left out", format!("{} faces", report.dropped_faces.len()));
    }
    let isolated = match found.isolated {
        0 => String::new(),
        n => format!(", {n} in no face"),
    };
    row(
        "vertices",
        format!(
            "{} ({} irregular{isolated})",
            found.vertices, found.irregular
        ),
    );
    row("valences", list(&found.inner_valences));
    row("at boundary", list(&found.boundary_valences));
    row(
        "edges",
        format!(
            "{} ({} boundary, {} non-manifold)",
            found.edges, found.boundary, found.not_manifold
        ),
    );
    let tags = cage.tags();
    for (key, [semi, hard]) in [
        ("creases", sharp(tags.creases.iter().map(|c| c.sharpness))),
        ("corners", sharp(tags.corners.iter().map(|c| c.sharpness))),
    ] {
        row(
            key,
            format!("{} ({semi} semi-sharp, {hard} sharp)", semi + hard),
        );
    }
    row("holes", tags.holes.len().to_string());
    let missing = match corners_without_uv(cage) {
        0 => String::new(),
        n => format!(" ({n} corners without)"),
    };
    row("uvs", format!("{}{missing}", cage.uvs().len()));
    row("normals", cage.normals().len().to_string());
    row(
        "vertex colours",
        if cage.colors().is_empty() {
            "no"
        } else {
            "yes"
        }
        .to_owned(),
    );
    let faces = material_faces(cage);
    row("materials", cage.materials().len().to_string());
    for (m, faces) in cage.materials().iter().zip(&faces).take(MATERIALS_SHOWN) {
        let maps: Vec<String> = maps(m)
            .iter()
            .map(|(k, v)| format!(", {k} map {}", escape(v.as_bytes(), 80)))
            .collect();
        let name = escape(m.name.as_bytes(), 80);
        row("", format!("{name}: {faces} faces{}", maps.concat()));
    }
    if cage.materials().len() > MATERIALS_SHOWN {
        row(
            "",
            format!("and {} more", cage.materials().len() - MATERIALS_SHOWN),
        );
    }
    for r in &found.rules {
        let from = match r.source {
            "file" => "from the file",
            "flag" => "from the flag",
            _ => "default",
        };
        row(r.name, format!("{} ({from})", r.value));
    }
    let [low, high] = bounds(cage);
    row("bounding box", format!("{low:?} to {high:?}"));
    if cage.origin() != [0.0; 3] {
        row("origin", format!("{:?}", cage.origin()));
    }
    out
}

/// Materials that the text lists; JSON lists all.
const MATERIALS_SHOWN: usize = 32;
