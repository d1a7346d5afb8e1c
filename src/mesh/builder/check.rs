//! Checks of the pieces of a cage, each with the first mistake it finds.

use crate::mesh::channel::{CageChannels, UniformValues};
use crate::mesh::{Cage, CageError, NONE, Tags};

pub(super) fn count(what: &str, got: usize, wanted: usize) -> Result<(), CageError> {
    if got == wanted {
        return Ok(());
    }
    Err(CageError::ChannelCount {
        name: what.to_owned(),
        got,
        wanted,
    })
}

pub(super) fn finite(what: &str, values: &[f32]) -> Result<(), CageError> {
    match values.iter().position(|c| !c.is_finite()) {
        None => Ok(()),
        Some(index) => Err(CageError::ChannelNotFinite {
            name: what.to_owned(),
            index,
        }),
    }
}

pub(super) fn in_range(what: &str, indices: &[u32], values: usize) -> Result<(), CageError> {
    let outside = |i: u32| i != NONE && i as usize >= values;
    match indices.iter().position(|&i| outside(i)) {
        None => Ok(()),
        Some(at) => Err(CageError::NoSuchValue {
            name: what.to_owned(),
            at,
            index: indices[at],
            count: values,
        }),
    }
}

pub(super) fn tags(cage: &Cage, tags: &Tags) -> Result<(), CageError> {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    if !tags.creases.is_empty() {
        for f in 0..cage.face_count() {
            let face = cage.face(f);
            edges.extend((0..face.len()).map(|i| sorted([face[i], face[(i + 1) % face.len()]])));
        }
        edges.sort_unstable();
    }
    for c in &tags.creases {
        let [a, b] = c.vertices;
        if edges.binary_search(&sorted([a, b])).is_err() {
            return Err(CageError::NoSuchEdge { vertices: [a, b] });
        }
        sharp(c.sharpness, || format!("edge {a}-{b}"))?;
    }
    for c in &tags.corners {
        if c.vertex as usize >= cage.points.len() {
            return Err(CageError::NoSuchCorner {
                vertex: c.vertex,
                count: cage.points.len(),
            });
        }
        sharp(c.sharpness, || format!("vertex {}", c.vertex))?;
    }
    match tags
        .holes
        .iter()
        .find(|&&f| f as usize >= cage.face_count())
    {
        None => Ok(()),
        Some(&face) => Err(CageError::NoSuchFace {
            face,
            count: cage.face_count(),
        }),
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn sharp(sharpness: f32, what: impl Fn() -> String) -> Result<(), CageError> {
    if sharpness >= 0.0 {
        Ok(())
    } else {
        Err(CageError::BadSharpness {
            what: what(),
            sharpness,
        })
    }
}

pub(super) fn channels(cage: &Cage, channels: &CageChannels) -> Result<(), CageError> {
    let reserved = if cage.colors.is_empty() { "" } else { "color" };
    unique(std::iter::once(reserved).chain(channels.vertex.iter().map(|c| c.name.as_str())))?;
    unique(channels.uniform.iter().map(|c| c.name.as_str()))?;
    unique(channels.face_varying.iter().map(|c| c.name.as_str()))?;
    for c in &channels.vertex {
        width(&c.name, c.width)?;
        count(&c.name, c.values.len(), cage.points.len() * c.width)?;
        finite(&c.name, &c.values)?;
    }
    for c in &channels.uniform {
        match &c.values {
            UniformValues::Ids(ids) => count(&c.name, ids.len(), cage.face_count())?,
            UniformValues::Numbers { width: w, values } => {
                width(&c.name, *w)?;
                count(&c.name, values.len(), cage.face_count() * w)?;
                finite(&c.name, values)?;
            }
        }
    }
    for c in &channels.face_varying {
        width(&c.name, c.width)?;
        let whole = c.values.len().next_multiple_of(c.width);
        count(&c.name, c.values.len(), whole)?;
        count(&c.name, c.corners.len(), cage.corner_vertices.len())?;
        finite(&c.name, &c.values)?;
        in_range(&c.name, &c.corners, c.values.len() / c.width)?;
    }
    Ok(())
}

fn width(name: &str, width: usize) -> Result<(), CageError> {
    if (1..=4).contains(&width) {
        return Ok(());
    }
    Err(CageError::ChannelWidth {
        name: name.to_owned(),
        width,
    })
}

fn unique<'a>(names: impl Iterator<Item = &'a str>) -> Result<(), CageError> {
    let mut names: Vec<&str> = names.filter(|n| !n.is_empty()).collect();
    names.sort_unstable();
    match names.windows(2).find(|w| w[0] == w[1]) {
        None => Ok(()),
        Some(w) => Err(CageError::SameName {
            name: w[0].to_owned(),
        }),
    }
}
