//! Levels of vector instructions and the way a kernel is compiled for each: the only file that knows widths and features.
//!
//! A kernel is one text: an `#[inline(always)]` function of plain loops over lane arrays, which the compiler vectorises.
//! [`dispatch!`](crate::dispatch) compiles it once per level, inside a function with that level's instructions enabled, and calls
//! the one chosen at run time. The compiler never fuses a multiplication with an addition on its own, and a loop over lanes never sums across them, so every level
//! gives the same bits.
//!
//! What vectorises well: loops whose trip count is not a small constant, over slices cut to equal length beforehand
//! (`let x = &x[..n];`), with `if`-expressions that select values in place of branches that skip work.
//!
//! ```
//! use earmark::simd::Level;
//!
//! #[inline(always)]
//! fn halve(x: &mut [f32]) {
//!     for v in x {
//!         *v *= 0.5;
//!     }
//! }
//!
//! let mut x = [3.0; 40];
//! earmark::dispatch!(Level::detect(), halve(&mut x));
//! assert_eq!(x, [1.5; 40]);
//! ```

use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::OnceLock;

/// Most lanes of any level: kernels pad their loops to multiples of it.
pub const LANES: usize = 16;

/// A number per lane, aligned so that no vector crosses a cache line: where it does, reading what was just written has to wait.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lanes<T>(pub [T; LANES]);

impl<T> Deref for Lanes<T> {
    type Target = [T; LANES];

    #[inline(always)]
    fn deref(&self) -> &[T; LANES] {
        &self.0
    }
}

impl<T> DerefMut for Lanes<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T; LANES] {
        &mut self.0
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    not(any(target_arch = "x86_64", target_arch = "aarch64")),
    expect(dead_code, reason = "such machines have the scalar level only")
)]
enum Kind {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Sse2,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

/// A set of vector instructions that this machine has. Values come from [`Level::detect`], [`Level::available`] and
/// [`Level::from_name`] only, so holding one proves that its instructions can be executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Level(Kind);

/// A level that is unknown or that this machine lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelError {
    name: String,
}

impl fmt::Display for LevelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no SIMD level {:?} on this machine; it has:", self.name)?;
        for level in Level::available() {
            write!(f, " {}", level.name())?;
        }
        Ok(())
    }
}

impl std::error::Error for LevelError {}

impl Level {
    /// The level without instructions beyond those that the target always has.
    pub const SCALAR: Self = Self(Kind::Scalar);

    /// The levels of this machine, weakest first; never empty.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut levels = vec![Self::SCALAR];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("sse2") {
                levels.push(Self(Kind::Sse2));
            }
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            if avx2 {
                levels.push(Self(Kind::Avx2));
            }
            if avx2
                && is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
            {
                levels.push(Self(Kind::Avx512));
            }
        }
        #[cfg(target_arch = "aarch64")]
        if std::arch::is_aarch64_feature_detected!("neon") {
            levels.push(Self(Kind::Neon));
        }
        levels
    }

    /// The strongest level of this machine.
    #[must_use]
    pub fn detect() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| Self::available().last().copied().unwrap_or(Self::SCALAR))
    }

    /// The level called `name`: `auto` (the strongest), `scalar`, `sse2`, `avx2`, `avx512` or `neon`.
    ///
    /// # Errors
    /// The name is unknown, or this machine lacks the level.
    pub fn from_name(name: &str) -> Result<Self, LevelError> {
        if name == "auto" {
            return Ok(Self::detect());
        }
        Self::available()
            .into_iter()
            .find(|level| level.name() == name)
            .ok_or_else(|| LevelError { name: name.into() })
    }

    /// The name that [`Level::from_name`] takes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Kind::Sse2 => "sse2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
        }
    }

    /// Calls `f` inside a function that has this level's instructions enabled. `f` must be `#[inline(always)]`, or it is
    /// compiled without them (correct, but slow): use [`dispatch!`](crate::dispatch), which sees to it.
    #[inline]
    #[expect(
        unsafe_code,
        reason = "entering a function with more instructions enabled than its caller"
    )]
    pub fn run<R>(self, f: impl FnOnce() -> R) -> R {
        match self.0 {
            #[cfg(not(target_arch = "x86_64"))]
            Kind::Scalar => f(),
            // Every x86-64 has SSE2 and the plain code uses it: one code for both levels.
            #[cfg(target_arch = "x86_64")]
            Kind::Scalar | Kind::Sse2 => f(),
            // SAFETY: a `Level` of this kind is only made by `available`, after asking the processor for these features.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => unsafe { avx2(f) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => unsafe { avx512(f) },
            // SAFETY: as above.
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => unsafe { neon(f) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx2<R>(f: impl FnOnce() -> R) -> R {
    f()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
fn avx512<R>(f: impl FnOnce() -> R) -> R {
    f()
}

#[cfg(target_arch = "aarch64")]
#[target_feature(enable = "neon")]
fn neon<R>(f: impl FnOnce() -> R) -> R {
    f()
}

/// One bit per lane, that of lane 0 lowest: set where `lanes` holds -1, clear where it holds 0. Loops over lanes write the bytes;
/// every level then has one instruction or a few for what a loop of shifts takes dozens for.
#[must_use]
#[inline(always)]
#[cfg_attr(
    target_arch = "x86_64",
    expect(
        unsafe_code,
        reason = "the baseline has the instruction, but only as an intrinsic"
    )
)]
pub fn bits(lanes: &[i8; LANES]) -> u32 {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_mm_loadu_si128, _mm_movemask_epi8};
        const { assert!(LANES == 16) }
        // SAFETY: every x86-64 has SSE2; the load is unaligned and of the array's 16 bytes.
        unsafe { _mm_movemask_epi8(_mm_loadu_si128(lanes.as_ptr().cast())) as u32 }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let bit = |l: usize| u32::from(lanes[l] < 0) << l;
        (0..LANES).fold(0, |all, l| all | bit(l))
    }
}

/// [`bits`] of flags in words: for conditions on floats, which the compiler would narrow lane by lane.
#[must_use]
#[inline(always)]
#[cfg_attr(
    target_arch = "x86_64",
    expect(
        unsafe_code,
        reason = "the baseline has the instructions, but only as intrinsics"
    )
)]
pub fn word_bits(lanes: &[i32; LANES]) -> u32 {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{
            _mm_loadu_si128, _mm_movemask_epi8, _mm_packs_epi16, _mm_packs_epi32,
        };
        // SAFETY: every x86-64 has SSE2; the loads are unaligned and of the array's four quarters.
        unsafe {
            let quarter = |k: usize| _mm_loadu_si128(lanes.as_ptr().add(4 * k).cast());
            let low = _mm_packs_epi32(quarter(0), quarter(1));
            let high = _mm_packs_epi32(quarter(2), quarter(3));
            _mm_movemask_epi8(_mm_packs_epi16(low, high)) as u32
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    bits(&lanes.map(|lane| lane as i8))
}

/// The words at sixteen places of a table, its length a power of two and places taken modulo that: lower halves, and upper halves.
///
/// Instructions that fetch in lanes take longer for it than one load per lane, and a loop would become them.
#[inline(always)]
#[cfg_attr(
    target_arch = "x86_64",
    expect(
        unsafe_code,
        reason = "the baseline has the instructions, but only as intrinsics"
    )
)]
pub fn fetch_pairs<const N: usize>(
    table: &[u64; N],
    at: &[u32; LANES],
    out: &mut [[u32; LANES]; 2],
) {
    const { assert!(N.is_power_of_two()) }
    let word = |l: usize| table[at[l] as usize & (N - 1)];
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{
            _mm_castps_si128, _mm_castsi128_ps, _mm_set_epi64x, _mm_shuffle_ps, _mm_storeu_si128,
        };
        let [low, high] = out;
        let parts = low.as_chunks_mut::<4>().0.iter_mut();
        for (q, (low, high)) in parts.zip(high.as_chunks_mut::<4>().0).enumerate() {
            // SAFETY: every x86-64 has SSE2; the stores are unaligned and of the arrays' 16 bytes.
            unsafe {
                let two = |l: usize| _mm_set_epi64x(word(l + 1) as i64, word(l) as i64);
                let a = _mm_castsi128_ps(two(4 * q));
                let b = _mm_castsi128_ps(two(4 * q + 2));
                let lower = _mm_castps_si128(_mm_shuffle_ps::<0b10_00_10_00>(a, b));
                let upper = _mm_castps_si128(_mm_shuffle_ps::<0b11_01_11_01>(a, b));
                _mm_storeu_si128(low.as_mut_ptr().cast(), lower);
                _mm_storeu_si128(high.as_mut_ptr().cast(), upper);
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    for l in 0..LANES {
        (out[0][l], out[1][l]) = (word(l) as u32, (word(l) >> 32) as u32);
    }
}

/// -1 or 0, as [`bits`] takes them.
#[must_use]
#[inline(always)]
pub fn flag(is: bool) -> i8 {
    -i8::from(is)
}

/// `dispatch!(level, kernel(a, b))`: evaluates the call with the instructions of `level` enabled. `kernel` must be an
/// `#[inline(always)]` function: its whole body, and what it inlines, is then compiled once per level.
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $call:expr) => {
        $crate::simd::Level::run(
            $level,
            #[inline(always)]
            || $call,
        )
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        let levels = Level::available();
        assert_eq!(levels[0], Level::SCALAR);
        for &level in &levels {
            assert_eq!(Level::from_name(level.name()), Ok(level));
        }
        assert_eq!(Level::from_name("auto"), Ok(Level::detect()));
        let error = Level::from_name("avx1024").unwrap_err().to_string();
        assert!(error.contains("avx1024") && error.contains("scalar"));
    }

    #[inline(always)]
    fn horner(x: &[f32], out: &mut [f32]) {
        for (o, &v) in out.iter_mut().zip(x) {
            *o = ((v * 0.1 + 0.7) * v + 0.3) / (v + 1.5);
        }
    }

    #[test]
    fn bits_stand_in_the_order_of_lanes() {
        for pattern in [0, 1, 0x8000, 0x1234, 0xffff, 0x5555] {
            let lanes: [i8; LANES] = std::array::from_fn(|l| flag(pattern >> l & 1 != 0));
            assert_eq!(bits(&lanes), pattern);
            assert_eq!(word_bits(&lanes.map(i32::from)), pattern);
        }
    }

    #[test]
    fn pairs_come_from_their_places() {
        let table: [u64; 64] = std::array::from_fn(|k| (k as u64) << 33 | k as u64);
        let at: [u32; LANES] = std::array::from_fn(|l| (l * l) as u32);
        for level in Level::available() {
            let mut out = [[0; LANES]; 2];
            crate::dispatch!(level, fetch_pairs(&table, &at, &mut out));
            assert_eq!(out[0], at.map(|k| k & 63));
            assert_eq!(out[1], at.map(|k| (k & 63) * 2));
        }
    }

    #[test]
    fn levels_agree() {
        let x: Vec<f32> = (0..1000).map(|i| i as f32 * 0.37).collect();
        let mut want = vec![0.0; x.len()];
        horner(&x, &mut want);
        for level in Level::available() {
            let mut got = vec![0.0; x.len()];
            crate::dispatch!(level, horner(&x, &mut got));
            assert_eq!(got, want, "{}", level.name());
        }
    }
}
