//! Where the numbers of `report.html` come from: the recordings, the programs, the machine and the files next to the page.

use super::file_links::FileLinks;
use super::markup::breakable;
use super::{AnalysisReport, verify};
use crate::input::host_file::utc;
use crate::number_text::six_digits;
use maud::{Markup, html};
use std::collections::BTreeSet;

/// The list of facts and files, with the most important ones in its title.
pub(super) fn section(report: &AnalysisReport, links: &FileLinks) -> Markup {
    let facts = facts(report);
    let title = facts.iter().filter(|(name, _)| *name != "run key" && *name != "model");
    let title = title.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ");
    html! {
        details {
            summary { h2 { "Files and keys" } " " span class="facts" { (title) } }
            dl class="provenance" {
                @for (name, value) in facts { div { dt { (name) } dd { (breakable(&value)) } } }
            }
            // A line of its own, because it differs between machines.
            @if let Some(machine) = machine(report) { p class="machine facts" { (machine) } "\n" }
            @if let Some(missing) = verify::missing(report) { p class="facts" { (missing) } }
            (links.list())
        }
    }
}

fn facts(report: &AnalysisReport) -> Vec<(&'static str, String)> {
    let distinct = |of: fn(&crate::run::RunAnalysis) -> String| {
        let all: BTreeSet<String> = report.runs.iter().map(of).collect();
        all.into_iter().collect::<Vec<_>>().join(", ")
    };
    let mut facts = vec![("model", report.models_and_runs())];
    if let [run] = report.runs.as_slice() {
        facts.push(("run key", run.origin.run_key.clone()));
    }
    facts.push(("seed", distinct(|run| run.manifest.seed.to_string())));
    facts.push(("program", distinct(|run| run.origin.program_version.clone())));
    facts.push(("physics", distinct(|run| format!("version {}", run.origin.physics_version))));
    let bytes: u64 = report.sizes.values().sum();
    // The runs of a table have no recordings.
    facts.extend((bytes > 0).then(|| ("size", size_text(bytes))));
    facts
}

/// Date, machine and wall time of the runs; `None` without host files.
fn machine(report: &AnalysisReport) -> Option<String> {
    let hosts = &report.hosts;
    let names: BTreeSet<String> = hosts
        .iter()
        .map(|host| {
            let name = host.host.as_deref().unwrap_or("unknown host");
            format!("{name} ({} {})", host.operating_system, host.architecture)
        })
        .collect();
    let date = hosts.iter().filter_map(|host| host.finished_unix_time_s).max();
    let seconds: f64 = hosts.iter().filter_map(|host| host.wall_time_s).sum();
    if hosts.is_empty() {
        return None;
    }
    let names = names.into_iter().collect::<Vec<_>>().join(", ");
    let date = date.map_or_else(String::new, |seconds| format!("{}, ", utc(seconds)));
    let which = match (hosts.len(), report.runs.len()) {
        (1, 1) => "",
        (known, all) if known < all => " of the runs with a host file",
        _ => " of all runs",
    };
    Some(format!("recorded {date}on {names}; wall time{which} {}", duration_text(seconds)))
}

fn size_text(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{} kB", six_digits(libm::round(bytes as f64 / 100.0) / 10.0)),
        _ => format!("{} MB", six_digits(libm::round(bytes as f64 / 1e5) / 10.0)),
    }
}

fn duration_text(seconds: f64) -> String {
    match seconds {
        short if short < 60.0 => format!("{} s", six_digits(libm::round(100.0 * short) / 100.0)),
        minutes if minutes < 5400.0 => {
            format!("{} min", six_digits(libm::round(minutes / 6.0) / 10.0))
        }
        hours => format!("{} h", six_digits(libm::round(hours / 360.0) / 10.0)),
    }
}
