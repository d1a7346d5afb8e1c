//! What the machine has for the process: threads and memory.

use super::exit::{Code, Failure};
use super::messages::warning;
use std::path::{Path, PathBuf};

/// Threads beyond this many per processor only take memory.
const MOST_THREADS_PER_CORE: usize = 4;
/// As many are always allowed, so that a result can be compared over thread counts anywhere.
const ALWAYS_ALLOWED: usize = 64;

/// A pool of so many threads.
pub(crate) fn pool_of(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| {
            let message = format!("earmark: cannot start {threads} threads: {e}");
            Failure::new(Code::Limit, message)
        })
}

/// How many threads: the flag (or its variable), rayon's variable, the processors.
pub(super) fn threads(wanted: Option<u32>) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let from_rayon = || {
        let n: usize = std::env::var("RAYON_NUM_THREADS").ok()?.parse().ok()?;
        (n > 0).then_some(n)
    };
    let wanted = match wanted {
        Some(n) => n as usize,
        None => from_rayon().unwrap_or(cores),
    };
    let most = (cores * MOST_THREADS_PER_CORE).max(ALWAYS_ALLOWED);
    if wanted > most {
        warning(&format!(
            "{wanted} threads are more than help here; {most} are used"
        ));
    }
    wanted.min(most)
}

/// Three quarters of what the process may have: its control group's limit, physical memory.
pub(super) fn default_memory() -> Option<u64> {
    let physical = || {
        let info = std::fs::read_to_string("/proc/meminfo").ok()?;
        let line = info.lines().find_map(|l| l.strip_prefix("MemTotal:"))?;
        let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
        Some(kilobytes << 10)
    };
    let least = [physical(), group_limit()].into_iter().flatten().min()?;
    Some(least / 4 * 3)
}

#[cfg(unix)]
pub(super) fn address_space() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

#[cfg(not(unix))]
pub(super) fn address_space() -> Option<u64> {
    None
}

/// The smallest memory limit among the process' control group and those around it, of both versions.
fn group_limit() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let mut least = None;
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else {
            continue;
        };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        // In a container the path may be that of the host; the mount's root is the group then.
        let mut folder = PathBuf::from(root).join(path.trim_start_matches('/'));
        loop {
            let limit = std::fs::read_to_string(folder.join(file)).ok();
            if let Some(n) = limit.and_then(|s| s.trim().parse::<u64>().ok()) {
                least = Some(least.map_or(n, |l: u64| l.min(n)));
            }
            if folder == Path::new(root) || !folder.pop() {
                break;
            }
        }
    }
    least
}
