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
    pub(crate) refinement: Refinement,
    pub(crate) drawing: Drawing,
    pub(crate) mode: ShadeMode,
    pub(crate) samples: u32,
    pub(crate) camera: Camera,
    pub(crate) patches: PatchKind,
    /// Whether vertices have random depth tags.
    pub(crate) has_random_tags: bool,
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
    /// A limit surface under light, with 4 samples.
    fn new(name: String, asset: &'static str, scheme: Scheme, refinement: Refinement) -> Self {
        Self {
            name,
            asset,
            scheme,
            refinement,
            drawing: Drawing::Limit,
            mode: ShadeMode::Lit,
            samples: 4,
            camera: Camera::default(),
            patches: PatchKind::None,
            has_random_tags: false,
        }
    }

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
        if self.has_random_tags {
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
        renderer.refinement = self.refinement;
        renderer.drawing = self.drawing;
        renderer.mode = self.mode;
        renderer
    }
}

/// Catmull-Clark at a level, by asset, level and the rest of the name.
fn uniform(asset: &'static str, level: u32, what: &str) -> Golden {
    let name = format!("{asset}_catmull-clark_l{level}{what}");
    Golden::new(
        name,
        asset,
        Scheme::CatmullClark,
        Refinement::Uniform(level),
    )
}

/// All of them. `more` are further assets with their level and the rest of their name; what follows a blank is a name of its own.
pub(crate) fn goldens(more: &[(&'static str, u32, &str)]) -> Vec<Golden> {
    let mut out = Vec::new();
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
        out.push(uniform(asset, 3, ""));
    }
    out.extend([uniform("creature", 4, ""), uniform("part", 0, "")]);
    for (asset, level, what, mode) in [
        ("creature", 2, "_normals", ShadeMode::Normals),
        ("creature", 2, "_uv", ShadeMode::Uv),
        ("creature", 3, "_single", ShadeMode::Lit),
        ("part", 6, "_single", ShadeMode::Lit),
        ("part", 2, "_depth", ShadeMode::Depth),
        ("torus", 6, "_level", ShadeMode::Level),
    ] {
        out.push(Golden {
            mode,
            samples: 1,
            ..uniform(asset, level, what)
        });
    }
    let camera = Camera::default();
    out.push(Golden {
        samples: 16,
        camera: camera.with_ortho().with_orbit(200.0, 10.0),
        ..uniform("creature", 3, "_ortho_16")
    });
    out.push(Golden {
        drawing: Drawing::Refined,
        mode: ShadeMode::Flat,
        samples: 8,
        ..uniform("creature", 1, "_refined_flat")
    });
    for (asset, mode) in [("creature", ShadeMode::Lit), ("part", ShadeMode::Flat)] {
        out.push(Golden {
            drawing: Drawing::Cage,
            mode,
            ..uniform(asset, 0, "_cage")
        });
    }
    out.push(Golden {
        camera: camera.with_zoom(6.0),
        ..uniform("part", 7, "_near")
    });
    for &(asset, level, what) in more {
        let mut golden = uniform(asset, level, what);
        if let Some((_, name)) = what.split_once(' ') {
            golden.name = name.to_owned();
        }
        out.push(golden);
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
        let name = format!("{asset}_{kind}_l{level}");
        out.push(Golden::new(name, asset, scheme, Refinement::Uniform(level)));
    }
    for (asset, scheme, kind, patches) in [
        ("creature", Scheme::CatmullClark, "qas", PatchKind::Qas),
        ("creature", Scheme::CatmullClark, "pn", PatchKind::Pn),
        ("part_creased", Scheme::CatmullClark, "pn", PatchKind::Pn),
        ("icosahedron", Scheme::Loop, "limit", PatchKind::None),
        ("icosahedron", Scheme::Loop, "qas", PatchKind::Qas),
        ("icosahedron", Scheme::Loop, "pn", PatchKind::Pn),
    ] {
        let name = format!("{asset}_{kind}_l4");
        out.push(Golden {
            patches,
            ..Golden::new(name, asset, scheme, Refinement::Uniform(4))
        });
    }
    out.extend(adaptive());
    out.extend(tagged());
    out
}

/// What is drawn where nothing is said, by topic.
fn adaptive() -> Vec<Golden> {
    let default = Renderer::new(1, 1).refinement;
    let camera = Camera::default();
    let mut out = Vec::new();
    for (asset, scheme, what, mode, camera) in [
        ("creature", Scheme::CatmullClark, "", ShadeMode::Lit, camera),
        (
            "creature",
            Scheme::CatmullClark,
            "_level",
            ShadeMode::Level,
            camera,
        ),
        (
            "part_creased",
            Scheme::CatmullClark,
            "_near",
            ShadeMode::Lit,
            camera.with_zoom(4.0),
        ),
        ("octahedron", Scheme::Loop, "", ShadeMode::Lit, camera),
    ] {
        let name = format!("adaptive_{asset}{what}");
        out.push(Golden {
            mode,
            camera,
            ..Golden::new(name, asset, scheme, default)
        });
    }
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
    for (topic, tags, has_random_tags) in topics {
        for (asset, scheme, what, mode) in [
            ("creature", Scheme::CatmullClark, "", ShadeMode::Lit),
            ("creature", Scheme::CatmullClark, "_level", ShadeMode::Level),
            ("cube", Scheme::CatmullClark, "_flat", ShadeMode::Flat),
            ("octahedron", Scheme::Loop, "_flat", ShadeMode::Flat),
            ("octahedron", Scheme::Loop, "", ShadeMode::Lit),
        ] {
            let name = format!("{topic}_{asset}{what}");
            out.push(Golden {
                mode,
                has_random_tags,
                ..Golden::new(name, asset, scheme, Refinement::DepthTags(tags))
            });
        }
    }
    out
}
