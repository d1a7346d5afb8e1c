//! What a suite found as a table, and as one object of JSON.

use super::{Arguments, Outcome, Row, summary};
use crate::cli::job::Job;
use crate::cli::stats::{Json, Stages, Time};
use std::fmt::Write;

impl Row {
    fn ns_per_item(&self) -> f64 {
        let [wall, _] = summary(&self.times, |t| t.wall);
        if self.items == 0 {
            0.0
        } else {
            wall * 1e6 / self.items as f64
        }
    }
}

pub(super) fn report(job: &Job, a: &Arguments, model: Json, outcome: &Outcome) -> Json {
    let mut stages = Stages::default();
    for row in outcome.rows.iter().filter(|r| r.stage != "total") {
        let [wall, cpu] = [
            summary(&row.times, |t| t.wall)[0],
            summary(&row.times, |t| t.cpu)[0],
        ];
        stages.add(row.stage, Time { wall, cpu });
    }
    let middle = vec![
        ("faces", Json::Whole(outcome.faces)),
        ("microtriangles", Json::Whole(outcome.microtriangles)),
        ("pixels_covered", Json::Whole(outcome.pixels)),
    ];
    let mut members = job.report(model, middle);
    for (name, value) in &mut members {
        match (name.as_str(), outcome.peak_bytes) {
            ("stages", _) => *value = stages.json(),
            ("peak_bytes", Some(bytes)) => *value = Json::Whole(bytes),
            _ => {}
        }
    }
    let rows = outcome.rows.iter().map(|row| {
        let [wall, cpu] = [
            summary(&row.times, |t| t.wall),
            summary(&row.times, |t| t.cpu),
        ];
        Json::object([
            ("stage", Json::text(row.stage)),
            ("wall_ms_min", Json::Number(wall[0])),
            ("wall_ms_median", Json::Number(wall[1])),
            ("cpu_ms_min", Json::Number(cpu[0])),
            ("cpu_ms_median", Json::Number(cpu[1])),
            ("items", Json::Whole(row.items)),
            ("ns_per_item_min", Json::Number(row.ns_per_item())),
        ])
    });
    let rows = rows
        .zip(&outcome.rows)
        .map(|(json, row)| match (json, row.published) {
            (Json::Object(mut members), Some(p)) => {
                let [wall, _] = summary(&row.times, |t| t.wall);
                members.extend([
                    ("coarse_faces".to_owned(), Json::Whole(p.coarse)),
                    ("published_ms".to_owned(), Json::Number(p.milliseconds)),
                    (
                        "times_published".to_owned(),
                        Json::Exact(wall / p.milliseconds),
                    ),
                ]);
                Json::Object(members)
            }
            (json, _) => json,
        });
    members.push(("repeat".to_owned(), Json::Whole(u64::from(a.repeat))));
    members.push(("rows".to_owned(), Json::List(rows.collect())));
    members.extend(outcome.members.iter().cloned());
    Json::Object(members)
}

pub(super) fn table(job: &Job, a: &Arguments, outcome: &Outcome) -> String {
    let longest = outcome.rows.iter().map(|r| r.stage.len()).max();
    let width = longest.unwrap_or(0).max(8);
    let named = outcome.rows.iter().any(|r| r.published.is_some());
    let mut out = format!(
        "{} faces, {} micro-triangles, {} threads, {}, best and median of {}\n{:<width$}{:>12}{:>12}{:>12}{:>12}{:>12}{:>10}{}\n",
        outcome.faces,
        outcome.microtriangles,
        job.threads,
        job.simd.name(),
        a.repeat,
        "stage",
        "wall ms",
        "median",
        "cpu ms",
        "median",
        "items",
        "ns/item",
        if named {
            "   faces published ms  times"
        } else {
            ""
        },
    );
    for row in &outcome.rows {
        let [wall, cpu] = [
            summary(&row.times, |t| t.wall),
            summary(&row.times, |t| t.cpu),
        ];
        let published = row.published.map_or_else(String::new, |p| {
            let (ms, times) = (p.milliseconds, wall[0] / p.milliseconds);
            format!("{:>8}{ms:>13.3}{times:>7.2}", p.coarse)
        });
        let _ = writeln!(
            out,
            "{:<width$}{:>12.3}{:>12.3}{:>12.3}{:>12.3}{:>12}{:>10.2}{}",
            row.stage,
            wall[0],
            wall[1],
            cpu[0],
            cpu[1],
            row.items,
            row.ns_per_item(),
            published,
        );
    }
    out
}
