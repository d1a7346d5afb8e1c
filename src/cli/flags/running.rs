//! How a run goes: threads, instructions, limits, reports, messages.

use super::values::{bytes, seconds};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// `auto`, `always` or `never`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum When {
    Auto,
    Always,
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Simd {
    Auto,
    Scalar,
    Sse2,
    Avx2,
    Avx512,
    Neon,
}

impl Simd {
    pub(crate) fn name(self) -> String {
        self.to_possible_value()
            .map(|v| v.get_name().to_owned())
            .unwrap_or_default()
    }
}

/// Threads, limits, and what is said.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Running")]
pub(crate) struct RunningFlags {
    /// Threads [default: RAYON_NUM_THREADS, else one per processor that the process may use]
    #[arg(short = 'j', long, value_name = "N", env = "EARMARK_THREADS", hide_env_values = true,
          value_parser = clap::value_parser!(u32).range(1..), allow_hyphen_values = true)]
    pub(crate) threads: Option<u32>,
    /// Vector instructions; never changes a pixel
    #[arg(
        long,
        value_enum,
        default_value = "auto",
        env = "EARMARK_SIMD",
        hide_env_values = true
    )]
    pub(crate) simd: Simd,
    /// Give up after so many seconds [default: never]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true)]
    pub(crate) timeout: Option<Duration>,
    /// Most memory to take: bytes, or with K, M, G or T [default: 75 % of what the process may have]
    #[arg(long, value_name = "SIZE", value_parser = bytes, allow_hyphen_values = true)]
    pub(crate) max_memory: Option<u64>,
    /// Most micro-faces [default: no limit; refine: 100 million]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(crate) max_faces: Option<u64>,
    /// Write what was done and how long it took as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Say what is being done
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Progress on standard error; auto: on a terminal, after a second
    #[arg(long, value_enum, value_name = "WHEN", default_value = "auto")]
    pub(crate) progress: When,
    /// Colours in messages; auto: on a terminal, unless NO_COLOR is set
    #[arg(long, value_enum, value_name = "WHEN", default_value = "auto")]
    pub(crate) color: When,
}

impl Default for RunningFlags {
    /// What verbs that only print a text run with.
    fn default() -> Self {
        Self {
            threads: Some(1),
            simd: Simd::Auto,
            timeout: None,
            max_memory: None,
            max_faces: None,
            stats: None,
            quiet: false,
            verbose: 0,
            progress: When::Never,
            color: When::Auto,
        }
    }
}
