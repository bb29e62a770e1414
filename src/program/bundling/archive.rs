//! The ZIP file of a bundle. It is written with the same bytes for the same contents; what is read is checked as a whole before any
//! file is written, because a bundle may come from a stranger.

use super::seal::{Hasher, SEAL_BYTES, Sealed, is_intact};
use data_encoding::HEXLOWER;
use kinetoscope_console::text::one_line;
use kinetoscope_files::atomic_file::NewFile;
use kinetoscope_files::regular_file;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek as _, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// What the bundle is, for programs.
pub(super) const BUNDLE: &str = "bundle.json";
/// The folder of the results; those of each experiment are in a folder of its name, as those that were bundled.
pub(super) const RECORDINGS: &str = "recordings";
/// The packages of the program (CycloneDX).
pub(super) const PACKAGES: &str = "kinetoscope.cdx.json";
/// The list of all other files with their hashes, as `sha256sum --check` reads it.
pub(super) const SUMS: &str = "SHA256SUMS";
/// Maximum size of the list, and of any other file that is read into memory.
const MOST_TEXT_BYTES: u64 = 64 << 20;
/// The contents are at most this number of times as large as the file, and [`MOST_SMALL_BYTES`]: texts of results shrink by a factor of
/// 5 to 20, recordings by none. A file that unpacks to more fills a disk.
const MOST_RATIO: u64 = 100;
/// See [`MOST_RATIO`].
const MOST_SMALL_BYTES: u64 = 1 << 20;
/// Maximum size of all files that the ZIP file compresses. Recordings are not among them.
const MOST_COMPRESSED_BYTES: u64 = 1 << 30;
/// Maximum number of files: that of a ZIP file without the fields of large ones.
const MOST_FILES: usize = 65_535;
/// Maximum length of a name; longer ones cannot be written everywhere.
const LONGEST_NAME: usize = 200;
/// From this size on, the size needs the fields of large files.
const LARGE_BYTES: u64 = 1 << 31;

/// What a bundle contains of one file.
#[derive(Clone, Debug)]
pub(super) enum Content {
    /// A text that was made for the bundle.
    Text(String),
    /// A file of this machine.
    File(PathBuf),
}

/// The SHA-256 of a content, as hexadecimal digits.
pub(super) fn hash_of(content: &Content) -> io::Result<String> {
    let mut hash = Sha256::new();
    match content {
        Content::Text(text) => hash.update(text),
        Content::File(path) => {
            let (mut file, _) = regular_file::open(path)?;
            io::copy(&mut file, &mut Hasher(&mut hash))?;
        }
    }
    Ok(HEXLOWER.encode(&hash.finalize()))
}

/// Why a bundle cannot be used.
#[derive(Debug, Error)]
pub(super) enum ArchiveError {
    /// The file cannot be read or written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file is not a bundle, or not what it was when it was written.
    #[error("{0}")]
    Damaged(String),
}

impl From<zip::result::ZipError> for ArchiveError {
    fn from(error: zip::result::ZipError) -> Self {
        match error {
            zip::result::ZipError::Io(error) => Self::Io(error),
            other => Self::Damaged(format!("it is not an intact ZIP file: {other}")),
        }
    }
}

fn damaged(what: impl Into<String>) -> ArchiveError {
    ArchiveError::Damaged(what.into())
}

/// Writes a bundle: the files in the order of their names, their hashes at the end.
pub(super) fn write(path: &Path, files: &BTreeMap<String, Content>) -> Result<(), ArchiveError> {
    if let Some(name) = files.keys().find(|name| !is_safe(name)) {
        let what = format!("{} cannot be the name of a file on every system", one_line(name));
        return Err(damaged(what));
    }
    if files.len() >= MOST_FILES {
        return Err(damaged(format!("a bundle has at most {MOST_FILES} files")));
    }
    let mut zip = ZipWriter::new_stream(Sealed::new(NewFile::create(path)?));
    let mut sums = String::new();
    for (name, content) in files {
        let hash = match content {
            Content::Text(text) => add(&mut zip, name, text.as_bytes(), text.len() as u64)?,
            Content::File(file) => {
                let (file, metadata) = regular_file::open(file)?;
                add(&mut zip, name, BufReader::new(file), metadata.len())?
            }
        };
        sums += &format!("{hash}  {name}\n");
    }
    add(&mut zip, SUMS, sums.as_bytes(), sums.len() as u64)?;
    zip.set_comment("0".repeat(SEAL_BYTES))?;
    Ok(zip.finish()?.into_inner().finish()?.finish()?)
}

type Zip = ZipWriter<StreamWriter<Sealed<NewFile>>>;

/// Adds a file, and returns its hash.
fn add(zip: &mut Zip, name: &str, mut from: impl Read, bytes: u64) -> Result<String, ArchiveError> {
    // Recordings are compressed already.
    let method = match name.ends_with(".mcap") {
        true => CompressionMethod::Stored,
        false => CompressionMethod::Deflated,
    };
    let options = SimpleFileOptions::default()
        .compression_method(method)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o644)
        .large_file(bytes >= LARGE_BYTES);
    zip.start_file(name, options)?;
    let (mut hash, mut buffer) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        let count = match from.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error.into()),
        };
        hash.update(&buffer[..count]);
        zip.write_all(&buffer[..count])?;
    }
    Ok(HEXLOWER.encode(&hash.finalize()))
}

/// A bundle whose contents are those that were written.
pub(super) struct Archive {
    zip: ZipArchive<BufReader<File>>,
    /// The hashes of all files but that of their list, by name.
    pub(super) hashes: BTreeMap<String, String>,
}

impl Archive {
    /// Opens a bundle and checks all of it.
    pub(super) fn open(path: &Path) -> Result<Self, ArchiveError> {
        let (mut file, metadata) = regular_file::open(path)?;
        let is_sealed = is_intact(&mut file, metadata.len())?;
        file.rewind()?;
        let zip = ZipArchive::new(BufReader::new(file))?;
        let mut archive = Self { zip, hashes: BTreeMap::new() };
        archive.reject_hostile(metadata.len())?;
        archive.compare_with_sums()?;
        if !is_sealed {
            return Err(damaged(
                "all of its files are those that were written, but the ZIP file around them is not: it was packed again, or is damaged",
            ));
        }
        Ok(archive)
    }

    /// Rejects what could write outside of a folder, or fill a disk.
    fn reject_hostile(&mut self, bytes: u64) -> Result<(), ArchiveError> {
        if self.zip.len() > MOST_FILES {
            return Err(damaged(format!("it has more than {MOST_FILES} files")));
        }
        if self.zip.has_duplicate_names() || self.zip.has_overlapping_entries()? {
            return Err(damaged("some of its files have the same name or share bytes"));
        }
        // A program that reads the file from its start would find other files or other names.
        self.zip.validate_header_consistency()?;
        if self.zip.offset() != 0 {
            return Err(damaged("it does not begin with its first file"));
        }
        let (mut unpacked, mut compressed) = (0_u64, 0_u64);
        let mut seen = BTreeMap::new();
        for index in 0..self.zip.len() {
            let entry = self.zip.by_index(index)?;
            unpacked = unpacked.saturating_add(entry.size());
            if entry.compression() != CompressionMethod::Stored {
                compressed = compressed.saturating_add(entry.size());
            }
            let name = entry.name()?.into_owned();
            if !is_safe(&name) || !entry.is_file() {
                return Err(damaged(format!(
                    "it contains \"{}\", which is not a file below its own folder",
                    one_line(&name)
                )));
            }
            // A name in other letters is the same file on some systems.
            if let Some(other) = seen.insert(name.to_lowercase(), name.clone()) {
                return Err(damaged(format!(
                    "{} and {} differ only in case",
                    one_line(&other),
                    one_line(&name)
                )));
            }
        }
        let is_folder = |name: &String| {
            let above = name.match_indices('/').map(|(end, _)| &name[..end]);
            above.into_iter().any(|folder| seen.contains_key(folder))
        };
        if let Some(name) = seen.keys().find(|name| is_folder(name)) {
            return Err(damaged(format!("the folder of {} is a file", one_line(name))));
        }
        if unpacked > bytes.saturating_mul(MOST_RATIO).saturating_add(MOST_SMALL_BYTES) {
            return Err(damaged(format!(
                "its contents are more than {MOST_RATIO} times as large as the file"
            )));
        }
        if compressed > MOST_COMPRESSED_BYTES {
            let what = format!("its texts have more than {} MB", MOST_COMPRESSED_BYTES >> 20);
            return Err(damaged(what));
        }
        Ok(())
    }

    /// Compares all files with the list of their hashes.
    fn compare_with_sums(&mut self) -> Result<(), ArchiveError> {
        let sums = self.text(SUMS)?;
        let mut listed = BTreeMap::new();
        for line in sums.lines() {
            let (hash, name) =
                line.split_once("  ").ok_or_else(|| damaged(format!("{SUMS} is damaged")))?;
            if listed.insert(name, hash).is_some() {
                return Err(damaged(format!("{SUMS} lists {} twice", one_line(name))));
            }
        }
        for index in 0..self.zip.len() {
            let mut entry = self.zip.by_index(index)?;
            let (name, size) = (entry.name()?.into_owned(), entry.size());
            if name == SUMS {
                continue;
            }
            let Some(expected) = listed.remove(name.as_str()) else {
                return Err(damaged(format!(
                    "{} was added: {SUMS} does not list it",
                    one_line(&name)
                )));
            };
            let mut hash = Sha256::new();
            let read = io::copy(&mut entry.by_ref().take(size), &mut Hasher(&mut hash));
            if read.is_err() || HEXLOWER.encode(&hash.finalize()) != expected {
                return Err(damaged(format!(
                    "{} was changed: it has another hash than in {SUMS}",
                    one_line(&name)
                )));
            }
            self.hashes.insert(name, expected.to_owned());
        }
        match listed.first_key_value() {
            Some((name, _)) => {
                Err(damaged(format!("{} is missing: {SUMS} lists it", one_line(name))))
            }
            None => Ok(()),
        }
    }

    /// The text of a file of the bundle.
    pub(super) fn text(&mut self, name: &str) -> Result<String, ArchiveError> {
        let entry = self.zip.by_name(name).map_err(|error| match error {
            zip::result::ZipError::FileNotFound => {
                damaged(format!("it has no {name}, so that it is not a bundle"))
            }
            other => other.into(),
        })?;
        let mut text = String::new();
        let read = entry.take(MOST_TEXT_BYTES).read_to_string(&mut text);
        read.map_err(|error| damaged(format!("{name} cannot be read: {error}")))?;
        Ok(text)
    }

    /// Writes all files below an empty folder.
    pub(super) fn unpack(&mut self, folder: &Path) -> Result<(), ArchiveError> {
        for index in 0..self.zip.len() {
            let mut entry = self.zip.by_index(index)?;
            let path = folder.join(entry.name()?.as_ref());
            if let Some(parent) = path.parent() {
                fs::create_dir_all(parent)?;
            }
            let size = entry.size();
            let mut file = File::create_new(&path)?;
            io::copy(&mut entry.by_ref().take(size), &mut file)?;
        }
        Ok(())
    }
}

/// Whether a name is that of a file below a folder, on every system.
pub(super) fn is_safe(name: &str) -> bool {
    let is_safe_part = |part: &str| {
        !part.is_empty()
            && part.trim_end_matches(['.', ' ']).len() == part.len()
            && !is_device(part)
            && !part.chars().any(|letter| letter.is_control() || r#"\:*?"<>|"#.contains(letter))
    };
    name.len() <= LONGEST_NAME && name.split('/').all(is_safe_part)
}

/// Whether Windows takes a name, with any ending, for a device.
fn is_device(part: &str) -> bool {
    let stem = part.split('.').next().unwrap_or(part).trim_end().to_uppercase();
    let numbered = || {
        ["COM", "LPT"].iter().any(|port| {
            let mut number = stem.strip_prefix(port).unwrap_or_default().chars();
            number.next().is_some_and(|digit| "0123456789¹²³".contains(digit))
                && number.next().is_none()
        })
    };
    ["CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"].contains(&stem.as_str()) || numbered()
}
