//! Pictures of what earmark draws, with a page to look at them: `cargo run --release --example gallery [FOLDER] [SIDE]`.
//!
//! `FOLDER` is `target/gallery` by default, `SIDE` the side of a picture in pixels, 480 by default. Below every picture stands the command
//! that draws it, byte for byte. Models are those of `assets/`.
#![allow(missing_docs, clippy::print_stdout, clippy::print_stderr)]

use earmark::displace::{Displacement, Function};
use earmark::film::Image;
use earmark::frame::{Drawing, Refinement};
use earmark::load::{LoadOptions, Loader};
use earmark::overlay::{self, Layers, Options};
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::shade::ShadeMode;
use earmark::tessellate::{DepthTags, Flatness, Pattern};
use earmark::{Camera, Renderer, Scene, files, film};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// One picture: what to load, how to draw it, and the flags that do the same on the command line.
struct Shot {
    topic: &'static str,
    model: &'static str,
    flags: String,
    load: LoadOptions,
    refinement: Option<Refinement>,
    drawing: Drawing,
    mode: ShadeMode,
    noise: Option<(&'static str, f32)>,
    layers: Layers,
    alone: bool,
    camera: Camera,
}

impl Shot {
    fn new(topic: &'static str, model: &'static str, flags: &str) -> Self {
        Self {
            topic,
            model,
            flags: flags.to_owned(),
            load: LoadOptions::default(),
            refinement: None,
            drawing: Drawing::Limit,
            mode: ShadeMode::Lit,
            noise: None,
            layers: Layers::NONE,
            alone: false,
            camera: Camera::default(),
        }
    }

    fn flag(mut self, flag: &str) -> Self {
        self.flags = format!("{} {flag}", self.flags).trim().to_owned();
        self
    }
    fn level(mut self, level: u32) -> Self {
        self.refinement = Some(Refinement::Uniform(level));
        self.flag(&format!("--level {level}"))
    }
    fn mode(mut self, mode: ShadeMode, name: &str) -> Self {
        self.mode = mode;
        self.flag(&format!("--shade {name}"))
    }
    fn lines(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self.flag(&format!("--overlay {}", layers.to_names()))
    }
    fn alone(mut self) -> Self {
        self.alone = true;
        self.flag("--shade wireframe --background ffffff")
    }
    fn scheme(mut self, scheme: Scheme, name: &str) -> Self {
        self.load.surface.scheme = Some(scheme);
        self.flag(&format!("--scheme {name}"))
    }
    fn patches(mut self, patches: PatchKind, name: &str) -> Self {
        self.load.surface.patches = patches;
        self.flag(&format!("--surface {name}"))
    }
    fn noise(mut self, function: &'static str, scale: f32) -> Self {
        self.noise = Some((function, scale));
        self.flag(&format!(
            "--displace-noise {function} --displace-scale {scale}"
        ))
    }
    fn refined(mut self, refinement: Refinement, flag: &str) -> Self {
        self.refinement = Some(refinement);
        self.flag(flag)
    }
    fn orbit(mut self, azimuth: f64, elevation: f64) -> Self {
        self.camera = self.camera.with_orbit(azimuth, elevation);
        self.flag(&format!("--azimuth {azimuth} --elevation {elevation}"))
    }

    fn scene(&self) -> Result<Scene, Box<dyn Error>> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("assets")
            .join(self.model);
        let mut loader = Loader::new(self.load.clone());
        loader.add_file(&path)?;
        let (mut scene, warnings) = loader.finish();
        for warning in warnings {
            eprintln!("{warning}");
        }
        if let Some((function, scale)) = self.noise {
            let function: Function = function.parse()?;
            for object in &mut scene.objects {
                let noise = Displacement::function(function).scaled(scale);
                object.surface.set_displacement(Some(noise));
            }
        }
        Ok(scene)
    }

    /// Draws it; line work alone also as SVG.
    fn draw(&self, side: u32) -> Result<(Image, Option<String>), Box<dyn Error>> {
        let scene = self.scene()?;
        let mut renderer = Renderer::new(side, side);
        renderer.drawing = self.drawing;
        renderer.mode = self.mode;
        if let Some(refinement) = self.refinement {
            renderer.refinement = refinement;
        }
        let view = renderer.view(&scene, &self.camera)?;
        if self.alone {
            let options = Options::illustration(self.layers);
            let art = overlay::trace(&renderer, &scene, &view, &options)?;
            let mut image = Image::filled([side; 2], [255; 4]);
            art.draw(&mut image);
            return Ok((image, Some(art.to_svg(Some([255; 4])))));
        }
        let mut image = renderer.render_view(&scene, &view)?.image;
        if !self.layers.is_empty() {
            let options = Options::overlay(self.layers);
            overlay::draw(&mut image, &renderer, &scene, &view, &options)?;
        }
        Ok((image, None))
    }
}

fn shots() -> Vec<Shot> {
    let wire = Layers::WIREFRAME;
    let mut out = Vec::new();
    let topic = "Schemes: one octahedron, and one cube";
    for (scheme, name) in [
        (Scheme::Loop, "loop"),
        (Scheme::Butterfly, "butterfly"),
        (Scheme::CatmullClark, "catmull-clark"),
        (Scheme::Bilinear, "bilinear"),
    ] {
        let shot = Shot::new(topic, "octahedron.obj", "").scheme(scheme, name);
        out.push(shot.level(3).lines(wire | Layers::CAGE));
    }
    for (scheme, name) in [
        (Scheme::CatmullClark, "catmull-clark"),
        (Scheme::Kobbelt, "kobbelt"),
    ] {
        let shot = Shot::new(topic, "cube.obj", "").scheme(scheme, name);
        out.push(shot.level(3).lines(wire | Layers::CAGE));
    }
    let topic = "Levels: the cage, and uniform refinement";
    let mut cage = Shot::new(topic, "creature.obj", "--surface cage").mode(ShadeMode::Flat, "flat");
    cage.drawing = Drawing::Cage;
    out.push(cage.lines(wire));
    for level in 0..4 {
        let shot = Shot::new(topic, "creature.obj", "").level(level);
        out.push(shot.mode(ShadeMode::Flat, "flat").lines(wire));
    }
    let topic = "Adaptive: as fine as the picture asks for";
    let flatness = |pixels| {
        Refinement::Adaptive(Flatness {
            pixels,
            ..Flatness::default()
        })
    };
    out.push(Shot::new(topic, "creature.obj", ""));
    out.push(Shot::new(topic, "creature.obj", "").lines(wire));
    out.push(Shot::new(topic, "creature.obj", "").mode(ShadeMode::Level, "level"));
    let coarse = Shot::new(topic, "creature.obj", "").refined(flatness(4.0), "--adaptive 4");
    out.push(coarse.lines(wire));
    let mut tags = DepthTags::by_curvature();
    tags.pattern = Some(Pattern::Equilateral);
    let tagged = Shot::new(topic, "part_creased.obj", "");
    let flag = "--depth-tags curvature --pattern equilateral";
    out.push(
        tagged
            .refined(Refinement::DepthTags(tags), flag)
            .lines(wire),
    );
    let topic = "Displacement along limit normals";
    out.push(Shot::new(topic, "creature.obj", "").noise("fbm:frequency=6,octaves=4", 0.04));
    out.push(Shot::new(topic, "torus.obj", "").noise("ridged:frequency=3", 0.1));
    out.push(
        Shot::new(topic, "torus.obj", "")
            .noise("ripples:frequency=4", 0.04)
            .lines(wire),
    );
    let topic = "Patches in place of the limit surface";
    for (kind, name) in [
        (PatchKind::None, "limit"),
        (PatchKind::Qas, "qas"),
        (PatchKind::Pn, "pn"),
    ] {
        let shot = Shot::new(topic, "creature.obj", "").patches(kind, name);
        out.push(shot.level(4).lines(Layers::PATCHES));
    }
    let topic = "Lines over a picture";
    let form = Layers::CREASES | Layers::BOUNDARIES;
    out.push(Shot::new(topic, "part_creased.obj", "").lines(form | Layers::PATCHES));
    out.push(Shot::new(topic, "part_creased.obj", "").lines(Layers::VALENCES));
    let grid =
        Shot::new(topic, "grid.obj", "").lines(Layers::CAGE | Layers::PATCHES | Layers::LABELS);
    out.push(grid);
    out.push(Shot::new(topic, "mobius.obj", "").lines(Layers::AXES | Layers::SCALE | form));
    let topic = "Lines alone, as PNG and as SVG";
    out.push(Shot::new(topic, "creature.obj", "").level(2).alone());
    out.push(
        Shot::new(topic, "part_creased.obj", "")
            .level(2)
            .alone()
            .lines(Layers::VALENCES),
    );
    out.push(
        Shot::new(topic, "mobius.obj", "")
            .level(3)
            .alone()
            .lines(Layers::PATCHES),
    );
    out.push(
        Shot::new(topic, "torus.obj", "")
            .level(3)
            .orbit(20.0, 40.0)
            .alone(),
    );
    let topic = "What else pixels can show";
    out.push(Shot::new(topic, "creature.obj", "").mode(ShadeMode::Normals, "normals"));
    out.push(Shot::new(topic, "creature.obj", "").mode(ShadeMode::Uv, "uv"));
    out.push(Shot::new(topic, "creature.obj", "").mode(ShadeMode::Depth, "depth"));
    out
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap_or_else(|| "target/gallery".into()));
    let side: u32 = arguments.next().map_or(Ok(480), |s| s.parse())?;
    std::fs::create_dir_all(&folder)?;
    let mut page = String::from(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>earmark: gallery</title>\n<style>body{font:15px/1.4 system-ui,sans-serif;margin:2rem;background:#fff;color:#222}\
         section{display:grid;grid-template-columns:repeat(auto-fill,minmax(280px,1fr));gap:1rem}figure{margin:0}\
         img{width:100%;background:#f4f4f2}figcaption code{font-size:12px;overflow-wrap:anywhere}</style>\n<h1>Gallery</h1>\n",
    );
    let mut topic = "";
    for (k, shot) in shots().iter().enumerate() {
        if shot.topic != topic {
            if !topic.is_empty() {
                page.push_str("</section>\n");
            }
            topic = shot.topic;
            write!(page, "<h2>{topic}</h2>\n<section>\n")?;
        }
        let (image, svg) = shot.draw(side)?;
        let name = format!("{k:02}_{}", shot.model.trim_end_matches(".obj"));
        files::write_atomic(
            &folder.join(format!("{name}.png")),
            &film::png::encode(&image)?,
        )?;
        let mut also = String::new();
        if let Some(svg) = svg {
            files::write_atomic(&folder.join(format!("{name}.svg")), svg.as_bytes())?;
            also = format!(" <a href=\"{name}.svg\">SVG</a>");
        }
        let command = format!(
            "earmark render assets/{} -o {name}.png --size {side}x{side} {}",
            shot.model, shot.flags
        );
        writeln!(
            page,
            "<figure><a href=\"{name}.png\"><img src=\"{name}.png\" alt=\"\" loading=\"lazy\"></a>\
             <figcaption><code>{}</code>{also}</figcaption></figure>",
            command.trim_end()
        )?;
    }
    page.push_str("</section>\n</html>\n");
    let index = folder.join("index.html");
    files::write_atomic(&index, page.as_bytes())?;
    println!("{}", index.display());
    Ok(())
}
