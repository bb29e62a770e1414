//! Reader of a recording: its manifest, provenance and frames. All contents of the file are checked before use.

pub use crate::frames::Frames;
pub use crate::provenance::{Outcome, Provenance};
pub use crate::recorded_frame::{RecordedFrame, RecordedMessage};
pub use crate::stored_frames::StoredFrames;
pub use crate::table::StateTable;

use crate::channels::SCHEMA_VERSION;
use crate::container::{Broken, Fields, MAGIC, PREFIX, Records, attachment, metadata};
use crate::data_section::DataSection;
use crate::error::{ReadError, ReadFault};
use crate::limits::ChunkLimits;
use crate::provenance::{
    LIBRARY, MANIFEST_ATTACHMENT, MERGED_RECORD, OUTCOME_RECORD, PROVENANCE_RECORD,
};
use crate::record_kind as kind;
use crate::storage::{InMemory, Input, LocalFolders, Opened, Storage};
use kinetoscope_files::regular_file::has_writer;
use std::fs::File;
use std::io::{self, BufReader, Seek as _, SeekFrom};
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::SystemTime;

/// Bytes of the footer and the magic after it.
const TAIL: u64 = PREFIX + 20 + MAGIC.len() as u64;
/// Maximum number of threads; more would wait for the thread that reads the file and decodes the frames.
const MOST_THREADS: NonZeroUsize = NonZeroUsize::new(4).unwrap();

/// A recording, opened.
#[derive(Clone, Debug)]
pub struct Recording {
    storage: Arc<dyn Storage>,
    path: Arc<Path>,
    changed: Option<SystemTime>,
    bytes: u64,
    manifest: String,
    provenance: Provenance,
    state_columns: Arc<[String]>,
    max_particles: Option<u64>,
}

impl Recording {
    /// Reads the manifest, the provenance and, if the file is complete, the outcome.
    ///
    /// # Errors
    /// A file that cannot be read, is not a recording of this program, or is damaged at its start.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_in(Arc::new(LocalFolders), path)
    }

    /// As [`Recording::open`], from another storage.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn open_in(storage: Arc<dyn Storage>, path: &Path) -> Result<Self, ReadError> {
        let Opened { input, bytes, changed } = opened(storage.as_ref(), path)?;
        let mut records = Records::new(BufReader::new(input), 0, bytes);
        let fault = |fault| ReadError { path: path.to_path_buf(), intact_frames: 0, fault };
        let mut is_own = false;
        let head = match read_head(&mut records, &mut is_own) {
            // Another program may use the names of our records for something else.
            Err(Broken::Damaged(_)) if !is_own => None,
            head => head.map_err(|broken| ReadError::new(path, 0, records.position(), broken))?,
        };
        let Some((manifest, mut provenance)) = head else { return Err(fault(ReadFault::Foreign)) };
        if provenance.schema_version != SCHEMA_VERSION {
            return Err(fault(ReadFault::OtherSchema { found: provenance.schema_version }));
        }
        // If the end cannot be read, the iteration over the frames reports the error.
        provenance.outcome = read_outcome(records.into_input(), bytes).unwrap_or(None);
        let state_columns = provenance.state_columns.clone().into();
        let path = path.into();
        let max_particles = None;
        Ok(Self {
            storage,
            path,
            changed,
            bytes,
            manifest,
            provenance,
            state_columns,
            max_particles,
        })
    }

    /// Limits the size of frames to that of so many particles, as the manifest states it: a chunk that claims more is damaged, and
    /// no memory is spent on it.
    #[must_use]
    pub fn with_max_particles(self, max_particles: u64) -> Self {
        Self { max_particles: Some(max_particles), ..self }
    }

    /// Opens a recording in memory. `path` names it in errors.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<Self, ReadError> {
        Self::open_in(Arc::new(InMemory(bytes.into())), path)
    }

    /// Writes the recording to a new file, byte for byte. An existing file is never overwritten: it may be this recording.
    ///
    /// # Errors
    /// A recording that cannot be read, or a file that exists or cannot be written.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        self.write_to(&mut File::create_new(path)?)
    }

    /// Writes the recording byte for byte.
    ///
    /// # Errors
    /// A recording that cannot be read, or an output that cannot be written.
    pub fn write_to(&self, output: &mut impl io::Write) -> io::Result<()> {
        io::copy(&mut self.storage.open(&self.path)?.input, output)?;
        Ok(())
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's size in bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Time of the last change of the file, if known.
    #[must_use]
    pub fn changed(&self) -> Option<SystemTime> {
        self.changed
    }

    /// The canonical manifest of the run.
    #[must_use]
    pub fn manifest(&self) -> &str {
        &self.manifest
    }

    /// The origin of the recording and the outcome of the run.
    #[must_use]
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Names of the state's columns.
    #[must_use]
    pub fn state_columns(&self) -> &[String] {
        &self.state_columns
    }

    /// The frames from the start, decompressed by a suitable number of threads. The file is intact only if the iterator ends
    /// without an error.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn frames(&self) -> Result<Frames, ReadError> {
        let cores = available_parallelism().unwrap_or(NonZeroUsize::MIN);
        self.frames_on(if cores < MOST_THREADS { cores } else { MOST_THREADS })
    }

    /// The frames from the start, of the bytes that the file had when it was opened. Up to `threads` threads decompress chunks in addition to the caller's thread; with 1, only
    /// the caller's thread does. Frames and errors do not depend on the number.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn frames_on(&self, threads: NonZeroUsize) -> Result<Frames, ReadError> {
        let Opened { input, bytes, .. } = opened(self.storage.as_ref(), &self.path)?;
        let bytes = bytes.min(self.bytes);
        let chunks = ChunkLimits::new(self.max_particles, self.state_columns.len());
        let data = DataSection::new(Records::new(BufReader::new(input), 0, bytes), threads, chunks);
        let (path, columns) = (Arc::clone(&self.path), Arc::clone(&self.state_columns));
        let Provenance { stored, outcome, .. } = &self.provenance;
        let max_block_bytes = chunks.max_content_bytes();
        Ok(Frames::new(data, max_block_bytes, path, columns, *stored, outcome.clone()))
    }
}

impl ReadError {
    pub(crate) fn new(path: &Path, intact_frames: u64, byte: u64, broken: Broken) -> Self {
        let fault = match broken {
            Broken::Io(source) => ReadFault::Io(source),
            Broken::Torn if has_writer(path) => ReadFault::Growing { byte },
            Broken::Torn => ReadFault::Torn { byte },
            Broken::Damaged(what) => ReadFault::Damaged { byte, what },
            Broken::NotMcap => ReadFault::NotMcap,
            Broken::Merged => ReadFault::Merged,
        };
        Self { path: path.to_path_buf(), intact_frames, fault }
    }
}

fn opened(storage: &dyn Storage, path: &Path) -> Result<Opened, ReadError> {
    storage.open(path).map_err(|source| ReadError::new(path, 0, 0, Broken::Io(source)))
}

/// The manifest and the provenance, which precede the first frame; `None` if they are missing. `is_own` is set if the file names
/// this program as its writer.
fn read_head(
    records: &mut Records<BufReader<Box<dyn Input>>>,
    is_own: &mut bool,
) -> Result<Option<(String, Provenance)>, Broken> {
    records.magic()?;
    let (mut manifest, mut provenance) = (None, None);
    let mut body = Vec::new();
    while manifest.is_none() || provenance.is_none() {
        let prefix = records.prefix()?;
        match prefix.kind {
            kind::ATTACHMENT => {
                records.body(prefix, &mut body)?;
                let (name, content) = attachment(&body)?;
                if name == MANIFEST_ATTACHMENT {
                    let text = String::from_utf8(content.to_vec());
                    manifest =
                        Some(text.map_err(|_| {
                            Broken::Damaged("the manifest is not UTF-8".to_owned())
                        })?);
                }
            }
            kind::METADATA => {
                records.body(prefix, &mut body)?;
                let (name, entries) = metadata(&body)?;
                if name == MERGED_RECORD {
                    return Err(Broken::Merged);
                }
                if name == PROVENANCE_RECORD {
                    let read = Provenance::from_metadata(&entries);
                    let read = read.ok_or_else(|| {
                        Broken::Damaged("the provenance is incomplete".to_owned())
                    })?;
                    // Other schema versions may have other forms.
                    let is_current = read.schema_version == SCHEMA_VERSION;
                    if let Some(defect) = read.defect().filter(|_| is_current) {
                        return Err(Broken::Damaged(defect));
                    }
                    provenance = Some(read);
                }
            }
            kind::HEADER => {
                records.body(prefix, &mut body)?;
                let mut fields = Fields(&body);
                *is_own = fields.string()?.is_empty() && fields.string()?.starts_with(LIBRARY);
            }
            _ => return Ok(None),
        }
    }
    Ok(manifest.zip(provenance))
}

/// Finds the outcome through the footer and the index of the summary; `None` if the file has no footer.
fn read_outcome(mut file: BufReader<Box<dyn Input>>, end: u64) -> Result<Option<Outcome>, Broken> {
    let Some(tail) = end.checked_sub(TAIL) else { return Ok(None) };
    file.seek(SeekFrom::Start(tail))?;
    let mut footer = Records::new(&mut file, tail, end);
    if footer.prefix()?.kind != kind::FOOTER {
        return Ok(None);
    }
    let summary_start = u64::from_le_bytes(footer.array()?);
    if summary_start > tail {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(summary_start))?;
    let mut summary = Records::new(&mut file, summary_start, tail);
    let mut body = Vec::new();
    let mut place = None;
    while summary.position() < tail {
        let prefix = summary.prefix()?;
        if prefix.kind == kind::METADATA_INDEX {
            summary.body(prefix, &mut body)?;
            let mut fields = Fields(&body);
            let (offset, _length) = (fields.u64()?, fields.u64()?);
            if fields.string()? == OUTCOME_RECORD {
                place = Some(offset);
            }
        } else {
            summary.skip(prefix)?;
        }
    }
    let Some(place) = place.filter(|&place| place < summary_start) else { return Ok(None) };
    file.seek(SeekFrom::Start(place))?;
    let mut record = Records::new(&mut file, place, summary_start);
    let prefix = record.prefix()?;
    record.body(prefix, &mut body)?;
    let (name, entries) = metadata(&body)?;
    // The record is the last one before the summary: behind a hole of a sparse file, there is no end.
    let last = record.prefix()?;
    if last.kind != kind::DATA_END || record.position() + last.length != summary_start {
        return Ok(None);
    }
    Ok(Outcome::from_metadata(&entries)
        .filter(|_| prefix.kind == kind::METADATA && name == OUTCOME_RECORD))
}
