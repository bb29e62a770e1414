//! What a bundle contains: the manifest, the entry of the lock file, the results, and the description of all of it.

use super::archive::{BUNDLE, Content, PACKAGES, RECORDINGS};
use super::description::Description;
use super::results::{MAX_RESULT_BYTES, METRICS, REPORT, analyze, without_machine};
use super::starts::starts;
use crate::locking::lock::{USUAL, entry};
use crate::locking::locked_runs::RerunExperiment;
use crate::messages::exit::unread;
use crate::messages::{Failure, bad};
use data_encoding::HEXLOWER;
use kinetoscope::verify::lock_file::LockFile;
use kinetoscope_console::Exit;
use kinetoscope_console::calendar::iso_time;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file::{MAX_EXPERIMENT_RECORD_BYTES, MAX_MANIFEST_BYTES, read_text};
use kinetoscope_recording::channels::SCHEMA_VERSION;
use serde_json::{Value as Json, json};
use sha1::{Digest as _, Sha1};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Version of the bundle's layout.
pub(super) const VERSION: u64 = 2;
/// What the recordings of a folder are.
const SIDE_CAR: &str = "experiment.toml";

/// What a bundle contains by the choice of its author, or by the program that wrote it. All else follows from the manifest.
pub(super) struct Claims {
    pub(super) description: Description,
    /// What made the results.
    pub(super) program: Json,
    /// The packages of that program.
    pub(super) packages: Option<Content>,
    /// The engine of report pages of that program.
    pub(super) engine: &'static [u8],
    /// When the last run was finished.
    pub(super) finished: String,
    pub(super) with_recordings: bool,
}

/// The files of a bundle by name.
pub(super) fn files(
    manifest: &Path,
    rerun: &RerunExperiment,
    claims: &Claims,
) -> Result<BTreeMap<String, Content>, Failure> {
    let text = read_text(manifest, MAX_MANIFEST_BYTES).map_err(|error| {
        let what = format!("cannot read the manifest {}: {error}", shown_path(manifest));
        unread(&error, what, "check the path")
    })?;
    let name = rerun.experiment.name.as_str();
    let manifest_name = format!("{name}.toml");
    let (mut files, metrics) = results(rerun, &manifest_name, claims)?;
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
        "program": claims.program,
        "finished": claims.finished,
        "authors": claims.description.authors_text(),
        "affiliation": claims.description.affiliation_text(),
        "license": claims.description.license,
        "runs": rerun.runs.iter().map(|run| run.run_key.as_str()).collect::<Vec<_>>(),
        "software_heritage": {
            "manifest": swhid,
            "source": claims.program["commit"].as_str().map(|commit| format!("swh:1:rev:{commit}")),
        },
    });
    let mut lock = LockFile::new(SCHEMA_VERSION);
    lock.program_version = claims.program["version"].as_str().unwrap_or_default().to_owned();
    lock.put(entry);
    let unwritten = |error| Failure::new(Exit::Retryable, error);
    let lock = lock.text().map_err(unwritten)?;
    files.insert(manifest_name.clone(), Content::Text(text));
    files.insert(USUAL.to_owned(), Content::Text(lock));
    files.insert(BUNDLE.to_owned(), Content::Text(format!("{bundle:#}\n")));
    for (name, path) in starts(manifest)? {
        if files.contains_key(&name) {
            return Err(bad(format!(
                "the experiment starts from {name}, which is a name in its bundle"
            ))
            .help("rename the file that it starts from"));
        }
        files.insert(name, Content::File(path));
    }
    let packages = claims.packages.iter().map(|packages| (PACKAGES.to_owned(), packages.clone()));
    files.extend(packages);
    let described = claims.description.files(&bundle, &files, &claims.finished);
    let described = described.map_err(unwritten)?;
    files.extend(described.into_iter().map(|(name, text)| (name.to_owned(), Content::Text(text))));
    Ok(files)
}

/// The results of the recordings in the experiment's folder, whatever was there.
fn results(
    rerun: &RerunExperiment,
    manifest_name: &str,
    claims: &Claims,
) -> Result<(BTreeMap<String, Content>, Json), Failure> {
    let folder = &rerun.folder;
    let below = |name: &str| format!("{RECORDINGS}/{}/{name}", rerun.experiment.name);
    let names = analyze(folder, claims.engine)?;
    let mut files: BTreeMap<String, Content> =
        names.iter().map(|name| (below(name), Content::File(folder.join(name)))).collect();
    let read = |name: &str, most: u64| {
        let path = folder.join(name);
        read_text(&path, most).map_err(|error| {
            let what = format!("cannot read {}: {error}", shown_path(&path));
            unread(&error, what, "check its permissions")
        })
    };
    let report = without_machine(&read(REPORT, MAX_RESULT_BYTES)?);
    files.insert(below(REPORT), Content::Text(report));
    let record = read(SIDE_CAR, MAX_EXPERIMENT_RECORD_BYTES)?;
    files.insert(below(SIDE_CAR), Content::Text(with_manifest(&record, manifest_name)));
    for run in rerun.runs.iter().filter(|run| claims.with_recordings && run.row.is_none()) {
        let name = run.recording.file_name().unwrap_or_default().to_string_lossy();
        files.insert(below(&name), Content::File(run.recording.clone()));
    }
    let metrics = serde_json::from_str(&read(METRICS, MAX_RESULT_BYTES)?).unwrap_or_default();
    Ok((files, metrics))
}

/// The record of an experiment with the manifest in the bundle in place of a path of this machine.
fn with_manifest(record: &str, manifest: &str) -> String {
    let line = |line: &str| match line.starts_with("manifest = ") {
        true => format!("manifest = {}\n", Json::from(manifest)),
        false => format!("{line}\n"),
    };
    record.lines().map(line).collect()
}

/// When the last run was finished: as recorded next to it, or the time of the file. Of runs without recordings, that of their description.
pub(super) fn finished_time(rerun: &RerunExperiment) -> String {
    let recorded = |recording: &Path| {
        let text = read_text(&recording.with_extension("host.json"), MAX_MANIFEST_BYTES).ok()?;
        serde_json::from_str::<Json>(&text).ok()?["finished_unix_time_s"].as_u64()
    };
    let of_file = |recording: &Path| {
        let changed = fs::metadata(recording).and_then(|metadata| metadata.modified()).ok()?;
        changed.duration_since(SystemTime::UNIX_EPOCH).ok().as_ref().map(Duration::as_secs)
    };
    let side_car = rerun.folder.join(SIDE_CAR);
    let finished = |recording| {
        let found = recorded(recording).or_else(|| of_file(recording));
        found.or_else(|| of_file(&side_car)).unwrap_or(0)
    };
    iso_time(rerun.runs.iter().map(|run| finished(&run.recording)).max().unwrap_or(0))
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
