//! `earmark bench calibrate`: how fast this machine is beside the one that figures are quoted for, from two fixed pieces of work on one
//! thread: 10^9 multiplications with as many additions, not fused, and a copy of 256 MB.

use super::{Arguments, Outcome, push};
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Json};
use earmark::dispatch;
use earmark::simd::LANES;
use std::hint::black_box;

/// Milliseconds of both on one core of the machine class that figures are quoted for (AMD Zen 4 at 3.2 to 3.7 GHz).
const REFERENCE: [f64; 2] = [17.0, 22.0];

/// Multiplications; as many additions follow them.
const OPERATIONS: u64 = 1_000_000_000;

/// Bytes that are copied.
const COPIED: usize = 256 << 20;

/// Numbers worked on side by side: enough to hide how long one operation takes.
const NUMBERS: usize = 8 * LANES;

#[inline(always)]
fn multiply_add(start: f32) -> f32 {
    let mut x: [f32; NUMBERS] = std::array::from_fn(|k| start + k as f32);
    for _ in 0..OPERATIONS / NUMBERS as u64 {
        let mut next = [0.0; NUMBERS];
        for (n, v) in next.iter_mut().zip(&x) {
            *n = v * 0.999_999 + 0.25;
        }
        x = next;
    }
    x.iter().sum()
}

/// Times of both, and how many times the reference's they are: the geometric mean of the two.
pub(super) fn calibrate(job: &Job, a: &Arguments) -> Result<Outcome, Failure> {
    let limits = job.limits();
    limits.memory("the copy", 2 * COPIED as u128)?;
    let from = vec![1_u8; COPIED];
    let mut to = vec![0_u8; COPIED];
    let items = |stage: &str| match stage {
        "mul_add" => 2 * OPERATIONS,
        "copy" => COPIED as u64,
        _ => 1,
    };
    let mut rows = Vec::new();
    let mut best = [f64::INFINITY; 2];
    for _ in 0..a.repeat {
        limits.check()?;
        let whole = Clock::now();
        let clock = Clock::now();
        black_box(dispatch!(job.simd, multiply_add(black_box(0.5))));
        let arithmetic = clock.elapsed();
        let clock = Clock::now();
        to.copy_from_slice(black_box(&from));
        black_box(&mut to);
        let copy = clock.elapsed();
        push(&mut rows, "total", whole.elapsed(), &items);
        push(&mut rows, "mul_add", arithmetic, &items);
        push(&mut rows, "copy", copy, &items);
        best = [best[0].min(arithmetic.wall), best[1].min(copy.wall)];
    }
    let factor = ((best[0] / REFERENCE[0]) * (best[1] / REFERENCE[1])).sqrt();
    Ok(Outcome {
        rows,
        members: vec![("factor".to_owned(), Json::Number(factor))],
        lines: format!(
            "factor {factor:.3}: divide milliseconds by it to compare them with those of other machines\n"
        ),
        ..Outcome::default()
    })
}
