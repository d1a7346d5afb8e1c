//! Which golden pictures there are, and how each is drawn.

use crate::common;
use earmark::frame::{Drawing, Refinement};
use earmark::load::{LoadOptions, Loader};
use earmark::mesh::resolver::NoFiles;
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::shade::ShadeMode;
use earmark::tessellate::{DepthTags, Pattern};
use earmark::{Camera, Renderer, Scene, SurfaceOptions};

/// A golden picture: what it shows, and how.
pub(crate) struct Golden {
    pub(crate) name: String,
    pub(crate) asset: &'static str,
    pub(crate) scheme: Scheme,
    pub(crate) level: u32,
    pub(crate) drawing: Drawing,
    pub(crate) mode: ShadeMode,
    pub(crate) samples: u32,
    pub(crate) camera: Camera,
    pub(crate) patches: PatchKind,
    /// Depth tags in place of the level, and whether vertices have random ones.
    pub(crate) tags: Option<(DepthTags, bool)>,
}

const ICOSAHEDRON: &str = "v -1 1.618034 0
v 1 1.618034 0
v -1 -1.618034 0
v 1 -1.618034 0
v 0 -1 1.618034
v 0 1 1.618034
v 0 -1 -1.618034
v 0 1 -1.618034
v 1.618034 0 -1
v 1.618034 0 1
v -1.618034 0 -1
v -1.618034 0 1
f 1 12 6
f 1 6 2
f 1 2 8
f 1 8 11
f 1 11 12
f 2 6 10
f 6 12 5
f 12 11 3
f 11 8 7
f 8 2 9
f 4 10 5
f 4 5 3
f 4 3 7
f 4 7 9
f 4 9 10
f 5 10 6
f 3 5 12
f 7 3 11
f 9 7 8
f 10 9 2
";

impl Golden {
    /// What it shows, without displacement.
    pub(crate) fn scene(&self) -> Scene {
        let mut loader = Loader::new(LoadOptions {
            surface: SurfaceOptions {
                scheme: Some(self.scheme),
                patches: self.patches,
                ..SurfaceOptions::default()
            },
            ..LoadOptions::default()
        });
        if self.asset == "icosahedron" {
            let read = loader.read(ICOSAHEDRON.as_bytes(), self.asset, &mut NoFiles);
            let cage = read.unwrap().cage;
            loader.add_cage(cage, self.asset, &mut NoFiles).unwrap();
        } else {
            let path = common::assets().join(format!("{}.obj", self.asset));
            loader.add_file(&path).unwrap();
        }
        let mut scene = loader.finish().0;
        if let Some((_, true)) = self.tags {
            let mut numbers = common::Random(11);
            let count = scene.objects[0].surface.cage().points().len();
            // Few vertices have tags that differ.
            const FEW: [u8; 8] = [5, 0, 4, 1, 5, 2, 3, 0];
            let tags = (0..count).map(|k| match count <= FEW.len() {
                true => FEW[k],
                false => (numbers.next() % 6) as u8,
            });
            scene.objects[0].depth_tags = tags.collect();
        }
        scene
    }

    /// How it is drawn.
    pub(crate) fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(256, 256);
        renderer.size.samples = self.samples;
        renderer.refinement = match self.tags {
            Some((tags, _)) => Refinement::DepthTags(tags),
            None => Refinement::Uniform(self.level),
        };
        renderer.drawing = self.drawing;
        renderer.mode = self.mode;
        renderer
    }
}

/// Scheme and level are part of the name. `more` are further assets with their level and the rest of their name.
pub(crate) fn goldens(more: &[(&'static str, u32, &str)]) -> Vec<Golden> {
    let mut out = Vec::new();
    let mut add = |asset, level, what: &str, drawing, mode, samples, camera| {
        let name = format!("{asset}_catmull-clark_l{level}{what}");
        out.push(Golden {
            name,
            asset,
            scheme: Scheme::CatmullClark,
            level,
            drawing,
            mode,
            samples,
            camera,
            patches: PatchKind::None,
            tags: None,
        });
    };
    let camera = Camera::default();
    for asset in [
        "corner",
        "cube",
        "fan24",
        "fan3",
        "fan5",
        "fan8",
        "grid",
        "mobius",
        "octahedron",
        "part",
        "tetrahedron",
        "torus",
    ] {
        add(asset, 3, "", Drawing::Limit, ShadeMode::Lit, 4, camera);
    }
    add("creature", 4, "", Drawing::Limit, ShadeMode::Lit, 4, camera);
    add(
        "creature",
        2,
        "_normals",
        Drawing::Limit,
        ShadeMode::Normals,
        1,
        camera,
    );
    add(
        "creature",
        2,
        "_uv",
        Drawing::Limit,
        ShadeMode::Uv,
        1,
        camera,
    );
    add(
        "creature",
        3,
        "_ortho_16",
        Drawing::Limit,
        ShadeMode::Lit,
        16,
        camera.with_ortho().with_orbit(200.0, 10.0),
    );
    add(
        "creature",
        1,
        "_refined_flat",
        Drawing::Refined,
        ShadeMode::Flat,
        8,
        camera,
    );
    add(
        "creature",
        0,
        "_cage",
        Drawing::Cage,
        ShadeMode::Lit,
        4,
        camera,
    );
    for (asset, level, what) in [("creature", 3, "_single"), ("part", 6, "_single")] {
        add(
            asset,
            level,
            what,
            Drawing::Limit,
            ShadeMode::Lit,
            1,
            camera,
        );
    }
    add("part", 0, "", Drawing::Limit, ShadeMode::Lit, 4, camera);
    add(
        "part",
        0,
        "_cage",
        Drawing::Cage,
        ShadeMode::Flat,
        4,
        camera,
    );
    add(
        "part",
        2,
        "_depth",
        Drawing::Limit,
        ShadeMode::Depth,
        1,
        camera,
    );
    add(
        "part",
        7,
        "_near",
        Drawing::Limit,
        ShadeMode::Lit,
        4,
        camera.with_zoom(6.0),
    );
    add(
        "torus",
        6,
        "_level",
        Drawing::Limit,
        ShadeMode::Level,
        1,
        camera,
    );
    for &(asset, level, what) in more {
        add(
            asset,
            level,
            what,
            Drawing::Limit,
            ShadeMode::Lit,
            4,
            camera,
        );
    }
    // What follows a blank is a name of its own.
    for g in &mut out {
        if let Some((_, name)) = g.name.split_once(' ') {
            g.name = name.to_owned();
        }
    }
    for (asset, scheme, level) in [
        ("part_creased", Scheme::CatmullClark, 3),
        ("part_creased", Scheme::Bilinear, 2),
        ("octahedron", Scheme::Loop, 4),
        ("tetrahedron", Scheme::Loop, 6),
    ] {
        let kind = match scheme {
            Scheme::Loop => "loop",
            Scheme::Bilinear => "bilinear",
            _ => "catmull-clark",
        };
        out.push(Golden {
            name: format!("{asset}_{kind}_l{level}"),
            asset,
            scheme,
            level,
            drawing: Drawing::Limit,
            mode: ShadeMode::Lit,
            samples: 4,
            camera,
            patches: PatchKind::None,
            tags: None,
        });
    }
    for (asset, scheme, kind, patches) in [
        ("creature", Scheme::CatmullClark, "qas", PatchKind::Qas),
        ("creature", Scheme::CatmullClark, "pn", PatchKind::Pn),
        ("part_creased", Scheme::CatmullClark, "pn", PatchKind::Pn),
        ("icosahedron", Scheme::Loop, "limit", PatchKind::None),
        ("icosahedron", Scheme::Loop, "qas", PatchKind::Qas),
        ("icosahedron", Scheme::Loop, "pn", PatchKind::Pn),
    ] {
        out.push(Golden {
            name: format!("{asset}_{kind}_l4"),
            asset,
            scheme,
            level: 4,
            drawing: Drawing::Limit,
            mode: ShadeMode::Lit,
            samples: 4,
            camera,
            patches,
            tags: None,
        });
    }
    out.extend(tagged());
    out
}

/// Topics of their own: depth tags and refinement patterns.
fn tagged() -> Vec<Golden> {
    let by = |pattern| DepthTags {
        pattern: Some(pattern),
        ..DepthTags::GIVEN
    };
    let topics = [
        ("tags_distance", DepthTags::by_distance(), false),
        ("tags_random", DepthTags::GIVEN, true),
        ("pattern_split", by(Pattern::Split), true),
        ("pattern_equilateral", by(Pattern::Equilateral), true),
    ];
    let mut out = Vec::new();
    for (topic, tags, random) in topics {
        for (asset, scheme, what, mode) in [
            ("creature", Scheme::CatmullClark, "", ShadeMode::Lit),
            ("creature", Scheme::CatmullClark, "_level", ShadeMode::Level),
            ("cube", Scheme::CatmullClark, "_flat", ShadeMode::Flat),
            ("octahedron", Scheme::Loop, "_flat", ShadeMode::Flat),
            ("octahedron", Scheme::Loop, "", ShadeMode::Lit),
        ] {
            out.push(Golden {
                name: format!("{topic}_{asset}{what}"),
                asset,
                scheme,
                level: 0,
                drawing: Drawing::Limit,
                mode,
                samples: 4,
                camera: Camera::default(),
                patches: PatchKind::None,
                tags: Some((tags, random)),
            });
        }
    }
    out
}
