//! Verification of a recording: its run is executed again from the embedded manifest, and the bytes or messages are compared.

mod check_thread;
pub mod compare;
pub mod diff;
pub mod divergence;
pub mod fill;
pub mod fine_frames;
pub mod fingerprint;
mod keyframe_search;
pub mod lock_file;
pub mod merge;
mod rerun_check;
pub mod restore;
pub mod zoom;

use crate::interrupt::Interrupt;
use crate::plan::restart_files::StartFiles;
use crate::run::prepared::Prepared;
use crate::run::recording;
use crate::run::{RunError, record_frames, record_start};
use crate::verify::diff::{Comparison, compare_messages};
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::regular_file;
use kinetoscope_manifest::{KeyDifference, RunManifest, differing_keys, parse_run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::error::{ReadError, ReadFault, RecordError};
use kinetoscope_recording::reader::{Outcome, Recording, StoredFrames};
use kinetoscope_recording::recorder::Recorder;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

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

/// The reason why a recording cannot be verified.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// The file cannot be read, or holds no frame.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// This version of the program does not accept the manifest; all errors are listed.
    #[error(
        "this version does not understand the manifest in the recording; verify it with the version that wrote it\n{0}"
    )]
    Manifest(String),
    /// The recording has only a part of its run.
    #[error("{path} is a part of a run: verify the recording of the whole run", path = shown_path(.0))]
    Part(PathBuf),
    /// The recording from which the run started is missing.
    #[error("the run started from another recording: {0}")]
    Start(String),
    /// The rerun does not start.
    #[error("the rerun failed: {0}")]
    Run(RunError),
    /// The temporary file of the rerun failed.
    #[error(
        "cannot write the rerun to {folder}: {source}; free some space there, or name another folder in TMPDIR",
        folder = shown_path(&std::env::temp_dir()),
        source = .0
    )]
    Temporary(io::Error),
    /// The program received a signal.
    #[error("stopped before the end, the recording is not verified; run the same command again")]
    Interrupted(u8),
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
    let recording = recording::open(path)?;
    if let StoredFrames::From(_) = recording.provenance().stored {
        return Err(VerifyError::Part(path.to_owned()));
    }
    let mut manifest = parse_run(recording.manifest())
        .map_err(|diagnostics| VerifyError::Manifest(diagnostics.render(false)))?;
    let starts = StartFiles::relative_to(folder_of(path));
    manifest.model.read_start(&|name: &str| starts.read(name)).map_err(VerifyError::Start)?;
    let provenance = recording.provenance();
    let (physics, layout) = (provenance.physics_version, provenance.schema_version);
    let rerun = Rerun {
        recording: &recording,
        manifest: &manifest,
        extent: intact_part(&recording)?,
        interrupt,
        on_frame,
    };
    // The file contains the versions; therefore, a file of another version has other bytes.
    let same_versions = provenance.program_version == env!("CARGO_PKG_VERSION")
        && physics == kind_of(&manifest.model).physics_version;
    let finding = if !rerun.extent.damaged && same_versions && rerun.has_same_bytes(path)? {
        Finding::SameBytes { frames: rerun.extent.frames }
    } else {
        Finding::Messages(Box::new(rerun.compare_messages()?))
    };
    Ok(Verification {
        physics_version: kind_of(&manifest.model).physics_version,
        key_fits: run_key(recording.manifest(), physics, layout).as_str() == provenance.run_key,
        reinterpreted: differing_keys(recording.manifest(), &manifest.canonical()),
        finding,
        recording,
    })
}

/// The readable part of a file.
#[derive(Clone, Copy)]
struct IntactPart {
    frames: u64,
    /// Index of the last frame.
    last: u64,
    damaged: bool,
}

fn intact_part(recording: &Recording) -> Result<IntactPart, ReadError> {
    let (mut frames, mut last) = (0, 0);
    for frame in recording.frames()? {
        match frame {
            Ok(frame) => (frames, last) = (frames + 1, frame.clock.frame),
            Err(error) if frames == 0 => return Err(error),
            Err(_) => return Ok(IntactPart { frames, last, damaged: true }),
        }
    }
    if frames == 0 {
        let fault = ReadFault::Damaged { byte: 0, what: "it has no frame".to_owned() };
        return Err(ReadError { path: recording.path().to_path_buf(), intact_frames: 0, fault });
    }
    Ok(IntactPart { frames, last, damaged: false })
}

/// A rerun, for as many frames as the file has.
struct Rerun<'a> {
    recording: &'a Recording,
    manifest: &'a RunManifest,
    extent: IntactPart,
    interrupt: &'a Interrupt,
    on_frame: &'a (dyn Fn(u64, u64) + Sync),
}

impl Rerun<'_> {
    /// Whether the rerun has the bytes of the file. It stops at the first byte that differs.
    fn has_same_bytes(&self, path: &Path) -> Result<bool, VerifyError> {
        let differs = Arc::new(AtomicBool::new(false));
        let (expected, _) = regular_file::open(path).map_err(|error| self.unreadable(error))?;
        let sink = ByteComparison {
            expected: BufReader::new(expected),
            part: vec![0; COMPARED_AT_ONCE],
            differs: Arc::clone(&differs),
        };
        match self.record_into(sink) {
            Ok(mut sink) => {
                let rest = sink.expected.read(&mut sink.part);
                Ok(rest.map_err(|error| self.unreadable(error))? == 0)
            }
            Err(VerifyError::Run(_)) if differs.load(Ordering::Relaxed) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Records the rerun to a temporary file and compares the messages.
    fn compare_messages(&self) -> Result<Comparison, VerifyError> {
        let file = tempfile::Builder::new()
            .prefix("kinetoscope-")
            .suffix(".mcap")
            .tempfile()
            .map_err(VerifyError::Temporary)?;
        let sink = file.as_file().try_clone().map_err(VerifyError::Temporary)?;
        let recorded = self.record_into(BufWriter::new(sink));
        let mut output = recorded.map_err(|error| match error {
            VerifyError::Run(RunError::Record(RecordError::Io(source))) => {
                VerifyError::Temporary(source)
            }
            other => other,
        })?;
        output.flush().map_err(VerifyError::Temporary)?;
        drop(output);
        let again = Recording::open(file.path())?;
        Ok(compare_messages(self.recording, &again)?)
    }

    /// Executes the run again and records it into a sink, which is returned.
    fn record_into<W: Write + Send + 'static>(&self, sink: W) -> Result<W, VerifyError> {
        let interrupt = self.interrupt.with_own_stop();
        let unfinished = self.extent.damaged
            || self.recording.provenance().outcome == Some(Outcome::Interrupted);
        let last = self.extent.last;
        let stop_at = |frame| {
            if unfinished && frame == last {
                interrupt.stop();
            }
        };
        stop_at(0);
        let on_frame = |done, of| {
            stop_at(done);
            (self.on_frame)(done, of);
        };
        let replay = || {
            let run_key = &self.recording.provenance().run_key;
            let start = Prepared::new(self.manifest, self.recording.manifest(), run_key)?;
            let recorder = Recorder::create(sink, &start.header)?;
            let mut state = record_start(start, recorder)?;
            let outcome = record_frames(&mut state, &interrupt, &on_frame, |_, _| Ok(()))?;
            Ok(state.recorder.finish(&outcome)?)
        };
        let recorded = replay();
        if let Some(code) = interrupt.exit_code() {
            return Err(VerifyError::Interrupted(code));
        }
        recorded.map_err(VerifyError::Run)
    }

    fn unreadable(&self, source: io::Error) -> VerifyError {
        VerifyError::Read(ReadError {
            path: self.recording.path().to_path_buf(),
            intact_frames: 0,
            fault: ReadFault::Io(source),
        })
    }
}

/// A sink that compares the written bytes with a file and fails at the first difference.
struct ByteComparison {
    expected: BufReader<File>,
    part: Vec<u8>,
    differs: Arc<AtomicBool>,
}

impl Write for ByteComparison {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let wanted = bytes.len().min(self.part.len());
        let count = self.expected.read(&mut self.part[..wanted])?;
        if self.part[..count] != bytes[..count] || (count == 0 && wanted > 0) {
            self.differs.store(true, Ordering::Relaxed);
            return Err(io::Error::other("the bytes differ"));
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
