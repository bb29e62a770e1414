//! `check --locked`: compares the runs of a lock file's manifests with it and names the first difference of each.

use crate::locking::findings::Findings;
use crate::locking::lock::{
    checked, locked_recording, manifest_of, metrics_of, physics_version, relative_to, unreadable,
};
use crate::locking::lock_summary::markdown;
use crate::locking::locked_runs::{Parallel, RerunExperiment, RerunRun, Reruns, values_of};
use crate::locking::moved::moved;
use crate::manifests::expand;
use crate::messages::exit::{of_output, unread_recording};
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, plural, word};
use kinetoscope::verify::diff::compare_messages;
use kinetoscope::verify::divergence::{Cause, in_frames};
use kinetoscope::verify::fingerprint::FirstDifference;
use kinetoscope::verify::lock_file::{
    LockError, LockFile, LockedExperiment, QUICK_S, RunHashes, checks_hash,
};
use kinetoscope_console::Exit;
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::output_file;
use kinetoscope_manifest::{differing_values, manifest_values};
use kinetoscope_recording::channels::{FrameClock, SCHEMA_VERSION};
use kinetoscope_recording::reader::Recording;
use serde_json::{Value as Json, json};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

/// A check of a lock file.
pub(crate) struct LockedCheck<'a> {
    pub(crate) lock_file: &'a Path,
    /// The bundle that contains the lock file, which is not written again.
    pub(crate) bundle: Option<&'a Path>,
    /// The manifests to check; those of the tier if it is empty.
    pub(crate) manifests: &'a [PathBuf],
    /// Whether the slow manifests are checked as well.
    pub(crate) all: bool,
    /// Whether only manifests that together take [`QUICK_S`] are run, others are compared with their locked values, and other files are skipped.
    pub(crate) quick: bool,
    /// The folder of recordings, where finished runs may be found.
    pub(crate) recordings: PathBuf,
    /// The folder where recordings of the locked runs may be found.
    pub(crate) earlier: PathBuf,
    /// The file to which a summary in Markdown is appended.
    pub(crate) summary: Option<&'a Path>,
    /// Whether finished runs of that folder are compared instead of new ones.
    pub(crate) recorded: bool,
    pub(crate) parallel: Parallel,
    pub(crate) result: &'a ResultArguments,
}

impl LockedCheck<'_> {
    /// Compares the runs of the manifests.
    pub(crate) fn execute(&self) -> Result<Exit, Failure> {
        // Before the runs, which may take long.
        if let Some(path) = self.summary {
            output_file::check(path).map_err(|error| unwritten(path, &error))?;
        }
        let file =
            LockFile::read(self.lock_file).map_err(|error| unreadable(self.lock_file, &error))?;
        if file.schema_version != SCHEMA_VERSION {
            let what = format!(
                "{} was written for recording schema {}; this program records schema {SCHEMA_VERSION}",
                shown_path(self.lock_file),
                file.schema_version
            );
            return Err(Failure::new(Exit::Differs, what).help(WRITE_AGAIN));
        }
        if file.experiments.is_empty() {
            let what = format!("{} has no manifest", shown_path(self.lock_file));
            return Err(Failure::new(Exit::Unreadable, what)
                .help("add manifests with `kinetoscope lock MANIFEST…`"));
        }
        let (entries, unlocked) = self.entries(&file)?;
        let reruns = match self.recorded {
            true => Reruns::recorded(self.recordings.clone(), self.parallel)?,
            false => Reruns::new(self.parallel)?,
        };
        let (mut exit, mut checked) = (Exit::Done, Vec::<Json>::new());
        let (mut equal, mut differing) = (0, Vec::new());
        for failure in &unlocked {
            exit = exit.worst(failure.report());
        }
        let mut left_s = QUICK_S;
        for entry in &entries {
            let is_run = !self.quick || entry.at_most_s <= left_s;
            if is_run && self.quick {
                left_s -= entry.at_most_s;
            }
            let findings = match self.findings(entry, is_run, &reruns) {
                Ok(findings) => findings,
                Err(failure) if matches!(failure.exit, Exit::Signal(_)) => return Err(failure),
                Err(failure) => {
                    let failure = match self.bundle {
                        Some(_) if failure.exit == Exit::Unreadable => failure.help(COPY_AGAIN),
                        _ => failure,
                    };
                    exit = exit.worst(failure.report());
                    continue;
                }
            };
            self.result.say(&described(entry, findings.as_ref()));
            let lines = findings.as_ref().map_or_else(Vec::new, Findings::text);
            checked.push(json!({
                "manifest": entry.manifest, "equal": findings.is_none(), "findings": lines,
            }));
            match findings {
                None => equal += 1,
                Some(findings) => {
                    exit = exit.worst(Exit::Differs);
                    differing.push((entry.manifest.as_str(), findings));
                }
            }
        }
        if let Some(path) = self.summary {
            let unchecked = unlocked.len() + entries.len() - equal - differing.len();
            let text = markdown(equal, unchecked, &differing);
            output_file::append(path, &text).map_err(|error| unwritten(path, &error))?;
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
            let source = shown_path(self.bundle.unwrap_or(self.lock_file));
            let mut what = format!("the runs are not those of {source}");
            let (own, locked) = (env!("CARGO_PKG_VERSION"), &file.program_version);
            if locked != own {
                let locked = one_line(locked);
                what += &format!(", which version {locked} of the program wrote; this is {own}");
            }
            let help = if self.bundle.is_some() { OTHER_PROGRAM } else { WRITE_AGAIN };
            Failure::new(exit, what).help(help).report();
        }
    }

    /// The entries to check, and the errors of manifests without an entry, which do not keep others from being compared.
    fn entries<'a>(
        &self,
        file: &'a LockFile,
    ) -> Result<(Vec<&'a LockedExperiment>, Vec<Failure>), Failure> {
        if self.manifests.is_empty() {
            let all = if self.all { file.experiments.iter().collect() } else { file.quick() };
            return Ok((all, Vec::new()));
        }
        let (mut entries, mut unlocked) = (Vec::new(), Vec::new());
        for manifest in expand(self.manifests)? {
            let path = relative_to(self.lock_file, &manifest)?;
            match file.experiment(&path) {
                Some(entry) => entries.push(entry),
                None if self.quick => {}
                None => {
                    let (lock_file, path) = (shown_path(self.lock_file), one_line(&path));
                    let add = word(&manifest.to_string_lossy());
                    unlocked.push(
                        bad(format!("{lock_file} has no entry for {path}"))
                            .help(format!("add it with `kinetoscope lock {add}`")),
                    );
                }
            }
        }
        for folder in self.whole_folders() {
            entries.extend(deleted_in(file, self.lock_file, &folder)?);
        }
        Ok((entries, unlocked))
    }

    /// The folders whose deleted manifests are named: those of the command line, and in a CI job, where a shell lists the files that are left, those of
    /// all manifests.
    fn whole_folders(&self) -> BTreeSet<PathBuf> {
        let folder = |named: &PathBuf| match named.is_dir() {
            true => Some(named.clone()),
            false => self.summary.map(|_| folder_of(named).to_owned()),
        };
        self.manifests.iter().filter_map(folder).collect()
    }

    /// What differs from the entry; `None` if nothing does.
    fn findings(
        &self,
        entry: &LockedExperiment,
        is_run: bool,
        reruns: &Reruns,
    ) -> Result<Option<Findings>, Failure> {
        let manifest = manifest_of(self.lock_file, entry)?;
        if !self.manifests.is_empty() && !manifest.exists() {
            let what = "the manifest no longer exists; `kinetoscope lock` removes its entry";
            return Ok(Some(Findings { lines: vec![what.to_owned()], ..Findings::default() }));
        }
        if !is_run {
            let lines = edited(entry, &values_of(&manifest));
            return Ok((!lines.is_empty()).then(|| Findings { lines, ..Findings::default() }));
        }
        let rerun = reruns.execute(&manifest)?;
        let lines = match other_model(entry, &rerun) {
            Some(finding) => vec![finding],
            None => {
                let mut lines = other_runs(entry, &rerun);
                if lines.is_empty() {
                    lines = self.differences(entry, &rerun)?;
                }
                lines
            }
        };
        let findings = match lines.is_empty() {
            true => None,
            false => {
                let checked = checked(&rerun)?;
                let movements = moved(entry, &checked.values);
                Some(Findings { lines, movements, checked })
            }
        };
        reruns.remove(rerun);
        Ok(findings)
    }

    /// What differs in the messages of the same runs.
    fn differences(
        &self,
        entry: &LockedExperiment,
        rerun: &RerunExperiment,
    ) -> Result<Vec<String>, Failure> {
        let first = &rerun.runs[0];
        let (recording, found) = first.fingerprint()?;
        let mut messages = vec![found.messages.clone()];
        for run in &rerun.runs[1..] {
            messages.push(run.messages()?);
        }
        let same_messages = RunHashes::new(&[], &messages).messages == entry.messages;
        if same_messages {
            if entry.frame_tags() != Some(found.tags()) {
                let manifest = one_line(&entry.manifest);
                let what =
                    format!("the tags of {manifest} are not those of its run, which is equal");
                return Err(unreadable(self.lock_file, &LockError::Damaged(what)));
            }
            let metrics = metrics_of(&recording)?;
            let checks = checks_hash(&rerun.checks, &entry.values, &entry.checked);
            let other_metrics =
                "the messages are equal, but not the metrics: the analysis has changed";
            let other_checks = "the runs are equal, but a check of the manifest was added, edited or removed, or this entry of the lock file was edited";
            let found =
                [(metrics != entry.metrics, other_metrics), (checks != entry.checks, other_checks)];
            let found = found.into_iter().filter(|(differs, _)| *differs);
            return Ok(found.map(|(_, what)| what.to_owned()).collect());
        }
        let tags = entry.frame_tags().filter(|tags| *tags != found.tags() || entry.runs == 1);
        if let Some(tags) = &tags
            && tags.shows_equal_messages(&found)
        {
            let what =
                format!("the hash of {} is not that of its tags, which are equal", first.name);
            return Err(unreadable(self.lock_file, &LockError::Damaged(what)));
        }
        let others = entry.first_other_runs(&messages).unwrap_or(0..1);
        let run = &rerun.runs[others.start];
        let mut lines = match self.locked_values(entry, rerun, others.start)? {
            Some(lines) => lines,
            None => {
                let place = match tags.filter(|_| others == (0..1)) {
                    Some(tags) => described_place(tags.first_difference(&found), &recording),
                    None if others.len() == 1 => "the messages differ".to_owned(),
                    None => format!("the messages of one of {} runs differ", others.len()),
                };
                let local = shown_path(&self.local(rerun, run));
                vec![match self.bundle {
                    Some(_) => format!(
                        "{place}; `bundle --recordings` includes what names the particle and both values"
                    ),
                    None => format!(
                        "{place}; for the particle and both values, copy a recording of the locked run to {local}, or compare it with `kinetoscope compare`"
                    ),
                }]
            }
        };
        lines[0] = format!("{}: {}", run.name, lines[0]);
        Ok(lines)
    }

    /// Where the recording of a locked run may be.
    fn local(&self, rerun: &RerunExperiment, run: &RerunRun) -> PathBuf {
        let name = run.recording.file_name().unwrap_or_default();
        self.earlier.join(&rerun.experiment.name).join(name)
    }

    /// The first difference with its values and its cause, if a recording with the locked messages is there.
    fn locked_values(
        &self,
        entry: &LockedExperiment,
        rerun: &RerunExperiment,
        number: usize,
    ) -> Result<Option<Vec<String>>, Failure> {
        let run = &rerun.runs[number];
        let local = self.local(rerun, run);
        let Some(local) = locked_recording(&local, entry, number) else { return Ok(None) };
        let (recording, _) = run.fingerprint()?;
        let comparison =
            compare_messages(&local, &recording).map_err(|error| unread_recording(&error))?;
        let Some(difference) = comparison.difference else { return Ok(None) };
        let mut lines = vec![difference.describe("the locked recording", "this run")];
        let divergence = in_frames(&local, &recording).map_err(|error| unread_recording(&error))?;
        let cause = divergence.map(|divergence| match divergence.cause() {
            Cause::Rounding => "cause: rounding errors",
            Cause::Physics => "cause: other coefficients or equations",
            Cause::Undecided => "cause: not decided by the frames; record more frames, or compare both programs step by step",
        });
        lines.extend(cause.map(str::to_owned));
        Ok(Some(lines))
    }
}

/// The error of a summary that cannot be written.
fn unwritten(path: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write {}: {error}", shown_path(path));
    Failure::new(of_output(error), what).help("name another file with --summary")
}

/// The entries of manifests in a folder that no longer exist.
fn deleted_in<'a>(
    file: &'a LockFile,
    lock_file: &Path,
    folder: &Path,
) -> Result<Vec<&'a LockedExperiment>, Failure> {
    let folder = relative_to(lock_file, folder)?;
    let is_deleted = |entry: &&LockedExperiment| {
        let parent = entry.manifest.rsplit_once('/').map_or("", |(parent, _)| parent);
        parent == folder && !lock_file.with_file_name(&entry.manifest).exists()
    };
    Ok(file.experiments.iter().filter(is_deleted).collect())
}

/// What to do with a bundle whose lock file is damaged.
pub(crate) const COPY_AGAIN: &str = "copy the file again from where it was published";
const OTHER_PROGRAM: &str =
    "the first difference is above; try the version of the program that bundle.json names";
const WRITE_AGAIN: &str = "if the change is intended, write the file again with `kinetoscope lock`, and review what changed";

/// Whether the model, or the physics of this program, is another one than that of the locked runs, whose bits are then expected to differ.
fn other_model(entry: &LockedExperiment, rerun: &RerunExperiment) -> Option<String> {
    let (model, locked) = (rerun.experiment.model(), entry.physics_version);
    if entry.model != model {
        return Some(format!("the model is {model}, locked {}", one_line(&entry.model)));
    }
    let version = physics_version(&rerun.experiment.runs[0].manifest);
    (version != locked).then(|| {
        format!("the physics version of {model} is {version}, locked with {locked}: other numbers are expected")
    })
}

/// The keys that were edited, one line each.
fn edited(entry: &LockedExperiment, values: &BTreeMap<String, String>) -> Vec<String> {
    let now: Vec<(String, String)> = values.clone().into_iter().collect();
    let changed = differing_values(manifest_values(&entry.values), &now);
    changed.iter().map(|key| format!("the manifest was edited: {key}")).collect()
}

/// Why the manifest describes other runs than those that are locked: one line per key. Empty if it describes the same.
fn other_runs(entry: &LockedExperiment, rerun: &RerunExperiment) -> Vec<String> {
    let keys: Vec<String> = rerun.runs.iter().map(|run| run.run_key.clone()).collect();
    if RunHashes::new(&keys, &[]).keys == entry.keys && entry.runs == keys.len() {
        return Vec::new();
    }
    let mut lines = edited(entry, &rerun.values);
    if lines.is_empty() {
        lines.push("the manifest has the locked values, but describes other runs: a file that it names, or a default of the program, has changed".to_owned());
    }
    if entry.runs != keys.len() {
        lines.push(format!("{}, locked {}", plural(keys.len() as u64, "run"), entry.runs));
    }
    lines
}

/// The place of a difference as text, with the time of its frame.
fn described_place(difference: FirstDifference, recording: &Recording) -> String {
    let FirstDifference { first, last } = difference;
    if first < last {
        return format!("first difference in one of the frames {first} to {last} of the file");
    }
    described_frame(recording, first)
        .unwrap_or_else(|| format!("first difference in frame {first}"))
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

fn described(entry: &LockedExperiment, findings: Option<&Findings>) -> String {
    let manifest = one_line(&entry.manifest);
    match findings {
        None => format!("{manifest}: {} equal", plural(entry.runs as u64, "run")),
        Some(findings) => format!("{manifest}: differs\n  {}", findings.text().join("\n  ")),
    }
}
