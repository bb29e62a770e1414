//! Recordings rewritten by the container's own library with one change and correct checksums.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::kinetoscope_program;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Changes the payload of a message, given its topic and frame; `false` omits the message.
pub(crate) type MessageChange<'a> = &'a dyn Fn(&str, u64, &mut Vec<u8>) -> bool;

/// The changes of a recording.
#[derive(Default)]
pub(crate) struct Forgery<'a> {
    /// Changes the text of the manifest.
    pub(crate) manifest: Option<&'a dyn Fn(&str) -> String>,
    /// New values of the two metadata records, by key.
    pub(crate) metadata: BTreeMap<String, String>,
    /// Changes or omits messages.
    pub(crate) message: Option<MessageChange<'a>>,
}

impl Forgery<'_> {
    /// Writes the recording `original` with the changes to `forged`, with one chunk per frame.
    pub(crate) fn write(&self, original: &Path, forged: &Path) {
        let bytes = fs::read(original).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let mut writer = mcap::WriteOptions::new()
            .library("kinetoscope")
            .compression(None)
            .chunk_size(None)
            .disable_seeking(true)
            .create(Cursor::new(Vec::new()))
            .unwrap();
        for index in &summary.attachment_indexes {
            let mut attachment = mcap::read::attachment(&bytes, index).unwrap();
            if let Some(change) = self.manifest {
                let text = change(std::str::from_utf8(&attachment.data).unwrap());
                attachment.data = Cow::Owned(text.into_bytes());
            }
            writer.attach(&attachment).unwrap();
        }
        let mut records: Vec<mcap::records::Metadata> = summary
            .metadata_indexes
            .iter()
            .map(|index| mcap::read::metadata(&bytes, index).unwrap())
            .collect();
        for record in &mut records {
            for (key, value) in &mut record.metadata {
                if let Some(forged) = self.metadata.get(key) {
                    value.clone_from(forged);
                }
            }
        }
        let (end, start): (Vec<_>, Vec<_>) =
            records.into_iter().partition(|record| record.name == "kinetoscope.outcome");
        start.iter().for_each(|record| writer.write_metadata(record).unwrap());
        let mut frames = 0;
        let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        let mut messages: Vec<_> = messages.collect();
        // In the file, groups of channels have chunks of their own.
        messages.sort_by_key(|message| (message.log_time, message.channel.id));
        for mut message in messages {
            if message.channel.topic == "/frame" {
                if frames > 0 {
                    writer.flush().unwrap();
                }
                frames += 1;
            }
            let mut payload = message.data.into_owned();
            let kept = self
                .message
                .is_none_or(|change| change(&message.channel.topic, frames - 1, &mut payload));
            message.data = Cow::Owned(payload);
            if kept {
                writer.write(&message).unwrap();
            }
        }
        end.iter().for_each(|record| writer.write_metadata(record).unwrap());
        writer.finish().unwrap();
        fs::write(forged, writer.into_inner().into_inner()).unwrap();
    }
}

/// Executes `kinetoscope`.
pub(crate) fn kinetoscope<A: AsRef<std::ffi::OsStr>>(
    arguments: impl IntoIterator<Item = A>,
) -> Output {
    kinetoscope_program::kinetoscope().args(arguments).output().unwrap()
}

/// Executes `run-experiment`.
pub(crate) fn run_experiment<A: AsRef<std::ffi::OsStr>>(
    arguments: impl IntoIterator<Item = A>,
) -> Output {
    Command::new(env!("CARGO_BIN_EXE_run-experiment")).args(arguments).output().unwrap()
}

/// Records the only run of a manifest below `folder` and returns its file.
pub(crate) fn record(folder: &Path, name: &str, manifest: &str) -> PathBuf {
    let path = folder.join(format!("{name}.toml"));
    fs::write(&path, manifest).unwrap();
    let output = folder.join("recordings");
    let before = recordings(&output.join(name));
    let ran = run_experiment([
        "--quiet".as_ref(),
        "--output".as_ref(),
        output.as_os_str(),
        path.as_os_str(),
    ]);
    // A run that ends in a fault completes its recording and has exit code 1.
    assert!(matches!(ran.status.code(), Some(0 | 1)), "{name}: {}", stderr(&ran));
    let mut new = recordings(&output.join(name));
    new.retain(|file| !before.contains(file));
    assert_eq!(new.len(), 1, "{name}: exactly one recording must be new");
    new.remove(0)
}

/// The recordings in a folder.
pub(crate) fn recordings(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "mcap"));
    files.sort();
    files
}

/// The standard output of a program.
pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The standard error of a program.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}
