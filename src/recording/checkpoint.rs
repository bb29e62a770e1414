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
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"\x89KINCKP\n";
/// Raised when the layout changes, in the file or of the recorder's part of the content.
const VERSION: u32 = 1;
const CHECKSUM_BYTES: usize = 4;

/// Name of a recording's checkpoint.
#[must_use]
pub fn path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.checkpoint"))
}

/// Replaces the checkpoint: afterwards the old one or the new one is there, whatever happens meanwhile. `identity` says
/// what the content belongs to: content key, program and physics version.
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
    let bytes = encode(identity, content)?;
    let temporary = folder.join(format!("{stem}.checkpoint.tmp"));
    let replace = || {
        let mut file = File::create(&temporary)?;
        file.write_all(&bytes)?;
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
    postcard::experimental::serialized_size(content).map(|size| size as u64).map_err(defect)
}

/// The bytes of a checkpoint.
///
/// # Errors
/// Content that can't be encoded: a defect of the program.
pub fn encode(identity: &str, content: &impl Serialize) -> Result<Vec<u8>, RecordError> {
    let content = postcard::to_stdvec(content).map_err(defect)?;
    let mut bytes = Vec::with_capacity(content.len() + identity.len() + 32);
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((identity.len() as u32).to_le_bytes());
    bytes.extend(identity.as_bytes());
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(content);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    Ok(bytes)
}

fn defect(error: postcard::Error) -> RecordError {
    RecordError::Container(format!("a checkpoint: {error}"))
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
