//! A mesh cut open into the sheets that interpolating schemes see: along boundaries, infinite creases, and seams of texture coordinates.
//!
//! Half-edges keep their numbers. What cutting takes away is noted per fan: whether the curve along the cut ends there.

use crate::refine::Level;
use crate::refine::interpolating::{Linear, Masks, Sheets};
use crate::refine::sharpness::Step;
use crate::topology::channel::number_edges;
use crate::topology::connect::rebuild_fans;
use crate::topology::{NONE, Topology};

/// A mesh cut open.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) topology: Topology,
    /// Fans where cuts do not run through.
    pub(super) ends: Vec<bool>,
    /// Whether cut edges are straight lines.
    pub(super) straight: bool,
}

impl Sheet {
    /// The sheets of the points of a level.
    pub(super) fn of_points(step: &Step<'_>, level: &Level<f64>) -> Self {
        let masks = Masks::default();
        let sheets = Sheets::<f64, f64, 3>::of_points(step, &masks, &level.points);
        Self::cut(&level.topology, &sheets, None)
    }

    /// The sheets of the texture coordinates of a level; vertices are values.
    pub(super) fn of_uvs(step: &Step<'_>, level: &Level<f64>) -> Option<Self> {
        let uvs = level.uvs.as_ref()?;
        let masks = Masks::default();
        let linear = uvs.linear_parts();
        let sheets = Sheets::<f64, f64, 2>::of_corners(
            step,
            &masks,
            &uvs.corners,
            &uvs.values,
            uvs.siblings(),
            linear,
        );
        let own = (uvs.corners.as_slice(), uvs.values.len());
        let mut sheet = Self::cut(&level.topology, &sheets, Some(own));
        sheet.straight = linear != Linear::Never;
        Some(sheet)
    }

    fn cut<const N: usize>(
        t: &Topology,
        sheets: &Sheets<'_, f64, f64, N>,
        values: Option<(&[u32], usize)>,
    ) -> Self {
        let mut topology = t.clone();
        if let Some((corners, count)) = values {
            topology.corner_vertices.copy_from_slice(corners);
            topology.vertex_count = count;
        }
        topology.edge_sharpness.clear();
        topology.vertex_sharpness.clear();
        for h in 0..t.half_count() as u32 {
            topology.twins[h as usize] = sheets.twin(h);
        }
        number_edges(&mut topology);
        rebuild_fans(&mut topology);
        let ends = (topology.fans())
            .iter()
            .map(|fan| fan.first != NONE && !fan.closed && !sheets.runs_through(fan.first))
            .collect();
        Self {
            topology,
            ends,
            straight: false,
        }
    }
}
