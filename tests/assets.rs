//! The committed assets are what the generator makes, and are what they claim to be.

#[path = "../examples/make_assets/generator.rs"]
mod generator;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets")
}

/// What an OBJ file says, read by a reader of our own so that a fault of the crate's reader cannot hide one of the assets.
#[derive(Default)]
struct Obj {
    points: Vec<[f64; 3]>,
    uvs: Vec<[f64; 2]>,
    faces: Vec<Vec<usize>>,
    face_uvs: Vec<Vec<usize>>,
    materials: BTreeSet<String>,
    creases: Vec<(usize, usize)>,
}

fn read(name: &str) -> Obj {
    let text = std::fs::read_to_string(folder().join(name)).expect(name);
    let mut o = Obj::default();
    let numbers = |words: &[&str]| -> Vec<f64> {
        words.iter().map(|w| w.parse().expect("a number")).collect()
    };
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[0] {
            "v" => o
                .points
                .push(numbers(&words[1..]).try_into().expect("three")),
            "vt" => o.uvs.push(numbers(&words[1..]).try_into().expect("two")),
            "usemtl" => {
                o.materials.insert(words[1].to_owned());
            }
            "f" => {
                let mut face = Vec::new();
                let mut uv = Vec::new();
                for corner in &words[1..] {
                    let mut parts = corner
                        .split('/')
                        .map(|i| i.parse::<usize>().expect("index"));
                    face.push(parts.next().expect("vertex") - 1);
                    uv.extend(parts.next().map(|i| i - 1));
                }
                assert!(uv.is_empty() || uv.len() == face.len(), "{name}: {line}");
                o.faces.push(face);
                o.face_uvs.push(uv);
            }
            "t" => {
                let vertex = |k: usize| words[k].parse::<usize>().expect("vertex");
                let (a, b) = (vertex(3), vertex(4));
                o.creases.push((a.min(b), a.max(b)));
            }
            "#" | "mtllib" => {}
            other => panic!("{name}: {other}"),
        }
    }
    assert_eq!(o.uvs.is_empty(), o.face_uvs[0].is_empty());
    let used: BTreeSet<usize> = o.faces.iter().flatten().copied().collect();
    assert_eq!(used.len(), o.points.len(), "{name}: every vertex is used");
    let edges = o.edges();
    assert!(o.creases.iter().all(|c| edges.contains_key(c)), "{name}");
    o
}

impl Obj {
    /// Edges with the direction in which each of their faces runs along them.
    fn edges(&self) -> BTreeMap<(usize, usize), Vec<bool>> {
        let mut edges: BTreeMap<_, Vec<bool>> = BTreeMap::new();
        for f in &self.faces {
            for (k, &a) in f.iter().enumerate() {
                let b = f[(k + 1) % f.len()];
                assert_ne!(a, b);
                edges.entry((a.min(b), a.max(b))).or_default().push(a < b);
            }
        }
        edges
    }

    fn valences(&self) -> Vec<usize> {
        let mut n = vec![0; self.points.len()];
        for (a, b) in self.edges().keys() {
            n[*a] += 1;
            n[*b] += 1;
        }
        n
    }

    fn boundary_edges(&self) -> usize {
        self.edges().values().filter(|f| f.len() == 1).count()
    }

    /// At most two faces at an edge, and one fan of faces at every vertex.
    fn assert_manifold(&self) {
        assert!(self.edges().values().all(|f| f.len() <= 2));
        let mut at: Vec<Vec<[usize; 2]>> = vec![Vec::new(); self.points.len()];
        for f in &self.faces {
            for k in 0..f.len() {
                at[f[k]].push([f[(k + f.len() - 1) % f.len()], f[(k + 1) % f.len()]]);
            }
        }
        for (v, wedges) in at.iter().enumerate() {
            let mut reached: BTreeSet<usize> = wedges[0].into_iter().collect();
            let mut left: Vec<[usize; 2]> = wedges[1..].to_vec();
            while !left.is_empty() {
                let before = left.len();
                left.retain(|w| {
                    let joins = w.iter().any(|x| reached.contains(x));
                    if joins {
                        reached.extend(w);
                    }
                    !joins
                });
                assert!(left.len() < before, "vertex {v} joins two fans");
            }
        }
    }

    /// Whether the two faces of every edge run along it in opposite directions.
    fn oriented(&self) -> bool {
        self.edges().values().all(|f| f.len() < 2 || f[0] != f[1])
    }

    fn euler(&self) -> i64 {
        self.points.len() as i64 - self.edges().len() as i64 + self.faces.len() as i64
    }

    /// Six times the enclosed volume of a closed mesh; positive when faces look outwards.
    fn volume(&self) -> f64 {
        let mut sum = 0.0;
        for f in &self.faces {
            for k in 1..f.len() - 1 {
                let [a, b, c] = [0, k, k + 1].map(|k| self.points[f[k]]);
                sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]);
            }
        }
        sum
    }

    /// The vertices on the refined surface, three levels down.
    fn refined(&self) -> Vec<[f64; 3]> {
        let mut net = generator::refine::Net::new(self.points.clone(), self.faces.clone());
        for _ in 0..3 {
            net = net.refine();
        }
        net.points
    }
}

#[test]
fn generator_reproduces_the_committed_files() {
    let made = generator::files();
    let names: BTreeSet<String> = made.iter().map(|(n, _)| n.clone()).collect();
    assert_eq!(names.len(), made.len());
    for (name, bytes) in &made {
        let committed = std::fs::read(folder().join(name)).expect(name);
        if name.ends_with(".png") {
            // Pixels, not bytes: how well the encoder packs is not ours.
            let pixels = |b: &[u8]| image::load_from_memory(b).expect(name).to_rgb8();
            assert!(pixels(&committed) == pixels(bytes), "{name} differs");
            assert!(committed.len() < 600_000, "{name}: {}", committed.len());
        } else {
            assert!(&committed == bytes, "{name} differs");
            assert!(committed.len() < 250_000, "{name}: {}", committed.len());
        }
        if name.ends_with(".obj") {
            numbers_are_short(name, bytes);
        }
    }
    for entry in std::fs::read_dir(folder()).expect("folder") {
        let entry = entry.expect("entry");
        // Pictures of the README are made by the program, not by the generator.
        if entry.path().is_dir() {
            assert_eq!(entry.file_name(), "pictures");
            continue;
        }
        let name = entry.file_name();
        let name = name.to_string_lossy();
        assert!(
            name == "README.md" || names.contains(&*name),
            "{name} is not generated"
        );
    }
}

fn numbers_are_short(name: &str, bytes: &[u8]) {
    let text = std::str::from_utf8(bytes).expect("text");
    for line in text.lines().filter(|l| l.starts_with('v')) {
        for word in line.split_whitespace().skip(1) {
            let digits = word.chars().filter(char::is_ascii_digit).count();
            assert!(digits <= 9 && word != "-0", "{name}: {word}");
        }
    }
}

#[test]
fn creature_is_a_closed_quad_mesh() {
    let o = read("creature.obj");
    assert!((1200..=1400).contains(&o.faces.len()), "{}", o.faces.len());
    assert!(o.faces.iter().all(|f| f.len() == 4));
    assert_eq!(o.boundary_edges(), 0);
    o.assert_manifold();
    assert!(o.oriented());
    assert_eq!(o.euler(), 2);
    assert!(o.volume() > 0.0);
    let mut count = BTreeMap::new();
    for n in o.valences() {
        *count.entry(n).or_insert(0_usize) += 1;
    }
    assert_eq!(count.keys().copied().collect::<Vec<_>>(), [3, 4, 5, 6]);
    assert!(count[&4] * 2 > o.points.len(), "{count:?}");
    assert!(count[&5] > 20 && count[&6] > 10, "{count:?}");
}

#[test]
fn creature_stands_on_the_ground() {
    let points = read("creature.obj").refined();
    let range = |axis: usize| {
        let lo = points.iter().map(|p| p[axis]).fold(f64::MAX, f64::min);
        let hi = points.iter().map(|p| p[axis]).fold(f64::MIN, f64::max);
        (lo, hi)
    };
    assert!(range(1).0.abs() < 1e-4);
    assert!(range(1).1 < 1.3);
    let long = range(2).1 - range(2).0;
    assert!((1.7..2.3).contains(&long), "{long}");
}

/// Calls `hit` for every texel whose middle lies inside the triangle.
fn texels(size: f64, t: [[f64; 2]; 3], mut hit: impl FnMut(usize)) {
    let t = t.map(|p| p.map(|x| x * size));
    let side = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let range = |d: usize| {
        let all = || t.iter().map(|p| p[d]);
        (all().fold(size, f64::min) as usize)..(all().fold(0.0, f64::max).ceil() as usize)
    };
    for y in range(1) {
        for x in range(0) {
            let p = [x as f64 + 0.5, y as f64 + 0.5];
            // A middle exactly on an edge belongs to neither side.
            if (0..3).all(|k| side(t[k], t[(k + 1) % 3], p) > 1e-9) {
                hit(y * size as usize + x);
            }
        }
    }
}

#[test]
fn creature_charts_neither_fold_nor_overlap() {
    let o = read("creature.obj");
    assert!(o.uvs.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
    let size = 1024;
    let mut taken = vec![0_u8; size * size];
    for (f, uv) in o.face_uvs.iter().enumerate() {
        let p = [0, 1, 2, 3].map(|k| o.uvs[uv[k]]);
        for split in [[0, 1, 2], [0, 2, 3]] {
            let area = generator::unwrap::area(split.iter().map(|&k| p[k]));
            assert!(area > 0.0, "face {f} folds: {area}");
            texels(size as f64, split.map(|k| p[k]), |i| taken[i] += 1);
        }
    }
    assert!(taken.iter().all(|&n| n <= 1), "charts overlap");
    let filled = taken.iter().filter(|&&n| n == 1).count() as f64 / taken.len() as f64;
    assert!(filled > 0.5, "filled {filled}");
}

#[test]
fn creature_charts_are_nearly_isometric() {
    let o = read("creature.obj");
    let points = o.refined();
    // How much edges and diagonals of quads are stretched.
    let mut stretches = Vec::new();
    for (face, uv) in o.faces.iter().zip(&o.face_uvs) {
        let p = [0, 1, 2, 3].map(|k| points[face[k]]);
        let t = [0, 1, 2, 3].map(|k| o.uvs[uv[k]]);
        for (a, b) in [(0, 2), (1, 3), (0, 1), (1, 2), (2, 3), (3, 0)] {
            let flat: f64 = (0..2).map(|d| (t[a][d] - t[b][d]).powi(2)).sum();
            let real: f64 = (0..3).map(|d| (p[a][d] - p[b][d]).powi(2)).sum();
            stretches.push((flat / real).sqrt());
        }
    }
    stretches.sort_by(f64::total_cmp);
    let at = |share: f64| stretches[(share * (stretches.len() - 1) as f64) as usize];
    let spread = [0.05, 0.25, 0.75, 0.95].map(|s| at(s) / at(0.5));
    assert!(spread[0] > 0.6 && spread[3] < 1.8, "{spread:?}");
    assert!(spread[1] > 0.85 && spread[2] < 1.15, "{spread:?}");
}

#[test]
fn part_mixes_polygons_and_has_a_boundary() {
    for (name, creases) in [("part.obj", false), ("part_creased.obj", true)] {
        let o = read(name);
        let sizes: BTreeSet<usize> = o.faces.iter().map(Vec::len).collect();
        assert_eq!(
            sizes.into_iter().collect::<Vec<_>>(),
            [3, 4, 5, 8],
            "{name}"
        );
        o.assert_manifold();
        assert!(o.oriented());
        // Outer rim, bore, six bolt holes, two set-screw holes: a sphere with ten holes and nothing else.
        assert_eq!(o.boundary_edges(), 48 + 12 + 8 * 8, "{name}");
        assert_eq!(o.euler(), 2 - 10, "{name}");
        assert_eq!(o.materials.len(), 2);
        assert_eq!(!o.creases.is_empty(), creases, "{name}");
    }
}

#[test]
fn teaching_cages_are_what_their_names_say() {
    // Name, vertices, faces, boundary edges, Euler characteristic, orientable.
    for (name, v, f, rim, euler, oriented) in [
        ("cube", 8, 6, 0, 2, true),
        ("tetrahedron", 4, 4, 0, 2, true),
        ("octahedron", 6, 8, 0, 2, true),
        ("torus", 96, 96, 0, 0, true),
        ("mobius", 48, 32, 32, 0, false),
        ("grid", 25, 16, 16, 1, true),
        ("corner", 21, 12, 16, 1, true),
        ("fan3", 19, 12, 12, 1, true),
        ("fan5", 31, 20, 20, 1, true),
        ("fan8", 49, 32, 32, 1, true),
        ("fan24", 145, 96, 96, 1, true),
    ] {
        let o = read(&format!("{name}.obj"));
        o.assert_manifold();
        let got = (
            o.points.len(),
            o.faces.len(),
            o.boundary_edges(),
            o.euler(),
            o.oriented(),
        );
        assert_eq!(got, (v, f, rim, euler, oriented), "{name}");
        if rim == 0 {
            assert!(o.volume() > 0.0, "{name} is inside out");
        }
        let in_square = |x: &f64| (0.0..=1.0).contains(x);
        assert!(o.uvs.iter().flatten().all(in_square), "{name}");
        if let Some(n) = name.strip_prefix("fan") {
            let n: usize = n.parse().expect("valence");
            let valences = o.valences();
            assert_eq!(valences[0], n);
            let around = o.faces.iter().filter(|f| f.contains(&0)).flatten();
            let ring: BTreeSet<usize> = around.copied().filter(|&v| v != 0).collect();
            assert_eq!(ring.len(), 2 * n);
            assert!(ring.iter().all(|&v| valences[v] == 4), "{name}");
        }
    }
    let valences = read("corner.obj").valences();
    assert_eq!(valences.iter().filter(|&&n| n == 2).count(), 5);
}
