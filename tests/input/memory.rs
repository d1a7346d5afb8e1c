//! Budgets of drawing: refused before much more than they allow is asked for.

use earmark::camera::Camera;
use earmark::frame::{Refinement, RenderError, Renderer, Scene};
use earmark::limits::LimitError;
use earmark::scheme::Scheme;
use earmark::{Cage, Surface, SurfaceOptions};

/// A sheet of `n` by `n` squares, or twice as many triangles, all of whose inner edges have a sharpness.
fn sheet(n: u32, triangles: bool, sharpness: f32) -> Cage {
    let side = n + 1;
    let points = (0..side * side).map(|k| {
        let height = (k * 7 % 5) as f32 * 0.2;
        [(k % side) as f32, (k / side) as f32, height]
    });
    let mut builder = Cage::builder().points(points);
    for k in (0..side * n).filter(|k| k % side < n) {
        let [a, b, c, d] = [k, k + 1, k + side + 1, k + side];
        builder = match triangles {
            true => builder.face([a, b, c]).face([a, c, d]),
            false => builder.face([a, b, c, d]),
        };
        if sharpness > 0.0 {
            builder = builder.crease(a, b, sharpness).crease(d, a, sharpness);
        }
    }
    builder.build().unwrap()
}

/// Draws on one thread, whose tiles take a known share of the budget.
fn draw(scene: &Scene, refinement: Refinement, bytes: Option<u64>) -> Result<u64, RenderError> {
    let mut renderer = Renderer::new(48, 48);
    renderer.refinement = refinement;
    renderer.limits.max_memory = bytes;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let frame = pool
        .unwrap()
        .install(|| renderer.render(scene, &Camera::default()))?;
    Ok(frame.stats.pixels_covered)
}

/// With a small budget drawing fails for `wanted`, before much more than the budget is asked for, now and after the picture was drawn
/// with a large one; surfaces are made anew for each.
fn assert_bounded(scene: impl Fn() -> Scene, refinement: Refinement, small: u64, wanted: &str) {
    let fails = |scene: &Scene| match draw(scene, refinement, Some(small)) {
        Err(RenderError::Limit(LimitError::Memory {
            what,
            wanted: bytes,
            allowed,
        })) => {
            assert!(what.contains(wanted), "{what}");
            assert_eq!(allowed, small);
            assert!(bytes > small, "{bytes}");
            bytes
        }
        other => panic!("{other:?}"),
    };
    let fresh = scene();
    let bytes = fails(&fresh);
    assert!(bytes < 40 * small, "{bytes}");
    // Nothing was gained by trying.
    assert_eq!(fails(&fresh), bytes);
    assert!(draw(&fresh, refinement, Some(1 << 30)).unwrap() > 100);
    assert_eq!(fails(&fresh), bytes);
}

#[test]
fn control_faces_of_deep_sharpness_count_as_memory() {
    for triangles in [false, true] {
        let scene = || Scene::of(Surface::new(sheet(4, triangles, 9.0), &Default::default()));
        assert_bounded(scene, Refinement::Uniform(8), 4 << 20, "control faces");
        if !triangles {
            let adaptive = Refinement::Adaptive(Default::default());
            assert_bounded(scene, adaptive, 4 << 20, "control faces");
        }
    }
    // Without creases there is nothing to count but the picture.
    let plain = Scene::of(Surface::new(sheet(4, false, 0.0), &Default::default()));
    let refused = draw(&plain, Refinement::Uniform(8), Some(4 << 20)).unwrap_err();
    assert!(refused.to_string().contains("the picture"), "{refused}");
}

#[test]
fn meshes_and_tables_of_interpolating_surfaces_count_as_memory() {
    for (scheme, triangles) in [(Scheme::Kobbelt, false), (Scheme::Butterfly, true)] {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        };
        let scene = || Scene::of(Surface::new(sheet(4, triangles, 0.0), &options));
        assert_bounded(scene, Refinement::Uniform(9), 1 << 20, "refined mesh");
        assert_bounded(scene, Refinement::Uniform(5), 1 << 20, "tables");
    }
}
