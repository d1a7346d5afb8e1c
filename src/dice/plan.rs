//! Where everything goes of which a whole face is diced in one block: it depends on the level and on which corners are irregular, and on
//! no point. So it is found out once for each of these cases, by the code that dices parts, and kept.

use super::basis::{Basis, Target};
use super::edge::Run;
use super::regular::{Area, BlockRange, Lines, areas};
use super::sheet::{Rows, Sheet, rows};
use crate::records::Grid3;
use std::sync::OnceLock;

/// Deepest level at which a face is one block.
const DEEPEST: usize = 5;

/// What a face's plan depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    /// At least 1.
    pub(super) level: u32,
    /// Which corners are regular, bit by bit.
    pub(super) regular: u8,
    /// Whether the sides are left to their own rule.
    pub(super) sides: bool,
}

/// The splines and strips that a face shows.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// In the order in which they are diced.
    areas: Vec<PlannedArea>,
    pub(super) strips: Vec<PlannedStrip>,
}

/// A quadrant of a sheet, and what of the block it shows.
#[derive(Clone, Debug)]
struct PlannedArea {
    sheet: usize,
    /// Place in the sheet's net.
    at: [usize; 2],
    level: u32,
    area: Area,
}

/// A strip along side `side` of a face, from a place of a sheet's net, or of the whole face's.
#[derive(Clone, Debug)]
pub(super) struct PlannedStrip {
    pub(super) side: usize,
    pub(super) sheet: Option<usize>,
    pub(super) at: [usize; 2],
    pub(super) level: u32,
    pub(super) run: Run,
}

impl Plan {
    /// The plan of a case, if that has one. `make` says what a face of the case is made of.
    #[inline(always)]
    pub(super) fn get(case: Case, make: impl FnOnce() -> Self) -> Option<&'static Self> {
        static PLANS: [[[OnceLock<Plan>; 16]; 2]; DEEPEST + 1] =
            [const { [const { [const { OnceLock::new() }; 16] }; 2] }; DEEPEST + 1];
        let plans = PLANS.get(case.level as usize)?;
        let plan = &plans[usize::from(case.sides)][usize::from(case.regular & 15)];
        Some(match plan.get() {
            Some(plan) => plan,
            None => plan.get_or_init(make),
        })
    }

    pub(super) fn new(sheets: &[Sheet], range: BlockRange, strips: Vec<PlannedStrip>) -> Self {
        let areas = areas(sheets, range)
            .map(|(sheet, quadrant, area)| PlannedArea {
                sheet,
                at: quadrant.at,
                level: quadrant.sheet.level,
                area,
            })
            .collect();
        Self { areas, strips }
    }

    /// As [`dice_sheets`](super::regular::dice_sheets) over the whole block.
    #[inline(always)]
    pub(super) fn dice(
        &self,
        sheets: &[Sheet],
        target: Target,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let mut lines = Lines::default();
        for planned in &self.areas {
            let net: Rows<'_> = rows(&sheets[planned.sheet].net, planned.at);
            let basis = Basis::get(target, planned.level);
            let normals = normals.as_deref_mut();
            planned.area.dice(&net, basis, &mut lines, points, normals);
        }
    }
}
