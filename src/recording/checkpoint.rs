//! The checkpoint of a run in progress, from which the run resumes after a kill. The file is replaced as a whole; it leaves no
//! trace in the recording.
//!
//! Layout: magic, version (u32), length of the identity (u32), identity, length of the content (u64), content, CRC-32 of
//! all preceding bytes; numbers in little-endian order. The content is one or more parts in
//! postcard's encoding, which keeps every bit of an f64.

use crate::error::RecordError;
use crate::file::at;
use kinetoscope_files::atomic_file::{remove_if_exists, replace_locked, temporary_path};
use kinetoscope_files::regular_file;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::{self, BufWriter, IntoInnerError, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"\x89KINCKP\n";
/// Raised when the layout changes, in the file or of the recorder's part of the content.
const VERSION: u32 = 3;
const CHECKSUM_BYTES: usize = 4;
const DAMAGED: &str = "the checkpoint is damaged";
/// The content of an intact file that cannot be decoded: a part has another layout, or the file was forged.
const OTHER_LAYOUT: &str = "the checkpoint is of another version of the program, whose state has another layout, or damaged";
/// Bytes that go to the disk at once.
const PIECE: usize = 1 << 20;

/// A page has no file for a checkpoint: its engine does not contain the code that encodes the states of all models.
const HAS_FILES: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

/// Name of a recording's checkpoint.
#[must_use]
pub fn path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.checkpoint"))
}

/// A part of a checkpoint's content. Every serializable type is one; `dyn Content` needs no type parameter.
pub trait Content {
    /// Number of bytes that the part takes, counted without writing them.
    ///
    /// # Errors
    /// A part that cannot be encoded: a defect of the program.
    fn encoded_size(&self) -> postcard::Result<u64>;

    /// Writes the part to a sink.
    ///
    /// # Errors
    /// A part that cannot be encoded, or a sink that fails.
    fn encode_into(&self, sink: &mut dyn Write) -> postcard::Result<()>;
}

impl<T: Serialize> Content for T {
    fn encoded_size(&self) -> postcard::Result<u64> {
        let size = if HAS_FILES { postcard::experimental::serialized_size(self)? } else { 0 };
        Ok(size as u64)
    }

    fn encode_into(&self, sink: &mut dyn Write) -> postcard::Result<()> {
        if HAS_FILES { postcard::to_io(self, sink).map(drop) } else { Ok(()) }
    }
}

/// Decodes one part of a checkpoint's content; `None` if the bytes are damaged.
#[must_use]
pub fn decode_content<C: DeserializeOwned>(bytes: &[u8]) -> Option<C> {
    postcard::from_bytes(bytes).ok()
}

/// Decodes the first part of a checkpoint's content and returns it with the bytes of the next parts; `None` if the bytes are
/// damaged.
#[must_use]
pub fn decode_head<C: DeserializeOwned>(bytes: &[u8]) -> Option<(C, &[u8])> {
    postcard::take_from_bytes(bytes).ok()
}

/// Number of bytes that a part takes in a checkpoint.
///
/// # Errors
/// A part that cannot be encoded: a defect of the program.
pub fn size(part: &dyn Content) -> Result<u64, RecordError> {
    part.encoded_size().map_err(|error| RecordError::Container(defect(error).to_string()))
}

/// Replaces the checkpoint as a whole: afterward, the old one or the new one exists, whatever happens meanwhile. `identity`
/// is what the content belongs to: run key, program and physics version. The parts are written one after the other.
///
/// # Errors
/// A disk that fails.
pub fn write(
    folder: &Path,
    stem: &str,
    identity: &str,
    parts: &[&dyn Content],
) -> Result<(), RecordError> {
    let path = path(folder, stem);
    replace_locked(&path, |file| write_into(file, identity, parts))
        .map_err(|error| at(&path, &error))
}

/// Reads a checkpoint of at most `max_bytes`; `None` if there is none. `decode` makes a value of the content's bytes, `None` if
/// they have another layout or are damaged.
///
/// # Errors
/// A checkpoint that cannot be read, is too large, is damaged, or belongs to another run or version.
pub fn read<C>(
    folder: &Path,
    stem: &str,
    identity: &str,
    max_bytes: u64,
    decode: impl FnOnce(&[u8]) -> Option<C>,
) -> Result<Option<C>, RecordError> {
    let path = path(folder, stem);
    let bytes = match regular_file::read(&path, max_bytes) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(at(&path, &error)),
    };
    content(&bytes, identity)
        .and_then(|content| decode(content).ok_or(OTHER_LAYOUT))
        .map(Some)
        .map_err(|what| RecordError::NotContinued { path, what: what.to_owned() })
}

/// Whether there is a checkpoint, or what a kill left of a new one.
pub(crate) fn exists(folder: &Path, stem: &str) -> bool {
    let path = path(folder, stem);
    [temporary_path(&path), path].iter().any(|path| path.symlink_metadata().is_ok())
}

/// Removes the checkpoint and what a kill left of a new one.
///
/// # Errors
/// A folder that cannot be written.
pub fn remove(folder: &Path, stem: &str) -> Result<(), RecordError> {
    let path = path(folder, stem);
    for path in [temporary_path(&path), path] {
        remove_if_exists(&path).map_err(|error| at(&path, &error))?;
    }
    Ok(())
}

/// The bytes of a checkpoint.
///
/// # Errors
/// Content that cannot be encoded: a defect of the program.
pub fn encode(identity: &str, parts: &[&dyn Content]) -> Result<Vec<u8>, RecordError> {
    let bytes = write_into(Vec::new(), identity, parts);
    bytes.map_err(|error| RecordError::Container(error.to_string()))
}

/// Writes a checkpoint piece by piece, because memory may have no room for a copy of a large run.
fn write_into<W: Write>(sink: W, identity: &str, parts: &[&dyn Content]) -> io::Result<W> {
    let sizes = parts.iter().map(|part| part.encoded_size());
    let length = sizes.sum::<postcard::Result<u64>>().map_err(defect)?;
    let checked = Checked { sink, checksum: crc32fast::Hasher::new(), failure: None };
    let mut pieces = BufWriter::with_capacity(PIECE, checked);
    pieces.write_all(&MAGIC)?;
    pieces.write_all(&VERSION.to_le_bytes())?;
    pieces.write_all(&(identity.len() as u32).to_le_bytes())?;
    pieces.write_all(identity.as_bytes())?;
    pieces.write_all(&length.to_le_bytes())?;
    for part in parts {
        if let Err(error) = part.encode_into(&mut pieces) {
            return Err(pieces.get_mut().failure.take().unwrap_or_else(|| defect(error)));
        }
    }
    let Checked { mut sink, checksum, .. } =
        pieces.into_inner().map_err(IntoInnerError::into_error)?;
    sink.write_all(&checksum.finalize().to_le_bytes())?;
    Ok(sink)
}

/// Computes the checksum of the bytes written, and keeps the error of a failed write, which the encoder does not report.
struct Checked<W> {
    sink: W,
    checksum: crc32fast::Hasher,
    failure: Option<io::Error>,
}

impl<W: Write> Write for Checked<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match self.sink.write(bytes) {
            Ok(written) => written,
            Err(error) => {
                let kind = error.kind();
                self.failure = Some(error);
                return Err(kind.into());
            }
        };
        self.checksum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

fn defect(error: postcard::Error) -> io::Error {
    io::Error::other(format!("a checkpoint: {error}"))
}

/// Checks a checkpoint's bytes and returns its content.
///
/// # Errors
/// What is wrong with the bytes.
pub fn content<'a>(bytes: &'a [u8], identity: &str) -> Result<&'a [u8], &'static str> {
    let (checked, checksum) = bytes.split_last_chunk::<CHECKSUM_BYTES>().ok_or(DAMAGED)?;
    if !checked.starts_with(&MAGIC) {
        return Err("the file is not a checkpoint");
    }
    if crc32fast::hash(checked) != u32::from_le_bytes(*checksum) {
        return Err(DAMAGED);
    }
    let rest = &checked[MAGIC.len()..];
    let (version, rest) = rest.split_first_chunk().ok_or(DAMAGED)?;
    if u32::from_le_bytes(*version) != VERSION {
        return Err("the checkpoint has the layout of another version of the program");
    }
    let (length, rest) = rest.split_first_chunk().ok_or(DAMAGED)?;
    let (found, rest) =
        rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or(DAMAGED)?;
    if found != identity.as_bytes() {
        return Err("the checkpoint belongs to another run or another version of the program");
    }
    let (length, content) = rest.split_first_chunk().ok_or(DAMAGED)?;
    if u64::from_le_bytes(*length) != content.len() as u64 {
        return Err(DAMAGED);
    }
    Ok(content)
}
