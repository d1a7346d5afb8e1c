//! `--stats`: wall and processor time by stage, peak memory, and the JSON that carries them.

use std::fmt;
use std::time::Instant;

/// A JSON value with its members in the order in which they were given.
#[derive(Clone, Debug)]
pub(crate) enum Json {
    Null,
    Bool(bool),
    Whole(u64),
    /// Milliseconds and the like: three decimals.
    Number(f64),
    /// A coordinate: as many digits as it takes.
    Exact(f64),
    Text(String),
    List(Vec<Self>),
    Object(Vec<(String, Self)>),
}

impl Json {
    pub(crate) fn object<const N: usize>(members: [(&str, Self); N]) -> Self {
        Self::Object(members.map(|(k, v)| (k.to_owned(), v)).into())
    }
    pub(crate) fn text(s: impl Into<String>) -> Self {
        Self::Text(s.into())
    }
    pub(crate) fn count(n: usize) -> Self {
        Self::Whole(n as u64)
    }
}

fn quoted(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    match serde_json::to_string(text) {
        Ok(text) => f.write_str(&text),
        Err(_) => Err(fmt::Error),
    }
}

impl fmt::Display for Json {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(b) => write!(f, "{b}"),
            Self::Whole(n) => write!(f, "{n}"),
            // JSON knows no other numbers.
            Self::Number(x) | Self::Exact(x) if !x.is_finite() => f.write_str("null"),
            Self::Number(x) => write!(f, "{x:.3}"),
            Self::Exact(x) => write!(f, "{x}"),
            Self::Text(s) => quoted(f, s),
            Self::List(items) => {
                f.write_str("[")?;
                for (k, item) in items.iter().enumerate() {
                    f.write_str(if k > 0 { "," } else { "" })?;
                    item.fmt(f)?;
                }
                f.write_str("]")
            }
            Self::Object(members) => {
                f.write_str("{")?;
                for (k, (name, value)) in members.iter().enumerate() {
                    f.write_str(if k > 0 { "," } else { "" })?;
                    quoted(f, name)?;
                    f.write_str(":")?;
                    value.fmt(f)?;
                }
                f.write_str("}")
            }
        }
    }
}

/// Time of a stage, in milliseconds; processor time is summed over threads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Time {
    pub(crate) wall: f64,
    pub(crate) cpu: f64,
}

/// Both clocks at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    wall: Instant,
    cpu: f64,
}

impl Clock {
    pub(crate) fn now() -> Self {
        Self {
            wall: Instant::now(),
            cpu: process_cpu_ms(),
        }
    }
    pub(crate) fn elapsed(&self) -> Time {
        Time {
            wall: self.wall.elapsed().as_secs_f64() * 1e3,
            cpu: process_cpu_ms() - self.cpu,
        }
    }
}

/// Processor time of all threads since the process began, in milliseconds; 0 where the system does not say.
#[cfg(unix)]
pub(crate) fn process_cpu_ms() -> f64 {
    use rustix::time::{ClockId, clock_gettime};
    let t = clock_gettime(ClockId::ProcessCPUTime);
    t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 * 1e-6
}

/// Processor time is not asked for on this system.
#[cfg(not(unix))]
pub(crate) fn process_cpu_ms() -> f64 {
    0.0
}

/// Stages in the order in which they first ran.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stages(pub(crate) Vec<(&'static str, Time)>);

impl Stages {
    pub(crate) fn add(&mut self, name: &'static str, time: Time) {
        match self.0.iter_mut().find(|(n, _)| *n == name) {
            Some((_, t)) => {
                t.wall += time.wall;
                t.cpu += time.cpu;
            }
            None => self.0.push((name, time)),
        }
    }
    pub(crate) fn json(&self) -> Json {
        let members = self.0.iter().flat_map(|(name, t)| {
            [
                (format!("{name}_ms"), Json::Number(t.wall)),
                (format!("{name}_cpu_ms"), Json::Number(t.cpu)),
            ]
        });
        Json::Object(members.collect())
    }
}

/// Stages of a frame that took `cpu` milliseconds of processor time. Stages that run fused, tile by tile, share the wall time of the
/// tiles by what their threads spent in them. Processor time is shared by wall time: all stages use all threads, and clocks read within
/// a stage would count the time in which another process had the processor.
pub(crate) fn frame_stages(stats: &earmark::frame::FrameStats, cpu: f64) -> Stages {
    use earmark::frame::Stage;
    let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
    let fused = [
        Stage::Dice,
        Stage::Displace,
        Stage::Tile,
        Stage::Shade,
        Stage::Film,
    ];
    let sum: f64 = fused.iter().map(|&s| ms(stats.times.get(s))).sum();
    let mut walls = vec![
        (Stage::Flatness, ms(stats.flatness)),
        (Stage::Setup, ms(stats.wall[0])),
        (Stage::Bin, ms(stats.wall[1])),
    ];
    // Stages that most frames do not have.
    let rare = [
        (Stage::DepthTags, ms(stats.depth_tags)),
        (Stage::Patterns, ms(stats.patterns)),
    ];
    walls.extend(rare.into_iter().filter(|&(_, wall)| wall > 0.0));
    walls.extend(fused.map(|stage| {
        let share = ms(stats.times.get(stage)) / sum.max(1e-9);
        (stage, ms(stats.wall[2]) * share)
    }));
    // Where nothing is displaced the stage does not run.
    walls.retain(|&(stage, wall)| stage != Stage::Displace || wall > 0.0);
    let total: f64 = walls.iter().map(|(_, wall)| wall).sum();
    let mut stages = Stages::default();
    for (stage, wall) in walls {
        let cpu = cpu * wall / total.max(1e-9);
        stages.add(stage.name(), Time { wall, cpu });
    }
    stages
}

/// A line of `/proc/self/status` in bytes.
fn status_bytes(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix(key))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

/// Most memory that the process ever held.
pub(crate) fn peak_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// Address space that it has reserved.
pub(crate) fn reserved_bytes() -> u64 {
    status_bytes("VmSize:").unwrap_or(0)
}

/// Memory that it holds now.
pub(crate) fn held_bytes() -> u64 {
    status_bytes("VmRSS:").unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_json() {
        let json = Json::object([
            ("z", Json::text("a\"\u{1}\n")),
            ("a", Json::List(vec![Json::Whole(u64::MAX), Json::Null])),
            ("b", Json::Number(1.23456)),
            ("c", Json::Exact(0.1)),
            ("d", Json::Number(f64::NAN)),
            ("e", Json::Bool(true)),
        ]);
        let text = json.to_string();
        assert!(
            text.starts_with(r#"{"z":"a\"\u0001\n","a":[18446744073709551615,null],"b":1.235,"#)
        );
        let parsed: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(parsed["c"], 0.1);
        assert!(parsed["d"].is_null());
    }

    #[test]
    fn stages_add_up_in_order() {
        let mut stages = Stages::default();
        for (name, wall) in [("read", 1.0), ("connect", 2.0), ("read", 3.0)] {
            stages.add(name, Time { wall, cpu: 0.5 });
        }
        let want =
            r#"{"read_ms":4.000,"read_cpu_ms":1.000,"connect_ms":2.000,"connect_cpu_ms":0.500}"#;
        assert_eq!(stages.json().to_string(), want);
    }
}
