//! The reason why a run is to be executed: how it differs from the most similar existing recording.

use crate::plan::{PlannedRun, Status};
use kinetoscope_console::Explained as _;
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::differing_keys;
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::file::{final_path, partial_path};
use kinetoscope_recording::reader::{Outcome, Recording};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The recordings of a folder, each opened once.
#[derive(Debug, Default)]
pub struct Earlier {
    /// By the file's stem without its run key: the experiment's name, the coordinates and the replicate.
    by_stem: BTreeMap<String, Vec<EarlierRecording>>,
    /// File names by run key.
    by_key: BTreeMap<String, String>,
}

/// Why a run is to be executed or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The reason, with the files and values that differ.
    pub text: String,
    /// The same without what is of this run only, such as `to do: differs in seed`, by which many runs are counted.
    pub kind: String,
}

impl Reason {
    fn of(kind: &str, text: String) -> Self {
        Self { text, kind: kind.to_owned() }
    }
}

#[derive(Debug)]
struct EarlierRecording {
    file: String,
    contents: Contents,
}

#[derive(Debug)]
enum Contents {
    Readable { manifest: String, physics_version: u32 },
    OtherSchema(u32),
}

impl Earlier {
    /// Reads the finished recordings of a folder; empty if the folder does not exist. Other files are skipped.
    #[must_use]
    pub fn in_folder(folder: &Path) -> Self {
        let mut earlier = Self::default();
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort();
        for file in names {
            let Some(stem) = file.strip_suffix(".mcap").filter(|stem| !stem.ends_with(".partial"))
            else {
                continue;
            };
            let contents = match Recording::open(&folder.join(&file)) {
                Ok(recording) => {
                    let provenance = recording.provenance();
                    earlier.by_key.insert(provenance.run_key.clone(), file.clone());
                    Contents::Readable {
                        manifest: recording.manifest().to_owned(),
                        physics_version: provenance.physics_version,
                    }
                }
                Err(ReadError { fault: ReadFault::OtherSchema { found }, .. }) => {
                    Contents::OtherSchema(found)
                }
                Err(_) => continue,
            };
            let stem = without_key(stem).to_owned();
            earlier.by_stem.entry(stem).or_default().push(EarlierRecording { file, contents });
        }
        earlier
    }

    /// Describes whether a run is to be executed, and why.
    #[must_use]
    pub fn reason(&self, run: &PlannedRun, folder: &Path) -> Reason {
        match &run.status {
            Status::Done(Outcome::Fault(fault)) => {
                let text = format!("finished; it failed ({fault}), --force reruns it");
                Reason { text, kind: "finished; the run failed, --force reruns it".to_owned() }
            }
            Status::Done(_) => Reason::of("finished", "finished".to_owned()),
            Status::Rejected(error) => {
                Reason::of("rejected", format!("rejected: {}", error.message().clause()))
            }
            Status::ToDo(_) => {
                let Reason { text, kind } = self.reason_to_execute(run, folder);
                Reason { text: format!("to do: {text}"), kind: format!("to do: {kind}") }
            }
        }
    }

    fn reason_to_execute(&self, run: &PlannedRun, folder: &Path) -> Reason {
        if let Some(reason) = unusable(&final_path(folder, &run.stem())) {
            return Reason::of("its recording cannot be used", reason);
        }
        if partial_path(folder, &run.stem()).exists() {
            return Reason::of("unfinished", format!("{}.partial.mcap is unfinished", run.stem()));
        }
        // The sweep or the number of replicates has changed.
        if let Some(file) = self.by_key.get(run.run_key.as_str()) {
            let text = format!("recorded as {file}, which has another name");
            return Reason::of("recorded with another name", text);
        }
        let candidates = self.by_stem.get(without_key(&run.stem())).into_iter().flatten();
        let nearest = candidates
            .map(|earlier| (changes(&earlier.contents, run), &earlier.file))
            .min_by_key(|(changes, _)| changes.len());
        match nearest {
            Some((changes, file)) => {
                let keys = changes.iter().map(|change| change.split(": ").next().unwrap_or(change));
                let kind = format!("differs in {}", keys.collect::<Vec<_>>().join(", "));
                let text = format!("differs from {file}\n    {}", changes.join("\n    "));
                Reason { text, kind }
            }
            None => Reason::of("never recorded", "never recorded".to_owned()),
        }
    }
}

/// A file's stem without its run key.
fn without_key(stem: &str) -> &str {
    stem.rsplit_once("__").map_or(stem, |(start, _)| start)
}

/// Why an existing file cannot serve as the run's recording; `None` if there is no file.
fn unusable(path: &Path) -> Option<String> {
    if !path.exists() {
        return None;
    }
    match Recording::open(path) {
        Err(error) => Some(error.message().clause()),
        Ok(recording) => Some(match recording.provenance().outcome {
            None => format!("{} has no end", shown_path(path)),
            Some(Outcome::Interrupted) => format!("{} was interrupted", shown_path(path)),
            Some(_) => format!("{} has the run key of another run", shown_path(path)),
        }),
    }
}

fn changes(earlier: &Contents, run: &PlannedRun) -> Vec<String> {
    match earlier {
        Contents::OtherSchema(found) => vec![format!("schema version: {found} → {SCHEMA_VERSION}")],
        Contents::Readable { manifest, physics_version: before } => {
            let now = kind_of(&run.run.manifest.model).physics_version;
            let version = (*before != now).then(|| format!("physics version: {before} → {now}"));
            let keys = differing_keys(manifest, &run.run.manifest.canonical());
            version.into_iter().chain(keys.iter().map(ToString::to_string)).collect()
        }
    }
}
