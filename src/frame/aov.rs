//! Further outputs of a frame: what the visible surface is, pixel by pixel, beside what it looks like.
//!
//! All but [`Aov::Coverage`] are those of one sample of the pixel and never an average: of the samples that show anything, the one
//! nearest to the pixel's centre, the first of those equally near. So they agree with each other, and a pixel has them exactly if the
//! picture has something there. They come from the frame's own keys and blocks; nothing is rasterised again.

use super::source::Source;
use super::tile::Scratch;
use super::visible::Visible;
use super::{Frame, shading};
use crate::camera::{Sphere, View};
use crate::film::srgb::{Srgb, quantize};
use crate::film::{WriteError, png};
use crate::math::saturate;
use crate::raster::sample_positions;
use crate::shade::SurfacePoint;

/// A further output. Names are those of `--aov`; formats are those of the PNG files.
///
/// | output | channels | code | nothing |
/// |---|---|---|---|
/// | `depth` | grey, 16 bits | distance along the view axis from near, 0, to far, 65534 | 65535 |
/// | `normal` | RGBA, 8 bits | `255 (n/2 + 1/2)` of the unit normal in model space, as `--shade normals`; alpha 255 | 0 |
/// | `position` | RGB, 16 bits | 0 to 65535 over a cube around the model, each axis its own range | 0, 0, 0 |
/// | `albedo` | RGBA, 8 bits | colour without light, sRGB; alpha 255 | 0 |
/// | `uv` | RGB, 16 bits | u and v, 0 to 65535 over a range of whole numbers, and 65535 in blue | 0; blue 0 also without coordinates |
/// | `face` | RGB, 8 bits | number of the cage's face plus 1, red the highest byte; faces are numbered through all models | 0 |
/// | `level` | grey, 8 bits | level of subdivision plus 1 | 0 |
/// | `coverage` | grey, 8 bits | samples that show anything, times 255 over all, rounded | 0 |
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Aov {
    /// Distance from the eye along the view axis.
    Depth,
    /// Unit normal in model space, not turned to the eye.
    Normal,
    /// Position in model space.
    Position,
    /// Colour without light.
    Albedo,
    /// Texture coordinates.
    Uv,
    /// Face of the cage.
    Face,
    /// Level of subdivision.
    Level,
    /// Share of the samples that show anything.
    Coverage,
}

impl Aov {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Depth,
        Self::Normal,
        Self::Position,
        Self::Albedo,
        Self::Uv,
        Self::Face,
        Self::Level,
        Self::Coverage,
    ];

    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Position => "position",
            Self::Albedo => "albedo",
            Self::Uv => "uv",
            Self::Face => "face",
            Self::Level => "level",
            Self::Coverage => "coverage",
        }
    }
    /// The one of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|a| a.name() == name)
    }
    /// Channels of a pixel: 1 grey, 3 RGB, 4 RGBA.
    #[must_use]
    pub const fn channels(self) -> u32 {
        match self {
            Self::Depth | Self::Level | Self::Coverage => 1,
            Self::Position | Self::Uv | Self::Face => 3,
            Self::Normal | Self::Albedo => 4,
        }
    }
    /// Bits of a channel: 8 or 16.
    #[must_use]
    pub const fn bits(self) -> u32 {
        match self {
            Self::Depth | Self::Position | Self::Uv => 16,
            _ => 8,
        }
    }
    /// Bytes of a pixel.
    #[must_use]
    pub const fn pixel_bytes(self) -> usize {
        (self.channels() * self.bits() / 8) as usize
    }
    /// Byte of a pixel that shows nothing.
    pub(crate) const fn nothing(self) -> u8 {
        match self {
            Self::Depth => 255,
            _ => 0,
        }
    }
}

/// A further output of a frame, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// What it is.
    pub aov: Aov,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Rows from the top, the higher byte of 16 bits first.
    pub data: Vec<u8>,
    /// What code 0 means: near in the first place of `depth`, the lowest coordinates of `position` and `uv`.
    pub low: [f64; 3],
    /// What code 65535 means: far in the first place of `depth`, the highest coordinates of `position` and `uv`.
    pub high: [f64; 3],
}

impl Plane {
    /// Codes of a pixel, as many as there are channels.
    ///
    /// # Panics
    /// Outside the picture.
    #[must_use]
    pub fn codes(&self, x: u32, y: u32) -> Vec<u16> {
        assert!(x < self.width && y < self.height, "pixel outside");
        let size = self.aov.pixel_bytes();
        let at = (y as usize * self.width as usize + x as usize) * size;
        let bytes = &self.data[at..at + size];
        match self.aov.bits() {
            16 => bytes
                .as_chunks::<2>()
                .0
                .iter()
                .map(|&b| u16::from_be_bytes(b))
                .collect(),
            _ => bytes.iter().map(|&b| b.into()).collect(),
        }
    }

    /// Values of a pixel of `depth`, `position` or `uv` from its codes and the range; `None` where nothing is.
    ///
    /// # Panics
    /// Outside the picture.
    #[must_use]
    pub fn value(&self, x: u32, y: u32) -> Option<[f64; 3]> {
        let codes = self.codes(x, y);
        let shows = match self.aov {
            Aov::Depth => codes[0] != u16::MAX,
            Aov::Position => codes != [0; 3],
            Aov::Uv => codes[2] != 0,
            _ => false,
        };
        let at = |k: usize| {
            let code = codes.get(k).copied().unwrap_or(0);
            self.low[k] + f64::from(code) / 65535.0 * (self.high[k] - self.low[k])
        };
        shows.then(|| [at(0), at(1), at(2)])
    }

    /// PNG bytes, with pairs of a keyword and a text in chunks of their own.
    ///
    /// # Errors
    /// As [`png::encode`].
    pub fn encode(&self, texts: &[(&str, String)]) -> Result<Vec<u8>, WriteError> {
        let format = [self.aov.channels(), self.aov.bits()];
        png::encode_data(&self.data, [self.width, self.height], format, texts)
    }
}

/// What a frame writes beside its picture, and over which ranges.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wanted {
    pub(crate) aovs: Vec<Aov>,
    pub(crate) position: [[f32; 3]; 2],
    pub(crate) uv: [[f32; 3]; 2],
    pub(crate) depth: [f32; 2],
    /// Samples of a pixel, nearest to its centre first.
    pub(crate) nearest: Vec<u32>,
}

impl Wanted {
    /// Without any of `aovs` nothing is looked at.
    pub(super) fn new(aovs: &[Aov], view: &View, samples: u32) -> Self {
        if aovs.is_empty() {
            return Self::default();
        }
        let centre = |k: &u32| {
            let [x, y] = sample_positions(samples)[*k as usize].map(|c| c - 128);
            (x * x + y * y, *k)
        };
        let mut nearest: Vec<u32> = (0..samples).collect();
        nearest.sort_by_key(centre);
        Self {
            aovs: aovs.to_vec(),
            depth: [view.near, view.far],
            nearest,
            ..Self::default()
        }
    }

    pub(crate) fn wants(&self, aov: Aov) -> bool {
        self.aovs.contains(&aov)
    }

    /// A cube around everything, a little larger than the sphere, so that no surface has code 0.
    pub(super) fn set_sphere(&mut self, sphere: &Sphere) {
        let reach = match sphere.radius {
            r if r > 0.0 => r * 1.01,
            _ => 1.0,
        };
        self.position = [-reach, reach].map(|r| sphere.center.map(|c| (c + r) as f32));
    }

    /// Whole numbers around all texture coordinates.
    pub(super) fn set_uvs(&mut self, uvs: impl Iterator<Item = [f32; 2]>) {
        let (mut low, mut high) = ([0.0_f32; 2], [1.0_f32; 2]);
        for uv in uvs.filter(|uv| uv.iter().all(|c| c.is_finite())) {
            low = [0, 1].map(|k| low[k].min(uv[k].floor()));
            high = [0, 1].map(|k| high[k].max(uv[k].ceil()));
        }
        self.uv = [[low[0], low[1], 0.0], [high[0], high[1], 1.0]];
    }

    /// Bytes of all outputs for so many pixels.
    pub(crate) fn bytes(&self, pixels: u128) -> u128 {
        let each = self.aovs.iter().map(|a| a.pixel_bytes() as u128);
        each.sum::<u128>() * pixels
    }

    /// Empty outputs of the whole picture.
    pub(crate) fn planes(&self, width: u32, height: u32) -> Vec<Plane> {
        let pixels = width as usize * height as usize;
        let wide = |v: [f32; 3]| v.map(f64::from);
        let plane = |&aov: &Aov| {
            let [low, high] = match aov {
                Aov::Depth => self.depth.map(|d| [d, 0.0, 0.0]),
                Aov::Position => self.position,
                Aov::Uv => self.uv,
                _ => [[0.0; 3]; 2],
            };
            Plane {
                aov,
                width,
                height,
                data: vec![aov.nothing(); pixels * aov.pixel_bytes()],
                low: wide(low),
                high: wide(high),
            }
        };
        self.aovs.iter().map(plane).collect()
    }

    /// Codes of a point, in as many bytes as its output has.
    fn write(&self, aov: Aov, frame: &Frame<'_>, point: &SurfacePoint, count: u32, out: &mut [u8]) {
        let code =
            |x: f32, [low, high]: [f32; 2]| saturate((x - low) / (high - low)) * 65535.0 + 0.5;
        let range = |r: &[[f32; 3]; 2], k: usize| [r[0][k], r[1][k]];
        let mut wide = |codes: &[u16]| {
            for (o, c) in out.as_chunks_mut::<2>().0.iter_mut().zip(codes) {
                *o = c.to_be_bytes();
            }
        };
        match aov {
            Aov::Depth => wide(&[((point.depth01 * 65535.0 + 0.5) as u16).min(65534)]),
            Aov::Position => wide(&[0, 1, 2].map(|k| {
                let code = code(point.position[k], range(&self.position, k)) as u16;
                code.max(1)
            })),
            Aov::Uv => {
                let Some(uv) = point.uv else { return };
                let [u, v] = [0, 1].map(|k| code(uv[k], range(&self.uv, k)) as u16);
                wide(&[u, v, u16::MAX]);
            }
            Aov::Normal => {
                let n = frame.shader.normal(point);
                let [r, g, b] = n.map(|c| quantize(c * 0.5 + 0.5));
                out.copy_from_slice(&[r, g, b, 255]);
            }
            Aov::Albedo => {
                let [r, g, b, _] = frame.shader.albedo(point);
                let [r, g, b] = [r, g, b].map(|c| Srgb::tables().encode(saturate(c)));
                out.copy_from_slice(&[r, g, b, 255]);
            }
            Aov::Face => out.copy_from_slice(&(point.face + 1).to_be_bytes()[1..]),
            Aov::Level => out[0] = point.level as u8 + 1,
            Aov::Coverage => {
                let samples = self.nearest.len() as u32;
                out[0] = ((count * 255 + samples / 2) / samples) as u8;
            }
        }
    }
}

/// Outputs of the tile of one thread.
#[derive(Debug, Default)]
pub(super) struct TilePlanes {
    /// The sample of every pixel that counts, and how many show anything.
    visible: Visible,
    /// Bytes of the tile, output by output.
    pub(super) rows: Vec<Vec<u8>>,
    width: usize,
}

impl TilePlanes {
    /// Makes all pixels of a tile empty.
    pub(super) fn clear(&mut self, wanted: &Wanted, [width, height]: [u32; 2]) {
        self.width = width as usize;
        self.rows.resize_with(wanted.aovs.len(), Vec::new);
        for (aov, rows) in wanted.aovs.iter().zip(&mut self.rows) {
            rows.clear();
            let pixels = width as usize * height as usize;
            rows.resize(pixels * aov.pixel_bytes(), aov.nothing());
        }
    }
}

/// Puts the rows of a tile, from column `x` on and `width` wide, into those of the picture; `size` is the bytes of a pixel.
pub(super) fn copy_rows(
    band: &mut [u8],
    rows: &[u8],
    picture: u32,
    [x, width]: [u32; 2],
    size: usize,
) {
    let [picture, x, width] = [picture, x, width].map(|n| n as usize * size);
    let lines = band.chunks_exact_mut(picture);
    for (to, row) in lines.zip(rows.chunks_exact(width)) {
        to[x..x + width].copy_from_slice(row);
    }
}

/// Finds the samples that count, once all blocks of the tile are drawn.
pub(super) fn gather(frame: &Frame<'_>, s: &mut Scratch) {
    // With one sample they are those of the picture.
    if !frame.wanted.aovs.is_empty() && frame.size.samples > 1 {
        let ranks = s.drawn.len();
        s.planes
            .visible
            .gather_nearest(frame.simd, &s.tile, ranks, &frame.wanted.nearest);
    }
}

/// Writes the outputs of a block that was just shaded: its points and attributes are still there.
pub(super) fn record(
    frame: &Frame<'_>,
    source: &Source<'_>,
    s: &mut Scratch,
    rank: usize,
    template: SurfacePoint,
) {
    let item = s.drawn[rank].item - source.first_item;
    let TilePlanes {
        visible,
        rows,
        width,
    } = &mut s.planes;
    let visible = match frame.size.samples {
        1 => &s.visible,
        _ => &*visible,
    };
    let block = shading::Shown {
        points: &s.points,
        attributes: &s.attributes,
        footprint: &s.footprint,
        projected: &s.projected,
        item,
        list: source.shape(item).list(),
        origin: s.tile.origin(),
    };
    for f in visible.of_rank(rank) {
        let point = block.point(frame, source, *f, template);
        let pixel = f.y() as usize * *width + f.x() as usize;
        for (&aov, rows) in frame.wanted.aovs.iter().zip(rows.iter_mut()) {
            let size = aov.pixel_bytes();
            let out = &mut rows[pixel * size..(pixel + 1) * size];
            frame.wanted.write(aov, frame, &point, f.count(), out);
        }
    }
}
