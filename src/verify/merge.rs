//! One recording of several runs, for a viewer.

use crate::interrupt::Interrupt;
use crate::run::recording;
use crate::verify::error::VerifyError;
use crate::verify::restored_file::unwritten;
use crate::verify::source::Source;
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::atomic_file::{NewFile, replace};
use kinetoscope_files::output_file;
use kinetoscope_manifest::{differing_keys, manifest_values};
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::layout::{layout_json, with_states};
use kinetoscope_recording::merged::{MAX_RUNS, MergeError, MergedRun, merge};
use kinetoscope_recording::merged_layout::merged_layout_json;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Header;
use std::io;
use std::path::{Path, PathBuf};

impl From<MergeError> for VerifyError {
    fn from(error: MergeError) -> Self {
        match error {
            MergeError::Read(error) => Self::Read(error),
            MergeError::Write(error) => Self::Write(error),
        }
    }
}

/// Checks that so many recordings can be merged into this file, before any is read.
///
/// # Errors
/// More recordings than colors, a name without `.mcap`, an existing file or layout, or one that cannot be written.
pub fn check_merge(count: usize, file: &Path) -> Result<(), VerifyError> {
    let usage = |what: String, help: &str| Err(VerifyError::Arguments(Message::new(what, help)));
    if count > MAX_RUNS {
        let what = format!("{count} recordings are too many to be told apart in one");
        return usage(what, &format!("name at most {MAX_RUNS}"));
    }
    if file.extension().is_none_or(|ending| ending != "mcap") {
        let what = format!("{} is not the name of a file that ends in .mcap", shown_path(file));
        return usage(what, "name one, such as --mcap both.mcap");
    }
    for path in [file, &layout_path(file)] {
        if path.symlink_metadata().is_ok() {
            let what = format!("{} already exists", shown_path(path));
            return usage(what, "delete it, or name a new file");
        }
    }
    output_file::check(file).map_err(|error| unwritten(file, &error, "--mcap"))
}

/// Merges recordings of one model into a new file, writes a layout next to it, and returns what was written.
///
/// # Errors
/// As [`check_merge`], different models, or a recording that cannot be read.
pub fn merge_recordings(paths: &[&Path], file: &Path) -> Result<Vec<String>, VerifyError> {
    check_merge(paths.len(), file)?;
    let usage = |what: String, help: &str| Err(VerifyError::Arguments(Message::new(what, help)));
    let recordings =
        paths.iter().map(|path| recording::open(path)).collect::<Result<Vec<_>, _>>()?;
    let model = |recording: &Recording| recording.provenance().model.clone();
    let models: Vec<String> = recordings.iter().map(model).collect();
    if let Some(other) = models.iter().find(|model| **model != models[0]) {
        let first = &models[0];
        let what = format!("the recordings are of different models: {first} and {other}");
        return usage(what, "name recordings of one model");
    }
    let labels = labels(&recordings);
    let runs = recordings.iter().zip(&labels);
    let runs: Vec<MergedRun<'_>> =
        runs.map(|(recording, label)| MergedRun { recording, label }).collect();
    let written = |source: io::Error| {
        let named = io::Error::new(source.kind(), format!("{}: {source}", shown_path(file)));
        VerifyError::Write(RecordError::Io(named))
    };
    let new = merge(&runs, NewFile::create(file).map_err(written)?)?;
    new.finish().map_err(written)?;
    let mut lines = vec![format!("{}: {} runs", shown_path(file), runs.len())];
    match layout(&recordings) {
        Ok(layout) => {
            let path = layout_path(file);
            let layout = merged_layout_json(&layout, &labels)?;
            replace(&path, layout.as_bytes()).map_err(written)?;
            lines.push(format!("layout: {}", shown_path(&path)));
        }
        Err(error) => lines.push(format!("no layout: {error}")),
    }
    Ok(lines)
}

/// `NAME.layout.json` for `NAME.mcap`.
fn layout_path(file: &Path) -> PathBuf {
    file.with_extension("layout.json")
}

/// The layout of the first run; with the states of all, if not every frame of each is drawn.
///
/// # Errors
/// A first run that this program cannot start.
fn layout(recordings: &[Recording]) -> Result<String, VerifyError> {
    let header = |recording| -> Result<Header, VerifyError> {
        Ok(Source::of(recording)?.prepared(&Interrupt::default())?.header)
    };
    let is_thinned = |header: &Header| header.draw_every.get() > 1;
    let first = header(&recordings[0])?;
    let layout = layout_json(&first, &[])?;
    let mut others = recordings[1..].iter();
    let has_thinned = is_thinned(&first)
        || others.any(|other| header(other).is_ok_and(|header| is_thinned(&header)));
    Ok(if has_thinned { with_states(&layout)? } else { layout })
}

/// What tells the runs apart: the values of the manifest's keys that are not the same in all of them, or a number.
fn labels(recordings: &[Recording]) -> Vec<String> {
    let Some(first) = recordings.first() else { return Vec::new() };
    let mut keys: Vec<String> = Vec::new();
    for other in recordings {
        for difference in differing_keys(first.manifest(), other.manifest()) {
            if difference.key.starts_with("model.") && !keys.contains(&difference.key) {
                keys.push(difference.key);
            }
        }
    }
    if keys.is_empty() {
        keys.push("seed".to_owned());
    }
    let label = |(index, recording): (usize, &Recording)| {
        let values = manifest_values(recording.manifest());
        let named = keys.iter().filter_map(|key| {
            let (_, value) = values.iter().find(|(name, _)| name == key)?;
            let name = key.rsplit('.').next().unwrap_or(key);
            Some(format!("{name} {}", value.trim_matches('"')))
        });
        let named: Vec<String> = named.take(LABELED_KEYS).collect();
        format!("run {}: {}", index + 1, named.join(", "))
    };
    recordings.iter().enumerate().map(label).collect()
}

/// Maximum number of keys in a label.
const LABELED_KEYS: usize = 3;
