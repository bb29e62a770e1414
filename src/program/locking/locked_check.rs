//! `check --locked`: compares the runs of a lock file's manifests with it and names the first difference of each.

use crate::locking::lock::{
    locked_recording, manifest_of, metrics_of, physics_version, relative_to, unreadable,
};
use crate::locking::locked_runs::{Parallel, RerunExperiment, RerunRun, Reruns};
use crate::manifests::expand;
use crate::messages::exit::unread_recording;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, plural, word};
use kinetoscope::verify::diff::compare_messages;
use kinetoscope::verify::fingerprint::{Fingerprint, FirstDifference, FrameTags};
use kinetoscope::verify::lock_file::{LockError, LockFile, LockedExperiment};
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
                    let tags = entry.frame_tags().filter(|_| index == 0);
                    let at = self.place(rerun, run, (&recording, &found), tags.as_ref(), locked)?;
                    findings.push(format!("{}: {at}", run.name));
                }
            } else if index == 0 && entry.frame_tags().as_ref() != Some(&found.tags) {
                let manifest = one_line(&entry.manifest);
                let what =
                    format!("the tags of {manifest} are not those of its run, which is equal");
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

    /// The first difference of a run: with its values, if a recording with the locked messages is there, otherwise its frame.
    fn place(
        &self,
        rerun: &RerunExperiment,
        run: &RerunRun,
        (recording, found): (&Recording, &Fingerprint),
        tags: Option<&FrameTags>,
        locked: &str,
    ) -> Result<String, Failure> {
        let name = run.recording.file_name().unwrap_or_default();
        let local = self.recordings.join(&rerun.experiment.name).join(name);
        if let Some(local) = locked_recording(&local, locked) {
            let comparison =
                compare_messages(&local, recording).map_err(|error| unread_recording(&error))?;
            if let Some(difference) = comparison.difference {
                return Ok(difference.describe("the locked recording", "this run"));
            }
        }
        let place = match tags {
            Some(tags) if tags.shows_equal_messages(&found.tags) => {
                let what =
                    format!("the hash of {} is not that of its tags, which are equal", run.name);
                return Err(unreadable(self.lock_file, &LockError::Damaged(what)));
            }
            Some(tags) => described_place(tags.first_difference(&found.tags), recording),
            None => "the messages differ".to_owned(),
        };
        Ok(format!(
            "{place}; for the particle and both values, copy a recording of the locked run to {}, or compare it with `kinetoscope compare`",
            shown_path(&local)
        ))
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
fn described_place(difference: FirstDifference, recording: &Recording) -> String {
    match difference {
        FirstDifference::At(position) => described_frame(recording, position)
            .unwrap_or_else(|| format!("first difference in frame {position}")),
        FirstDifference::After(position) => {
            format!("first difference after frame {position} of the file")
        }
    }
}

/// A frame with its time, and the steps or events since the one before it; `None` if the recording is shorter.
fn described_frame(recording: &Recording, position: u64) -> Option<String> {
    let mut before = None;
    let frames = recording.frames().ok()?.with_scalar_frames();
    for (index, found) in (0..=position).zip(frames) {
        let FrameClock { frame, step_or_event_count: count, time, time_unit } = found.ok()?.clock;
        if index == position {
            let space = if time_unit.is_empty() { "" } else { " " };
            let between = before.map_or_else(String::new, |before| {
                format!(", between {before} and {count} steps or events")
            });
            return Some(format!(
                "first difference in frame {frame} (time {time:?}{space}{time_unit}{between})"
            ));
        }
        before = Some(count);
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
