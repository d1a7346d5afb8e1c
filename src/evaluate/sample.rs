//! What an evaluation gives, in three sizes.

use super::locate::Local;
use super::patches::{GridRow, Patches};
use crate::dice::evaluate::{Jet, Place as Found};
use crate::math;

/// The limit surface at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Limit point.
    pub position: [f32; 3],
    /// First derivative by u.
    pub du: [f32; 3],
    /// First derivative by v.
    pub dv: [f32; 3],
    /// Unit normal, `du` × `dv`; where the surface has none, a defined unit vector.
    pub normal: [f32; 3],
    /// Second derivatives; `None` at vertices where there are none.
    pub second: Option<SecondDerivatives>,
}

/// Second derivatives of the limit surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SecondDerivatives {
    /// Twice by u.
    pub duu: [f32; 3],
    /// By u and v.
    pub duv: [f32; 3],
    /// Twice by v.
    pub dvv: [f32; 3],
}

/// Position and first derivatives: less to compute than a [`Sample`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangents {
    /// Limit point.
    pub position: [f32; 3],
    /// First derivative by u.
    pub du: [f32; 3],
    /// First derivative by v.
    pub dv: [f32; 3],
}

/// What [`Surface::evaluate_as`](crate::Surface::evaluate_as) and its like give: a [`Sample`], [`Tangents`], or a position alone
/// (`[f32; 3]`). Not for other types.
pub trait Evaluated: sealed::Kind + Copy + Default + Send {}
impl Evaluated for Sample {}
impl Evaluated for Tangents {}
impl Evaluated for [f32; 3] {}

pub(super) mod sealed {
    use super::super::locate::{Local, Tip};
    use super::super::patches::Patches;

    /// A place in a face that is ready.
    pub struct Asked<'a, 'c, P: Patches> {
        pub(in super::super) patches: &'a mut P,
        pub(in super::super) channel: P::Channel<'c>,
        pub(in super::super) at: Local,
        pub(in super::super) tip: Option<Tip>,
    }

    /// How a kind of sample is made.
    pub trait Kind: Sized {
        /// Whether it holds derivatives.
        const DERIVATIVES: bool = true;
        /// What it holds of a sample.
        fn of_sample(sample: super::Sample) -> Self;
        fn evaluate<P: Patches>(asked: Asked<'_, '_, P>) -> Self;
        /// The same without preparing the face, where there is such a way.
        fn at_once<P: Patches>(channel: P::Channel<'_>, at: Local) -> Option<Self>;
        /// The grid of `n` segments of the face; the place of `asked` says which face alone.
        fn grid<P: Patches>(asked: Asked<'_, '_, P>, n: u32, out: &mut [Self]);
    }
}

use sealed::Asked;

impl<P: Patches> Asked<'_, '_, P> {
    #[inline(always)]
    fn jet<const ORDER: u32>(self) -> Jet {
        let found = self.patches.at::<ORDER>(self.channel, self.at.u, self.at.v);
        self.at.outer::<ORDER>(jet(found))
    }
}

impl sealed::Kind for [f32; 3] {
    const DERIVATIVES: bool = false;
    fn of_sample(sample: Sample) -> Self {
        sample.position
    }
    #[inline(always)]
    fn evaluate<P: Patches>(asked: Asked<'_, '_, P>) -> Self {
        match asked.tip {
            Some(tip) => tip.position,
            None => asked.jet::<0>().position.xyz(),
        }
    }
    #[inline(always)]
    fn at_once<P: Patches>(channel: P::Channel<'_>, at: Local) -> Option<Self> {
        let jet = P::at_once::<0>(channel, at)?;
        Some(jet.position.xyz())
    }
    fn grid<P: Patches>(asked: Asked<'_, '_, P>, n: u32, out: &mut [Self]) {
        (asked.patches).rows::<0, _>(asked.channel, n, out, |row, out| {
            row.tangents(out, |[position, ..]| position);
        });
    }
}

impl sealed::Kind for Tangents {
    fn of_sample(sample: Sample) -> Self {
        Self {
            position: sample.position,
            du: sample.du,
            dv: sample.dv,
        }
    }
    #[inline(always)]
    fn evaluate<P: Patches>(asked: Asked<'_, '_, P>) -> Self {
        let tip = asked.tip;
        let mut out = Self::of(asked.jet::<1>());
        if let Some(tip) = tip {
            out.position = tip.position;
        }
        out
    }
    #[inline(always)]
    fn at_once<P: Patches>(channel: P::Channel<'_>, at: Local) -> Option<Self> {
        let jet = P::at_once::<1>(channel, at)?;
        Some(Self::of(at.outer::<1>(jet)))
    }
    fn grid<P: Patches>(asked: Asked<'_, '_, P>, n: u32, out: &mut [Self]) {
        (asked.patches).rows::<1, _>(asked.channel, n, out, |row, out| {
            row.tangents(out, |[position, du, dv]| Self { position, du, dv });
        });
    }
}

impl sealed::Kind for Sample {
    fn of_sample(sample: Sample) -> Self {
        sample
    }
    #[inline(always)]
    fn evaluate<P: Patches>(asked: Asked<'_, '_, P>) -> Self {
        let Asked {
            patches,
            channel,
            at,
            tip,
        } = asked;
        let found = patches.at::<2>(channel, at.u, at.v);
        let mut out = Self::of(patches, channel, &at, found);
        if let Some(tip) = tip {
            out.position = tip.position;
            out.normal = math::normalize(tip.normal).unwrap_or(out.normal);
            out.second = None;
        }
        out
    }
    #[inline(always)]
    fn at_once<P: Patches>(channel: P::Channel<'_>, at: Local) -> Option<Self> {
        let jet = P::at_once::<2>(channel, at)?;
        let sample = Self::quick(Found::Smooth(at.outer::<2>(jet)));
        (sample.normal != [0.0; 3]).then_some(sample)
    }
    fn grid<P: Patches>(asked: Asked<'_, '_, P>, n: u32, out: &mut [Self]) {
        let Asked {
            patches,
            channel,
            at,
            ..
        } = asked;
        patches.rows::<2, _>(channel, n, out, |row, out| {
            for (i, out) in out.iter_mut().enumerate() {
                let jet = row.jet(i);
                *out = Self::quick(match row.corner(i) {
                    None => Found::Smooth(jet),
                    Some(c) => Found::Corner(jet, c),
                });
            }
        });
        // Places without a clear normal are evaluated once more, with all that can be done.
        for (out, [u, v]) in out.iter_mut().zip(P::grid_places(n)) {
            if out.normal == [0.0; 3] {
                let at = Local::whole(at.face, u, v);
                let found = patches.at::<2>(channel, u, v);
                *out = Self::of(patches, channel, &at, found);
            }
        }
    }
}

#[inline(always)]
fn jet(found: Found) -> Jet {
    let (Found::Smooth(jet) | Found::Corner(jet, _)) = found;
    jet
}

impl Tangents {
    #[inline(always)]
    fn of(jet: Jet) -> Self {
        Self {
            position: jet.position.xyz(),
            du: jet.du.xyz(),
            dv: jet.dv.xyz(),
        }
    }
}

impl Sample {
    #[inline(always)]
    fn new(jet: Jet, normal: [f32; 3], smooth: bool) -> Self {
        Self {
            position: jet.position.xyz(),
            du: jet.du.xyz(),
            dv: jet.dv.xyz(),
            normal,
            second: smooth.then(|| SecondDerivatives {
                duu: jet.duu.xyz(),
                duv: jet.duv.xyz(),
                dvv: jet.dvv.xyz(),
            }),
        }
    }

    /// With a normal of zeros where it takes more to find one.
    #[inline(always)]
    fn quick(found: Found) -> Self {
        match found {
            Found::Smooth(jet) => Self::new(jet, normal(&jet).unwrap_or([0.0; 3]), true),
            Found::Corner(jet, _) => Self::new(jet, [0.0; 3], false),
        }
    }

    #[inline(always)]
    fn of<P: Patches>(patches: &mut P, channel: P::Channel<'_>, at: &Local, found: Found) -> Self {
        let mut sample = Self::quick(match found {
            Found::Smooth(jet) => Found::Smooth(at.outer::<2>(jet)),
            Found::Corner(jet, c) => Found::Corner(at.outer::<2>(jet), c),
        });
        if sample.normal == [0.0; 3] {
            let corner = match found {
                Found::Corner(_, c) => Some(c),
                Found::Smooth(_) => None,
            };
            sample.normal = spare_normal(patches, channel, at, corner);
        }
        sample
    }
}

/// Unit vector along du × dv, unless the two are parallel as far as can be told.
#[inline(always)]
fn normal(jet: &Jet) -> Option<[f32; 3]> {
    /// Squared sine below which directions are rounding.
    const PARALLEL: f32 = 1e-10;
    let (du, dv) = (jet.du.xyz(), jet.dv.xyz());
    let cross = math::cross(du, dv);
    let (square, size) = (
        math::dot(cross, cross),
        math::dot(du, du) * math::dot(dv, dv),
    );
    if size > 1e-20 && size < 1e30 {
        if square <= PARALLEL * size {
            return None;
        }
        return Some(math::scale(cross, 1.0 / square.sqrt()));
    }
    // Squares of tiny or huge vectors leave the range of numbers: scale them first.
    let unit = |v: [f32; 3]| {
        let most = v[0].abs().max(v[1].abs()).max(v[2].abs());
        (most > 0.0 && most.is_finite()).then_some(())?;
        math::normalize(v.map(|c| c / most))
    };
    let cross = math::cross(unit(du)?, unit(dv)?);
    if math::dot(cross, cross) > PARALLEL {
        math::normalize(cross)
    } else {
        None
    }
}

/// The normal where the derivatives have none: of the corner if it is one, else of a place closer to the middle of the face, else of the
/// nearest corner.
#[cold]
fn spare_normal<P: Patches>(
    patches: &mut P,
    channel: P::Channel<'_>,
    at: &Local,
    corner: Option<usize>,
) -> [f32; 3] {
    let nearest = corner.unwrap_or_else(|| P::nearest_corner(at.u, at.v));
    if corner.is_none() {
        for step in [1e-3, 1e-2, 0.1, 0.5] {
            let [u, v] = [at.u, at.v].map(|x| x + (P::MIDDLE - x) * step);
            if let Found::Smooth(jet) = patches.at::<1>(channel, u, v)
                && let Some(normal) = normal(&jet)
            {
                return normal;
            }
        }
    }
    let (_, normal) = P::corner(channel, at.face, nearest);
    math::normalize(normal).unwrap_or([0.0, 0.0, 1.0])
}
