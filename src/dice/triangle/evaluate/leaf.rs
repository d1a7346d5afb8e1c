//! Down the control levels below a triangle at a feature, to the patch that holds a parameter.

use super::super::control::DescendTriangles;
use super::super::patch::TriangleChannel;
use super::super::ring::is_regular;
use crate::dice::evaluate::Leaf;

/// Follows the control levels below `face` down to the patch at (`u`, `v`). `None` where the triangle itself is the patch. `whole` where the
/// face is one of the surface; else it is a part of one, whose corners are places as any other.
pub(crate) fn leaf(
    below: &impl DescendTriangles,
    face: u32,
    u: f32,
    v: f32,
    whole: bool,
) -> Option<Leaf<TriangleChannel<'_>>> {
    let root = below.at(0)?;
    root.first_child(face)?;
    // Sums that are 1 only after rounding lie on the side. What is subtracted from 1 is at least a half, so differences are exact.
    let [u, v] = match (u >= 0.5, v >= 0.5) {
        (true, _) if whole => [u, v.min(1.0 - u)],
        (_, true) if whole => [u.min(1.0 - v), v],
        _ => [u, v],
    };
    const CORNERS: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let corner = |at: [f32; 2]| CORNERS.iter().position(|&c| c == at);
    let mut tip = corner([u, v]).filter(|_| whole);
    if let Some(c) = tip {
        let h = 3 * face + c as u32;
        if !root.features[root.whole.vertex(h) as usize] {
            // The fan's own rule holds, and gives the same tangents in all faces around, refined or not.
            if !is_regular(&root.topology.fans()[root.topology.fan(h) as usize]) {
                return None;
            }
            tip = None;
        }
    }
    let (mut view, mut depth, mut face) = (root, 0, face);
    let (mut at, mut scale) = ([u, v], 1.0);
    while let Some(first) = view.first_child(face) {
        // Below the last level there is nothing: darts end there.
        let Some(next) = below.at(depth + 1) else {
            break;
        };
        let [u, v] = at;
        let child = if u >= 0.5 {
            at = [2.0 * u - 1.0, 2.0 * v];
            1
        } else if v >= 0.5 {
            at = [2.0 * u, 2.0 * v - 1.0];
            2
        } else if u + v <= 0.5 {
            at = [2.0 * u, 2.0 * v];
            0
        } else {
            at = [1.0 - 2.0 * u, 1.0 - 2.0 * v];
            3
        };
        scale *= if child == 3 { -2.0 } else { 2.0 };
        face = first + child;
        (view, depth) = (next, depth + 1);
    }
    Some(Leaf {
        channel: view.channel(),
        depth,
        quad: face,
        at,
        scale,
        tip,
        value: corner(at).and_then(|c| view.tip(3 * face + c as u32)),
        open: view.first_child(face).is_some(),
    })
}
