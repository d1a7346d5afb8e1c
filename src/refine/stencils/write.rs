//! Stencils as bytes and as JSON.

use super::Stencils;
use std::io::{self, Write};

const MAGIC: &[u8; 8] = b"EARSTEN1";
/// Numbers that are turned to bytes at a time.
const RUN: usize = 1 << 14;

fn numbers<T: Copy, const N: usize>(
    out: &mut impl Write,
    items: &[T],
    bytes: impl Fn(T) -> [u8; N],
) -> io::Result<()> {
    for run in items.chunks(RUN) {
        let text: Vec<u8> = run.iter().flat_map(|&x| bytes(x)).collect();
        out.write_all(&text)?;
    }
    Ok(())
}

fn layers(s: &Stencils) -> Vec<&[f32]> {
    let [a, b] = &s.tangents;
    if a.is_empty() {
        vec![&s.weights]
    } else {
        vec![&s.weights, a, b]
    }
}

pub(super) fn bytes(s: &Stencils, out: &mut impl Write) -> io::Result<()> {
    let layers = layers(s);
    out.write_all(MAGIC)?;
    let head = [s.cage_points, s.len(), s.indices.len(), layers.len()];
    numbers(out, &head, |n| (n as u64).to_le_bytes())?;
    numbers(out, &s.offsets, u64::to_le_bytes)?;
    numbers(out, &s.indices, u32::to_le_bytes)?;
    for layer in layers {
        numbers(out, layer, f32::to_le_bytes)?;
    }
    Ok(())
}

pub(super) fn json(s: &Stencils, out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "{{\"version\": 1, \"cage_points\": {}, \"rows\": {}, \"stencils\": [",
        s.cage_points,
        s.len()
    )?;
    let names = ["weights", "du", "dv"];
    for i in 0..s.len() {
        let row = s.row(i);
        write!(out, "{{\"indices\": ")?;
        list(out, &s.indices[row.clone()])?;
        for (name, layer) in names.iter().zip(layers(s)) {
            write!(out, ", \"{name}\": ")?;
            list(out, &layer[row.clone()])?;
        }
        let end = if i + 1 == s.len() { "}" } else { "}," };
        writeln!(out, "{end}")?;
    }
    writeln!(out, "]}}")
}

fn list<T: std::fmt::Display>(out: &mut impl Write, items: &[T]) -> io::Result<()> {
    for (i, x) in items.iter().enumerate() {
        write!(out, "{}{x}", if i == 0 { "[" } else { ", " })?;
    }
    out.write_all(if items.is_empty() { b"[]" } else { b"]" })
}

/// Takes items of `N` bytes from the front.
fn take<T, const N: usize>(
    bytes: &mut &[u8],
    count: usize,
    from: impl Fn([u8; N]) -> T,
) -> Option<Vec<T>> {
    let (own, rest) = bytes.split_at_checked(count.checked_mul(N)?)?;
    *bytes = rest;
    let (items, _) = own.as_chunks::<N>();
    Some(items.iter().map(|&x| from(x)).collect())
}

pub(super) fn read(bytes: &[u8]) -> io::Result<Stencils> {
    parse(bytes).ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "no stencils"))
}

fn parse(bytes: &[u8]) -> Option<Stencils> {
    let mut rest = bytes.strip_prefix(MAGIC)?;
    let head = take(&mut rest, 4, u64::from_le_bytes)?;
    let head: Vec<usize> = (head.into_iter())
        .map(usize::try_from)
        .collect::<Result<_, _>>()
        .ok()?;
    let [cage_points, rows, entries, layers] = head[..] else {
        return None;
    };
    let offsets = take(&mut rest, rows.checked_add(1)?, u64::from_le_bytes)?;
    let indices = take(&mut rest, entries, u32::from_le_bytes)?;
    let weights = take(&mut rest, entries, f32::from_le_bytes)?;
    let tangents = match layers {
        1 => [Vec::new(), Vec::new()],
        3 => [
            take(&mut rest, entries, f32::from_le_bytes)?,
            take(&mut rest, entries, f32::from_le_bytes)?,
        ],
        _ => return None,
    };
    let sound = rest.is_empty()
        && offsets.first() == Some(&0)
        && offsets.last() == Some(&(entries as u64))
        && offsets.is_sorted()
        && indices.iter().all(|&i| (i as usize) < cage_points);
    sound.then_some(Stencils {
        cage_points,
        offsets,
        indices,
        weights,
        tangents,
    })
}
