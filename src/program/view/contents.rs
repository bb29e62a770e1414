//! The recordings of a folder with their layouts and reports, and their addresses.

use std::fs;
use std::net::SocketAddr;
use std::path::Path;

/// Folders below the named one that are searched.
const MAX_DEPTH: usize = 3;
/// Recordings that are listed at most.
const MAX_RECORDINGS: usize = 1000;
/// Files and folders that are scanned at most.
pub(super) const MAX_ENTRIES: usize = 100_000;

/// A recording with the files next to it. Paths are relative to the served folder, with `/`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Found {
    /// The recording.
    pub(super) path: String,
    /// The layout of its experiment.
    pub(super) layout: Option<String>,
    /// The report of its experiment.
    pub(super) report: Option<String>,
}

/// What is served.
#[derive(Debug, Default)]
pub(super) struct Contents {
    /// The recordings, sorted by path.
    pub(super) recordings: Vec<Found>,
    /// Whether there are more than are listed.
    pub(super) is_cut: bool,
    /// Number of files and folders that were scanned.
    entries: usize,
}

impl Contents {
    /// Searches a folder; of a folder with a named recording, only that one is found.
    pub(super) fn of(folder: &Path, only: Option<&str>) -> Self {
        let mut contents = Self::default();
        contents.search(folder, "", only, MAX_DEPTH);
        contents
    }

    /// Adds the recordings of a folder and of those below. Symbolic links are not followed.
    fn search(&mut self, folder: &Path, prefix: &str, only: Option<&str>, depth: usize) {
        let (mut files, mut folders) = (Vec::new(), Vec::new());
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            self.entries += 1;
            if self.entries > MAX_ENTRIES {
                self.is_cut = true;
                break;
            }
            let (Ok(kind), Ok(name)) = (entry.file_type(), entry.file_name().into_string()) else {
                continue;
            };
            match () {
                () if is_hidden(&entry.path()) => {}
                () if kind.is_file() => files.push(name),
                () if kind.is_dir() => folders.push(name),
                () => {}
            }
        }
        files.sort();
        folders.sort();
        let layout = files.iter().find(|name| name.ends_with(".layout.json"));
        let report = files.iter().find(|name| *name == "report.html");
        let beside = |name: &str| format!("{prefix}{name}");
        // A merged recording has a layout of its own.
        let own_layout = |recording: &str| {
            let own = format!("{}.layout.json", recording.strip_suffix(".mcap")?);
            files.iter().find(|name| **name == own)
        };
        let found = |name: &str| Found {
            path: beside(name),
            layout: own_layout(name).or(layout).map(|name| beside(name)),
            report: report.map(|name| beside(name)),
        };
        if let Some(only) = only {
            self.recordings.push(found(only));
        }
        for name in files.iter().filter(|name| only.is_none() && is_recording(name)) {
            if self.has_room() {
                self.recordings.push(found(name));
            }
        }
        if depth == 0 || only.is_some() {
            return;
        }
        for name in &folders {
            if self.is_cut {
                return;
            }
            self.search(&folder.join(name), &format!("{prefix}{name}/"), None, depth - 1);
        }
    }

    fn has_room(&mut self) -> bool {
        let has_room = self.recordings.len() < MAX_RECORDINGS;
        self.is_cut |= !has_room;
        has_room
    }
}

/// Whether a file or folder of this name is neither shown nor served: hidden ones and unfinished recordings.
pub(super) fn is_hidden(path: &Path) -> bool {
    path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'))
}

fn is_recording(name: &str) -> bool {
    name.ends_with(".mcap") && !name.ends_with(".partial.mcap")
}

/// The address that opens a recording in the viewer, with its layout.
pub(super) fn viewer_address(viewer: &str, server: SocketAddr, found: &Found) -> String {
    let address =
        |path: &String| percent_encoded(&format!("http://{server}{}", path_of_address(path)), "");
    let separator = if viewer.contains('?') { '&' } else { '?' };
    let recording = address(&found.path);
    let layout = found.layout.iter().map(|layout| format!("&layoutUrl={}", address(layout)));
    format!("{viewer}{separator}ds=remote-file&ds.url={recording}{}", layout.collect::<String>())
}

/// The path of an address of this server, for a path relative to the folder.
pub(super) fn path_of_address(path: &str) -> String {
    format!("/{}", percent_encoded(path, "/"))
}

/// A text as a part of an address; letters, digits, `-_.~` and the characters in `kept` stay as they are.
fn percent_encoded(text: &str, kept: &str) -> String {
    let mut encoded = String::new();
    for byte in text.bytes() {
        let character = char::from(byte);
        if character.is_ascii_alphanumeric()
            || "-_.~".contains(character)
            || kept.contains(character)
        {
            encoded.push(character);
        } else {
            encoded += &format!("%{byte:02X}");
        }
    }
    encoded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_address_keeps_every_character_of_a_name() {
        let found = Found {
            path: "a b/run&x=1#2.mcap".to_owned(),
            layout: Some("a b/a b.layout.json".to_owned()),
            report: None,
        };
        let server = SocketAddr::from(([127, 0, 0, 1], 8766));
        assert_eq!(
            viewer_address("http://localhost:8080/", server, &found),
            "http://localhost:8080/?ds=remote-file&ds.url=http%3A%2F%2F127.0.0.1%3A8766%2Fa%2520b%2Frun%2526x%253D1%25232.mcap&layoutUrl=http%3A%2F%2F127.0.0.1%3A8766%2Fa%2520b%2Fa%2520b.layout.json"
        );
        let with_query = viewer_address("http://localhost/?openIn=web", server, &found);
        assert!(with_query.starts_with("http://localhost/?openIn=web&ds=remote-file"));
    }
}
