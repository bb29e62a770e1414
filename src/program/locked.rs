//! `check --locked`: compares the runs of a lock file's manifests with it and names the first difference of each.

use crate::lock::{
    locked_recording, manifest_of, metrics_of, physics_version, relative_to, unreadable,
};
use crate::manifests::expand;
use crate::messages::{Failure, bad, plural, word};
use crate::rerun::{Parallel, RerunExperiment, RerunRun, Reruns};
use crate::result_arguments::ResultArguments;
use kinetoscope::verify::diff::compare_messages;
use kinetoscope::verify::fingerprint::{Fingerprint, Place};
use kinetoscope::verify::lock_file::{LockError, LockFile, LockedExperiment, LockedTrace};
use kinetoscope_console::Exit;
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_recording::channels::{FrameClock, SCHEMA_VERSION};
use kinetoscope_recording::reader::Recording;
use serde_json::{Value as Json, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How many metrics of a run are listed.
const LISTED_METRICS: usize = 8;

/// A check of a lock file.
pub(crate) struct LockedCheck<'a> {
    pub(crate) lock_file: &'a Path,
    /// The manifests to check; those of the tier if it is empty.
    pub(crate) manifests: &'a [PathBuf],
    /// Whether the slow manifests are checked as well.
    pub(crate) all: bool,
    /// The folder of recordings, where finished runs or the details of a difference may be found.
    pub(crate) recordings: PathBuf,
    /// Whether finished runs of that folder are compared instead of new ones.
    pub(crate) recorded: bool,
    pub(crate) parallel: Parallel,
    pub(crate) result: &'a ResultArguments,
}

impl LockedCheck<'_> {
    /// Compares the runs of the manifests.
    pub(crate) fn execute(&self) -> Result<Exit, Failure> {
        let file =
            LockFile::read(self.lock_file).map_err(|error| unreadable(self.lock_file, &error))?;
        if file.schema_version != SCHEMA_VERSION {
            let what = format!(
                "{} was written for recording schema {}; this program records schema {SCHEMA_VERSION}",
                shown_path(self.lock_file),
                file.schema_version
            );
            return Err(Failure::new(Exit::Differs, what).help(WRITE_ANEW));
        }
        if file.experiments.is_empty() {
            let what = format!("{} has no manifest", shown_path(self.lock_file));
            return Err(Failure::new(Exit::Unreadable, what)
                .help("add manifests with `kinetoscope lock MANIFEST…`"));
        }
        let entries = self.entries(&file)?;
        let reruns = match self.recorded {
            true => Reruns::recorded(self.recordings.clone(), self.parallel)?,
            false => Reruns::new(self.parallel)?,
        };
        let (mut exit, mut checked) = (Exit::Done, Vec::<Json>::new());
        for entry in &entries {
            let findings = match self.findings(entry, &reruns) {
                Ok(findings) => findings,
                Err(failure) if matches!(failure.exit, Exit::Signal(_)) => return Err(failure),
                Err(failure) => {
                    exit = exit.worst(failure.report());
                    continue;
                }
            };
            self.result.say(&described(entry, &findings));
            checked.push(json!({
                "manifest": entry.manifest, "equal": findings.is_empty(), "findings": findings,
            }));
            if !findings.is_empty() {
                exit = exit.worst(Exit::Differs);
            }
        }
        self.conclude(&file, exit, entries.len(), &checked);
        Ok(exit)
    }

    fn conclude(&self, file: &LockFile, exit: Exit, entries: usize, checked: &[Json]) {
        if self.result.json {
            self.result.print_json(&json!({ "exit_code": exit.code(), "experiments": checked }));
            return;
        }
        let equal = checked.iter().filter(|entry| entry["equal"] == true).count();
        let mut text = format!("{equal} of {} equal", plural(entries as u64, "manifest"));
        let rest = file.experiments.len() - entries.min(file.experiments.len());
        if rest > 0 && self.manifests.is_empty() && !self.all {
            text += &format!("; {} not checked (--all)", plural(rest as u64, "slow manifest"));
        }
        self.result.say(&text);
        if exit == Exit::Differs {
            let mut what = format!("the runs are not those of {}", shown_path(self.lock_file));
            let (own, locked) = (env!("CARGO_PKG_VERSION"), &file.program_version);
            if locked != own {
                let locked = one_line(locked);
                what += &format!(", which version {locked} of the program wrote; this is {own}");
            }
            Failure::new(exit, what).help(WRITE_ANEW).report();
        }
    }

    /// The entries to check.
    fn entries<'a>(&self, file: &'a LockFile) -> Result<Vec<&'a LockedExperiment>, Failure> {
        if self.manifests.is_empty() {
            return Ok(if self.all { file.experiments.iter().collect() } else { file.quick() });
        }
        let of = |manifest: &PathBuf| {
            let path = relative_to(self.lock_file, manifest)?;
            file.experiment(&path).ok_or_else(|| {
                bad(format!("{} has no entry for {}", shown_path(self.lock_file), one_line(&path)))
                    .help(format!(
                        "add it with `kinetoscope lock {}`",
                        word(&manifest.to_string_lossy())
                    ))
            })
        };
        expand(self.manifests)?.iter().map(of).collect()
    }

    /// What differs from the entry.
    fn findings(&self, entry: &LockedExperiment, reruns: &Reruns) -> Result<Vec<String>, Failure> {
        let rerun = reruns.execute(&manifest_of(self.lock_file, entry)?)?;
        let other = other_physics(entry, &rerun).or_else(|| other_runs(entry, &rerun));
        let findings = match other {
            Some(finding) => vec![finding],
            None => self.differences(entry, &rerun)?,
        };
        reruns.remove(rerun);
        Ok(findings)
    }

    /// What differs in the messages and metrics of the same runs.
    fn differences(
        &self,
        entry: &LockedExperiment,
        rerun: &RerunExperiment,
    ) -> Result<Vec<String>, Failure> {
        let (mut findings, mut differing) = (Vec::new(), 0);
        for (index, (line, run)) in entry.runs.iter().zip(&rerun.runs).enumerate() {
            let (recording, found) = run.fingerprint()?;
            let locked = line.rsplit(' ').next().unwrap_or_default();
            if found.messages != locked {
                differing += 1;
                if differing == 1 {
                    let trace = entry.trace.fingerprint().filter(|_| index == 0);
                    let at =
                        self.place(rerun, run, (&recording, &found), trace.as_ref(), locked)?;
                    findings.push(format!("{}: {at}", run.name));
                }
            } else if index == 0 && LockedTrace::of(&found) != entry.trace {
                let manifest = one_line(&entry.manifest);
                let what =
                    format!("the trace of {manifest} is not that of its run, which is equal");
                return Err(unreadable(self.lock_file, &LockError::Damaged(what)));
            }
            if index == 0 {
                findings.extend(moved(&entry.metrics, &metrics_of(&recording)?));
            }
        }
        if differing > 1 {
            findings
                .push(format!("{differing} of {} differ", plural(entry.runs.len() as u64, "run")));
        }
        Ok(findings)
    }

    /// The first difference of a run: exactly, if a recording with the locked messages is there, otherwise from the trace.
    fn place(
        &self,
        rerun: &RerunExperiment,
        run: &RerunRun,
        (recording, found): (&Recording, &Fingerprint),
        trace: Option<&Fingerprint>,
        locked: &str,
    ) -> Result<String, Failure> {
        let name = run.recording.file_name().unwrap_or_default();
        let local = self.recordings.join(&rerun.experiment.name).join(name);
        if let Some((local, _)) = locked_recording(&local, locked) {
            let comparison = compare_messages(&local, recording)
                .map_err(|error| Failure::with_remedy(Exit::Unreadable, error))?;
            if let Some(difference) = comparison.difference {
                return Ok(difference.describe("the locked recording", "this run"));
            }
        }
        if trace.is_some_and(|trace| trace.has_equal_trace(found)) {
            let what = format!("the hash of {} is not that of its trace, which is equal", run.name);
            return Err(unreadable(self.lock_file, &LockError::Damaged(what)));
        }
        let particles = recording
            .frames()
            .ok()
            .and_then(|mut frames| frames.next()?.ok()?.state().map(|state| state.rows() as u64))
            .unwrap_or(u64::MAX);
        let place = trace.and_then(|trace| trace.first_difference(found, particles));
        let Some(place) = place else {
            let missing = format!(
                "the messages differ; their place is known if {} has a recording with the locked messages",
                shown_path(&local)
            );
            return Ok(missing);
        };
        Ok(describe(&place, recording))
    }
}

const WRITE_ANEW: &str = "if the change is intended, write the file again with `kinetoscope lock`, and review what changed";

/// Whether the physics of this program is another one than that of the locked runs, whose bits are then expected to differ.
fn other_physics(entry: &LockedExperiment, rerun: &RerunExperiment) -> Option<String> {
    let (model, locked) = (rerun.experiment.model(), entry.physics_version);
    if entry.model != model {
        return Some(format!("the model is {model}, locked {}", one_line(&entry.model)));
    }
    let version = physics_version(&rerun.experiment.runs[0].manifest);
    (version != locked).then(|| {
        format!("the physics version of {model} is {version}, locked with {locked}: other numbers are expected")
    })
}

/// Why the manifest describes other runs than those that are locked.
fn other_runs(entry: &LockedExperiment, rerun: &RerunExperiment) -> Option<String> {
    let short = |key: &str| key.chars().take(16).collect::<String>();
    let mut locked = entry.runs.iter().map(|line| short(line));
    let mut found = rerun.runs.iter().map(|run| short(&run.run_key));
    let runs = entry.runs.len().max(rerun.runs.len());
    let (number, keys) = (1..=runs)
        .map(|number| (number, [found.next(), locked.next()]))
        .find(|(_, [now, locked])| now != locked)?;
    let [now, was] = keys.map(|key| key.unwrap_or_else(|| "missing".to_owned()));
    Some(format!(
        "the manifest describes other runs than those locked ({}, locked {}): the run key of run {number} is {now}, locked {was}",
        plural(rerun.runs.len() as u64, "run"),
        entry.runs.len()
    ))
}

/// The place of a difference as text, with the time of its frame.
fn describe(place: &Place, recording: &Recording) -> String {
    let (equal, frame) = place.frames;
    let mut text = match equal {
        Some(equal) if equal < frame.saturating_sub(1) => {
            format!("first difference after frame {equal}, at the latest in frame {frame}")
        }
        _ => format!("first difference in frame {frame}"),
    };
    let last_equal = equal.or(frame.checked_sub(1));
    text += &instant(recording, last_equal, frame).unwrap_or_default();
    let Some(row) = &place.row else { return text };
    if row.frame != frame {
        text += &format!("; in frame {}", row.frame);
    }
    let mut parts = Vec::new();
    if !row.topics.is_empty() {
        parts.push(row.topics.join(", "));
    }
    if !row.columns.is_empty() {
        parts.push(format!("columns {}", row.columns.join(", ")));
    }
    match row.particles.as_deref() {
        None => parts.push("more than two particles".to_owned()),
        Some([]) => {}
        Some([one]) => parts.push(format!("particle {one}")),
        Some(several) => {
            let names: Vec<String> = several.iter().map(u64::to_string).collect();
            parts.push(format!("particles {}", names.join(" and ")));
        }
    }
    if parts.is_empty() {
        // A row keeps one byte per topic and column, which is the same for other values one time in 256.
        parts.push("no topic is known".to_owned());
    }
    text + ": " + &parts.join("; ")
}

/// The time of a frame, and the steps or events since the last equal one.
fn instant(recording: &Recording, last_equal: Option<u64>, frame: u64) -> Option<String> {
    let mut from = None;
    for found in recording.frames().ok()? {
        let FrameClock { frame: index, step_or_event_count: count, time, time_unit } =
            found.ok()?.clock;
        if Some(index) == last_equal {
            from = Some(count);
        }
        if index == frame {
            let space = if time_unit.is_empty() { "" } else { " " };
            let between = from.map_or_else(String::new, |from| {
                format!(", between {from} and {count} steps or events")
            });
            return Some(format!(" (time {time:?}{space}{time_unit}{between})"));
        }
    }
    None
}

/// The metrics that moved, those that moved most first.
fn moved(locked: &BTreeMap<String, f64>, found: &BTreeMap<String, f64>) -> Vec<String> {
    let mut lines: Vec<(f64, String)> = Vec::new();
    for (name, old) in locked {
        match found.get(name) {
            Some(new) if new == old || (new.is_nan() && old.is_nan()) => {}
            Some(new) => {
                let relative = ((new - old) / old).abs();
                let order = if relative.is_nan() { f64::INFINITY } else { relative };
                let shown =
                    format!("metric {name}: {old:?} → {new:?} (relative change {relative:.1e})");
                lines.push((order, shown));
            }
            None => lines.push((f64::INFINITY, format!("metric {name}: {old:?} → no value"))),
        }
    }
    let is_new = |name: &&String| !locked.contains_key(*name);
    for name in found.keys().filter(is_new) {
        lines.push((f64::INFINITY, format!("metric {name}: not locked")));
    }
    lines.sort_by(|one, other| other.0.total_cmp(&one.0));
    let rest = lines.len().saturating_sub(LISTED_METRICS);
    let mut shown: Vec<String> =
        lines.into_iter().take(LISTED_METRICS).map(|(_, line)| line).collect();
    if rest > 0 {
        shown.push(format!("{} more moved", plural(rest as u64, "metric")));
    }
    shown
}

fn described(entry: &LockedExperiment, findings: &[String]) -> String {
    let manifest = one_line(&entry.manifest);
    if findings.is_empty() {
        return format!("{manifest}: {} equal", plural(entry.runs.len() as u64, "run"));
    }
    let findings: Vec<_> = findings.iter().map(|finding| one_line(finding)).collect();
    format!("{manifest}: differs\n  {}", findings.join("\n  "))
}
