//! The files that an experiment starts from (`start_from`): recordings, and manifests with the files that they start from.

use super::archive::is_safe;
use crate::manifests::base_of;
use crate::messages::exit::unread;
use crate::messages::{Failure, bad};
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, read_text};
use kinetoscope_manifest::{is_manifest_name, start_names};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// All files that a manifest starts from, by their path below its folder, which is their name in a bundle.
///
/// # Errors
/// A file that is not below the folder of the manifest: the bundle of a stranger would read any file of this machine.
pub(super) fn starts(manifest: &Path) -> Result<BTreeMap<String, PathBuf>, Failure> {
    let mut found = BTreeMap::new();
    let mut waiting = vec![(String::new(), manifest.to_owned())];
    while let Some((folder, path)) = waiting.pop() {
        let text = read_text(&path, MAX_MANIFEST_BYTES).map_err(|error| {
            let what = format!("cannot read the manifest {}: {error}", shown_path(&path));
            unread(&error, what, "check the path")
        })?;
        for start in start_names(&text) {
            let parts: Vec<&str> = start.name.split('/').filter(|part| *part != ".").collect();
            let name = format!("{folder}{}", parts.join("/"));
            if !is_safe(&name) || !(is_manifest_name(&name) || name.ends_with(".mcap")) {
                let what = format!(
                    "{}:{}: start_from = \"{}\" is not a manifest or a recording (*.mcap) below the folder of the manifest",
                    shown_path(&path),
                    start.line,
                    one_line(&start.name)
                );
                return Err(bad(what).help("move the file there, and name it by its relative path"));
            }
            let file = base_of(&path).join(&start.name);
            if found.insert(name.clone(), file.clone()).is_none() && is_manifest_name(&name) {
                let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
                let folder = if folder.is_empty() { String::new() } else { format!("{folder}/") };
                waiting.push((folder, file));
            }
        }
    }
    Ok(found)
}
