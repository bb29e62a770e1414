//! A recording is verified by doing its run again, from the manifest that it carries.

pub mod attestation;
pub mod compare;
pub mod diff;

use crate::interrupt::Interrupt;
use crate::plan::restart_files::StartFiles;
use crate::run::checkpoint::NoCheckpoints;
use crate::run::prepared::Prepared;
use crate::run::{RunError, record_frames, record_start};
use crate::verify::diff::{Comparison, compare_messages};
use kinetoscope_manifest::{KeyDifference, RunManifest, differing_keys, parse_run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::error::{ReadError, ReadFault, RecordError};
use kinetoscope_recording::reader::{Outcome, Recording};
use kinetoscope_recording::recorder::Recorder;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes of the recording that are compared at once.
const COMPARED_AT_ONCE: usize = 1 << 16;

/// What came of doing a recording's run again.
#[derive(Debug)]
pub struct Verification {
    /// What the file says of itself.
    pub recording: Recording,
    /// The physics version of this program.
    pub physics_version: u32,
    /// Whether the run key follows from the embedded manifest and the recorded versions.
    pub key_fits: bool,
    /// Keys that this version of the program reads otherwise than they stand in the file, such as one that is new.
    pub reinterpreted: Vec<KeyDifference>,
    /// How far the file goes along with the re-run.
    pub finding: Finding,
}

/// How far a file goes along with its re-run.
#[derive(Debug)]
pub enum Finding {
    /// Every byte is the same.
    SameBytes {
        /// Frames of the file.
        frames: u64,
    },
    /// Bytes differ; so much the messages say, the file on the left and the re-run on the right.
    Messages(Box<Comparison>),
}

/// Why a recording can't be verified.
#[derive(Debug)]
pub enum VerifyError {
    /// It can't be read, or holds no frame.
    Read(ReadError),
    /// This version of the program does not understand its manifest, with all that is wrong with it.
    Manifest(String),
    /// The recording that the run began with is not there.
    Start(String),
    /// The re-run does not start.
    Run(RunError),
    /// The temporary file of the re-run failed.
    Temporary(io::Error),
    /// A signal came.
    Interrupted(u8),
}

impl fmt::Display for VerifyError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(error) => error.fmt(formatter),
            Self::Manifest(errors) => write!(
                formatter,
                "this version does not understand the manifest in the recording; verify it with the version that wrote it\n{errors}"
            ),
            Self::Start(why) => {
                write!(formatter, "the run began where another recording ends: {why}")
            }
            Self::Run(error) => write!(formatter, "the re-run failed: {error}"),
            Self::Temporary(error) => write!(
                formatter,
                "cannot write the re-run to {}: {error}. Free some space there, or name another folder in TMPDIR",
                std::env::temp_dir().display()
            ),
            Self::Interrupted(_) => {
                formatter.write_str("Stopped before the end: nothing is said of the recording")
            }
        }
    }
}

impl std::error::Error for VerifyError {}

impl From<ReadError> for VerifyError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

/// Does the run of a recording again and compares: first the bytes as they come, which needs no disk; where they differ,
/// message by message with a temporary recording. Of a damaged or unfinished file the intact frames are compared.
///
/// # Errors
/// A file without a readable frame, a manifest that is not understood, a re-run that does not start, or an interruption.
pub fn verify(
    path: &Path,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<Verification, VerifyError> {
    let recording = Recording::open(path)?;
    let mut manifest = parse_run(recording.manifest())
        .map_err(|diagnostics| VerifyError::Manifest(diagnostics.render(false)))?;
    let starts = StartFiles::relative_to(&folder_of(path));
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
    // The versions stand in the file, so that a file of another version has other bytes.
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

/// The folder of a file, as an absolute path where there is one, so that it has folders beside it.
fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
    folder.canonicalize().unwrap_or(folder)
}

/// What of a file can be read.
#[derive(Clone, Copy)]
struct IntactPart {
    frames: u64,
    damaged: bool,
}

fn intact_part(recording: &Recording) -> Result<IntactPart, ReadError> {
    let mut frames = 0;
    for frame in recording.frames()? {
        match frame {
            Ok(_) => frames += 1,
            Err(error) if frames == 0 => return Err(error),
            Err(_) => return Ok(IntactPart { frames, damaged: true }),
        }
    }
    Ok(IntactPart { frames, damaged: false })
}

/// A run that is done again, for as many frames as there are to compare with.
struct Rerun<'a> {
    recording: &'a Recording,
    manifest: &'a RunManifest,
    extent: IntactPart,
    interrupt: &'a Interrupt,
    on_frame: &'a (dyn Fn(u64, u64) + Sync),
}

impl Rerun<'_> {
    /// Whether the re-run has the bytes of the file. It is given up at the first byte that differs.
    fn has_same_bytes(&self, path: &Path) -> Result<bool, VerifyError> {
        let differs = Arc::new(AtomicBool::new(false));
        let expected = File::open(path).map_err(|error| self.unreadable(error))?;
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

    /// Records the re-run to a temporary file and compares the messages.
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

    fn record_into<W: Write + Send + 'static>(&self, sink: W) -> Result<W, VerifyError> {
        let interrupt = self.interrupt.with_own_stop();
        let unfinished = self.extent.damaged
            || self.recording.provenance().outcome == Some(Outcome::Interrupted);
        let last = self.extent.frames - 1;
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
        let recorded = self.replay_into(sink, &interrupt, &on_frame);
        if let Some(code) = interrupt.exit_code() {
            return Err(VerifyError::Interrupted(code));
        }
        recorded.map_err(VerifyError::Run)
    }

    /// Executes the run again and records it into a sink, which is returned.
    fn replay_into<W: Write + Send + 'static>(
        &self,
        sink: W,
        interrupt: &Interrupt,
        on_frame: &(dyn Fn(u64, u64) + Sync),
    ) -> Result<W, RunError> {
        let run_key = &self.recording.provenance().run_key;
        let start = Prepared::new(self.manifest, self.recording.manifest(), run_key)?;
        let recorder = Recorder::create(sink, &start.header)?;
        let mut state = record_start(start, recorder)?;
        let outcome = record_frames(&mut state, &mut NoCheckpoints, interrupt, on_frame)?;
        Ok(state.recorder.finish(&outcome)?)
    }

    fn unreadable(&self, source: io::Error) -> VerifyError {
        VerifyError::Read(ReadError {
            path: self.recording.path().to_path_buf(),
            intact_frames: 0,
            fault: ReadFault::Io(source),
        })
    }
}

/// Compares what is written with what a file holds, and refuses the first byte that differs.
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
