//! `verify`: the run of a recording is executed again from the embedded manifest, and the bytes or messages are compared.

use crate::interrupt::Interrupt;
use crate::verify::diff::{Comparison, compare_messages};
use crate::verify::error::VerifyError;
use crate::verify::rerun::Rerun;
use crate::verify::source::{ReadablePart, Source};
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file;
use kinetoscope_manifest::{KeyDifference, differing_keys, run_key};
use kinetoscope_recording::error::{ReadError, ReadFault, RecordError};
use kinetoscope_recording::reader::{Outcome, Recording, StoredFrames};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

/// Size of the parts in which bytes are compared.
const COMPARED_AT_ONCE: usize = 1 << 16;

/// Result of a verification.
#[derive(Debug)]
pub struct Verification {
    /// The recording.
    pub recording: Recording,
    /// The physics version of this program.
    pub physics_version: u32,
    /// Whether the run key follows from the embedded manifest and the recorded versions.
    pub key_fits: bool,
    /// Manifest keys that this version of the program reads differently, such as a new key.
    pub reinterpreted: Vec<KeyDifference>,
    /// How far the file agrees with the rerun.
    pub finding: Finding,
}

/// How far a file agrees with its rerun.
#[derive(Debug)]
pub enum Finding {
    /// Every byte is equal.
    SameBytes {
        /// Number of frames in the file.
        frames: u64,
    },
    /// Bytes differ; the messages are compared, with the file on the left and the rerun on the right.
    Messages(Box<Comparison>),
}

/// Executes the run of a recording again and compares. Bytes are compared while they are produced, which needs no disk space. If
/// they differ, the messages are compared with a temporary recording. For a damaged or unfinished file, the intact frames are
/// compared.
///
/// # Errors
/// A file without a readable frame, a manifest that is not accepted, a rerun that does not start, or an interruption.
pub fn verify(
    path: &Path,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<Verification, VerifyError> {
    let source = Source::open(path)?;
    let provenance = source.recording.provenance();
    if let StoredFrames::From(_) = provenance.stored {
        let what = format!("{} is a part of a run", shown_path(path));
        let help = "verify the recording of the whole run";
        return Err(VerifyError::Unsuitable(Message::new(what, help)));
    }
    let readable = readable_part(&source, interrupt)?;
    let (frames, is_damaged) = (readable.frames, readable.damage.is_some());
    let is_unfinished = is_damaged || provenance.outcome == Some(Outcome::Interrupted);
    let rerun = || -> Result<Rerun<'_>, VerifyError> {
        let mut rerun = Rerun::new(source.prepared(interrupt)?, interrupt);
        rerun.last = is_unfinished.then_some((readable.last, Outcome::Interrupted));
        Ok(rerun)
    };
    let (physics, schema) = (provenance.physics_version, provenance.schema_version);
    let physics_version = source.own_physics_version();
    // The file contains the versions; therefore, a file of another version has other bytes.
    let has_same_versions =
        provenance.program_version == env!("CARGO_PKG_VERSION") && physics == physics_version;
    let finding = if !is_damaged && has_same_versions && has_same_bytes(rerun()?, path, on_frame)? {
        Finding::SameBytes { frames }
    } else {
        Finding::Messages(Box::new(compare_with_rerun(&source.recording, rerun()?, on_frame)?))
    };
    let manifest = source.recording.manifest();
    Ok(Verification {
        physics_version,
        key_fits: run_key(manifest, physics, schema).as_str() == provenance.run_key,
        reinterpreted: differing_keys(manifest, &source.manifest.canonical()),
        finding,
        recording: source.recording,
    })
}

/// The readable part of a recording, which has a frame.
fn readable_part(source: &Source, interrupt: &Interrupt) -> Result<ReadablePart, VerifyError> {
    let readable = ReadablePart::of(source, interrupt)?;
    match readable.damage {
        Some(error) if readable.frames == 0 => Err(error.into()),
        None if readable.frames == 0 => {
            let fault = ReadFault::Damaged { byte: 0, what: "it has no frame".to_owned() };
            Err(unreadable(source.recording.path(), fault))
        }
        _ => Ok(readable),
    }
}

fn unreadable(path: &Path, fault: ReadFault) -> VerifyError {
    VerifyError::Read(ReadError { path: path.to_owned(), intact_frames: 0, fault })
}

/// Whether a rerun has the bytes of a file. It stops at the first byte that differs.
fn has_same_bytes(
    rerun: Rerun<'_>,
    path: &Path,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<bool, VerifyError> {
    let failed = |error| unreadable(path, ReadFault::Io(error));
    let (expected, _) = regular_file::open(path).map_err(failed)?;
    let sink =
        ByteComparison { expected: BufReader::new(expected), part: vec![0; COMPARED_AT_ONCE] };
    match rerun.record(sink, on_frame, |_| Ok(())) {
        Ok(recorded) => {
            let ByteComparison { mut expected, mut part } = recorded.sink;
            Ok(expected.read(&mut part).map_err(failed)? == 0)
        }
        // The sink fails where the bytes differ. The comparison of the messages reports any other error again.
        Err(VerifyError::Write(_)) => Ok(false),
        Err(error) => Err(error),
    }
}

/// Records a rerun to a temporary file and compares the messages.
fn compare_with_rerun(
    recording: &Recording,
    rerun: Rerun<'_>,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<Comparison, VerifyError> {
    let file = tempfile::Builder::new()
        .prefix("kinetoscope-")
        .suffix(".mcap")
        .tempfile()
        .map_err(VerifyError::Temporary)?;
    let sink = file.as_file().try_clone().map_err(VerifyError::Temporary)?;
    let recorded = rerun.record(BufWriter::new(sink), on_frame, |_| Ok(()));
    let mut recorded = recorded.map_err(|error| match error {
        VerifyError::Write(RecordError::Io(source)) => VerifyError::Temporary(source),
        other => other,
    })?;
    recorded.sink.flush().map_err(VerifyError::Temporary)?;
    drop(recorded);
    Ok(compare_messages(recording, &Recording::open(file.path())?)?)
}

/// A sink that compares the written bytes with a file and fails at the first difference.
struct ByteComparison {
    expected: BufReader<File>,
    part: Vec<u8>,
}

impl Write for ByteComparison {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let wanted = bytes.len().min(self.part.len());
        let count = self.expected.read(&mut self.part[..wanted])?;
        if self.part[..count] != bytes[..count] || (count == 0 && wanted > 0) {
            return Err(io::Error::other("the bytes differ"));
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
