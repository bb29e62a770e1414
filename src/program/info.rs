//! `info`: reports what a file is; for a recording, its experiment, key, seed, versions, channels, frames and outcome.

use crate::messages::exit::unread_recording;
use crate::messages::progress::size;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, plural};
use crate::named_recordings::named_recordings;
use clap::Args;
use kinetoscope::run::recording;
use kinetoscope_console::Exit;
use kinetoscope_console::text::{every, one_line, shown_path};
use kinetoscope_files::regular_file::{self, MAX_EXPERIMENT_RECORD_BYTES};
use kinetoscope_manifest::{ExperimentRecord, parse_run};
use kinetoscope_recording::channels::DISCS;
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::reader::{Outcome, Recording, StoredFrames};
use serde_json::{Value as Json, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Bytes at the start of a file that decide what it is.
const HEAD_BYTES: u64 = 512;

/// Report what a recording is: experiment, run key, seed, versions, channels, frames, outcome, size.
#[derive(Debug, Args)]
pub(crate) struct InfoArguments {
    /// Recordings (*.mcap), folders of recordings, or any other files
    #[arg(required = true, value_name = "FILE")]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

impl InfoArguments {
    /// Prints what each file is. The exit code is 0 only for complete recordings.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let paths = match named_recordings(&self.paths) {
            Ok(paths) => paths,
            Err(failure) => return self.result.concluded(self.result.failed(&failure)),
        };
        let (mut exit, mut documents) = (Exit::Done, Vec::new());
        for path in &paths {
            let described = describe(path, |report| {
                self.result.say(&report.text());
                documents.push(report.json());
            });
            if let Err(failure) = described {
                if documents.last().is_none_or(|last| last["file"] != json!(path)) {
                    documents.push(json!({ "file": path, "error": failure.plain_text() }));
                }
                exit = exit.worst(failure.report());
            }
        }
        if self.result.json {
            self.result.print_json(&match documents.pop() {
                Some(document) if documents.is_empty() => document,
                last => Json::Array(documents.into_iter().chain(last).collect()),
            });
        }
        self.result.concluded(exit)
    }
}

/// Shows a recording, and says why it is not a complete one.
fn describe(path: &Path, show: impl FnOnce(&Report<'_>)) -> Result<(), Failure> {
    let unreadable =
        |what: &str| Failure::new(Exit::Unreadable, format!("{} {what}", shown_path(path)));
    let metadata = fs::metadata(path)
        .map_err(|error| unreadable(&format!("cannot be read: {error}")).help("check the path"))?;
    if !metadata.is_file() {
        let special = regular_file::type_of(&metadata);
        return Err(
            unreadable(&format!("is {special}, not a recording")).help("name a recording (*.mcap)")
        );
    }
    let recording = recording::open(path).map_err(|error| not_a_recording(path, &error))?;
    let contents = Contents::read(&recording);
    show(&Report { recording: &recording, contents: &contents });
    match (&contents.error, &recording.provenance().outcome) {
        (Some(error), _) => Err(unread_recording(error)),
        (None, Some(Outcome::Complete | Outcome::Fault(_))) => Ok(()),
        (None, Some(Outcome::Interrupted) | None) => {
            Err(unreadable("is not finished").help("run its manifest again to resume"))
        }
    }
}

/// The error for a file that does not open as a recording, with what it is instead.
fn not_a_recording(path: &Path, error: &ReadError) -> Failure {
    if !matches!(error.fault, ReadFault::NotMcap | ReadFault::Torn { .. }) {
        return unread_recording(error);
    }
    let mut head = Vec::new();
    let read =
        regular_file::open(path).and_then(|(file, _)| file.take(HEAD_BYTES).read_to_end(&mut head));
    if let Err(error) = read {
        let what = format!("{} cannot be read: {error}", shown_path(path));
        return Failure::new(Exit::Unreadable, what).help("check its permissions");
    }
    match kind_of(&head, path) {
        Some((what, help)) => {
            let what = format!("{} is {what}, not a recording", shown_path(path));
            Failure::new(Exit::Unreadable, what).help(help)
        }
        None => unread_recording(error),
    }
}

/// What a file is by its first bytes, and what to do with it; `None` for the start of an MCAP file.
fn kind_of(head: &[u8], path: &Path) -> Option<(&'static str, &'static str)> {
    const NAME_ONE: &str = "name a recording (*.mcap)";
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let ends_with = |end: &str| path.to_string_lossy().ends_with(end);
    let signatures: [(&[u8], &'static str); 6] = [
        (b"\x89PNG", "a PNG image"),
        (b"\x1f\x8b", "gzip data: unpack it first"),
        (b"PK\x03\x04", "a ZIP archive: unpack it first"),
        (b"\x28\xb5\x2f\xfd", "Zstandard data: unpack it first"),
        (b"PAR1", "a Parquet table"),
        (b"\x7fELF", "a program"),
    ];
    if head.is_empty() {
        return Some(("an empty file", "run its manifest again, or copy the file again"));
    }
    if head.starts_with(MAGIC) {
        return None;
    }
    if let Some((_, what)) = signatures.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Some((what, NAME_ONE));
    }
    if ends_with(".checkpoint") {
        return Some(("a checkpoint of a run", "run its manifest again to resume"));
    }
    let is_text = !head.contains(&0)
        && std::str::from_utf8(head).map_or_else(|error| error.error_len().is_none(), |_| true);
    Some(match (is_text, ends_with(".toml"), ends_with(".json")) {
        (true, true, _) => ("a TOML file", "`kinetoscope check FILE` checks a manifest"),
        (true, _, true) => ("a JSON file", NAME_ONE),
        (true, ..) => ("a text file", NAME_ONE),
        (false, ..) => ("a file of unknown bytes", NAME_ONE),
    })
}

/// The frames of a recording, counted.
struct Contents {
    frames: u64,
    /// Number of messages per channel.
    messages: BTreeMap<String, u64>,
    /// Time of the last frame, in the model's unit.
    end_time: Option<f64>,
    /// Why the rest cannot be read.
    error: Option<ReadError>,
}

impl Contents {
    fn read(recording: &Recording) -> Self {
        let mut contents =
            Self { frames: 0, messages: BTreeMap::new(), end_time: None, error: None };
        let frames = match recording.frames() {
            Ok(frames) => frames.with_scalar_frames(),
            Err(error) => return Self { error: Some(error), ..contents },
        };
        for frame in frames {
            match frame {
                Ok(frame) => {
                    contents.frames += u64::from(frame.is_complete());
                    contents.end_time = Some(frame.clock.time);
                    for message in frame.messages() {
                        *contents.messages.entry(message.topic().to_owned()).or_default() += 1;
                    }
                }
                Err(error) => {
                    contents.error = Some(error);
                    break;
                }
            }
        }
        contents
    }
}

/// What is printed in place of the experiment's name.
const UNKNOWN_NAME: &str = "unknown (the file was renamed or moved)";

struct Report<'a> {
    recording: &'a Recording,
    contents: &'a Contents,
}

impl Report<'_> {
    /// The experiment's name. Recordings do not contain it, because the key of a run does not depend on it: it is read from the
    /// `experiment.toml` next to the recording that lists the run, or else from a file name that belongs to the run's key.
    fn experiment(&self) -> Option<String> {
        let run_key = self.recording.provenance().run_key.as_str();
        let path = self.recording.path();
        let record = path.with_file_name("experiment.toml");
        let listed = regular_file::read_text(&record, MAX_EXPERIMENT_RECORD_BYTES)
            .ok()
            .and_then(|text| ExperimentRecord::from_toml(&text, "experiment.toml").ok())
            .filter(|record| record.runs.iter().any(|run| run.run_key.as_str() == run_key));
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        listed.map(|record| record.name).or_else(|| {
            let (name, key) = (stem.split("__").next()?, stem.rsplit("__").next()?);
            (key.len() == 8 && run_key.starts_with(key)).then(|| name.to_owned())
        })
    }

    fn outcome(&self) -> String {
        match &self.recording.provenance().outcome {
            Some(Outcome::Complete) => "complete".to_owned(),
            Some(Outcome::Fault(fault)) => format!("failed: {fault}"),
            Some(Outcome::Interrupted) => "interrupted".to_owned(),
            None => "not finished".to_owned(),
        }
    }

    fn text(&self) -> String {
        let provenance = self.recording.provenance();
        let run = parse_run(self.recording.manifest()).ok();
        let mut lines = vec![
            ("experiment", self.experiment().unwrap_or_else(|| UNKNOWN_NAME.to_owned())),
            ("model", provenance.model.clone()),
            ("run key", provenance.run_key.clone()),
        ];
        if let Some(run) = run {
            lines.push(("seed", format!("{}, replicate {}", run.seed, run.replicate)));
        }
        lines.push((
            "versions",
            format!(
                "program {}, physics {}, schema {}",
                provenance.program_version, provenance.physics_version, provenance.schema_version
            ),
        ));
        lines.push(("outcome", self.outcome()));
        let until = self.contents.end_time.map_or_else(String::new, |time| {
            format!(", up to time {time} {}", provenance.time_unit).trim_end().to_owned()
        });
        let kept = match provenance.stored {
            StoredFrames::All => String::new(),
            StoredFrames::Keyframes(distance) => {
                let every = every(distance.get(), "frame");
                format!(" (keyframes: {every} of the run, with the scalars of all)")
            }
            StoredFrames::From(first) => format!(" (a part of a run, from frame {first} on)"),
        };
        let drawn = self.contents.messages.get(DISCS);
        let drawn = drawn.filter(|count| **count < self.contents.frames);
        let drawn = drawn.map_or_else(String::new, |count| format!(", {count} of them drawn"));
        lines.push(("frames", format!("{}{kept}{until}{drawn}", self.contents.frames)));
        lines.push(("size", size(self.recording.bytes())));
        let mut text = shown_path(self.recording.path());
        for (name, value) in lines {
            text += &format!("\n  {name:<11} {}", one_line(&value));
        }
        text += "\n  channels   ";
        for (index, (topic, count)) in self.contents.messages.iter().enumerate() {
            let start = if index == 0 { " " } else { "\n              " };
            text += &format!("{start}{} ({})", one_line(topic), plural(*count, "message"));
        }
        text
    }

    fn json(&self) -> Json {
        let provenance = self.recording.provenance();
        let run = parse_run(self.recording.manifest()).ok();
        json!({
            "file": self.recording.path(),
            "experiment": self.experiment(),
            "model": provenance.model,
            "run_key": provenance.run_key,
            "seed": run.as_ref().map(|run| run.seed),
            "replicate": run.as_ref().map(|run| run.replicate),
            "program_version": provenance.program_version,
            "physics_version": provenance.physics_version,
            "schema_version": provenance.schema_version,
            "outcome": self.outcome(),
            "frames": self.contents.frames,
            "end_time": self.contents.end_time,
            "time_unit": provenance.time_unit,
            "bytes": self.recording.bytes(),
            "channels": self.contents.messages,
            "error": self.contents.error.as_ref().map(ToString::to_string),
        })
    }
}
