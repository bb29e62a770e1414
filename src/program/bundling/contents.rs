//! What a bundle contains: the manifest, the entry of the lock file, the results, and the description of all of it.

use super::archive::Content;
use super::description::{Description, iso_time};
use crate::locking::lock::{USUAL, entry};
use crate::locking::locked_runs::RerunExperiment;
use crate::messages::exit::unread;
use crate::messages::{Failure, bad};
use data_encoding::HEXLOWER;
use kinetoscope::verify::lock_file::LockFile;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, read_text};
use kinetoscope_recording::channels::SCHEMA_VERSION;
use serde_json::{Value as Json, json};
use sha1::{Digest as _, Sha1};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Version of the bundle's layout.
pub(super) const VERSION: u64 = 1;
/// What the bundle is, for programs.
pub(super) const BUNDLE: &str = "bundle.json";
/// The folder of the results; those of each experiment are in a folder of its name, as those that were bundled.
pub(super) const RECORDINGS: &str = "recordings";
/// Endings of the results that are bundled; host.json would differ between two machines.
const RESULTS: [&str; 5] = [".toml", ".json", ".csv", ".html", ".svg"];
const OF_THIS_MACHINE: &str = ".host.json";
/// Maximum size of the metrics of a bundled experiment.
const MAX_METRICS_BYTES: u64 = 256 << 20;
/// The commit of the source, if the build names it: releases do.
const COMMIT: Option<&str> = option_env!("KINETOSCOPE_COMMIT");

/// The files of a bundle by name.
pub(super) fn files(
    manifest: &Path,
    rerun: &RerunExperiment,
    with_recordings: bool,
    description: &Description,
) -> Result<BTreeMap<String, Content>, Failure> {
    let text = read_text(manifest, MAX_MANIFEST_BYTES).map_err(|error| {
        let what = format!("cannot read the manifest {}: {error}", shown_path(manifest));
        unread(&error, what, "check the path")
    })?;
    reject_starts(&rerun.values)?;
    let metrics = metrics(rerun)?;
    let name = rerun.experiment.name.as_str();
    let manifest_name = format!("{name}.toml");
    let entry = entry(manifest_name.clone(), rerun)?;
    let swhid = software_heritage_id(&text);
    let bundle = json!({
        "bundle": VERSION,
        "experiment": name,
        "manifest": manifest_name,
        "question": metrics["question"],
        "answer": metrics["answer"]["text"],
        "model": entry.model,
        "physics_version": entry.physics_version,
        "schema_version": SCHEMA_VERSION,
        "program": program(),
        "runs": rerun.runs.iter().map(|run| run.run_key.as_str()).collect::<Vec<_>>(),
        "software_heritage": {
            "manifest": swhid,
            "source": COMMIT.map(|commit| format!("swh:1:rev:{commit}")),
        },
    });
    let mut lock = LockFile::new(SCHEMA_VERSION);
    lock.put(entry);
    let unwritten = |error| Failure::new(Exit::Retryable, error);
    let lock = lock.text().map_err(unwritten)?;
    let mut files = results(rerun, with_recordings)?;
    files.insert(manifest_name.clone(), Content::Text(text));
    files.insert(USUAL.to_owned(), Content::Text(lock));
    files.insert(BUNDLE.to_owned(), Content::Text(format!("{bundle:#}\n")));
    let finished = iso_time(finished_unix_time_s(rerun));
    let described = description.files(&bundle, &files, &finished).map_err(unwritten)?;
    files.extend(described.into_iter().map(|(name, text)| (name.to_owned(), Content::Text(text))));
    Ok(files)
}

/// What made the results.
fn program() -> Json {
    json!({
        "name": "Kinetoscope",
        "version": env!("CARGO_PKG_VERSION"),
        "repository": env!("CARGO_PKG_REPOSITORY"),
        "commit": COMMIT,
    })
}

/// Rejects an experiment that starts from a recording elsewhere, which the bundle would not contain.
fn reject_starts(values: &BTreeMap<String, String>) -> Result<(), Failure> {
    let starts = |key: &&String| key.rsplit('.').next() == Some("start_from");
    match values.keys().find(starts) {
        None => Ok(()),
        Some(key) => Err(bad(format!(
            "the experiment starts from another recording ({key}), which a bundle does not contain"
        ))
        .help("bundle the experiment that it starts from, and describe both")),
    }
}

/// The metrics of these very runs.
fn metrics(rerun: &RerunExperiment) -> Result<Json, Failure> {
    let path = rerun.folder.join("metrics.json");
    let analyze = format!("analyze it first: kinetoscope analyze {}", shown_path(&rerun.folder));
    let text = read_text(&path, MAX_METRICS_BYTES).map_err(|error| {
        let what = format!("the experiment has no results: {}: {error}", shown_path(&path));
        unread(&error, what, &analyze)
    })?;
    let metrics: Json = serde_json::from_str(&text).unwrap_or_default();
    let analyzed = metrics["runs"].as_array().into_iter().flatten();
    let analyzed: Vec<_> =
        analyzed.map(|run| run["run_key"].as_str().unwrap_or_default()).collect();
    let recorded: Vec<_> = rerun.runs.iter().map(|run| run.run_key.as_str()).collect();
    if analyzed != recorded {
        let what = format!("{} is not of the runs of this manifest", shown_path(&path));
        return Err(bad(what).help(analyze));
    }
    Ok(metrics)
}

/// The results in the experiment's folder.
fn results(
    rerun: &RerunExperiment,
    with_recordings: bool,
) -> Result<BTreeMap<String, Content>, Failure> {
    let folder = &rerun.folder;
    let unreadable = |error: std::io::Error| {
        let what = format!("cannot read the folder {}: {error}", shown_path(folder));
        unread(&error, what, "check its permissions")
    };
    let mut files = BTreeMap::new();
    let below = |name: &str| format!("{RECORDINGS}/{}/{name}", rerun.experiment.name);
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_result = RESULTS.iter().any(|ending| name.ends_with(ending))
            && !name.ends_with(OF_THIS_MACHINE)
            && entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_result {
            files.insert(below(&name), Content::File(entry.path()));
        }
    }
    // Not those of an earlier manifest.
    for run in rerun.runs.iter().filter(|_| with_recordings) {
        let name = run.recording.file_name().unwrap_or_default().to_string_lossy();
        files.insert(below(&name), Content::File(run.recording.clone()));
    }
    Ok(files)
}

/// When the last run was finished, in s since 1970: as recorded next to it, or the time of the file.
fn finished_unix_time_s(rerun: &RerunExperiment) -> u64 {
    let recorded = |recording: &Path| {
        let text = read_text(&recording.with_extension("host.json"), MAX_MANIFEST_BYTES).ok()?;
        serde_json::from_str::<Json>(&text).ok()?["finished_unix_time_s"].as_u64()
    };
    let of_file = |recording: &Path| {
        let changed = fs::metadata(recording).and_then(|metadata| metadata.modified()).ok()?;
        changed.duration_since(SystemTime::UNIX_EPOCH).ok().as_ref().map(Duration::as_secs)
    };
    let finished = |recording| recorded(recording).or_else(|| of_file(recording)).unwrap_or(0);
    rerun.runs.iter().map(|run| finished(&run.recording)).max().unwrap_or(0)
}

/// The identifier of a text in the archive of Software Heritage (SWHID, ISO/IEC 18670): the hash that git gives a file.
fn software_heritage_id(text: &str) -> String {
    let mut hash = Sha1::new();
    hash.update(format!("blob {}\0", text.len()));
    hash.update(text);
    format!("swh:1:cnt:{}", HEXLOWER.encode(&hash.finalize()))
}

#[cfg(test)]
mod tests {
    use super::software_heritage_id;

    /// Source: `printf 'hello\n' | git hash-object --stdin`.
    #[test]
    fn identifier_of_a_text_is_its_hash_in_git() {
        let expected = "swh:1:cnt:ce013625030ba8dba906f756967f9e9ca394464a";
        assert_eq!(software_heritage_id("hello\n"), expected);
        assert_ne!(software_heritage_id("hello"), expected);
    }
}
