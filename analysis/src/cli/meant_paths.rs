//! The paths that a user means: without any, the folder `recordings`; a manifest stands for the folder of its recordings.

use super::exit::CommandError;
use crate::input::SIDE_CAR;
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Message, complain};
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_manifest::experiment_name;
use std::path::{Path, PathBuf};

/// The folder below which `run` records unless `--output` names another.
const RECORDINGS: &str = "recordings";

/// The recordings and folders of recordings behind the paths of a command line.
///
/// # Errors
/// No path where there is no folder `recordings`, or a manifest without recordings there.
pub(super) fn meant_paths(paths: &[PathBuf]) -> Result<Vec<PathBuf>, CommandError> {
    if paths.is_empty() {
        let usual = PathBuf::from(RECORDINGS);
        return match usual.is_dir() {
            true => Ok(vec![usual]),
            false => Err(CommandError::usage(Message::new(
                "no path is named, and there is no folder `recordings` here",
                "name recordings, their folder or their manifest",
            ))),
        };
    }
    paths.iter().map(|path| meant_path(path)).collect()
}

fn meant_path(path: &Path) -> Result<PathBuf, CommandError> {
    if path.extension().is_none_or(|end| end != "toml") || !path.is_file() {
        return Ok(path.to_owned());
    }
    if path.file_name().is_some_and(|name| name == SIDE_CAR) {
        return Ok(folder_of(path).to_owned());
    }
    let source = read_text(path, MAX_SIDE_FILE_BYTES).ok();
    let Some(name) = source.and_then(|source| experiment_name(&source, path)) else {
        return Err(CommandError::usage(Message::new(
            format!(
                "{} states no name of an experiment, and its file name is none",
                shown_path(path)
            ),
            "set `name` to letters, digits, _ and -, or name the folder of the recordings",
        )));
    };
    let folder = Path::new(RECORDINGS).join(name);
    if folder.is_dir() {
        if is_newer(path, &folder.join(SIDE_CAR)) {
            let manifest = shown_path(path);
            let note = format!(
                "note: {manifest} was saved after its runs, which are analyzed as they were recorded; run it again if it was changed"
            );
            complain(&note, false);
        }
        return Ok(folder);
    }
    let (manifest, folder) = (shown_path(path), shown_path(&folder));
    Err(CommandError::usage(Message::new(
        format!("{manifest} has no recordings in {folder}"),
        "run it first, or name the folder of its recordings",
    )))
}

/// Whether a manifest was written after the description of its runs; false if the system states no times.
fn is_newer(manifest: &Path, description: &Path) -> bool {
    let written = |path: &Path| path.metadata().and_then(|it| it.modified()).ok();
    matches!((written(manifest), written(description)), (Some(one), Some(other)) if one > other)
}
