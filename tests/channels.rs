//! Values per vertex, face and corner: refined, at the limit, and as files.
#![allow(missing_docs)]

mod support;

use earmark::evaluate::ChannelKind;
use earmark::mesh::{FaceVaryingChannel, UniformValues};
use earmark::refine::{Level, Options, Timings, limit, refine};
use earmark::scheme::{Boundary, FaceVaryingRule, Scheme};
use earmark::topology::{ConnectOptions, Topology, connect};
use earmark::{Cage, Surface, SurfaceOptions};
use support::random_cages::{COUNT, random_cage};
use support::{all_shapes, assert_close, base_level, refined};

fn topology(cage: &Cage, boundary: Boundary) -> Topology {
    let tags = cage.tags();
    let options = ConnectOptions {
        boundary,
        creases: &tags.creases,
        corners: &tags.corners,
        holes: &tags.holes,
    };
    let corners = cage.corner_vertices().to_vec();
    connect(cage.points().len(), cage.face_offsets(), corners, &options).0
}

fn deeper(level: Level<f64>, levels: u32) -> Level<f64> {
    refine(
        level,
        &Options::default(),
        levels,
        None,
        &mut Timings::default(),
    )
    .unwrap()
}

/// Channels that repeat points and texture coordinates are refined to the same numbers as these, and so are their limits.
#[test]
fn channels_go_by_the_rules_of_points_and_texture_coordinates() {
    for index in [0, 7, 50, 111, 200] {
        let cage = random_cage(index);
        let shape = &cage.shape;
        let flat: Vec<f32> = (shape.points.iter())
            .flat_map(|p| [p[0], p[1], p[2], p[0]].map(|c| c as f32))
            .collect();
        let uvs: Vec<f32> = (shape.uvs.iter())
            .flat_map(|p| [p[1], p[0], p[1]].map(|c| c as f32))
            .collect();
        let faces = shape.faces() as u32;
        let built = Cage::builder()
            .points(shape.points.iter().map(|p| p.map(|c| c as f32)))
            .faces(
                shape.face_offsets.windows(2).map(|w| w[1] - w[0]),
                shape.corners.iter().copied(),
            )
            .creases(shape.creases.iter().copied())
            .uvs(
                shape.uvs.iter().map(|p| p.map(|c| c as f32)),
                shape.corner_uvs.iter().copied(),
            )
            .colors(shape.points.iter().map(|p| p.map(|c| c as f32)))
            .vertex_channel("four", 4, flat)
            .vertex_channel("one", 1, shape.points.iter().map(|p| p[2] as f32))
            .face_varying("three", 3, uvs.clone(), shape.corner_uvs.iter().copied())
            .face_varying_channel(FaceVaryingChannel {
                name: "linear".into(),
                width: 1,
                values: shape.uvs.iter().map(|p| p[0] as f32).collect(),
                corners: shape.corner_uvs.clone(),
                rule: Some(FaceVaryingRule::All),
            })
            .face_ids("id", (0..faces).map(|f| 3 * f))
            .build()
            .unwrap();
        let rule = FaceVaryingRule::CornersPlus1;
        let base = Level::<f64>::of_cage(
            &built,
            topology(&built, Boundary::EdgeAndCorner),
            Scheme::CatmullClark,
            rule,
        )
        .unwrap();
        let level = deeper(base, 2);
        let limits = limit(&level, &Options::default());
        let uv = level.uvs.as_ref().unwrap();
        for (channels, points, uvs) in [
            (&level.channels, &level.points, &uv.values),
            (&limits.channels, &limits.positions, &limits.uvs),
        ] {
            assert_eq!(channels.vertex.len(), 3);
            let [color, four, one] = &channels.vertex[..] else {
                panic!("three channels")
            };
            assert_eq!(color.name, "color");
            for (v, p) in points.iter().enumerate() {
                assert_eq!(color.value(v).collect::<Vec<_>>(), p);
                assert_eq!(four.value(v).collect::<Vec<_>>(), [p[0], p[1], p[2], p[0]]);
                assert_eq!(one.value(v).collect::<Vec<_>>(), [p[2]]);
            }
            let three = &channels.face_varying[0];
            assert_eq!(three.corners(), uv.corners);
            assert_eq!(three.len(), uvs.len());
            for (i, p) in uvs.iter().enumerate() {
                assert_eq!(three.value(i).collect::<Vec<_>>(), [p[1], p[0], p[1]]);
            }
            // What is linear is at its limit already.
            let [linear, refined] = [channels, &level.channels].map(|c| &c.face_varying[1]);
            assert!((0..linear.len()).all(|i| linear.value(i).eq(refined.value(i))));
            let UniformValues::Ids(ids) = &channels.uniform[0].values else {
                panic!("ids")
            };
            for f in 0..level.topology.face_count() as u32 {
                let base = level.base_face(f);
                assert_eq!(ids[base as usize], 3 * base);
            }
        }
    }
}

/// At any place a channel has what points and texture coordinates of the same numbers have, and at corners the limits of the whole mesh.
#[test]
fn channels_are_found_at_any_place() {
    let mut compared = 0;
    for index in [0, 7, 50, 111, 200] {
        let cage = random_cage(index);
        let shape = &cage.shape;
        let faces = shape.faces() as u32;
        let flat = shape.points.iter();
        let flat = flat.flat_map(|p| [p[0], p[1], p[2], p[1]].map(|c| c as f32));
        let uvs: Vec<f32> = (shape.uvs.iter())
            .flat_map(|p| [p[1], p[0], p[1]].map(|c| c as f32))
            .collect();
        let built = Cage::builder()
            .points(shape.points.iter().map(|p| p.map(|c| c as f32)))
            .faces(
                shape.face_offsets.windows(2).map(|w| w[1] - w[0]),
                shape.corners.iter().copied(),
            )
            .creases(shape.creases.iter().copied())
            .uvs(
                shape.uvs.iter().map(|p| p.map(|c| c as f32)),
                shape.corner_uvs.iter().copied(),
            )
            .vertex_channel("four", 4, flat)
            .face_varying("three", 3, uvs.clone(), shape.corner_uvs.iter().copied())
            .face_varying_channel(FaceVaryingChannel {
                name: "linear".into(),
                width: 1,
                values: shape.uvs.iter().map(|p| p[0] as f32).collect(),
                corners: shape.corner_uvs.clone(),
                rule: Some(FaceVaryingRule::All),
            })
            .face_channel("pair", 2, (0..2 * faces).map(|k| k as f32))
            .face_ids("id", 0..faces)
            .build()
            .unwrap();
        let options = SurfaceOptions {
            scheme: Some(Scheme::CatmullClark),
            ..SurfaceOptions::default()
        };
        let surface = Surface::new(built.clone(), &options);
        let channel = |kind, name| surface.named_channel(kind, name).unwrap();
        let four = channel(ChannelKind::Vertex, "four");
        let three = channel(ChannelKind::FaceVarying, "three");
        let linear = channel(ChannelKind::FaceVarying, "linear");
        let pair = channel(ChannelKind::Uniform, "pair");
        assert!(surface.named_channel(ChannelKind::Uniform, "id").is_none());
        assert!(
            surface
                .named_channel(ChannelKind::Vertex, "three")
                .is_none()
        );
        assert_eq!([four.width(), three.width(), pair.width()], [4, 3, 2]);

        let base = Level::<f64>::of_cage(
            &built,
            topology(&built, Boundary::EdgeAndCorner),
            Scheme::CatmullClark,
            FaceVaryingRule::CornersPlus1,
        )
        .unwrap();
        let limits = limit(&base, &Options::default());
        let t = &base.topology;
        for f in 0..faces {
            let mut face = surface.face_evaluator(f).unwrap();
            for (u, v) in [(0.2, 0.7), (0.5, 0.0), (0.75, 0.5), (1e-3, 0.999)] {
                let [x, y, z] = surface.evaluate_as::<[f32; 3]>(f, u, v).unwrap();
                assert_eq!(four.at(f, u, v), Some([x, y, z, y]));
                let [a, b] = face.uv(u, v).unwrap();
                assert_eq!(three.at(f, u, v), Some([b, a, b, 0.0]));
                let of_face = [2 * f, 2 * f + 1].map(|k| k as f32);
                assert_eq!(pair.at(f, u, v), Some([of_face[0], of_face[1], 0.0, 0.0]));
            }
            assert!(pair.at(f, -0.5, 0.5).is_none() && four.at(faces, 0.5, 0.5).is_none());
            let halves = t.face_halves(f);
            for (k, h) in halves.clone().enumerate() {
                let (u, v) = match halves.len() {
                    4 => [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][k],
                    _ => (k as f32, 0.0),
                };
                for (found, name) in [(&three, "three"), (&linear, "linear")] {
                    let all = &limits.channels.face_varying;
                    let all = all.iter().find(|c| c.name == name).unwrap();
                    let value = all.corners()[h as usize] as usize;
                    let got = found.at(f, u, v).unwrap();
                    for (got, want) in got.iter().zip(all.value(value)) {
                        let error = (f64::from(*got) - want).abs();
                        assert!(error < 2e-6, "{name} of {index}, {f} {k}: {got} {want}");
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 500, "{compared}");
}

/// The limit of a value is the same from every level.
#[test]
fn limits_of_texture_coordinates_do_not_depend_on_the_level() {
    let (mut worst, mut compared) = (0.0_f64, 0);
    let mut semi_sharp = 0;
    for index in 0..COUNT {
        let cage = random_cage(index);
        let level = base_level(&cage.shape, &cage.case);
        let options = &cage.case.options;
        let kinds = |l: &Level<f64>| {
            use earmark::refine::face_varying::SiblingKind as K;
            let siblings = l.uvs.as_ref().unwrap().siblings();
            siblings
                .iter()
                .filter(|s| matches!(s.kind, K::SemiSharp | K::Dependent))
                .count()
        };
        semi_sharp += kinds(&level);
        // Local refinement knows rings of quads: from level 1 on every level is one.
        let from: Vec<Vec<[f64; 2]>> = (0..3)
            .map(|n| limit(&refined(level.clone(), n, options), options).uvs)
            .collect();
        for (n, coarse) in from[..2].iter().enumerate() {
            for (i, p) in coarse.iter().enumerate() {
                let d = support::distance(p, &from[n + 1][i]);
                assert!(d < 1e-12, "cage {index}, level {n}, value {i}: {d:.2e}");
                worst = worst.max(d);
                compared += 1;
            }
        }
    }
    assert!(
        compared > 20_000 && semi_sharp > 100,
        "{compared} {semi_sharp}"
    );
    assert!(worst > 0.0);
}

/// Refined values approach the limit.
#[test]
fn texture_coordinates_converge_to_their_limits() {
    for index in 0..24 {
        let cage = random_cage(index);
        let options = &cage.case.options;
        let level = refined(base_level(&cage.shape, &cage.case), 1, options);
        let limits = limit(&level, options).uvs;
        let deep = refined(level, 4, options);
        let values = &deep.uvs.as_ref().unwrap().values;
        let farthest = (limits.iter().zip(values))
            .map(|(a, b)| support::distance(a, b))
            .fold(0.0, f64::max);
        assert!(farthest < 0.02, "cage {index}: {farthest}");
    }
}

/// Where texture coordinates are positions, so are their limits.
#[test]
fn limits_of_coinciding_values_are_limits_of_points() {
    for shape in all_shapes() {
        let values: Vec<[f64; 2]> = shape.points.iter().map(|p| [p[0], p[2]]).collect();
        let level = shape
            .level(Boundary::EdgeAndCorner)
            .with_uvs(
                &values,
                &shape.corners,
                Scheme::CatmullClark,
                FaceVaryingRule::CornersOnly,
            )
            .unwrap();
        for n in 0..3 {
            let level = refined(level.clone(), n, &Options::default());
            let limits = limit(&level, &Options::default());
            let t = &level.topology;
            let corners = &level.uvs.as_ref().unwrap().corners;
            for h in 0..t.half_count() as u32 {
                let p = limits.positions[t.vertex(h) as usize];
                let uv = limits.uvs[corners[h as usize] as usize];
                assert_close(&uv, &[p[0], p[2]], 1e-12);
            }
        }
    }
}

#[test]
fn channels_count_as_memory() {
    let shape = support::cube();
    let cage = |colors: bool| {
        let b = Cage::builder()
            .points(shape.points.iter().map(|p| p.map(|c| c as f32)))
            .faces([4; 6], shape.corners.iter().copied());
        let b = if colors { b.colors([[0.5; 3]; 8]) } else { b };
        b.build().unwrap()
    };
    let bytes = |colors: bool| {
        let cage = cage(colors);
        let t = topology(&cage, Boundary::EdgeAndCorner);
        Level::<f32>::of_cage(&cage, t, Scheme::CatmullClark, FaceVaryingRule::All)
            .unwrap()
            .predicted_bytes(earmark::scheme::Scheme::CatmullClark, 4)
    };
    let level = deeper(support::cube().level(Boundary::EdgeAndCorner), 4);
    let above = deeper(support::cube().level(Boundary::EdgeAndCorner), 3);
    let vertices = (level.points.len() + above.points.len()) as u128;
    assert_eq!(bytes(true) - bytes(false), 12 * vertices);
}
