//! The side file of a run under way: what it goes on from after a kill. It is replaced as a whole and leaves no trace in
//! the recording.
//!
//! Layout: magic, version (u32), length of the identity (u32), identity, length of the content (u64), content, CRC-32 of
//! all before it; numbers in little-endian order. The content is postcard's encoding, which keeps every bit of an f64.

use crate::error::RecordError;
use crate::file::{at, sync_folder};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File};
use std::io::{self, BufWriter, IntoInnerError, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"\x89KINCKP\n";
/// Raised when the layout changes, in the file or of the recorder's part of the content.
const VERSION: u32 = 1;
const CHECKSUM_BYTES: usize = 4;
/// Bytes that go to the disk at once.
const PIECE: usize = 1 << 20;

/// Name of a recording's checkpoint.
#[must_use]
pub fn path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.checkpoint"))
}

/// Replaces the checkpoint: afterward the old one or the new one is there, whatever happens meanwhile. `identity` says
/// what the content belongs to: run key, program and physics version.
///
/// # Errors
/// A disk that fails.
pub fn write(
    folder: &Path,
    stem: &str,
    identity: &str,
    content: &impl Serialize,
) -> Result<(), RecordError> {
    let path = path(folder, stem);
    let temporary = folder.join(format!("{stem}.checkpoint.tmp"));
    let replace = || {
        let file = write_into(File::create(&temporary)?, identity, content)?;
        file.sync_all()?;
        fs::rename(&temporary, &path)
    };
    replace().map_err(|error| at(&path, &error))?;
    sync_folder(&path)
}

/// The content of the checkpoint; `None` where there is none.
///
/// # Errors
/// A checkpoint that can't be read, is damaged, or belongs to something else.
pub fn read<C: DeserializeOwned>(
    folder: &Path,
    stem: &str,
    identity: &str,
) -> Result<Option<C>, RecordError> {
    let path = path(folder, stem);
    let bytes = match fs::read(&path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(at(&path, &error)),
    };
    decode(&bytes, identity)
        .map(Some)
        .map_err(|what| RecordError::NotContinued { path, what: what.to_owned() })
}

/// Removes the checkpoint and what a kill left of a new one.
///
/// # Errors
/// A folder that can't be written.
pub fn remove(folder: &Path, stem: &str) -> Result<(), RecordError> {
    for path in [path(folder, stem), folder.join(format!("{stem}.checkpoint.tmp"))] {
        match fs::remove_file(&path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(at(&path, &error)),
        }
    }
    Ok(())
}

/// How many bytes a content takes in a checkpoint, counted without writing them.
///
/// # Errors
/// Content that can't be encoded: a defect of the program.
pub fn size(content: &impl Serialize) -> Result<u64, RecordError> {
    let size = postcard::experimental::serialized_size(content);
    size.map(|size| size as u64).map_err(|error| RecordError::Container(defect(error).to_string()))
}

/// The bytes of a checkpoint.
///
/// # Errors
/// Content that can't be encoded: a defect of the program.
pub fn encode(identity: &str, content: &impl Serialize) -> Result<Vec<u8>, RecordError> {
    let bytes = write_into(Vec::new(), identity, content);
    bytes.map_err(|error| RecordError::Container(error.to_string()))
}

/// Writes a checkpoint piece by piece: a copy of a large run may have no room beside it.
fn write_into<W: Write>(sink: W, identity: &str, content: &impl Serialize) -> io::Result<W> {
    let length = postcard::experimental::serialized_size(content).map_err(defect)? as u64;
    let checked = Checked { sink, checksum: crc32fast::Hasher::new(), failure: None };
    let mut pieces = BufWriter::with_capacity(PIECE, checked);
    pieces.write_all(&MAGIC)?;
    pieces.write_all(&VERSION.to_le_bytes())?;
    pieces.write_all(&(identity.len() as u32).to_le_bytes())?;
    pieces.write_all(identity.as_bytes())?;
    pieces.write_all(&length.to_le_bytes())?;
    if let Err(error) = postcard::to_io(content, &mut pieces) {
        return Err(pieces.get_mut().failure.take().unwrap_or_else(|| defect(error)));
    }
    let Checked { mut sink, checksum, .. } =
        pieces.into_inner().map_err(IntoInnerError::into_error)?;
    sink.write_all(&checksum.finalize().to_le_bytes())?;
    Ok(sink)
}

/// Counts up the checksum of what goes through, and keeps why it could not: the encoder does not say.
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

/// The content of a checkpoint's bytes. Nothing is allocated that the bytes do not justify.
///
/// # Errors
/// What is wrong with the bytes.
pub fn decode<C: DeserializeOwned>(bytes: &[u8], identity: &str) -> Result<C, &'static str> {
    let damaged = "the checkpoint is damaged";
    let (checked, checksum) = bytes.split_last_chunk::<CHECKSUM_BYTES>().ok_or(damaged)?;
    if !checked.starts_with(&MAGIC) {
        return Err("it is no checkpoint");
    }
    if crc32fast::hash(checked) != u32::from_le_bytes(*checksum) {
        return Err(damaged);
    }
    let rest = &checked[MAGIC.len()..];
    let (version, rest) = rest.split_first_chunk().ok_or(damaged)?;
    if u32::from_le_bytes(*version) != VERSION {
        return Err("the checkpoint has the layout of another version of the program");
    }
    let (length, rest) = rest.split_first_chunk().ok_or(damaged)?;
    let (found, rest) =
        rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or(damaged)?;
    if found != identity.as_bytes() {
        return Err("the checkpoint belongs to another run or another version of the program");
    }
    let (length, content) = rest.split_first_chunk().ok_or(damaged)?;
    if u64::from_le_bytes(*length) != content.len() as u64 {
        return Err(damaged);
    }
    postcard::from_bytes(content).map_err(|_| damaged)
}
