//! Evaluation below the control levels that are made for all faces: the bits of levels that are all there.

use super::{FaceEvaluator, Sample};
use crate::dice::MAX_LEVEL;
use crate::mesh::obj;
use crate::mesh::resolver::NoFiles;
use crate::scheme::Scheme;
use crate::{Surface, SurfaceOptions};
use std::fmt::Write;

/// A bent sheet of 4 by 4 quads or twice as many triangles, with texture coordinates, a deep crease, a shallow one, a corner and a dart.
fn sheet(triangles: bool) -> Surface {
    let mut text = String::new();
    for k in 0..25 {
        let (x, y) = (f64::from(k % 5), f64::from(k / 5));
        let z = 0.4 * (x * 1.1 + 0.3).sin() + 0.2 * x * y - 0.1 * y * y;
        writeln!(text, "v {x} {y} {z}\nvt {x} {}", y + 0.1 * z).unwrap();
    }
    for q in 0..16 {
        let at = q / 4 * 5 + q % 4 + 1;
        let c = [at, at + 1, at + 6, at + 5].map(|v| format!("{v}/{v}"));
        if triangles {
            writeln!(
                text,
                "f {} {} {}\nf {} {} {}",
                c[0], c[1], c[2], c[0], c[2], c[3]
            )
            .unwrap();
        } else {
            writeln!(text, "f {} {} {} {}", c[0], c[1], c[2], c[3]).unwrap();
        }
    }
    for (a, b, sharpness) in [(6, 7, 5.5), (7, 12, 5.5), (11, 12, 2.2), (12, 13, 10.0)] {
        writeln!(text, "t crease 2/1/0 {a} {b} {sharpness}").unwrap();
    }
    text.push_str("t corner 1/1/0 17 3.5\n");
    let read = obj::read(
        text.as_bytes(),
        "sheet.obj",
        &mut NoFiles,
        &Default::default(),
    );
    let scheme = match triangles {
        true => Scheme::Loop,
        false => Scheme::CatmullClark,
    };
    let options = SurfaceOptions {
        scheme: Some(scheme),
        ..SurfaceOptions::default()
    };
    Surface::new(read.unwrap().cage, &options)
}

fn all(
    face: &mut FaceEvaluator<'_>,
    places: &[[f32; 2]],
) -> Vec<(Option<Sample>, Option<[f32; 2]>)> {
    (places.iter())
        .map(|&[u, v]| (face.at(u, v), face.uv(u, v)))
        .collect()
}

#[test]
fn single_faces_go_on_with_the_bits_of_all() {
    // Corners, places along sides and close to them, and in the middle.
    let ends = [0.0, 1.0, 0.5, 0.25, 0.015_625, 1e-3, 0.999, 0.3, 0.71];
    for triangles in [false, true] {
        let places: Vec<[f32; 2]> = (ends.iter())
            .flat_map(|&u| ends.map(|v| [u, v]))
            .filter(|[u, v]| !triangles || u + v <= 1.0)
            .collect();
        let whole = sheet(triangles);
        whole.ensure(MAX_LEVEL);
        // Nothing is made for all faces; a little is.
        for bytes in [0, 60_000] {
            let lazy = sheet(triangles);
            lazy.ensure_evaluation(bytes);
            for f in 0..lazy.topology().face_count() as u32 {
                let got = all(&mut lazy.face_evaluator(f).unwrap(), &places);
                let want = all(&mut whole.face_evaluator(f).unwrap(), &places);
                for ((place, got), want) in places.iter().zip(&got).zip(&want) {
                    assert_eq!(got, want, "face {f} at {place:?}, {bytes} bytes");
                }
                let [u, v] = places[f as usize % places.len()];
                assert_eq!(lazy.evaluate(f, u, v), whole.evaluate(f, u, v));
            }
        }
    }
}
